"""Solve to the accuracy asked for.

Where a method's own estimates fall short of it, again with finer sizes.
"""

from collections.abc import Sequence
from dataclasses import replace

from ...meshes.errors import RingwearError
from ..methods.base import Method, Solution
from ..problem.defaults import followed
from ..problem.problem import Problem
from ..problem.quantities import A_FEW, ENERGIES
from ..problem.sections import DEGREES
from ..progress import LOG, Stages
from .agreement import unresolved


def solved_to_accuracy(
    method: Method, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve problems on the same ring edges, and those again whose estimates fall short.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step, layers
    thinner than coordinates can tell) is left to the verdict. A refinement asks for sizes of at
    most ten times the accuracy, and is followed by another if it has halved the error.
    """
    solutions = method.solve_all(problems, stages)
    errors = [error_of_sizes(*pair) for pair in zip(problems, solutions, strict=True)]
    # where edges move, half of the uncertainty that two methods may have
    allowed = [of.rtol * (1.0 if of.full_contact else A_FEW / 2) for of in problems]
    limits = [
        followed(problem, solution.settings.get("pressures", 0))
        for problem, solution in zip(problems, solutions, strict=True)
    ]
    working = [min(problem.rtol, most) for problem, (_, most) in zip(problems, limits, strict=True)]
    short = [at for at, problem in enumerate(problems) if not problem.sizes_given(method.name)]
    for _ in range(4):
        short = [at for at in short if working[at] > limits[at][0] and errors[at] > allowed[at]]
        if not short:
            break
        for at in short:
            ratio = max(0.5 * allowed[at] / errors[at], 0.1)
            working[at] = max(limits[at][0], working[at] * ratio)
            numbers = method.name, errors[at], allowed[at]
            LOG.info("%8s  its estimate %.1e is above %.1e: refining ...", *numbers)
        finer = [replace(problems[at], rtol=working[at]) for at in short]
        try:
            refined = method.solve_all(finer, stages)
        except RingwearError as failure:
            # what is there is as good as it says
            LOG.info("%8s  cannot be refined: %s", method.name, failure)
            break
        for at, solution in zip(short[:], refined, strict=True):
            error = error_of_sizes(problems[at], solution)
            if 2 * error > errors[at]:
                short.remove(at)
            if error < errors[at]:
                note = (
                    f"{method.name}: refined from rtol {problems[at].rtol:.1e} to "
                    f"{working[at]:.1e}, for its estimates fell short"
                )
                solutions[at] = replace(solution, notes=(*solution.notes, note))
                errors[at] = error
    return solutions


def error_of_sizes(problem: Problem, solution: Solution) -> float:
    """Return the greatest error estimate of all quantities that finer sizes would mend."""
    names = [name for name in solution.errors if not unresolved(problem, name, "")]
    if problem.full_contact:
        # closed forms and the uniform grid have no sizes that go by the accuracy asked for
        discretisation = solution.parts.get("discretisation", solution.parts.get("force"))
        if problem.march != "modal" or discretisation is None:
            return discretisation or 0.0
        # fields follow neither on triangles, whose degree is low, nor beyond the highest degree of
        # quadrilaterals, where more layers bring roundoff
        mesher, degree = solution.settings.get("mesher"), solution.settings.get("degree", 0)
        if mesher in DEGREES and degree >= DEGREES[mesher][-1]:
            names = [name for name in names if name in ENERGIES]
    error = max(map(solution.greatest_error, names), default=0.0)
    # cells do not mend what is far above, such as the last of a force that decays
    return error if problem.full_contact or error < 40 * problem.rtol else 0.0
