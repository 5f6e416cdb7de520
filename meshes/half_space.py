"""The truncated half-space: a scikit-fem mesh of a quarter disc with named boundaries.

Non-dimensional: the punch has radius 1. Depth is positive into the half-space, and the surface has
depth zero. The boundaries are `contact` (the surface under the face of the punch), `free` (the
surface beside it and in a hole), `axis`, `far` (the arc) and, for layers on a rigid base, `base`.
Meshes of triangles (`MeshTri`) and of quadrilaterals (`MeshQuad`) are accepted. Quadrilaterals are
reoriented so that elements of any degree are continuous across their sides.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh, MeshQuad
from skfem.mapping import Mapping

from .errors import MeshError
from .radial import Array, Indices

# The subdomains `degree -1`, `degree -2`, ... of a mesh contain the elements on which the degree of
# the displacement may be lower by 1, 2, ...
LOWERED_DEGREE_PREFIX = "degree -"
# subdomain in which fields are smoothest: away from every ring edge and below the surface
DEEP_SUBDOMAIN = "deep"
# greatest roundoff of the sum of the angles at a vertex
ANGLE_ROUNDOFF = 1e-3


@dataclass(repr=False)
class ExactQuads(MeshQuad):  # type: ignore[misc]
    """A scikit-fem mesh of quadrilaterals with exact radii.

    Layers round a ring edge may be far thinner than the roundoff of its radius: at r = 0.5
    neighbouring double-precision numbers are 1e-16 apart. Each radius is therefore stored as a sum
    of two numbers: the rounded radius, which scikit-fem uses, and its rounding error, called the
    low part. Depths need no low part because the surface has depth 0.

    Parameters
    ----------
    low_parts : (n,) low part of the radius of each vertex; zero if not given
    """

    low_parts: Array | None = None

    @cached_property
    def local_mapping(self) -> Mapping:
        """The mapping of the same elements, each moved so that its first corner is the origin.

        Its derivatives are accurate to all digits.
        """
        offsets = corner_offsets(self)
        corners = offsets.transpose(0, 2, 1).reshape(2, -1)
        numbers = np.arange(corners.shape[1]).reshape(-1, len(self.t)).T
        return MeshQuad(np.ascontiguousarray(corners), np.ascontiguousarray(numbers)).mapping()


def low_parts(mesh: Mesh) -> Array:
    """Return the low part (n,) of the radius of each vertex, which is its rounding error."""
    exact = mesh.low_parts if isinstance(mesh, ExactQuads) else None
    return np.zeros(mesh.p.shape[1]) if exact is None else np.asarray(exact)


def without_low_parts(mesh: Mesh) -> Mesh:
    """Return a mesh in the form that scikit-fem writes to files, without low parts of radii."""
    if not isinstance(mesh, ExactQuads):
        return mesh
    names = {"_boundaries": mesh.boundaries, "_subdomains": mesh.subdomains}
    return MeshQuad(mesh.p, mesh.t, **names)


def derivative_mapping(mesh: Mesh) -> Mapping:
    """Return the scikit-fem mapping whose derivatives are accurate to all digits.

    Use it for derivatives only, because it may place elements elsewhere than the mesh does.
    """
    return mesh.local_mapping if isinstance(mesh, ExactQuads) else mesh.mapping()


def corner_offsets(mesh: Mesh) -> Array:
    """Return the coordinates (2, corners, m) of element corners, relative to the first corner."""
    corners, low = mesh.p[:, mesh.t], low_parts(mesh)[mesh.t]
    offsets = corners - corners[:, :1]
    offsets[0] += low - low[:1]
    return offsets


def radial_ranks(mesh: Mesh) -> Indices:
    """Return the rank (n,) of each vertex in the order of the exact radii."""
    ranks = np.empty(mesh.p.shape[1], dtype=np.int64)
    # low parts decide the order of vertices with equal rounded radii
    ranks[np.lexsort((low_parts(mesh), mesh.p[0]))] = np.arange(len(ranks))
    return ranks


def as_half_space(mesh: Mesh, ring_edges: Array, base: float = np.inf) -> Mesh:
    """Name the boundaries of a quarter disc, remove points without elements, and check the mesh.

    Parameters
    ----------
    mesh : triangles or quadrilaterals; the first coordinate is the radius, the second the depth
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1; each must be a vertex
    base : depth of a rigid base at which the quarter disc ends, on the boundary `base`; infinite
        without one

    Raises
    ------
    MeshError
        if a boundary point lies elsewhere, a ring edge is not a vertex, or an element is degenerate
    """
    used, t = np.unique(mesh.t, return_inverse=True)
    points = np.ascontiguousarray(mesh.p[:, used])
    fields = {"doflocs": points, "t": t.reshape(mesh.t.shape), "_boundaries": None}
    if isinstance(mesh, ExactQuads):
        fields["low_parts"] = low_parts(mesh)[used]
    else:
        # meshers return coordinates that should be zero with roundoff
        points[points < 1e-14] = 0.0
    mesh = replace(mesh, **fields)
    if isinstance(mesh, MeshQuad):
        mesh = oriented(mesh)
    if np.bincount(mesh.t2f.ravel()).max() > 2:
        raise MeshError("the mesh is not a surface: a facet belongs to more than two elements")
    outer = mesh.boundary_facets()
    r, z = mesh.p[:, mesh.facets[:, outer]]
    surface, axis = (z == 0).all(axis=0), (r == 0).all(axis=0)
    # A facet belongs to the contact if one of its ends is inside the rim. Next to the rim only the
    # low parts show this, because both ends may be rounded to r = 1.
    low = low_parts(mesh)[mesh.facets[:, outer]]
    inside_rim = ((r < 1) | ((r == 1) & (low < 0))).any(axis=0)
    on_face = surface & inside_rim & _beyond_hole(mesh, surface, outer, float(ring_edges[0]))
    names = {
        "contact": on_face,
        "free": surface & ~on_face,
        "axis": axis,
        "far": ~surface & ~axis & ~(z == base).all(axis=0),
    }
    if np.isfinite(base):
        names["base"] = (z == base).all(axis=0)
    mesh = mesh.with_boundaries({name: outer[mask] for name, mask in names.items()})
    _check(mesh, np.asarray(ring_edges))
    return mesh


def _beyond_hole(
    mesh: Mesh, surface: NDArray[np.bool_], outer: Indices, radius: float
) -> NDArray[np.bool_]:
    """Return which facets lie outside a hole that may have the radius 0.

    Its edge is the vertex on the surface that is nearest to the radius.

    Parameters
    ----------
    mesh : the mesh
    surface : (k,) which facets lie on the surface
    outer : (k,) facets of the boundary
    radius : radius of the hole
    """
    if not radius:
        return np.ones(len(outer), dtype=bool)
    vertices, ranks = np.unique(mesh.facets[:, outer[surface]]), radial_ranks(mesh)
    distances = np.abs((mesh.p[0, vertices] - radius) + low_parts(mesh)[vertices])
    edge = vertices[distances.argmin()]
    return (ranks[mesh.facets[:, outer]] >= ranks[edge]).all(axis=0)


def halved(mesh: Mesh, ring_edges: Array, count: int) -> Mesh:
    """Return a half-space with every element halved `count` times.

    New boundary points are moved onto the arc.
    """
    base = np.inf
    if "base" in mesh.boundaries:
        base = float(mesh.p[1, mesh.facets[0, mesh.boundaries["base"][0]]])
    mesh, outer = without_low_parts(mesh).refined(count), truncation(mesh)
    points = np.where(np.abs(mesh.p) < 1e-14, 0.0, mesh.p)
    boundary = mesh.boundary_nodes()
    r, z = points[:, boundary]
    on_arc = boundary[(r > 0) & (z > 0) & (z < base)]
    points[:, on_arc] *= outer / np.hypot(*points[:, on_arc])
    return as_half_space(type(mesh)(points, mesh.t), ring_edges, base)


def oriented(mesh: MeshQuad) -> MeshQuad:
    """Reorder the corners of quadrilaterals so that neighbours agree on the direction of sides.

    In `ElementQuadP` the functions of a side depend on its direction, which runs from its first
    corner to its second; opposite sides run in parallel. The functions of two neighbours are
    continuous if both elements give their common side the same direction. Such directions exist for
    every mesh in the plane (Agelek, Anderson, Bangerth, Barth, ACM Trans. Math. Softw. 44, 2017).
    Opposite sides are linked into strips, and one of the two possible directions is chosen for each
    strip.
    """
    # `runs_as_reference` states whether a side, in the direction of the reference element (0-1,
    # 1-2, 3-2, 0-3), starts at the vertex of lower number
    runs_as_reference = np.stack(
        [mesh.facets[0, mesh.t2f[i]] == mesh.t[start] for i, start in enumerate((0, 1, 3, 0))]
    )
    first, opposite = mesh.t2f[:2].ravel(), mesh.t2f[2:].ravel()
    swapped = (runs_as_reference[:2] != runs_as_reference[2:]).ravel()
    count = mesh.nfacets
    # Node f of the graph is side f from its lower to its higher vertex; node f + count is the same
    # side in the other direction.
    starts = np.concatenate([first, first + count])
    ends = np.concatenate([opposite + count * swapped, opposite + count * ~swapped])
    graph = coo_matrix((np.ones(len(starts)), (starts, ends)), shape=(2 * count,) * 2)
    _, strip = connected_components(graph, directed=False)
    upwards = strip[:count] < strip[count:]
    # `forward` and `upward` state whether the first and the second pair of opposite sides keep
    # their direction. The corner at which both pairs start becomes the first corner.
    forward, upward = (runs_as_reference[i] == upwards[mesh.t2f[i]] for i in (0, 1))
    shift = np.where(upward, np.where(forward, 0, 1), np.where(forward, 3, 2))
    corners = (np.arange(4)[:, None] + shift) % 4
    return replace(mesh, t=np.take_along_axis(mesh.t, corners, axis=0))


def _check(mesh: Mesh, ring_edges: Array) -> None:
    """Check that the mesh has no gap, fold, missing ring edge or degenerate element.

    Raises
    ------
    MeshError
        if the mesh has one of these faults
    """
    ends = segments(mesh, mesh.boundaries["far"])
    if np.abs(np.linalg.norm(ends, axis=2) / truncation(mesh) - 1).max(initial=0.0) > 1e-9:
        raise MeshError(
            "the mesh has a hole or a gap, or is no quarter disc: boundary points lie neither on "
            "the surface, nor on the axis, nor on the arc; merge duplicate vertices (in gmsh: "
            "Coherence Mesh)"
        )
    enclosed = np.abs(np.linalg.det(ends)).sum() / 2
    if "base" in mesh.boundaries:
        enclosed += np.abs(np.linalg.det(segments(mesh, mesh.boundaries["base"]))).sum() / 2
    if abs(areas(mesh).sum() / enclosed - 1) > 1e-9:
        raise MeshError("elements overlap: the mesh is folded")
    missing = [edge for edge in ring_edges if np.abs(contact_radii(mesh) - edge).min() > 1e-12]
    if missing:
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {missing[0]:.9g} a: use a smaller "
            "ring_size"
        )
    shape = quality(mesh)
    if shape.min() < 0.02:
        r, z = mesh.p[:, mesh.t[:, shape.argmin()]].mean(axis=1)
        raise MeshError(
            f"an element at r = {r:.3g} a, depth {z:.3g} a is degenerate (quality "
            f"{shape.min():.1e}): use less extreme sizes"
        )
    if _is_folded(mesh):
        raise MeshError("elements overlap: the mesh is folded")


def _is_folded(mesh: Mesh) -> bool:
    """Return whether elements overlap, or leave a gap, at any vertex.

    The angles of the elements at a vertex sum to 2 pi inside the mesh and to pi on its straight
    boundaries. Areas do not show folds of elements that are far smaller than the mesh.
    """
    angles = np.bincount(mesh.t.ravel(), corner_angles(mesh).ravel())
    r, z = mesh.p
    on_line = (r == 0).astype(int) + (z == 0)
    if "base" in mesh.boundaries:
        on_line += z == z[mesh.facets[0, mesh.boundaries["base"]]].max()
    expected = 2 * np.pi / 2.0**on_line
    curved = np.zeros(len(r), dtype=bool)
    curved[mesh.facets[:, mesh.boundaries["far"]]] = True
    return bool((np.abs(angles - expected) > ANGLE_ROUNDOFF)[~curved].any())


def corner_angles(mesh: Mesh) -> Array:
    """Return the angles (corners, m) at the corners of each element, negative at reflex corners."""
    corners = corner_offsets(mesh)
    following, preceding = (np.roll(corners, shift, axis=1) - corners for shift in (-1, 1))
    cross = following[0] * preceding[1] - following[1] * preceding[0]
    return np.arctan2(cross * np.sign(cross.sum(axis=0)), (following * preceding).sum(axis=0))


def truncation(mesh: Mesh) -> float:
    """Return the truncation radius, which is the outer radius of the half-space."""
    return float(mesh.p[0].max())


def contact_facets(mesh: Mesh) -> Indices:
    """Return the facets of the contact, from the axis or a hole to the rim."""
    facets = mesh.boundaries["contact"]
    return facets[np.argsort(radial_ranks(mesh)[mesh.facets[:, facets]].sum(axis=0))]


def contact_radii(mesh: Mesh) -> Array:
    """Return the radii of the vertices on the contact, from 0 or a hole to 1."""
    return mesh.p[0, contact_vertices(mesh)]


def contact_vertices(mesh: Mesh) -> Indices:
    """Return the vertices on the contact, from the axis or a hole to the rim."""
    vertices = np.unique(mesh.facets[:, mesh.boundaries["contact"]])
    return vertices[np.argsort(radial_ranks(mesh)[vertices])]


def facet_ends(mesh: Mesh, facets: Indices) -> Indices:
    """Return the vertices (2, k) of facets, those nearer to the axis first."""
    ends = mesh.facets[:, facets]
    order = np.argsort(radial_ranks(mesh)[ends], axis=0, kind="stable")
    return np.take_along_axis(ends, order, axis=0)


def segments(mesh: Mesh, facets: Indices) -> Array:
    """Return the end points (k, 2, 2) (radius, depth) of facets, those nearer to the axis first."""
    return mesh.p[:, facet_ends(mesh, facets)].transpose(2, 1, 0)


def areas(mesh: Mesh) -> Array:
    """Return the areas (m,) of the elements in the (radius, depth) plane."""
    r, z = mesh.p[:, mesh.t]
    return np.abs((r * np.roll(z, -1, axis=0) - np.roll(r, -1, axis=0) * z).sum(axis=0)) / 2


def quality(mesh: Mesh) -> Array:
    """Return the least sine (m,) of the corners of each element.

    It is .87 for an equilateral triangle, 1 for a rectangle, 0 for a flat element, and negative for
    an element that is not convex.
    """
    return np.sin(corner_angles(mesh)).min(axis=0)
