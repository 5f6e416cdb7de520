"""Meshes for the studies of orders: a base mesh subdivided, or wrapped in layers and stretched to a box.

Points are complex numbers, radius and depth. Subdivision is in log-polar coordinates, the complex logarithm, about the rim
and ring edges, and far away: in these a graded mesh is uniform. Halved in plain coordinates, it approaches its order from
below by a term in h; in these by h^2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri

from ringwear.meshes import bisection, triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import contact_radii, half_space, truncation
from ringwear.meshes.radial import Array, Indices
from ringwear.meshes.sizes import SizeField

Points = NDArray[np.complex128]
FAR = 1.6  # radius beyond which subdivision is in log-polar coordinates about the origin
CORE, LAYER = 2.0, 2**0.25  # radius inside the layers in a, ratio of neighbouring layers
DOUBLED = 2  # layers that double the sides of the arc
UNSTRETCHED = 1.4  # radius within which a box is the disc that it was made of


def base_mesh(ring_edges: Array, smallest: float, growth: float, outer: float, centre_size: float) -> MeshTri:
    """Of one size at rim and ring edges, by gmsh or, where that cannot be loaded or fails at such sizes, by bisection."""
    field = SizeField(tuple(ring_edges.tolist()), smallest, smallest, growth, outer, centre_size)
    try:
        return triangles.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(mesh: MeshTri, count: int, tips: Array) -> MeshTri:
    """Every triangle into ``count^2``: in log-polar coordinates about `tips` (radii) and far away, else in plain ones.

    Neighbours compute the points between them from the same numbers in the same order, and so agree on every digit.
    """
    square = MeshTri.init_tensor(*2 * [np.arange(count + 1.0)])
    half = square.restrict(np.subtract(*square.p[:, square.t].mean(axis=1)) > 0)
    weight = np.stack([count - half.p[0], half.p[0] - half.p[1], half.p[1]], axis=1) / count
    points = _interpolated(mesh.p[0] + 1j * mesh.p[1], np.sort(mesh.t, axis=0).T[:, None], weight, tips)
    unique, number = np.unique(points, return_inverse=True)
    return half_space(_mesh(unique, number.reshape(points.shape)[:, half.t.T].reshape(-1, 3)), contact_radii(mesh)[[0, -1]])


def _mesh(points: Points, corners: Indices) -> MeshTri:
    return MeshTri(np.stack([points.real, points.imag]), np.ascontiguousarray(corners.T))


def _interpolated(vertices: Points, corners: Indices, weight: Array, tips: Array) -> Points:
    """(m, l) points by (m, 1, 3) corners and (l, 3) weights; where a point lies depends on corners of some weight alone."""
    centres = np.append(tips, 0.0)
    distance = np.abs(vertices[:, None] - centres)
    # the centre of each vertex, or -1: well inside half the distance to the next singular point, or to the axis
    reach = np.append(0.6 * np.minimum(np.diff(tips, prepend=0.0), np.diff(tips, append=np.inf)), 0.0)
    chart = np.where((distance < reach).any(axis=1), np.where(distance < reach, distance, np.inf).argmin(axis=1), -1)
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


def layered(core: MeshTri, count: int) -> MeshTri:
    """A core with layers of triangles between concentric arcs, on the rays of the points of its own arc.

    The first layers double the sides of the arc: the study of truncation wants the far field's values well resolved
    on the outer boundary, wherever that is.
    """
    points, corners = [core.p[0] + 1j * core.p[1]], [core.t.T]
    arc = np.unique(core.facets[:, core.boundaries["far"]])
    arc = arc[np.argsort(np.angle(points[0][arc]))]
    rays, total = points[0][arc] / CORE, core.nvertices
    for layer in range(1, count + 1):
        times = 2 if layer <= DOUBLED else 1
        if times == 2:
            middles = rays[1:] + rays[:-1]
            rays = np.insert(rays, np.arange(1, len(rays)), middles / np.abs(middles))
        points.append(CORE * LAYER**layer * rays)
        outer = total + np.arange(len(rays))
        # a triangle on each side of the outer arc, and one on each of the inner arc
        apex = arc[(np.arange(len(outer) - 1) + times - 1) // times]
        corners += [np.stack([outer[:-1], outer[1:], apex], axis=1), np.stack([arc[:-1], arc[1:], outer[1::times]], axis=1)]
        arc, total = outer, total + len(outer)
    return half_space(_mesh(np.concatenate(points), np.concatenate(corners)), contact_radii(core)[[0, -1]])


def boxed(mesh: MeshTri) -> MeshTri:
    """The mesh with its outer arc stretched to the square around it, and nothing moved near the contact.

    Points move along their rays, ever more from `UNSTRETCHED` on; rays turn a little so that one ends in the corner.
    """
    outer, corner = truncation(mesh), np.pi / 4
    radius, angle = np.hypot(*mesh.p), np.arctan2(mesh.p[1], mesh.p[0])
    moved = np.clip((radius - UNSTRETCHED) / (outer - UNSTRETCHED), 0.0, 1.0)
    far = angle[np.unique(mesh.facets[:, mesh.boundaries["far"]])]
    nearest = far[np.abs(far - corner).argmin()]
    angle += moved * (np.interp(angle, [0.0, nearest, np.pi / 2], [0.0, corner, np.pi / 2]) - angle)
    direction = np.stack([np.cos(angle), np.sin(angle)])
    radius *= 1 + moved * (1 / direction.max(axis=0) - 1)
    # on the axis and the surface, which do not move, coordinates are exact zeros
    return replace(mesh, doflocs=np.where(mesh.p == 0, 0.0, radius * direction))
