"""Compute a block of scenes.

Scenes share a discretisation if they can. If one scene fails, the others are still computed.
"""

from collections.abc import Sequence
from threading import Lock

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes import Array, SceneError
from ..crosscheck import (
    Method,
    Problem,
    Solution,
    Stages,
    common,
    disagreement,
    error_name,
    groups,
    in_units,
    method,
    solved_to_accuracy,
)
from .axes import Sweep
from .results import DONE, FAILED, PENDING, unsolved

# Dask may run several blocks in threads of one process, in which gmsh has only one global state
COMPUTING_LOCK = Lock()
# greatest number of scenes that are solved together: all their solutions are in memory at once
MOST_TOGETHER = 64


def compute_block(sweep: Sweep, blank: xarray.Dataset) -> dict[str, Array]:
    """Compute all scenes of a block.

    Parameters
    ----------
    sweep : sweep that consists of the scenes of the block
    blank : empty results of one scene (`results.one_scene`)

    Returns
    -------
    Values of each variable, in the shape that they have in the store.
    """
    values = unsolved(blank, sweep.count)
    values["status"][:] = DONE
    problems = dict[int, Problem]()
    for number, changes in enumerate(sweep.changes()):
        try:
            problems[number] = sweep.problem(changes)
        except SceneError as error:
            values["reason"][number], values["status"][number] = str(error), FAILED
    numbers, solvers = list(problems), blank["solver"].values.tolist()
    with COMPUTING_LOCK, threadpool_limits(1):
        for group in groups(list(problems.values())):
            for start in range(0, len(group), MOST_TOGETHER):
                indices = group[start : start + MOST_TOGETHER]
                subgroup = {numbers[index]: problems[numbers[index]] for index in indices}
                _compute_together(subgroup, solvers, sweep.keep, values)
    shape = sweep.sizes.values()
    return {name: array.reshape(*shape, *array.shape[1:]) for name, array in values.items()}


def _compute_together(
    problems: dict[int, Problem],
    solvers: Sequence[str],
    keep: tuple[str, ...],
    values: dict[str, Array],
) -> None:
    """Solve problems on one discretisation; write results in the scenes' units into `values`."""
    solutions: dict[int, list[Solution]] = {number: [] for number in problems}
    for solver_index, name in enumerate(solvers):
        results = solve(method(name), list(problems.values()))
        for (number, problem), solution in zip(problems.items(), results, strict=True):
            if isinstance(solution, Exception):
                # a refusal names the method and the remedy
                reason = f"{name}: {type(solution).__name__}: {solution}"
                if isinstance(solution, SceneError):
                    reason = str(solution)
                # the scene can be computed with more memory
                status = PENDING if isinstance(solution, MemoryError) else FAILED
                values["reason"][number], values["status"][number] = reason, status
                continue
            solutions[number].append(solution)
            errors = {error_name(name): error for name, error in solution.errors.items()}
            quantities = in_units(problem, solution.results) | errors
            for key in quantities.keys() & values.keys():
                target, result = values[key][number, solver_index, ...], np.asarray(quantities[key])
                # a scene may have more modes or fewer rings than the arrays of the store
                common_part = common(target.shape, result.shape)
                target[common_part] = result[common_part]
    if "disagreement" in values:
        for number, problem in problems.items():
            values["disagreement"][number] = disagreement(problem, solutions[number], keep)


def solve(solver: Method, problems: Sequence[Problem]) -> list[Solution | Exception]:
    """Solve problems together; return the solution of each problem, or the error that it caused.

    If solving them together fails, each problem is solved alone.
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
