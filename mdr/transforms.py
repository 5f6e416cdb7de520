"""The MDR transforms: pressures to line densities, and profiles to one-dimensional profiles.

`line_density` is the inverse of Eq. 7, ``q(x) = 2 int_x^a r p / sqrt(r^2 - x^2) dr``, on the
pressure space. The grid matrices are Eqs. 3 and 7 themselves for piecewise linear functions. The
integral of Eq. 7 extends to infinity and includes the jump of `q` at ``x = a``, which the paper
does not show: it gives the edge term ``q(a) / (pi sqrt(a^2 - r^2))``, which is the whole pressure
of a flat punch.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..meshes.pressure_space import PressureSpace, shapes
from ..meshes.radial import Array, Indices, exact_sum, gauss, unit_gauss

HOLE_GRADING = 1 / 3
"""Size ratio of neighbouring panels in a hole, towards its edge.

With it, ten points on each panel are right to 1e-11.
"""
EXTRA_POINTS = 8
"""Points on each panel, besides two for each degree, that integrate energies to 1e-10.

If neighbouring elements have similar sizes, the error is roundoff.
"""


def line_density(space: PressureSpace, positions: Array, low_parts: Array | None = None) -> Array:
    """Return the line density ``q(x)`` (P, size) of each pressure function at positions in (0, 1).

    Parameters
    ----------
    space : pressure space
    positions : (P,) array
    low_parts : (P,) array, optional
        Low parts (rounding errors) of the positions, which may be closer to a ring edge than the
        roundoff of its radius.
    """
    out = np.empty((len(positions), space.size))
    low_parts = np.zeros(len(positions)) if low_parts is None else low_parts
    # positions are processed in blocks, because the arrays over pairs of positions and elements
    # would be far larger than the result
    for start in range(0, len(positions), 256):
        rows = slice(start, start + 256)
        out[rows] = _rows(space, positions[rows], low_parts[rows])
    return out


def _rows(space: PressureSpace, positions: Array, low_parts: Array) -> Array:
    """Return the line densities (P, size) at a block of positions."""
    numbers = np.arange(len(space.breakpoints))
    distances = space.distance_from(positions[:, None], low_parts[:, None], numbers[None])
    out = np.zeros((len(positions), space.size + 1))
    # neighbouring positions are in the same block, so that most elements are far from all of them
    nearest = distances[:, :-1].min(axis=0)
    is_far = nearest >= space.widths / 2
    far = np.flatnonzero(is_far)
    _add_from_afar(out, space, positions, distances, far, _point_counts(space, nearest[far], far))
    _add_from_near(out, space, positions, distances, (distances[:, 1:] > 0) & ~is_far)
    return out[:, :-1]


def _add_from_afar(
    out: Array,
    space: PressureSpace,
    positions: Array,
    distances: Array,
    elements: Indices,
    point_counts: Indices,
) -> None:
    """Add the integrals over elements that are far from all positions of a block.

    Parameters
    ----------
    out : (P, size + 1) array to add to
    space, positions : the pressure space, and the positions (P,)
    distances : (P, n+1) distances from the positions to the breakpoints
    elements, point_counts : the elements, and the number of Gauss points on each
    """
    x = positions[:, None, None]
    for points in np.unique(point_counts):
        group = elements[point_counts == points]
        kernel, functions = _far_kernel(
            space, x, distances[:, group, None], group[:, None], int(points)
        )
        values = kernel @ functions
        # within a pass, each function occurs at most once
        for j in range(space.top + 1):
            out[:, space.dofs[group, j]] += values[..., j]


def _add_from_near(
    out: Array, space: PressureSpace, positions: Array, distances: Array, pairs: NDArray[np.bool_]
) -> None:
    """Add the integrals over the selected pairs (P, n) of positions and elements.

    The other arguments are those of `_add_from_afar`.
    """
    point, element = np.nonzero(pairs)
    x = positions[point]
    # distances from the position to both ends of the element; the first may be negative
    to_left, to_right = distances[point, element], distances[point, element + 1]
    is_far = to_left >= space.widths[element] / 2
    values = np.empty((len(point), space.top + 1))
    values[is_far] = _from_afar(space, x[is_far], to_left[is_far], element[is_far])
    values[~is_far] = _from_near(
        space, x[~is_far], to_left[~is_far], to_right[~is_far], element[~is_far]
    )
    # In each pass, a row and column occurs at most once. Neighbours share hats, so that the hats
    # are added one after the other.
    for j in range(space.top + 1):
        out[point, space.dofs[element, j]] += values[:, j]


def _point_counts(space: PressureSpace, to_left: Array, element: Indices) -> Indices:
    """Return the number of Gauss points in the radius that integrate far elements to roundoff.

    The larger the distance of the element, the larger is the ellipse around it in which the root is
    analytic, and the fewer points are needed.
    """
    distance_ratio = 1 + 2 * to_left / space.widths[element]
    count = (space.degrees[element] + 1 - np.log(1e-17) / np.arccosh(distance_ratio)) / 2
    return np.ceil(count).astype(np.int64)


def _from_afar(space: PressureSpace, x: Array, to_left: Array, element: Indices) -> Array:
    """Return integrals over elements at least half their width away, where the root is smooth."""
    point_counts = _point_counts(space, to_left, element)
    values = np.empty((len(x), space.top + 1))
    for points in np.unique(point_counts):
        group = np.flatnonzero(point_counts == points)
        kernel, functions = _far_kernel(
            space, x[group, None], to_left[group, None], element[group, None], int(points)
        )
        values[group] = kernel @ functions
    return values


def _far_kernel(
    space: PressureSpace, x: Array, to_left: Array, element: Indices, points: int
) -> tuple[Array, Array]:
    """Return weighted kernel values (..., points) and shape functions at them (points, top+1).

    The last axis of the arguments is that of the Gauss points.
    """
    node, functions = _weighted_shapes(points, space.top)
    half = space.widths[element] / 2
    # the gap r - x is computed as a sum, not as a difference, because elements may be as small as
    # roundoff allows
    offset = half * (1 + node)
    r, gap = space.breakpoints[element] + offset, to_left + offset
    kernel = 2 * half * r / np.sqrt(gap * (r + x))
    return kernel, functions


@lru_cache(maxsize=256)
def _weighted_shapes(points: int, top: int) -> tuple[Array, Array]:
    """Return the nodes of a Gauss rule, and weighted shape functions at them (points, top+1)."""
    node, weight = gauss(points)
    return node, weight[:, None] * shapes(node, top)


def _from_near(
    space: PressureSpace, x: Array, to_left: Array, to_right: Array, element: Indices
) -> Array:
    """Return integrals over elements that are close to x or contain it.

    With ``r = x cosh(theta)`` the integrand is entire. No difference of close numbers is formed, so
    that elements may be as small as roundoff allows.
    """
    # Numbers of Gauss points that integrate a polynomial in exp(theta) to roundoff, and the
    # thresholds of (degree x length of the interval) at which the number increases.
    reaches, gauss_points = (0.25, 1, 4, 12, 40, 100), np.array([10, 14, 20, 32, 56, 100, 200])
    # if x is inside the element, the integral begins at x; all distances are from x
    to_lower, width = np.maximum(to_left, 0.0), space.widths[element]
    lower, right = x + to_lower, x + to_right
    lower_root, upper_root = np.sqrt(to_lower * (lower + x)), np.sqrt(to_right * (right + x))
    length = to_right - to_lower
    span = np.arcsinh(length * (right + lower) / (upper_root * lower + lower_root * right))
    reach = (space.degrees[element] + 1) * span
    count = gauss_points[np.searchsorted(reaches, reach, side="right")]
    values = np.empty((len(x), space.top + 1))
    for points in np.unique(count):
        group = np.flatnonzero(count == points)
        node, weight = gauss(max(int(points), space.top + 4))
        sinh = np.sinh(span[group, None] * (1 + node) / 4)
        root, low = lower_root[group, None], lower[group, None]
        distance = 2 * sinh * (root * np.sqrt(1 + sinh**2) + low * sinh)
        radius = low + distance
        local = 2 * ((to_lower - to_left)[group, None] + distance) / width[group, None] - 1
        weighted = (radius * weight * span[group, None])[:, None, :]
        values[group] = (weighted @ shapes(local, space.top))[:, 0]
    return values


def panels_from_axis(space: PressureSpace) -> PressureSpace:
    """Return a space on [0, 1] with the elements of a space, and with elements that fill its hole.

    The line density of a hollow punch is not zero in the hole. The elements there become smaller
    towards its edge, down to the size of the first element of the face.
    """
    inner_radius, low_parts = space.inner_radius, space.sort_keys.imag
    if not inner_radius:
        return space
    smallest = min(float(space.widths[0]), inner_radius)
    hole = PressureSpace.graded([0.0, inner_radius], smallest, HOLE_GRADING, space.top)
    return PressureSpace(
        np.append(hole.breakpoints[:-1], space.breakpoints),
        np.append(hole.degrees, space.degrees),
        np.append(0.0, space.ring_edges),
        np.append(hole.sort_keys.imag[:-1], low_parts),
    )


def panel_quadrature(
    space: PressureSpace, extra_points: int = EXTRA_POINTS
) -> tuple[Array, Array, Array]:
    """Return a quadrature on (0, 1) that integrates products of line densities of the space.

    The arrays (P,) are the positions, the weights, and the low parts of the positions.

    Parameters
    ----------
    space : pressure space
    extra_points : points on each panel, besides two for each degree of the pressure

    Notes
    -----
    A line density has a square-root singularity on the left of every breakpoint, and ``x^2 log x``
    at the axis. Substituting squares at these ends makes the integrand smooth.
    """
    space = panels_from_axis(space)
    degrees = space.degrees
    # the innermost panel is singular at both ends, so that the substitution needs twice the degree
    node, weight = unit_gauss(4 * int(degrees[0]) + 2 * extra_points)
    first, folded = space.breakpoints[1], node * (2 - node)
    positions = [first * (1 - folded) * (1 + folded)]
    weights = [first * 4 * folded * (1 - node) * weight]
    low_parts: list[Array] = [np.zeros(len(node))]
    for degree in np.unique(degrees):
        node, weight = unit_gauss(2 * int(degree) + extra_points)
        panels = 1 + np.flatnonzero(degrees[1:] == degree)
        right, width = space.breakpoints[panels + 1], space.widths[panels]
        position, low = exact_sum(right[:, None], -width[:, None] * node**2)
        # the right end has its own low part
        position, low = exact_sum(position, low + space.sort_keys.imag[panels + 1][:, None])
        positions.append(position.ravel())
        low_parts.append(low.ravel())
        weights.append((width[:, None] * 2 * node * weight).ravel())
    # in the order of the radius, like the pressures
    position, weight, low = map(np.concatenate, (positions, weights, low_parts))
    order = np.argsort(position + 1j * low)
    return position[order], weight[order], low[order]


def profile_transform(radii: Array, positions: Array) -> Array:
    """Return the matrix of Eq. 3, ``g = T f``, for a profile that is linear between `radii`.

    The profile is flat inside the first radius, and continues with its last slope beyond the last.
    Positions must be positive. Eq. 3 as printed holds for ``f(0) = 0``; a centre that has worn adds
    ``f(0)`` to `g` everywhere.
    """
    cells = np.append(radii[:-1], np.inf)
    x = positions[:, None]
    angle = np.arcsin(np.clip(cells / x, 0.0, 1.0))
    by_slope = x * np.diff(angle, axis=1) / np.diff(radii)
    out = np.zeros((len(positions), len(radii)))
    out[:, 1:] += by_slope
    out[:, :-1] -= by_slope
    out[:, 0] += 1.0
    return out


def pressure_transform(positions: Array, radii: Array) -> Array:
    """Return the matrix of Eq. 7 with its edge term, ``p = S q``.

    The line density q is linear between the positions. The positions start at 0 and end at the rim;
    radii must lie strictly between.
    """
    root = np.arccosh(np.maximum(positions / radii[:, None], 1.0))
    by_slope = np.diff(root, axis=1) / np.diff(positions) / np.pi
    out = np.zeros((len(radii), len(positions)))
    out[:, 1:] -= by_slope
    out[:, :-1] += by_slope
    rim = positions[-1]
    out[:, -1] += 1 / (np.pi * np.sqrt((rim - radii) * (rim + radii)))
    return out
