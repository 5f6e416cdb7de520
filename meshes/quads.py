"""The quarter disc in quadrilaterals: geometric layers round every ring edge, gmsh between them.

Round a singular point each layer is a copy of the one outside it, smaller by a factor: four
quadrilaterals to a layer, and two kites in the middle. Polynomials whose degree rises from layer to
layer converge exponentially there. Neighbouring patches touch in the middle of a ring where their
sizes allow it; the outline of a patch is a diamond, of which gmsh meshes each side as two. Outside
the patches everything is smooth, and a few large quadrilaterals of high degree are enough.
"""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from skfem import MeshQuad

from .errors import MeshError
from .gmsh_session import QUADRILATERAL, TRIANGLE, elements, session, set_sizes
from .half_space import DEEP, LOWER, ExactQuads, as_half_space, quality
from .outline import Outline, add_corners, add_surfaces
from .radial import Array, Indices, exact_sum
from .sizes import (
    LARGEST,
    Amplitude,
    EdgeAmplitude,
    adjacent_sizes,
    degree_reductions,
    patch_layers,
    patch_widths,
)

# half-width of a patch over the first layer, at the most: patches lie within it
PATCH_OF_LAYER = 0.6


@dataclass(frozen=True, eq=False)
class GradedQuads:
    """A quarter disc of quadrilaterals and how it was made.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, 0 first and 1 (the rim) last
    widths : (N, 2) half-width of the patch at each edge but the centre, towards the axis and away
        from it
    layers : (N,) layers of each patch outside its two kites
    factor : size of a layer over that of the layer outside it
    between : points (2, n) and quadrilaterals (4, m) outside the patches
    edge_amplitude : of the highest degree near an edge, which says where a lower degree will do
    lacking_degrees : by how many degrees the highest one falls short of what the amplitude asks for
    base : depth of a rigid base, at which the mesh ends
    """

    ring_edges: Array
    widths: Array
    layers: Indices
    factor: float
    between: tuple[Array, Indices]
    edge_amplitude: Amplitude
    lacking_degrees: int = 0
    base: float = np.inf

    @cached_property
    def mesh(self) -> MeshQuad:
        """The mesh.

        In its subdomains `degree -1`, `degree -2`, ... the degree of the displacement may be so
        much lower; what is outside the patches and below the surface is its subdomain `DEEP`.

        Raises
        ------
        MeshError
            if it is not what was asked for
        """
        points, low, quadrilaterals, lower = self._patches()
        outside, between = self.between
        # what gmsh leaves of zero
        outside = np.where(np.abs(outside) < 1e-14, 0.0, outside)
        # the corners of the outlines are there twice
        distance, nearest = cKDTree(outside.T).query(points.T)
        scale = np.repeat(self.widths.min(axis=1), 5 * (self.layers + 1) + 1)
        same = distance < 1e-6 * scale
        number = np.where(same, nearest, outside.shape[1] + np.cumsum(~same) - 1)
        cells = np.concatenate([number[quadrilaterals], between], axis=1)
        parts = {f"{LOWER}{k}": np.flatnonzero(lower == k) for k in np.unique(lower[lower > 0])}
        parts[DEEP] = len(lower) + np.flatnonzero(outside[1, between].min(axis=0) > 0)
        vertices = np.concatenate([outside, points[:, ~same]], axis=1)
        low_parts = np.append(np.zeros(outside.shape[1]), low[~same])
        mesh = ExactQuads(vertices, cells, low_parts=low_parts)
        return as_half_space(mesh.with_subdomains(parts), self.ring_edges, self.base)

    def coarser(self) -> "GradedQuads":
        """Return the same without the innermost layer of every patch that has more than one."""
        return replace(self, layers=np.maximum(self.layers - 1, 1))

    def _patches(self) -> tuple[Array, Array, Indices, Indices]:
        """Return the points and quadrilaterals of the patches, and where degrees may be lower.

        The four arrays are the points (2, n), what rounding has taken from their radii (n,), the
        quadrilaterals (4, m), and by how much the degree of each may be lowered (m,).
        """
        outline = np.array([[-1.0, 0.0], [-0.5, 0.5], [0.0, 1.0], [0.5, 0.5], [1.0, 0.0]])
        # corners of a layer of half-width 1, from the surface inside the singular point to that
        # outside it; and of the outermost
        layer = np.array([[-1.0, 0.0], [-0.75, 0.75], [0.0, 1.0], [0.75, 0.75], [1.0, 0.0]])
        points, low_parts, quadrilaterals, lower, count = [], [], [], [], 0
        lowered = degree_reductions(
            self.widths, self.layers, self.factor, self.edge_amplitude, self.lacking_degrees
        )
        for centre, (inner, outer), fall in zip(
            self.ring_edges[1:], self.widths, lowered, strict=True
        ):
            depth = len(fall) - 1
            shapes = np.stack([outline, *[layer] * depth])
            shapes = shapes * self.factor ** np.arange(depth + 1.0)[:, None, None]
            away = np.where(shapes[..., 0] < 0, inner, outer) * shapes[..., 0]
            x, low = exact_sum(centre, away)
            z = (inner + outer) / 2 * shapes[..., 1]
            points.append(np.stack([np.append(x, centre), np.append(z, 0.0)]))
            low_parts.append(np.append(low, 0.0))
            corners = count + np.arange(x.size).reshape(-1, 5)
            count += x.size + 1
            around = np.stack(
                [corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]]
            )
            last, middle = corners[-1], count - 1
            kites = np.array(
                [[last[0], middle, last[2], last[1]], [middle, last[4], last[3], last[2]]]
            ).T
            quadrilaterals += [around.reshape(4, -1), kites]
            lower += [np.repeat(fall[:-1], 4), np.repeat(fall[-1:], 2)]
        return (
            np.concatenate(points, axis=1),
            np.concatenate(low_parts),
            np.concatenate(quadrilaterals, axis=1),
            np.concatenate(lower),
        )


