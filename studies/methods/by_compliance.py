"""Methods that yield a compliance.

Contact, wear, steady states and estimates are written once, over that.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ..problem.marching import refused_steps
from ..problem.problem import Problem
from ..problem.profile import FLAT
from ..problem.shared import Shared
from ..progress import Stages
from .base import Method, Solution, method
from .costs import steps
from .estimate import SAFETY, Together, estimated, worn_together

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace
    from .unilateral.solution import UnilateralMethod


@dataclass(frozen=True, eq=False)
class Discretised:
    """A method made ready for a problem.

    Parameters
    ----------
    compliance : on the method's own pressure space
    coarser : of a coarser discretisation, for the error estimate; None if none is wanted
    unknowns : size of the system behind the compliance
    settings : the sizes chosen, for the summary
    half_space : the finite-element half-space, if there is one
    notes : what the user should know, such as a mesher replaced
    safety : times the difference to the coarser one that errors are stated as
    """

    compliance: Compliance
    coarser: Compliance | None
    unknowns: int
    settings: dict[str, Any]
    half_space: "HalfSpace | None" = None
    notes: tuple[str, ...] = ()
    safety: float = SAFETY


def marches_contact(problem: Problem) -> bool:
    """Whether a history is wanted in which contact opens, closes and spreads."""
    return not problem.full_contact and bool(len(problem.times))


def compliance_method(name: str) -> "ComplianceMethod":
    """The method of that name, which must yield a compliance."""
    one = method(name)
    assert isinstance(one, ComplianceMethod)
    return one


class ComplianceMethod(Method):
    """A method that yields a compliance on a pressure space."""

    operator = True

    @abstractmethod
    def discretised(self, problem: Problem, stages: Stages, coarser: bool = True) -> Discretised:
        """The method made ready for a problem.

        Without a `coarser` one its error cannot be estimated.
        """

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Discretise once, for the sharpest of the problems; then wear, sample and estimate
        each.
        """
        if not problems[0].full_contact:
            return [self._with_profile(problem, stages) for problem in problems]
        one = self.discretised(Shared.of(problems) if len(problems) > 1 else problems[0], stages)
        assert one.coarser is not None
        with stages("marching" if len(problems[0].times) else "steady state"):
            together = (
                worn_together(problems, one.compliance, one.coarser) if len(problems) > 1 else None
            )
            return [_solved(problem, one, together) for problem in problems]

    def refusal(self, problem: Problem) -> str:
        """Contact that opens, closes and spreads is marched in implicit steps, from where the punch
        touches.
        """
        if refused := refused_steps(steps(problem), "give a larger wear.step, or march = 'modal'"):
            return refused
        if problem.full_contact:
            return ""
        if problem.march == "explicit":
            return (
                f"wear.march = 'explicit' does not go with {self.name} on an initial profile or a "
                "fixed indentation, where "
                "contact is an inequality: give 'implicit', or 'modal' for steps that suit the "
                "accuracy"
            )
        if problem.indentation is not None and not len(problem.times):
            return (
                "load.indentation has no steady state but that nothing presses any more: give "
                "wear.times"
            )
        return ""

    @abstractmethod
    def unilateral(self, problem: Problem) -> "UnilateralMethod":
        """What it gives to contact on part of the face."""

    def _with_profile(self, problem: Problem, stages: Stages) -> Solution:
        """The history from the unworn face, and the steady state, which is the flat punch's."""
        from .unilateral import solution

        steady = None
        if problem.steady and problem.indentation is None:
            flat = replace(problem, profile=FLAT, times=problem.times[:0], compared_on=problem.face)
            steady = self.solve(flat, stages)
        if not len(problem.times):
            assert steady is not None
            return steady
        return solution.with_steady(
            solution.history(self.unilateral(problem), problem, stages), steady
        )


def _solved(problem: Problem, one: Discretised, together: Together | None) -> Solution:
    assert one.coarser is not None
    known = estimated(problem, one.compliance, one.coarser, together, one.safety)
    results, checked = known.result.results, known.result.checked
    found = results, checked, known.errors, known.parts
    return Solution(
        *found, one.unknowns, one.settings, one.notes, known.result.wear, one.half_space
    )


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space, not on one of its own only."""

    @abstractmethod
    def compliance(self, space: PressureSpace) -> Compliance:
        """The compliance on a space."""

    def unilateral(self, problem: Problem) -> "UnilateralMethod":
        from ...meshes.contact_cells import ContactCells, fitted_space
        from .unilateral.solution import UnilateralMethod

        def even(cells: ContactCells, _: bool) -> tuple[Compliance, int]:
            space = cells.space()
            return self.compliance(space), space.size

        def fitted(edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int) -> Compliance:
            return self.compliance(fitted_space(edges, infinite, degree))

        return UnilateralMethod(even, fitted, (8, 6))
