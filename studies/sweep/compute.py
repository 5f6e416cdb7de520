"""Compute one block of scenes.

Those that can share a discretisation share it, and one that fails fails alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from threading import Lock

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError, SceneError
from ...meshes.radial import Array
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import worst
from ..crosscheck.answer import answer
from ..methods.base import Method, Solution, method
from ..methods.quantities import ANSWER, HISTORIES, QUANTITIES, common, error_name
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.shared import groups
from ..progress import LOG, Stages
from ..versions import fingerprint
from .axes import Sweep
from .kept import ANSWERS, asked_for
from .layout import DONE, FAILED, PENDING, Layout, Outcome

# of the code that this process has loaded: files may change later
FINGERPRINT = fingerprint()
# what the machine lacks today, it may have tomorrow
OF_THE_MACHINE = (MemoryError, OSError)
# gmsh has one state for a whole process, whose threads a cluster may give several blocks
ONE_AT_A_TIME = Lock()


@dataclass(frozen=True)
class Failure:
    """Why a scene has no solution, and whether to try again is in vain."""

    reason: str
    final: bool


def computed(sweep: Sweep, layout: Layout) -> Outcome:
    """Every scene of a block, which is a sweep of its own."""
    with ONE_AT_A_TIME, threadpool_limits(1):
        return _computed(sweep, layout)


def _computed(sweep: Sweep, layout: Layout) -> Outcome:
    count = sweep.count
    values = {name: np.full((count, *one.shape), np.nan) for name, one in layout.variables.items()}
    reason, status = [""] * count, np.full(count, DONE, dtype=np.uint8)
    scenes: dict[int, tuple[Scene, Problem]] = {}
    for number, index in enumerate(product(*map(range, sweep.shape))):
        try:
            scene = sweep.scene(index)
            scenes[number] = scene, posed(scene, sweep.keep)
        except SceneError as error:
            reason[number], status[number] = str(error), FAILED
    solutions: dict[int, dict[str, Solution]] = {number: {} for number in scenes}
    for name in layout.solvers:
        numbers = [
            number for number in scenes if name in scenes[number][0].methods and not reason[number]
        ]
        for group in groups([scenes[number][1] for number in numbers]):
            together = [numbers[at] for at in group]
            found = solved(method(name), [scenes[number][1] for number in together])
            for number, solution in zip(together, found, strict=True):
                if isinstance(solution, Failure):
                    reason[number] = f"{name}: {solution.reason}"
                    status[number] = FAILED if solution.final else PENDING
                else:
                    solutions[number][name] = solution
    for number, (_, problem) in scenes.items():
        if reason[number]:
            continue
        for name, solution in solutions[number].items():
            put(values, (number, layout.solvers.index(name)), problem, solution, sweep.keep)
        if len(layout.solvers) > 1:
            for name, value in (
                worst(problem, list(solutions[number].values()), sweep.keep)._asdict().items()
            ):
                values[name][number] = value
    return Outcome(values, status, reason, FINGERPRINT)


def posed(scene: Scene, keep: tuple[str, ...]) -> Problem:
    """The problem of a scene, asking for what is kept and nothing else."""
    problem = scene.problem
    needed = {quantity for name in keep for quantity in ANSWERS.get(name, (name,))}
    kept = frozenset(
        name for name in needed if name == "relaxation_time" or asked_for(scene.wear, name)
    )
    times = problem.times if kept & HISTORIES else np.empty(0)
    return replace(
        problem, quantities=kept, times=times, march=problem.march if len(times) else "modal"
    )


def solved(one: Method, problems: Sequence[Problem]) -> list[Solution | Failure]:
    """Each problem's solution, or the reason why it has none.

    What fails together is tried again by halves.
    """
    try:
        for problem in problems:
            if refusal := one.refusal(problem):
                raise SceneError(refusal)
        return list(solved_to_accuracy(one, problems, Stages(one.name)))
    except Exception as error:
        if len(problems) > 1:
            if not isinstance(error, RingwearError):
                kind = type(error).__name__
                LOG.warning(
                    "%8s  %d scenes together: %s: %s; again by halves",
                    one.name,
                    len(problems),
                    kind,
                    error,
                )
            half = len(problems) // 2
            return [*solved(one, problems[:half]), *solved(one, problems[half:])]
        if isinstance(error, RingwearError):
            return [Failure(str(error), final=True)]
        final = not isinstance(error, OF_THE_MACHINE)
        return [Failure(f"{type(error).__name__}: {error}", final)]


def put(
    values: dict[str, Array],
    place: tuple[int, int],
    problem: Problem,
    solution: Solution,
    keep: tuple[str, ...],
) -> None:
    """Put what is kept of one scene by one method in its place, in the scene's units."""
    answers = answer(problem, solution) if ANSWERS.keys() & set(keep) else {}
    found: dict[str, Array] = {}
    for name in keep:
        if name in answers:
            found[name] = answers[name] * getattr(problem.units, ANSWER[name].unit)
        elif name in solution.results:
            scale = getattr(problem.units, QUANTITIES[name].unit)
            found[name] = np.asarray(solution.results.variables[name].values) * scale
            found[error_name(name)] = np.asarray(solution.errors[name])
    for label, array in found.items():
        target = values[label][place[0]]
        known = common(array.shape, target.shape[1:])
        target[(place[1], *known)] = array[known]
