"""Mesh the half-space of a deck by quadrilaterals, with nodes at ring edges and graded there.

Non-dimensional: the punch has radius 1, and depth is positive into the half-space.
"""

import itertools
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from skfem import MeshQuad

from ...meshes import (
    Array,
    Ground,
    Indices,
    MeshError,
    SceneError,
    as_half_space,
    contact_facets,
    contact_radii,
    facet_ends,
    from_axis,
    halved,
    structured,
)
from ...meshes.by_gmsh import GradedQuads, first_that_succeeds, graded, truncation_with_interfaces

RIM_SIZE = 1.44
"""Size of the elements at the rim over the square of the size inside. Near a root singularity the
error of an element is proportional to the root of its size, elsewhere to the square of its size."""
WIDE = 0.5
"""Width of a ring, in punch radii, below which its elements are smaller in proportion."""
GROWTH = 2.0
"""Growth of the element size per distance from an edge, over the size inside."""
MIN_REACH = 8.0
"""Least radius of the half-space, in punch radii."""
MAX_ELEMENTS = 200_000
"""Greatest number of elements."""
TOO_LARGE = (
    "the deck would have {} elements, more than "
    f"{MAX_ELEMENTS}: give a larger size, or fewer rings"
)
GROWTHS = (1.0, 0.9, 0.8, 0.7, 0.6)
"""Growth of the size of quadrilaterals of layers per distance, in the order that is tried."""
HALVINGS, MAX_SIZE_AT_EDGE = 2, 0.3
"""How often the quadrilaterals of layers are halved, at least, and their largest size at a ring
edge before, over the width of the narrower ring there."""


@dataclass(frozen=True, eq=False)
class DeckMesh:
    """The mesh of a deck: numbered nodes, elements and sets of nodes.

    Parameters
    ----------
    mesh : mesh of scikit-fem, with named boundaries
    quadratic : whether elements also have nodes in the middles of their sides
    """

    mesh: MeshQuad
    quadratic: bool

    @cached_property
    def points(self) -> Array:
        """(n, 2) radius and depth of the nodes: the vertices, then the middles of all sides."""
        middles = self.mesh.p[:, self.mesh.facets].mean(axis=1)
        return np.hstack([self.mesh.p, middles] if self.quadratic else [self.mesh.p]).T

    @cached_property
    def _around(self) -> tuple[Indices, Indices]:
        """Corners and sides (4, m) of the elements, anticlockwise with the height upwards."""
        corners, sides = self.mesh.t, self.mesh.t2f
        r, z = self.mesh.p[:, corners]
        twice_area = (r * np.roll(z, -1, axis=0) - np.roll(r, -1, axis=0) * z).sum(axis=0)
        # depth points down: clockwise in radius and depth is anticlockwise in radius and height
        clockwise = twice_area < 0
        corners = np.where(clockwise, corners, corners[[0, 3, 2, 1]])
        return corners, np.where(clockwise, sides, sides[::-1])

    @cached_property
    def cells(self) -> Indices:
        """(m, 4 or 8) nodes of the elements: corners and middles of sides, as in CAX4 and CAX8."""
        corners, sides = self._around
        middles = sides + self.mesh.nvertices
        return np.vstack([corners, middles] if self.quadratic else [corners]).T

    @cached_property
    def contact(self) -> Indices:
        """(k,) contact nodes from the axis, or from the hole, to the rim."""
        return self._nodes_along(self._facets)

    @cached_property
    def faces(self) -> list[tuple[int, int]]:
        """Elements at the contact, from inside to outside, each with its side there, from 1."""
        _, sides = self._around
        cells = self.mesh.f2t[0, self._facets]
        numbers = (sides[:, cells] == self._facets).argmax(axis=0) + 1
        return list(zip(cells.tolist(), numbers.tolist(), strict=True))

    @property
    def axis(self) -> Indices:
        """Nodes on the axis."""
        return self._nodes_along(self.mesh.boundaries["axis"])

    @property
    def base(self) -> Indices:
        """Nodes on a rigid base at which the mesh ends; empty without one."""
        return self._nodes_along(self.mesh.boundaries.get("base", np.empty(0, dtype=np.int64)))

    @property
    def far(self) -> Indices:
        """Nodes on the clamped arc."""
        return self._nodes_along(self.mesh.boundaries["far"])

    @property
    def _facets(self) -> Indices:
        return contact_facets(self.mesh)

    def _nodes_along(self, facets: Indices) -> Indices:
        """Return the nodes of facets, sorted by radius and then by depth."""
        ends = np.unique(facet_ends(self.mesh, facets))
        nodes = np.append(ends, facets + self.mesh.nvertices) if self.quadratic else ends
        r, z = self.points[nodes].T
        return nodes[np.lexsort((z, r))]


