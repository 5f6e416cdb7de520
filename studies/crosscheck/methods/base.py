"""The interface of a method: what it has to provide, and the solution that it returns."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES, DESCRIBED
from ..problem.refusal import Feature, Refusal
from ..progress import Stages
from ..wear.fitted_press import CompliancesOn
from ..wear.flat_contact import FittedPress
from ..wear.full_contact import RunningIn
from .error_factors import error_factor

if TYPE_CHECKING:
    from ....fem.half_space import HalfSpace
    from ..wear.evolution import Evolution


@dataclass(frozen=True, eq=False)
class Solution:
    """What a method has computed for a problem, with its error estimates.

    Parameters
    ----------
    results : the quantities at the requested times and radii, and the numbers of the answer;
        non-dimensional
    compared : the same at the times `problem.compared_rows`, on the face of the punch; these are
        compared with other methods
    errors : relative error of each of them, in its norm, as the method itself estimates it
    parts : error estimate of the indentation, split by cause
    unknowns, settings, notes : size of the system, sizes that were chosen, and texts for the user
    wear : the running-in on the method's compliance, if it has one
    half_space : the finite-element half-space, if there is one
    smallest : smallest element size at a ring edge that the method can use
    slope_roundoff : relative roundoff of RMS slopes where wear has smoothed the pressure over the
        whole face; thinner layers have more (`sizes.ring_edges.amplified_roundoff`)
    evolution : the wear in time of a contact that opens, closes and spreads, if it does that
    presses : the initial contact, on pressure spaces fitted to its edges: a fine solution and a
        coarser one; empty if there is none
    steady_part : the steady state of a shaped punch, which is solved separately, if it has one
    remedy : what would make the solution more accurate, if that is not a smaller `rtol`; the run
        asks the method for it (`Method.remedy`)
    limited_by_degree : quantities that a smaller `rtol` does not make more accurate, because the
        elements already have their highest degree
    error_by_sizes : the part of the error of the response to the load that finer sizes reduce; None
        for closed forms and grids, whose sizes do not follow `rtol`
    """

    results: Results
    compared: Results
    errors: dict[str, Array]
    parts: dict[str, float]
    unknowns: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wear: RunningIn | None = None
    half_space: "HalfSpace | None" = None
    smallest: float = 0.0
    slope_roundoff: float = 0.0
    evolution: "Evolution | None" = None
    presses: tuple[FittedPress, ...] = ()
    steady_part: "Solution | None" = None
    remedy: str = ""
    limited_by_degree: frozenset[str] = frozenset()
    error_by_sizes: float | None = None

    @property
    def error_estimate(self) -> float:
        """The method's own estimate of the relative error of the indentation, over all times."""
        return float(sum(self.parts.values()))

    def beyond(self, rtol: float) -> dict[str, float]:
        """Return the quantities whose estimated error exceeds `rtol`.

        The value for each is its largest estimated error.
        """
        errors = {name: self.greatest_error(name) for name in self.errors}
        return {name: error for name, error in errors.items() if error > rtol}

    def compared_error(self, problem: Problem, name: str) -> Array:
        """Return the error of a quantity at the times `problem.compared_rows`."""
        error = self.errors[name]
        return error[problem.compared_rows] if DESCRIBED[name].over_time else error

    @property
    def max_error(self) -> float:
        """The largest error of all quantities over all times."""
        return max(map(self.greatest_error, self.errors), default=0.0)

    def greatest_error(self, name: str) -> float:
        """Return the largest error of a quantity over all times.

        For relaxation times it is the largest error of the slowest ones, which are compared between
        methods. Values that the method does not compute or that are not finite (NaN) are left out.
        """
        compared = slice(COMPARED_MODES) if "mode" in DESCRIBED[name].dims else ...
        errors = self.errors[name][compared]
        return float(np.max(errors[~np.isnan(errors)], initial=0.0))


