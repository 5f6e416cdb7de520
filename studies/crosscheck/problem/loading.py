"""Represent loads that vary: force and sliding speed over time, linear between knots.

Non-dimensional. Archard's law is written in the sliding distance ``tau = int v dt``: ``df/dtau = k
p``. While the punch does not slide, `tau` is constant, and the force may change without wear. The
integral of the force over the distance, ``int F dtau = int f / k dA``, is called the work.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....meshes.radial import Array, Indices
from .fields import OverTime


class State(NamedTuple):
    """A load at T times.

    Parameters
    ----------
    force, distance, work : (T,) arrays
        Force, sliding distance, and integral of the force over the distance.
    knot : (T,) array of int
        Index of the last knot at or before each time.
    rise, slid : (T,) arrays
        Increase of the force and sliding distance since that knot.
    bend : (T,) array
        Increase of the speed since that knot over twice its mean, from -1 to 1.
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
        Times of the knots, increasing from 0. After the last knot, force and speed are constant.
    forces, speeds : (K,) arrays
        Force and speed at the knots, from 0 to 1. By default both are always 1.
    """

    times: Array = field(default_factory=lambda: np.zeros(1))
    forces: Array = field(default_factory=lambda: np.ones(1))
    speeds: Array = field(default_factory=lambda: np.ones(1))

    @classmethod
    def over_time(cls, force: OverTime, speed: OverTime, unit: float) -> "Loading":
        """Return the loading of a force and a speed over time, with times divided by `unit`."""
        if len(force.times) == len(speed.times) == 1:
            return cls()
        times = np.unique([0.0, *force.times, *speed.times])
        curves = force, speed
        values = (np.interp(times, curve.times, curve.values) / curve.greatest for curve in curves)
        loading = cls(times / unit, *values)
        return loading if loading.varies else cls()

    @property
    def varies(self) -> bool:
        """Whether the force or the speed changes."""
        return bool(np.ptp(self.forces) or np.ptp(self.speeds))

    @property
    def rising(self) -> bool:
        """Whether the force never falls. A flat punch then always stays in full contact."""
        return bool((np.diff(self.forces) >= 0).all())

    @property
    def final(self) -> "Loading":
        """A constant loading with the force and speed of the last knot."""
        return Loading(np.zeros(1), self.forces[-1:], self.speeds[-1:])

    def at(self, times: Array) -> State:
        """Return the exact load at times (T,)."""
        knot = np.searchsorted(self.times, times, side="right") - 1
        return self._state_since_knot(knot, times - self.times[knot], *self._integrals)

    @cached_property
    def segments(self) -> State:
        """State at the end of each segment between two knots (K - 1,).

        Distance and work are those of the segment alone.
        """
        zeros = np.zeros(len(self.times))
        return self._state_since_knot(np.arange(len(zeros) - 1), np.diff(self.times), zeros, zeros)

    def _state_since_knot(
        self, knot: Indices, duration: Array, distances: Array, works: Array
    ) -> State:
        force, speed = self.forces[knot], self.speeds[knot]
        rise, speed_rise = (slope[knot] * duration for slope in self._slopes)
        speed_sum = 2 * speed + speed_rise
        bend = np.divide(speed_rise, speed_sum, out=np.zeros(len(duration)), where=speed_sum > 0)
        slid = duration * speed_sum / 2
        segment_work = duration * (force * speed_sum / 2 + rise * (speed / 2 + speed_rise / 3))
        distance, work = distances[knot] + slid, works[knot] + segment_work
        return State(force + rise, distance, work, knot, rise, slid, bend)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """Rates of change of force and speed, (K,) each, after each knot."""
        slopes = np.diff([self.forces, self.speeds]) / np.diff(self.times)
        force, speed = np.column_stack([slopes, np.zeros(2)])
        return force, speed

    @cached_property
    def _integrals(self) -> tuple[Array, Array]:
        """Sliding distance and work, (K,) each, until each knot."""
        segments = self.segments
        return np.cumsum([0.0, *segments.slid]), np.cumsum([0.0, *segments.work])

    def changes_before(self, times: Array) -> tuple[Array, Array]:
        """Return how far the punch has slid since each knot, and how much the force has changed.

        Returns
        -------
        slid : (T, K) array
            Sliding distance from each knot until each time; not positive if the knot is later.
        parts : (T, K) array
            Sum of all changes of the force since that knot, over the force at that time, at most 1.
            It is 1 at the first knot, at which the punch was pressed on, and 0 without a force.
        """
        state, (distances, _) = self.at(times), self._integrals
        changes = np.cumsum(np.abs(np.diff(self.forces, prepend=self.forces[0])))
        until = changes[state.knot] + np.abs(state.rise)
        force = state.force[:, None]
        parts = np.divide(
            until[:, None] - changes,
            force,
            out=np.zeros((len(times), len(changes))),
            where=force > 0,
        )
        parts[:, 0] = 1.0
        return state.distance[:, None] - distances, np.clip(parts, 0.0, 1.0)

    def force_rise_at_rest(self, times: Array) -> Array:
        """Return the increase of the force (T,) since the punch last slid; 0 while it slides."""
        state, (distances, _) = self.at(times), self._integrals
        # the first knot with the same sliding distance, if there is one
        stop_knot = np.minimum(np.searchsorted(distances, state.distance), len(distances) - 1)
        force_at_stop = np.where(state.distance > 0, self.forces[stop_knot], 0.0)
        return np.where(distances[stop_knot] == state.distance, state.force - force_at_stop, 0.0)

    def contact_times(self, times: Array) -> Array:
        """Return the times (E,) at which a march always solves a contact problem.

        They are the requested times (T,) and the knots of the load until the last of these.
        """
        return np.union1d(times, self.times[self.times < times[-1]])

    def times_at(self, distances: Array) -> Array:
        """Return the first times (S,) at which sliding distances (S,) are reached.

        A distance that is never reached, because sliding stops before, has no time: NaN.
        """
        knots = np.maximum(np.searchsorted(self._integrals[0], distances) - 1, 0)
        pairs = zip(distances.tolist(), knots.tolist(), strict=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.array([self.time_at(distance, knot) for distance, knot in pairs])
        return np.where(np.isfinite(times), times, np.nan)

    def time_at(self, distance: float, knot: int) -> float:
        """Return the time at which a sliding distance is reached between a knot and the next."""
        speed, slid = self.speeds[knot], distance - self._integrals[0][knot]
        final_speed = np.sqrt(max(speed**2 + 2 * self._slopes[1][knot] * slid, 0.0))
        return float(self.times[knot] + (2 * slid / (speed + final_speed) if slid > 0 else 0.0))
