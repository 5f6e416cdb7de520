"""The verdict on the results of a run, and what it follows from."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from threadpoolctl import threadpool_limits

from ....meshes.radial import Array
from ..anchors.anchor import Anchor
from ..anchors.checks import anchors, expected_anchors
from ..methods.base import Solution
from ..scene.scene import Scene
from ..verdict.agreement import AGREE, DISAGREE, UNDECIDED, Agreement, overall
from ..verdict.promise import LeftOut, left_out_of_promise
from .output.table import Table
from .table import report


@dataclass(frozen=True, eq=False)
class Judged:
    """The judgement on a table of results, which is computed when it is asked for.

    Parameters
    ----------
    scene : the scene that was solved
    table, answers : the results and the numbers of the answer as they are reported
    solutions : the solution of each of our methods; results of other programs are not among them,
        because these are judged by their errors
    agreement : the verdicts on every pair of methods and every quantity
    """

    scene: Scene
    table: Table
    answers: Mapping[str, Mapping[str, Array]]
    solutions: Mapping[str, Solution]
    agreement: tuple[Agreement, ...]

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method is checked against."""
        reports = {
            name: (report(self.table, name), self.answers[name], solution)
            for name, solution in self.solutions.items()
        }
        # one thread, as for the solutions
        with threadpool_limits(1):
            return tuple(anchors(self.scene, reports))

    @property
    def missing_anchors(self) -> tuple[str, ...]:
        """Names of anchors that the report of a method should have, but does not."""
        present = {(anchor.name, anchor.method) for anchor in self.anchors}
        missing = (
            name
            for method, solution in self.solutions.items()
            for name in expected_anchors(self.scene.problem, solution)
            if (name, method) not in present
        )
        return tuple(dict.fromkeys(missing))

    @property
    def verdict(self) -> str:
        """`agree`, `disagree` or `undecided`: the worst verdict on the promised quantities.

        An anchor that does not hold makes it `disagree`. A missing anchor makes `agree`
        `undecided`.
        """
        if not all(anchor.holds for anchor in self.anchors):
            return DISAGREE
        verdict = overall(self.agreement)
        return UNDECIDED if verdict == AGREE and self.missing_anchors else verdict

    @cached_property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that cannot be promised, with the times and the reason."""
        return tuple(left_out_of_promise(self.scene.problem, self.solutions, self.scene.wear.times))
