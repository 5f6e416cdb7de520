"""Ring edges, the graded radial mesh, and the pressure space on it (radius of the punch = 1).

The pressure is a polynomial on each element, continuous inside a ring and broken at ring edges. That one space
holds every case of interest: the flat start (pressure continuous), wear for t > 0 (wear rate ``k p`` continuous)
and every steady state (pressure constant on each ring, Eq. 24). The basis is hierarchical (hats and integrated
Legendre bubbles), so that dropping the highest bubbles gives the coarser space an error estimate compares with.

All areas are those of the punch face: ``dA = 2 pi r dr``.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def alternating_edges(count: int, width_ratio: float = 1.0) -> Array:
    """Edges of `count` rings on [0, 1] whose widths alternate as h1, h2, h1, ... with ``h2/h1 = width_ratio``."""
    widths = np.where(np.arange(count) % 2 == 0, 1.0, width_ratio)
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    return edges / edges[-1]


def ring_areas(edges: ArrayLike) -> Array:
    """Area of each ring, ``pi (r_o^2 - r_i^2)``, without cancellation for narrow rings."""
    edges = np.asarray(edges, dtype=float)
    return np.pi * np.diff(edges) * (edges[1:] + edges[:-1])


def graded_breakpoints(edges: ArrayLike, edge_size: ArrayLike, rim_size: float, factor: float) -> Array:
    """Element boundaries that shrink by `factor` per element towards every ring edge and the rim.

    The smallest elements have about `edge_size` at ring edges (one for all, or one for each between the centre and
    the rim) and `rim_size` at the rim. There is nothing to resolve at the axis, where every field is smooth in ``r^2``.
    """
    edges = np.asarray(edges, dtype=float)
    sizes = np.append(np.broadcast_to(np.asarray(edge_size, dtype=float), len(edges) - 2), rim_size)
    pieces = []
    for i, (inner, outer) in enumerate(itertools.pairwise(edges)):
        width = outer - inner
        span = width if i == 0 else width / 2
        towards_outer = outer - _layers(span, sizes[i], factor)
        towards_inner = inner + _layers(span, sizes[i - 1], factor)[::-1] if i else np.empty(0)
        # the two families meet at mid-ring, and share that point
        pieces.append(np.concatenate([[inner], towards_inner[:-1], towards_outer if i else towards_outer[1:]]))
    return np.concatenate([*pieces, edges[-1:]])


def _layers(span: float, smallest: float, factor: float) -> Array:
    """Distances from a singular point: `span`, `span * factor`, ... down to about `smallest`."""
    count = max(0, round(np.log(max(smallest, 1e-300) / span) / np.log(factor)))
    return span * factor ** np.arange(count + 1.0)


def layer_degrees(breakpoints: Array, edges: ArrayLike, degree: int, rise: float, lowest: int = 1) -> Indices:
    """Degree of each element: `lowest` at ring edges and rim, rising by `rise` per element to `degree`."""
    marks = np.searchsorted(breakpoints, np.asarray(edges, dtype=float)[1:])
    index = np.arange(len(breakpoints) - 1)
    after = np.searchsorted(marks, index, side="right")
    to_outer = marks[np.minimum(after, len(marks) - 1)] - 1 - index
    to_inner = np.where(after > 0, index - marks[np.maximum(after - 1, 0)], len(index))
    layer = np.minimum(to_outer, to_inner)
    return np.minimum(degree, lowest + np.floor(rise * layer).astype(np.int64))


@dataclass(frozen=True, eq=False)
class PressureSpace:
    """Piecewise polynomials on a radial mesh, continuous inside rings, broken at ring edges.

    Parameters
    ----------
    breakpoints : (n+1,) element boundaries, 0 to 1
    degrees : (n,) polynomial degree of each element, at least 1
    edges : (N+1,) ring edges, each one a breakpoint
    """

    breakpoints: Array
    degrees: Indices
    edges: Array

    @property
    def size(self) -> int:
        return self._numbering[1]

    @property
    def top(self) -> int:
        return int(self.degrees.max())

    @cached_property
    def ring(self) -> Indices:
        """Ring that each element belongs to."""
        middle = (self.breakpoints[1:] + self.breakpoints[:-1]) / 2
        return np.searchsorted(self.edges, middle, side="right") - 1

    @cached_property
    def _numbering(self) -> tuple[Indices, int]:
        n = len(self.degrees)
        first = np.concatenate([[True], np.diff(self.ring) > 0])
        left = np.cumsum(first) - 1 + np.arange(n)
        vertices = int(left[-1]) + 2
        bubbles = self.degrees - 1
        start = vertices + np.concatenate([[0], np.cumsum(bubbles)])
        size = int(start[-1])
        table = np.full((n, self.top + 1), size)
        table[:, 0], table[:, 1] = left, left + 1
        order = np.arange(self.top - 1)
        table[:, 2:] = np.where(order < bubbles[:, None], start[:-1, None] + order, size)
        return table, size

    @property
    def dofs(self) -> Indices:
        """(n, top+1) global number of each local shape function; `size` where the element has none."""
        return self._numbering[0]

    @cached_property
    def order(self) -> Indices:
        """Polynomial degree of each basis function: 1 for hats, 2 and up for bubbles."""
        result = np.ones(self.size + 1, dtype=np.int64)
        result[self.dofs[:, 2:]] = np.arange(2, self.top + 1)
        return result[:-1]

    @cached_property
    def degree_of_function(self) -> Indices:
        """Degree of the element that each bubble lives on (for hats: of one of their elements)."""
        result = np.ones(self.size + 1, dtype=np.int64)
        result[self.dofs] = self.degrees[:, None]
        return result[:-1]

    def scatter(self, values: Array) -> Array:
        """Sum local rows ``(n, top+1, ...)`` into global rows ``(size, ...)``."""
        out = np.zeros((self.size + 1, *values.shape[2:]))
        np.add.at(out, self.dofs, values)
        return out[:-1]

    def matrix(self, radii: ArrayLike, derivative: bool = False) -> Array:
        """(len(radii), size) values, or slopes, of the basis. An edge radius belongs to the ring outside it."""
        radii = np.asarray(radii, dtype=float)
        element = np.clip(np.searchsorted(self.breakpoints, radii, side="right") - 1, 0, len(self.degrees) - 1)
        left, right = self.breakpoints[element], self.breakpoints[element + 1]
        local = ((radii - left) - (right - radii)) / (right - left)
        values = shape_slopes(local, self.top) * (2 / (right - left)[:, None]) if derivative else shapes(local, self.top)
        out = np.zeros((len(radii), self.size + 1))
        out[np.arange(len(radii))[:, None], self.dofs[element]] = values
        return out[:, :-1]

    @cached_property
    def quadrature(self) -> tuple[Array, Array, Array]:
        """Gauss points: radii (n, q), weights of dr (n, q), local coordinate (q,); exact for products of the basis."""
        local, weight = np.polynomial.legendre.leggauss(self.top + 2)
        left, half = self.breakpoints[:-1, None], np.diff(self.breakpoints)[:, None] / 2
        return left + half * (1 + local), half * weight, local

    @cached_property
    def _element_mass(self) -> Array:
        radii, weight, local = self.quadrature
        values = shapes(local, self.top)
        return np.einsum("eq,qi,qj->eij", 2 * np.pi * radii * weight, values, values, optimize=True)

    def mass(self, ring_values: ArrayLike) -> Array:
        """(size, size) ``int c phi_i phi_j dA`` with the constant `c` of each ring."""
        scaled = self._element_mass * np.asarray(ring_values, dtype=float)[self.ring, None, None]
        out = np.zeros((self.size + 1, self.size + 1))
        np.add.at(out, (self.dofs[:, :, None], self.dofs[:, None, :]), scaled)
        return out[:-1, :-1]

    def slope_gram(self, weight_of_radius: Array) -> Array:
        """(size, size) ``int phi_i' phi_j' w(r) dr`` for weights given at the quadrature radii (n, q)."""
        _, weight, local = self.quadrature
        slopes = shape_slopes(local, self.top)
        scale = (2 / np.diff(self.breakpoints)) ** 2
        blocks = np.einsum("eq,qi,qj->eij", scale[:, None] * weight * weight_of_radius, slopes, slopes, optimize=True)
        out = np.zeros((self.size + 1, self.size + 1))
        np.add.at(out, (self.dofs[:, :, None], self.dofs[:, None, :]), blocks)
        return out[:-1, :-1]

    @cached_property
    def weights(self) -> Array:
        """(size,) ``int phi_i dA``: the force that each basis function carries."""
        radii, weight, local = self.quadrature
        return self.scatter(np.einsum("eq,qi->ei", 2 * np.pi * radii * weight, shapes(local, self.top)))

    def ring_forces(self, edges: ArrayLike) -> Array:
        """(M, size) force that each basis function puts on each of the rings between `edges` (any edges)."""
        edges = np.asarray(edges, dtype=float)
        cuts = np.union1d(self.breakpoints, edges)
        local, weight = np.polynomial.legendre.leggauss(self.top + 2)
        half = np.diff(cuts)[:, None] / 2
        radii = (cuts[:-1, None] + half * (1 + local)).ravel()
        forces = (2 * np.pi * radii * (half * weight).ravel())[:, None] * self.matrix(radii)
        ring = np.clip(np.searchsorted(edges, radii, side="right") - 1, 0, len(edges) - 2)
        out = np.zeros((len(edges) - 1, self.size))
        np.add.at(out, ring, forces)
        return out

    def ring_indicator(self) -> Array:
        """(size, N) coefficients of the pressures that are one on a ring and zero on the others."""
        out = np.zeros((self.size + 1, len(self.edges) - 1))
        out[self.dofs[:, 0], self.ring] = 1.0
        out[self.dofs[:, 1], self.ring] = 1.0
        return out[:-1]

    def joined(self, ring_coefficients: ArrayLike) -> Array:
        """(size, size-N+1) basis of the pressures whose product with `ring_coefficients` is continuous.

        With the wear coefficients: the space of t > 0, in terms of the wear rate. With ones: continuous pressures.
        """
        coefficients = np.asarray(ring_coefficients, dtype=float)
        starts = self.dofs[np.flatnonzero(np.diff(self.ring) > 0) + 1, 0]
        column = np.arange(self.size) - np.searchsorted(starts, np.arange(self.size), side="right")
        ring_of = np.zeros(self.size + 1, dtype=np.int64)
        ring_of[self.dofs] = self.ring[:, None]
        out = np.zeros((self.size, self.size - len(starts)))
        out[np.arange(self.size), column] = 1 / coefficients[ring_of[:-1]]
        return out


def shapes(local: Array, top: int) -> Array:
    """(..., top+1) hats and integrated Legendre bubbles at local coordinates in [-1, 1]."""
    legendre = np.polynomial.legendre.legvander(local, top)
    bubbles = [(legendre[..., j] - legendre[..., j - 2]) / np.sqrt(4 * j - 2) for j in range(2, top + 1)]
    return np.stack([(1 - local) / 2, (1 + local) / 2, *bubbles], axis=-1)


def shape_slopes(local: Array, top: int) -> Array:
    """(..., top+1) derivatives of `shapes` in the local coordinate."""
    legendre = np.polynomial.legendre.legvander(local, top)
    half = np.full_like(local, 0.5)
    return np.stack([-half, half, *(legendre[..., j - 1] * np.sqrt(j - 0.5) for j in range(2, top + 1))], axis=-1)
