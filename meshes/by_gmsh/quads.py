"""The quarter disc in quadrilaterals: geometric layers round every ring edge, gmsh between them.

Each layer round a singular point is a copy of the next outer layer, smaller by a constant factor.
It consists of four quadrilaterals, and two kites fill the middle. Polynomials whose degree rises
from layer to layer converge exponentially there. Neighbouring patches touch inside a ring if their
sizes allow it. The outline of a patch is a diamond, and gmsh divides each of its sides into two.
The solution is smooth outside the patches, so a few large quadrilaterals of high degree are enough
there.
"""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skfem import MeshQuad

from ..errors import MeshError
from ..half_space import DEEP_SUBDOMAIN, LOWERED_DEGREE_PREFIX, ExactQuads, as_half_space, quality
from ..radial import Array, Indices, exact_sum, from_axis
from ..sizes import (
    LARGEST_QUADRILATERAL,
    Amplitude,
    EdgeAmplitude,
    adjacent_sizes,
    degree_reductions,
    patch_layers,
    patch_widths,
)
from .outline import Blocks, Outline, add_corners, add_surfaces
from .session import QUADRILATERAL, TRIANGLE, Band, elements, session, set_sizes

# Largest half-width of a patch, relative to the thickness of the first elastic layer. The patches
# then lie within that layer.
PATCH_TO_LAYER_RATIO = 0.6
# Largest size of quadrilaterals over the thickness of their layer, if sizes under the face are
# limited, or if gmsh fails without this limit. With 20, gmsh leaves degenerate elements in one of
# 60 meshes, with 40 in 9 of 60
# (unit/meshes/test_half_space_mesh.py::test_thin_layers_are_divided_into_upright_columns).
FLATTEST = 10.0
# Least length of a part of the first layer that is divided into columns, over their width.
LEAST_COLUMNS = 1.0


