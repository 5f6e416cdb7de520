"""Confidence intervals from profiles of the likelihood, whose valleys may bend.

The profile of a parameter is the minimum of chi-square over all other parameters, as a function of
its value. The interval ends where the profile has risen by a threshold. If the valleys of
chi-square bend, a single path of constrained minima, such as that of lmfit's `conf_interval`,
leaves the valley and ends too early. Therefore all points that any profile has visited are pooled,
each search begins at the outermost pooled point within the threshold, and a valley counts as ended
only after constrained minima from two more points have failed, too.
"""

from dataclasses import dataclass, field

import numpy as np

from ...meshes import Array
from .estimator import Likelihood, Point

# greatest number of rounds of searches; after the first round, a search begins again if another
# one has found a point further out
ROUNDS = 4
# greatest number of steps of a search. It ends if the root of the rise of chi-square, or the
# distance, is known to the relative tolerance `CLOSE`; beyond the distance `WIDE`, at which a
# parameter is no longer identifiable, to `CLOSE_IF_WIDE`
MAX_STEPS, CLOSE, WIDE, CLOSE_IF_WIDE = 40, 0.02, 1.0, 0.1
# relative change of chi-square at which a search for a constrained minimum ends
TOLERANCE = 1e-5
# relative distance by which a point must be outside an interval for a new search
MIN_EXTENSION = 0.05
# decrease of chi-square by which a point replaces the best one
MIN_IMPROVEMENT = 1e-2
# greatest first step, in coordinates
MAX_FIRST_STEP = 2.0


class BetterPointError(Exception):
    """A search has found a point with a lower chi-square than the best one: its argument."""


@dataclass(frozen=True, eq=False)
class Profiles:
    """Profiles of the likelihood around its best point.

    Parameters
    ----------
    likelihood : of the measurements
    best : its best point
    covariance : (f, f) covariance of the free parameters, by the curvature at the best point
    threshold : rise of chi-square at the ends of an interval
    seen : pooled points within the threshold; all intervals include them
    traces : by the index of a parameter, pairs of its coordinate and the minimum of chi-square
    """

    likelihood: Likelihood
    best: Point
    covariance: Array
    threshold: float
    seen: list[Point] = field(default_factory=list)
    traces: dict[int, list[tuple[float, float]]] = field(default_factory=dict)

    def intervals(self, numbers: list[int]) -> dict[int, tuple[float, float]]:
        """Return the intervals of parameters by their indices; open ends are infinite.

        Raises
        ------
        BetterPointError
            if a search finds a better point than the best one
        """
        ends = {(number, sign): 0.0 for number in numbers for sign in (-1, 1)}
        for search_round in range(ROUNDS):
            extended = False
            for number, sign in ends:
                outermost = self._outermost(number, sign)
                distance = sign * (outermost.x[number] - self.best.x[number])
                if search_round and distance <= ends[number, sign] * (1 + MIN_EXTENSION):
                    continue
                extended = True
                ends[number, sign] = self._search(number, sign, outermost, bool(search_round))
            if not extended:
                break
        middle = self.best.x
        return {
            number: (middle[number] - ends[number, -1], middle[number] + ends[number, 1])
            for number in numbers
        }

    def _outermost(self, number: int, sign: int) -> Point:
        return max([self.best, *self.seen], key=lambda point: sign * point.x[number])

    def _search(self, number: int, sign: int, nearest: Point, again: bool) -> float:
        """Return the distance of the end of an interval from the best point; infinite if open.

        The root of the rise of chi-square is nearly linear, so that the secant method is used.

        Parameters
        ----------
        number, sign : index of the parameter, and side of the interval
        nearest : point within the threshold at which the search begins
        again : whether this is a later search for the same end
        """
        place = self.likelihood.free.index(number)
        spread = float(np.sqrt(self.covariance[place, place] * self.threshold))
        middle, goal = self.best.x[number], np.sqrt(self.threshold)
        bound = self.likelihood.parameters[number].reach - sign * middle
        start = sign * (nearest.x[number] - middle)
        low, low_rise = start, self._root_of_rise(nearest)
        high, high_rise = np.inf, np.inf
        step = start + (0.3 * max(start, 0.01) if again else min(spread, MAX_FIRST_STEP))
        for _ in range(MAX_STEPS):
            step = min(step, bound)
            point = self._constrained_minimum(number, middle + sign * step, nearest)
            rise = self._root_of_rise(point)
            if rise < goal:
                low, low_rise, nearest = step, rise, point
                if step >= bound * (1 - 1e-9):
                    return float(np.inf)
            else:
                high, high_rise = step, rise
            tolerance = CLOSE_IF_WIDE if low > WIDE else CLOSE
            if abs(rise / goal - 1) < tolerance:
                return float(step)
            if high - low < tolerance * high:
                return float(high)
            if np.isinf(high):
                growth = np.clip(1.05 * goal / max(low_rise, 1e-9) - 1, 0.3, 2.0)
                step = low + (low - start + 0.1 * spread) * growth
            else:
                step = low + (high - low) * np.clip(
                    (goal - low_rise) / (high_rise - low_rise), 0.1, 0.9
                )
        return float(high)

    def _constrained_minimum(self, number: int, value: float, near: Point) -> Point:
        """Return the best point with one parameter held at a coordinate, and record it.

        The search begins at a nearby point, shifted along the valley by the covariance.

        Raises
        ------
        BetterPointError
            if the point is better than the best one
        """
        likelihood = self.likelihood
        place = likelihood.free.index(number)
        direction = np.zeros(len(near.x))
        direction[list(likelihood.free)] = self.covariance[place] / self.covariance[place, place]
        shift = direction * (value - near.x[number])
        start = near.x + shift if np.abs(shift).max() < 1 else near.x
        point = likelihood.best_from(start, number, value, TOLERANCE)
        if point.chi_square > self.best.chi_square + self.threshold:
            # a narrow valley may bend: search from two more points before it counts as ended
            closest = min([self.best, *self.seen], key=lambda seen: abs(seen.x[number] - value))
            others = [
                likelihood.best_from(other.x, number, value, TOLERANCE) for other in (near, closest)
            ]
            point = min([point, *others], key=lambda candidate: candidate.chi_square)
        if point.chi_square < self.best.chi_square - MIN_IMPROVEMENT:
            raise BetterPointError(point)
        self.traces.setdefault(number, []).append((value, point.chi_square))
        if point.chi_square < self.best.chi_square + self.threshold:
            self.seen.append(point)
        return point

    def _root_of_rise(self, point: Point) -> float:
        return float(np.sqrt(max(point.chi_square - self.best.chi_square, 0.0)))
