"""Stresses inside the half-space, recovered from contact pressures in scikit-fem's elements."""

import numpy as np
from numpy.polynomial.legendre import legvander2d
from skfem import MeshQuad
from skfem.quadrature import get_quadrature

from ..meshes.half_space import derivatives
from ..meshes.radial import Array, Indices
from .elasticity import AxisymmetricElasticity
from .half_space import HalfSpace
from .weak_form import tables


def stresses(
    solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array
) -> tuple[Array, Array]:
    """Return the displacements and stresses at reference points of elements.

    The displacements have the shape (states, m, q, 2), the stresses rr, zz, rz, hoop the shape
    (states, m, q, 4).

    The elements must be of one degree p. Near incompressibility lambda makes noise of the
    dilatation but for its part in the polynomials of total degree p - 1, which with displacements
    of degree p are stable: the dilatation is projected on them in each element, by volume.
    """
    degree = int(solid.degrees[elements[0]])
    rule, weights = get_quadrature(solid.element, 2 * degree + 1)
    mapping = solid.mesh.mapping()
    areas = np.abs(derivatives(solid.mesh).detDF(rule, elements))
    volume = weights * areas * mapping.F(rule, elements)[0]
    _, (rr, zz, _, hoop) = _strains(solid, displacement, elements, rule)
    at_rule, at_points = _polynomials(degree - 1, rule), _polynomials(degree - 1, points)
    count = len(at_rule)
    products = (at_rule[:, None] * at_rule).reshape(count**2, -1)
    masses = (volume @ products.T).reshape(-1, count, count)
    moments = (volume * (rr + zz + hoop)) @ at_rule.T
    dilatation = np.linalg.solve(masses, moments[..., None])[..., 0] @ at_points
    moved, (rr, zz, rz, hoop) = _strains(solid, displacement, elements, points)
    lame, shear = (constant[elements][:, None] for constant in solid.materials)
    # strains that do not add up to that dilatation share what is missing
    missing = (dilatation - rr - zz - hoop) / 3
    rr, zz, hoop = (lame * dilatation + 2 * shear * (strain + missing) for strain in (rr, zz, hoop))
    return moved, np.stack([rr, zz, 2 * shear * rz, hoop], axis=-1)


def _polynomials(degree: int, points: Array) -> Array:
    """Return the values (k, q) of the polynomials of a total degree at reference points."""
    total = np.add.outer(np.arange(degree + 1), np.arange(degree + 1)).ravel()
    first, second = 2 * points - 1
    return legvander2d(first, second, [degree, degree]).T[total <= degree]


def _strains(
    solid: AxisymmetricElasticity, displacement: Array, elements: Indices, points: Array
) -> tuple[Array, Array]:
    """Return the displacements and strains at reference points of elements.

    The displacements have the shape (states, m, q, 2), the strains rr, zz, rz, hoop the shape (4,
    states, m, q).
    """
    value, gradient = tables(solid.element, points)
    mapping = solid.mesh.mapping()
    r, inverse = mapping.F(points, elements)[0], derivatives(solid.mesh).invDF(points, elements)
    # by field: radial, axial (2, states, m, functions)
    coefficients = np.moveaxis(displacement[:, solid.dofs.element_dofs[:, elements].T], -1, 0)
    moved = coefficients @ value
    first, second = coefficients @ gradient[:, 0], coefficients @ gradient[:, 1]
    (rr, zr), (rz, zz) = (first * inverse[0, axis] + second * inverse[1, axis] for axis in (0, 1))
    on_axis = r <= 1e-12 * r.max(axis=1, keepdims=True)
    hoop = np.where(on_axis, rr, moved[0] / np.where(on_axis, 1.0, r))
    return np.moveaxis(moved, 0, -1), np.stack([rr, zz, (rz + zr) / 2, hoop])


def sampled(
    half_space: HalfSpace, pressures: Array, refinements: int
) -> tuple[Array, Indices, Array, Array]:
    """Return the displacements and stresses of all elements under given contact pressures.

    `pressures` (states, size) are coefficients on the pressure space. The fields are not averaged
    between elements.

    Points and triangles depend on the mesh only, so that the fields of two degrees can be compared
    point by point.

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
    coefficients = half_space.displacements(pressures)
    reference = type(solid.mesh).init_refdom().refined(refinements)
    small = (reference.to_meshtri() if isinstance(reference, MeshQuad) else reference).t
    starts = reference.nvertices * np.arange(solid.mesh.nelements)
    triangles = (small[:, None] + starts[:, None]).reshape(3, -1)
    states, elements, each = len(coefficients), solid.mesh.nelements, reference.nvertices
    points = solid.mesh.mapping().F(reference.p).reshape(2, -1)
    moved, stress = np.empty((states, elements, each, 2)), np.empty((states, elements, each, 4))
    for batch in solid.batches:
        moved[:, batch.elements], stress[:, batch.elements] = stresses(
            solid, coefficients, batch.elements, reference.p
        )
    return points, triangles, moved.reshape(states, -1, 2), stress.reshape(states, -1, 4)


def von_mises(stress: Array) -> Array:
    """Return the von Mises stress (...) of (..., 4) stresses."""
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    return np.sqrt(((rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2) / 2 + 3 * rz**2)
