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


class Part(NamedTuple):
    """What happens from the last knot before each of T times until then.

    Parameters
    ----------
    knot : (T,) number of the knot
    force, distance, work : (T,) by how much these rise
    bend : (T,) rise of the speed over twice its mean, from -1 to 1
    """

    knot: Indices
    force: Array
    distance: Array
    work: Array
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
    def of(cls, force: OverTime, speed: OverTime, unit: float) -> "Loading":
        """Return the loading of a scene, whose times count in a unit."""
        times = np.unique([0.0, *force.times, *speed.times])
        values = (
            np.interp(times, each.times, each.values) / each.greatest for each in (force, speed)
        )
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

    def since(self, times: Array) -> Part:
        """Return what happens between each of the times and the last knot before it."""
        knot = np.searchsorted(self.times, times, side="right") - 1
        return self._part(knot, times - self.times[knot])

    @cached_property
    def parts(self) -> Part:
        """What happens between each knot and the next, (K - 1,)."""
        return self._part(np.arange(len(self.times) - 1), np.diff(self.times))

    def _part(self, knot: Indices, time: Array) -> Part:
        force, speed = self.forces[knot], self.speeds[knot]
        more, faster = (rise[knot] * time for rise in self._rises)
        both = 2 * speed + faster
        bend = np.divide(faster, both, out=np.zeros(len(time)), where=both > 0)
        work = time * (force * both / 2 + more * (speed / 2 + faster / 3))
        return Part(knot, more, time * both / 2, work, bend)

    @cached_property
    def _rises(self) -> tuple[Array, Array]:
        """Rise of the force and of the speed in a time, (K,) after each knot."""
        lengths = np.diff(self.times)
        force, speed = (
            np.append(np.diff(values) / lengths, 0.0) for values in (self.forces, self.speeds)
        )
        return force, speed

    @cached_property
    def _distances(self) -> Array:
        return np.cumsum([0.0, *self.parts.distance])

    def force(self, times: Array) -> Array:
        """Return the force at times (T,)."""
        part = self.since(times)
        return np.asarray(self.forces[part.knot] + part.force)

    def distance(self, times: Array) -> Array:
        """Return the sliding distance by times (T,), exactly."""
        part = self.since(times)
        return np.asarray(self._distances[part.knot] + part.distance)

    def work(self, times: Array) -> Array:
        """Return the integral of the force over the sliding distance by times (T,), exactly."""
        part = self.since(times)
        return np.asarray(np.cumsum([0.0, *self.parts.work])[part.knot] + part.work)

    def pressed(self, times: Array) -> Array:
        """Return by how much the force has risen (T,) since the punch last slid."""
        part, distances = self.since(times), self.distance(times)
        # the first knot that lies as far
        stopped = np.minimum(np.searchsorted(self._distances, distances), len(self.times) - 1)
        before = np.where(distances > 0, self.forces[stopped], 0.0)
        forces = self.forces[part.knot] + part.force
        return np.where(self._distances[stopped] == distances, forces - before, 0.0)

    def time_at(self, distance: float, knot: int) -> float:
        """Return when a sliding distance is reached between a knot and the next."""
        speed, slid = self.speeds[knot], distance - self._distances[knot]
        final = np.sqrt(max(speed**2 + 2 * self._rises[1][knot] * slid, 0.0))
        return float(self.times[knot] + (2 * slid / (speed + final) if slid > 0 else 0.0))
