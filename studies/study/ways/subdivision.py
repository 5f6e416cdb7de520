"""Sequences of graded meshes: base triangles, subdivided into triangles or quadrilaterals.

Points are complex numbers: radius + i depth. Near the rim, near every ring edge and far away,
triangles are subdivided in log-polar coordinates (the complex logarithm of the position relative to
that place), in which a graded mesh is uniform. In plain coordinates, the observed order of
convergence approaches its limit from below with an error of order h; in log-polar coordinates, of
order h^2.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh, MeshQuad, MeshTri

from ....meshes import Array, Indices, MeshError, SizeField, as_half_space, bisection
from ....meshes.by_gmsh import triangles

FLAT = np.array([0.0, 1.0])
"""Ring edges of a punch of one ring."""
Points = NDArray[np.complex128]

LOG_POLAR = 0.6
"""Reach of log-polar coordinates about an edge and beyond the rim, over the radius of the edge."""
BETWEEN_EDGES = 0.45
"""Upper limit of that reach over the distance to the next edge: neighbours do not overlap."""


@cache
def triangulated(field: SizeField) -> MeshTri:
    """Mesh the quarter disc with gmsh, or by bisection if gmsh fails."""
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

    Two neighbouring triangles compute the points on their common side from the same numbers in the
    same order, so that these agree in every digit.

    Parameters
    ----------
    mesh : triangles of the quarter disc, with a vertex at each ring edge
    count : number of parts into which each side of a triangle is divided, or each half of it for
        quadrilaterals
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1 (the rim)
    into_quads : whether each triangle becomes three quadrilaterals that meet in its middle
    log_polar : whether triangles near the rim, near ring edges and far away are divided in
        log-polar coordinates; all others are divided in plain coordinates

    Raises
    ------
    MeshError
        if an element is degenerate
    """
    weight, cells = (_weights_of_quads if into_quads else _weights_of_triangles)(count)
    vertices, corners = mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None]
    plain = np.sum(weight * vertices[corners], axis=-1)
    if log_polar:
        points = _in_log_polar(plain, vertices, corners, weight, ring_edges)
    else:
        points = _onto_arc(plain, vertices, corners, weight)
    # vertices do not move
    points = np.where(weight.max(axis=1) == 1, plain, points)
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

    Each corner of the triangle is a corner of one of three quadrilaterals, which are then divided.
    """
    square = MeshQuad.init_tensor(*2 * [np.arange(count + 1.0)])
    i, j = square.p
    # Weights of the three corners, times 6 count^2. They are integers, so that points on a side
    # have the same weights from both of its triangles.
    second, third = 3 * i * (count - j) + 2 * i * j, 3 * j * (count - i) + 2 * i * j
    first = 6 * count**2 - second - third
    turns = [np.roll(np.stack([first, second, third], axis=1), turn, axis=1) for turn in range(3)]
    unique, number = np.unique(np.concatenate(turns), axis=0, return_inverse=True)
    number = number.reshape(3, -1)
    cells = np.concatenate([places[square.t] for places in number], axis=1)
    return unique / (6 * count**2), cells


def _in_log_polar(
    plain: Points, vertices: Points, corners: Indices, weight: Array, ring_edges: Array
) -> Points:
    """Return points (m, l) in triangles, moved from plain to log-polar coordinates.

    A point depends only on those corners whose weight is not zero.

    Parameters
    ----------
    plain : (m, l) the points in plain coordinates
    vertices, corners, weight : vertices, corners (m, 1, 3) of the triangles, and weights (l, 3)
    ring_edges : as in `subdivided`
    """
    points = plain.copy()
    to_axis = np.abs(vertices)
    centres = [(0.0, to_axis, to_axis > 1 + LOG_POLAR)]
    edges = ring_edges[ring_edges > 0]
    for edge in edges:
        others = np.abs(edges - edge)
        reach = min(LOG_POLAR * edge, BETWEEN_EDGES * min(others[others > 0], default=np.inf))
        distance = np.abs(vertices - edge)
        centres.append((edge, distance, distance < reach))
    for centre, distance, within_reach in centres:
        # the logarithm is infinite at a centre: triangles at it are subdivided in plain coordinates
        regular = ((distance[corners] > 0) | (weight == 0)).all(axis=-1)
        log_polar_part = regular * np.sum(weight * within_reach[corners], axis=-1)
        log = np.log(np.where(distance > 0, vertices - centre, 1.0))
        points += log_polar_part * (centre + np.exp(np.sum(weight * log[corners], axis=-1)) - plain)
    # points on the axis and on the surface have exact zeros
    points.real[plain.real == 0] = 0.0
    points.imag[plain.imag == 0] = 0.0
    return points


def _onto_arc(plain: Points, vertices: Points, corners: Indices, weight: Array) -> Points:
    """Return points (m, l) in triangles; those between corners on the outer arc are moved onto it.

    The parameters are those of `_in_log_polar`.
    """
    distance, outer = np.abs(vertices), np.abs(vertices).max()
    on_arc = ((distance[corners] > outer * (1 - 1e-12)) | (weight == 0)).all(axis=-1)
    return np.where(on_arc, plain * (outer / np.maximum(np.abs(plain), 1.0)), plain)
