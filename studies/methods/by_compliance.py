"""Methods that yield a compliance: contact, wear, steady states and estimates are written once, over that."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.methods.base import Method, Solution, method
from ringwear.studies.methods.costs import steps
from ringwear.studies.methods.estimate import Pair, estimated
from ringwear.studies.problem.marching import refused_steps
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.shared import Shared
from ringwear.studies.progress import Stages

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace


@dataclass(frozen=True, eq=False)
class Discretised:
    """A method made ready for a problem.

    Parameters
    ----------
    compliance : on the method's own pressure space
    pairs : finer and coarser computations, for the error estimate
    unknowns : size of the system behind the compliance
    settings : the sizes chosen, for the summary
    half_space : the finite-element half-space, if there is one
    notes : what the user should know, such as a mesher replaced
    """

    compliance: Compliance
    pairs: tuple[Pair, ...]
    unknowns: int
    settings: dict[str, Any]
    half_space: "HalfSpace | None" = None
    notes: tuple[str, ...] = ()


def compliance_method(name: str) -> "ComplianceMethod":
    """The method of that name, which must yield a compliance."""
    one = method(name)
    assert isinstance(one, ComplianceMethod)
    return one


class ComplianceMethod(Method):
    """A method that yields a compliance on a pressure space."""

    operator = True

    @abstractmethod
    def discretised(self, problem: Problem, stages: Stages, pairs: bool = True) -> Discretised:
        """The method made ready for a problem; without `pairs`, its error cannot be estimated."""

    def refusal(self, problem: Problem) -> str:
        return refused_steps(steps(problem), "give a larger wear.step, or march = 'modal'")

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Discretise once, for the sharpest of the problems; then wear, sample and estimate each."""
        one = self.discretised(Shared.of(problems) if len(problems) > 1 else problems[0], stages)
        with stages("marching" if len(problems[0].times) else "steady state"):
            return [_solved(problem, one) for problem in problems]


def _solved(problem: Problem, one: Discretised) -> Solution:
    known = estimated(problem, one.compliance, one.pairs)
    results, checked = known.result.results, known.result.checked
    found = results, checked, known.errors, known.parts
    return Solution(*found, one.unknowns, one.settings, one.notes, known.result.wear, one.half_space)


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space, not on one of its own only."""

    @abstractmethod
    def compliance(self, space: PressureSpace) -> Compliance:
        """The compliance on a space."""
