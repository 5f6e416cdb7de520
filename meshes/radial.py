"""Ring edges, the graded radial mesh between them, and Gauss rules on its elements.

The radius of the punch is 1.
"""

import itertools
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating]
Indices = NDArray[np.int64]


def alternating_edges(count: int, width_ratio: float = 1.0) -> Array:
    """Return the edges of `count` rings on [0, 1] whose widths alternate as h1, h2, h1, ...

    The ratio is ``h2/h1 = width_ratio``.
    """
    widths = np.where(np.arange(count) % 2 == 0, 1.0, width_ratio)
    ring_edges = np.concatenate([[0.0], np.cumsum(widths)])
    return ring_edges / ring_edges[-1]


def from_axis(ring_edges: ArrayLike) -> Array:
    """Return ring edges that begin at 0: in front of the edge of a hole, the axis is added."""
    return np.union1d(0.0, np.asarray(ring_edges, dtype=float))


def ring_areas(ring_edges: ArrayLike) -> Array:
    """Return the area of each ring, ``pi (r_o^2 - r_i^2)``, to all digits for narrow rings."""
    ring_edges = np.asarray(ring_edges, dtype=float)
    return np.pi * np.diff(ring_edges) * (ring_edges[1:] + ring_edges[:-1])


def ring_of(ring_edges: Array, radii: ArrayLike) -> Indices:
    """Return the number of the ring at each radius, counted from 0.

    A radius on an edge belongs to the ring outside it, the rim to the last.
    """
    return np.clip(np.searchsorted(ring_edges, radii, side="right") - 1, 0, len(ring_edges) - 2)


def values_on_rings(
    ring_edges: Array, ring_values: ArrayLike, radii: Array, ring: Indices
) -> Array:
    """Return the values of a function given on rings, at radii of known rings.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges
    ring_values : constant of each ring (N,), one constant for all, or values (2, N) at the inner
        and outer edge of each ring, with linear interpolation between them
    radii : radii at which the function is evaluated
    ring : number of the ring of each radius
    """
    inner, outer = np.broadcast_to(ring_values, (2, len(ring_edges) - 1))[:, ring]
    fraction = (radii - ring_edges[ring]) / (ring_edges[ring + 1] - ring_edges[ring])
    return inner + (outer - inner) * fraction


def graded_breakpoints(
    ring_edges: ArrayLike, sizes: ArrayLike, factor: float, axis_size: float | None = None
) -> tuple[Array, Array]:
    """Return element boundaries whose distances shrink by `factor` towards every edge.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to the rim
    sizes : approximate size of the smallest elements at edges, one size for all, or (M,) one for
        each edge except the axis; that of the rim is the last
    factor : ratio of the sizes of neighbouring elements, below 1
    axis_size : approximate size of the smallest elements at the axis; by default a ring that begins
        at the axis is refined towards its outer edge only, because fields that are smooth in
        ``r^2`` need no refinement at the axis

    Returns
    -------
    boundaries, low parts : (n+1,) each
        The low part is the rounding error of the boundary. With it, elements beside an edge can be
        far narrower than the roundoff of its radius.
    """
    ring_edges = np.asarray(ring_edges, dtype=float)
    count = int(np.count_nonzero(ring_edges))
    at_edges = np.broadcast_to(np.asarray(sizes, dtype=float), count)
    rounded, low_parts, at_inner = [], [], axis_size
    if ring_edges[0] > 0:
        at_inner, at_edges = at_edges[0], at_edges[1:]
    for (inner, outer), at_outer in zip(itertools.pairwise(ring_edges), at_edges, strict=True):
        # the layers of both edges end in the middle of the ring
        span = (outer - inner) / (1 if at_inner is None else 2)
        from_inner = np.zeros(1)
        from_outer = layers(span, at_outer, factor)
        if at_inner is None:
            # the outermost boundary of the layers is the centre itself
            from_outer = from_outer[1:]
        else:
            from_inner = np.append(from_inner, layers(span, at_inner, factor)[:0:-1])
        for edge, distances in ((inner, from_inner), (outer, -from_outer)):
            boundaries, low = exact_sum(edge, distances)
            rounded.append(boundaries)
            low_parts.append(low)
        at_inner = at_outer
    return np.concatenate([*rounded, ring_edges[-1:]]), np.concatenate([*low_parts, np.zeros(1)])


def exact_sum(first: ArrayLike, second: ArrayLike) -> tuple[Array, Array]:
    """Return the rounded sum of two arrays, and its rounding error (Knuth)."""
    first, second = np.broadcast_arrays(np.asarray(first, float), np.asarray(second, float))
    rounded = first + second
    second_as_added = rounded - first
    return rounded, (first - (rounded - second_as_added)) + (second - second_as_added)


def layers(span: float, smallest: float, factor: float) -> Array:
    """Return the distances of the boundaries of graded layers from a singular point.

    The distances are `span`, `span * factor`, ... down to about `smallest`.
    """
    count = max(0, round(np.log(max(smallest, 1e-300) / span) / np.log(factor)))
    return span * factor ** np.arange(count + 1.0)


def layer_degrees(
    breakpoints: Array, ring_edges: ArrayLike, degree: int, rise: float, lowest: int = 1
) -> Indices:
    """Return the degree of each element.

    The degree is `lowest` at ring edges and rim, and increases by `rise` per element up to
    `degree`.
    """
    index = np.arange(len(breakpoints) - 1)
    ring_edges = np.asarray(ring_edges, dtype=float)
    # a mark at the axis is far from every element, because degrees do not fall towards the axis
    marks = np.where(ring_edges > 0, np.searchsorted(breakpoints, ring_edges), -len(index))
    next_mark = np.searchsorted(marks, index, side="right")
    layer = np.minimum(marks[next_mark] - 1 - index, index - marks[next_mark - 1])
    return np.minimum(degree, lowest + np.floor(rise * layer).astype(np.int64))


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on (-1, 1), which are cached and must not be modified."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return node, weight


def unit_gauss(count: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on (0, 1).

    They are used after substitutions that remove a singularity at one end.
    """
    node, weight = gauss(count)
    return (1 + node) / 2, weight / 2
