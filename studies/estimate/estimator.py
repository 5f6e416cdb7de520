"""Estimate parameters by least squares: best points, covariance, combinations without effect.

The errors of the data are Gaussian, with the covariance ``C = diag(noise^2) + sum_q b_q b_q^T``:
the values of a series q have a noise each, and an error b_q in common, such as an unknown offset of
a profile, or the part of a program's error by which all of its pressures are too high. The
likelihood is described by chi-square, ``r^T C^-1 r`` for residuals r.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from ...meshes import Array, SolverError
from .measurement import Measurement
from .model import STEP, Model
from .parameter import Parameter

# factor on the reach of a parameter within which it is searched, so that a best point at the reach
# is recognised as such
SEARCH_MARGIN = 1.02
# `ftol`, `xtol` and `gtol` of the least-squares search
TOLERANCE = 1e-8
MAX_EVALUATIONS = 200
# singular value of the derivatives, scaled to length one, below which a combination of parameters
# has no effect
NO_EFFECT = 1e-6
# least component of a parameter in a combination of length one
MIN_COMPONENT = 1e-3
# least noise that is estimated, over the greatest value: exact data have none, and their residuals
# are roundoff of the model
LEAST_NOISE = 1e-9
# greatest number of iterations that estimate noises from the residuals
NOISE_ROUNDS = 4
# greatest allowed numerical error of a prediction, over the noise
MAX_NUMERICAL_ERROR = 0.1


class Point(NamedTuple):
    """Coordinates (m,) of the parameters, and chi-square there."""

    x: Array
    chi_square: float


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Measurements and predictions, in units of the noise.

    n is the number of measured values, m the number of parameters, f the number of free ones.

    Parameters
    ----------
    predictor : the model, with the measurements and their noise
    parameters : m parameters
    free : indices of the parameters that are fitted; the others keep the values of the scene
    """

    predictor: Model
    parameters: tuple[Parameter, ...]
    free: tuple[int, ...]

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """The measurements."""
        return self.predictor.measurements

    @cached_property
    def noise(self) -> Array:
        """(n,) standard deviations of all values."""
        return np.concatenate([each.noise for each in self.measurements])

    @cached_property
    def values(self) -> Array:
        """(n,) measured values over the noise; 0 for missing ones."""
        values = np.concatenate([each.values for each in self.measurements])
        # missing values have an infinite noise
        return np.where(np.isfinite(self.noise), values, 0.0) / self.noise

    @cached_property
    def common(self) -> tuple[Array, Array]:
        """The common errors: orthonormal columns (n, o), and the parts (o,) that are removed.

        With the deviation b of a common error along the unit vector e, ``C^-1/2`` in units of the
        noise is ``1 - (1 - 1 / sqrt(1 + b^2)) e e^T``: a projection if b is infinite.
        """
        columns, parts = [], []
        for each in self.measurements:
            error, deviation = each.common_error
            length = float(np.linalg.norm(error)) or 1.0
            columns.append(error[:, None] / length)
            parts.append(1 - 1 / np.sqrt(1 + (deviation * length) ** 2))
        return block_diag(*columns), np.array(parts)

    def split(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Return the parts of values (n,) that belong to each measurement."""
        return np.split(values, np.cumsum([len(each.values) for each in self.measurements])[:-1])

    @property
    def offsets(self) -> Array:
        """(n, o) orthonormal columns of the offsets of which nothing is known."""
        columns, parts = self.common
        return columns[:, parts == 1]

    @property
    def degrees_of_freedom(self) -> int:
        """Number of measured values, minus the numbers of offsets and of free parameters."""
        return len(self.noise) - self.offsets.shape[1] - len(self.free)

    def whitened(self, values: Array) -> Array:
        """Return values (n, ...) in units of the noise, multiplied by the root of ``C^-1``."""
        columns, parts = self.common
        return values - (columns * parts) @ (columns.T @ values)

    def residuals(self, x: Array) -> Array:
        """Return measured minus predicted values (n,) at coordinates (m,), over the noise."""
        predicted = np.concatenate(self.predictor.predict(x)) / self.noise
        return self.whitened(self.values - predicted)

    def slopes(
        self, x: Array, numbers: Sequence[int] | None = None, backward: float = STEP
    ) -> Array:
        """Return the derivatives (n, k) by parameters, over the noise.

        Parameters
        ----------
        x : (m,) coordinates
        numbers : indices of k parameters; by default those of the free ones
        backward : step behind x; 0 for differences ahead, which are accurate enough for a search

        Raises
        ------
        SolverError
            if they are not finite
        """
        directions = np.eye(len(x))[list(self.free if numbers is None else numbers)]
        columns = [
            self.residuals(x - backward * each) - self.residuals(x + STEP * each)
            for each in directions
        ]
        return _finite(np.reshape(columns, (len(directions), -1)).T / (STEP + backward))

    def best_from(
        self,
        start: Array,
        fixed: int | None = None,
        value: float = 0.0,
        tolerance: float = TOLERANCE,
        evaluations: int = MAX_EVALUATIONS,
    ) -> Point:
        """Return the local minimum of chi-square that is reached from a start (m,).

        Parameters
        ----------
        fixed : index of a parameter that is held at a coordinate, if any
        value : that coordinate
        tolerance : relative change of chi-square at which the search ends
        evaluations : greatest number of evaluations
        """
        x, varied = start.copy(), [number for number in self.free if number != fixed]
        if fixed is not None:
            x[fixed] = value
        if not varied:
            return Point(x, float(np.sum(self.residuals(x) ** 2)))

        def moved(values: Array) -> Array:
            """Return coordinates (m,) with other values of those that are varied."""
            x[varied] = values
            return x.copy()

        reach = SEARCH_MARGIN * np.array([self.parameters[number].reach for number in varied])
        found = least_squares(
            lambda values: _finite(self.residuals(moved(values))),
            np.clip(x[varied], -reach, reach),
            lambda values: -self.slopes(moved(values), varied, 0.0),
            bounds=(-reach, reach),
            x_scale="jac",
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=evaluations,
        )
        return Point(moved(found.x), float(2 * found.cost))

    def covariance(self, x: Array) -> Array:
        """Return the covariance (f, f) of the free parameters, by the curvature at a point."""
        return inverse_of_information(self.slopes(x))

    def with_noise(self, factors: Sequence[float]) -> "Likelihood":
        """Return the likelihood with the noise of each measurement multiplied by a factor."""
        scaled = tuple(
            replace(each, noise=factor * each.noise)
            for each, factor in zip(self.measurements, factors, strict=True)
        )
        return replace(self, predictor=self.predictor.for_measurements(scaled))


def _finite(values: Array) -> Array:
    """Return residuals or derivatives that are finite; otherwise raise a `SolverError`."""
    if not np.isfinite(values).all():
        raise SolverError("its results are not finite")
    return values


def inverse_of_information(slopes: Array) -> Array:
    """Return the inverse (f, f) of ``J^T J`` for derivatives J (n, f), which may be near singular.

    Small singular values of J, scaled to columns of length one, are raised to 1e-12.
    """
    lengths = np.linalg.norm(slopes, axis=0)
    lengths = np.where(lengths > 0, lengths, 1.0)
    _, singular, right = np.linalg.svd(slopes / lengths, full_matrices=False)
    scaled = right.T / np.maximum(singular, 1e-12)
    return (scaled @ scaled.T) / np.outer(lengths, lengths)


def fix_ineffective_parameters(likelihood: Likelihood) -> tuple[Likelihood, list[tuple[int, ...]]]:
    """Fix parameters so that each combination of the free ones has an effect.

    If a combination of parameters has no effect on the predictions, one parameter of it is held at
    its value in the scene: an unknown of the rig if there is one.

    Returns
    -------
    likelihood : all combinations of its free parameters have an effect
    combinations : indices of the parameters in each combination without effect; the last parameter
        of each is the one that is held
    """
    combinations = list[tuple[int, ...]]()
    while likelihood.free:
        slopes = likelihood.slopes(np.zeros(len(likelihood.parameters)))
        lengths = np.linalg.norm(slopes, axis=0)
        greatest = max(float(lengths.max()), np.finfo(float).tiny)
        if (ineffective := np.flatnonzero(lengths <= 1e-14 * greatest)).size:
            combination = [likelihood.free[int(ineffective[0])]]
        else:
            _, singular, right = np.linalg.svd(slopes / lengths, full_matrices=True)
            if len(singular) == len(lengths) and singular[-1] > NO_EFFECT:
                break
            components = np.flatnonzero(np.abs(right[-1]) > MIN_COMPONENT)
            combination = [likelihood.free[int(component)] for component in components]
        # unknowns of the rig last
        combination.sort(key=lambda number: not likelihood.parameters[number].logarithmic)
        combinations.append(tuple(combination))
        free = tuple(number for number in likelihood.free if number != combination[-1])
        likelihood = replace(likelihood, free=free)
    return likelihood, combinations


def with_estimated_noise(likelihood: Likelihood, best: Point) -> Likelihood:
    """Return the likelihood with unknown noises estimated from the residuals.

    Each column of the data has one noise.

    Parameters
    ----------
    best : the best point with the initial noises
    """
    if all(each.noise_known for each in likelihood.measurements):
        return likelihood
    columns = np.repeat(
        [each.column for each in likelihood.measurements],
        [len(each.values) for each in likelihood.measurements],
    )
    for _ in range(NOISE_ROUNDS):
        residuals, factors = likelihood.residuals(best.x), []
        # the fitted numbers are divided among the columns in proportion to their values
        freedom_per_value = max(likelihood.degrees_of_freedom, 1) / len(residuals)
        for each in likelihood.measurements:
            own = columns == each.column
            scale = float(np.sqrt(np.mean(residuals[own] ** 2) / freedom_per_value))
            least = LEAST_NOISE * float(np.abs(likelihood.values[own]).max())
            factors.append(1.0 if each.noise_known else max(scale, least, 1e-12))
        likelihood = likelihood.with_noise(factors)
        best = likelihood.best_from(best.x)
        if all(abs(factor - 1) < 1e-2 for factor in factors):
            break
    return likelihood