@dataclass(frozen=True, eq=False)
class GradedQuads:
    """A quarter disc of quadrilaterals, with the parameters that define it.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1 (the rim)
    widths : (M, 2) half-widths of the patch at each edge except the centre, towards the axis and
        away from it
    layers : (M,) number of layers of each patch outside its two kites
    factor : ratio of the size of a layer to that of the next outer layer
    between : points (2, n) and quadrilaterals (4, m) outside the patches
    edge_amplitude : estimate of the amplitude of the highest degree near an edge, which determines
        where a lower degree is enough
    lacking_degrees : difference between the highest degree that the amplitude requires and the
        highest degree available
    base : depth of a rigid base at which the mesh ends; infinite without one
    axis_layers : number of layers round the origin
    """

    ring_edges: Array
    widths: Array
    layers: Indices
    factor: float
    between: tuple[Array, Indices]
    edge_amplitude: Amplitude
    lacking_degrees: int = 0
    base: float = np.inf
    axis_layers: int = 0

    @cached_property
    def mesh(self) -> MeshQuad:
        """The scikit-fem mesh.

        In its subdomains `degree -1`, `degree -2`, ... the degree of the displacement may be lower
        by 1, 2, ... The subdomain `DEEP_SUBDOMAIN` contains the elements outside the patches that
        do not touch the surface.

        Raises
        ------
        MeshError
            if the mesh has a gap, a fold, a missing ring edge or a degenerate element
        """
        points, patch_low_parts, quadrilaterals, reductions = self._patches()
        outside_points, between = _with_layers_at_axis(*self.between, self.axis_layers, self.factor)
        # corners on the outlines belong to the patches and to gmsh's part: keep each only once
        ends = np.cumsum(5 * (self.layers + 1) + 1)
        nearest, duplicate = np.zeros(points.shape[1], int), np.zeros(points.shape[1], bool)
        for first, size in zip([0, *ends[:-1]], self.widths.min(axis=1), strict=True):
            corners = slice(first, first + 5)
            distances = np.linalg.norm(outside_points[:, None] - points[:, corners, None], axis=0)
            nearest[corners] = distances.argmin(axis=1)
            duplicate[corners] = distances.min(axis=1) < 1e-6 * size
        vertex_numbers = np.where(
            duplicate, nearest, outside_points.shape[1] + np.cumsum(~duplicate) - 1
        )
        cells = np.concatenate([vertex_numbers[quadrilaterals], between], axis=1)
        subdomains = {
            f"{LOWERED_DEGREE_PREFIX}{k}": np.flatnonzero(reductions == k)
            for k in np.unique(reductions[reductions > 0])
        }
        subdomains[DEEP_SUBDOMAIN] = len(reductions) + np.flatnonzero(
            outside_points[1, between].min(axis=0) > 0
        )
        vertices = np.concatenate([outside_points, points[:, ~duplicate]], axis=1)
        low_parts = np.append(np.zeros(outside_points.shape[1]), patch_low_parts[~duplicate])
        mesh = ExactQuads(vertices, cells, low_parts=low_parts)
        return as_half_space(mesh.with_subdomains(subdomains), self.ring_edges, self.base)

    def coarser(self) -> "GradedQuads":
        """Return the same quarter disc without the innermost layer of each patch and at the axis.

        A patch that has only one layer keeps it.
        """
        at_axis = max(self.axis_layers - 1, 0)
        return replace(self, layers=np.maximum(self.layers - 1, 1), axis_layers=at_axis)

    def _patches(self) -> tuple[Array, Array, Indices, Indices]:
        """Return the points and quadrilaterals of the patches, and the reductions of their degrees.

        The four arrays are the points (2, n), the low parts of their radii (n,), the quadrilaterals
        (4, m), and by how much the degree of each may be lowered (m,).
        """
        outline = np.array([[-1.0, 0.0], [-0.5, 0.5], [0.0, 1.0], [0.5, 0.5], [1.0, 0.0]])
        # Corners of a layer of half-width 1, from the surface on the axis side of the singular
        # point to the surface on its other side. `outline` holds those of the outermost layer,
        # `layer` those of all others.
        layer = np.array([[-1.0, 0.0], [-0.75, 0.75], [0.0, 1.0], [0.75, 0.75], [1.0, 0.0]])
        points, low_parts, quadrilaterals, reductions, count = [], [], [], [], 0
        reductions_of_patches = degree_reductions(
            self.widths, self.layers, self.factor, self.edge_amplitude, self.lacking_degrees
        )
        for centre, (inner, outer), patch_reductions in zip(
            self.ring_edges[self.ring_edges > 0], self.widths, reductions_of_patches, strict=True
        ):
            depth = len(patch_reductions) - 1
            shapes = np.stack([outline, *[layer] * depth])
            shapes = shapes * self.factor ** np.arange(depth + 1.0)[:, None, None]
            offsets = np.where(shapes[..., 0] < 0, inner, outer) * shapes[..., 0]
            x, low = exact_sum(centre, offsets)
            z = (inner + outer) / 2 * shapes[..., 1]
            points.append(np.stack([np.append(x, centre), np.append(z, 0.0)]))
            low_parts.append(np.append(low, 0.0))
            corners = count + np.arange(x.size).reshape(-1, 5)
            count += x.size + 1
            layer_cells = np.stack(
                [corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]]
            )
            last, middle = corners[-1], count - 1
            kites = np.array(
                [[last[0], middle, last[2], last[1]], [middle, last[4], last[3], last[2]]]
            ).T
            quadrilaterals += [layer_cells.reshape(4, -1), kites]
            reductions += [np.repeat(patch_reductions[:-1], 4), np.repeat(patch_reductions[-1:], 2)]
        return (
            np.concatenate(points, axis=1),
            np.concatenate(low_parts),
            np.concatenate(quadrilaterals, axis=1),
            np.concatenate(reductions),
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
    under_face: ArrayLike = np.inf,
    axis_size: float | None = None,
) -> GradedQuads:
    """Mesh the quarter disc.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1 (the rim)
    sizes : largest size of the kites at each edge between centre and rim, either one number or one
        for each
    rim_size : largest size of the kites at the rim
    factor : ratio of the size of a layer to that of the next outer layer
    growth : increase of the element size per distance from the patches
    outer : truncation radius of the half-space, in punch radii
    edge_amplitude : estimate of the amplitude of the highest degree near an edge, which determines
        where a lower degree is enough; the default is that of unworn rings
    lacking_degrees : difference between the highest degree that the amplitude requires and the
        highest degree available
    interfaces : depths of the interfaces between elastic layers; those less deep than `outer` are
        lines of the mesh
    rigid : whether the last interface is a rigid base; the mesh ends there if it is less deep than
        `outer`
    under_face : largest size of the elements of the first layer under each of the N rings, either
        one number or one for each
    axis_size : largest size of the elements at the origin; without it, there are no layers round it

    Raises
    ------
    MeshError
        if a ring is narrower than 1e-10 a, or if gmsh cannot be loaded or fails with all its
        algorithms
    """
    # Pairs of gmsh's numbers for the meshing and the recombination algorithm, in the order in which
    # they are tried. In a trial with 200 punches of 8 to 70 rings, the first pair left a triangle
    # or a fold for one punch in 30, the second pair for a single punch. Now and then an algorithm
    # does not refine where it should, which leads to flat quadrilaterals. A mesh is accepted at
    # once if the least sine of its corners is at least `accepted_quality`.
    algorithms, accepted_quality = ((6, 3), (5, 3), (5, 2)), 0.1
    ring_edges = np.asarray(ring_edges, dtype=float)
    edges = from_axis(ring_edges)
    # coordinates cannot resolve a narrower ring and its layers
    if np.diff(edges).min() < 1e-10:
        raise MeshError("a ring is narrower than 1e-10 a: merge it with a neighbour")
    widths = patch_widths(ring_edges)
    outline = Outline.of_layers(outer, interfaces, rigid)
    if outline.interfaces:
        widths = np.minimum(widths, PATCH_TO_LAYER_RATIO * outline.interfaces[0])
    layers = patch_layers(
        widths, np.append(np.broadcast_to(sizes, len(edges) - 2), rim_size), factor
    )
    under_face = np.broadcast_to(under_face, len(ring_edges) - 1)
    # sizes are not limited under a hole
    under_face = np.append(np.full(len(edges) - len(ring_edges), np.inf), under_face)
    edge_amplitude = edge_amplitude or EdgeAmplitude(
        0.0, np.zeros(len(widths)), np.ones(len(widths))
    )
    flattest = [FLATTEST] if np.isfinite(under_face).any() else [np.inf]
    if outline.interfaces and flattest == [np.inf]:
        flattest.append(FLATTEST)
    candidates: list[tuple[float, GradedQuads]] = []
    for flatness, algorithm_pair in itertools.product(flattest, algorithms):
        if flatness != flattest[0] and candidates:
            break
        sizes_between = SizesBetween(growth, under_face, flatness)
        try:
            points, cells = _between(edges, widths, sizes_between, outline, algorithm_pair)
            # gmsh returns coordinates that should be zero with roundoff
            points = np.where(np.abs(points) < 1e-14, 0.0, points)
            size = points[:, cells[:, _at_origin(points)[cells].any(axis=0)]].max()
            axis_layers = max(0, int(np.ceil(np.log((axis_size or size) / size) / np.log(factor))))
            graded = GradedQuads(
                ring_edges,
                widths,
                layers,
                factor,
                (points, cells),
                edge_amplitude,
                lacking_degrees,
                outline.base,
                axis_layers,
            )
            candidates.append((quality(graded.mesh).min(), graded))
        except MeshError as error:
            reason = error
            continue
        if candidates[-1][0] >= accepted_quality:
            break
    if not candidates:
        raise MeshError(f"no quadrilaterals between the rings: {reason}")
    return max(candidates, key=itemgetter(0))[1]


