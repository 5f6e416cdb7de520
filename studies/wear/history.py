"""What wearing a punch yields, whatever the punch: a history as coefficients on a pressure space.

Non-dimensional.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...meshes.radial import Array, Indices
from .unilateral import Interval, Mask


class Start(Protocol):
    """A press of the unworn punch on functions that suit it better than the pressure space does."""

    @property
    def indentation(self) -> float:
        """How deep it is."""

    @property
    def force(self) -> float:
        """The force on it, of which pressures are a multiple where that varies."""

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """Where the punch touches."""

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures at radii (R,) of the punch."""

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""


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
    distances : (T,) array
        What the punch has slid: the times, at constant speed.
    pressure, profile : (T, size) arrays
        Coefficients of the pressure and of the worn depth. Where the start has functions of its
        own, its pressure is their projection.
    indentation, force : (T,) arrays
    gap : (T, size) array
        Moments of the gap, zero in contact.
    contact : (T, size) array of bool
        Which functions carry.
    start : Start, optional
        The press of the unworn punch, if one of the distances is zero.
    steps : Steps
        Of the march; none if the history is exact in time.
    """

    distances: Array
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
        distances: Array,
        pressure: Array,
        profile: Array,
        indentation: Array,
        force: Array | float = 1.0,
    ) -> "History":
        """Return the history of a punch of which all carries, under the force 1 or another."""
        none = np.broadcast_to(0.0, pressure.shape)
        full = np.broadcast_to(True, pressure.shape)
        force = np.broadcast_to(force, distances.shape)
        return cls(distances, pressure, profile, indentation, force, none, full)

    def __getitem__(self, which: Indices) -> "History":
        distances = self.distances[which]
        return History(
            distances,
            self.pressure[which],
            self.profile[which],
            self.indentation[which],
            self.force[which],
            self.gap[which],
            self.contact[which],
            self.start if (distances == 0).any() else None,
            self.steps,
        )
