"""The quarter disc with a star of quadrilaterals round every ring edge and the rim, and triangles between the stars.

Round a singular point the star is a half square of shells, each a copy of the one outside it, smaller by the same
factor: trapezoids four to a shell, and two squares in the core. Polynomials whose degree rises from shell to shell
converge exponentially there. Outside the stars everything is smooth, and a few large triangles of high degree are enough.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .errors import MeshError
from .gmsh_mesher import session, set_sizes
from .half_space import LOWEST_QUALITY, HalfSpaceMesh, assemble
from .radial import Array, Indices

# half-width of a star in units of the narrower ring beside it: between the stars of a ring remains as much room again,
# so that the triangles there are as large as the stars and as well shaped
HALF_WIDTH = 1 / 3
# greatest triangles, over the truncation
LARGEST_FILL = 0.4
# a ring narrower than this is lost to roundoff, layers and all
NARROWEST = 1e-10
# corners of a shell of half-width 1, from the surface inside the singular point to that outside it
SHELL = np.array([[-1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class StarMesh:
    """Quadrilaterals and triangles of the truncated half-space, with named boundaries.

    Parameters
    ----------
    points : (n, 2) radius and depth
    quadrilaterals : (k, 4) vertex numbers, counter-clockwise
    triangles : (m, 3) vertex numbers, counter-clockwise
    layer : (k,) of each quadrilateral: 0 at the singular point, that is core and innermost shell, rising outwards
    boundaries : facets (k, 2) by name: `contact`, `free`, `axis`, `far`
    mesher : who made it
    """

    points: Array
    quadrilaterals: Indices
    triangles: Indices
    layer: Indices
    boundaries: dict[str, Indices]
    mesher: str

    @property
    def truncation(self) -> float:
        return float(self.points[:, 0].max())

    @property
    def cells(self) -> dict[str, Indices]:
        """Vertex numbers of the elements by kind, in the order of `quality`."""
        return {"quad": self.quadrilaterals, "triangle": self.triangles}

    @cached_property
    def contact_radii(self) -> Array:
        """Radii of the vertices on the contact line, from 0 to 1."""
        return np.sort(self.points[np.unique(self.boundaries["contact"]), 0])

    @cached_property
    def quality(self) -> Array:
        """(k + m,) least sine of the corners of each quadrilateral, 2 x inradius / circumradius of each triangle."""
        fill = HalfSpaceMesh(self.points, self.triangles, self.boundaries, self.mesher)
        sides = np.roll(self.points[self.quadrilaterals], -1, axis=1) - self.points[self.quadrilaterals]
        sides /= np.linalg.norm(sides, axis=2, keepdims=True)
        before = np.roll(sides, 1, axis=1)
        sines = before[..., 0] * sides[..., 1] - before[..., 1] * sides[..., 0]
        return np.concatenate([sines.min(axis=1), fill.quality])

    def coarser(self) -> StarMesh:
        """The same mesh with one shell less in every star: what is inside its innermost shell becomes the core."""
        innermost = self.quadrilaterals[self.layer == 0]
        trapezoids = innermost[: 2 * len(innermost) // 3].reshape(-1, 4, 4)
        centres = innermost[2 * len(innermost) // 3 :][: len(trapezoids), 1]
        outer = np.concatenate([trapezoids[:, :, 0], trapezoids[:, -1:, 3]], axis=1)
        cores = _cores(outer, centres)
        kept = self.quadrilaterals[self.layer > 0]
        layer = np.append(self.layer[self.layer > 0] - 1, np.zeros(len(cores), dtype=np.int64))
        edges = np.append(0.0, np.sort(self.points[centres, 0]))
        return _assembled(self.points, np.concatenate([kept, cores]), layer, self.triangles, edges)


def mesh(edges: ArrayLike, sizes: ArrayLike, rim_size: float, grading: float, growth: float, truncation: float) -> StarMesh:
    """Mesh the quarter disc.

    Parameters
    ----------
    edges : (N+1,) ring edges, 0 first and 1 (the rim) last
    sizes : greatest half-width of the core at each of the N-1 edges between: one for all of them, or one for each
    rim_size : the same at the rim
    grading : size of a shell over that of the shell outside it
    growth : growth of the triangles with the distance from the stars
    truncation : radius of the quarter disc, in punch radii

    Raises
    ------
    MeshError
        if a ring is too narrow, or gmsh cannot be loaded, fails, or leaves a mesh that is not what was asked for
    """
    edges = np.asarray(edges, dtype=float)
    widths = np.diff(edges)
    if widths.min() < NARROWEST:
        raise MeshError(f"a ring is narrower than {NARROWEST:g} a: merge it with a neighbour")
    half_widths, layers = star_shells(edges, sizes, rim_size, grading)
    points, quadrilaterals, layer, outlines = _stars(edges[1:], half_widths, layers, grading)
    points, triangles = _fill(points, outlines, half_widths, growth, truncation)
    return _assembled(points, quadrilaterals, layer, triangles, edges)


def star_shells(edges: ArrayLike, sizes: ArrayLike, rim_size: float, grading: float) -> tuple[Array, Indices]:
    """(N,) half-width of the star at each ring edge but the centre, and the shells in it (see `mesh`)."""
    widths = np.diff(np.asarray(edges, dtype=float))
    wanted = np.append(np.broadcast_to(np.asarray(sizes, dtype=float), len(widths) - 1), rim_size)
    half_widths = HALF_WIDTH * np.minimum(widths, np.append(widths[1:], np.inf))
    return half_widths, np.maximum(1, np.ceil(np.log(wanted / half_widths) / np.log(grading) - 1e-9)).astype(np.int64)


def fill_sizes(half_widths: Array) -> Array:
    """(N,) size of the triangles beside each star: its own, in few distinct values, which is what a mesher digests."""
    return np.asarray(2.0 ** (np.ceil(4 * np.log2(half_widths)) / 4))


def _assembled(points: Array, quadrilaterals: Indices, layer: Indices, triangles: Indices, edges: Array) -> StarMesh:
    """Name the boundaries and check: as for a mesh of triangles only, every quadrilateral cut in two."""
    used, numbers = np.unique(np.concatenate([quadrilaterals.ravel(), triangles.ravel()]), return_inverse=True)
    quadrilaterals = numbers[: quadrilaterals.size].reshape(-1, 4)
    triangles = numbers[quadrilaterals.size :].reshape(-1, 3)
    halves = quadrilaterals[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    whole = assemble(points[used], np.concatenate([halves, triangles]), edges, "stars")
    made = StarMesh(whole.points, quadrilaterals, whole.triangles[len(halves) :], layer, whole.boundaries, whole.mesher)
    if made.quality.min() < LOWEST_QUALITY:
        raise MeshError(f"a quadrilateral is degenerate (quality {made.quality.min():.1e}): ask for a milder grading")
    return made


def _stars(centres: Array, half_widths: Array, layers: Indices, grading: float) -> tuple[Array, Indices, Indices, Indices]:
    """Points, quadrilaterals and their layers, and the (N, 5) corners of the outermost shell of each star."""
    shells = layers + 1
    star = np.repeat(np.arange(len(centres)), shells)
    depth = np.arange(len(star)) - np.repeat(np.cumsum(shells) - shells, shells)
    width = half_widths[star] * grading**depth
    at_surface = np.stack([centres, np.zeros_like(centres)], axis=1)
    points = np.concatenate([at_surface, (at_surface[star, None] + width[:, None, None] * SHELL).reshape(-1, 2)])
    corners = len(centres) + np.arange(5 * len(star)).reshape(-1, 5)
    inside = np.flatnonzero(depth)
    outer, inner = corners[inside - 1], corners[inside]
    trapezoids = np.stack([outer[:, :-1], inner[:, :-1], inner[:, 1:], outer[:, 1:]], axis=2).reshape(-1, 4)
    layer = np.repeat(layers[star[inside]] - depth[inside], 4)
    cores = _cores(corners[depth == layers[star]], np.arange(len(centres)))
    quadrilaterals = np.concatenate([trapezoids, cores])
    return points, quadrilaterals, np.append(layer, np.zeros(len(cores), dtype=np.int64)), corners[depth == 0]


def _cores(corners: Indices, centres: Indices) -> Indices:
    """The two squares inside each shell, the left ones first, by its (N, 5) corners and its singular point."""
    core = corners.T
    left = np.stack([core[0], centres, core[2], core[1]], axis=1)
    right = np.stack([centres, core[4], core[3], core[2]], axis=1)
    return np.concatenate([left, right])


def _fill(points: Array, outlines: Indices, half_widths: Array, growth: float, truncation: float) -> tuple[Array, Indices]:
    """The points with those of the triangles added, and the triangles between the stars and the outer arc."""
    ends = np.array([[0.0, 0.0], [truncation, 0.0], [0.0, truncation]])
    given = np.concatenate([points, ends])
    corners = np.concatenate([outlines.ravel(), len(points) + np.arange(3)])
    with session() as gmsh:
        tags = _geometry(gmsh, given[corners])
        at_stars, sizes = tags[:-3].reshape(-1, 5), fill_sizes(half_widths)
        # triangles as large as the stars at their corners, growing with the distance
        groups = [(at_stars[sizes == size].ravel(), size) for size in np.unique(sizes)]
        set_sizes(gmsh, groups, growth, LARGEST_FILL * truncation)
        gmsh.model.mesh.generate(2)
        at_corners = [gmsh.model.mesh.getNodes(0, tag)[0][0] for tag in tags]
        nodes, coordinates, _ = gmsh.model.mesh.getNodes()
        _, cells = gmsh.model.mesh.getElementsByType(2)
    number = np.full(int(nodes.max()) + 1, -1)
    number[at_corners] = corners
    new = number[nodes] < 0
    number[nodes[new]] = len(given) + np.arange(new.sum())
    added = coordinates.reshape(-1, 3)[new, :2]
    return np.concatenate([given, added]), number[cells].reshape(-1, 3)


def _geometry(gmsh: Any, corners: Array) -> Indices:
    """Tags of the corners: of the stars in the order of the radius, then the origin, and both ends of the arc."""
    geometry = gmsh.model.geo
    tags = np.array([geometry.addPoint(r, z, 0) for r, z in corners])
    origin, surface_end, axis_end = tags[-3:]
    # from the origin along the stars: from the end of each to the start of the next, and round it
    line = np.concatenate([[origin], tags[:-3], [surface_end]])
    curves = [geometry.addLine(a, b) for a, b in itertools.pairwise(line)]
    for k, curve in enumerate(curves):
        if k % 5:
            geometry.mesh.setTransfiniteCurve(curve, 2)
    curves += [geometry.addCircleArc(surface_end, origin, axis_end), geometry.addLine(axis_end, origin)]
    geometry.addPlaneSurface([geometry.addCurveLoop(curves)])
    geometry.synchronize()
    return tags
