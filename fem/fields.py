"""Displacements and stresses inside the half-space, recovered from contact pressures."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from meshes.errors import SolverError
from meshes.radial import Array

from .compliance import HalfSpace
from .elasticity import AxisymmetricElasticity, moduli


def displacements(half_space: HalfSpace, pressures: Array) -> Array:
    """(states, nodes, 2) radial and axial displacement under (states, size) pressure coefficients."""
    system, size = half_space.system, half_space.coupling.shape[0]
    right = np.zeros((system.shape[0], len(pressures)))
    right[-size:] = half_space.coupling @ pressures.T
    symmetric = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    solution = splu(system, permc_spec="MMD_AT_PLUS_A", **symmetric).solve(right)
    if not np.isfinite(solution).all():
        raise SolverError("the stiffness of the half-space is singular: no displacement can be recovered")
    return half_space.expand(solution)


def stresses(solid: AxisymmetricElasticity, displacement: Array, points: Array) -> Array:
    """(states, m, q, 4) stresses rr, zz, rz, hoop at (2, q) reference points of each of the m triangles."""
    value, gradient = solid.reference(points)
    inverse, _ = solid.inverse_jacobian
    local = solid.on_triangles(displacement)
    slopes = np.einsum("iaq,axm,simc->smqcx", gradient, inverse, local, optimize=True)
    radius = np.einsum("vm,vq->mq", solid.corners[0], np.stack([1 - points[0] - points[1], points[0], points[1]]))
    radial = np.einsum("iq,sim->smq", value, local[..., 0], optimize=True)
    on_axis = radius == 0
    hoop = np.where(on_axis, slopes[..., 0, 0], radial / np.where(on_axis, 1.0, radius))
    strains = np.stack([slopes[..., 0, 0], slopes[..., 1, 1], (slopes[..., 0, 1] + slopes[..., 1, 0]) / 2, hoop])
    # the dilatation that carries the energy: near incompressibility lambda would make noise of any other
    return stresses_of(strains, solid.dilatation(local, points), solid.poisson_ratio)


def stresses_of(strains: Array, dilatation: Array, poisson_ratio: float) -> Array:
    """(..., 4) stresses rr, zz, rz, hoop by (4, ...) strains and a smoother dilatation (...) than theirs."""
    lame, shear = moduli(poisson_ratio)
    rr, zz, rz, hoop = strains
    # strains that do not add up to that dilatation share what is missing
    missing = (dilatation - rr - zz - hoop) / 3
    rr, zz, hoop = (lame * dilatation + 2 * shear * (strain + missing) for strain in (rr, zz, hoop))
    return np.stack([rr, zz, 2 * shear * rz, hoop], axis=-1)


def vertex_stresses(solid: AxisymmetricElasticity, displacement: Array) -> Array:
    """(states, vertices, 4) stresses rr, zz, rz, hoop at the mesh vertices, averaged over the triangles around each.

    Singular at the rim and at ring edges: values there show the element size, not the solid.
    """
    at_corners = stresses(solid, displacement, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    _, area = solid.inverse_jacobian
    vertices = solid.vertices
    out = np.zeros((len(displacement), vertices.max() + 1, 4))
    weight = np.zeros(vertices.max() + 1)
    for corner in range(3):
        for state, values in zip(out, at_corners, strict=True):
            np.add.at(state, vertices[corner], area[:, None] * values[:, corner])
        np.add.at(weight, vertices[corner], area)
    return out / weight[:, None]


def von_mises(stress: Array) -> Array:
    """(...) von Mises stress of (..., 4) stresses."""
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    return np.sqrt(((rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2) / 2 + 3 * rz**2)
