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
        at = np.concatenate([self.knots, [np.inf]])
        out = np.zeros(np.shape(times))
        for begin, end in pairwise(at):
            upper = np.clip(times, begin, end)
            speeds = np.interp([begin], self.knots, self.speeds)[0]
            ends = np.interp(upper, self.knots, self.speeds)
            out = out + (upper - begin) * (speeds + ends) / 2
        return out

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return force, distance, and the integral of the force over the distance."""
        times = np.asarray(times, float)
        node, weight = leggauss(4)
        work = []
        for until in times:
            ends = self._segments(until)
            t = ends[:-1, None] + np.diff(ends)[:, None] * (1 + node) / 2
            rate = np.interp(t, self.knots, self.forces) * np.interp(t, self.knots, self.speeds)
            work.append((np.diff(ends)[:, None] / 2 * weight * rate).sum())
        return np.interp(times, self.knots, self.forces), self._distance(times), np.array(work)

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
