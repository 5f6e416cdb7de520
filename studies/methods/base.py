"""What a method is, and what it says of a problem."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..contact.fitted_press import CompliancesOn
from ..contact.marched import Marched
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, COMPARED_MODES, DESCRIBED
from ..problem.regimes import FIXED_INDENTATIONS, MOVING_CONTACT, Regime
from ..progress import Stages
from ..sampling.norms import Results
from ..wear.flat_contact import FittedPress
from ..wear.full_contact import RunningIn
from .error_factors import error_factor

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace


@dataclass(frozen=True, eq=False)
class Solution:
    """What a method says of a problem.

    Parameters
    ----------
    results : its quantities at the times and radii asked for; non-dimensional
    checked : the same at some of the times, on the face of the punch: what is compared with other
        methods
    errors : relative, of each quantity and of each number of the answer in its norm, by the
        method's own estimate
    parts : of the indentation, by what causes it
    unknowns, settings, notes : of what was solved
    wear : the running-in on the method's compliance, if it has one
    half_space : the finite-element half-space, if there is one
    smallest : least size of the elements that the method can have beside a ring edge
    march : of a contact that opens, closes and spreads, if it is one
    presses : its start, fitted to the edges of the contact, and a coarser one; empty if that failed
    answers : the numbers of the answer
    steady_part : the steady state of a shaped punch, which is solved by itself, if it has one
    remedy : what would make it more accurate, if that is not a smaller `rtol`
    limited_by_degree : quantities that become no more accurate by a smaller `rtol`, because its
        elements have the highest degree that there is
    """

    results: Results
    checked: Results
    errors: dict[str, Array]
    parts: dict[str, float]
    unknowns: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wear: RunningIn | None = None
    half_space: "HalfSpace | None" = None
    smallest: float = 0.0
    march: Marched | None = None
    presses: tuple[FittedPress, ...] = ()
    answers: Results = field(default_factory=dict)
    steady_part: "Solution | None" = None
    remedy: str = ""
    limited_by_degree: frozenset[str] = frozenset()

    @property
    def error_estimate(self) -> float:
        """The method's own estimate of its relative error, of the indentation over all times."""
        return float(sum(self.parts.values()))

    def beyond(self, rtol: float) -> dict[str, float]:
        """Return the quantities whose estimated error exceeds an accuracy.

        Each is returned with the greatest error that the method estimates for it.
        """
        errors = {name: self.greatest_error(name) for name in self.errors}
        return {name: error for name, error in errors.items() if error > rtol}

    def checked_error(self, problem: Problem, name: str) -> Array:
        """Return the error of a quantity at the times that are checked."""
        error = self.errors[name]
        return error[problem.checked] if DESCRIBED[name].dims[:1] == ("time",) else error

    @property
    def greatest_of_all_errors(self) -> float:
        """The greatest error of all quantities over all times."""
        return max(map(self.greatest_error, self.errors), default=0.0)

    def greatest_error(self, name: str) -> float:
        """Return the greatest error of a quantity over all times.

        For relaxation times, it is the greatest error of the slowest ones, which are compared
        between methods. Numbers of the answer that the method does not give have no error.
        """
        shown = slice(COMPARED_MODES) if "mode" in DESCRIBED[name].dims else ...
        errors = self.errors[name][shown]
        if name in ANSWER:
            # a part that the method does not give has no error
            errors = errors[~np.isnan(errors)]
        return float(np.max(errors, initial=0.0))


