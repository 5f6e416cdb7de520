"""Sequences of graded meshes: base triangles, subdivided into triangles or quadrilaterals.

Points are complex numbers, radius and depth. Subdivision is in log-polar coordinates, the complex
logarithm, about the rim, about every ring edge and far away: in these a graded mesh is uniform.
Halved in plain coordinates, it approaches its order from below by a term in h; in these by h^2.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh, MeshQuad, MeshTri

from ...meshes import bisection
from ...meshes.by_gmsh import triangles
from ...meshes.errors import MeshError
from ...meshes.half_space import as_half_space
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField
from .core import FLAT

Points = NDArray[np.complex128]

LOG_POLAR = 0.6
"""Reach of log-polar coordinates about an edge and beyond the rim, over the radius of the edge."""
BETWEEN_EDGES = 0.45
"""The same over the distance to the next edge: neighbours do not overlap."""


@cache
def triangulated(field: SizeField) -> MeshTri:
    """Mesh the quarter disc by gmsh, or by bisection where gmsh cannot."""
    try:
        return triangles.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(
    mesh: MeshTri,
    count: int,
    ring_edges: Array = FLAT,
    into_quads: bool = False,
    log_polar: bool = True,
) -> Mesh:
    """Divide every triangle into ``count^2`` triangles, or into ``3 count^2`` quadrilaterals.

    Neighbours compute the points between them from the same numbers in the same order, and so agree
    on every digit.

    Parameters
    ----------
    mesh : triangles of the quarter disc, each ring edge a vertex
    count : parts of each side of a triangle, or of each half of it
    ring_edges : (N+1,) ring edges, 0 first and 1 (the rim) last
    into_quads : whether each triangle becomes three quadrilaterals, which meet at its middle
    log_polar : whether the division is in log-polar coordinates about the rim, about every ring
        edge and far away; it is in plain ones between them, or everywhere

    Raises
    ------
    MeshError
        if an element is degenerate
    """
    weight, cells = (_weights_of_quads if into_quads else _weights_of_triangles)(count)
    vertices, corners = mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None]
    if log_polar:
        points = interpolate(vertices, corners, weight, ring_edges)
    else:
        points = _interpolate_plainly(vertices, corners, weight)
    unique, number = np.unique(points, return_inverse=True)
    fine = number.reshape(points.shape)[:, cells.T].reshape(-1, len(cells))
    kind = MeshQuad if into_quads else MeshTri
    divided = kind(np.stack([unique.real, unique.imag]), np.ascontiguousarray(fine.T))
    return as_half_space(divided, ring_edges)


def _weights_of_triangles(count: int) -> tuple[Array, Indices]:
    """Return barycentric weights (l, 3) of points in a triangle, and its parts (3, count^2)."""
    square = MeshTri.init_tensor(*2 * [np.arange(count + 1.0)])
    half = square.restrict(np.subtract(*square.p[:, square.t].mean(axis=1)) > 0)
    weight = np.stack([count - half.p[0], half.p[0] - half.p[1], half.p[1]], axis=1) / count
    return weight, half.t


def _weights_of_quads(count: int) -> tuple[Array, Indices]:
    """Return barycentric weights (l, 3) of points in a triangle, and its parts (4, 3 count^2).

    Each corner of the triangle is a corner of one of the three quadrilaterals that are divided.
    """
    square = MeshQuad.init_tensor(*2 * [np.arange(count + 1.0)])
    i, j = square.p
    # of the corner opposite the first side, and so on, times 6 count^2: integers, so that points
    # on a side have the same weights from both of its triangles
    second, third = 3 * i * (count - j) + 2 * i * j, 3 * j * (count - i) + 2 * i * j
    first = 6 * count**2 - second - third
    turns = [np.roll(np.stack([first, second, third], axis=1), turn, axis=1) for turn in range(3)]
    unique, number = np.unique(np.concatenate(turns), axis=0, return_inverse=True)
    number = number.reshape(3, -1)
    cells = np.concatenate([places[square.t] for places in number], axis=1)
    return unique / (6 * count**2), cells


def interpolate(
    vertices: Points, corners: Indices, weight: Array, ring_edges: Array = FLAT
) -> Points:
    """Return points (m, l) by corners (m, 1, 3) and weights (l, 3).

    Where a point lies depends on corners of some weight alone.
    """
    plain = np.sum(weight * vertices[corners], axis=-1)
    points = plain.copy()
    to_axis = np.abs(vertices)
    centres = [(0.0, to_axis, to_axis > 1 + LOG_POLAR)]
    for edge in ring_edges[1:]:
        others = np.abs(ring_edges[1:] - edge)
        reach = min(LOG_POLAR * edge, BETWEEN_EDGES * min(others[others > 0], default=np.inf))
        distance = np.abs(vertices - edge)
        centres.append((edge, distance, distance < reach))
    for centre, distance, near in centres:
        # a centre has no logarithm: the triangles at it are subdivided plainly
        regular = ((distance[corners] > 0) | (weight == 0)).all(axis=-1)
        part = regular * np.sum(weight * near[corners], axis=-1)
        log = np.log(np.where(distance > 0, vertices - centre, 1.0))
        points += part * (centre + np.exp(np.sum(weight * log[corners], axis=-1)) - plain)
    # coordinates on the axis and the surface are exact zeros, and vertices stay where they are
    points.real[plain.real == 0] = 0.0
    points.imag[plain.imag == 0] = 0.0
    return np.where(weight.max(axis=1) == 1, plain, points)


def _interpolate_plainly(vertices: Points, corners: Indices, weight: Array) -> Points:
    """Return points (m, l) by corners (m, 1, 3) and weights (l, 3), those between arc points on it.

    Where a point lies depends on corners of some weight alone.
    """
    plain = np.sum(weight * vertices[corners], axis=-1)
    distance, outer = np.abs(vertices), np.abs(vertices).max()
    on_arc = ((distance[corners] > outer * (1 - 1e-12)) | (weight == 0)).all(axis=-1)
    points = np.where(on_arc, plain * (outer / np.maximum(np.abs(plain), 1.0)), plain)
    return np.where(weight.max(axis=1) == 1, plain, points)
