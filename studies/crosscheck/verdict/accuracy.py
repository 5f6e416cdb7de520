"""Solve problems to the tolerance `rtol`.

A problem is solved again with finer sizes if the method's error estimates exceed the tolerance.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from math import ceil, isfinite, log, sqrt

from ....meshes.errors import RingwearError
from ..methods.base import Method, Solution
from ..methods.spaces import pressure_spaces
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED
from ..progress import LOG, Stages
from ..sizes.cells import tolerance_range
from .promise import allowed_error, unresolved

# refinement stops if the last one left more than this part of the error estimate and was not slight
LITTLE_GAIN = 0.5
# The tolerance that sizes follow after a refinement, over that before. Layers and degrees are whole
# numbers, which a larger factor may leave as they are. It depends on little more than whether there
# is a refinement, so that the methods are mostly refined to the same tolerance and share the search
# for the first contact.
FINER = 0.1
# greatest number of such factors in all, and at once if the last refinement shows that several are
# needed
MOST_FACTORS, MOST_AT_ONCE = 4, 3
# The same for cells of contact that moves, if the error is less than `SLIGHT` times the allowed
# one. Errors fall about as the root of the tolerance, but not evenly; the factor is also at most
# `ROOT` times the square of the ratio of the allowed error to the last one.
SLIGHTLY_FINER, SLIGHT, ROOT = 0.6, 1.7, 0.9


def solved_to_accuracy(
    method: Method, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve problems on the same ring edges, and refine the solutions that are not accurate enough.

    Returns
    -------
    list of Solution
        One for each problem.
    """
    solutions = method.solve_alike(problems, stages)
    return [
        replace(refined(method, problem, solution, stages), remedy=method.remedy(problem))
        for problem, solution in zip(problems, solutions, strict=True)
    ]


def refined(method: Method, problem: Problem, solution: Solution, stages: Stages) -> Solution:
    """Return a solution, or a refined one if its error estimates exceed the allowed error.

    Sizes that the user gives are never refined. Errors that finer sizes do not reduce (roundoff, a
    given time step, layers thinner than the roundoff of coordinates) do not lead to a refinement;
    the verdict reports them. Each refinement multiplies the tolerance that sizes follow by `FINER`
    or, if little is missing, by `SLIGHTLY_FINER`; in full contact, by a power of `FINER` that the
    last refinement shows to be needed. Another one follows if the last one was slight, or reduced
    the estimate to `LITTLE_GAIN` or less.
    """
    error, allowed = error_of_sizes(problem, solution), allowed_error(problem)
    last_rtol, gain = problem.rtol, 0.0
    for _ in range(MOST_FACTORS):
        rtol = next_rtol(method, problem, solution, last_rtol, gain)
        if rtol is None:
            break
        numbers = method.name, error, allowed
        LOG.info("%8s  its error estimate %.1e is above %.1e: refining ...", *numbers)
        try:
            finer = method.solve_again(with_rtol(problem, rtol), solution, allowed, stages)
        except RingwearError as failure:
            # keep the coarser solution, whose error estimate is still valid
            LOG.info("%8s  cannot be refined: %s", method.name, failure)
            break
        slightly = _misses_slightly(solution, error, allowed)
        last_error, new_error = error, error_of_sizes(problem, finer)
        if 0 < new_error < last_error:
            # of one factor `FINER`
            gain = (new_error / last_error) ** (log(FINER) / log(rtol / last_rtol))
        last_rtol = rtol
        if new_error < last_error:
            note = (
                f"{method.name}: refined from rtol {problem.rtol:.1e} to {rtol:.1e}, because its "
                "error estimates were too large"
            )
            solution, error = replace(finer, notes=(*finer.notes, note)), new_error
        if new_error > LITTLE_GAIN * last_error and not slightly:
            break
    return solution


def next_rtol(
    method: Method, problem: Problem, solution: Solution, last_rtol: float, gain: float = 0.0
) -> float | None:
    """Return the tolerance that the sizes of the next refinement follow; None if there is none.

    Parameters
    ----------
    method, problem : the method, and the problem with the requested tolerance
    solution : the most accurate solution so far
    last_rtol : tolerance that the sizes of the last refinement followed
    gain : factor by which `FINER` has reduced the error estimate; 0 if that is not known
    """
    # the pressures on the cells, which are the same for every method
    pressures = pressure_spaces(problem)[0].size if solution.evolution else 0
    smallest, largest = tolerance_range(problem, pressures)
    last_rtol = min(last_rtol, largest)
    # reached but for roundoff in the products of the factors
    smallest = max(smallest, FINER**MOST_FACTORS * min(problem.rtol, largest))
    # if edges of the contact move, a method may use half of the uncertainty of two methods
    error, allowed = error_of_sizes(problem, solution), allowed_error(problem)
    if error <= allowed or last_rtol <= 1.01 * smallest or method.sizes_given(problem):
        return None
    by_root = min(SLIGHTLY_FINER, ROOT * (allowed / error) ** 2)
    finer = by_root if _misses_slightly(solution, error, allowed) else FINER
    if solution.evolution is None and gain and isfinite(error):
        finer **= min(ceil(log(allowed / error) / log(gain)), MOST_AT_ONCE)
    return max(smallest, finer * last_rtol)


def _misses_slightly(solution: Solution, error: float, allowed: float) -> bool:
    """Return whether cells under moving edges, with this error, are only slightly too large."""
    return solution.evolution is not None and error < SLIGHT * allowed


@lru_cache(maxsize=16)
def with_rtol(problem: Problem, rtol: float) -> Problem:
    """Return a problem with a finer tolerance; the same object for every method.

    Problems are compared by identity, and what they share is stored for each object. Errors of time
    steps are far below those of cells, so that steps get shorter less than cells.
    """
    return replace(problem, rtol=rtol, step_rtol=sqrt(problem.rtol * rtol))


def error_of_sizes(problem: Problem, solution: Solution) -> float:
    """Return the greatest error estimate of the quantities that finer sizes make more accurate."""
    error = solution.error_by_sizes
    if problem.full_contact and (problem.march != "modal" or error is None):
        return error or 0.0
    solutions = {"": solution}
    names = [
        name
        for name in solution.errors
        if name not in solution.limited_by_degree
        and (DESCRIBED[name].cells == "refined" or not unresolved(problem, name, solutions))
    ]
    return max(map(solution.greatest_error, names), default=0.0)
