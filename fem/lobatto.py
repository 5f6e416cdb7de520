"""Hierarchical functions of any degree on the reference quadrilateral and the reference triangle.

Corners, sides and inside have functions of their own, and those of one degree are among those of every higher one.
Along a side they are the hats and integrated Legendre bubbles of the pressure space: elements of two kinds and two
degrees meet on a side by the bubbles that both have. Bubbles of odd degree change sign with the direction of a side.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss, legvander

from meshes.pressure_space import shape_slopes, shapes
from meshes.radial import Array, Indices


class Element(ABC):
    """A reference element; its functions are those of corners, then of sides, by degree, then those inside."""

    corners: int
    # corners of each side, in the direction of its bubbles
    sides: tuple[tuple[int, int], ...]

    def outer(self, degree: int) -> int:
        """Number of functions that do not vanish on the boundary."""
        return self.corners + len(self.sides) * (degree - 1)

    @abstractmethod
    def inner(self, degree: int) -> int:
        """Number of functions that vanish on the boundary."""

    @abstractmethod
    def functions(self, points: Array, degree: int) -> tuple[Array, Array]:
        """Values (n, q) and gradients (n, 2, q) of the functions at (2, q) points."""

    @abstractmethod
    def polynomials(self, points: Array, degree: int) -> Array:
        """(t, q) a basis of the polynomials of a degree, close to orthogonal."""

    @abstractmethod
    def rule(self, count: int) -> tuple[Array, Array]:
        """Points (2, count^2) off the boundary and weights: exact for polynomials of degree ``2 count - 2``."""

    @abstractmethod
    def lattice(self, fineness: int) -> tuple[Array, Indices]:
        """Equispaced points (2, q), and the small triangles (t, 3) between them, counter-clockwise."""


class Quadrilateral(Element):
    """The square from -1 to 1, its functions products of those of a line."""

    corners = 4
    sides = ((0, 1), (1, 2), (3, 2), (0, 3))

    def inner(self, degree: int) -> int:
        return (degree - 1) ** 2

    def functions(self, points: Array, degree: int) -> tuple[Array, Array]:
        (x, y), (x_slope, y_slope) = shapes(points, degree), shape_slopes(points, degree)
        bubbles = np.arange(2, degree + 1)
        low, high = np.zeros_like(bubbles), np.ones_like(bubbles)
        first = np.concatenate([[0, 1, 1, 0], bubbles, high, bubbles, low, np.repeat(bubbles, degree - 1)])
        second = np.concatenate([[0, 0, 1, 1], low, bubbles, high, bubbles, np.tile(bubbles, degree - 1)])
        along_x, along_y = x_slope[:, first] * y[:, second], x[:, first] * y_slope[:, second]
        return (x[:, first] * y[:, second]).T, np.stack([along_x.T, along_y.T], axis=1)

    def polynomials(self, points: Array, degree: int) -> Array:
        x, y = legvander(points, degree)
        return np.einsum("qi,qj->ijq", x, y).reshape(-1, points.shape[1])

    def rule(self, count: int) -> tuple[Array, Array]:
        node, weight = leggauss(count)
        return np.stack(np.meshgrid(node, node)).reshape(2, -1), np.outer(weight, weight).ravel()

    def lattice(self, fineness: int) -> tuple[Array, Indices]:
        node = np.linspace(-1, 1, fineness + 1)
        number = np.arange((fineness + 1) ** 2).reshape(fineness + 1, -1)
        a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
        halves = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        return np.stack(np.meshgrid(node, node)).reshape(2, -1), halves


class Triangle(Element):
    """The triangle (0, 0), (1, 0), (0, 1)."""

    corners = 3
    sides = ((0, 1), (1, 2), (0, 2))

    def inner(self, degree: int) -> int:
        return (degree - 1) * (degree - 2) // 2

    def functions(self, points: Array, degree: int) -> tuple[Array, Array]:
        corner, slopes = _barycentric(points), np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
        values, gradients = [corner], [np.repeat(slopes[:, :, None], points.shape[1], axis=2)]
        for a, b in self.sides:
            # a bubble of the line is the product of its hats times a kernel of the difference of both
            kernel, kernel_slope = _kernels(corner[b] - corner[a], degree)
            product = corner[a] * corner[b]
            by_product = np.outer(slopes[a], corner[b]) + np.outer(slopes[b], corner[a])
            values.append(kernel * product)
            along = np.einsum("kq,x->kxq", kernel_slope * product, slopes[b] - slopes[a])
            gradients.append(kernel[:, None] * by_product + along)
        if degree > 2:
            inner, inner_gradient = _inside(corner, slopes, degree)
            values.append(inner)
            gradients.append(inner_gradient)
        return np.concatenate(values), np.concatenate(gradients)

    def polynomials(self, points: Array, degree: int) -> Array:
        corner = _barycentric(points)
        first, second = _by_total_degree(degree)
        one, other = legvander(corner[1] - corner[0], degree), legvander(2 * corner[2] - 1, degree)
        return (one[:, first] * other[:, second]).T

    def rule(self, count: int) -> tuple[Array, Array]:
        points, weights = QUADRILATERAL.rule(count)
        # the square collapsed on the last corner
        height = (1 + points[1]) / 2
        return np.stack([(1 + points[0]) / 2 * (1 - height), height]), weights * (1 - height) / 4

    def lattice(self, fineness: int) -> tuple[Array, Indices]:
        pairs = [(i, j) for j in range(fineness + 1) for i in range(fineness + 1 - j)]
        number = {pair: k for k, pair in enumerate(pairs)}
        upward = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in pairs if i + j < fineness]
        downward = [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in pairs if i + j < fineness - 1]
        return np.array(pairs, dtype=float).T / fineness, np.array(upward + downward)


QUADRILATERAL, TRIANGLE = Quadrilateral(), Triangle()


@lru_cache(maxsize=32)
def at_rule(element: Element, degree: int, count: int) -> tuple[Array, Array, Array, Array]:
    """Values and gradients of the functions, values of those of the corners alone, and weights, at the rule's points."""
    points, weights = element.rule(count)
    values, gradients = element.functions(points, degree)
    return values, gradients, values[: element.corners], weights


