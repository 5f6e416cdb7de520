"""Methods that yield a compliance: contact, wear, steady states and estimates are written once, over that."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.methods.base import Method, Solution, method
from ringwear.studies.methods.estimate import Pair, estimated
from ringwear.studies.problem.problem import Problem
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

    @abstractmethod
    def discretised(self, problem: Problem, stages: Stages, pairs: bool = True) -> Discretised:
        """The method made ready for a problem; without `pairs`, its error cannot be estimated."""

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Discretise, wear, sample and estimate."""
        one = self.discretised(problem, stages)
        with stages("marching" if len(problem.times) else "steady state"):
            known = estimated(problem, one.compliance, one.pairs)
            results, checked = known.result.results, known.result.checked
        return Solution(
            results,
            checked,
            known.errors,
            known.parts,
            one.unknowns,
            one.settings,
            one.notes,
            known.result.wear,
            one.half_space,
        )


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space, not on one of its own only."""

    @abstractmethod
    def compliance(self, space: PressureSpace) -> Compliance:
        """The compliance on a space."""
