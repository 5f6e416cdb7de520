"""The likelihood of measurements with Gaussian noise: its best point, and what is never known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ....meshes.radial import Array
from ..measurement import Measurement, Predictor
from ..parameters import Parameter

# the search may leave the reach of a parameter by this, so that what lies on it is seen
BEYOND = 1.02
TOLERANCE = 1e-8
MOST_EVALUATIONS = 200
# of singular values of derivatives of length one: below it, a combination has no effect
NO_EFFECT = 1e-6
# part of a combination from which on a parameter takes part in it
PART = 1e-3
# starting points, and how far logarithms of all but the first are scattered
STARTS, SCATTER = 4, 1.2
# rounds in which noises that are not given are taken from the residuals
NOISE_ROUNDS = 4


class Point(NamedTuple):
    """Coordinates (m,) of the parameters, and chi-square there."""

    x: Array
    chi_square: float


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Measurements beside what a model predicts, in units of their noise.

    Unknown offsets of profiles are projected out, exactly.

    Parameters
    ----------
    predictor : the model, and its measurements with their noise
    parameters : m of them
    free : numbers of those that are sought; the others stay where the scene has them
    """

    predictor: Predictor
    parameters: tuple[Parameter, ...]
    free: tuple[int, ...]

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """What has been measured."""
        return self.predictor.measurements

    @cached_property
    def noise(self) -> Array:
        """(n,) standard deviations of all values."""
        return np.concatenate([each.noise for each in self.measurements])

    @cached_property
    def _values(self) -> Array:
        return np.concatenate([each.values for each in self.measurements]) / self.noise

    @cached_property
    def offsets(self) -> Array:
        """(n, o) orthonormal columns that unknown offsets take up."""
        columns, row = [], 0
        for each in self.measurements:
            if each.has_offset:
                column = np.zeros(len(self.noise))
                column[row : row + len(each.values)] = 1 / each.noise
                columns.append(column / np.linalg.norm(column))
            row += len(each.values)
        return np.array(columns).T if columns else np.zeros((len(self.noise), 0))

    @property
    def degrees_of_freedom(self) -> int:
        """Numbers that are measured, less what is fitted."""
        return len(self.noise) - self.offsets.shape[1] - len(self.free)

    def without_offsets(self, values: Array) -> Array:
        """Return values (n, ...) in units of noise less what offsets take up."""
        return np.asarray(values - self.offsets @ (self.offsets.T @ values))

    def residuals(self, x: Array) -> Array:
        """Return what is measured less what is predicted at coordinates (m,), over the noise."""
        predicted = np.concatenate(self.predictor.predict(x)) / self.noise
        return self.without_offsets(self._values - predicted)

    def all_slopes(self, x: Array) -> Array:
        """Return the derivatives (n, m) of what is predicted, over the noise."""
        slopes = np.concatenate(self.predictor.slopes(x)) / self.noise[:, None]
        return self.without_offsets(slopes)

    def slopes(self, x: Array) -> Array:
        """Return the derivatives (n, f) by the parameters that are sought."""
        return self.all_slopes(x)[:, self.free]

    def best_from(
        self,
        start: Array,
        held: int | None = None,
        value: float = 0.0,
        tolerance: float = TOLERANCE,
    ) -> Point:
        """Return the nearest best point from a start (m,), if wanted with one parameter held.

        Parameters
        ----------
        held : number of the parameter that is held at a value
        tolerance : relative change of chi-square at which the search ends
        """
        x, moving = start.copy(), [number for number in self.free if number != held]
        if held is not None:
            x[held] = value

        def placed(coordinates: Array) -> Array:
            place = x.copy()
            place[moving] = coordinates
            return place

        if not moving:
            return Point(x, float(np.sum(self.residuals(x) ** 2)))
        reach = BEYOND * np.array([self.parameters[number].reach for number in moving])
        found = least_squares(
            lambda coordinates: -self.residuals(placed(coordinates)),
            np.clip(x[moving], -reach, reach),
            lambda coordinates: self.all_slopes(placed(coordinates))[:, moving],
            bounds=(-reach * (1 + 1e-9), reach * (1 + 1e-9)),
            x_scale="jac",
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=MOST_EVALUATIONS,
        )
        return Point(placed(found.x), float(2 * found.cost))

    def starts(self, count: int) -> list[Array]:
        """Return starting points: the values of the scene, and logarithms scattered about them."""
        random = np.random.default_rng(0)
        logarithmic = np.array([parameter.logarithmic for parameter in self.parameters])
        scattered = random.normal(0.0, SCATTER, (count - 1, len(self.parameters))) * logarithmic
        return [np.zeros(len(self.parameters)), *scattered]

    def covariance(self, x: Array) -> Array:
        """Return the covariance (f, f) of what is sought, by the curvature at a point."""
        return inverse_of(self.slopes(x))

    def with_noise(self, factors: Sequence[float]) -> "Likelihood":
        """Return it with the noise of each measurement times a factor."""
        scaled = tuple(
            each.scaled(factor) for each, factor in zip(self.measurements, factors, strict=True)
        )
        return replace(self, predictor=self.predictor.measuring(scaled))


