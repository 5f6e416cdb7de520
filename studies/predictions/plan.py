"""What a run will take, before it runs.

Sizes are counted on the meshes that it will have. Seconds are those of one probe, the scene itself
at a coarse accuracy, and go with the sizes: a sparse factor as unknowns^1.5, dense algebra as
pressures^2, and as pressures^3 once matrices are large, a march as its steps times pressures^2.
"""

from ..methods.base import Method, SystemSize
from ..outcome.run import run
from ..outcome.scope import methods_of, refusals
from ..problem.problem import Problem
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..problem.scene import Scene, Source
from ..sizes.marching import steps_between
from .memory import predict_memory


def _work_of_modes(problem: Problem, order: float) -> float:
    # of a steady state, or of relaxation times alone, no modes are needed
    return (0.5 if len(problem.times) else 0.1) * order**2 * (1 + order / 3)


def _work_of_steps(problem: Problem, order: float) -> float:
    # the steps that suit rtol go as the third root of its inverse
    return float(0.15 * order**2 * problem.rtol ** (-1 / 3))


# work of dense algebra, by a problem and thousands of its pressures
DENSE_WORK = {FULL_CONTACT: _work_of_modes, MOVING_CONTACT: _work_of_steps}


def predict_work(method: Method, problem: Problem, size: SystemSize) -> float:
    """Return about how much work a method has; what counts is the ratio of two problems.

    The factors between its parts were measured on the bundled scenes.
    """
    order, step = size.pressures / 1e3, method.step(problem)
    steps = float(steps_between(problem.times, step).sum()) if step else 0.0
    dense = DENSE_WORK[problem.contact](problem, order)
    return 0.02 + dense + 0.1 * (size.unknowns / 1e4) ** 1.5 + 6e-4 * steps * order**2


def coarsen(scene: Scene) -> Scene:
    """Return the probe of a scene: the same scene at a coarse accuracy.

    If a flat punch has many rings, the probe has the inner ones only. If a time step is given, the
    probe makes the first hundred steps.
    """
    problem, step, times = scene.problem, scene.wear.step, scene.wear.times
    fem = problem.fem.model_dump(include={"far_field"}, exclude_unset=True)
    accuracy = {
        "rtol": max(problem.rtol, 1e-2),
        "fem": fem | {"mesher": problem.fem.meshed_by},
        "mdr": {"grid": min(problem.mdr.grid, 100)},
    }
    if step is not None and times:
        times = [0.0, min(times[-1], 100 * step)]
    changes: dict[str, object] = {"accuracy": accuracy, "wear__times": times, "output__radii": None}
    most = problem.contact.rings_of_probe
    if most is not None and len(problem.wear_coefficients) > most:
        edges = (problem.ring_edges[1 : most + 1] * problem.units.length).tolist()
        coefficients = problem.wear_coefficients[:most] * problem.units.wear_coefficient
        changes["punch"] = {
            "radius": edges[-1],
            "ring_edges": edges,
            "wear_coefficients": coefficients.tolist(),
        }
    return scene.changed(**changes)


def plan(source: Source) -> list[str]:
    """Say how large each method's system will be, and what it will take by one coarse probe.

    Parameters
    ----------
    source : Scene, str, Path or dict
        What would be computed.

    Returns
    -------
    list of str
        Lines of text: sizes, seconds on one thread, GiB, refusals and notes.
    """
    scene = Scene.of(source)
    if refused := refusals(scene, methods_of(scene.methods)):
        return [f"refused: {reason}" for reason in refused]
    probe, lines, total = coarsen(scene), list[str](), 0.0
    run(probe)  # loads libraries, and is not timed
    result = run(probe)
    for name, stages in result.stages.items():
        entry = result.methods[name]
        size = entry.system_size(scene.problem)
        work = predict_work(entry, scene.problem, size)
        probed = predict_work(entry, probe.problem, entry.system_size(probe.problem))
        seconds = sum(stages.seconds.values()) * work / probed
        total += seconds
        lines.append(
            f"{name}: {size.unknowns} unknowns, {size.pressures} pressures, about {seconds:.2g} s"
        )
    return [
        *lines,
        f"in all: about {total:.2g} s, and a few for loading, files and figures",
        f"memory: about {predict_memory(scene):.2g} GiB",
        *(f"note: {note}" for note in result.notes if note.startswith("meshed by")),
    ]
