"""Load over time for the independent solution of `independent.py`, integrated between knots."""

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss

Array = np.ndarray


class Load:
    """Force and speed over time, non-dimensional and linear between knots."""

    def __init__(self, knots: Array, forces: Array, speeds: Array) -> None:
        self.knots, self.forces, self.speeds = knots, forces, speeds

    def _segments(self, until: float) -> Array:
        return np.append(self.knots[self.knots < until], until)

    def _distance(self, times: Array) -> Array:
        """Return the sliding distance; the trapezoidal rule is exact for a linear speed."""
        at = np.union1d(self.knots, times)
        speeds = np.interp(at, self.knots, self.speeds)
        slid = np.append(0.0, np.cumsum(np.diff(at) * (speeds[1:] + speeds[:-1]) / 2))
        return np.interp(times, at, slid)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return force, distance, and the integral of the force over the distance."""
        at = np.union1d(self.knots, times)
        node, weight = leggauss(4)
        parts = np.diff(at)[:, None] / 2
        t = at[:-1, None] + parts * (1 + node)
        rate = np.interp(t, self.knots, self.forces) * np.interp(t, self.knots, self.speeds)
        work = np.append(0.0, np.cumsum((parts * weight * rate).sum(axis=1)))
        force = np.interp(times, self.knots, self.forces)
        return force, self._distance(times), np.interp(times, at, work)

    def decayed(self, times: Array, relaxation: Array) -> Array:
        """Return the (T, m) forces that remain in each mode after its decay.

        Each increment of the force decays exponentially with the sliding distance since then. The
        relaxation times (m,) are distances.
        """
        node, weight = leggauss(12)
        out = []
        for until in np.asarray(times, float):
            ends = self._segments(until)
            reached = self._distance(np.array([until]))[0]
            total = self.forces[0] * np.exp(-reached / relaxation)
            for begin, end in pairwise(ends):
                rise = np.diff(np.interp([begin, end], self.knots, self.forces))[0]
                if not rise:
                    continue
                before = (end - begin) * np.append(0.0, 0.25 ** np.arange(28, -1.0, -1))
                low, size = before[:-1, None], np.diff(before)[:, None]
                ago = (low + size * (1 + node) / 2).ravel()
                # distances from t' to the end of the segment, without cancellation
                last, first = np.interp([end, begin], self.knots, self.speeds)
                slid = ago * (last - (last - first) * ago / (end - begin) / 2)
                since = reached - self._distance(np.array([end]))[0] if end < until else 0.0
                decay = np.exp(-(slid[:, None] + since) / relaxation)
                total = total + (size / 2 * weight).ravel() @ decay * rise / (end - begin)
            out.append(total)
        return np.array(out)