def deck_mesh(ring_edges: Array, size: float, reach: float, quadratic: bool) -> DeckMesh:
    """Return the mesh of a quarter disc for a deck.

    Parameters
    ----------
    ring_edges : (N+1,) from 0 or the radius of a hole to 1
    size : of the elements below the punch, away from ring edges, in punch radii
    reach : radius of the quarter disc, in punch radii
    quadratic : whether elements also have nodes in the middles of their sides

    Raises
    ------
    SceneError
        if the reach is out of range, or if the mesh would be too large
    """
    refuse_reach(reach)
    edges = from_axis(ring_edges)
    radii, least = _radii(edges, size), _edge_sizes(edges, size)[1:].min()
    depths = structured.growing_distances(structured.SQUARE, least, size, GROWTH * size)
    shells = structured.shells_around(reach, GROWTH * size)
    around = len(radii) + len(depths) - 2
    count = (len(radii) - 1) * (len(depths) - 1) + around * (len(shells) - 1)
    if count > MAX_ELEMENTS:
        raise SceneError(TOO_LARGE.format(count))
    mesh = structured.quarter_disc(radii, depths, shells)
    return DeckMesh(as_half_space(mesh, ring_edges), quadratic)


def layered_mesh(
    ring_edges: Array, size: float, reach: float, quadratic: bool, ground: Ground
) -> DeckMesh:
    """Return the mesh of a quarter disc of layers, whose interfaces are lines of the mesh.

    It is made by gmsh in larger quadrilaterals, which are halved. The other arguments are those of
    `deck_mesh`.

    Raises
    ------
    SceneError
        if the reach is out of range, or if the mesh would be too large
    """
    refuse_reach(reach)
    edges, interfaces = from_axis(ring_edges), tuple(ground.depths.tolist())
    widths, scale = np.diff(edges), 2**HALVINGS
    at_edges = scale * _edge_sizes(edges, size)[1:]
    narrower = np.minimum(widths, np.append(widths[1:], np.inf))
    sizes = np.minimum(at_edges, MAX_SIZE_AT_EDGE * narrower)

    def generate(growth: float) -> GradedQuads:
        return graded(
            ring_edges,
            sizes[:-1],
            float(sizes[-1]),
            factor=0.5,
            growth=growth,
            outer=truncation_with_interfaces(interfaces, reach),
            interfaces=interfaces,
            rigid=ground.rigid,
        )

    try:
        layered = first_that_succeeds(generate, GROWTHS)
    except MeshError as error:
        raise SceneError(
            f"the layers could not be meshed: {error}; give another --reach"
        ) from error
    widest = float(np.diff(contact_radii(layered.mesh)).max())
    halvings = max(HALVINGS, int(np.ceil(np.log2(widest / size))))
    if (count := layered.mesh.nelements * 4**halvings) > MAX_ELEMENTS:
        raise SceneError(TOO_LARGE.format(count))
    return DeckMesh(halved(layered.mesh, ring_edges, halvings), quadratic)


def refuse_reach(reach: float) -> None:
    """Refuse a radius of the modelled half-space that is out of range.

    Raises
    ------
    SceneError
        if it is
    """
    if not MIN_REACH <= reach <= 1e6:
        raise SceneError(
            f"--reach {reach:g}: give the radius of the modelled half-space in punch radii, "
            f"{MIN_REACH:g} to 1e6"
        )


def _edge_sizes(edges: Array, size: float) -> Array:
    """Return the sizes (M+1,) of elements at the axis, which is 0, and at the other edges."""
    scales = np.minimum(np.diff(edges) / WIDE, 1.0)
    return np.append(0.0, RIM_SIZE * size**2 * np.minimum(scales, np.append(scales[1:], np.inf)))


def _radii(edges: Array, size: float) -> Array:
    """Return the radii of the vertices of the square, from 0 to its side."""
    grow = partial(structured.growing_distances, growth=GROWTH * size)
    edge_sizes, lines = _edge_sizes(edges, size), list[Array]([np.zeros(1)])
    largest = size * np.minimum(np.diff(edges) / WIDE, 1.0)
    for number, (start, end) in enumerate(itertools.pairwise(edges)):
        # sizes grow to the middle of a ring, or to the axis
        middle = (start + end) / 2 if start else 0.0
        if start:
            lines.append(start + grow(middle - start, edge_sizes[number], largest[number])[1:])
        lines.append((end - grow(end - middle, edge_sizes[number + 1], largest[number])[::-1])[1:])
    lines.append(1 + grow(structured.SQUARE - 1, edge_sizes[-1], size)[1:])
    radii = np.concatenate(lines)
    # remove the roundoff of ring edges and of the end
    for exact in (*edges, structured.SQUARE):
        radii[np.abs(radii - exact).argmin()] = exact
    return radii
