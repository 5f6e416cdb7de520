"""What a run will take, before it runs.

Sizes are counted on the meshes that it will have. Seconds are those of one probe, the scene itself
at a coarse accuracy, and go with the sizes: a sparse factor as unknowns^1.5, dense algebra as
pressures^2, and as pressures^3 once matrices are large, a march as its steps times pressures^2.
"""

from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np

from ...meshes.errors import SceneError
from ..methods.spaces import contact_cells, pressure_spaces
from ..problem import defaults
from ..problem.marching import steps_between
from ..problem.problem import Problem
from ..problem.scene import Scene, Source
from .dataset import Result
from .run import run
from .scope import methods_of, refusals
from .sizes import predict_memory


@lru_cache(maxsize=16)  # work is predicted by them, too, and meshes take as long as the rest
def count_unknowns(name: str, problem: Problem) -> tuple[int, int]:
    """Return the unknowns of the system behind a method's compliance, and its pressures."""
    without_space = {"direct": 0, "mdr-grid": problem.mdr.grid + 1}
    if name in without_space:
        return without_space[name], without_space[name]
    if name != "fem":
        space = pressure_spaces(problem)[0]
        return space.size, space.size
    from ...fem.contact_meshes import even_half_space
    from ..methods.fem import half_space_mesh, half_space_on

    if problem.full_contact:
        half_space = half_space_on(problem, half_space_mesh(problem))
    else:
        half_space = even_half_space(contact_cells(problem)[0], problem.poisson_ratio)
    return half_space.unknowns, half_space.space.size


def predict_work(name: str, problem: Problem) -> float:
    """Return about how much work a method has; what counts is the ratio of two problems.

    The factors between its parts were measured on the bundled scenes.
    """
    unknowns, pressures = count_unknowns(name, problem)
    order, step = pressures / 1e3, problem.step
    if name == "mdr-grid":
        step = defaults.grid_step(problem, 4 / np.pi / problem.mdr.grid)
    steps = float(steps_between(problem.times, step).sum()) if step else 0.0
    marching = 6e-4 * steps * order**2
    if not problem.full_contact and len(problem.times):
        # the steps that suit rtol go as the third root of its inverse; the rest is the first press
        return 0.15 * (1 + order**2 * problem.rtol ** (-1 / 3)) + marching
    # of a steady state, or of relaxation times alone, no modes are needed
    dense = (0.5 if len(problem.times) else 0.1) * order**2 * (1 + order / 3)
    sampling = 3e-7 * order * len(problem.times) * len(problem.radii)
    factor = 0.1 * (unknowns / 1e4) ** 1.5
    return 0.02 + dense + sampling + factor + marching


def coarsen(scene: Scene) -> Scene:
    """Return the probe of a scene: a coarse accuracy, few rings, times and steps."""
    problem, step, rings = scene.problem, scene.wear.step, scene.problem.rings
    fem = problem.fem.model_dump(include={"far_field"}, exclude_unset=True)
    accuracy = {
        "rtol": max(problem.rtol, 1e-2),
        "fem": fem | {"mesher": problem.fem.meshed_by},
        "mdr": {"grid": min(problem.mdr.grid, 100)},
    }
    times = list(scene.wear.times)[:: len(scene.wear.times) // 20 + 1]
    if step is not None and times:
        times = [0.0, min(times[-1], 100 * step)]
    changes: dict[str, Any] = {"accuracy": accuracy, "wear__times": times, "output__radii": None}
    if problem.full_contact and len(rings.wear_coefficients) > 16:
        edges = (rings.ring_edges[1:17] * problem.units.length).tolist()
        coefficients = rings.wear_coefficients[:16] * problem.units.wear_coefficient
        changes["punch"] = {
            "radius": edges[-1],
            "ring_edges": edges,
            "wear_coefficients": coefficients.tolist(),
        }
    return scene.changed(**changes)


def predict_seconds(scene: Scene) -> tuple[Result, dict[str, float]]:
    """Return the probe of a scene, and the seconds that each method will take by it."""
    probe = coarsen(scene)
    result = run(probe)
    seconds = {
        name: sum(stages.seconds.values())
        * predict_work(name, scene.problem)
        / predict_work(name, probe.problem)
        for name, stages in result.stages.items()
    }
    return result, seconds


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
    run(coarsen(scene))  # loads libraries, and is not timed
    result, seconds = predict_seconds(scene)
    lines = []
    for name in result.solutions:
        unknowns, pressures = count_unknowns(name, scene.problem)
        lines.append(
            f"{name}: {unknowns} unknowns, {pressures} pressures, about {seconds[name]:.2g} s"
        )
    by_part = []
    for part in ("indentation", "relaxation_time", "history", "fields", "steady"):
        with suppress(SceneError):
            alone = scene.changed(output__quantities=[part])
            by_part.append(f"{part} {sum(predict_seconds(alone)[1].values()):.2g} s")
    total = sum(seconds.values())
    memory = predict_memory(scene)
    parts = ", ".join(f"{value:.2g} for {key}" for key, value in memory.items())
    notes = [f"note: {note}" for note in result.notes if note.startswith("meshed by")]
    return [
        *lines,
        f"in all: about {total:.2g} s, and a few for loading, files and figures",
        f"by output.quantities, each alone: {', '.join(by_part)}",
        f"memory: about {sum(memory.values()):.2g} GiB: {parts}",
        *notes,
    ]