def _at_origin(points: Array) -> NDArray[np.bool_]:
    """Return which of the points (2, n) is the origin."""
    return (points == 0).all(axis=0)


def _with_layers_at_axis(
    points: Array, cells: Indices, count: int, factor: float
) -> tuple[Array, Indices]:
    """Return the points and quadrilaterals (4, m) with layers in those that touch the origin.

    Each layer is a copy of the next outer one, smaller by the factor, so that neighbours have the
    same vertices on their common sides.
    """
    touching = _at_origin(points)[cells]
    innermost, others = cells[:, touching.any(axis=0)], [cells[:, ~touching.any(axis=0)]]
    # the origin is the first corner
    shift = _at_origin(points)[innermost].argmax(axis=0)
    innermost = np.take_along_axis(innermost, (np.arange(4)[:, None] + shift) % 4, axis=0)
    for _ in range(count):
        origin, *outer = innermost
        moved, numbers = np.unique(outer, return_inverse=True)
        inner = points.shape[1] + numbers.reshape(3, -1)
        points = np.concatenate([points, factor * points[:, moved]], axis=1)
        others += [np.stack([inner[i], outer[i], outer[i + 1], inner[i + 1]]) for i in (0, 1)]
        innermost = np.stack([origin, *inner])
    return points, np.concatenate([*others, innermost], axis=1)


class SizesBetween(NamedTuple):
    """Sizes of the quadrilaterals between the patches.

    Parameters
    ----------
    growth : increase of the size per distance from the patches
    under_face : (M,) largest size in the first layer under each ring and under a hole
    flattest : largest size over the thickness of a layer above the lowest interface
    """

    growth: float
    under_face: Array
    flattest: float


