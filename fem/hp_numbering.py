"""Numbers of the functions of high degree: of vertices first, then the bubbles of each side by degree.

The degree rises from layer to layer of a star, and a side has the lower degree of its two elements: what exceeds it is
left out of the other. Sides run outwards along the radius (straight down those at one radius), so that the functions of
the contact line are those of a pressure space, signs included.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from meshes.pressure_space import shapes
from meshes.radial import Array, Indices
from meshes.stars import StarMesh

from .lobatto import QUADRILATERAL, TRIANGLE, Element


@dataclass(frozen=True, eq=False)
class Group:
    """All elements of one kind.

    Parameters
    ----------
    vertices : (m, corners) vertex numbers, counter-clockwise
    degrees : (m,) polynomial degree of each
    """

    element: Element
    vertices: Indices
    degrees: Indices


@dataclass(frozen=True, eq=False)
class Chain:
    """The sides of a named boundary from one end to the other.

    Parameters
    ----------
    sides : (m,) side numbers
    ends : (m, 2) vertices at the lower and the higher end of each
    degrees : (m,) polynomial degrees
    """

    sides: Indices
    ends: Indices
    degrees: Indices

    @property
    def before(self) -> Indices:
        """(m,) number of functions on the chain before each side."""
        return np.cumsum(self.degrees) - self.degrees


@dataclass(frozen=True, eq=False)
class Numbering:
    """The functions on vertices and sides of a mesh with stars.

    Parameters
    ----------
    mesh : the mesh
    degree : of the triangles
    lowest : degree at singular points; from there it rises by one per layer up to `degree`
    """

    mesh: StarMesh
    degree: int
    lowest: int

    @cached_property
    def groups(self) -> tuple[Group, Group]:
        """The quadrilaterals and the triangles."""
        triangles = self.mesh.triangles
        # the quadrature of triangles is best for the hoop strain u/r when the corner nearest the axis comes last
        nearest = self.mesh.points[triangles, 0].argmin(axis=1)
        turned = np.take_along_axis(triangles, np.add.outer(nearest, [1, 2, 3]) % 3, axis=1)
        in_stars = np.minimum(self.degree, self.lowest + self.mesh.layer)
        in_fill = np.full(len(triangles), self.degree)
        return Group(QUADRILATERAL, self.mesh.quadrilaterals, in_stars), Group(TRIANGLE, turned, in_fill)

    @cached_property
    def _along_radius(self) -> Indices:
        """The vertices by radius, then by depth."""
        return np.lexsort(self.mesh.points.T[::-1])

    @cached_property
    def _rank(self) -> Indices:
        """Place of each vertex in that order: sides run from the lower to the higher."""
        return np.argsort(self._along_radius)

    def _codes(self, ends: Indices) -> Indices:
        """One number for each side, by the (..., 2) vertices at its ends; in the order of its lower end."""
        ranks = self._rank[ends]
        return ranks.min(axis=-1) * len(self._rank) + ranks.max(axis=-1)

    @cached_property
    def _sides(self) -> tuple[Indices, tuple[Indices, ...]]:
        """Codes of the sides, sorted, and for each group the numbers (m, sides) of its own."""
        codes = [self._codes(group.vertices[:, group.element.sides]) for group in self.groups]
        unique = np.unique(np.concatenate([own.ravel() for own in codes]))
        return unique, tuple(np.searchsorted(unique, own) for own in codes)

    @cached_property
    def _degrees(self) -> Indices:
        """(sides,) the lower degree of the elements on either side of each."""
        codes, sides = self._sides
        out = np.full(len(codes), self.degree)
        for group, own in zip(self.groups, sides, strict=True):
            np.minimum.at(out, own, group.degrees[:, None])
        return out

    @cached_property
    def _starts(self) -> Indices:
        """(sides + 1,) number of the first bubble of each side, and of all functions."""
        return len(self.mesh.points) + np.append(0, np.cumsum(self._degrees - 1))

    @property
    def size(self) -> int:
        return int(self._starts[-1])

    def functions(self, group: Group, chosen: Indices, degree: int) -> tuple[Indices, Array]:
        """(k, n) numbers and signs of the functions on the boundary of the chosen elements; -1 for those left out."""
        own = self._sides[1][self.groups.index(group)][chosen]
        vertices = group.vertices[chosen]
        order = np.arange(2, degree + 1)
        bubbles = np.where(order > self._degrees[own][..., None], -1, self._starts[own][..., None] + order - 2)
        start, end = np.moveaxis(self._rank[vertices[:, group.element.sides]], -1, 0)
        signs = np.where((start > end)[..., None] & (order % 2 == 1), -1.0, 1.0)
        numbers = np.concatenate([vertices, bubbles.reshape(len(vertices), -1)], axis=1)
        return numbers, np.concatenate([np.ones(vertices.shape), signs.reshape(len(vertices), -1)], axis=1)

    def chain(self, name: str) -> Chain:
        """The sides of a named boundary."""
        codes = np.sort(self._codes(self.mesh.boundaries[name]))
        sides = np.searchsorted(self._sides[0], codes)
        ends = self._along_radius[np.stack(np.divmod(codes, len(self._rank)), axis=1)]
        return Chain(sides, ends, self._degrees[sides])

    def boundary(self, name: str) -> Indices:
        """Functions on a named boundary along it: vertex, bubbles by degree, vertex, and so on."""
        chain = self.chain(name)
        bubble = np.arange(chain.degrees.sum()) - np.repeat(chain.before, chain.degrees) - 1
        vertex, first = (np.repeat(own, chain.degrees) for own in (chain.ends[:, 0], self._starts[chain.sides]))
        return np.append(np.where(bubble < 0, vertex, first + bubble), chain.ends[-1, 1])

    def interpolate(self, name: str, field: Callable[[Array], Array]) -> Array:
        """(functions, 2) coefficients on a named boundary, in its order, of a field with (n, 2) values at (n, 2) points.

        Interpolated at the Chebyshev-Lobatto points of each side.
        """
        chain = self.chain(name)
        out = np.empty((chain.degrees.sum() + 1, 2))
        for degree in np.unique(chain.degrees):
            chosen = chain.degrees == degree
            local = -np.cos(np.pi * np.arange(degree + 1) / degree)
            points = shapes(local, 1) @ self.mesh.points[chain.ends[chosen]]
            values = field(points.reshape(-1, 2)).reshape(points.shape)
            places = chain.before[chosen][:, None] + np.array([0, degree, *range(1, degree)])
            out[places] = np.linalg.solve(shapes(local, degree), values)
        return out

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """(8, m) corners and sides of each element, in one numbering, and (size,) the corner or side of each function.

        Triangles have two less, and tell one of their corners three times.
        """
        count = len(self.mesh.points)
        quadrilaterals, triangles = (
            np.concatenate([group.vertices.T, count + own.T]) for group, own in zip(self.groups, self._sides[1], strict=True)
        )
        padded = np.concatenate([triangles, triangles[:1], triangles[:1]])
        per_part = np.append(np.ones(count, dtype=np.int64), self._degrees - 1)
        return np.concatenate([quadrilaterals, padded], axis=1), np.repeat(np.arange(len(per_part)), per_part)
