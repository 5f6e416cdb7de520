"""The history of a wearing punch, as coefficients on a pressure space. Non-dimensional."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from ....meshes.radial import Array, Indices
from .unilateral import ContactSolution, Mask

if TYPE_CHECKING:
    from .flat_contact import FittedPress, FlatStart

Start: TypeAlias = "FlatStart | FittedPress"
"""The solution for the unworn punch, on functions that represent it better than the space."""


class UnwornPart(NamedTuple):
    """The part of a history's pressure that is a multiple of the unworn solution, and the rest.

    The pressure at each time is ``force / start.force`` times the pressure of `start`, plus `rest`.

    Parameters
    ----------
    start : Start
        Solution for the unworn punch.
    force : (T,) array
        Force carried by that part at each time.
    rest : (T, size) array
        Coefficients of the remaining pressure on the space of the history.
    """

    start: Start
    force: Array
    rest: Array


class Instant(NamedTuple):
    """The state of the punch at one instant.

    Parameters
    ----------
    time, distance : float
        Time since the start, and sliding distance until then.
    press : ContactSolution
        Pressures, gaps and contact.
    integral : (size,) array
        Integral of the pressure over the sliding distance.
    work : float
        Integral of the force over the sliding distance.
    """

    time: float
    distance: float
    press: ContactSolution
    integral: Array
    work: float = 0.0


@dataclass(frozen=True, eq=False)
class History:
    """A wearing punch at T times.

    In full contact the whole face finally wears by the same depth, which grows without bound. This
    depth is stored apart from the shape of the face, which would otherwise drown in its roundoff.

    Parameters
    ----------
    times, distances : (T,) arrays
        Times, and sliding distances until then.
    pressure, shape : (T, size) arrays
        Coefficients of the pressure, and of the worn depth less `even_wear`. The pressure contains
        the projection of the part that `pressed` represents more accurately.
    depth, force : (T,) arrays
        Indentation less `even_wear`, and normal force.
    gap : (T, size) array
        Moments of the gap, zero in contact.
    contact : (T, size) array of bool
        Whether each basis function is in contact.
    pressed : UnwornPart, optional
        The part of the pressure that was applied since the punch last slid, if there is any. No
        wear has changed it yet.
    integral : (T, size) array
        Integral of the pressure over the sliding distance, less that of the steady pressure that
        wears by `even_wear`. Zero if the worn depth is in the space of the pressures, as that of a
        flat punch is.
    even_wear : (T,) array
        Once the whole face is in contact: the steady wear rate times the work of the force so far,
        which is the mean worn depth, with the steady pressure as its weight. 0 before.
    uniform : (size,) array
        Coefficients of the constant 1.
    """

    times: Array
    distances: Array
    pressure: Array
    shape: Array
    depth: Array
    force: Array
    gap: Array
    contact: Mask
    integral: Array
    even_wear: Array
    uniform: Array
    pressed: UnwornPart | None = None

    @classmethod
    def in_full_contact(
        cls,
        times: Array,
        distances: Array,
        pressure: Array,
        shape: Array,
        depth: Array,
        force: Array,
        even_wear: Array,
        uniform: Array,
    ) -> "History":
        """Return the history of a punch in full contact, without the integral of its pressure."""
        zero = np.broadcast_to(0.0, pressure.shape)
        full = np.broadcast_to(True, pressure.shape)
        fields = times, distances, pressure, shape, depth, force
        return cls(*fields, zero, full, zero, even_wear, uniform)

    @property
    def indentation(self) -> Array:
        """(T,) indentation."""
        return self.depth + self.even_wear

    @property
    def profile(self) -> Array:
        """(T, size) coefficients of the worn depth."""
        return self.shape + np.outer(self.even_wear, self.uniform)

    def press(self, start: Start, forces: Array) -> "History":
        """Return the history plus the flat-punch solution `start` under additional forces (T,)."""
        if not forces.any():
            return self
        return replace(
            self,
            pressure=self.pressure + np.outer(forces, start.pressure),
            depth=self.depth + forces * start.indentation,
            force=self.force + forces,
            pressed=UnwornPart(start, forces, self.pressure),
        )

    def __getitem__(self, index: Indices | slice) -> "History":
        """Return the history at some of its times, given by their indices or a slice."""
        pressed = self.pressed
        if pressed is not None:
            pressed = pressed._replace(force=pressed.force[index], rest=pressed.rest[index])
        arrays = {name: getattr(self, name)[index] for name in TIME_ARRAYS}
        return replace(self, **arrays, pressed=pressed)

    @classmethod
    def joined(cls, parts: "Sequence[History]") -> "History":
        """Return successive histories as one, with the `pressed` part of the first one."""
        first, *others = parts
        if not others:
            return first
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in TIME_ARRAYS
        }
        return replace(first, **arrays)


# fields of `History` whose first axis is time
TIME_ARRAYS = (
    "times",
    "distances",
    "pressure",
    "shape",
    "depth",
    "force",
    "gap",
    "contact",
    "integral",
    "even_wear",
)
