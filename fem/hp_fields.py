"""Displacements and stresses inside the half-space of high degree, at a lattice of points in every element."""

from __future__ import annotations

import numpy as np

from meshes.radial import Array, Indices

from .compliance import HalfSpace
from .fields import displacements, stresses_of
from .hp import Batch, HpElasticity
from .hp_stiffness import geometry
from .lobatto import Element


def sampled(half_space: HalfSpace, pressures: Array, fineness: int) -> tuple[Array, Indices, Array, Array]:
    """The fields of the elements under (states, size) pressure coefficients, not averaged between elements.

    Parameters
    ----------
    half_space : its solid is an `HpElasticity`
    fineness : into how many a side is cut: a quadrilateral into ``2 fineness^2`` small triangles, a triangle into half

    Returns
    -------
    points : (P, 2) radius and depth, those on sides once for each element
    triangles : (T, 3) the small triangles between them, counter-clockwise
    displacement : (states, P, 2) radial, and into the half-space
    stress : (states, P, 4) rr, zz, rz, hoop; singular at the rim and at ring edges

    Raises
    ------
    SolverError
        if the stiffness of the half-space is singular
    """
    solid = half_space.solid
    assert isinstance(solid, HpElasticity)
    moved = displacements(half_space, pressures)
    known = np.concatenate([moved[..., 0], moved[..., 1], np.zeros((len(moved), 1))], axis=1)
    points, triangles, displacement, stress = [], [], [], []
    count = 0
    for batch, (_, inside) in zip(solid.batches, solid.condensed, strict=True):
        lattice, small = batch.element.lattice(fineness)
        local = _local(batch, inside, known)
        at, value, tension = _fields(batch, local, lattice, solid.poisson_ratio)
        points.append(at.reshape(-1, 2))
        displacement.append(value.reshape(len(moved), -1, 2))
        stress.append(tension.reshape(len(moved), -1, 4))
        starts = count + lattice.shape[1] * np.arange(len(at))
        triangles.append((starts[:, None, None] + small).reshape(-1, 3))
        count += lattice.shape[1] * len(at)
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(displacement, 1), np.concatenate(stress, 1)


def _local(batch: Batch, inside: Array, known: Array) -> Array:
    """(states, m, 2, n) coefficients of each element, by (states, unknowns + 1) coefficients on sides."""
    boundary = known[:, batch.unknowns]
    inner = np.einsum("mib,smb->smi", inside, boundary, optimize=True)
    shape = (*boundary.shape[:2], 2, -1)
    return np.concatenate([(boundary * batch.signs).reshape(shape), inner.reshape(shape)], axis=-1)


def _fields(batch: Batch, local: Array, points: Array, poisson_ratio: float) -> tuple[Array, Array, Array]:
    """Points (m, q, 2), displacements (states, m, q, 2) and stresses (states, m, q, 4) at reference points."""
    at, displacement, strains = _strains(batch, local, points)
    gauss, weights = batch.element.rule(batch.degree + 1)
    _, _, (rr_gauss, zz_gauss, _, hoop_gauss) = _strains(batch, local, gauss)
    smooth = _projection(batch.element, gauss, weights, points, max(batch.degree - 2, 0))
    # near incompressibility lambda makes noise of the dilatation but for its part of lower degree
    dilatation = (rr_gauss + zz_gauss + hoop_gauss) @ smooth
    return at, displacement, stresses_of(strains, dilatation, poisson_ratio)


def _strains(batch: Batch, local: Array, points: Array) -> tuple[Array, Array, Array]:
    """Points (m, q, 2), displacements (states, m, q, 2) and strains rr, zz, rz, hoop (4, states, m, q)."""
    values, gradients = batch.element.functions(points, batch.degree)
    corner_values, corner_gradients = batch.element.functions(points, 1)
    at, inverse, _ = geometry(batch.corners, (corner_values, corner_gradients))
    displacement = local @ values
    slopes = np.einsum("smci,iaq,mxaq->cxsmq", local, gradients, inverse, optimize=True)
    radius = at[..., 0]
    on_axis = radius <= 1e-12 * batch.corners[..., 0].max(axis=1, keepdims=True)
    radius[on_axis] = 0.0
    hoop = np.where(on_axis, slopes[0, 0], displacement[:, :, 0] / np.where(on_axis, 1.0, radius))
    strains = np.stack([slopes[0, 0], slopes[1, 1], (slopes[0, 1] + slopes[1, 0]) / 2, hoop])
    return at, np.moveaxis(displacement, 2, 3), strains


def _projection(element: Element, gauss: Array, weights: Array, points: Array, degree: int) -> Array:
    """(q, points) values of the projection on polynomials of a degree, by values at the quadrature points."""
    moments = element.polynomials(gauss, degree) * weights
    gram = moments @ element.polynomials(gauss, degree).T
    return moments.T @ np.linalg.solve(gram, element.polynomials(points, degree))
