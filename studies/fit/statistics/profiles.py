"""Intervals by the profile of the likelihood, which may have several valleys.

The profile of a parameter is the least chi-square over all others, by its value. Its interval ends
where that has risen by the threshold. Wherever the likelihood bends, one path of constrained
minima ends too early: so all points that any start or any profile has visited are pooled, each
search begins at the outermost of those within the threshold, and a valley is said to have ended
only after it was looked for from two more points.
"""

from dataclasses import dataclass, field

import numpy as np

from ....meshes.radial import Array
from .likelihood import Likelihood, Point

# how often all searches are repeated from points that others have found since
ROUNDS = 4
# steps of one search, and the part of the threshold's root, or of the way, to which it finds it;
# from a way of this length on, where the interval is too wide for a parameter to be identifiable,
# the larger part
MOST_STEPS, CLOSE, WIDE, CLOSE_IF_WIDE = 40, 0.02, 1.0, 0.1
# relative change of chi-square at which a search for a constrained minimum ends
TOLERANCE = 1e-5
# part by which a point must lie beyond an interval for it to be sought anew
FURTHER = 0.05
# a point that is better by this than the best is a new best
BETTER = 1e-2
# greatest first step, in coordinates
LONGEST = 2.0


class BetterPointError(Exception):
    """A search has found a point that is better than the best one."""

    def __init__(self, point: Point) -> None:
        super().__init__()
        self.point = point


@dataclass(frozen=True, eq=False)
class Profiles:
    """Profiles of the likelihood about its best point.

    Parameters
    ----------
    likelihood : of the measurements
    best : its best point
    covariance : (f, f) by the curvature there
    threshold : rise of chi-square at the ends of an interval
    seen : points within the threshold, whatever was looked for: all intervals hold them
    traces : by the number of a parameter, its values with the least chi-square of each
    """

    likelihood: Likelihood
    best: Point
    covariance: Array
    threshold: float
    seen: list[Point] = field(default_factory=list)
    traces: dict[int, list[tuple[float, float]]] = field(default_factory=dict)

    def intervals(self, numbers: list[int]) -> dict[int, tuple[float, float]]:
        """Return the ends of the intervals of some parameters, infinite where there is none.

        Raises
        ------
        BetterPointError
            if a search finds a better point than the best one
        """
        ends = {(number, sign): 0.0 for number in numbers for sign in (-1, 1)}
        for around in range(ROUNDS):
            found_more = False
            for number, sign in ends:
                reached = self._outermost(number, sign)
                out = sign * (reached.x[number] - self.best.x[number])
                if around and out <= ends[number, sign] * (1 + FURTHER):
                    continue
                found_more = True
                ends[number, sign] = self._search(number, sign, reached, bool(around))
            if not found_more:
                break
        middle = self.best.x
        return {
            number: (middle[number] - ends[number, -1], middle[number] + ends[number, 1])
            for number in numbers
        }

    def _outermost(self, number: int, sign: int) -> Point:
        return max([self.best, *self.seen], key=lambda point: sign * point.x[number])

    def _search(self, number: int, sign: int, reached: Point, again: bool) -> float:
        """Return how far from the best point an interval ends; infinite if it is open.

        The root of the rise of chi-square is nearly straight, and so the end is found by secants.
        """
        place = self.likelihood.free.index(number)
        spread = float(np.sqrt(self.covariance[place, place] * self.threshold))
        middle, goal = self.best.x[number], np.sqrt(self.threshold)
        bound = self.likelihood.parameters[number].reach - sign * middle
        start = sign * (reached.x[number] - middle)
        low, low_rise = start, self._rise(reached)
        high, high_rise = np.inf, np.inf
        step = start + (0.3 * max(start, 0.01) if again else min(spread, LONGEST))
        for _ in range(MOST_STEPS):
            step = min(step, bound)
            point = self._constrained(number, middle + sign * step, reached)
            rise = self._rise(point)
            if rise < goal:
                low, low_rise, reached = step, rise, point
                if step >= bound * (1 - 1e-9):
                    return float(np.inf)
            else:
                high, high_rise = step, rise
            close = CLOSE_IF_WIDE if low > WIDE else CLOSE
            if abs(rise / goal - 1) < close:
                return float(step)
            if high - low < close * high:
                return float(high)
            if np.isinf(high):
                ahead = np.clip(1.05 * goal / max(low_rise, 1e-9) - 1, 0.3, 2.0)
                step = low + (low - start + 0.1 * spread) * ahead
            else:
                step = low + (high - low) * np.clip(
                    (goal - low_rise) / (high_rise - low_rise), 0.1, 0.9
                )
        return float(high)

    def _constrained(self, number: int, value: float, near: Point) -> Point:
        """Return the best point with one parameter held, from a point nearby, and keep it."""
        likelihood = self.likelihood
        place = likelihood.free.index(number)
        along = np.zeros(len(near.x))
        along[list(likelihood.free)] = self.covariance[place] / self.covariance[place, place]
        shift = along * (value - near.x[number])
        start = near.x + shift if np.abs(shift).max() < 1 else near.x
        point = likelihood.best_from(start, number, value, TOLERANCE)
        if point.chi_square > self.best.chi_square + self.threshold:
            # a narrow valley that bends: look again before it is said to end
            closest = min([self.best, *self.seen], key=lambda of: abs(of.x[number] - value))
            others = [
                likelihood.best_from(of.x, number, value, TOLERANCE) for of in (near, closest)
            ]
            point = min([point, *others], key=lambda of: of.chi_square)
        if point.chi_square < self.best.chi_square - BETTER:
            raise BetterPointError(point)
        self.traces.setdefault(number, []).append((value, point.chi_square))
        if point.chi_square < self.best.chi_square + self.threshold:
            self.seen.append(point)
        return point

    def _rise(self, point: Point) -> float:
        return float(np.sqrt(max(point.chi_square - self.best.chi_square, 0.0)))
