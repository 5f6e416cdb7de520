"""The truncated half-space: a scikit-fem mesh of a quarter disc, its boundaries named.

Non-dimensional: the punch has radius 1. Depth is positive into the half-space; the surface is depth
zero. Boundaries are `contact` (surface under the punch), `free` (surface beside it), `axis` and
`far` (the arc). Triangles (`MeshTri`) and quadrilaterals (`MeshQuad`) are welcome alike; the latter
are turned so that elements of any degree conform on them.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh, MeshQuad

from .errors import MeshError
from .radial import Array, Indices

# subdomains `degree -1`, `degree -2`, ... of a mesh: where the degree of the displacement may be so
# much lower
LOWER = "degree -"
# where fields are smoothest: away from every edge, and below the surface
DEEP = "deep"


def as_half_space(mesh: Mesh, ring_edges: Array) -> Mesh:
    """Name the boundaries of a quarter disc, drop its orphan points, and check it.

    Parameters
    ----------
    mesh : triangles or quadrilaterals, the first coordinate the radius, the second the depth
    ring_edges : (N+1,) ring edges, 0 to 1; each must be a vertex

    Raises
    ------
    MeshError
        if a boundary point lies elsewhere, a ring edge is not a vertex, or an element is degenerate
    """
    used, t = np.unique(mesh.t, return_inverse=True)
    points = np.ascontiguousarray(mesh.p[:, used])
    points[points < 1e-14] = 0.0
    mesh = replace(mesh, doflocs=points, t=t.reshape(mesh.t.shape), _boundaries=None)
    if isinstance(mesh, MeshQuad):
        mesh = turned(mesh)
    if np.bincount(mesh.t2f.ravel()).max() > 2:
        raise MeshError("the mesh is not a surface: a facet has more than two elements")
    outer = mesh.boundary_facets()
    r, z = mesh.p[:, mesh.facets[:, outer]]
    surface, axis = (z == 0).all(axis=0), (r == 0).all(axis=0)
    inside = r.mean(axis=0) < 1  # however small the facets beside the rim
    names = {
        "contact": surface & inside,
        "free": surface & ~inside,
        "axis": axis,
        "far": ~surface & ~axis,
    }
    mesh = mesh.with_boundaries({name: outer[mask] for name, mask in names.items()})
    _check(mesh, np.asarray(ring_edges))
    return mesh


def turned(mesh: MeshQuad) -> MeshQuad:
    """Renumber quadrilaterals so that their sides run as those of their neighbours.

    In `ElementQuadP` the functions of a side have the direction of that side, from its first corner
    to its second, and opposite sides are parallel. Neighbours agree on them if every side runs the
    same way in both its elements, which in the plane can always be had (Agelek, Anderson, Bangerth,
    Barth, ACM Trans. Math. Softw. 44, 2017). Opposite sides are linked into strips; a strip has two
    directions, of which one is chosen.
    """
    # does a side, as the reference element runs it (0-1, 1-2, 3-2, 0-3), start at its lower vertex?
    along = np.stack(
        [mesh.facets[0, mesh.t2f[i]] == mesh.t[start] for i, start in enumerate((0, 1, 3, 0))]
    )
    first, opposite = mesh.t2f[:2].ravel(), mesh.t2f[2:].ravel()
    swapped = (along[:2] != along[2:]).ravel()
    count = mesh.nfacets
    # node f: side f from its lower to its higher vertex; node f + count: the other way
    starts = np.concatenate([first, first + count])
    ends = np.concatenate([opposite + count * swapped, opposite + count * ~swapped])
    graph = coo_matrix((np.ones(len(starts)), (starts, ends)), shape=(2 * count,) * 2)
    _, strip = connected_components(graph, directed=False)
    upwards = strip[:count] < strip[count:]
    # whether the first and the second pair of opposite sides run as numbered now; the corner where
    # both start comes first
    forward, upward = (along[i] == upwards[mesh.t2f[i]] for i in (0, 1))
    shift = np.where(upward, np.where(forward, 0, 1), np.where(forward, 3, 2))
    corners = (np.arange(4)[:, None] + shift) % 4
    return replace(mesh, t=np.take_along_axis(mesh.t, corners, axis=0))


def _check(mesh: Mesh, ring_edges: Array) -> None:
    ends = segments(mesh, mesh.boundaries["far"])
    if np.abs(np.linalg.norm(ends, axis=2) / truncation(mesh) - 1).max(initial=0.0) > 1e-9:
        raise MeshError(
            "the mesh has a hole or a gap, or is no quarter disc: boundary points lie neither on "
            "the surface, nor on the axis, nor on the arc; merge vertices that are there twice (in "
            "gmsh: Coherence Mesh)"
        )
    enclosed = np.abs(np.linalg.det(ends)).sum() / 2
    if abs(areas(mesh).sum() / enclosed - 1) > 1e-9:
        raise MeshError("elements overlap: the mesh is folded over itself")
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
            f"{shape.min():.1e}): ask for less extreme sizes"
        )


def truncation(mesh: Mesh) -> float:
    """Radius of the half-space."""
    return float(mesh.p[0].max())


def contact_facets(mesh: Mesh) -> Indices:
    """Facets of the contact, from the axis to the rim."""
    facets = mesh.boundaries["contact"]
    return np.asarray(facets[np.argsort(mesh.p[0, mesh.facets[:, facets]].sum(axis=0))])


def contact_radii(mesh: Mesh) -> Array:
    """Radii of the vertices on the contact, from 0 to 1."""
    return np.sort(mesh.p[0, np.unique(mesh.facets[:, mesh.boundaries["contact"]])])


def facet_ends(mesh: Mesh, facets: Indices) -> Indices:
    """(2, k) vertices of facets, those nearer to the axis first."""
    ends = mesh.facets[:, facets]
    return np.take_along_axis(ends, np.argsort(mesh.p[0, ends], axis=0, kind="stable"), axis=0)


def segments(mesh: Mesh, facets: Indices) -> Array:
    """(k, 2, 2) end points (radius, depth) of facets, those nearer to the axis first."""
    return mesh.p[:, facet_ends(mesh, facets)].transpose(2, 1, 0)


def areas(mesh: Mesh) -> Array:
    """(m,) areas of the elements in the (radius, depth) plane."""
    r, z = mesh.p[:, mesh.t]
    return np.asarray(
        np.abs((r * np.roll(z, -1, axis=0) - np.roll(r, -1, axis=0) * z).sum(axis=0)) / 2
    )


def quality(mesh: Mesh) -> Array:
    """(m,) least sine of the corners of each element.

    .87 for an equilateral triangle, 1 for a rectangle, 0 if flat.
    """
    corners = mesh.p[:, mesh.t]
    sides = np.roll(corners, -1, axis=1) - corners
    sides = sides / np.linalg.norm(sides, axis=0)
    before = np.roll(sides, 1, axis=1)
    sines = before[0] * sides[1] - before[1] * sides[0]
    # negative at a corner that bends the other way
    return np.asarray((sines * np.sign(sines.sum(axis=0))).min(axis=0))
