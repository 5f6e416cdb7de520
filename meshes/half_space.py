"""The truncated half-space as plain arrays: a quarter disc of (radius, depth), graded to the rim and the ring edges.

Natural units: the punch has radius 1. Depth is positive into the half-space; the surface is depth zero. The element
size is ``min(rim_size + growth * d_rim, ring_size + growth * d_edge, far_size * R)`` with the distances to the rim and
to the nearest other ring edge (or the centre), and the truncation radius R: well-shaped elements round every singular
point, in numbers that grow only with the logarithm of the smallest size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .errors import MeshError
from .radial import Array, Indices


@dataclass(frozen=True)
class SizeField:
    """The wanted element size as a function of position.

    Parameters
    ----------
    edges : ring edges, 0 first and 1 (the rim) last
    rim_size : size at the rim
    ring_size : size at the other ring edges: one for all of them, or one for each
    growth : growth of the size with the distance from them
    truncation : radius of the quarter disc, in punch radii
    centre_size : size at the centre of the punch, where little area stands behind the value that people look at
    far_size : greatest size, over the truncation: elements of low degree follow the far field only along short sides
    """

    edges: tuple[float, ...]
    rim_size: float
    ring_size: float | tuple[float, ...]
    growth: float
    truncation: float
    centre_size: float = 0.25
    far_size: float = 0.25

    def __call__(self, points: Array) -> Array:
        """(n,) sizes at (n, 2) points."""
        size = np.minimum(self.largest, self.rim_size + self.growth * np.hypot(points[:, 0] - 1, points[:, 1]))
        for edge, smallest in zip(self.edges[:-1], (self.centre_size, *self.ring_sizes), strict=True):
            size = np.minimum(size, smallest + self.growth * np.hypot(points[:, 0] - edge, points[:, 1]))
        return size

    @property
    def largest(self) -> float:
        """Greatest size anywhere."""
        return self.truncation * self.far_size

    @property
    def ring_sizes(self) -> tuple[float, ...]:
        """Size at each ring edge between the centre and the rim."""
        count = len(self.edges) - 2
        return self.ring_size if isinstance(self.ring_size, tuple) else (self.ring_size,) * count


@dataclass(frozen=True, eq=False)
class HalfSpaceMesh:
    """Triangles of the truncated half-space, with named boundaries.

    Parameters
    ----------
    points : (n, 2) radius and depth
    triangles : (m, 3) vertex numbers, counter-clockwise
    boundaries : facets (k, 2) by name: `contact`, `free`, `axis`, `far`
    mesher : who made it
    """

    points: Array
    triangles: Indices
    boundaries: dict[str, Indices]
    mesher: str

    @property
    def truncation(self) -> float:
        return float(self.points[:, 0].max())

    @property
    def cells(self) -> dict[str, Indices]:
        """Vertex numbers of the elements by kind."""
        return {"triangle": self.triangles}

    @cached_property
    def contact_radii(self) -> Array:
        """Radii of the vertices on the contact line, from 0 to 1."""
        return np.sort(self.points[np.unique(self.boundaries["contact"]), 0])

    @cached_property
    def quality(self) -> Array:
        """(m,) 2 x inradius / circumradius of each triangle: 1 for equilateral, 0 for degenerate."""
        a, b, c = (np.linalg.norm(self._corner(i) - self._corner(j), axis=1) for i, j in ((0, 1), (1, 2), (2, 0)))
        half = (a + b + c) / 2
        return 8 * (half - a) * (half - b) * (half - c) / (a * b * c)

    @cached_property
    def areas(self) -> Array:
        """(m,) signed areas in the (radius, depth) plane."""
        p, q = self._corner(1) - self._corner(0), self._corner(2) - self._corner(0)
        return (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / 2

    def _corner(self, index: int) -> Array:
        return self.points[self.triangles[:, index]]


LOWEST_QUALITY = 0.02


def assemble(points: Array, triangles: NDArray[np.integer], edges: Array, mesher: str) -> HalfSpaceMesh:
    """Drop orphan points, orient the triangles, name the boundaries, and check the result on arrival.

    Raises
    ------
    MeshError
        if a boundary has the wrong length, a ring edge is not a vertex, or a triangle is degenerate
    """
    used, inverse = np.unique(triangles, return_inverse=True)
    points, cells = np.ascontiguousarray(points[used]), inverse.reshape(-1, 3).astype(np.int64)
    p, q = points[cells[:, 1]] - points[cells[:, 0]], points[cells[:, 2]] - points[cells[:, 0]]
    flipped = p[:, 0] * q[:, 1] < p[:, 1] * q[:, 0]
    cells[flipped] = cells[flipped][:, [0, 2, 1]]
    points[points[:, 0] < 1e-14, 0] = 0.0
    points[points[:, 1] < 1e-14, 1] = 0.0
    mesh = HalfSpaceMesh(points, cells, _named_boundaries(points, cells), mesher)
    check(mesh, edges)
    return mesh


def _named_boundaries(points: Array, triangles: Indices) -> dict[str, Indices]:
    facets = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(facets, axis=0, return_counts=True)
    if count.max() > 2:
        raise MeshError("the mesh is not a surface: a facet has more than two triangles")
    outer = unique[count == 1]
    r, z = points[outer, 0], points[outer, 1]
    surface, axis = (z == 0).all(axis=1), (r == 0).all(axis=1)
    inside = r.mean(axis=1) < 1  # however small the facets beside the rim
    names = {"contact": surface & inside, "free": surface & ~inside, "axis": axis, "far": ~surface & ~axis}
    return {name: outer[mask] for name, mask in names.items()}


def check(mesh: HalfSpaceMesh, edges: Array) -> None:
    """Raise `MeshError` unless the mesh is the quarter disc it should be, with every ring edge a vertex."""
    outer = mesh.truncation
    lengths = {
        name: float(np.linalg.norm(np.diff(mesh.points[facets], axis=1), axis=-1).sum())
        for name, facets in mesh.boundaries.items()
    }
    for name, expected in {"contact": 1.0, "free": outer - 1, "axis": outer}.items():
        if abs(lengths[name] - expected) > 1e-9 * outer:
            raise MeshError(f"the {name} boundary is {lengths[name]:.9g} a long and should be {expected:.9g} a")
    far = mesh.points[np.unique(mesh.boundaries["far"])]
    if np.abs(np.hypot(*far.T) / outer - 1).max() > 1e-9:
        raise MeshError("the mesh has a hole or a gap: boundary points lie inside, where no boundary should be")
    missing = [e for e in np.asarray(edges) if np.abs(mesh.contact_radii - e).min() > 1e-12]
    if missing:
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {missing[0]:.9g} a: ask for a smaller ring_size"
        )
    if mesh.areas.min() <= 0 or mesh.quality.min() < LOWEST_QUALITY:
        worst = mesh.points[mesh.triangles[mesh.quality.argmin()]].mean(axis=0)
        raise MeshError(
            f"a triangle at r = {worst[0]:.3g} a, depth {worst[1]:.3g} a is degenerate "
            f"(quality {mesh.quality.min():.1e}): ask for less extreme sizes"
        )