@dataclass(frozen=True, eq=False)
class Discretised:
    """The half-space of a method, made ready for a problem.

    Parameters
    ----------
    compliance : Compliance
        On a pressure space that suits the problem (`pressure_spaces`), or on one of the method's
        own.
    coarser : () -> Compliance
        The same, coarser in everything: the difference of the two is the error estimate.
    unknowns : int
        Size of the system behind the compliance; none but the pressures if it is 0.
    settings : dict
        The sizes chosen, for the summary.
    half_space : HalfSpace, optional
        Of finite elements.
    notes : tuple of str
        What the user should know, such as a mesher replaced.
    fitted : pair of CompliancesOn, optional
        Compliances on pressures fitted to the edges of a contact, of a higher and of a lower
        degree, for the start of a shaped punch; without, it is as accurate as the march.
    safety : float
        What the difference to the coarser one is multiplied by, of flat punches.
    smallest : float
        Least size of the elements that the method can have beside a ring edge, in punch radii.
    limited_by_degree : frozenset of str
        Quantities that become no more accurate by a smaller `rtol`, because its elements have the
        highest degree that there is.
    """

    compliance: Compliance
    coarser: Callable[[], Compliance]
    unknowns: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict)
    half_space: "HalfSpace | None" = None
    notes: tuple[str, ...] = ()
    fitted: tuple[CompliancesOn, CompliancesOn] | None = None
    safety: float = error_factor("flat punch")
    smallest: float = 0.0
    limited_by_degree: frozenset[str] = frozenset()


class SystemSize(NamedTuple):
    """How large the system is that a method solves for a problem.

    Parameters
    ----------
    unknowns : of the system behind the compliance
    pressures : that the compliance is between
    """

    unknowns: int
    pressures: int


def flat_punches_only(name: str) -> dict[Regime, str]:
    """Return what a method refuses that solves flat punches under a force only."""
    reason = f"{name} knows flat punches under a force only: leave it out of methods"
    return dict.fromkeys((MOVING_CONTACT, *FIXED_INDENTATIONS), reason)


class Method(ABC):
    """A way to solve the problem.

    Attributes
    ----------
    name : as scenes call it
    what : what it is, for people
    lacks : `history` or `steady state`, if it does not give that, and why
    refused : regimes of problems that it cannot solve, each with the reason and the remedy; all but
        flat punches under a force if it is None
    knows_layers : whether it solves problems on layered ground
    """

    name: str
    what: str = ""
    lacks: ClassVar[dict[str, str]] = {}
    refused: ClassVar[Mapping[Regime, str] | None] = None
    knows_layers: ClassVar[bool] = False

    @abstractmethod
    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return everything that a problem asks for."""

    def solve_alike(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Return the solutions of several problems on the same ring edges and half-space.

        A method that can compute once what they have in common does so here.
        """
        return [self.solve(problem, stages) for problem in problems]

    def solve_again(
        self, problem: Problem, before: Solution, allowed: float, stages: Stages
    ) -> Solution:
        """Return a problem's solution by finer sizes than one before.

        Parameters
        ----------
        problem : with the accuracy that sizes follow
        before : of which a method may keep what is accurate enough
        allowed : relative error that what is kept may have
        stages : tells of the progress
        """
        return self.solve(problem, stages)

    def refusal(self, problem: Problem) -> str:
        """Return why it cannot solve the problem at all, with the remedy; empty if it can."""
        if problem.ground is not None and not self.knows_layers:
            return f"{self.name} does not know half_space.layers: leave it out of methods"
        refused = flat_punches_only(self.name) if self.refused is None else self.refused
        return next((refused[regime] for regime in problem.regimes if regime in refused), "")

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the user has given the sizes of the method, which then stay."""
        return False

    def remedy(self, problem: Problem) -> str:
        """Return what would make it more accurate, if that is not a smaller `rtol`."""
        if self.sizes_given(problem):
            return f"the sizes given for {self.name} are too coarse; leave them out"
        return ""

    def modelling_errors(self, problem: Problem) -> dict[str, str]:
        """Return what the method leaves out of the model of a problem, and what that costs."""
        return {}

    def step(self, problem: Problem) -> float | None:
        """Return the step in time that it marches a problem in, if it is one length."""
        return problem.step

    def system_size(self, problem: Problem) -> SystemSize:
        """Return how large its system will be; closed forms have none."""
        return SystemSize(0, 0)

    def numbers_in_memory(self, problem: Problem, pressures: int) -> float:
        """Return about how many numbers it keeps at once.

        Parameters
        ----------
        pressures : that suit the problem by the method of dimensionality reduction
        """
        return 0.0


def method(name: str) -> Method:
    """Return the method of that name; its file is imported only now."""
    return import_module(f"ringwear.studies.methods.{name.replace('-', '_')}").METHOD
