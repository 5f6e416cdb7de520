"""What a run will take, before it runs.

Sizes are counted on the meshes that it will have. A method refines where its estimates fall short,
which doubles the seconds or more. No probe foresees that, as estimates are often about as large as
what is allowed. So a method that takes a few seconds is solved once, and its own estimate tells.

Of others, a probe, the scene itself at a coarse accuracy, tells how long they take at least:
seconds go with the sizes, a sparse factor as unknowns^1.5, dense algebra as pressures^2, and as
pressures^3 once matrices are large, a march as its steps times pressures^2.
"""

import time
from dataclasses import replace
from typing import NamedTuple

from threadpoolctl import threadpool_limits

from ..crosscheck.accuracy import error_of_sizes, finer_rtol
from ..crosscheck.promise import allowed_error
from ..methods.base import Method, Solution, SystemSize
from ..outcome.scope import methods_of, refusals
from ..problem.problem import Problem
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..progress import Stages
from ..scene.scene import Scene, Source
from ..sizes.defaults import tolerance_range
from ..sizes.marching import steps_between
from .memory import predict_memory

# work up to which a method is solved at once, and seconds up to which it is after a probe
LITTLE_WORK, MOST_SOLVED = 1.0, 5.0
# an estimate of a probe over what it may be, below which full contact is expected to be accurate
# enough at the accuracy asked for: over 20 scenes the ratio grew at most fivefold
FAR_BELOW = 0.2


class Cost(NamedTuple):
    """What a method will take, in seconds of one processor.

    Parameters
    ----------
    first : until it has solved the problem once
    refining : for solving it again by finer sizes; 0 if it will not
    rtol : that these sizes follow
    known : whether it is known if it will be refined
    notes : that the method has given, such as a mesher replaced
    """

    first: float
    refining: float = 0.0
    rtol: float = 0.0
    known: bool = True
    notes: tuple[str, ...] = ()

    @property
    def total(self) -> float:
        """Seconds in all, as far as they are known."""
        return self.first + self.refining

    def __str__(self) -> str:
        """Return the seconds in words."""
        if not self.known:
            return (
                f"{self.first:.2g} s or more: whether it is to be refined then, it tells as it runs"
            )
        if not self.refining:
            return f"about {self.first:.2g} s"
        return (
            f"about {self.total:.2g} s, {self.refining:.2g} s of it to refine to rtol "
            f"{self.rtol:.0e}"
        )


def _work_of_modes(problem: Problem, order: float) -> float:
    # of a steady state, or of relaxation times alone, no modes are needed
    return (0.5 if len(problem.times) else 0.1) * order**2 * (1 + order / 3)


def _work_of_steps(problem: Problem, order: float) -> float:
    # the steps that suit rtol go as the third root of its inverse
    return float(0.15 * order**2 * problem.rtol ** (-1 / 3))


# work of dense algebra, by a problem and thousands of its pressures
DENSE_WORK = {FULL_CONTACT: _work_of_modes, MOVING_CONTACT: _work_of_steps}