@lru_cache(maxsize=32)
def products(element: Element, degree: int, count: int) -> Array:
    """(q, n n) products of every two functions at the rule's points."""
    values, *_ = at_rule(element, degree, count)
    return np.einsum("iq,jq->qij", values, values).reshape(values.shape[1], -1)


def _barycentric(points: Array) -> Array:
    """(3, q) barycentric coordinates."""
    return np.stack([1 - points[0] - points[1], points[0], points[1]])


def _by_total_degree(degree: int) -> tuple[Indices, Indices]:
    """Exponents of the products of two polynomials up to a total degree, by that degree."""
    total = np.repeat(np.arange(degree + 1), np.arange(degree + 1) + 1)
    second = np.arange(len(total)) - total * (total + 1) // 2
    return total - second, second


def _kernels(argument: Array, degree: int) -> tuple[Array, Array]:
    """(degree-1, q) values and slopes of the bubbles of a line over the product of its hats."""
    order = np.arange(2, degree + 1)
    # (P_k - P_(k-2)) / (1 - x^2) = -(2k - 1) / (k (k - 1)) P'_(k-1)
    scale = -4 * (2 * order - 1) / (order * (order - 1)) / np.sqrt(4 * order - 2)
    slopes = [Legendre.basis(k - 1).deriv() for k in order]
    values = np.array([slope(argument) for slope in slopes]).reshape(-1, len(argument))
    curvatures = np.array([slope.deriv()(argument) for slope in slopes]).reshape(-1, len(argument))
    return scale[:, None] * values, scale[:, None] * curvatures


def _inside(corner: Array, slopes: Array, degree: int) -> tuple[Array, Array]:
    """Values and gradients of the functions that vanish on the boundary of the triangle."""
    bubble = corner.prod(axis=0)
    by_bubble = np.einsum("vx,vq->xq", slopes, np.roll(corner, 1, axis=0) * np.roll(corner, 2, axis=0))
    first, second = _by_total_degree(degree - 3)
    one, one_slope = _legendre(corner[1] - corner[0], degree - 3)
    other, other_slope = _legendre(2 * corner[2] - 1, degree - 3)
    # of about the same energy each, which keeps the equations well conditioned
    scale = 10.0 * (first + second + 1)[:, None]
    product = scale * one[first] * other[second]
    along = np.einsum("kq,x->kxq", scale * one_slope[first] * other[second], slopes[1] - slopes[0])
    along += np.einsum("kq,x->kxq", scale * one[first] * other_slope[second], 2 * slopes[2])
    return bubble * product, product[:, None] * by_bubble + bubble * along


def _legendre(argument: Array, degree: int) -> tuple[Array, Array]:
    """(degree+1, q) values and slopes of the Legendre polynomials."""
    slopes = [Legendre.basis(k).deriv()(argument) for k in range(degree + 1)]
    return np.array(legvander(argument, degree).T, dtype=np.float64), np.array(slopes).reshape(-1, len(argument))
