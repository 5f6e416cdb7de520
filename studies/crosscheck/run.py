"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import xarray
from threadpoolctl import threadpool_limits

from ringwear.meshes.errors import SceneError
from ringwear.studies.crosscheck.agreement import Agreement, agreements
from ringwear.studies.crosscheck.operators import OperatorDifference, difference
from ringwear.studies.methods.base import Method, Solution, method
from ringwear.studies.methods.by_compliance import AnySpaceMethod
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import LOG, Stages

MOST_REFINEMENTS = 2
FINEST = 1e-9


@dataclass(frozen=True, eq=False)
class Result:
    """Everything that a run computed; solutions are non-dimensional, `dataset` is in the scene's units.

    Parameters
    ----------
    scene : what was asked for
    solutions : by method
    stages : seconds by method
    agreement : of every two methods, by quantity
    operators : of every two compliances
    """

    scene: Scene
    solutions: dict[str, Solution]
    stages: dict[str, Stages]
    agreement: tuple[Agreement, ...]
    operators: tuple[OperatorDifference, ...]

    @property
    def agrees(self) -> bool:
        return all(row.agrees for row in self.agreement)

    @property
    def estimates(self) -> dict[str, float]:
        """Each method's own estimate of its relative error, of the indentation over all times."""
        return {name: solution.error_estimate for name, solution in self.solutions.items()}

    @property
    def short_of(self) -> dict[str, float]:
        """Methods whose own estimate is above the accuracy asked for."""
        return {name: value for name, value in self.estimates.items() if value > self.scene.accuracy.rtol}

    @property
    def notes(self) -> tuple[str, ...]:
        return tuple(note for solution in self.solutions.values() for note in solution.notes)

    @property
    def dataset(self) -> xarray.Dataset:
        """The results as an xarray Dataset, in the scene's units."""
        from ringwear.studies.crosscheck.dataset import dataset

        return dataset(self.scene, self.solutions)

    @property
    def summary(self) -> dict[str, Any]:
        """What was done, at what cost, how accurately, and what was left out."""
        from ringwear.studies.crosscheck.dataset import summary

        return summary(self.scene, self.solutions, self.stages, self.agreement, self.operators)


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
        solutions = {name: solved_to_accuracy(one, problem, stages[name]) for name, one in methods.items()}
        operators = tuple(compare_operators(problem, solutions))
    agreement = tuple(
        row
        for a, b in combinations(solutions, 2)
        for row in agreements((a, b), solutions[a].results, solutions[b].results, problem.rtol)
    )
    return Result(scene, solutions, stages, agreement, operators)


def solved_to_accuracy(one: Method, problem: Problem, stages: Stages) -> Solution:
    """Solve; as long as the method's own estimate falls short of the accuracy asked for, again with finer sizes.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step) is left to the verdict.
    """
    asked = working = problem.rtol
    solution = one.solve(problem, stages)
    for _ in range(MOST_REFINEMENTS):
        estimate = solution.error_of_sizes
        if estimate <= asked or working <= FINEST or one.sizes_given(problem):
            break
        working = max(FINEST, working * 0.5 * asked / estimate)
        LOG.info("%8s  its estimate %.1e is above %.1e: refining ...", one.name, estimate, asked)
        finer = one.solve(replace(problem, rtol=working), stages)
        if finer.error_of_sizes >= estimate:
            break
        note = f"{one.name}: refined from rtol {asked:.1e} to {working:.1e}, for its estimate fell short"
        solution = replace(finer, notes=(*finer.notes, note))
    return solution


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
