"""The graded quarter disc by scikit-fem's local refinement, without gmsh or system libraries.

A coarse quarter disc in polar form is refined (red-green-blue) until its triangles have the target
sizes. The vertices of its contact line have dyadic radii only. Therefore the mesh is made for a
punch whose ring edges are moved to nearby dyadic radii, and at the end every point is moved
radially by the piecewise linear map from the dyadic radii to the ring edges.
"""

import itertools
from dataclasses import replace

import numpy as np
from skfem import MeshTri

from .errors import MeshError
from .half_space import as_half_space, truncation
from .radial import Array, Indices, from_axis
from .sizes import SizeField

# largest side of a triangle, relative to the target size there
MAX_SIDE = 1.25
# Rounds of refinement, relative to the number of halvings from the truncation radius to the
# smallest size. The first number of rounds is usually enough. After the second one, the target
# sizes count as out of reach.
USUAL_ROUNDS = 2
MAX_ROUNDS = 10
# Largest side relative to the target size, after the usual rounds. If the target size is uniform
# along the contact, refining one triangle may make its neighbour exceed `MAX_SIDE`, that one the
# next, and so on, one triangle in each round. This lower limit refines all of them at once.
MAX_SIDE_AFTER_USUAL_ROUNDS = 1.2

# relative distance from the arc below which points count as lying on it
ROUNDOFF_OF_ARC = 1e-14


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc with the sizes of the size field.

    Raises
    ------
    MeshError
        if the sizes are not reached
    """
    ring_edges, edges = np.array(field.ring_edges), from_axis(field.ring_edges)
    dyadic, spacing = _dyadic_image(edges)
    current_mesh = _polar_quarter_disc(field.truncation)
    for round_number in itertools.count():
        corners = _with_moved_edges(current_mesh.p, dyadic, edges)[:, current_mesh.t]
        longest_sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
        target_sizes = field(corners.mean(axis=1).T)
        halvings = np.log2(field.truncation / target_sizes.min())
        if round_number > MAX_ROUNDS * halvings:
            raise MeshError(
                "local refinement did not reach the target sizes: use larger sizes, or gmsh"
            )
        max_side = (
            MAX_SIDE if round_number <= USUAL_ROUNDS * halvings else MAX_SIDE_AFTER_USUAL_ROUNDS
        )
        too_long = np.flatnonzero(longest_sides > max_side * target_sizes)
        marked = np.union1d(too_long, _spans_an_edge(current_mesh, dyadic, spacing))
        if not len(marked):
            break
        current_mesh = _bisected(current_mesh, marked)
    points = _with_moved_edges(current_mesh.p, dyadic, edges)
    return as_half_space(replace(current_mesh, doflocs=points), ring_edges)


def refined(mesh: MeshTri, marked: Indices, ring_edges: Array) -> MeshTri:
    """Return the quarter disc with each marked triangle divided into four.

    Neighbours are divided where that is needed for a conforming mesh.

    Parameters
    ----------
    mesh : quarter disc with named boundaries
    marked : numbers of the triangles to refine
    ring_edges : (N+1,) ring edges, vertices of the mesh

    Raises
    ------
    MeshError
        if a triangle became degenerate
    """
    return as_half_space(_bisected(mesh, marked), ring_edges)


def _bisected(mesh: MeshTri, marked: Indices) -> MeshTri:
    """Refine the marked triangles, and move new points of the outer boundary onto the arc."""
    outer = truncation(mesh)
    # a copy would compute the facets of the mesh anew, which takes most of the time
    plain = mesh if mesh.boundaries is None else replace(mesh, _boundaries=None)
    finer = plain.refined(marked)
    boundary = finer.boundary_nodes()
    # boundary points that are neither on the axis nor on the surface belong to the arc
    arc = boundary[(finer.p[:, boundary] > 0).all(axis=0)]
    scale = outer / np.hypot(*finer.p[:, arc])
    if np.abs(scale - 1).max() <= ROUNDOFF_OF_ARC:
        return finer
    points = finer.p.copy()
    points[:, arc] *= scale
    return replace(finer, doflocs=points)


def _dyadic_image(edges: Array) -> tuple[Array, float]:
    """Return a dyadic radius close to each edge, in the same order, and the dyadic spacing."""
    level = int(np.ceil(np.log2(2 / np.diff(edges).min())))
    return np.round(edges * 2.0**level) / 2.0**level, 0.5**level


def _with_moved_edges(points: Array, dyadic: Array, edges: Array) -> Array:
    """Return points moved radially, so that the dyadic radii become the ring edges."""
    radius = np.hypot(*points)
    in_punch = (radius > 0) & (radius < 1)
    scale = np.ones_like(radius)
    scale[in_punch] = np.interp(radius[in_punch], dyadic, edges) / radius[in_punch]
    return points * scale


def _spans_an_edge(mesh: MeshTri, dyadic: Array, spacing: float) -> Indices:
    """Return the triangles to refine because a ring edge lies inside their contact facet.

    Refinement ends when the ring edge is an end of a facet.
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
