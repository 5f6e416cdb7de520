"""The pressure space on a radial mesh (radius of the punch = 1).

The pressure is a polynomial on each element, continuous inside a ring and broken at ring edges. That one space
holds every case of interest: the flat start (pressure continuous), wear for t > 0 (wear rate ``k p`` continuous)
and every steady state (pressure constant on each ring, Eq. 24). The basis is hierarchical (hats and integrated
Legendre bubbles), so that dropping the highest bubbles gives the coarser space an error estimate compares with. It is
numbered along the radius, so that what couples neighbours only (masses, slopes) is a narrow band.

All areas are those of the punch face: ``dA = 2 pi r dr``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ringwear.meshes.radial import Array, Indices, ring_of


@dataclass(frozen=True, eq=False)
class PressureSpace:
    """Piecewise polynomials on a radial mesh, continuous inside rings, broken at ring edges.

    Parameters
    ----------
    breakpoints : (n+1,) element boundaries, 0 to 1
    degrees : (n,) polynomial degree of each element, at least 1
    ring_edges : (N+1,) ring edges, each one a breakpoint
    """

    breakpoints: Array
    degrees: Indices
    ring_edges: Array

    @property
    def size(self) -> int:
        return self._numbering[1]

    @property
    def top(self) -> int:
        return int(self.degrees.max())

    @cached_property
    def ring(self) -> Indices:
        """Ring that each element belongs to."""
        return ring_of(self.ring_edges, (self.breakpoints[1:] + self.breakpoints[:-1]) / 2)

    @cached_property
    def _numbering(self) -> tuple[Indices, int]:
        breaks = np.concatenate([[0], np.diff(self.ring) > 0])
        left = np.cumsum(breaks) + np.cumsum(self.degrees) - self.degrees
        size = int(left[-1] + self.degrees[-1]) + 1
        # left vertex, bubbles, right vertex along the radius; in the table both vertices come first
        order = np.arange(self.top + 1)
        table = np.where(order <= self.degrees[:, None], left[:, None] + order - 1, size)
        table[:, 0], table[:, 1] = left, left + self.degrees
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

    def matrix(self, radii: ArrayLike, derivative: bool = False) -> csr_matrix:
        """(len(radii), size) values, or slopes, of the basis. An edge radius belongs to the ring outside it."""
        radii = np.asarray(radii, dtype=float)
        element = np.clip(np.searchsorted(self.breakpoints, radii, side="right") - 1, 0, len(self.degrees) - 1)
        left, right = self.breakpoints[element], self.breakpoints[element + 1]
        local = ((radii - left) - (right - radii)) / (right - left)
        values = shape_slopes(local, self.top) * (2 / (right - left)[:, None]) if derivative else shapes(local, self.top)
        rows = np.repeat(np.arange(len(radii)), self.top + 1)
        columns = self.dofs[element].ravel()
        return csr_matrix((values.ravel(), (rows, columns)), (len(radii), self.size + 1))[:, :-1]

    def on_elements(self, local: Array) -> csr_matrix:
        """(elements x points, size) values of the basis at local coordinates in [-1, 1] of every element.

        By radii, as in `matrix`, coordinates would lose digits on elements much smaller than the punch.
        """
        shape = (len(self.degrees), len(local), self.top + 1)
        rows = np.broadcast_to(np.arange(shape[0] * shape[1])[:, None], (shape[0] * shape[1], shape[2])).ravel()
        columns = np.broadcast_to(self.dofs[:, None, :], shape).ravel()
        values = np.broadcast_to(shapes(local, self.top), shape).ravel()
        return csr_matrix((values, (rows, columns)), (shape[0] * shape[1], self.size + 1))[:, :-1]

    def _gram(self, blocks: Array) -> csr_matrix:
        """(size, size) sum of the (n, top+1, top+1) matrices of the elements."""
        rows = np.broadcast_to(self.dofs[:, :, None], blocks.shape).ravel()
        columns = np.broadcast_to(self.dofs[:, None, :], blocks.shape).ravel()
        return csr_matrix((blocks.ravel(), (rows, columns)), (self.size + 1,) * 2)[:-1, :-1]

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

    def mass(self, ring_values: ArrayLike) -> csr_matrix:
        """(size, size) ``int c phi_i phi_j dA`` with the constant `c` of each ring."""
        return self._gram(self._element_mass * np.asarray(ring_values, dtype=float)[self.ring, None, None])

    def slope_gram(self, weight_of_radius: Array) -> csr_matrix:
        """(size, size) ``int phi_i' phi_j' w(r) dr`` for weights given at the quadrature radii (n, q)."""
        _, weight, local = self.quadrature
        slopes = shape_slopes(local, self.top)
        scale = (2 / np.diff(self.breakpoints)) ** 2
        blocks = np.einsum("eq,qi,qj->eij", scale[:, None] * weight * weight_of_radius, slopes, slopes, optimize=True)
        return self._gram(blocks)

    @cached_property
    def weights(self) -> Array:
        """(size,) ``int phi_i dA``: the force that each basis function carries."""
        radii, weight, local = self.quadrature
        return self.scatter(np.einsum("eq,qi->ei", 2 * np.pi * radii * weight, shapes(local, self.top)))

    def ring_forces(self, ring_edges: ArrayLike) -> Array:
        """(M, size) force that each basis function puts on each of the rings between `ring_edges` (any edges)."""
        ring_edges = np.asarray(ring_edges, dtype=float)
        cuts = np.union1d(self.breakpoints, ring_edges)
        local, weight = np.polynomial.legendre.leggauss(self.top + 2)
        half = np.diff(cuts)[:, None] / 2
        radii = (cuts[:-1, None] + half * (1 + local)).ravel()
        area = 2 * np.pi * radii * (half * weight).ravel()
        ring = np.clip(np.searchsorted(ring_edges, radii, side="right") - 1, 0, len(ring_edges) - 2)
        sums = csr_matrix((area, (ring, np.arange(len(radii)))), (len(ring_edges) - 1, len(radii)))
        return np.asarray((sums @ self.matrix(radii)).toarray())

    def ring_indicator(self) -> Array:
        """(size, N) coefficients of the pressures that are one on a ring and zero on the others."""
        out = np.zeros((self.size + 1, len(self.ring_edges) - 1))
        out[self.dofs[:, 0], self.ring] = 1.0
        out[self.dofs[:, 1], self.ring] = 1.0
        return out[:-1]

    def joined(self, ring_coefficients: ArrayLike) -> csr_matrix:
        """(size, size-N+1) basis of the pressures whose product with `ring_coefficients` is continuous.

        With the wear coefficients: the space of t > 0, in terms of the wear rate. With ones: continuous pressures.
        """
        coefficients = np.asarray(ring_coefficients, dtype=float)
        starts = self.dofs[np.flatnonzero(np.diff(self.ring) > 0) + 1, 0]
        column = np.arange(self.size) - np.searchsorted(starts, np.arange(self.size), side="right")
        ring_of = np.zeros(self.size + 1, dtype=np.int64)
        ring_of[self.dofs] = self.ring[:, None]
        values = 1 / coefficients[ring_of[:-1]]
        return csr_matrix((values, (np.arange(self.size), column)), (self.size, self.size - len(starts)))


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
