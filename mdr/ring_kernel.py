"""The compliance by boundary elements: the Galerkin matrix of the ring kernel (Eq. 19).

It uses no identity of the MDR.

``A_ij = int int G(r, s) phi_i(r) phi_j(s) dA dA``, ``G = 2 K(k) / (pi^2 (r + s))``, whose
complementary modulus is ``|r - s| / (r + s)``. The kernel is logarithmic at ``r = s``. If the two
elements are identical or share a breakpoint, their product is split into triangles at a common
vertex (Duffy), and powers smooth the logarithms. Separate elements have as many Gauss points as the
nearest singularity requires. Distances are sums of parts of elements, never differences of radii,
so that elements may be tiny. Non-dimensional: punch radius 1, modulus 1.
"""

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky
from scipy.special import ellipkm1

from ..meshes.compliance import Compliance
from ..meshes.errors import SolverError
from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.pressure_space import PressureSpace, shapes
from ..meshes.radial import Array, Indices, unit_gauss
from .layers import added_by_layers

# Numbers of Gauss points in an element that does not touch the other one. If the largest is not
# enough, points are clustered at the gap by powers.
GAUSS_LADDER = (4, 6, 8, 10, 12, 15, 18, 22, 28, 36, 48, 64)


class _Rule(NamedTuple):
    """Quadrature with q points for pairs of elements; the first element is the inner one.

    The two elements of a pair may be identical.

    first, second : (q,) radii, as fractions of each element from its left end
    gap_parts : two arrays (q,), fractions of the two widths; the distance between the radii is the
        gap plus these parts
    weight : (q,) weights of the unit square
    """

    first: Array
    second: Array
    gap_parts: tuple[Array, Array]
    weight: Array


_Blocks = Iterator[tuple[Indices, Indices, Array]]


def compliance(space: PressureSpace, ground: Ground = HALF_SPACE) -> Compliance:
    """Return the compliance of the half-space on `space` by the ring kernel.

    Parameters
    ----------
    space : pressure space, `size` functions
    ground : layers, which add to the kernel

    Returns
    -------
    Compliance
        Its factor is the Cholesky factor of the matrix, (size, size) and upper triangular.

    Raises
    ------
    SolverError
        if the matrix is not positive definite because of roundoff
    """
    rows = space.size + 1
    # each pair of points is integrated in one order only; the transpose is the other order
    half = np.zeros(rows * rows)
    for first, second, blocks in itertools.chain(_touching(space), _separate(space)):
        place = space.dofs[first][:, :, None] * rows + space.dofs[second][:, None, :]
        np.add.at(half, place.ravel(), blocks.ravel())
    half = half.reshape(rows, rows)[:-1, :-1]
    matrix = half + half.T + added_by_layers(space, ground)
    try:
        factor = cholesky(matrix, check_finite=False)
    except np.linalg.LinAlgError as error:
        raise SolverError(
            f"the boundary-element compliance of {space.size} unknowns is not positive definite to "
            "roundoff: lower the degree of the pressure, or grade the radial mesh less"
        ) from error
    return Compliance(space, factor, ground)


def _touching(space: PressureSpace) -> _Blocks:
    """Yield the blocks of each element with itself, and of each element with its neighbour.

    An element with itself is integrated over the triangle in which the second radius is smaller.
    Two elements that share a breakpoint are integrated over both triangles at that corner.
    """
    depth, cut, weight = _product(_flattened(space.top), _flattened(space.top))
    element, weight = np.arange(len(space.degrees)), depth * weight
    # the vertex is the left end, because at the axis its depth cancels the pole of 1/(r + s)
    same_element = _Rule(depth, depth * (1 - cut), (depth * cut, np.zeros_like(cut)), weight)
    yield from _integrate(space, element, element, same_element)
    for inward, outward in ((depth, depth * cut), (depth * cut, depth)):
        yield from _integrate(space, element[:-1], element[1:], _facing(inward, outward, weight))


