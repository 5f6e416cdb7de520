"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator, Sequence
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
    """Compute everything that a scene asks for.

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
        solutions = {name: solved_to_accuracy(one, [problem], stages[name])[0] for name, one in methods.items()}
        operators = tuple(compare_operators(problem, solutions))
        held = tuple(anchor for name, solution in solutions.items() for anchor in anchors(problem, name, solution))
    agreement = tuple(
        row for a, b in combinations(solutions, 2) for row in agreements(problem, (a, b), (solutions[a], solutions[b]))
    )
    return Result(scene, solutions, stages, agreement, held, operators)


def solved_to_accuracy(one: Method, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
    """Solve problems on the same ring edges; those whose own estimates fall short of the accuracy again, with finer sizes.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step, layers thinner than coordinates
    can tell) is left to the verdict.
    """
    solutions, working = one.solve_all(problems, stages), [problem.rtol for problem in problems]
    short = [number for number, problem in enumerate(problems) if not one.sizes_given(problem)]
    for _ in range(MOST_REFINEMENTS):
        short = [number for number in short if _falls_short(problems[number], solutions[number], working[number])]
        if not short:
            break
        for number in short:
            asked, estimate = problems[number].rtol, error_of_sizes(problems[number], solutions[number])
            working[number] = max(FINEST, working[number] * max(0.5 * asked / estimate, 1 / FINER))
            LOG.info("%8s  its estimate %.1e is above %.1e: refining ...", one.name, estimate, asked)
        finer = one.solve_all([replace(problems[number], rtol=working[number]) for number in short], stages)
        gained = {}
        for number, solution in zip(short, finer, strict=True):
            gained[number] = _ratio(problems[number], solutions[number], solution)
            if gained[number] > 1:
                asked = problems[number].rtol
                note = f"{one.name}: refined from rtol {asked:.1e} to {working[number]:.1e}, for its estimates fell short"
                solutions[number] = replace(solution, notes=(*solution.notes, note))
        short = [number for number in short if gained[number] >= WORTH]
    return solutions


def _falls_short(problem: Problem, solution: Solution, working: float) -> bool:
    return working > FINEST and error_of_sizes(problem, solution) > A_FEW / 2 * problem.rtol


def _ratio(problem: Problem, solution: Solution, finer: Solution) -> float:
    """How many times better a refinement has made a result."""
    return error_of_sizes(problem, solution) / error_of_sizes(problem, finer)


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
