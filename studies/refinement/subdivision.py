"""Meshes made of another one for the studies of orders: subdivided, wrapped in layers, stretched to a box.

Subdivision is in log-polar coordinates at the rim and ring edges, and far away: in these a graded mesh is uniform. Halved in
plain coordinates, it approaches its order from below by a term in h; in these by h^2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import contact_radii, half_space, truncation
from ringwear.meshes.radial import Array, Indices
from ringwear.meshes.size_field import SizeField
from skfem import Mesh, MeshTri

FAR = 1.6  # radius beyond which subdivision is in log-polar coordinates about the origin
CORE, LAYER = 2.0, 2**0.25  # radius inside the layers in a, ratio of neighbouring layers
DOUBLED = 2  # layers that double the sides of the arc
UNSTRETCHED = 1.4  # radius within which a box is the disc that it was made of


def coarse_field(edges: Array, sizes: tuple[float, float, float], truncation: float) -> SizeField:
    """Sizes of a mesh to subdivide, by those at the rim and at ring edges and their growth; as coarse at the centre."""
    return SizeField(tuple(float(edge) for edge in edges), *sizes, truncation, centre_size=truncation)


def base_mesh(field: SizeField) -> MeshTri:
    """The mesh by gmsh or, where that cannot be loaded or fails at such sizes, by bisection."""
    from ringwear.meshes import bisection, triangles

    try:
        return triangles.mesh(field)
    except MeshError:
        return bisection.mesh(field)


def subdivided(mesh: MeshTri, count: int, tips: Array) -> MeshTri:
    """Every triangle into ``count^2``: in log-polar coordinates about `tips` (radii) and far away, else in plain ones.

    A new point is told by the vertices it lies between and its weight on each, so that neighbours agree on it; in
    which coordinates it is interpolated depends on these vertices alone.
    """
    lattice, small = _lattice(count)
    vertices_of, corners = mesh.t.T, mesh.p.T
    weights = np.broadcast_to(lattice, (len(vertices_of), *lattice.shape))
    vertices = np.where(weights > 0, vertices_of[:, None, :], -1)
    order = np.argsort(vertices, axis=-1)
    told = np.concatenate([np.take_along_axis(part, order, axis=-1) for part in (vertices, weights)], axis=-1)
    unique, number = np.unique(told.reshape(-1, 6), axis=0, return_inverse=True)
    between, weight = unique[:, :3], unique[:, 3:] / count
    between = np.where(weight > 0, between, between[:, 2:])
    points = _interpolated(corners, between, weight, tips)
    for axis in (0, 1):
        points[(corners[between, axis] == 0).all(axis=1), axis] = 0.0
    kept = weight[:, 2] == 1
    points[kept] = corners[between[kept, 2]]
    triangles = number.reshape(len(vertices_of), -1)[:, small].reshape(-1, 3)
    return half_space(_mesh(points, triangles), contact_radii(mesh)[[0, -1]])


def _mesh(points: Array, triangles: Indices) -> MeshTri:
    return MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))


def _lattice(count: int) -> tuple[Indices, Indices]:
    """Integer barycentric coordinates (m, 3) of the points in a subdivided triangle, and its small triangles."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
    inside = i + j <= count
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(inside.sum())
    upright = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:]], axis=-1).reshape(-1, 3)
    turned = np.stack([number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 3)
    triangles = np.concatenate([upright, turned])
    return np.stack([count - i - j, i, j], axis=-1)[inside], triangles[triangles.min(axis=1) >= 0]


def _interpolated(points: Array, between: Indices, weight: Array, tips: Array) -> Array:
    centres = np.append(tips, 0.0)
    distance = np.hypot(points[:, 0, None] - centres, points[:, 1, None])
    chart = np.full(len(points), -1)
    if len(tips):
        nearest = distance[:, :-1].argmin(axis=1)
        # well inside half the distance to the next singular point, or to the axis
        reach = 0.6 * np.minimum(np.diff(tips, prepend=0.0), np.diff(tips, append=np.inf))
        chart = np.where(distance[:, :-1].min(axis=1) < reach[nearest], nearest, chart)
    chart[distance[:, -1] > FAR] = len(tips)
    out, plain = np.zeros((len(between), 2)), np.ones(len(between))
    for number, centre in enumerate(centres):
        rho = distance[:, number]
        # a centre has no logarithm: the triangles at it are subdivided plainly
        share = np.where(rho[between].min(axis=1) > 0, np.sum(weight * (chart[between] == number), axis=1), 0.0)
        log = np.log(np.where(rho > 0, rho, 1.0))
        radius = np.exp(np.sum(weight * log[between], axis=1))
        angle = np.sum(weight * np.arctan2(points[:, 1], points[:, 0] - centre)[between], axis=1)
        out += (share * radius * np.array([np.cos(angle), np.sin(angle)])).T
        out[:, 0] += share * centre
        plain -= share
    return out + plain[:, None] * np.einsum("pv,pvx->px", weight, points[between])


def layered(core: MeshTri, count: int) -> MeshTri:
    """A core with layers of triangles between concentric arcs, on the rays of the points of its own arc.

    The first layers double the sides of the arc: the study of truncation wants the far field's values well resolved
    on the outer boundary, wherever that is.
    """
    arc = np.unique(core.facets[:, core.boundaries["far"]])
    arc = arc[np.argsort(np.arctan2(core.p[1, arc], core.p[0, arc]))]
    points, triangles, total = [core.p.T], [core.t.T], core.nvertices
    rays = core.p.T[arc] / CORE
    for layer in range(1, count + 1):
        doubled = layer <= DOUBLED
        if doubled:
            rays = _with_middles(rays)
        points.append(CORE * LAYER**layer * rays)
        outer = total + np.arange(len(rays))
        triangles.append(_between_doubled(arc, outer) if doubled else _between_equal(arc, outer))
        arc, total = outer, total + len(rays)
    return half_space(_mesh(np.concatenate(points), np.concatenate(triangles)), contact_radii(core)[[0, -1]])


def _with_middles(rays: Array) -> Array:
    """Unit vectors with another one between each two."""
    middles = rays[:-1] + rays[1:]
    out = np.empty((2 * len(rays) - 1, 2))
    out[::2], out[1::2] = rays, middles / np.hypot(*middles.T)[:, None]
    return out


def _between_equal(inner: Indices, outer: Indices) -> Indices:
    """Two triangles between facing sides of two arcs."""
    low, high = (inner[:-1], outer[:-1], outer[1:]), (inner[:-1], outer[1:], inner[1:])
    return np.concatenate([np.stack(corners, axis=1) for corners in (low, high)])


def _between_doubled(inner: Indices, outer: Indices) -> Indices:
    """Three triangles between each side of an arc and the two that face it."""
    a, b = inner[:-1], inner[1:]
    low, middle, high = outer[:-1:2], outer[1::2], outer[2::2]
    return np.concatenate([np.stack(corners, axis=1) for corners in ((a, low, middle), (a, middle, b), (b, middle, high))])


def boxed(mesh: MeshTri) -> MeshTri:
    """The mesh with its outer arc stretched to the square around it, and nothing moved near the contact.

    Points move along their rays, ever more from `UNSTRETCHED` on; rays turn a little so that one ends in the corner.
    """
    outer, corner = truncation(mesh), np.pi / 4
    radius, angle = np.hypot(*mesh.p), np.arctan2(mesh.p[1], mesh.p[0])
    share = np.clip((radius - UNSTRETCHED) / (outer - UNSTRETCHED), 0.0, 1.0)
    far = angle[np.unique(mesh.facets[:, mesh.boundaries["far"]])]
    nearest = far[np.abs(far - corner).argmin()]
    turned = angle + share * (np.interp(angle, [0.0, nearest, np.pi / 2], [0.0, corner, np.pi / 2]) - angle)
    to_square = 1 / np.maximum(np.cos(turned), np.sin(turned))
    stretched = radius * (1 + share * (to_square - 1))
    points = stretched * np.stack([np.cos(turned), np.sin(turned)])
    # on the axis and the surface, which do not move, coordinates are exact zeros
    return replace(mesh, doflocs=np.where(mesh.p == 0, 0.0, points))


def condensed(
    mesh: Mesh, edges: Array, degree: int, poisson_ratio: float, poles: tuple[int, ...] = (0, 2, 4)
) -> tuple[Compliance, int]:
    """Compliance and number of unknowns of the finite-element half-space on a mesh."""
    from ringwear.fem.elasticity import AxisymmetricElasticity
    from ringwear.fem.half_space import HalfSpace, pressure_space

    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    whole = HalfSpace(solid, pressure_space(solid, edges), poles)
    return whole.compliance(), whole.unknowns
