"""Displacements and stresses inside the half-space, recovered from contact pressures and interpolated by scikit-fem."""

import numpy as np
from scipy.sparse.linalg import splu
from skfem import CellBasis, MeshQuad
from skfem.quadrature import get_quadrature

from ringwear.fem.condensation import SYMMETRIC
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.half_space import HalfSpace
from ringwear.fem.weak_form import element_of_degree, moduli, projection
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array, Indices


def displacements(half_space: HalfSpace, pressures: Array) -> Array:
    """(states, functions, 2) radial and axial coefficients under (states, size) pressure coefficients.

    Raises
    ------
    SolverError
        if the stiffness of the half-space is singular
    """
    system, loads = half_space.system, half_space.coupling @ pressures.T
    right = np.pad(loads, ((system.shape[0] - len(loads), 0), (0, 0)))
    solution = splu(system, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).solve(right)
    if not np.isfinite(solution).all():
        raise SolverError("the stiffness of the half-space is singular: no displacement can be recovered")
    return half_space.solid.with_insides(half_space.expand(solution))


def stresses(solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array) -> tuple[Array, Array]:
    """Displacements (states, m, q, 2) and stresses rr, zz, rz, hoop (states, m, q, 4) at reference points of elements.

    The elements must be of one degree. Near incompressibility lambda makes noise of the dilatation but for its part of
    lower degree: the dilatation is projected on that.
    """
    degree = int(solid.degrees[elements[0]])
    quadrature, weights = get_quadrature(solid.element, 2 * degree + 1)
    lower = element_of_degree(solid.mesh, max(degree - (2 if isinstance(solid.mesh, MeshQuad) else 1), 1))
    _, (rr, zz, _, hoop) = _strains(solid, displacement, elements, quadrature)
    dilatation = (rr + zz + hoop) @ projection(lower, quadrature, weights, points)
    moved, (rr, zz, rz, hoop) = _strains(solid, displacement, elements, points)
    lame, shear = moduli(solid.poisson_ratio)
    # strains that do not add up to that dilatation share what is missing
    missing = (dilatation - rr - zz - hoop) / 3
    rr, zz, hoop = (lame * dilatation + 2 * shear * (strain + missing) for strain in (rr, zz, hoop))
    return moved, np.stack([rr, zz, 2 * shear * rz, hoop], axis=-1)


def _strains(solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array) -> tuple[Array, Array]:
    """Displacements (states, m, q, 2) and strains rr, zz, rz, hoop (4, states, m, q) at reference points of elements."""
    basis = CellBasis(solid.mesh, solid.element, elements=elements, quadrature=(points, np.ones(points.shape[1])))
    r = basis.global_coordinates()[0]
    on_axis = r <= 1e-12 * r.max(axis=1, keepdims=True)
    moved, strains = [], []
    for state in displacement:
        radial, axial = (basis.interpolate(component) for component in state.T)
        hoop = np.where(on_axis, radial.grad[0], radial / np.where(on_axis, 1.0, r))
        moved.append(np.stack([radial, axial], axis=-1))
        strains.append([radial.grad[0], axial.grad[1], (radial.grad[1] + axial.grad[0]) / 2, hoop])
    return np.array(moved), np.array(strains).swapaxes(0, 1)


def sampled(half_space: HalfSpace, pressures: Array, refinements: int) -> tuple[Array, Indices, Array, Array]:
    """The fields of all elements under (states, size) pressure coefficients, not averaged between elements.

    Parameters
    ----------
    refinements : how many times each element is refined to make the small triangles

    Returns
    -------
    points : (2, P) radius and depth, those on facets once for each element
    triangles : (3, T) the small triangles between them
    displacement : (states, P, 2) radial, and into the half-space
    stress : (states, P, 4) rr, zz, rz, hoop; singular at the rim and at ring edges
    """
    solid = half_space.solid
    coefficients = displacements(half_space, pressures)
    reference = type(solid.mesh).init_refdom().refined(refinements)
    small = (reference.to_meshtri() if isinstance(reference, MeshQuad) else reference).t
    starts = reference.nvertices * np.arange(solid.mesh.nelements)
    triangles = (small[:, None] + starts[:, None]).reshape(3, -1)
    points, moved, stress = [], [], []
    for batch in solid.batches:
        shift, tension = stresses(solid, coefficients, batch.elements, reference.p)
        points.append(solid.mesh.mapping().F(reference.p, batch.elements).reshape(2, -1))
        moved.append(shift.reshape(len(coefficients), -1, 2))
        stress.append(tension.reshape(len(coefficients), -1, 4))
    return np.concatenate(points, 1), triangles, np.concatenate(moved, 1), np.concatenate(stress, 1)


def von_mises(stress: Array) -> Array:
    """(...) von Mises stress of (..., 4) stresses."""
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    return np.sqrt(((rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2) / 2 + 3 * rz**2)