def _between(
    edges: Array,
    widths: Array,
    sizes: SizesBetween,
    outline: Outline,
    algorithm_pair: tuple[int, int],
) -> tuple[Array, Indices]:
    """Return the points and quadrilaterals between the patches and the arc.

    `algorithm_pair` holds gmsh's numbers for the meshing and the recombination algorithm.

    Raises
    ------
    MeshError
        if gmsh fails or leaves a triangle
    """
    with session() as gmsh:
        gmsh.option.setNumber("Mesh.RecombineAll", 1)
        gmsh.option.setNumber("Mesh.Algorithm", algorithm_pair[0])
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", algorithm_pair[1])
        _geometry(gmsh, edges, widths, sizes, outline)
        # gmsh divides every curve into an even number of sides, except curves that have only one
        # side
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
    gmsh: ModuleType,
    edges: Array,
    widths: Array,
    sizes: SizesBetween,
    outline: Outline,
) -> None:
    geometry = gmsh.model.geo
    corners = add_corners(geometry, outline)
    columns, blocks = columns_under_face(edges, widths, sizes), None
    if columns:
        axis = geometry.addLine(corners.axis_ends[0], corners.origin)
        blocks = Blocks(geometry, outline.bottoms[0], corners.axis_ends[0], axis)
    curves, previous, at_patches, end = [], corners.origin, [], 0.0
    for number, (inside, outside) in enumerate(widths):
        centre, start = edges[number + 1], previous
        if blocks and (block := columns.get(number)):
            for radius, count in ((block.inner, None), (block.outer, block.columns)):
                if radius == 0:
                    continue
                point = geometry.addPoint(radius, 0, 0)
                curves.append(geometry.addLine(previous, point))
                blocks.add(curves, point, radius, count)
                curves, previous = [], point
            start = previous
        if centre - inside - end > 1e-9 * inside:
            start = geometry.addPoint(centre - inside, 0, 0)
            curves.append(geometry.addLine(previous, start))
        end = centre + outside
        bottom_point = geometry.addPoint(centre, (inside + outside) / 2, 0)
        previous = geometry.addPoint(end, 0, 0)
        for a, b in ((start, bottom_point), (bottom_point, previous)):
            curves.append(geometry.addLine(a, b))
            geometry.mesh.setTransfiniteCurve(curves[-1], 3)
        at_patches.append((start, bottom_point, previous))
    curves.append(geometry.addLine(previous, corners.surface_end))
    add_surfaces(geometry, outline, corners, curves, blocks)
    geometry.synchronize()
    largest = LARGEST_QUADRILATERAL * outline.outer
    bands = _bands(edges, sizes, outline, largest)
    set_sizes(gmsh, np.array(at_patches), adjacent_sizes(widths), sizes.growth, largest, bands)


class Columns(NamedTuple):
    """Upright columns of quadrilaterals in the first layer under a ring.

    Parameters
    ----------
    inner, outer : radii between which they are
    columns : even number of columns
    """

    inner: float
    outer: float
    columns: int


def columns_under_face(edges: Array, widths: Array, sizes: SizesBetween) -> dict[int, Columns]:
    """Return the columns of quadrilaterals in the first layer, by the number of the ring.

    Between two patches gmsh would make sheared quadrilaterals in a thin layer, with which some
    pressures are unstable near incompressibility. Columns begin where the size that grows from the
    patches reaches the limit under the face.

    Parameters
    ----------
    edges : (M+1,) ring edges from the axis
    widths : (M, 2) half-widths of the patch at each edge except the centre
    sizes : sizes between the patches; there are columns only where `under_face` is finite
    """
    columns = {}
    for ring, limit in enumerate(sizes.under_face):
        if not np.isfinite(limit):
            continue
        distances = np.maximum(limit - adjacent_sizes(widths), 0.0) / sizes.growth
        inner = edges[ring] + widths[ring - 1, 1] + distances[ring - 1] if ring else 0.0
        outer = edges[ring + 1] - widths[ring, 0] - distances[ring]
        if outer - inner > LEAST_COLUMNS * limit:
            # gmsh divides all other curves into an even number of sides
            count = 2 * int(np.ceil((outer - inner) / (2 * limit)))
            columns[ring] = Columns(float(inner), float(outer), count)
    return columns


def _bands(edges: Array, sizes: SizesBetween, outline: Outline, largest: float) -> list[Band]:
    """Return the limits on sizes in layers; `largest` is the largest size anywhere."""
    bands = [
        Band(0.0, outline.bottoms[0], float(size), float(inner), float(outer))
        for size, inner, outer in zip(sizes.under_face, edges[:-1], edges[1:], strict=True)
        if size < largest
    ]
    for top, bottom in itertools.pairwise((0.0, *outline.interfaces)):
        flattest = sizes.flattest * (bottom - top)
        if top == 0.0:
            flattest = max([flattest, *(band.largest for band in bands)])
        if flattest < largest:
            bands.append(Band(top, bottom, flattest))
    return bands
