"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ..methods.base import Solution, method
from ..methods.by_compliance import AnySpaceMethod
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..progress import Stages
from .accuracy import solved_to_accuracy
from .agreement import agreements
from .dataset import Result
from .operators import OperatorDifference, difference
from .scope import refusals


def run(scene: Scene) -> Result:
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Parameters
    ----------
    scene : what is computed; its numbers in any consistent units

    Returns
    -------
    Result
        `dataset` (xarray, in the scene's units), `answers` by method, `verdict`, `agreement`,
        `anchors`, `summary`

    Progress goes to the logger `ringwear`.

    Raises
    ------
    RingwearError
        if a method cannot solve the scene, or a mesh or a system fails; the message names the
        remedy
    """
    problem, methods = scene.problem, {name: method(name) for name in scene.methods}
    if refused := refusals(scene):
        raise SceneError(refused[0])
    stages = {name: Stages(name) for name in methods}
    # the dense matrices are small: threads of two linear algebra libraries would spend their time
    # waiting on each other
    with threadpool_limits(1):
        solutions = {
            name: solved_to_accuracy(one, [problem], stages[name])[0]
            for name, one in methods.items()
        }
        operators = tuple(compare_operators(problem, solutions))
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements(problem, (a, b), (solutions[a], solutions[b]))
    )
    return Result(scene, solutions, stages, agreement, operators)


def compare_operators(
    problem: Problem, solutions: dict[str, Solution]
) -> Iterator[OperatorDifference]:
    """Compare methods as operators: each on the space of another, where it can be had there.

    A method with a space of its own (the finite elements, on their contact facets) gives the space;
    the others follow.
    """
    if not problem.full_contact:
        return
    wears = {
        name: solution.wear for name, solution in solutions.items() if solution.wear is not None
    }
    for a, b in combinations(
        sorted(wears, key=lambda name: isinstance(method(name), AnySpaceMethod)), 2
    ):
        other = method(b)
        if isinstance(other, AnySpaceMethod):
            with Stages("check")(f"{a} against {b}"):
                second = replace(wears[a], compliance=other.compliance(wears[a].compliance.space))
                compared = difference(problem, (a, b), wears[a], second)
            if not isinstance(method(a), AnySpaceMethod):
                compared.check_multipliers()
            yield compared
