"""Rigorous lower and upper bounds of the stiffness of a flat annulus ``b <= r <= 1``.

Any pressure on the annulus gives a lower bound, ``F^2 / int u p dA``. Any displacement that is 1 on
the annulus gives an upper bound, which is its energy: in the MDR, ``2 int_0^1 g^2 dx`` with the
one-dimensional displacement g of Eq. 3. In the hole the displacement may be ``1 + sqrt(b^2 - r^2)``
times any polynomial in ``r^2``. With the Legendre functions `Q` of the second kind, this gives

    g(x) = 1 + sum_j c_j Q_(2j-1)(x / b)

on both sides of ``x = b``. The outer radius and the plane strain modulus are 1.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.linalg import solve_triangular

from ringwear.mdr.energy import compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array, gauss, unit_gauss

# Number of functions of the upper bound. With them the bound equals the stiffness to roundoff up to
# b = .95, and exceeds it by 1e-11 at b = .99.
FUNCTION_COUNT = 32
# lower bound: size of the elements at both edges, relative to the width of the annulus
EDGE_SIZE = 1e-12
# lower bound: polynomial degree of the elements
DEGREE = 10
# lower bound: ratio of the sizes of neighbouring elements
RATIO = 0.15
# upper bound: number of quadrature points in each interval
POINTS = 240
# upper bound: exponent of the substitution that smooths the logarithm at x = b
POWER = 7
# argument up to which the recurrence of Legendre functions does not lose digits
RECURRENCE_LIMIT = 1.005
# number of Gauss points of the integral that replaces the recurrence at larger arguments
INTEGRAL_POINTS = 300


class Bounds(NamedTuple):
    """Lower and upper bound of the stiffness F / (E* a d)."""

    lower: float
    upper: float


@lru_cache(maxsize=16)
def stiffness_bounds(inner_radius: float) -> Bounds:
    """Return the bounds of the stiffness of an annulus with an inner radius between 0 and 1."""
    return Bounds(_lower_bound(inner_radius), _upper_bound(inner_radius))


def _lower_bound(inner_radius: float) -> float:
    """Return ``b . A^-1 b``, the greatest lower bound that pressures of a space can give.

    A is the compliance of the space, and b the forces of its basis functions.
    """
    size = EDGE_SIZE * (1 - inner_radius)
    at_hole = min(size, EDGE_SIZE * inner_radius)
    space = PressureSpace.graded([inner_radius, 1.0], [at_hole, size], RATIO, DEGREE)
    # the triangular factor is used because the compliance itself would lose the digits of small
    # elements
    factor = np.linalg.qr(compliance(space).factor, mode="r")
    half = solve_triangular(factor, space.weights, trans=1)
    return float(half @ half)


def _upper_bound(inner_radius: float) -> float:
    """Return the minimum of ``2 int_0^1 g^2 dx`` over the coefficients of g."""
    arguments, distances, weights = _quadrature(1 / inner_radius)
    root = np.sqrt(weights)
    functions = root[:, None] * _odd_legendre_q(arguments, distances, FUNCTION_COUNT)
    coefficients, *_ = np.linalg.lstsq(functions, -root, rcond=None)
    residual = root + functions @ coefficients
    return float(2 * inner_radius * residual @ residual)


def _quadrature(last: float) -> tuple[Array, Array, Array]:
    """Return a quadrature from 0 to a last argument above 1, graded to a singularity at 1.

    The three arrays (M,) are the arguments, their distances from 1, and the weights.
    """
    node, weight = unit_gauss(POINTS)
    distance, near_weights = node**POWER, POWER * node ** (POWER - 1) * weight
    reach = min(last - 1, 1.0)
    parts: list[tuple[Array, Array, Array]] = [
        (1 - distance, distance, near_weights),
        (1 + reach * distance, reach * distance, reach * near_weights),
    ]
    inner = 1 + reach
    while inner < last:
        outer = min(2 * inner, last)
        arguments = inner + (outer - inner) * node
        parts.append((arguments, arguments - 1, (outer - inner) * weight))
        inner = outer
    arguments, distances, weights = map(np.concatenate, zip(*parts, strict=True))
    return arguments, distances, weights


def _odd_legendre_q(arguments: Array, distances: Array, count: int) -> Array:
    """Return ``Q_1, Q_3, ...`` (M, count) at arguments (M,), with given distances from 1."""
    values, highest = np.empty((len(arguments), 2 * count)), 2 * count - 1
    beyond_limit = arguments > RECURRENCE_LIMIT
    node, weight = gauss(INTEGRAL_POINTS)
    values[beyond_limit] = (
        (weight / (arguments[beyond_limit, None] - node)) @ legvander(node, highest) / 2
    )
    small_arguments = arguments[~beyond_limit]
    order_zero = 0.5 * np.log((1 + small_arguments) / distances[~beyond_limit])
    recurrence = [order_zero, small_arguments * order_zero - 1]
    for order in range(1, highest):
        last, previous = recurrence[order], recurrence[order - 1]
        recurrence.append(
            ((2 * order + 1) * small_arguments * last - order * previous) / (order + 1)
        )
    values[~beyond_limit] = np.stack(recurrence, axis=1)
    return values[:, 1::2]