@dataclass(frozen=True, eq=False)
class Discretised:
    """The discretised half-space of a method for a problem.

    Parameters
    ----------
    compliance : Compliance
        On a pressure space that suits the problem (`pressure_spaces`), or on a space of the
        method's own.
    coarser : () -> Compliance
        Compute the compliance on a discretisation that is coarser. The difference between the two
        solutions is the error estimate.
    unknowns : int
        Size of the system from which the compliance is condensed; 0 if the pressures are the only
        unknowns.
    settings : dict
        The sizes that were chosen, for the summary.
    half_space : HalfSpace, optional
        The finite-element half-space.
    notes : tuple of str
        Texts for the user, such as that the mesher had to be replaced.
    fitted : pair of CompliancesOn, optional
        For the start of a shaped punch: functions that compute the compliance on pressures fitted
        to the edges of the contact, of a higher and of a lower degree. Without them, the start is
        only as accurate as the march.
    safety : float
        For flat punches: the factor by which the difference to the coarser solution is multiplied.
    smallest : float
        Smallest element size at a ring edge that the method can use, in punch radii.
    slope_roundoff : float
        For flat punches: relative roundoff of RMS slopes where wear has smoothed the pressure over
        the whole face; thinner layers have more (`sizes.ring_edges.amplified_roundoff`).
    least_error : float
        For flat punches: least relative error of every quantity, because the compliance is
        extrapolated to Poisson's ratio 1/2; 0 if it is not.
    limited_by_degree : frozenset of str
        Quantities that a smaller `rtol` does not make more accurate, because the elements already
        have their highest degree.
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
    slope_roundoff: float = 0.0
    least_error: float = 0.0
    limited_by_degree: frozenset[str] = frozenset()


class SystemSize(NamedTuple):
    """Size of the system that a method solves for a problem.

    Parameters
    ----------
    unknowns : unknowns of the system from which the compliance is condensed
    pressures : size of the pressure space, and of the compliance matrix
    notes : texts for the user, such as that the mesher has to be replaced
    """

    unknowns: int
    pressures: int
    notes: tuple[str, ...] = ()


def flat_punches_only(name: str) -> dict[Feature, Refusal]:
    """Return what a method refuses that solves only flat punches under a force."""
    refusal = Refusal(f"{name} solves only flat punches under a given force")
    return {"moving contact": refusal, "fixed indentation": refusal}


class Method(ABC):
    """A numerical method for the problem.

    Attributes
    ----------
    name : the name of the method in scenes
    what : description for the user
    lacks : reasons for which it does not compute the `history` or the `steady state`, by these
        names
    refused : features of problems that it cannot solve, each with the reason and the remedy; if
        None, it solves only flat punches under a force
    knows_layers : whether it solves problems on layered ground
    """

    name: str
    what: str = ""
    lacks: ClassVar[dict[str, str]] = {}
    refused: ClassVar[Mapping[Feature, Refusal] | None] = None
    knows_layers: ClassVar[bool] = False

    @abstractmethod
    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return the solution of a problem, with all quantities that the problem wants."""

    def solve_alike(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Return the solutions of several problems on the same ring edges and half-space.

        A method can override this to compute only once what these problems share.
        """
        return [self.solve(problem, stages) for problem in problems]

    def solve_again(
        self, problem: Problem, earlier: Solution, allowed_error: float, stages: Stages
    ) -> Solution:
        """Return the solution of a problem with finer sizes than those of an earlier solution.

        Parameters
        ----------
        problem : the problem, with the tolerance from which sizes are chosen
        earlier : the earlier solution; a method may reuse the parts of it that are accurate enough
        allowed_error : relative error up to which a part may be reused
        stages : reports the progress
        """
        return self.solve(problem, stages)

    def beyond(self, problem: Problem) -> Refusal | None:
        """Return why problems of this kind are beyond the method; None if it can solve them.

        Settings that only have to be changed are no such reason, but `refusal` names them, too.
        """
        refused = flat_punches_only(self.name) if self.refused is None else self.refused
        if not self.knows_layers:
            refused = {
                "layers": Refusal(f"{self.name} does not solve half_space.layers"),
                **refused,
            }
        return next((refused[each] for each in problem.features if each in refused), None)

    def refusal(self, problem: Problem) -> str:
        """Return why the method cannot solve the problem, with the remedy; empty if it can."""
        beyond = self.beyond(problem)
        return "" if beyond is None else str(beyond)

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the scene sets the sizes of the method, which are then not changed."""
        return False

    def remedy(self, problem: Problem) -> str:
        """Return what would make the method more accurate, if that is not a smaller `rtol`."""
        if self.sizes_given(problem):
            return f"the sizes given for {self.name} are too coarse; leave them out"
        return ""

    def modelling_errors(self, problem: Problem) -> dict[str, str]:
        """Return what the method leaves out of the model, and the error that this causes."""
        return {}

    def step(self, problem: Problem) -> float | None:
        """Return the length of its steps in time, if all steps have the same length."""
        return problem.step

    def system_size(self, problem: Problem) -> SystemSize:
        """Return the size of the system; methods in closed form have none."""
        return SystemSize(0, 0)


def method(name: str) -> Method:
    """Return the method of that name; its module is only imported now."""
    return import_module(f"ringwear.studies.crosscheck.methods.{name.replace('-', '_')}").METHOD