def graded(
    ring_edges: ArrayLike,
    sizes: ArrayLike,
    rim_size: float,
    factor: float,
    growth: float,
    outer: float,
    edge_amplitude: Amplitude | None = None,
    lacking_degrees: int = 0,
    interfaces: tuple[float, ...] = (),
    rigid: bool = False,
) -> GradedQuads:
    """Mesh the quarter disc.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, 0 first and 1 (the rim) last
    sizes : greatest size of the kites at each of the N-1 edges between: one for all of them, or one
        for each
    rim_size : the same at the rim
    factor : size of a layer over that of the layer outside it
    growth : growth of the elements with the distance from the patches
    outer : truncation radius of the half-space, in punch radii
    edge_amplitude : of the highest degree near an edge, which says where a lower degree will do; by
        default as if nothing had worn
    lacking_degrees : by how many degrees the highest one falls short of what the amplitude asks for
    interfaces : depths of the interfaces of layers; those within the mesh are lines of it
    rigid : whether the last of these is a rigid base, at which the mesh ends

    Raises
    ------
    MeshError
        if a ring is too narrow, or gmsh cannot be loaded, or fails in every way
    """
    # gmsh's numbers of algorithms, of meshing and of recombination. Of 200 punches of 8 to 70 rings
    # the first leaves a triangle or folds the mesh in one of 30, the second in one. They forget to
    # refine now and then, which shows in flat quadrilaterals: those of this least sine are good
    # enough
    ways, good = ((6, 3), (5, 3), (5, 2)), 0.1
    ring_edges = np.asarray(ring_edges, dtype=float)
    # it would be lost to roundoff, layers and all
    if np.diff(ring_edges).min() < 1e-10:
        raise MeshError("a ring is narrower than 1e-10 a: merge it with a neighbour")
    widths = patch_widths(ring_edges)
    outline = Outline.of_layers(outer, interfaces, rigid)
    if outline.interfaces:
        widths = np.minimum(widths, PATCH_OF_LAYER * outline.interfaces[0])
    layers = patch_layers(
        widths, np.append(np.broadcast_to(sizes, len(ring_edges) - 2), rim_size), factor
    )
    edge_amplitude = edge_amplitude or EdgeAmplitude(
        0.0, np.zeros(len(widths)), np.ones(len(widths))
    )
    tried: list[tuple[float, GradedQuads]] = []
    for way in ways:
        try:
            between = _between(ring_edges[1:], widths, growth, outline, way)
            graded = GradedQuads(
                ring_edges,
                widths,
                layers,
                factor,
                between,
                edge_amplitude,
                lacking_degrees,
                outline.base,
            )
            tried.append((quality(graded.mesh).min(), graded))
        except MeshError as error:
            reason = error
            continue
        if tried[-1][0] >= good:
            break
    if not tried:
        raise MeshError(f"no quadrilaterals between the rings: {reason}")
    return max(tried, key=itemgetter(0))[1]


def _between(
    centres: Array, widths: Array, growth: float, outline: Outline, way: tuple[int, int]
) -> tuple[Array, Indices]:
    """Return the points and quadrilaterals between the patches and the arc.

    MeshError if gmsh fails or leaves a triangle.
    """
    with session() as gmsh:
        gmsh.option.setNumber("Mesh.RecombineAll", 1)
        gmsh.option.setNumber("Mesh.Algorithm", way[0])
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", way[1])
        _geometry(gmsh, centres, widths, growth, outline)
        # gmsh makes the sides of a curve even in number, but for curves of one side
        gmsh.model.mesh.generate(1)
        curves = [tag for _, tag in gmsh.model.getEntities(1)]
        single = [len(gmsh.model.mesh.getElements(1, tag)[1][0]) == 1 for tag in curves]
        gmsh.model.mesh.clear()
        for tag in itertools.compress(curves, single):
            gmsh.model.mesh.setTransfiniteCurve(tag, 3)
        gmsh.model.mesh.generate(2)
        _, triangles = gmsh.model.mesh.getElementsByType(TRIANGLE)
        if len(triangles):
            raise MeshError("gmsh left a triangle between the quadrilaterals")
        return elements(gmsh, QUADRILATERAL)


def _geometry(
    gmsh: ModuleType, centres: Array, widths: Array, growth: float, outline: Outline
) -> None:
    geometry = gmsh.model.geo
    corners = add_corners(geometry, outline)
    curves, previous, at_patches, end = [], corners.origin, [], 0.0
    for centre, (inside, outside) in zip(centres, widths, strict=True):
        start = previous
        if centre - inside - end > 1e-9 * inside:
            start = geometry.addPoint(centre - inside, 0, 0)
            curves.append(geometry.addLine(previous, start))
        end = centre + outside
        below = geometry.addPoint(centre, (inside + outside) / 2, 0)
        previous = geometry.addPoint(end, 0, 0)
        for a, b in ((start, below), (below, previous)):
            curves.append(geometry.addLine(a, b))
            geometry.mesh.setTransfiniteCurve(curves[-1], 3)
        at_patches.append((start, below, previous))
    curves.append(geometry.addLine(previous, corners.surface_end))
    add_surfaces(geometry, outline, corners, curves)
    geometry.synchronize()
    set_sizes(gmsh, np.array(at_patches), adjacent_sizes(widths), growth, LARGEST * outline.outer)
