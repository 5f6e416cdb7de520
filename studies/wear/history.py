"""What wearing a punch yields, whatever the punch: a history as coefficients on a pressure space.

Non-dimensional.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...meshes.radial import Array, Indices
from .unilateral import Interval, Mask, Press


class Start(Protocol):
    """A press that has not worn yet, on functions that suit it better than the pressure space."""

    @property
    def pressure(self) -> Array:
        """Coefficients of the pressure on a space of its own, or of the history."""

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


class Pressed(NamedTuple):
    """What functions of its own carry of a history.

    Parameters
    ----------
    start : by one force
    force : (T,) that they carry at each time
    rest : (T, size) pressures beside them
    """

    start: Start
    force: Array
    rest: Array


class Moment(NamedTuple):
    """The punch at one time.

    Parameters
    ----------
    time, distance : since the start, and slid until then
    press : pressures, gaps and contact
    integral : (size,) of the pressure over the sliding distance
    work : integral of the force over the sliding distance
    """

    time: float
    distance: float
    press: Press
    integral: Array
    work: float = 0.0


@dataclass(frozen=True)
class Steps:
    """How a march went.

    Steps taken and rejected, and active sets tried in each stage.
    """

    taken: int = 0
    rejected: int = 0
    iterations: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class History:
    """A wearing punch at T times.

    Parameters
    ----------
    distances : (T,) array
        What the punch has slid: the times, at constant speed.
    pressure, profile : (T, size) arrays
        Coefficients of the pressure and of the worn depth. Of what is pressed on functions of its
        own, the pressure is their projection.
    indentation, force : (T,) arrays
    gap : (T, size) array
        Moments of the gap, zero in contact.
    contact : (T, size) array of bool
        Which functions carry.
    pressed : Pressed, optional
        What was put on since the punch last slid, if anything.
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
    pressed: Pressed | None = None
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

    def press(self, start: Start, forces: Array) -> "History":
        """Return the history with (T,) forces on a flat punch of the same space added."""
        if not forces.any():
            return self
        return replace(
            self,
            pressure=self.pressure + np.outer(forces, start.pressure),
            indentation=self.indentation + forces * start.indentation,
            force=self.force + forces,
            pressed=Pressed(start, forces, self.pressure),
        )

    def __getitem__(self, which: Indices | slice) -> "History":
        """Return the history at some of its times, given by number or slice."""
        pressed = self.pressed
        if pressed is not None:
            pressed = pressed._replace(force=pressed.force[which], rest=pressed.rest[which])
        arrays = {name: getattr(self, name)[which] for name in OVER_TIME}
        return replace(self, **arrays, pressed=pressed)

    def then(self, later: "History") -> "History":
        """Return it with what comes later."""
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(later, name)]) for name in OVER_TIME
        }
        return replace(self, **arrays)


# arrays of a history
OVER_TIME = ("distances", "pressure", "profile", "indentation", "force", "gap", "contact")
