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
    plain = mesh if mesh.boundaries is None else replace(mesh, _boundaries=None)
    finer = plain.refined(marked)
    arc = _points_of_arc(finer, outer)
    scale = outer / np.hypot(*finer.p[:, arc])
    if np.abs(scale - 1).max(initial=0.0) <= ROUNDOFF_OF_ARC:
        return finer
    points = finer.p.copy()
    points[:, arc] *= scale
    return replace(finer, doflocs=points)


def _points_of_arc(mesh: MeshTri, outer: float) -> Indices:
    """Return the points of the arc off its ends, among them the middles of chords.

    The sides of the arc belong to one triangle each, and one of their ends lies on the arc. So only
    the triangles at such points are searched: all facets of the mesh would take most of the time.
    """
    on_arc = np.abs(np.hypot(*mesh.p) / outer - 1) <= ROUNDOFF_OF_ARC
    at_arc = mesh.t[:, on_arc[mesh.t].any(axis=0)]
    sides = np.sort(np.stack([at_arc, np.roll(at_arc, 1, axis=0)]).reshape(2, -1), axis=0)
    sides, counts = np.unique(sides[:, on_arc[sides].any(axis=0)], axis=1, return_counts=True)
    outermost = np.unique(sides[:, counts == 1])
    # other points of the boundary are on the axis or on the surface
    return outermost[(mesh.p[:, outermost] > 0).all(axis=0)]


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
    r, z = mesh.p[:, mesh.t]
    # the triangles with a side on the surface, and the ends of that side
    triangles = np.flatnonzero((z == 0).sum(axis=0) == 2)
    on_surface = z[:, triangles] == 0
    low = np.where(on_surface, r[:, triangles], np.inf).min(axis=0)
    high = np.where(on_surface, r[:, triangles], -np.inf).max(axis=0)
    first, last = (np.searchsorted(dyadic, r) for r in (low + spacing / 8, high - spacing / 8))
    return triangles[(low < 1) & (first < last)]


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
