"""Orders of convergence, Richardson's limit and the grid convergence index of some levels.

If values follow ``v + c h^p``, three levels determine the order p, Richardson's limit v, and
Roache's grid convergence index [1], which is 1.25 times the distance of the finest value from that
limit. A program can report this index as its error estimate without knowing the exact value. More
levels give p by least squares, with an interval.

[1] Roache: Perspective: a method for uniform reporting of grid refinement studies, J. Fluids Eng.
116 (1994), doi 10.1115/1.2910291.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import stdtrit

from ...meshes import Array

INDEX_SAFETY_FACTOR = 1.25
"""Safety factor of the grid convergence index if three levels determine the order (Roache [1])."""
LOWEST_ORDER, HIGHEST_ORDER = 0.05, 20.0
"""Bounds of the search for an order."""
CONFIDENCE = 0.95
"""Confidence level of the interval of an observed order, for normally distributed scatter."""


class Fitted(NamedTuple):
    """An order of convergence, and the ends of its `CONFIDENCE` interval; NaN if undetermined."""

    order: float = np.nan
    low: float = np.nan
    high: float = np.nan


def slope(x: Array, y: Array) -> Fitted:
    """Return the slope of a line by least squares through points (n,), with its interval.

    The interval is that of Student's distribution; two points have none.
    """
    if len(x) < 2 or not np.ptp(x):
        return Fitted()
    if len(x) < 3:
        return Fitted(float(np.diff(y)[0] / np.diff(x)[0]))
    (fitted, _), covariance = np.polyfit(x, y, 1, cov=True)
    half = stdtrit(len(x) - 2, (1 + CONFIDENCE) / 2) * np.sqrt(covariance[0, 0])
    return Fitted(float(fitted), float(fitted - half), float(fitted + half))


def order_of_errors(sizes: Array, errors: Array) -> Fitted:
    """Return the order of errors (n,): the slope of their logarithm over that of the sizes (n,)."""
    usable = (errors > 0) & np.isfinite(errors)
    return slope(np.log(sizes[usable]), np.log(errors[usable]))


def orders_between(sizes: Array, errors: Array) -> Array:
    """Return the orders (n-1,) of errors (n,) between neighbouring levels of the sizes (n,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.diff(np.log(errors)) / np.diff(np.log(sizes))


def order_of_changes(sizes: Array, changes: Array) -> Fitted:
    """Return the order of values from the sizes (n-1,) of their changes from level to level.

    The changes of ``v + c h^p`` are ``c (h_i^p - h_(i+1)^p)``. Their logarithms are fitted by least
    squares; three levels are fitted exactly, whatever the ratios of their sizes (n,).
    """
    if len(changes) < 2 or not (np.isfinite(changes) & (changes > 0)).all():
        return Fitted()
    logarithms = np.log(changes)

    def of_powers(order: float) -> Array:
        return np.log(sizes[:-1] ** order - sizes[1:] ** order)

    def scatter(order: float) -> float:
        residuals = logarithms - of_powers(order)
        return float(np.sum((residuals - residuals.mean()) ** 2))

    bounds = LOWEST_ORDER, HIGHEST_ORDER
    order = float(minimize_scalar(scatter, bounds=bounds, options={"xatol": 1e-10}).x)
    if min(order - LOWEST_ORDER, HIGHEST_ORDER - order) < 1e-3:
        return Fitted()
    step = 1e-4 * order
    derivative = (of_powers(order + step) - of_powers(order - step)) / (2 * step)
    # of a linear model of the logarithms about this order
    further = slope(derivative, logarithms - of_powers(order))
    half = (further.high - further.low) / 2
    return Fitted(order, order - half, order + half)


def order_of_three(sizes: Array, changes: Array) -> float:
    """Return the order that two changes (2,) between three levels determine; NaN if none does.

    The changes have signs if they are those of a single number.
    """
    previous, last = changes

    def misfit(order: float) -> float:
        powers = sizes**order
        return float((powers[0] - powers[1]) * last - (powers[1] - powers[2]) * previous)

    if not np.isfinite(changes).all() or misfit(LOWEST_ORDER) * misfit(HIGHEST_ORDER) >= 0:
        return np.nan
    return float(brentq(misfit, LOWEST_ORDER, HIGHEST_ORDER))


def weight_of_limit(sizes: Array, order: float) -> float:
    """Return the distance of the finest value from Richardson's limit, over the last change."""
    return float(1 / ((sizes[-2] / sizes[-1]) ** order - 1))


def richardson(
    sizes: Array,
    errors: Array,
    changes: Array | None = None,
    error_of_limit: Callable[[float], float] | None = None,
) -> tuple[float, float]:
    """Return the error of Richardson's limit and the grid convergence index, both relative.

    Both are NaN for fewer than three levels, and if the last three levels do not converge
    monotonically.

    Parameters
    ----------
    sizes, errors : (n,) of the levels, from coarse to fine; errors are relative and have signs
    changes : (n-1,) relative norms of the differences between levels, if the errors are norms,
        which have no sign
    error_of_limit : function of w that returns the relative error of the field
        ``finest + w * (finest - second finest)``, for norms
    """
    undetermined = np.nan, np.nan
    if len(sizes) < 3 or not np.isfinite(errors[-3:]).all():
        return undetermined
    sizes, errors = sizes[-3:], errors[-3:]
    changes = errors[:-1] - errors[1:] if changes is None else changes[-2:]
    order = order_of_three(sizes, changes)
    if np.isnan(order):
        return undetermined
    weight = weight_of_limit(sizes, order)
    distance = weight * changes[-1]
    if error_of_limit is not None:
        return error_of_limit(weight), float(INDEX_SAFETY_FACTOR * distance)
    index = INDEX_SAFETY_FACTOR * abs(distance) / (1 + errors[2])
    return float(errors[2] - distance), float(index)