def _separate(space: PressureSpace) -> _Blocks:
    """Yield the blocks of pairs of elements that do not touch, grouped by quadrature rule."""
    first, second = np.triu_indices(len(space.degrees), 2)
    gap = space.distance(first + 1, second)
    rules = [*map(unit_gauss, GAUSS_LADDER), _flattened(space.top)]
    group = _rung(space, first, gap) * len(rules) + _rung(space, second, gap)
    for number in np.unique(group):
        pairs = np.flatnonzero(group == number)
        rule = _facing(*_product(rules[number // len(rules)], rules[number % len(rules)]))
        yield from _integrate(space, first[pairs], second[pairs], rule)


def _rung(space: PressureSpace, element: Indices, gap: Array) -> Indices:
    """Return the index of the Gauss count that suffices for elements with a singularity at `gap`.

    The index refers to `GAUSS_LADDER`; if no count suffices it is the length of the ladder.

    Notes
    -----
    The Chebyshev coefficients of the kernel decrease by the sum of the semi-axes of the ellipse
    that has the ends of the element as foci and passes through the singularity. Gauss quadrature is
    exact up to a degree of twice the number of points.
    """
    width = space.widths[element]
    decay = 2 * np.arcsinh(np.sqrt(gap / width))
    count = (space.degrees[element] + 2 - np.log(1e-16) / decay) / 2
    return np.searchsorted(GAUSS_LADDER, count)


def _flattened(degree: int) -> tuple[Array, Array]:
    """Return points and weights on (0, 1) for integrands with a logarithm at 0.

    The integrands are products of two shape functions of a degree and the logarithm. With
    ``x = w^6``, ``log(x) dx`` is smooth enough at w = 0 for Gauss points in w.
    """
    node, weight = unit_gauss(28 + 2 * degree)
    return node**6, weight * 6 * node**5


def _product(inner: tuple[Array, Array], outer: tuple[Array, Array]) -> tuple[Array, Array, Array]:
    """Return points (q,), (q,) and weights (q,) of the product of two rules on the unit square."""
    x, y = np.meshgrid(inner[0], outer[0], indexing="ij")
    return x.ravel(), y.ravel(), np.outer(inner[1], outer[1]).ravel()


def _facing(inward: Array, outward: Array, weight: Array) -> _Rule:
    """Return the rule of two different elements.

    `inward` and `outward` are fractions of the two widths, measured from the ends that face each
    other.
    """
    return _Rule(1 - inward, outward, (inward, outward), weight)


def _integrate(space: PressureSpace, first: Indices, second: Indices, rule: _Rule) -> _Blocks:
    """Yield groups of pairs of elements, and their blocks (m, top+1, top+1) by a rule."""
    local = space.top + 1
    products = np.einsum(
        "q,qi,qj->qij",
        rule.weight,
        shapes(2 * rule.first - 1, space.top),
        shapes(2 * rule.second - 1, space.top),
    ).reshape(-1, local**2)
    left, widths = space.breakpoints[:-1, None], space.widths[:, None]
    # at most a million values of the kernel, or entries of blocks, in each group
    count = max(1, 10**6 // max(len(rule.weight), local**2))
    for start in range(0, len(first), count):
        inner, outer = first[start : start + count], second[start : start + count]
        inner_width, outer_width = widths[inner], widths[outer]
        # the gap of an element with itself is zero
        gap = np.maximum(space.distance(inner + 1, outer), 0.0)[:, None]
        distance = gap + inner_width * rule.gap_parts[0] + outer_width * rule.gap_parts[1]
        kernel = _weighted_kernel(
            left[inner] + inner_width * rule.first,
            left[outer] + outer_width * rule.second,
            distance,
        )
        blocks = inner_width * outer_width * (kernel @ products)
        yield inner, outer, blocks.reshape(-1, local, local)


def _weighted_kernel(radius: Array, ring: Array, distance: Array) -> Array:
    """Return the kernel of Eq. 19 with its areas, ``G dA dA / (dr ds) = 8 r s K / (r + s)``.

    The radii r (`radius`) and s (`ring`) are `distance` apart.
    """
    radius_sum = radius + ring
    return 8 * radius * ring / radius_sum * ellipkm1((distance / radius_sum) ** 2)
