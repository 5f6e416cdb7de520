"""Stiffness of single elements of high degree: reference tensors times what little differs between elements.

Only the hoop energy ``int (c/r) u_r^2 dA`` is rational. Every other integral on a straight triangle is a polynomial; and
the quadrilaterals of stars are copies of a few shapes, scaled and moved along the radius, so that of each shape two
tensors are enough: ``stiffness = c A + h B`` with the mean radius `c` and the scale `h`.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from meshes.radial import Array

from .elasticity import moduli
from .lobatto import QUADRILATERAL, TRIANGLE, Element, at_rule, products


def stiffness(element: Element, corners: Array, degree: int, poisson_ratio: float) -> Array:
    """(m, 2, n, 2, n) stiffness of each element: radial and axial displacements of its n functions.

    Parameters
    ----------
    corners : (m, corners, 2) radius and depth of the corners, counter-clockwise
    """
    smooth = {QUADRILATERAL: _quadrilaterals, TRIANGLE: _triangles}[element]
    out = smooth(corners, degree, poisson_ratio)
    lame, shear = moduli(poisson_ratio)
    out[:, 0, :, 0] += (lame + 2 * shear) * _hoop(element, corners, degree)
    return out


def geometry(corners: Array, local: tuple[Array, Array]) -> tuple[Array, Array, Array]:
    """Points (m, q, 2), derivatives (m, x, a, q) of reference coordinates `a` by physical `x`, area factors (m, q).

    `local` are values (corners, q) and gradients (corners, a, q) of the functions of the corners.
    """
    values, gradients = local
    points = np.einsum("mvx,vq->mqx", corners, values)
    (rx, ry), (zx, zy) = np.einsum("mvx,vaq->xamq", corners, gradients, optimize=True)
    area = rx * zy - ry * zx
    inverse = np.stack([zy, -zx, -ry, rx], axis=1).reshape(len(corners), 2, 2, -1) / area[:, None, None]
    return points, inverse, area


def _hoop(element: Element, corners: Array, degree: int) -> Array:
    """(m, n, n) ``2 pi int phi_i phi_j / r dA``: a richer rule for triangles, which reach the axis; its points do not."""
    count = degree + (2 if element is QUADRILATERAL else 4)
    _, gradients, at_corners, weights = at_rule(element, degree, count)
    points, _, area = geometry(corners, (at_corners, gradients[: element.corners]))
    table = products(element, degree, count)
    n = round(table.shape[1] ** 0.5)
    return ((2 * np.pi * weights * area / points[..., 0]) @ table).reshape(-1, n, n)


def _triangles(corners: Array, degree: int, poisson_ratio: float) -> Array:
    lame, shear = moduli(poisson_ratio)
    slopes, mixed = _triangle_tables(degree)
    n = round(slopes.shape[1] ** 0.5)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
    inverse = np.stack([b[:, 1], -a[:, 1], -b[:, 0], a[:, 0]], axis=1).reshape(-1, 2, 2) / area[:, None, None]
    by_radius = 2 * np.pi * area[:, None] * corners[..., 0]

    def energies(x: int, y: int) -> Array:
        constants = np.einsum("mv,ma,mb->mvab", by_radius, inverse[:, x], inverse[:, y])
        return (constants.reshape(-1, 12) @ slopes).reshape(-1, n, n)

    radial, axial = (((2 * np.pi * area)[:, None] * inverse[:, x] @ mixed).reshape(-1, n, n) for x in (0, 1))
    rr, zz, rz = energies(0, 0), energies(1, 1), energies(0, 1)
    return _blocks(lame, shear, (rr, zz, rz), (radial, axial))


@lru_cache(maxsize=16)
def _triangle_tables(degree: int) -> tuple[Array, Array]:
    """Tables (12, n n) of ``lambda_v d_a phi_i d_b phi_j`` and (2, n n) of ``phi_i d_a phi_j``, integrated."""
    values, gradients, corner, weights = at_rule(TRIANGLE, degree, degree + 2)
    slopes = np.einsum("vq,iaq,jbq->vabij", corner * weights, gradients, gradients, optimize=True)
    mixed = np.einsum("q,iq,jaq->aij", weights, values, gradients, optimize=True)
    return slopes.reshape(12, -1), mixed.reshape(2, -1)


def _quadrilaterals(corners: Array, degree: int, poisson_ratio: float) -> Array:
    middle = corners.mean(axis=1, keepdims=True)
    scale = np.ptp(corners, axis=1).max(axis=1)
    # shapes that are equal but for roundoff are one, known best from the largest
    order = np.argsort(-scale, kind="stable")
    shapes = ((corners - middle) / scale[:, None, None]).reshape(-1, 8)[order]
    _, first, kind = np.unique(np.round(shapes, 6), axis=0, return_index=True, return_inverse=True)
    constants = np.stack([middle[:, 0, 0], scale], axis=1)
    n = (degree + 1) ** 2
    out = np.empty((len(corners), 2, n, 2, n))
    for k, shape in enumerate(shapes[first]):
        alike = order[kind == k]
        out[alike] = np.tensordot(constants[alike], _shape_tensors(tuple(shape), degree, poisson_ratio), 1)
    return out


@lru_cache(maxsize=128)
def _shape_tensors(shape: tuple[float, ...], degree: int, poisson_ratio: float) -> Array:
    """(2, 2, n, 2, n) stiffness without the hoop energy, by the mean radius and by the scale."""
    values, gradients, at_corners, weights = at_rule(QUADRILATERAL, degree, degree + 4)
    corners = np.reshape(shape, (1, 4, 2))
    points, inverse, area = geometry(corners, (at_corners, gradients[:4]))
    measure = 2 * np.pi * weights * area[0]
    slopes = np.einsum("iaq,xaq->xiq", gradients, inverse[0])
    moment = measure * points[0, :, 0]
    lame, shear = moduli(poisson_ratio)
    none = np.zeros((1, 1, 1))

    def energies(weight: Array) -> tuple[Array, Array, Array]:
        return tuple(((slopes[x] * weight) @ slopes[y].T)[None] for x, y in ((0, 0), (1, 1), (0, 1)))

    mixed = (values * measure) @ slopes.transpose(0, 2, 1)
    by_radius = _blocks(lame, shear, energies(measure), (none, none))
    return np.concatenate([by_radius, _blocks(lame, shear, energies(moment), (mixed[:1], mixed[1:]))])


def _blocks(lame: float, shear: float, energies: tuple[Array, Array, Array], mixed: tuple[Array, Array]) -> Array:
    """(m, 2, n, 2, n) stiffness without the hoop energy.

    Parameters
    ----------
    energies : (m, n, n) ``int r d_x phi_i d_y phi_j`` for xy = rr, zz, rz
    mixed : (m, n, n) ``int phi_i d_x phi_j`` for x = r, z
    """
    (rr, zz, rz), (radial, axial) = energies, mixed
    m, n, _ = rr.shape
    out = np.empty((m, 2, n, 2, n))
    out[:, 0, :, 0] = (lame + 2 * shear) * rr + shear * zz + lame * (radial + radial.transpose(0, 2, 1))
    out[:, 1, :, 1] = (lame + 2 * shear) * zz + shear * rr
    out[:, 0, :, 1] = lame * (rz + axial) + shear * rz.transpose(0, 2, 1)
    out[:, 1, :, 0] = out[:, 0, :, 1].transpose(0, 2, 1)
    return out
