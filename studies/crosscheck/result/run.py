"""Run a scene: solve it by every method, estimate errors, and judge whether the methods agree."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeVar

from threadpoolctl import threadpool_limits

from ..methods.base import Method, Solution
from ..methods.pipeline import AnySpaceMethod
from ..problem.problem import Problem
from ..progress import Stages
from ..scene.scene import Scene
from ..verdict.accuracy import solved_to_accuracy
from ..verdict.agreement import agreements
from ..verdict.operators import (
    OperatorDifference,
    affordable_subspace,
    check_multipliers,
    difference,
)
from .outcome import Outcome
from .scope import chosen_methods, methods_of, refuse

Kind = TypeVar("Kind", bound=Outcome)


def run(scene: Scene, methods: Sequence[str | Method] | None = None) -> Outcome:
    """Compute everything that a scene asks for, by every method it names, and compare them."""
    return run_as(Outcome, scene, methods)


def run_as(kind: type[Kind], scene: Scene, methods: Sequence[str | Method] | None = None) -> Kind:
    """Compute everything that a scene asks for, by every method it names, and compare them.

    Users call `ringwear.run`; its docstring describes the methods and the rule of the verdict.

    Parameters
    ----------
    kind : class of the result, such as `Result`, which can draw itself
    scene : the scene, with numbers in any consistent units
    methods : names or objects of methods that replace those of the scene; if neither gives any,
        those of the default methods that can solve the scene

    Raises
    ------
    RingwearError
        if a method cannot solve the scene, or if a mesh or a linear system fails; the message
        contains a remedy
    """
    by_name = methods_of(methods) if methods else chosen_methods(scene)
    problem = scene.problem
    refuse(scene, by_name)
    stages = {name: Stages(name) for name in by_name}
    # one thread: the matrices are small, and threads of two linear algebra libraries would mostly
    # wait for each other
    with threadpool_limits(1):
        solutions = {
            name: solved_to_accuracy(entry, [problem], stages[name])[0]
            for name, entry in by_name.items()
        }
        operators = tuple(compare_operators(problem, by_name, solutions))
    units = scene.unit_names
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements(problem, (a, b), (solutions[a], solutions[b]), units)
    )
    return kind(scene, by_name, solutions, stages, agreement, operators)


def compare_operators(
    problem: Problem, methods: Mapping[str, Method], solutions: Mapping[str, Solution]
) -> Iterator[OperatorDifference]:
    """Compare the compliances of every two methods on the pressure space of one of them.

    A method that has a fixed pressure space (finite elements, on their contact facets) determines
    the space; the other methods compute their compliance on it. On a space that is too large, both
    are restricted to a coarser one. Two methods with fixed spaces are not compared.
    """
    if not problem.full_contact:
        return
    wears = {
        name: solution.wear for name, solution in solutions.items() if solution.wear is not None
    }
    any_space = {name for name in wears if isinstance(methods[name], AnySpaceMethod)}
    for a, b in combinations(sorted(wears, key=any_space.__contains__), 2):
        other = methods[b]
        if isinstance(other, AnySpaceMethod):
            with Stages("check")(f"{a} against {b}"):
                running_in, space = wears[a], wears[a].compliance.space
                other_running_in = replace(
                    running_in, compliance=other.compliance(space, problem.ground)
                )
                if a not in any_space:
                    check_multipliers(a, running_in.compliance, other_running_in.compliance)
                if subspace := affordable_subspace(space):
                    pair = (
                        replace(each, compliance=each.compliance.restricted(subspace))
                        if subspace is not space
                        else each
                        for each in (running_in, other_running_in)
                    )
                    yield difference(problem, (a, b), *pair)
