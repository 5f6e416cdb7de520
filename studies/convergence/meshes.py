"""Triangles for the studies of orders: a mesh of given sizes, and how it is subdivided.

Points are complex numbers, radius and depth. Subdivision is in log-polar coordinates, the complex
logarithm, about the rim and ring edges, and far away: in these a graded mesh is uniform. Halved in
plain coordinates, it approaches its order from below by a term in h; in these by h^2.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri

from ...meshes import bisection, triangles
from ...meshes.errors import MeshError
from ...meshes.half_space import as_half_space, contact_radii
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField

Points = NDArray[np.complex128]
FAR = 1.6  # radius beyond which subdivision is in log-polar coordinates about the origin


@cache
def triangulated(field: SizeField) -> MeshTri:
    """The quarter disc by gmsh.

    By bisection where that cannot be loaded or fails at such sizes, or if sizes do not grow.
    """
    try:
        return triangles.mesh(field) if field.growth else bisection.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(mesh: MeshTri, count: int, tips: Array) -> MeshTri:
    """Every triangle into ``count^2``.

    In log-polar coordinates about `tips` (radii) and far away, else in plain ones.

    Neighbours compute the points between them from the same numbers in the same order, and so agree
    on every digit.
    """
    square = MeshTri.init_tensor(*2 * [np.arange(count + 1.0)])
    half = square.restrict(np.subtract(*square.p[:, square.t].mean(axis=1)) > 0)
    weight = np.stack([count - half.p[0], half.p[0] - half.p[1], half.p[1]], axis=1) / count
    points = _interpolated(
        mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None], weight, tips
    )
    unique, number = np.unique(points, return_inverse=True)
    corners = number.reshape(points.shape)[:, half.t.T].reshape(-1, 3)
    fine = MeshTri(np.stack([unique.real, unique.imag]), np.ascontiguousarray(corners.T))
    return as_half_space(fine, contact_radii(mesh)[[0, -1]])


def _interpolated(vertices: Points, corners: Indices, weight: Array, tips: Array) -> Points:
    """(m, l) points by (m, 1, 3) corners and (l, 3) weights.

    Where a point lies depends on corners of some weight alone.
    """
    centres = np.append(tips, 0.0)
    distance = np.abs(vertices[:, None] - centres)
    # the centre of each vertex, or -1: well inside half the distance to the next singular point, or
    # to the axis
    reach = np.append(
        0.6 * np.minimum(np.diff(tips, prepend=0.0), np.diff(tips, append=np.inf)), 0.0
    )
    chart = np.where(
        (distance < reach).any(axis=1),
        np.where(distance < reach, distance, np.inf).argmin(axis=1),
        -1,
    )
    chart[distance[:, -1] > FAR] = len(tips)
    plain = np.sum(weight * vertices[corners], axis=-1)
    out, rest = np.zeros_like(plain), np.ones(plain.shape)
    for number, centre in enumerate(centres):
        # a centre has no logarithm: the triangles at it are subdivided plainly
        regular = ((distance[corners, number] > 0) | (weight == 0)).all(axis=-1)
        part = regular * np.sum(weight * (chart[corners] == number), axis=-1)
        log = np.log(np.where(distance[:, number] > 0, vertices - centre, 1.0))
        out += part * (centre + np.exp(np.sum(weight * log[corners], axis=-1)))
        rest -= part
    out += rest * plain
    # coordinates on the axis and the surface are exact zeros, and vertices stay where they are
    out.real[plain.real == 0] = 0.0
    out.imag[plain.imag == 0] = 0.0
    return np.where(weight.max(axis=1) == 1, plain, out)
