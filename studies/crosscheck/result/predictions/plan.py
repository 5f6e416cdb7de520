"""Prediction of the seconds that a run will need.

System sizes are counted on the meshes of the run itself. A method whose error estimates are too
large is solved again with finer sizes, which doubles the seconds or more. A coarse probe cannot
predict whether that happens, because estimates are often about as large as the allowed error. A
method that takes a few seconds is therefore solved once, and its own error estimate decides.

For other methods, a probe gives a lower bound: the scene itself at a coarse tolerance and at some
of its times. Seconds are scaled from the probe by system sizes: a sparse factor as unknowns^1.5,
dense algebra as pressures^2, and as pressures^3 once matrices are large, a march as its steps times
pressures^2, modes as times times pressures^2. A march through many changes of the load has no
probe, which would take the same steps: its seconds are predicted from their number.
"""

import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from ...methods.base import Method, Solution, SystemSize
from ...problem.problem import Problem
from ...progress import Stages
from ...scene.calls import naming_arguments
from ...scene.scene import Scene, Source
from ...verdict.accuracy import error_of_sizes, next_rtol
from ...verdict.promise import allowed_error
from ...wear.step_control import steps_between
from ..scope import chosen_methods, refusals
from .memory import predict_memory, why_beyond_memory

# Predicted work up to which a method is solved at once, and predicted seconds up to which it is
# solved after a probe.
MAX_WORK_WITHOUT_PROBE, MAX_SECONDS_TO_SOLVE = 1.0, 5.0
# Greatest number of times of a probe, and greatest number of steps that a march must make at least
# for it to have a probe.
MOST_PROBE_TIMES, MOST_PROBE_STEPS, MOST_PROBE_RINGS = 50, 200, 16
# Error estimate of a probe over the allowed error, below which a solution in full contact is
# expected to need no refinement: over 20 scenes that ratio was at most five times as large at the
# requested tolerance as in the probe.
SAFE_ERROR_RATIO = 0.2


class Cost(NamedTuple):
    """Predicted cost of a method, in seconds of one processor.

    Parameters
    ----------
    size : size of the system that the method solves
    first : seconds for the first solution
    refining : seconds for solving again with finer sizes; 0 if that is not expected
    rtol : tolerance from which the finer sizes are chosen
    refinement_known : whether it is known if there will be a refinement
    notes : notes of the method, such as that the mesher had to be replaced
    """

    size: SystemSize
    first: float
    refining: float = 0.0
    rtol: float = 0.0
    refinement_known: bool = True
    notes: tuple[str, ...] = ()

    @property
    def total(self) -> float:
        """Seconds in all, as far as they can be predicted."""
        return self.first + self.refining

    def __str__(self) -> str:
        """Return the seconds as text."""
        if not self.refinement_known:
            return f"{self.first:.2g} s or more: only the run shows whether a refinement is needed"
        if not self.refining:
            return f"about {self.first:.2g} s"
        return (
            f"about {self.total:.2g} s, {self.refining:.2g} s of it to refine to rtol "
            f"{self.rtol:.0e}"
        )


def _work_of_modes(problem: Problem, order: float) -> float:
    # a steady state or relaxation times alone need no modes
    modes = (0.5 if len(problem.times) else 0.1) * order**2 * (1 + order / 3)
    # fields at the requested times, and amplitudes at the knots of the load
    sampling = 1.2e-3 * len(problem.times) + 4e-4 * len(problem.loading.times)
    return modes + sampling * order**2


def _work_of_steps(problem: Problem, order: float) -> float:
    # the number of adaptive steps grows as rtol^(-1/3), by a few for each end of a step that the
    # scene requires
    steps = 0.15 * problem.rtol ** (-1 / 3) + 0.1 * problem.least_steps
    return float(steps * order**2)


def predict_work(method: Method, problem: Problem, size: SystemSize) -> float:
    """Return about how much work a method has for a problem.

    The unit is about a second, to a factor of five. The ratio of the works of two problems is more
    accurate. The constants were measured on the bundled scenes.
    """
    order, step = size.pressures / 1e3, method.step(problem)
    steps = float(steps_between(problem.times, step).sum()) if step else 0.0
    dense = (_work_of_modes if problem.full_contact else _work_of_steps)(problem, order)
    return 0.02 + dense + 0.1 * (size.unknowns / 1e4) ** 1.5 + 6e-4 * steps * order**2


