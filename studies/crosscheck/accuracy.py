"""Solve to the accuracy asked for.

Where a method's own estimates fall short of it, again with finer sizes.
"""

from collections.abc import Sequence
from dataclasses import replace

from ...meshes.errors import RingwearError
from ..methods.base import Method, Solution
from ..problem.problem import Problem
from ..progress import LOG, Stages
from ..sizes.defaults import tolerance_range
from .promise import BY_CELLS, allowed_error, unresolved

# a refinement that leaves more than this part of an error is not followed by another
LITTLE_GAIN = 0.5


def solved_to_accuracy(
    method: Method, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve problems on the same ring edges, and each again whose estimates fall short."""
    solutions = method.solve_alike(problems, stages)
    return [
        refined(method, problem, solution, stages)
        for problem, solution in zip(problems, solutions, strict=True)
    ]


def refined(method: Method, problem: Problem, solution: Solution, stages: Stages) -> Solution:
    """Return a solution, or one of finer sizes if its estimates fall short.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step, layers
    thinner than coordinates can tell) is left to the verdict. A refinement asks for sizes of at
    most ten times the accuracy, and is followed by another if it was worth its time.
    """
    error = error_of_sizes(problem, solution)
    # where edges move, half of the uncertainty that two methods may have
    allowed = allowed_error(problem)
    least, most = tolerance_range(problem, solution.march.space.size if solution.march else 0)
    rtol = min(problem.rtol, most)
    if method.sizes_given(problem):
        return solution
    for _ in range(4):
        if rtol <= least or error <= allowed:
            break
        rtol = finer_rtol(rtol, error, allowed, least)
        numbers = method.name, error, allowed
        LOG.info("%8s  its estimate %.1e is above %.1e: refining ...", *numbers)
        try:
            finer = method.solve_again(replace(problem, rtol=rtol), solution, allowed, stages)
        except RingwearError as failure:
            # what is there is as good as it says
            LOG.info("%8s  cannot be refined: %s", method.name, failure)
            break
        before, after = error, error_of_sizes(problem, finer)
        if after < before:
            note = (
                f"{method.name}: refined from rtol {problem.rtol:.1e} to {rtol:.1e}, for its "
                "estimates fell short"
            )
            solution, error = replace(finer, notes=(*finer.notes, note)), after
        if after > LITTLE_GAIN * before:
            break
    return solution


def finer_rtol(rtol: float, error: float, allowed: float, least: float) -> float:
    """Return the accuracy that the next refinement asks for, if an error is above the allowed one.

    Parameters
    ----------
    rtol : that sizes followed
    error, allowed : the greatest estimate, and what it may be
    least : the least accuracy that sizes follow
    """
    # sizes and degrees are whole numbers of layers: less than that may hardly change them
    return max(least, rtol * max(0.25 * allowed / error, 0.1))


def error_of_sizes(problem: Problem, solution: Solution) -> float:
    """Return the greatest error estimate of all quantities that finer sizes would mend."""
    # closed forms and the uniform grid have no sizes that follow the accuracy asked for
    discretisation = solution.parts.get("discretisation", solution.parts.get("force"))
    if problem.full_contact and (problem.march != "modal" or discretisation is None):
        return discretisation or 0.0
    solutions = {"": solution}
    names = [
        name
        for name in solution.errors
        if name not in solution.limited_by_degree
        and (name in BY_CELLS or not unresolved(problem, name, solutions))
    ]
    return max(map(solution.greatest_error, names), default=0.0)
