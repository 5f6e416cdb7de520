"""Solve to the accuracy asked for.

Where a method's own estimates fall short of it, again with finer sizes.
"""

from collections.abc import Sequence
from dataclasses import replace

from ..methods.base import Method, Solution
from ..methods.quantities import ENERGIES, FINEST
from ..problem.defaults import at_smallest, field_accuracy
from ..problem.problem import Problem
from ..problem.sections import DEGREES
from ..progress import LOG, Stages

MOST_REFINEMENTS = 4
# times finer that a refinement asks for at the most; times better that it has to make the result to
# be followed by another
FINER, WORTH = 10.0, 2.0


def solved_to_accuracy(one: Method, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
    """Solve problems on the same ring edges.

    Those whose own estimates fall short of the accuracy again, with finer sizes.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step, layers
    thinner than coordinates can tell) is left to the verdict.
    """
    solutions, working = one.solve_all(problems, stages), [problem.rtol for problem in problems]
    short = [number for number, problem in enumerate(problems) if not _sizes_given(one, problem)]
    for _ in range(MOST_REFINEMENTS):
        short = [
            number
            for number in short
            if _falls_short(problems[number], solutions[number], working[number])
        ]
        if not short:
            break
        for number in short:
            asked, estimate = (
                problems[number].rtol,
                error_of_sizes(problems[number], solutions[number]),
            )
            working[number] = max(FINEST, working[number] * max(0.5 * asked / estimate, 1 / FINER))
            LOG.info(
                "%8s  its estimate %.1e is above %.1e: refining ...", one.name, estimate, asked
            )
        finer = one.solve_all(
            [replace(problems[number], rtol=working[number]) for number in short], stages
        )
        refined, short = short, []
        for number, solution in zip(refined, finer, strict=True):
            before = error_of_sizes(problems[number], solutions[number])
            after = error_of_sizes(problems[number], solution)
            if after < before:
                asked = problems[number].rtol
                note = (
                    f"{one.name}: refined from rtol {asked:.1e} to {working[number]:.1e}, for its "
                    "estimates fell short"
                )
                solutions[number] = replace(solution, notes=(*solution.notes, note))
            if WORTH * after <= before:
                short.append(number)
    return solutions


def _sizes_given(method: Method, problem: Problem) -> bool:
    """Return whether the user has given its sizes, which then stay as they are."""
    return (problem.fem if method.name == "fem" else problem.mdr).given


def _falls_short(problem: Problem, solution: Solution, working: float) -> bool:
    return working > FINEST and error_of_sizes(problem, solution) > problem.rtol


def error_of_sizes(problem: Problem, solution: Solution) -> float:
    """The greatest error of all quantities that finer sizes would mend."""
    if not problem.full_contact:
        # the cells of a march go by what was asked for
        return 0.0
    # closed forms and the uniform grid have no sizes that go by the accuracy asked for
    if problem.march != "modal" or "discretisation" not in solution.parts:
        return solution.error_of_sizes
    # fields follow neither on triangles, whose degree is low, nor beyond the highest degree of
    # quadrilaterals, where more layers bring roundoff, nor with so many rings that they take too
    # many pressures
    mesher, degree = solution.settings.get("mesher"), solution.settings.get("degree", 0)
    highest = mesher is not None and degree >= DEGREES[mesher][-1]
    energies = highest or field_accuracy(problem) > problem.rtol
    thin = ("rms_slope", "pressure") if at_smallest(problem) else ()
    names = ENERGIES if energies else [name for name in solution.errors if name not in thin]
    return max(
        (solution.greatest_error(name) for name in names if name in solution.errors), default=0.0
    )