def coarsen(scene: Scene) -> Scene:
    """Return the probe of a scene: the same scene at a coarse tolerance.

    If a flat punch has many rings, the probe has only the inner ones. If there are many times, it
    has some of them. If a time step is given, it makes the first hundred steps.
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
    if len(times) > MOST_PROBE_TIMES:
        rows = np.linspace(0, len(times) - 1, MOST_PROBE_TIMES).round().astype(int)
        times = [times[row] for row in rows]
    changes: dict[str, object] = {"accuracy": accuracy, "wear__times": times, "output__radii": None}
    if problem.full_contact and len(problem.wear_coefficients) > MOST_PROBE_RINGS:
        edges = (problem.ring_edges[1 : MOST_PROBE_RINGS + 1] * problem.units.length).tolist()
        coefficients = problem.wear_coefficients[:MOST_PROBE_RINGS] * problem.units.wear_coefficient
        changes["punch"] = {
            "radius": edges[-1],
            "ring_edges": edges,
            "wear_coefficients": coefficients.tolist(),
        }
    return scene.changed(**changes)


def predict_cost(method: Method, problem: Problem, probe: Problem) -> Cost:
    """Return the predicted cost of a method for a problem.

    If the problem is quick to solve, it is solved once. Otherwise the cost is scaled from that of
    the probe, which is the same problem at a coarse tolerance. A march through many load changes is
    not probed.
    """
    marches = not problem.full_contact and "history" not in method.lacks
    if marches and problem.least_steps > MOST_PROBE_STEPS:
        size = method.system_size(problem)
        work = predict_work(method, problem, size)
        return Cost(size, work, refinement_known=method.sizes_given(problem))
    _solve(method, _small_problem(problem))  # libraries are loaded, and not timed
    start = time.process_time()
    size = method.system_size(problem)
    work = predict_work(method, problem, size)
    # `system_size` locates the first contact, which is cached
    locating = time.process_time() - start
    if work > MAX_WORK_WITHOUT_PROBE:
        seconds, solution = _solve(method, probe)
        seconds *= work / predict_work(method, probe, method.system_size(probe))
        if seconds > MAX_SECONDS_TO_SOLVE:
            ratio = error_of_sizes(probe, solution) / allowed_error(probe)
            known = method.sizes_given(problem) or (
                problem.full_contact and ratio < SAFE_ERROR_RATIO
            )
            return Cost(size, seconds, refinement_known=known, notes=solution.notes)
    first, solution = _solve(method, problem)
    cost = _with_refinement(method, problem, solution, size, first)
    return cost._replace(first=locating + first)


def _small_problem(problem: Problem) -> Problem:
    """Return a problem that loads the same libraries as another, but needs little time."""
    fem = {"mesher": problem.fem.chosen_mesher}
    return Scene.load("flat_punch").changed({"accuracy": {"rtol": 0.1, "fem": fem}}).problem


def _solve(method: Method, problem: Problem) -> tuple[float, Solution]:
    """Return the processor seconds that a method needs to solve a problem, and the solution."""
    start = time.process_time()
    solution = method.solve(problem, Stages(method.name))
    return time.process_time() - start, solution


def _with_refinement(
    method: Method, problem: Problem, solution: Solution, size: SystemSize, first: float
) -> Cost:
    """Return the predicted cost of a method that has solved a problem once in `first` seconds."""
    rtol = next_rtol(method, problem, solution, problem.rtol)
    if rtol is None:
        return Cost(size, first, notes=solution.notes)
    finer = replace(problem, rtol=rtol)
    work, finer_work = (
        predict_work(method, each, each_size)
        for each, each_size in ((problem, size), (finer, method.system_size(finer)))
    )
    return Cost(size, first, first * finer_work / work, finer.rtol, notes=solution.notes)


@naming_arguments
def plan_run(source: Source, memory: float | None = None) -> list[str]:
    """Predict the unknowns, the seconds and the memory of a run, by each method.

    Methods that take a few seconds are solved once, others at a coarse tolerance.

    Parameters
    ----------
    source : Scene, str, Path or dict
        The scene that would be computed.
    memory : float, optional
        Largest memory that a run may use, in GiB; by default that of the machine.

    Returns
    -------
    list of str
        Lines of text: sizes, seconds of one processor, GiB, refusals and notes.
    """
    scene = Scene.of(source)
    methods = chosen_methods(scene)
    reasons = refusals(scene, methods) or [why_beyond_memory(scene, methods.values(), memory)]
    if any(reasons):
        return [f"refused: {reason}" for reason in reasons]
    problem, probe = scene.problem, coarsen(scene).problem
    with threadpool_limits(1):
        costs = {name: predict_cost(entry, problem, probe) for name, entry in methods.items()}
    total = sum(cost.total for cost in costs.values())
    notes = dict.fromkeys(note for cost in costs.values() for note in cost.notes)
    total_text = f"about {total:.2g} s"
    if not all(cost.refinement_known for cost in costs.values()):
        total_text = f"{total:.2g} s or more"
    return [
        *(
            f"{name}: {cost.size.unknowns} unknowns, {cost.size.pressures} pressures, {cost}"
            for name, cost in costs.items()
        ),
        f"in all: {total_text}, plus a few seconds for loading, files and figures",
        f"memory: about {predict_memory(scene):.2g} GiB",
        *(f"note: {note}" for note in notes if note.startswith(("meshed by", "factorised by"))),
    ]
