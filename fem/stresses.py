"""Stresses inside the half-space, recovered from contact pressures in scikit-fem's elements."""

import numpy as np
from numpy.polynomial.legendre import legvander2d
from skfem import MeshQuad
from skfem.quadrature import get_quadrature

from ..meshes.half_space import derivative_mapping
from ..meshes.radial import Array, Indices
from .elasticity import AxisymmetricElasticity
from .half_space import HalfSpace
from .weak_form import tables


def stresses_in(
    solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array
) -> tuple[Array, Array]:
    """Return the displacements and stresses at reference points of elements of one degree.

    Near incompressibility lambda amplifies the error of the dilatation. The part of the dilatation
    in the polynomials of total degree p - 1 is accurate, because these are stable with
    displacements of degree p. The dilatation is therefore projected on these polynomials in each
    element, by volume.

    Parameters
    ----------
    solid : elastic solid
    displacement : (states, functions, 2) coefficients
    elements : (m,) numbers of elements, all of one degree p
    points : (2, q) points in the reference element

    Returns
    -------
    displacement : (states, m, q, 2) radial and axial
    stress : (states, m, q, 4) rr, zz, rz, hoop
    """
    degree = int(solid.degrees[elements[0]])
    rule, weights = get_quadrature(solid.element, 2 * degree + 1)
    mapping = solid.mesh.mapping()
    areas = np.abs(derivative_mapping(solid.mesh).detDF(rule, elements))
    volume = weights * areas * mapping.F(rule, elements)[0]
    _, (rr, zz, _, hoop) = _strains(solid, displacement, elements, rule)
    at_rule, at_points = _polynomials(degree - 1, rule), _polynomials(degree - 1, points)
    count = len(at_rule)
    products = (at_rule[:, None] * at_rule).reshape(count**2, -1)
    masses = (volume @ products.T).reshape(-1, count, count)
    moments = (volume * (rr + zz + hoop)) @ at_rule.T
    dilatation = np.linalg.solve(masses, moments[..., None])[..., 0] @ at_points
    point_displacement, (rr, zz, rz, hoop) = _strains(solid, displacement, elements, points)
    lame, shear = (constant[elements][:, None] for constant in solid.materials)
    # the difference between the projected dilatation and the trace of the strains is distributed
    # equally over the three normal strains
    correction = (dilatation - rr - zz - hoop) / 3
    rr, zz, hoop = (
        lame * dilatation + 2 * shear * (strain + correction) for strain in (rr, zz, hoop)
    )
    return point_displacement, np.stack([rr, zz, 2 * shear * rz, hoop], axis=-1)


def _polynomials(degree: int, points: Array) -> Array:
    """Return the values (k, q) of all polynomials up to a total degree, at reference points."""
    total_degrees = np.add.outer(np.arange(degree + 1), np.arange(degree + 1)).ravel()
    first, second = 2 * points - 1
    return legvander2d(first, second, [degree, degree]).T[total_degrees <= degree]


def _strains(
    solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array
) -> tuple[Array, Array]:
    """Return the displacements and strains at reference points of elements.

    The displacements have the shape (states, m, q, 2), the strains rr, zz, rz, hoop the shape (4,
    states, m, q).
    """
    value, gradient = tables(solid.element, np.arange(len(solid.element.doflocs)), points)
    mapping = solid.mesh.mapping()
    r, inverse = (
        mapping.F(points, elements)[0],
        derivative_mapping(solid.mesh).invDF(points, elements),
    )
    # order of the axes: field (radial, axial), states, m, functions
    coefficients = np.moveaxis(displacement[:, solid.dofs.element_dofs[:, elements].T], -1, 0)
    point_displacement = coefficients @ value
    first, second = coefficients @ gradient[:, 0], coefficients @ gradient[:, 1]
    (rr, zr), (rz, zz) = (first * inverse[0, axis] + second * inverse[1, axis] for axis in (0, 1))
    on_axis = r <= 1e-12 * r.max(axis=1, keepdims=True)
    hoop = np.where(on_axis, rr, point_displacement[0] / np.where(on_axis, 1.0, r))
    return np.moveaxis(point_displacement, 0, -1), np.stack([rr, zz, (rz + zr) / 2, hoop])


def sample_fields(
    half_space: HalfSpace, pressures: Array, refinements: int
) -> tuple[Array, Indices, Array, Array]:
    """Return the displacements and stresses of all elements under given contact pressures.

    Fields are not averaged between elements. The points and triangles depend on the mesh only, so
    that the fields of two degrees can be compared point by point. Fields of a solid that is too
    nearly incompressible to be modelled are extrapolated (`incompressibility.py`).

    Parameters
    ----------
    half_space : the half-space
    pressures : (states, size) coefficients on the pressure space
    refinements : number of times that each element is refined to make the small triangles

    Returns
    -------
    points : (2, P) radius and depth; a point on a facet occurs once for each of its elements
    triangles : (3, T) small triangles between the points
    displacement : (states, P, 2) radial, and axial (positive into the half-space)
    stress : (states, P, 4) rr, zz, rz, hoop; singular at the rim and at ring edges
    """
    solid = half_space.solid
    reference = type(solid.mesh).init_refdom().refined(refinements)
    small = (reference.to_meshtri() if isinstance(reference, MeshQuad) else reference).t
    starts = reference.nvertices * np.arange(solid.mesh.nelements)
    triangles = (small[:, None] + starts[:, None]).reshape(3, -1)
    points = solid.mesh.mapping().F(reference.p).reshape(2, -1)
    displacement, stress = _fields_of_model(half_space, pressures, reference.p)
    if second := half_space.more_compressible:
        second_displacement, second_stress = _fields_of_model(second, pressures, reference.p)
        displacement = 2 * displacement - second_displacement
        stress = 2 * stress - second_stress
    return points, triangles, displacement, stress


def _fields_of_model(half_space: HalfSpace, pressures: Array, points: Array) -> tuple[Array, Array]:
    """Return displacements (states, P, 2) and stresses (states, P, 4) with modelled ratios.

    `points` (2, q) are points in the reference element; P is q times the number of elements.
    """
    solid, coefficients = half_space.solid, half_space.displacements(pressures)
    shape = len(coefficients), solid.mesh.nelements, points.shape[1]
    displacement, stress = np.empty((*shape, 2)), np.empty((*shape, 4))
    for batch in solid.batches:
        displacement[:, batch.elements], stress[:, batch.elements] = stresses_in(
            solid, coefficients, batch.elements, points
        )
    return displacement.reshape(shape[0], -1, 2), stress.reshape(shape[0], -1, 4)


def von_mises(stress: Array) -> Array:
    """Return the von Mises stresses (...) of stresses (..., 4)."""
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    return np.sqrt(((rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2) / 2 + 3 * rz**2)