def predict_work(method: Method, problem: Problem, size: SystemSize) -> float:
    """Return about how much work a method has, in seconds on some machine, to a factor of five.

    The ratio for two problems is better known. Its factors were measured on the bundled scenes.
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
        "fem": fem | {"mesher": problem.fem.chosen_mesher},
        "mdr": {"grid": min(problem.mdr.grid, 100)},
    }
    if step is not None and times:
        times = [0.0, min(times[-1], 100 * step)]
    changes: dict[str, object] = {"accuracy": accuracy, "wear__times": times, "output__radii": None}
    most = problem.contact.most_probe_rings
    if most is not None and len(problem.wear_coefficients) > most:
        edges = (problem.ring_edges[1 : most + 1] * problem.units.length).tolist()
        coefficients = problem.wear_coefficients[:most] * problem.units.wear_coefficient
        changes["punch"] = {
            "radius": edges[-1],
            "ring_edges": edges,
            "wear_coefficients": coefficients.tolist(),
        }
    return scene.changed(**changes)


def predict_cost(method: Method, problem: Problem, probe: Problem) -> Cost:
    """Return what a method will take for a problem: by the problem itself if it is quick to solve.

    Else by a probe, which is the same problem at a coarse accuracy.
    """
    _solve(method, _small_problem(problem))  # libraries are loaded, and not timed
    start = time.process_time()
    work = predict_work(method, problem, method.system_size(problem))
    # where contact begins is located for that, and kept
    locating = time.process_time() - start
    if work > LITTLE_WORK:
        seconds, solution = _solve(method, probe)
        seconds *= work / predict_work(method, probe, method.system_size(probe))
        if seconds > MOST_SOLVED:
            ratio = error_of_sizes(probe, solution) / allowed_error(probe)
            known = method.sizes_given(problem) or (problem.full_contact and ratio < FAR_BELOW)
            return Cost(seconds, known=known, notes=solution.notes)
    first, solution = _solve(method, problem)
    cost = _with_refinement(method, problem, solution, first)
    return cost._replace(first=locating + first)


def _small_problem(problem: Problem) -> Problem:
    """Return a problem that needs the libraries of another, and little else."""
    fem = {"mesher": problem.fem.chosen_mesher}
    return Scene.load("flat_punch").changed({"accuracy": {"rtol": 0.1, "fem": fem}}).problem


def _solve(method: Method, problem: Problem) -> tuple[float, Solution]:
    """Return the seconds of a processor that a method takes to solve a problem once, and that."""
    start = time.process_time()
    solution = method.solve(problem, Stages(method.name))
    return time.process_time() - start, solution


def _with_refinement(method: Method, problem: Problem, solution: Solution, first: float) -> Cost:
    """Return what a method takes in all that has solved a problem once."""
    error, allowed = error_of_sizes(problem, solution), allowed_error(problem)
    size = solution.march.space.size if solution.march else 0
    least, most = tolerance_range(problem, size)
    before = min(problem.rtol, most)
    if error <= allowed or before <= least or method.sizes_given(problem):
        return Cost(first, notes=solution.notes)
    finer = replace(problem, rtol=finer_rtol(before, error, allowed, least))
    sizes = method.system_size(finer), method.system_size(problem)
    if problem.full_contact:
        works = [predict_work(method, *of) for of in zip((finer, problem), sizes, strict=True)]
        growth = works[0] / works[1]
    else:
        # more cells and more steps; the start and the steady state are kept
        growth = (sizes[0].pressures / sizes[1].pressures) ** 2
    return Cost(first, first * growth, finer.rtol, notes=solution.notes)


def plan(source: Source) -> list[str]:
    """Say how large each method's system will be, and what it will take.

    Methods that take a few seconds are solved once, others at a coarse accuracy.

    Parameters
    ----------
    source : Scene, str, Path or dict
        What would be computed.

    Returns
    -------
    list of str
        Lines of text: sizes, seconds of one processor, GiB, refusals and notes.
    """
    scene = Scene.of(source)
    methods = methods_of(scene.methods)
    if refused := refusals(scene, methods):
        return [f"refused: {reason}" for reason in refused]
    problem, probe = scene.problem, coarsen(scene).problem
    with threadpool_limits(1):
        costs = {name: predict_cost(entry, problem, probe) for name, entry in methods.items()}
    sizes = {name: entry.system_size(problem) for name, entry in methods.items()}
    total = sum(cost.total for cost in costs.values())
    notes = dict.fromkeys(note for cost in costs.values() for note in cost.notes)
    in_all = f"about {total:.2g} s"
    if not all(cost.known for cost in costs.values()):
        in_all = f"{total:.2g} s or more"
    return [
        *(
            f"{name}: {size.unknowns} unknowns, {size.pressures} pressures, {costs[name]}"
            for name, size in sizes.items()
        ),
        f"in all: {in_all}, and a few for loading, files and figures",
        f"memory: about {predict_memory(scene):.2g} GiB",
        *(f"note: {note}" for note in notes if note.startswith("meshed by")),
    ]
