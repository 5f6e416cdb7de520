"""A residual error indicator for a half-space of triangles, and the choice of those to refine.

A displacement u_h that is computed under a given contact pressure p leaves a residual
``div sigma(u_h)`` inside each triangle T, jumps of the traction ``sigma(u_h) n`` across its sides,
and a difference between the traction and the pressure on the surface. With the degree k of the
elements, the longest side h_T of the triangle and the length h_F of each of its sides F,

    eta_T^2 = h_T^2 / (2 mu k^2) int_T |div sigma|^2 dV
              + sum_F h_F / (2 mu k) (1/2 int_F |jump of sigma n|^2 dA     F inside the half-space
                                      or int_F |sigma n - p e_z|^2 dA)     F on the surface

(p is 0 beside the contact). Up to a factor that depends only on the shapes of the triangles, the
sum of eta_T^2 is an upper and a lower bound of the energy of the error u - u_h. The square root of
the ratio of the sum to the energy is the effectivity [1]. The scaling with k is that of hp elements
[2]. The indicator does not include the error of the far field, which has its own estimate
(`far_field.enough_poles`). Near incompressibility lambda multiplies the error of the dilatation,
and the indicator overestimates the error.

The fewest triangles that together hold a fixed share of that sum are refined. The error then falls
at the best order of triangles of degree k, for all singularities [3].

[1] Verfürth: A Review of A Posteriori Error Estimation and Adaptive Mesh-Refinement Techniques,
Wiley-Teubner, 1996, section 1.2.
[2] Melenk, Wohlmuth: On residual-based a posteriori error estimation in hp-FEM, Adv. Comput. Math.
15 (2001), doi 10.1023/A:1014268310921.
[3] Dörfler: A convergent adaptive algorithm for Poisson's equation, SIAM J. Numer. Anal. 33 (1996),
doi 10.1137/0733054.
"""

from typing import NamedTuple

import numpy as np
from skfem import CellBasis, ElementDG, FacetBasis, InteriorFacetBasis, MeshTri
from skfem.assembly.basis import AbstractBasis

from ..meshes.errors import MeshError
from ..meshes.half_space import contact_facets, facet_ends
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, Indices
from .elasticity import AxisymmetricElasticity
from .weak_form import element_of_degree, moduli


def squared_indicators(
    solid: AxisymmetricElasticity, displacements: Array, space: PressureSpace, pressures: Array
) -> Array:
    """Return the squares of the error indicators (states, m) of all triangles.

    Their sum over the triangles is comparable to the energy of the error of each state, in units of
    (force x indentation).

    Parameters
    ----------
    solid : elastic solid on a mesh of triangles
    displacements : (states, functions, 2) coefficients as returned by `HalfSpace.displacements`
    space : pressure space on the contact facets of the solid
    pressures : (states, size) coefficients on that space

    Raises
    ------
    MeshError
        if the solid has quadrilaterals, for which scikit-fem has no second derivatives
    """
    mesh, degree = solid.mesh, solid.degree
    if not isinstance(mesh, MeshTri):
        raise MeshError("the error indicator is for triangles only: give a mesh of triangles")
    twice_shear = 2 * moduli(solid.poisson_ratio)[1]
    ends = mesh.p[:, mesh.facets]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0)
    longest = lengths[mesh.t2f].max(axis=0)
    residual_terms = (
        longest**2 / (twice_shear * degree**2) * _squared_residuals(solid, displacements)
    )
    facet_terms = _squared_mismatches(solid, displacements, space, pressures)
    facet_terms *= lengths / (twice_shear * degree)
    return residual_terms + facet_terms[:, mesh.t2f].sum(axis=1)


def fewest_with_share(indicators: Array, share: float) -> Indices:
    """Return the fewest elements that together hold a share of the sum of all indicators (Dörfler).

    Parameters
    ----------
    indicators : (m,) squared indicators, not negative
    share : share of the sum, between 0 and 1
    """
    order = np.argsort(-indicators, kind="stable")
    sums = np.cumsum(indicators[order])
    return order[: np.searchsorted(sums, share * sums[-1]) + 1]


