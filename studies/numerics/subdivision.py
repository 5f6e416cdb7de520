"""Sequences of graded triangles: a base mesh of the flat punch, subdivided.

Points are complex numbers, radius and depth. Subdivision is in log-polar coordinates, the complex
logarithm, about the rim and far away: in these a graded mesh is uniform. Halved in plain
coordinates, it approaches its order from below by a term in h; in these by h^2.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri

from ...meshes import bisection, triangles
from ...meshes.errors import MeshError
from ...meshes.half_space import as_half_space
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField
from .core import FLAT

Points = NDArray[np.complex128]


@cache
def triangulated(field: SizeField) -> MeshTri:
    """Mesh the quarter disc by gmsh, or by bisection where gmsh cannot."""
    try:
        return triangles.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(mesh: MeshTri, count: int) -> MeshTri:
    """Divide every triangle into ``count^2``.

    In log-polar coordinates about the rim and far away, between them in plain ones. Neighbours
    compute the points between them from the same numbers in the same order, and so agree on every
    digit.
    """
    square = MeshTri.init_tensor(*2 * [np.arange(count + 1.0)])
    half = square.restrict(np.subtract(*square.p[:, square.t].mean(axis=1)) > 0)
    weight = np.stack([count - half.p[0], half.p[0] - half.p[1], half.p[1]], axis=1) / count
    vertices, corners = mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None]
    points = interpolate(vertices, corners, weight)
    unique, number = np.unique(points, return_inverse=True)
    fine = number.reshape(points.shape)[:, half.t.T].reshape(-1, 3)
    divided = MeshTri(np.stack([unique.real, unique.imag]), np.ascontiguousarray(fine.T))
    return as_half_space(divided, FLAT)


def interpolate(vertices: Points, corners: Indices, weight: Array) -> Points:
    """Return points (m, l) by corners (m, 1, 3) and weights (l, 3).

    Where a point lies depends on corners of some weight alone.
    """
    plain = np.sum(weight * vertices[corners], axis=-1)
    points = plain.copy()
    to_rim, to_axis = np.abs(vertices - 1), np.abs(vertices)
    for centre, distance, near in ((1, to_rim, to_rim < 0.6), (0, to_axis, to_axis > 1.6)):
        # a centre has no logarithm: the triangles at it are subdivided plainly
        regular = ((distance[corners] > 0) | (weight == 0)).all(axis=-1)
        part = regular * np.sum(weight * near[corners], axis=-1)
        log = np.log(np.where(distance > 0, vertices - centre, 1.0))
        points += part * (centre + np.exp(np.sum(weight * log[corners], axis=-1)) - plain)
    # coordinates on the axis and the surface are exact zeros, and vertices stay where they are
    points.real[plain.real == 0] = 0.0
    points.imag[plain.imag == 0] = 0.0
    return np.where(weight.max(axis=1) == 1, plain, points)
