"""Triangles for the studies of orders: of given sizes, subdivided, and condensed to a compliance.

Points are complex numbers, radius and depth. Subdivision is in log-polar coordinates, the complex
logarithm, about the rim and ring edges, and far away: in these a graded mesh is uniform. Halved in
plain coordinates, it approaches its order from below by a term in h; in these by h^2.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh, MeshTri

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.half_space import HalfSpace, pressure_space
from ...meshes import bisection, triangles
from ...meshes.compliance import Compliance
from ...meshes.errors import MeshError
from ...meshes.half_space import as_half_space, contact_radii
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField
from ..wear.flat_contact import press_flat

Points = NDArray[np.complex128]
Discretised = tuple[Compliance, int]
"""A compliance, and the number of unknowns behind it."""
FLAT = np.array([0.0, 1.0])
"""Edges of a punch of one ring."""


@cache
def triangulated(field: SizeField) -> MeshTri:
    """Mesh the quarter disc by gmsh.

    By bisection where that cannot be loaded or fails at such sizes, or if sizes do not grow.
    """
    try:
        return triangles.mesh(field) if field.growth else bisection.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(mesh: MeshTri, count: int, tips: Array) -> MeshTri:
    """Divide every triangle into ``count^2``.

    In log-polar coordinates about `tips` (radii) and far away, else in plain ones. Neighbours
    compute the points between them from the same numbers in the same order, and so agree on every
    digit.
    """
    square = MeshTri.init_tensor(*2 * [np.arange(count + 1.0)])
    half = square.restrict(np.subtract(*square.p[:, square.t].mean(axis=1)) > 0)
    weight = np.stack([count - half.p[0], half.p[0] - half.p[1], half.p[1]], axis=1) / count
    vertices, corners = mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None]
    points = interpolate(vertices, corners, weight, tips)
    unique, number = np.unique(points, return_inverse=True)
    fine = number.reshape(points.shape)[:, half.t.T].reshape(-1, 3)
    divided = MeshTri(np.stack([unique.real, unique.imag]), np.ascontiguousarray(fine.T))
    return as_half_space(divided, contact_radii(mesh)[[0, -1]])


def interpolate(vertices: Points, corners: Indices, weight: Array, tips: Array) -> Points:
    """Return points (m, l) by corners (m, 1, 3) and weights (l, 3).

    Where a point lies depends on corners of some weight alone.
    """
    centres = np.append(tips, 0.0)
    distance = np.abs(vertices[:, None] - centres)
    # the centre of each vertex, or -1: well inside half the distance to the next singular point, or
    # to the axis
    inner, outer = np.diff(tips, prepend=0.0), np.diff(tips, append=np.inf)
    near = np.where(distance < np.append(0.6 * np.minimum(inner, outer), 0.0), distance, np.inf)
    chart = np.where(np.isfinite(near).any(axis=1), near.argmin(axis=1), -1)
    chart[distance[:, -1] > 1.6] = len(tips)
    plain = np.sum(weight * vertices[corners], axis=-1)
    points = plain.copy()
    for number, centre in enumerate(centres):
        # a centre has no logarithm: the triangles at it are subdivided plainly
        regular = ((distance[corners, number] > 0) | (weight == 0)).all(axis=-1)
        part = regular * np.sum(weight * (chart[corners] == number), axis=-1)
        log = np.log(np.where(distance[:, number] > 0, vertices - centre, 1.0))
        points += part * (centre + np.exp(np.sum(weight * log[corners], axis=-1)) - plain)
    # coordinates on the axis and the surface are exact zeros, and vertices stay where they are
    points.real[plain.real == 0] = 0.0
    points.imag[plain.imag == 0] = 0.0
    return np.where(weight.max(axis=1) == 1, plain, points)


def condense(
    mesh: Mesh, ring_edges: Array, degree: int, poisson_ratio: float, poles: int
) -> Discretised:
    """Condense the finite-element half-space on a mesh, with so many poles as its far field."""
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    orders = tuple(range(0, 2 * poles, 2))
    half_space = HalfSpace(solid, pressure_space(solid, ring_edges), orders)
    return half_space.compliance(), half_space.unknowns


def flat_d0(compliance: Compliance) -> dict[str, float]:
    """Return the indentation of the flat start, singular at the rim."""
    return {"d0": press_flat(compliance).indentation}