class _DisplacementFields(NamedTuple):
    """Displacements and their gradients at the points of a scikit-fem basis.

    Parameters
    ----------
    radii : (m, q) radii of the q points on each of m elements or facets
    radial : (states, m, q) radial displacements
    radial_gradient : (2, states, m, q) derivatives of the radial displacement by radius and depth
    axial_gradient : (2, states, m, q) derivatives of the axial displacement by radius and depth
    """

    radii: Array
    radial: Array
    radial_gradient: Array
    axial_gradient: Array

    @classmethod
    def at_points(cls, basis: AbstractBasis, displacements: Array) -> "_DisplacementFields":
        """Return the fields of displacements (states, functions, 2) at the points of a basis."""
        radial, axial = np.moveaxis(displacements, -1, 0)
        values, radial_gradient = _combine(basis, radial)
        _, axial_gradient = _combine(basis, axial)
        return cls(
            np.asarray(basis.global_coordinates())[0], values, radial_gradient, axial_gradient
        )

    def tractions(self, normals: Array, poisson_ratio: float) -> Array:
        """Return radial and axial tractions (2, states, m, q) on facets with normals (2, m, q)."""
        lame, shear = moduli(poisson_ratio)
        (rr, rz), (zr, zz) = self.radial_gradient, self.axial_gradient
        dilatation_part = lame * (rr + self.radial / self.radii + zz)
        shear_stress = shear * (rz + zr)
        return np.stack(
            [
                (dilatation_part + 2 * shear * rr) * normals[0] + shear_stress * normals[1],
                shear_stress * normals[0] + (dilatation_part + 2 * shear * zz) * normals[1],
            ]
        )


def _combine(basis: AbstractBasis, coefficients: Array) -> tuple[Array, Array]:
    """Return values (states, m, q) and gradients (2, states, m, q) of fields at a basis' points.

    `coefficients` is (states, functions). scikit-fem's `interpolate` gives the same numbers, but
    processes one state at a time and determines the parts of composite elements each time.
    """
    local = coefficients[:, basis.element_dofs].transpose(2, 0, 1)
    fields = [function[0] for function in basis.basis]
    values = np.stack([np.asarray(field) for field in fields], axis=1)
    gradients = np.stack([field.grad for field in fields], axis=2)
    return (local @ values).swapaxes(0, 1), (local @ gradients).swapaxes(1, 2)


def _squared_residuals(solid: AxisymmetricElasticity, displacements: Array) -> Array:
    """Return ``int |div sigma|^2 dV`` (states, m) over each triangle.

    The gradient of a polynomial of degree k has degree k - 1. scikit-fem's discontinuous element of
    that degree represents it exactly: the values of the gradient at the nodes are the coefficients,
    and the gradient of the element's functions gives the second derivatives.
    """
    lame, shear = moduli(solid.poisson_ratio)
    lower = ElementDG(element_of_degree(solid.mesh, solid.degree - 1))
    nodes = np.ascontiguousarray(lower.doflocs.T)
    at_nodes = CellBasis(
        solid.mesh, solid.element, quadrature=(nodes, np.ones(nodes.shape[1])), dofs=solid.dofs
    )
    cells = CellBasis(solid.mesh, solid.element, intorder=2 * solid.degree, dofs=solid.dofs)
    gradient_basis = CellBasis(solid.mesh, lower, quadrature=cells.quadrature)

    def differentiate(gradients: Array) -> tuple[Array, Array, Array]:
        """Return derivatives rr, rz and zz (states, m, q) of gradients (2, states, m, nodes)."""
        second = []
        for component in gradients:
            coefficients = np.empty((len(component), gradient_basis.N))
            coefficients[:, gradient_basis.element_dofs] = component.swapaxes(1, 2)
            second.append(_combine(gradient_basis, coefficients)[1])
        (rr, rz), (_, zz) = second
        return rr, rz, zz

    nodal = _DisplacementFields.at_points(at_nodes, displacements)
    r_rr, r_rz, r_zz = differentiate(nodal.radial_gradient)
    z_rr, z_rz, z_zz = differentiate(nodal.axial_gradient)
    r, radial, (rr, rz), (zr, _) = _DisplacementFields.at_points(cells, displacements)
    # derivative of u_r / r by the radius
    hoop_r = (rr - radial / r) / r
    along_r = (lame + 2 * shear) * (r_rr + hoop_r) + lame * z_rz + shear * (r_zz + z_rz)
    along_z = lame * (r_rz + rz / r + z_zz) + 2 * shear * z_zz
    along_z += shear * (r_rz + z_rr + (rz + zr) / r)
    volumes = 2 * np.pi * r * cells.dx
    return np.sum((along_r**2 + along_z**2) * volumes, axis=-1)


