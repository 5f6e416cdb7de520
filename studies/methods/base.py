"""What every method is.

An object that knows its sizes at an accuracy, solves a problem, and says how good the result is.

Before it solves, it says what it will cost (`costs.py`).
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import xarray

from ...meshes.radial import Array
from ..problem.problem import Problem
from ..progress import Stages
from ..wear.archard import RunningIn
from .costs import Cost, by_rates
from .quantities import COMPARED_MODES, QUANTITIES

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace

# parts of an error estimate that finer sizes make smaller
OF_SIZES = ("discretisation",)


@dataclass(frozen=True, eq=False)
class Solution:
    """What a method says of a problem.

    Parameters
    ----------
    results : its quantities at the times and radii asked for; non-dimensional
    checked : the same at some of the times, on the face of the punch: what is compared with other
        methods
    errors : relative, of each quantity in its norm, by the method's own estimate
    parts : of the indentation, by what causes it
    unknowns, settings, notes : of what was solved
    wear : the running-in on the method's compliance, if it has one
    half_space : the finite-element half-space, if there is one
    """

    results: xarray.Dataset
    checked: xarray.Dataset
    errors: dict[str, Array]
    parts: dict[str, float]
    unknowns: int = 0
    settings: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wear: RunningIn | None = None
    half_space: "HalfSpace | None" = None

    @property
    def error_estimate(self) -> float:
        """The method's own estimate of its relative error, of the indentation over all times."""
        return float(sum(self.parts.values()))

    def beyond(self, rtol: float) -> dict[str, float]:
        """Quantities whose error is above an accuracy by the method's own estimate, with the
        greatest estimate.
        """
        return {name: error for name in self.errors if (error := self.greatest_error(name)) > rtol}

    def checked_error(self, problem: Problem, name: str) -> Array:
        """The error of a quantity at the times that are checked."""
        error = self.errors[name]
        return error[problem.checked] if QUANTITIES[name].dims[:1] == ("time",) else error

    def greatest_error(self, name: str) -> float:
        """The greatest error of a quantity, over all times.

        Of relaxation times, those of the slowest.
        """
        shown = slice(COMPARED_MODES) if "mode" in QUANTITIES[name].dims else ...
        return float(np.max(self.errors[name][shown], initial=0.0))

    @property
    def error_of_sizes(self) -> float:
        """The part of it that finer sizes would mend: not the time step, the far field or
        roundoff.
        """
        return float(sum(self.parts.get(part, 0.0) for part in OF_SIZES))

    @property
    def has_sizes(self) -> bool:
        """Whether sizes are part of its error, however small that part is."""
        return not self.parts.keys().isdisjoint(OF_SIZES)


def method(name: str) -> "Method":
    """The method of that name; its file is imported only now."""
    return import_module(f"ringwear.studies.methods.{name.replace('-', '_')}").METHOD


class Method(ABC):
    """A way to solve the problem. Subclasses say what they are, and give an instance as ``METHOD``.

    Attributes
    ----------
    name : as scenes call it
    what : what it is, for people
    look : its curve in figures, as matplotlib takes it
    lacks : `history` or `steady state`, if it does not give that, and why
    own_march : whether it has its own way through time, whatever the march of the scene
    operator : whether it yields a compliance, which can be compared with that of another as an
        operator
    """

    name: ClassVar[str]
    what: ClassVar[str]
    look: ClassVar[dict[str, Any]]
    lacks: ClassVar[dict[str, str]] = {}
    own_march: ClassVar[bool] = False
    operator: ClassVar[bool] = False

    @abstractmethod
    def described(self, problem: Problem) -> str:
        """What it will be made of."""

    @abstractmethod
    def counted(self, problem: Problem) -> tuple[int, int]:
        """Unknowns, and pressures among them, without making any."""

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Everything that the problem asks for."""
        return self.solve_all([problem], stages)[0]

    @abstractmethod
    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Everything that problems on the same ring edges and half-space ask for.

        What they share is made once.
        """

    def refusal(self, problem: Problem) -> str:
        """Why it cannot solve the problem at all, with the remedy; empty if it can."""
        if not problem.full_contact:
            return f"{self.name} knows flat punches under a force only: leave it out of methods"
        return ""

    def notes(self, problem: Problem) -> tuple[str, ...]:
        """What is worth knowing before it runs, as far as that is known."""
        return ()

    def kind(self, problem: Problem) -> str:
        """Its name in the table of measured costs."""
        return self.name

    def cost(self, problem: Problem) -> Cost:
        """What it will cost, and how accurate it will be."""
        cost = by_rates(self.kind(problem), *self.counted(problem), problem)
        return replace(cost, error=np.nan) if self.sizes_given(problem) else cost

    def sizes_given(self, problem: Problem) -> bool:
        """Whether the user has given its sizes, which then stay as they are."""
        return False
