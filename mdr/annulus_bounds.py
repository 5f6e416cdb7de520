"""Two-sided bounds of the stiffness of a flat annulus ``b <= r <= 1``: nothing may violate them.

Any pressure on the annulus gives a lower bound, ``F^2 / int u p dA``. Any displacement that is 1 on
the annulus gives an upper bound, the energy that it takes: in the MDR, ``2 int_0^1 g^2 dx`` with
the one-dimensional displacement g of Eq. 3. In the hole the displacement may be ``1 + sqrt(b^2 -
r^2)`` times any polynomial in ``r^2``; then, with the Legendre functions `Q` of the second kind,

    g(x) = 1 + sum_j c_j Q_(2j-1)(x / b)

on both sides of ``x = b``. The outer radius and the plane strain modulus are 1.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.linalg import solve_triangular

from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, exact_graded_breakpoints, gauss, unit_gauss
from .energy import compliance

# functions of the upper bound; with them it is the stiffness to roundoff up to b = .95, and 1e-11
# above it at .99
FUNCTIONS = 32
# of the lower bound: size of the elements at both edges, over the width of the annulus, their
# degree, and the ratio of neighbouring sizes
EDGE_SIZE, DEGREE, RATIO = 1e-12, 10, 0.15
# of the quadrature of the upper bound: points in an interval, and the power that flattens the
# logarithm at x = b
POINTS, POWER = 240, 7
# argument up to which the recurrence of Legendre functions keeps its digits, and the points by
# which they are integrated beyond it
NEAR, MANY_POINTS = 1.005, 300


class Bounds(NamedTuple):
    """What a stiffness F / (E* a d) lies between."""

    lower: float
    upper: float


@lru_cache(maxsize=16)
def stiffness_bounds(inner_radius: float) -> Bounds:
    """Return the bounds of the stiffness of an annulus with an inner radius below 1."""
    return Bounds(_lower_bound(inner_radius), _upper_bound(inner_radius))


def _lower_bound(inner_radius: float) -> float:
    """Return ``b . A^-1 b``: no pressure of the space takes less energy."""
    edges, size = np.array([0.0, inner_radius, 1.0]), EDGE_SIZE * (1 - inner_radius)
    at_hole = min(size, EDGE_SIZE * inner_radius)
    breakpoints, low_parts = exact_graded_breakpoints(edges, [at_hole], size, RATIO)
    degrees = np.where(breakpoints[1:] <= inner_radius, 0, DEGREE)
    space = PressureSpace(breakpoints, degrees, edges, low_parts)
    # by the triangular factor: the compliance itself would lose the digits of small elements
    factor = np.linalg.qr(compliance(space).factor, mode="r")
    half = solve_triangular(factor, space.weights, trans=1)
    return float(half @ half)


def _upper_bound(inner_radius: float) -> float:
    """Return the least ``2 int_0^1 g^2 dx``."""
    arguments, apart, weights = _quadrature(1 / inner_radius)
    root = np.sqrt(weights)
    functions = root[:, None] * _odd_legendre_q(arguments, apart, FUNCTIONS)
    chosen, *_ = np.linalg.lstsq(functions, -root, rcond=None)
    left = root + functions @ chosen
    return float(2 * inner_radius * left @ left)


def _quadrature(last: float) -> tuple[Array, Array, Array]:
    """Return arguments (M,) from 0 to a last one above 1, their distances from 1, and weights."""
    node, weight = unit_gauss(POINTS)
    near, flattened = node**POWER, POWER * node ** (POWER - 1) * weight
    reach = min(last - 1, 1.0)
    parts = [(1 - near, near, flattened), (1 + reach * near, reach * near, reach * flattened)]
    inner = 1 + reach
    while inner < last:
        outer = min(2 * inner, last)
        arguments = inner + (outer - inner) * node
        parts.append((arguments, arguments - 1, (outer - inner) * weight))
        inner = outer
    arguments, apart, weights = map(np.concatenate, zip(*parts, strict=True))
    return arguments, apart, weights


def _odd_legendre_q(arguments: Array, apart: Array, count: int) -> Array:
    """Return ``Q_1, Q_3, ...`` (M, count) at arguments (M,), given their distances from 1, too."""
    values, highest = np.empty((len(arguments), 2 * count)), 2 * count - 1
    far = arguments > NEAR
    node, weight = gauss(MANY_POINTS)
    values[far] = (weight / (arguments[far, None] - node)) @ legvander(node, highest) / 2
    near = arguments[~far]
    below = 0.5 * np.log((1 + near) / apart[~far])
    recurrence = [below, near * below - 1]
    for order in range(1, highest):
        last, before = recurrence[order], recurrence[order - 1]
        recurrence.append(((2 * order + 1) * near * last - order * before) / (order + 1))
    values[~far] = np.stack(recurrence, axis=1)
    return values[:, 1::2]
