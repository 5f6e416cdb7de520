"""The graded quarter disc by scikit-fem's own local refinement: no gmsh, no system library.

A coarse polar quarter disc is refined (red-green-blue) to the size field. Its contact line then holds dyadic radii
only, so the field is followed on a dyadic image of the punch and every point is moved radially at the end, by the
piecewise linear map that carries dyadic radii to ring edges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from skfem import MeshTri

from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import half_space
from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import SizeField

MOST_ROUNDS = 80


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc to the size field.

    Raises
    ------
    MeshError
        if the ring edges are too close together to be told apart on a dyadic grid
    """
    ring_edges = np.array(field.ring_edges)
    dyadic, spacing = _dyadic_image(ring_edges)
    points, triangles = _polar_quarter_disc(field.truncation)
    current = MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))
    for _ in range(MOST_ROUNDS):
        corners = _moved(current.p.T, dyadic, ring_edges)[current.t.T]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        marked = longest > 1.25 * field(corners.mean(axis=1))
        marked |= _spans_an_edge(current.p.T[current.t.T], dyadic, spacing)
        if not marked.any():
            break
        current = current.refined(np.flatnonzero(marked))
        points = _on_the_arc(current.p.T, current.boundary_nodes(), field.truncation)
        current = replace(current, doflocs=np.ascontiguousarray(points.T))
    else:
        raise MeshError("local refinement did not reach the sizes asked for: ask for larger ones, or for gmsh")
    moved = np.ascontiguousarray(_moved(current.p.T, dyadic, ring_edges).T)
    return half_space(replace(current, doflocs=moved), ring_edges)


def _dyadic_image(ring_edges: Array) -> tuple[Array, float]:
    """A dyadic radius for each edge, in order and close to it, and the spacing of that dyadic grid."""
    level = int(np.ceil(np.log2(2 / np.diff(ring_edges).min())))
    if level > 40:
        raise MeshError(f"rings narrower than 1e-12 a cannot be meshed: the narrowest is {np.diff(ring_edges).min():.2g} a")
    return np.round(ring_edges * 2.0**level) / 2.0**level, 0.5**level


def _moved(points: Array, dyadic: Array, ring_edges: Array) -> Array:
    radius = np.hypot(*points.T)
    inside = (radius > 0) & (radius < 1)
    scale = np.ones_like(radius)
    scale[inside] = np.interp(radius[inside], dyadic, ring_edges) / radius[inside]
    return points * scale[:, None]


def _spans_an_edge(corners: Array, dyadic: Array, spacing: float) -> Array:
    """Triangles on the contact line with a ring edge inside their facet, or too coarse to have it as a vertex."""
    r = np.where(corners[:, :, 1] == 0, corners[:, :, 0], np.nan)
    on_line = np.isfinite(r).sum(axis=1) == 2
    low, high = np.nanmin(r[on_line], axis=1), np.nanmax(r[on_line], axis=1)
    tolerance = spacing / 8
    inside = np.searchsorted(dyadic, high - tolerance) > np.searchsorted(dyadic, low + tolerance)
    result = np.zeros(len(corners), dtype=bool)
    result[np.flatnonzero(on_line)[inside & (low < 1)]] = True
    return result


def _on_the_arc(points: Array, boundary: Array, outer: float) -> Array:
    """Boundary points off the axis and the surface belong on the arc: put them there."""
    arc = boundary[(points[boundary, 0] > 0) & (points[boundary, 1] > 0)]
    points = points.copy()
    points[arc] *= (outer / np.hypot(*points[arc].T))[:, None]
    return points


def _polar_quarter_disc(outer: float) -> tuple[Array, Array]:
    """A few well-shaped triangles: rays at 0, 45 and 90 degrees, radii 1, then doubling up to `outer`."""
    count = max(1, round(np.log2(outer)))
    radii = outer ** (np.arange(count + 1) / count)
    angles = np.array([0.0, 0.25, 0.5]) * np.pi
    # exact zeros on the axis and the surface: boundaries are told by them
    cosine, sine = np.array([1, np.sqrt(0.5), 0]), np.array([0, np.sqrt(0.5), 1])
    points = np.concatenate([[[0.0, 0.0]], *(rho * np.stack([cosine, sine], axis=1) for rho in radii)])
    rays = len(angles)
    triangles = [(0, 1 + j, 2 + j) for j in range(rays - 1)]
    for layer in range(count):
        for j in range(rays - 1):
            a, b = 1 + layer * rays + j, 2 + layer * rays + j
            c, d = a + rays, b + rays
            triangles += [(a, c, d), (a, d, b)] if j == 0 else [(a, c, b), (b, c, d)]
    return points, np.array(triangles)
