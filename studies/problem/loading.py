"""Loads that vary: force and sliding speed over time, linear between knots. Non-dimensional.

Archard's law holds in the sliding distance ``tau = int v dt``: ``df/dtau = k p``. Where the punch
stands still, `tau` does, too, and the force may change without wear. What has worn on all rings
together is ``int f / k dA = int F dtau``, here called the work.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...meshes.radial import Array, Indices
from .fields import OverTime


class State(NamedTuple):
    """A load at T times.

    Parameters
    ----------
    force, distance, work : (T,) force, sliding distance, and integral of the force over it
    knot : (T,) number of the last knot before
    rise, slid : (T,) of the force, and of the distance, since that knot
    bend : (T,) rise of the speed since then over twice its mean, from -1 to 1
    """

    force: Array
    distance: Array
    work: Array
    knot: Indices
    rise: Array
    slid: Array
    bend: Array


@dataclass(frozen=True, eq=False)
class Loading:
    """Force and sliding speed over their greatest values, linear between knots.

    Parameters
    ----------
    times : (K,) array
        Of the knots, increasing from 0; after the last nothing changes.
    forces, speeds : (K,) arrays
        At the knots, from 0 to 1; if none are given, both stay 1.
    """

    times: Array = field(default_factory=lambda: np.zeros(1))
    forces: Array = field(default_factory=lambda: np.ones(1))
    speeds: Array = field(default_factory=lambda: np.ones(1))

    @classmethod
    def over_time(cls, force: OverTime, speed: OverTime, unit: float) -> "Loading":
        """Return a loading by force and speed over time, which is counted in a unit."""
        if len(force.times) == len(speed.times) == 1:
            return cls()
        times = np.unique([0.0, *force.times, *speed.times])
        both = force, speed
        values = (np.interp(times, each.times, each.values) / each.greatest for each in both)
        loading = cls(times / unit, *values)
        return loading if loading.varies else cls()

    @property
    def varies(self) -> bool:
        """Whether the force or the speed ever changes."""
        return bool(np.ptp(self.forces) or np.ptp(self.speeds))

    @property
    def rising(self) -> bool:
        """Whether the force never falls, so that contact of a flat punch stays full."""
        return bool((np.diff(self.forces) >= 0).all())

    @property
    def held_last(self) -> "Loading":
        """The force and speed of the last knot, as if they had always been."""
        return Loading(np.zeros(1), self.forces[-1:], self.speeds[-1:])

    def at(self, times: Array) -> State:
        """Return the load at times (T,), exactly."""
        knot = np.searchsorted(self.times, times, side="right") - 1
        return self._after(knot, times - self.times[knot], *self._integrals)

    @cached_property
    def segments(self) -> State:
        """What knots but the first bring (K - 1,): distance and work are those since the last."""
        nothing = np.zeros(len(self.times))
        return self._after(np.arange(len(nothing) - 1), np.diff(self.times), nothing, nothing)

    def _after(self, knot: Indices, time: Array, distances: Array, works: Array) -> State:
        force, speed = self.forces[knot], self.speeds[knot]
        rise, faster = (slope[knot] * time for slope in self._slopes)
        both = 2 * speed + faster
        bend = np.divide(faster, both, out=np.zeros(len(time)), where=both > 0)
        slid, work = time * both / 2, time * (force * both / 2 + rise * (speed / 2 + faster / 3))
        distance, work = distances[knot] + slid, works[knot] + work
        return State(force + rise, distance, work, knot, rise, slid, bend)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """Rise of the force and of the speed in a time, (K,) after each knot."""
        slopes = np.diff([self.forces, self.speeds]) / np.diff(self.times)
        force, speed = np.column_stack([slopes, np.zeros(2)])
        return force, speed

    @cached_property
    def _integrals(self) -> tuple[Array, Array]:
        """Sliding distance and work (K,) by each knot."""
        segments = self.segments
        return np.cumsum([0.0, *segments.slid]), np.cumsum([0.0, *segments.work])

    def pressed(self, times: Array) -> Array:
        """Return by how much the force has risen (T,) since the punch last slid."""
        state, (distances, _) = self.at(times), self._integrals
        # the first knot that lies as far, if one does
        stop = np.minimum(np.searchsorted(distances, state.distance), len(distances) - 1)
        before = np.where(state.distance > 0, self.forces[stop], 0.0)
        return np.where(distances[stop] == state.distance, state.force - before, 0.0)

    def time_at(self, distance: float, knot: int) -> float:
        """Return when a sliding distance is reached between a knot and the next."""
        speed, slid = self.speeds[knot], distance - self._integrals[0][knot]
        final = np.sqrt(max(speed**2 + 2 * self._slopes[1][knot] * slid, 0.0))
        return float(self.times[knot] + (2 * slid / (speed + final) if slid > 0 else 0.0))
