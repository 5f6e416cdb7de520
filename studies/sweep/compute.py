"""Compute a block of scenes.

Scenes that can share a discretisation do, and one that fails fails alone.
"""

from collections.abc import Sequence
from threading import Lock

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import disagreement
from ..methods.base import Method, Solution, method
from ..outcome.answer import answer
from ..outcome.table import in_units
from ..problem.problem import Problem
from ..problem.quantities import error_name
from ..progress import Stages
from ..sampling.norms import common
from ..sizes.shared import groups
from ..versions import stamp
from .axes import ANSWERS, Sweep
from .store import DONE, FAILED, PENDING

# gmsh has one state for a whole process, whose threads a cluster may give several blocks
ONE_AT_A_TIME = Lock()
# scenes that are solved together at most: their solutions take memory
MOST_TOGETHER = 64


def compute_block(sweep: Sweep, blank: xarray.Dataset) -> dict[str, Array]:
    """Compute all scenes of a block.

    Parameters
    ----------
    sweep : the block, as a sweep of its own
    blank : the template of a scene

    Returns
    -------
    values of each variable, in the shape that they have in the store; `code` is of what this
    process has computed them with
    """
    values = {
        str(name): np.stack([variable.values] * sweep.count)
        for name, variable in blank.data_vars.items()
    }
    values["status"][:] = DONE
    problems = dict[int, Problem]()
    for number, changes in enumerate(sweep.changes()):
        try:
            problems[number] = sweep.problem(changes)
        except SceneError as error:
            values["reason"][number], values["status"][number] = str(error), FAILED
    numbers, solvers = list(problems), blank["solver"].values.tolist()
    with ONE_AT_A_TIME, threadpool_limits(1):
        for group in groups(list(problems.values())):
            for start in range(0, len(group), MOST_TOGETHER):
                part = group[start : start + MOST_TOGETHER]
                together = {numbers[at]: problems[numbers[at]] for at in part}
                _compute_together(together, solvers, sweep.keep, values)
    # of all that the computing has loaded
    values["code"][:] = stamp()
    shape = sweep.sizes.values()
    return {name: array.reshape(*shape, *array.shape[1:]) for name, array in values.items()}


def _compute_together(
    problems: dict[int, Problem],
    solvers: Sequence[str],
    keep: tuple[str, ...],
    values: dict[str, Array],
) -> None:
    """Put results of problems that share a discretisation in their places, in the scenes' units."""
    solutions: dict[int, list[Solution]] = {number: [] for number in problems}
    for place, name in enumerate(solvers):
        results = solve(method(name), list(problems.values()))
        for (number, problem), solution in zip(problems.items(), results, strict=True):
            if isinstance(solution, Exception):
                reason = f"{name}: {type(solution).__name__}: {solution}"
                # more memory mends it
                status = PENDING if isinstance(solution, MemoryError) else FAILED
                values["reason"][number], values["status"][number] = reason, status
                continue
            solutions[number].append(solution)
            given = solution.results
            if ANSWERS.keys() & set(keep):
                given = given | answer(problem, solution)
            errors = {error_name(name): error for name, error in solution.errors.items()}
            given = in_units(problem, given) | errors
            for quantity in given.keys() & values.keys():
                target, result = values[quantity][number, place, ...], np.asarray(given[quantity])
                # more modes may be there, and fewer rings
                both = common(target.shape, result.shape)
                target[both] = result[both]
    if "disagreement" in values:
        for number, problem in problems.items():
            values["disagreement"][number] = disagreement(problem, solutions[number], keep)


def solve(solver: Method, problems: Sequence[Problem]) -> list[Solution | Exception]:
    """Return each problem's solution, or why it has none.

    What fails together is tried again one by one.
    """
    try:
        for problem in problems:
            if refusal := solver.refusal(problem):
                raise SceneError(refusal)
        return list(solved_to_accuracy(solver, problems, Stages(solver.name)))
    except Exception as error:
        if len(problems) == 1:
            return [error]
        return [solution for problem in problems for solution in solve(solver, [problem])]
