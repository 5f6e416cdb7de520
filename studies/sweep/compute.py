"""Compute a block of scenes: those that can share a discretisation do, one that fails fails alone.
"""

from collections import defaultdict
from collections.abc import Sequence
from threading import Lock
from typing import NamedTuple

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError, SceneError
from ...meshes.radial import Array
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import worst
from ..crosscheck.answer import answer
from ..methods.base import Method, Solution, method
from ..methods.quantities import ANSWER, QUANTITIES, common, error_name
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.shared import groups
from ..progress import LOG, Stages
from ..versions import fingerprint
from .axes import ANSWERS, Sweep
from .layout import DONE, FAILED, PENDING

# of the code that this process has loaded: files may change later
FINGERPRINT = fingerprint()
# gmsh has one state for a whole process, whose threads a cluster may give several blocks
ONE_AT_A_TIME = Lock()


class Failure(NamedTuple):
    """Why a scene has no solution, and what that makes of it."""

    reason: str
    status: int


class Outcome(NamedTuple):
    """What a block has become.

    Parameters
    ----------
    values : (scenes, ...) of each variable of the store
    computed_by : fingerprint of the ringwear that computed it
    """

    values: dict[str, Array]
    computed_by: str


def compute_block(sweep: Sweep, blank: xarray.Dataset) -> Outcome:
    """Compute all scenes of a block.

    Parameters
    ----------
    sweep : the block, as a sweep of its own
    blank : the template of a scene
    """
    values = {
        str(name): np.stack([variable.values] * sweep.count)
        for name, variable in blank.data_vars.items()
    }
    values["status"][:] = DONE
    scenes: dict[int, tuple[Scene, Problem]] = {}
    for number, index in enumerate(np.ndindex(sweep.shape)):
        try:
            scene = sweep.scene(index)
            scenes[number] = scene, sweep.problem(scene)
        except SceneError as error:
            values["reason"][number], values["status"][number] = str(error), FAILED
    numbers = list(scenes)
    with ONE_AT_A_TIME, threadpool_limits(1):
        for group in groups([problem for _, problem in scenes.values()]):
            # solutions take memory: at most 64 at once
            for start in range(0, len(group), 64):
                together = {numbers[at]: scenes[numbers[at]] for at in group[start : start + 64]}
                _compute_together(together, blank["solver"].values, sweep.keep, values)
    return Outcome(values, FINGERPRINT)


def _compute_together(
    scenes: dict[int, tuple[Scene, Problem]],
    solvers: Sequence[str],
    keep: tuple[str, ...],
    values: dict[str, Array],
) -> None:
    """Put results of scenes that share a discretisation in their places, in the scenes' units."""
    solutions: dict[int, dict[int, Solution]] = defaultdict(dict)
    for place, name in enumerate(solvers):
        numbers = [
            number
            for number, (scene, _) in scenes.items()
            if name in scene.methods and values["status"][number] == DONE
        ]
        results = solve(method(name), [scenes[number][1] for number in numbers])
        for number, solution in zip(numbers, results, strict=True):
            if isinstance(solution, Failure):
                values["reason"][number] = f"{name}: {solution.reason}"
                values["status"][number] = solution.status
            else:
                solutions[number][place] = solution
    for number, by_solver in solutions.items():
        if values["status"][number] != DONE:
            continue
        problem = scenes[number][1]
        for place, solution in by_solver.items():
            for name, result in _quantities(problem, solution, keep).items():
                target = values[name][number]
                region = common(result.shape, target.shape[1:])
                target[(place, *region)] = result[region]
        if "disagreement" in values:
            for name, value in worst(problem, list(by_solver.values()), keep)._asdict().items():
                values[name][number] = value


def solve(solver: Method, problems: Sequence[Problem]) -> list[Solution | Failure]:
    """Return each problem's solution, or the reason why it has none.

    What fails together is tried again by halves. What the machine lacks today it may have
    tomorrow, so that leaves a scene pending.
    """
    if not problems:
        return []
    try:
        for problem in problems:
            if refusal := solver.refusal(problem):
                raise SceneError(refusal)
        return list(solved_to_accuracy(solver, problems, Stages(solver.name)))
    except Exception as error:
        expected = isinstance(error, RingwearError)
        reason = str(error) if expected else f"{type(error).__name__}: {error}"
        if len(problems) > 1:
            if not expected:
                LOG.warning("%8s  %d scenes: %s; by halves", solver.name, len(problems), reason)
            half = len(problems) // 2
            return [*solve(solver, problems[:half]), *solve(solver, problems[half:])]
        return [Failure(reason, PENDING if isinstance(error, MemoryError | OSError) else FAILED)]


def _quantities(problem: Problem, solution: Solution, keep: tuple[str, ...]) -> dict[str, Array]:
    """Return quantities to keep, their errors, and answers, in the scene's units."""
    results: dict[str, Array] = {}
    answers = answer(problem, solution) if ANSWERS.keys() & set(keep) else {}
    for name in keep:
        if name in answers:
            results[name] = answers[name] * getattr(problem.units, ANSWER[name].unit)
        elif name in solution.results:
            scale = getattr(problem.units, QUANTITIES[name].unit)
            results[name] = solution.results.variables[name].values * scale
            results[error_name(name)] = np.asarray(solution.errors[name])
    return results
