"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

from threadpoolctl import threadpool_limits

from ringwear.meshes.errors import SceneError
from ringwear.studies.crosscheck.agreement import A_FEW, FINEST, agreements
from ringwear.studies.crosscheck.anchors import anchors
from ringwear.studies.crosscheck.dataset import Result
from ringwear.studies.crosscheck.operators import OperatorDifference, difference
from ringwear.studies.methods.base import Method, Solution, method
from ringwear.studies.methods.by_compliance import AnySpaceMethod
from ringwear.studies.methods.quantities import ENERGIES
from ringwear.studies.problem.defaults import at_smallest, field_accuracy
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import LOG, Stages

MOST_REFINEMENTS = 4
# times finer that a refinement asks for at the most; times better that it has to make the result to be followed by another
FINER, WORTH = 10.0, 3.0


def run(scene: Scene) -> Result:
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Parameters
    ----------
    scene : what is computed; its numbers in any consistent units

    Returns
    -------
    Result
        `dataset` (xarray, in the scene's units), `answers` by method, `verdict`, `agreement`, `anchors`, `summary`

    Progress goes to the logger `ringwear`.

    Raises
    ------
    RingwearError
        if a method cannot solve the scene, or a mesh or a system fails; the message names the remedy
    """
    problem, methods = scene.problem, {name: method(name) for name in scene.methods}
    refusals = [refusal for one in methods.values() if (refusal := one.refusal(problem))]
    if refusals:
        raise SceneError(refusals[0])
    stages = {name: Stages(name) for name in methods}
    # the dense matrices are small: threads of two linear algebra libraries would spend their time waiting on each other
    with threadpool_limits(1):
        solutions = {name: solved_to_accuracy(one, problem, stages[name]) for name, one in methods.items()}
        operators = tuple(compare_operators(problem, solutions))
        held = tuple(anchor for name, solution in solutions.items() for anchor in anchors(problem, name, solution))
    agreement = tuple(
        row for a, b in combinations(solutions, 2) for row in agreements(problem, (a, b), (solutions[a], solutions[b]))
    )
    return Result(scene, solutions, stages, agreement, held, operators)


def solved_to_accuracy(one: Method, problem: Problem, stages: Stages) -> Solution:
    """Solve; as long as the method's own estimates fall short of the accuracy asked for, again with finer sizes.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step, layers thinner than coordinates
    can tell) is left to the verdict.
    """
    asked = working = problem.rtol
    solution = one.solve(problem, stages)
    for _ in range(MOST_REFINEMENTS):
        estimate = error_of_sizes(problem, solution)
        if estimate <= A_FEW / 2 * asked or working <= FINEST or one.sizes_given(problem):
            break
        working = max(FINEST, working * max(0.5 * asked / estimate, 1 / FINER))
        LOG.info("%8s  its estimate %.1e is above %.1e: refining ...", one.name, estimate, asked)
        finer = one.solve(replace(problem, rtol=working), stages)
        gained = estimate / error_of_sizes(problem, finer)
        if gained > 1:
            note = f"{one.name}: refined from rtol {asked:.1e} to {working:.1e}, for its estimates fell short"
            solution = replace(finer, notes=(*finer.notes, note))
        if gained < WORTH:
            break
    return solution


def error_of_sizes(problem: Problem, solution: Solution) -> float:
    """The greatest error of all quantities that finer sizes would mend."""
    if problem.march != "modal" or not solution.error_of_sizes:
        return solution.error_of_sizes
    # fields follow neither on triangles, whose degree is low, nor with so many rings that they take too many pressures
    energies = solution.settings.get("mesher", "quads") != "quads" or field_accuracy(problem) > problem.rtol
    thin = ("rms_slope", "pressure") if at_smallest(problem) else ()
    names = ENERGIES if energies else [name for name in solution.errors if name not in thin]
    return max((solution.greatest_error(name) for name in names if name in solution.errors), default=0.0)


def compare_operators(problem: Problem, solutions: dict[str, Solution]) -> Iterator[OperatorDifference]:
    """Compare methods as operators: each on the space of another, where it can be had there.

    A method with a space of its own (the finite elements, on their contact facets) gives the space; the others follow.
    """
    wears = {name: solution.wear for name, solution in solutions.items() if solution.wear is not None}
    for a, b in combinations(sorted(wears, key=lambda name: isinstance(method(name), AnySpaceMethod)), 2):
        other = method(b)
        if isinstance(other, AnySpaceMethod):
            with Stages("check")(f"{a} against {b}"):
                second = replace(wears[a], compliance=other.compliance(wears[a].compliance.space))
                compared = difference(problem, (a, b), wears[a], second)
            if not isinstance(method(a), AnySpaceMethod):
                compared.check_multipliers()
            yield compared
