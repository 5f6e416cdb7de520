"""What wearing a punch yields, whatever the punch: a history as coefficients on a pressure space.

Non-dimensional.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...meshes.radial import Array, Indices
from .unilateral import Interval, Load, Mask


class Start(Protocol):
    """A press of the unworn punch on functions that suit it better than the pressure space does."""

    @property
    def indentation(self) -> float:
        """How deep it is."""

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """Where the punch touches."""

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures at radii (R,) of the punch."""

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""


class March(Protocol):
    """A march of a contact that opens, closes and spreads (`ContactMarch`)."""

    load: Load

    @property
    def time_of_full_contact(self) -> float:
        """When all of the face began to carry for good; NaN if it never did."""

    @property
    def slowest_time(self) -> float:
        """The slowest relaxation time of the full face."""

    @property
    def path(self) -> Array:
        """(S, 4) time, indentation, force, and area of contact over that of the face.

        At the start, and after each step taken.
        """

    def left(self, times: Array | None = None) -> tuple[Array, Array]:
        """Return times (T,), and how far the punch is from where wear tends to by each."""


@dataclass(frozen=True)
class Steps:
    """How a march went.

    Steps taken and rejected, active sets tried in each stage, and the error that the quadrature in
    time adds to the worn depth over all steps, in the norm of the march.
    """

    taken: int = 0
    rejected: int = 0
    iterations: tuple[int, ...] = ()
    error: float = 0.0


@dataclass(frozen=True, eq=False)
class History:
    """A wearing punch at T times.

    Parameters
    ----------
    times : (T,) array
    pressure, profile : (T, size) arrays
        Coefficients of the pressure and of the worn depth. Where the start has functions of its
        own, its pressure is their projection.
    indentation, force : (T,) arrays
    gap : (T, size) array
        Moments of the gap, zero in contact.
    contact : (T, size) array of bool
        Which functions carry.
    start : Start, optional
        The press at the first of the times, if that is the start.
    steps : Steps
        Of the march; none if the history is exact in time.
    """

    times: Array
    pressure: Array
    profile: Array
    indentation: Array
    force: Array
    gap: Array
    contact: Mask
    start: Start | None = None
    steps: Steps = Steps()

    @classmethod
    def in_full_contact(
        cls,
        times: Array,
        pressure: Array,
        profile: Array,
        indentation: Array,
        force: Array,
    ) -> "History":
        """Return the history of a punch of which all carries."""
        none = np.broadcast_to(0.0, pressure.shape)
        full = np.broadcast_to(True, pressure.shape)
        return cls(times, pressure, profile, indentation, force, none, full)

    def __getitem__(self, which: Indices) -> "History":
        times = self.times[which]
        return History(
            times,
            self.pressure[which],
            self.profile[which],
            self.indentation[which],
            self.force[which],
            self.gap[which],
            self.contact[which],
            self.start if (times == 0).any() else None,
            self.steps,
        )
