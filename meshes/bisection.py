"""The graded quarter disc by scikit-fem's own local refinement: no gmsh, no system library.

A coarse polar quarter disc is refined (red-green-blue) to the size field. Its contact line then
holds dyadic radii only, so the field is followed on a dyadic image of the punch and every point is
moved radially at the end, by the piecewise linear map that carries dyadic radii to ring edges.
"""

import itertools
from dataclasses import replace

import numpy as np
from skfem import MeshTri

from .errors import MeshError
from .half_space import as_half_space, truncation
from .radial import Array, Indices
from .sizes import SizeField

# greatest length of a side over the size that is wanted there
LONGEST = 1.25
# rounds of refinement over the halvings from the whole to the smallest size: usually so many are
# enough, and beyond the second number there is no hope
ROUNDS, MOST_ROUNDS = 2, 10
# Where sizes are even, a triangle that is refined may make its neighbour too long, that one the
# next, and so on along the contact, one in a round. After the usual rounds this length over the
# size is refined, so that all of them are at once.
LONGEST_OF_CHAINS = 1.2


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc to the size field.

    Raises
    ------
    MeshError
        if the sizes are not reached
    """
    ring_edges = np.array(field.ring_edges)
    dyadic, spacing = _dyadic_image(ring_edges)
    current = _polar_quarter_disc(field.truncation)
    for count in itertools.count():
        corners = _moved(current.p, dyadic, ring_edges)[:, current.t]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
        wanted = field(corners.mean(axis=1).T)
        halvings = np.log2(field.truncation / wanted.min())
        if count > MOST_ROUNDS * halvings:
            raise MeshError(
                "local refinement did not reach the sizes: ask for larger ones, or gmsh"
            )
        allowed = LONGEST if count <= ROUNDS * halvings else LONGEST_OF_CHAINS
        too_long = np.flatnonzero(longest > allowed * wanted)
        marked = np.union1d(too_long, _spans_an_edge(current, dyadic, spacing))
        if not len(marked):
            break
        current = _bisected(current, marked)
    points = _moved(current.p, dyadic, ring_edges)
    return as_half_space(replace(current, doflocs=points), ring_edges)


def refined(mesh: MeshTri, marked: Indices, ring_edges: Array) -> MeshTri:
    """Return the quarter disc with marked triangles divided into four, and neighbours as needed.

    Parameters
    ----------
    mesh : with its boundaries named
    marked : numbers of the triangles to refine
    ring_edges : (N+1,) ring edges, vertices of the mesh

    Raises
    ------
    MeshError
        if a triangle became degenerate
    """
    return as_half_space(_bisected(mesh, marked), ring_edges)


def _bisected(mesh: MeshTri, marked: Indices) -> MeshTri:
    """Refine marked triangles, and put what is new on the outer boundary on the arc."""
    outer = truncation(mesh)
    finer = replace(mesh, _boundaries=None).refined(marked)
    points, boundary = finer.p.copy(), finer.boundary_nodes()
    # boundary points off the axis and the surface belong on the arc
    arc = boundary[(points[:, boundary] > 0).all(axis=0)]
    points[:, arc] *= outer / np.hypot(*points[:, arc])
    return replace(finer, doflocs=points)


def _dyadic_image(ring_edges: Array) -> tuple[Array, float]:
    """Return a dyadic radius close to each edge, in order, and the spacing of that dyadic grid."""
    level = int(np.ceil(np.log2(2 / np.diff(ring_edges).min())))
    return np.round(ring_edges * 2.0**level) / 2.0**level, 0.5**level


def _moved(points: Array, dyadic: Array, ring_edges: Array) -> Array:
    radius = np.hypot(*points)
    inside = (radius > 0) & (radius < 1)
    scale = np.ones_like(radius)
    scale[inside] = np.interp(radius[inside], dyadic, ring_edges) / radius[inside]
    return points * scale


def _spans_an_edge(mesh: MeshTri, dyadic: Array, spacing: float) -> Indices:
    """Return the triangles that must be refined because a ring edge lies inside their facet.

    Only facets on the contact count. A facet that cannot have the ring edge as its end is refined
    until it can.
    """
    facets = mesh.boundary_facets()
    r, z = mesh.p[:, mesh.facets[:, facets]]
    low, high = np.sort(r, axis=0)
    first, last = (np.searchsorted(dyadic, r) for r in (low + spacing / 8, high - spacing / 8))
    return np.asarray(mesh.f2t[0, facets[(z == 0).all(axis=0) & (low < 1) & (first < last)]])


def _polar_quarter_disc(outer: float) -> MeshTri:
    """Return a few well-shaped triangles of a quarter disc.

    Their vertices lie on rays at 0, 45 and 90 degrees; the radius about doubles from one circle of
    vertices to the next.
    """
    count = max(1, round(np.log2(outer)))
    radii = outer ** (np.arange(count + 1) / count)
    # exact zeros on the axis and the surface: boundaries are recognised by them
    rays = np.array([[1, np.sqrt(0.5), 0], [0, np.sqrt(0.5), 1]])
    points = np.concatenate([np.zeros((2, 1)), *(radius * rays for radius in radii)], axis=1)
    # points 1 to 3 lie on the first circle, 4 to 6 on the second, ...
    layer = np.array([[1, 1, 2, 3], [4, 5, 5, 5], [5, 2, 3, 6]])
    triangles = [
        np.array([[0, 0], [1, 2], [2, 3]]),
        *(layer + 3 * number for number in range(count)),
    ]
    return MeshTri(points, np.concatenate(triangles, axis=1))