def _squared_mismatches(
    solid: AxisymmetricElasticity, displacements: Array, space: PressureSpace, pressures: Array
) -> Array:
    """Return the squared mismatch of tractions (states, facets), integrated over each facet.

    Inside the half-space it is half of the squared jump, for each of the two triangles. On the
    surface it is the squared difference from the pressure. It is zero on the axis, which has no
    area, and on the outer boundary.
    """
    mesh, ratio = solid.mesh, solid.poisson_ratio
    settings = {"intorder": 2 * solid.degree, "dofs": solid.dofs}
    first, second = (
        InteriorFacetBasis(mesh, solid.element, side=side, **settings) for side in (0, 1)
    )
    on_free_surface = FacetBasis(mesh, solid.element, facets=mesh.boundaries["free"], **settings)
    on_contact = FacetBasis(mesh, solid.element, facets=contact_facets(mesh), **settings)

    def tractions(basis: FacetBasis, normals: Array) -> Array:
        return _DisplacementFields.at_points(basis, displacements).tractions(normals, ratio)

    # both sides use the normals of the first side
    jumps = tractions(first, np.asarray(first.normals)) - tractions(
        second, np.asarray(first.normals)
    )
    contact_tractions = tractions(on_contact, np.asarray(on_contact.normals))
    contact_tractions[1] -= _given_pressures(on_contact, space, pressures)
    out = np.zeros((len(displacements), mesh.nfacets))
    out[:, first.find] = _integrals(first, jumps) / 2
    out[:, on_free_surface.find] = _integrals(
        on_free_surface, tractions(on_free_surface, np.asarray(on_free_surface.normals))
    )
    out[:, on_contact.find] = _integrals(on_contact, contact_tractions)
    return out


def _given_pressures(on_contact: FacetBasis, space: PressureSpace, pressures: Array) -> Array:
    """Return the given pressures (states, facets, q) at the points of the contact facets."""
    mesh, facets = on_contact.mesh, on_contact.find
    local = 2 * on_contact.X[0] - 1
    from_axis, towards_axis = (
        (space.on_elements(coordinates) @ pressures.T).T.reshape(len(pressures), len(facets), -1)
        for coordinates in (local, -local)
    )
    # the local coordinate of a facet starts at its first vertex, which may be the one farther from
    # the axis
    begins_outside = mesh.facets[0, facets] != facet_ends(mesh, facets)[0]
    return np.where(begins_outside[:, None], towards_axis, from_axis)


def _integrals(basis: FacetBasis, tractions: Array) -> Array:
    """Return ``int |t|^2 dA`` (states, facets) for tractions (2, states, facets, q)."""
    areas = 2 * np.pi * np.asarray(basis.global_coordinates())[0] * basis.dx
    return np.sum((tractions**2).sum(axis=0) * areas, axis=-1)
