"""The pressure space on a radial mesh (radius of the punch = 1).

The pressure is a polynomial on each element, continuous inside a ring and broken at ring edges.
This space contains the pressures of all cases: the flat start (pressure continuous), wear for t > 0
(wear rate ``k p`` continuous) and every steady state (pressure constant on each ring, Eq. 24). The
basis is hierarchical (hats and integrated Legendre bubbles) and numbered along the radius, so that
matrices that couple only neighbours (mass, slope) have a narrow band.

The space begins at the axis or, under a hollow punch, at the edge of the hole.

All areas are areas of the punch face: ``dA = 2 pi r dr``.

Breakpoints are stored as a rounded radius and a low part, which is its rounding error. Differences
of breakpoints computed from both are accurate to all digits.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgError, cholesky_banded
from scipy.linalg.lapack import dtbtrs
from scipy.sparse import csr_matrix, tril

from .errors import SolverError
from .radial import (
    Array,
    Indices,
    from_axis,
    gauss,
    graded_breakpoints,
    layers,
    ring_of,
    values_on_rings,
)

# values of functions (float) or numbers of rings (int)
Values = TypeVar("Values", Array, Indices)


class BandedCholesky:
    """Cholesky factor `L` of a symmetric positive definite band matrix ``L L^T``.

    Matrices that couple only neighbours along the radius have such a band.

    Parameters
    ----------
    matrix : symmetric matrix with a narrow band

    Raises
    ------
    SolverError
        if the matrix is not positive definite to roundoff
    """

    def __init__(self, matrix: csr_matrix) -> None:
        entries = tril(matrix, format="coo")
        below = entries.row - entries.col
        band = np.zeros((int(below.max(initial=0)) + 1, matrix.shape[0]))
        band[below, entries.col] = entries.data
        try:
            self._band = cholesky_banded(band, lower=True)
        except LinAlgError as error:
            raise SolverError(
                f"the radial mesh is too extreme for double precision: {error}"
            ) from error

    def forward(self, right: Array, trans: str = "N") -> Array:
        """Return ``L^-1`` (or ``L^-T`` if `trans` is "T") times a vector or a matrix."""
        if not right.size:
            # for empty arrays, LAPACK's wrapper writes outside the array
            return right
        columns = right.reshape(len(right), -1)
        solution, _ = dtbtrs(self._band, columns, uplo="L", trans=trans)
        return np.asarray(solution).reshape(right.shape)

    def multiply(self, right: Array) -> Array:
        """Return ``L`` times a vector or a matrix."""
        columns = right.reshape(len(right), -1)
        product = self._band[0, :, None] * columns
        for below in range(1, len(self._band)):
            product[below:] += self._band[below, :-below, None] * columns[:-below]
        return product.reshape(right.shape)

    def backward(self, right: Array) -> Array:
        """Return ``L^-T`` times a vector or a matrix."""
        return self.forward(right, "T")

    def solve(self, right: Array) -> Array:
        """Return the inverse of the matrix times a vector or a matrix."""
        return self.backward(self.forward(right))


@dataclass(frozen=True, eq=False)
class PressureSpace:
    """Represent contact pressures by polynomials along the radius, broken at ring edges.

    A `PressureSpace` turns coefficients (size,) of a pressure into values (`matrix`), forces
    (`weights`, `ring_forces`) and integrals (`mass`). The `Compliance` of each method is defined on
    such a space.

    >>> edges = np.array([0.0, 0.5, 1.0])
    >>> space = PressureSpace(edges, degrees=np.array([2, 2]), ring_edges=edges)
    >>> pressure = space.ring_indicator() @ [4.0, 1.0]
    >>> space.ring_forces(edges) @ pressure / np.pi  # 4 times 1/4, and 1 times 3/4
    array([1.  , 0.75])

    Parameters
    ----------
    breakpoints : (n+1,) element boundaries, from 0 or the radius of a hole to 1
    degrees : (n,) polynomial degree of each element, at least 1
    ring_edges : (N+1,) ring edges, each one a breakpoint
    low_parts : (n+1,) low part of each breakpoint, by default zero; with it, elements beside an
        edge may be far narrower than the roundoff of its radius
    """

    breakpoints: Array
    degrees: Indices
    ring_edges: Array
    low_parts: Array | None = None

    @classmethod
    def graded(
        cls,
        ring_edges: ArrayLike,
        sizes: ArrayLike,
        factor: float,
        degree: int,
        axis_size: float | None = None,
    ) -> "PressureSpace":
        """Return the space of one degree on elements that shrink by a factor towards every edge.

        The other arguments are those of `radial.graded_breakpoints`.
        """
        breakpoints, low_parts = graded_breakpoints(ring_edges, sizes, factor, axis_size)
        degrees = np.full(len(breakpoints) - 1, degree)
        return cls(breakpoints, degrees, np.asarray(ring_edges, dtype=float), low_parts)

    @cached_property
    def _low(self) -> Array:
        return np.zeros(len(self.breakpoints)) if self.low_parts is None else self.low_parts

    @cached_property
    def widths(self) -> Array:
        """(n,) widths of the elements, accurate to all digits."""
        return np.diff(self.breakpoints) + np.diff(self._low)

    @cached_property
    def sort_keys(self) -> NDArray[np.complex128]:
        """(n+1,) complex numbers in the order of the breakpoints.

        numpy orders complex numbers by their real parts, here the rounded breakpoints, and equal
        ones by their imaginary parts, here the low parts.
        """
        return self.breakpoints + 1j * self._low

    def distance(self, first: Indices, second: Indices) -> Array:
        """Return the distances from breakpoints `first` to breakpoints `second`, to all digits.

        Breakpoints are given by number.
        """
        rounded = self.breakpoints[second] - self.breakpoints[first]
        return rounded + (self._low[second] - self._low[first])

    def distance_from(self, radii: Array, low_parts: Array, number: Indices) -> Array:
        """Return the distances from radii to breakpoints, given by number, to all digits.

        `low_parts` are the low parts of the radii.
        """
        return (self.breakpoints[number] - radii) + (self._low[number] - low_parts)

    @cached_property
    def size(self) -> int:
        """Number of basis functions."""
        return int(self.degrees.sum()) + len(self.ring_edges) - 1

    @property
    def inner_radius(self) -> float:
        """Radius of the hole; 0 without a hole."""
        return float(self.breakpoints[0])

    @property
    def top(self) -> int:
        """Highest degree of all elements."""
        return int(self.degrees.max())

    @cached_property
    def ring(self) -> Indices:
        """(n,) number of the ring that each element belongs to."""
        return np.searchsorted(self.ring_edges + 0j, self.sort_keys[:-1], side="right") - 1

    @cached_property
    def dofs(self) -> Indices:
        """(n, top+1) global number of each local shape function.

        The number is `size` if the element does not have the function.
        """
        left = self.ring + np.cumsum(self.degrees) - self.degrees
        # global numbers follow the radius: left vertex, bubbles, right vertex; the columns of the
        # table start with both vertices
        order = np.arange(self.top + 1)
        table = np.where(order <= self.degrees[:, None], left[:, None] + order - 1, self.size)
        table[:, 0], table[:, 1] = left, left + self.degrees
        return table

    def _of_functions(self, values: Values) -> Values:
        """Return a value (size,) of each basis function from values on the elements.

        `values` is (n, top+1), one for each shape function of each element, or (n, 1), one for each
        element.
        """
        out = np.zeros(self.size + 1, dtype=values.dtype)
        out[self.dofs] = values
        return out[:-1]

    @cached_property
    def uniform(self) -> Array:
        """(size,) coefficients of the uniform pressure 1: 1 for hats, 0 for bubbles."""
        return self._of_functions(np.where(np.arange(self.top + 1) < 2, 1.0, 0.0))

    def matrix(self, radii: ArrayLike, derivative: bool = False) -> csr_matrix:
        """Return the values, or slopes, (radii, size) of all basis functions at radii.

        A radius on a ring edge belongs to the ring outside it. In a hole, the values are zero.
        """
        radii = np.asarray(radii, dtype=float)
        element = np.clip(
            np.searchsorted(self.breakpoints, radii, side="right") - 1, 0, len(self.degrees) - 1
        )
        left, right = self.breakpoints[element], self.breakpoints[element + 1]
        left_low, right_low = self._low[element], self._low[element + 1]
        local = ((radii - left) - left_low) - ((right - radii) + right_low)
        local = np.clip(local / self.widths[element], -1.0, 1.0)
        functions = np.where((radii < self.inner_radius)[:, None], self.size, self.dofs[element])
        return self._values(element, local, functions, derivative)

    def on_elements(self, local: Array, derivative: bool = False) -> csr_matrix:
        """Return the values, or slopes, of the basis at local coordinates of every element.

        The local coordinates are in [-1, 1]; the matrix has the shape (elements x points, size).
        `matrix`, which takes radii, would lose digits on elements that are much smaller than the
        punch.
        """
        count = len(self.degrees)
        element = np.repeat(np.arange(count), len(local))
        return self._values(element, np.tile(local, count), self.dofs[element], derivative)

    def _values(
        self, element: Indices, local: Array, functions: Indices, derivative: bool
    ) -> csr_matrix:
        """Return values, or slopes, of the basis (points, size) at local coordinates.

        `functions` (points, top+1) are the numbers of the shape functions of the elements.
        """
        values = shapes(local, self.top)
        if derivative:
            values = shape_slopes(local, self.top)
            values *= (2 / self.widths[element])[:, None]
        rows = np.arange(len(local))[:, None]
        return self._assembled(values, rows, functions, len(local))

    def _assembled(self, values: Array, rows: Indices, columns: Indices, height: int) -> csr_matrix:
        """Return the matrix (height, size) that sums values in rows and columns.

        Values, rows and columns are broadcast. Entries in the row `height` or the column `size`,
        which are functions that an element does not have, are left out.
        """
        entries, row, column = map(np.ravel, np.broadcast_arrays(values, rows, columns))
        exists = (column != self.size) & (row != height)
        places = row[exists], column[exists]
        return csr_matrix((entries[exists], places), (height, self.size))

    @cached_property
    def quadrature(self) -> tuple[Array, Array, Array]:
        """Gauss points on all elements, exact for products of two basis functions.

        The arrays are the radii (n, q), the weights of dr (n, q) and the local coordinates (q,).
        """
        local, weight = gauss(self.top + 2)
        left, half = self.breakpoints[:-1, None], self.widths[:, None] / 2
        return left + half * (1 + local), half * weight, local

    def mass(self, ring_values: ArrayLike = 1.0) -> csr_matrix:
        """Return the mass matrix (size, size) ``int c phi_i phi_j dA``.

        `ring_values` gives the factor `c`: a constant for each ring (N,), one constant for all
        rings, or values (2, N) at the inner and outer edge of each ring, with `c` linear between
        them.
        """
        radii, lengths, local = self.quadrature
        factors = values_on_rings(self.ring_edges, ring_values, radii, self.ring[:, None])
        areas = 2 * np.pi * radii * lengths * factors
        values = shapes(local, self.top)
        blocks = np.einsum("eq,qi,qj->eij", areas, values, values, optimize=True)
        rows, columns = self.dofs[:, :, None], self.dofs[:, None, :]
        return self._assembled(blocks, rows, columns, self.size)

    @cached_property
    def _mass_factor(self) -> BandedCholesky:
        return BandedCholesky(self.mass())

    def projected(self, moments: Array) -> Array:
        """Return the coefficients (size, ...) of the functions with given moments.

        The moments (size, ...) are the integrals ``int f phi_i dA`` of a function f; the result is
        its projection on the space, which has the same moments.

        Raises
        ------
        SolverError
            if the mass matrix is singular to roundoff
        """
        return self._mass_factor.solve(moments)

    def at_vertices(self, ring_values: ArrayLike) -> Array:
        """Return the values (size,) of a function given on rings, at the vertex of each hat.

        `ring_values` gives the function as in `mass`. A bubble has the value at the outer vertex of
        its element.
        """
        ends = np.stack([self.breakpoints[:-1], self.breakpoints[1:]], axis=1)
        radii = np.repeat(ends, [1, self.top], axis=1)
        values = values_on_rings(self.ring_edges, ring_values, radii, self.ring[:, None])
        return self._of_functions(values)

    @cached_property
    def weights(self) -> Array:
        """(size,) ``int phi_i dA``: the force that each basis function carries."""
        radii, lengths, local = self.quadrature
        elements = np.arange(len(self.degrees))
        return self.moments(elements, local[None], 2 * np.pi * radii * lengths)

    def moments(self, element: Indices, local: Array, values: Array) -> Array:
        """Return the moments (size, ...) of values at points within elements.

        They are the sums of the values times each basis function.

        Parameters
        ----------
        element : (P,) index of the element of each group of Q points
        local : (P, Q) or (1, Q) coordinates of the points in [-1, 1]
        values : (P, Q, ...) values at the points, times the area ``2 pi r dr`` of each
        """
        parts = np.einsum("pq...,pqi->pi...", values, shapes(local, self.top), optimize=True)
        sums = np.zeros((self.size + 1, *values.shape[2:]))
        np.add.at(sums, self.dofs[element], parts)
        return sums[:-1]

    def ring_forces(self, ring_edges: ArrayLike) -> Array:
        """Return the force (M, size) that each basis function puts on each of M rings.

        The rings lie between `ring_edges` (M+1,), which may be any edges.
        """
        ring_edges = np.asarray(ring_edges, dtype=float)
        node, weight = gauss(self.top + 2)
        if np.isin(ring_edges, self.breakpoints).all():
            radii, lengths, _ = self.quadrature
            ring = np.searchsorted(ring_edges + 0j, self.sort_keys[:-1], side="right")[:, None] - 1
            values = np.einsum("eq,qi->ei", 2 * np.pi * radii * lengths, shapes(node, self.top))
            # elements inside the first edge are on no ring
            on_rings = ring[:, 0] >= 0
            values, ring, functions = values[on_rings], ring[on_rings], self.dofs[on_rings]
            return self._assembled(values, ring, functions, len(ring_edges) - 1).toarray()
        cuts = np.union1d(self.breakpoints, ring_edges)
        cuts = cuts[cuts >= max(self.inner_radius, ring_edges[0])]
        half = np.diff(cuts)[:, None] / 2
        element = np.searchsorted(self.breakpoints, cuts[:-1], side="right") - 1
        left, width = self.breakpoints[element, None], np.diff(self.breakpoints)[element, None]
        # local coordinates are computed from distances within the element, because radii would lose
        # digits on small elements
        local = 2 * (cuts[:-1, None] - left + half * (1 + node)) / width - 1
        area = 2 * np.pi * (cuts[:-1, None] + half * (1 + node)) * half * weight
        values = np.einsum("eq,eqi->ei", area, shapes(local, self.top))
        rings = ring_of(ring_edges, cuts[:-1])[:, None]
        return self._assembled(values, rings, self.dofs[element], len(ring_edges) - 1).toarray()

    def ring_indicator(self) -> Array:
        """Return the coefficients of the pressures that are 1 on one ring and 0 on all others.

        The coefficients (size, N) have one column for each ring.
        """
        ring = self._of_functions(self.ring[:, None])
        rings = np.arange(len(self.ring_edges) - 1)
        return self.uniform[:, None] * (ring[:, None] == rings)

    def joined(self, ring_coefficients: ArrayLike = 1.0) -> csr_matrix:
        """Return a basis of the pressures whose product with `ring_coefficients` is continuous.

        The basis is (size, size-N+1); `ring_coefficients` are given as `ring_values` in `mass`.
        With the wear coefficients, it is the space of t > 0 in terms of the wear rate. By default,
        it is the space of continuous pressures.
        """
        ring, function = self._of_functions(self.ring[:, None]), np.arange(self.size)
        # the last function of a ring and the first of the next share one column
        values, column = 1 / self.at_vertices(ring_coefficients), function - ring
        return csr_matrix((values, (function, column)), (self.size, int(column[-1]) + 1))

    def coarser(self) -> "PressureSpace":
        """Return a coarser subspace.

        The degree is lower by 1 in every element, but not below 1, and there is one layer less on
        each side of every ring edge and at the axis. An element counts as a layer only if it is
        narrower than half of the narrower ring at the edge. If the pressure is smooth at an edge
        there may be no layers, and the error of two merged elements of that width would be far
        larger than theirs. If this space has degree 1 only, neighbouring elements are merged in
        pairs instead, but not across ring edges.
        """
        count, edges = len(self.breakpoints), np.searchsorted(self.sort_keys, self.ring_edges + 0j)
        dropped = np.arange(1, count, 2)
        if self.top > 1:
            widths, rings = np.diff(self.breakpoints), np.diff(from_axis(self.ring_edges))
            # slightly less than half, so that roundoff does not decide about elements of exactly
            # half
            largest_layer = 0.499 * np.minimum(rings, np.append(rings[1:], rings[-1]))
            if not self.inner_radius:
                largest_layer = np.append(largest_layer[0], largest_layer)
            # an edge has no inner side at the axis or a hole, and no outer side at the rim
            inner, outer = edges > 0, edges < count - 1
            inner &= widths[edges - 1] < largest_layer
            outer[outer] = widths[edges[outer]] < largest_layer[outer]
            dropped = np.concatenate([edges[inner] - 1, edges[outer] + 1])
        remaining = np.setdiff1d(np.arange(count), np.setdiff1d(dropped, edges))
        lowest = np.minimum.reduceat(self.degrees, remaining[:-1])
        return PressureSpace(
            self.breakpoints[remaining],
            np.maximum(lowest - 1, 1),
            self.ring_edges,
            None if self.low_parts is None else self.low_parts[remaining],
        )

    def joined_beside_ring_edges(self) -> "PressureSpace":
        """Return the space with the two elements next to a ring edge merged, on either side of it.

        A ring that is a single element stays as it is. Elements beside the rim, the axis and the
        edge of a hole are not merged, because the pressure does not jump there.
        """
        edges = np.searchsorted(self.sort_keys, self.ring_edges + 0j)
        inner = edges[1:-1]
        dropped = np.setdiff1d(np.concatenate([inner - 1, inner + 1]), edges)
        remaining = np.setdiff1d(np.arange(len(self.breakpoints)), dropped)
        return PressureSpace(
            self.breakpoints[remaining],
            np.minimum.reduceat(self.degrees, remaining[:-1]),
            self.ring_edges,
            None if self.low_parts is None else self.low_parts[remaining],
        )

    def divided(self, breakpoints: Array, low_parts: Array) -> "PressureSpace":
        """Return the space on more breakpoints, which include those of this space.

        Each element has the degree of the element of this space that contains it.
        """
        parent = np.searchsorted(self.sort_keys, (breakpoints + 1j * low_parts)[1:]) - 1
        return PressureSpace(breakpoints, self.degrees[parent], self.ring_edges, low_parts)

    def with_layers_at_axis(self, smallest: float, factor: float) -> "PressureSpace":
        """Return the space with its first element cut into layers that shrink towards the axis."""
        cuts = layers(float(self.widths[0]), smallest, factor)[:0:-1]
        first = np.ones(len(cuts), dtype=np.int64)
        return self.divided(
            np.insert(self.breakpoints, first, cuts), np.insert(self._low, first, 0.0)
        )

    def no_wider(self, widest: float | Array) -> "PressureSpace":
        """Return the space with elements no wider than `widest`: wider ones are cut evenly.

        It is one number, or one (E,) for each element.
        """
        counts = np.maximum(np.ceil(self.widths / widest), 1).astype(np.int64)
        if (counts == 1).all():
            return self
        number = np.repeat(np.arange(len(counts)), counts)
        part_index = np.arange(len(number)) - np.repeat(np.cumsum(counts) - counts, counts)
        cut = self.widths[number] * part_index / counts[number]
        breakpoints = np.append(self.breakpoints[number] + cut, self.breakpoints[-1])
        low_parts = np.append(np.where(part_index > 0, 0.0, self._low[number]), self._low[-1])
        return self.divided(breakpoints, low_parts)

    def embedding(self, coarse: "PressureSpace") -> csr_matrix:
        """Return the matrix (size, coarse size) that embeds a subspace in this space.

        Each column holds the coefficients, on this space, of one basis function of the subspace
        `coarse`.
        """
        parent = np.searchsorted(coarse.sort_keys, self.sort_keys[1:]) - 1
        left, width = coarse.breakpoints[parent, None], coarse.widths[parent, None]
        node = gauss(self.top + 1)[0]
        distances = self.breakpoints[:-1, None] - left
        distances = distances + (self._low[:-1] - coarse._low[parent])[:, None]
        distances = distances + self.widths[:, None] * (1 + node) / 2
        values = shapes(2 * distances / width - 1, coarse.top)
        coefficients = np.linalg.inv(shapes(node, self.top)) @ values
        # the coefficient of a vertex between two elements of a ring is entered only once
        coefficients[1:, 0][np.diff(self.ring) == 0] = 0.0
        rows, columns = self.dofs[:, :, None], coarse.dofs[parent][:, None, :]
        return coarse._assembled(coefficients, rows, columns, self.size)


def shapes(local: Array, top: int) -> Array:
    """Return hats and integrated Legendre bubbles (..., top+1) at local coordinates in [-1, 1]."""
    legendre = np.polynomial.legendre.legvander(local, top)
    values = np.empty((*np.shape(local), top + 1))
    values[..., 0], values[..., 1] = (1 - local) / 2, (1 + local) / 2
    degrees = np.arange(2, top + 1)
    values[..., 2:] = (legendre[..., 2:] - legendre[..., :-2]) / np.sqrt(4 * degrees - 2)
    return values


def shape_slopes(local: Array, top: int) -> Array:
    """Return the derivatives (..., top+1) of `shapes` in the local coordinate."""
    legendre = np.polynomial.legendre.legvander(local, top)
    half = np.full_like(local, 0.5)
    return np.stack(
        [-half, half, *(legendre[..., j - 1] * np.sqrt(j - 0.5) for j in range(2, top + 1))],
        axis=-1,
    )
