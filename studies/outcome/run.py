"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeVar

from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import agreements
from ..crosscheck.operators import MOST_PRESSURES, OperatorDifference, check_multipliers, difference
from ..methods.base import Method, Solution
from ..methods.pipeline import AnySpaceMethod
from ..problem.problem import Problem
from ..problem.regimes import OPERATORS
from ..progress import Stages
from ..scene.scene import Scene
from .outcome import Outcome
from .scope import methods_of, refusals

Kind = TypeVar("Kind", bound=Outcome)


def run(scene: Scene, methods: Sequence[str | Method] | None = None) -> Outcome:
    """Compute everything that a scene asks for, by every method it names, and compare them."""
    return run_as(Outcome, scene, methods)


def run_as(kind: type[Kind], scene: Scene, methods: Sequence[str | Method] | None = None) -> Kind:
    """Compute everything that a scene asks for, by every method it names, and compare them.

    `ringwear.run` is what users call; its docstring tells what each method gives, and the rule of
    the verdict.

    Parameters
    ----------
    kind : of the outcome, such as one that shows itself
    scene : what is computed; its numbers in any consistent units
    methods : names of methods, and methods of one's own, in place of the scene's

    Raises
    ------
    RingwearError
        if a method cannot solve the scene, or a mesh or a system fails; the message names the
        remedy
    """
    by_name, problem = methods_of(methods or scene.methods), scene.problem
    if refused := refusals(scene, by_name):
        raise SceneError(refused[0])
    stages = {name: Stages(name) for name in by_name}
    # the dense matrices are small: threads of two linear algebra libraries would spend their time
    # waiting on each other
    with threadpool_limits(1):
        solutions = {
            name: solved_to_accuracy(entry, [problem], stages[name])[0]
            for name, entry in by_name.items()
        }
        operators = tuple(compare_operators(problem, by_name, solutions))
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements(problem, (a, b), (solutions[a], solutions[b]))
    )
    return kind(scene, by_name, solutions, stages, agreement, operators)


def compare_operators(
    problem: Problem, methods: Mapping[str, Method], solutions: Mapping[str, Solution]
) -> Iterator[OperatorDifference]:
    """Compare methods as operators: each on the space of another, where it can be had there.

    A method with a space of its own (the finite elements, on their contact facets) gives the space;
    the others follow.
    """
    if OPERATORS in problem.contact.left_out:
        return
    wears = {
        name: solution.wear for name, solution in solutions.items() if solution.wear is not None
    }
    anywhere = {name for name in wears if isinstance(methods[name], AnySpaceMethod)}
    for a, b in combinations(sorted(wears, key=anywhere.__contains__), 2):
        other = methods[b]
        if isinstance(other, AnySpaceMethod):
            with Stages("check")(f"{a} against {b}"):
                first, space = wears[a], wears[a].compliance.space
                second = replace(first, compliance=other.compliance(space, problem.ground))
                if a not in anywhere:
                    check_multipliers(a, first.compliance, second.compliance)
                if space.size <= MOST_PRESSURES:
                    yield difference(problem, (a, b), first, second)