def inverse_of(slopes: Array) -> Array:
    """Return the inverse of ``J^T J``, which may be all but singular."""
    lengths = np.linalg.norm(slopes, axis=0)
    lengths = np.where(lengths > 0, lengths, 1.0)
    _, singular, right = np.linalg.svd(slopes / lengths, full_matrices=False)
    scaled = right.T / np.maximum(singular, 1e-12)
    return np.asarray((scaled @ scaled.T) / np.outer(lengths, lengths))


def without_effect(likelihood: Likelihood) -> tuple[Likelihood, list[tuple[int, ...]]]:
    """Return the likelihood without parameters that no data can tell, and those they go with.

    Of each combination of parameters that has no effect on what is predicted one is held where the
    scene has it, an unknown of the rig if there is one.

    Returns
    -------
    likelihood : in which what is sought has an effect
    combinations : the numbers of the parameters of each; the last one of each is held
    """
    combinations = list[tuple[int, ...]]()
    while likelihood.free:
        slopes = likelihood.slopes(np.zeros(len(likelihood.parameters)))
        lengths = np.linalg.norm(slopes, axis=0)
        greatest = max(float(lengths.max()), np.finfo(float).tiny)
        if (silent := np.flatnonzero(lengths <= 1e-14 * greatest)).size:
            taking = [likelihood.free[int(silent[0])]]
        else:
            _, singular, right = np.linalg.svd(slopes / lengths, full_matrices=True)
            if len(singular) == len(lengths) and singular[-1] > NO_EFFECT:
                break
            parts = np.flatnonzero(np.abs(right[-1]) > PART)
            taking = [likelihood.free[int(part)] for part in parts]
        # unknowns of the rig last
        taking.sort(key=lambda number: not likelihood.parameters[number].logarithmic)
        combinations.append(tuple(taking))
        free = tuple(number for number in likelihood.free if number != taking[-1])
        likelihood = replace(likelihood, free=free)
    return likelihood, combinations


def best_points(likelihood: Likelihood, count: int = STARTS) -> list[Point]:
    """Return the best points from several starts, the best of all first."""
    points = [likelihood.best_from(start) for start in likelihood.starts(count)]
    return sorted(points, key=lambda point: point.chi_square)


def with_estimated_noise(likelihood: Likelihood, points: list[Point]) -> Likelihood:
    """Return the likelihood with the noises that are not given, taken from the residuals.

    Each column has one; the points are those of the noises that are taken first.
    """
    if all(each.noise_known for each in likelihood.measurements):
        return likelihood
    best = points[0]
    for _ in range(NOISE_ROUNDS):
        columns = [each.column for each in likelihood.measurements]
        residuals, row = likelihood.residuals(best.x), 0
        sums, counts = dict[str, float](), dict[str, int]()
        for each in likelihood.measurements:
            part = residuals[row : row + len(each.values)]
            sums[each.column] = sums.get(each.column, 0.0) + float(part @ part)
            counts[each.column] = counts.get(each.column, 0) + len(part)
            row += len(part)
        # what is fitted is shared among the columns by their numbers
        left = max(likelihood.degrees_of_freedom, 1) / len(residuals)
        factors = {
            column: 1.0 if known else max(np.sqrt(sums[column] / (counts[column] * left)), 1e-12)
            for column, known in zip(
                columns, [each.noise_known for each in likelihood.measurements], strict=True
            )
        }
        likelihood = likelihood.with_noise([factors[column] for column in columns])
        best = likelihood.best_from(best.x)
        if all(abs(factor - 1) < 1e-2 for factor in factors.values()):
            break
    return likelihood
