"""A residual error indicator for the half-space in triangles, and which triangles to refine by it.

A displacement u_h that is computed under a given contact pressure p leaves a residual ``div
sigma(u_h)`` inside each triangle T, jumps of the traction ``sigma(u_h) n`` across its sides, and a
difference between the traction and the pressure on the surface. With the degree k of the elements,
the longest side h_T of the triangle and the length h_F of each of its sides F,

    eta_T^2 = h_T^2 / (2 mu k^2) int_T |div sigma|^2 dV
              + sum_F h_F / (2 mu k) (1/2 int_F |jump of sigma n|^2 dA     F inside the half-space
                                      or int_F |sigma n - p e_z|^2 dA)     F on the surface

(p is 0 beside the contact). Up to a factor that depends on the shapes of the triangles alone, the
sum of eta_T^2 bounds the energy of the error u - u_h from both sides; the ratio of the two is the
effectivity [1]. The scaling with k is that of hp elements [2]. What the far field errs by is not
part of it: the truncation has an estimate of its own (`far_field.enough_poles`). Towards
incompressibility lambda multiplies what the dilatation errs by, and the indicator overestimates.

Triangles that hold a fixed share of that sum are refined, as few as possible, and so the error
falls at the best order that triangles of degree k have, whatever the singularities [3].

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
    solid : of triangles
    displacements : (states, functions, 2) as `HalfSpace.displacements` returns them
    space : pressure space on the contact facets of the solid
    pressures : (states, size) coefficients on that space

    Raises
    ------
    MeshError
        if the solid has quadrilaterals, whose second derivatives scikit-fem does not give
    """
    mesh, degree = solid.mesh, solid.degree
    if not isinstance(mesh, MeshTri):
        raise MeshError("the error indicator is one of triangles: give a mesh of triangles")
    twice_shear = 2 * moduli(solid.poisson_ratio)[1]
    ends = mesh.p[:, mesh.facets]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0)
    longest = lengths[mesh.t2f].max(axis=0)
    inside = longest**2 / (twice_shear * degree**2) * _squared_residuals(solid, displacements)
    on_facets = _squared_mismatches(solid, displacements, space, pressures)
    on_facets *= lengths / (twice_shear * degree)
    return np.asarray(inside + on_facets[:, mesh.t2f].sum(axis=1))


def fewest_with_share(indicators: Array, share: float) -> Indices:
    """Return the fewest elements that hold a share of the sum of their indicators (Dörfler).

    Parameters
    ----------
    indicators : (m,) not negative, squares of what is summed
    share : between 0 and 1
    """
    order = np.argsort(-indicators, kind="stable")
    sums = np.cumsum(indicators[order])
    return np.asarray(order[: np.searchsorted(sums, share * sums[-1]) + 1])


class _Moved(NamedTuple):
    """Displacements and their gradients at the points of a scikit-fem basis.

    Parameters
    ----------
    radii : (m, q) of the q points of each of m elements or facets
    radial : (states, m, q) radial displacements
    of_radial, of_axial : (2, states, m, q) gradients of the radial and axial displacement, by
        radius and depth
    """

    radii: Array
    radial: Array
    of_radial: Array
    of_axial: Array

    @classmethod
    def at_points(cls, basis: AbstractBasis, displacements: Array) -> "_Moved":
        """Return them for displacements (states, functions, 2)."""
        radial, axial = np.moveaxis(displacements, -1, 0)
        values, of_radial = _combine(basis, radial)
        _, of_axial = _combine(basis, axial)
        return cls(np.asarray(basis.global_coordinates())[0], values, of_radial, of_axial)

    def tractions(self, normals: Array, poisson_ratio: float) -> Array:
        """Return radial and axial tractions (2, states, m, q) on facets of normals (2, m, q)."""
        lame, shear = moduli(poisson_ratio)
        (rr, rz), (zr, zz) = self.of_radial, self.of_axial
        pressure_part = lame * (rr + self.radial / self.radii + zz)
        shear_stress = shear * (rz + zr)
        return np.stack(
            [
                (pressure_part + 2 * shear * rr) * normals[0] + shear_stress * normals[1],
                shear_stress * normals[0] + (pressure_part + 2 * shear * zz) * normals[1],
            ]
        )


def _combine(basis: AbstractBasis, coefficients: Array) -> tuple[Array, Array]:
    """Return values (states, m, q) and gradients (2, states, m, q) of fields at a basis' points.

    `coefficients` is (states, functions). The same as scikit-fem's `interpolate`, which takes one
    state at a time and looks for the parts of composite elements each time.
    """
    local = coefficients[:, basis.element_dofs].transpose(2, 0, 1)
    fields = [function[0] for function in basis.basis]
    values = np.stack([np.asarray(field) for field in fields], axis=1)
    gradients = np.stack([field.grad for field in fields], axis=2)
    return (local @ values).swapaxes(0, 1), (local @ gradients).swapaxes(1, 2)


def _squared_residuals(solid: AxisymmetricElasticity, displacements: Array) -> Array:
    """Return ``int |div sigma|^2 dV`` (states, m) over each triangle.

    The gradient of a polynomial of degree k is one of degree k - 1, which scikit-fem's
    discontinuous element of that degree holds exactly: its values at the nodes are the
    coefficients, and its gradient has the second derivatives.
    """
    lame, shear = moduli(solid.poisson_ratio)
    lower = ElementDG(element_of_degree(solid.mesh, solid.degree - 1))
    nodes = np.ascontiguousarray(lower.doflocs.T)
    at_nodes = CellBasis(
        solid.mesh, solid.element, quadrature=(nodes, np.ones(nodes.shape[1])), dofs=solid.dofs
    )
    cells = CellBasis(solid.mesh, solid.element, intorder=2 * solid.degree, dofs=solid.dofs)
    of_gradients = CellBasis(solid.mesh, lower, quadrature=cells.quadrature)

    def differentiate(gradients: Array) -> tuple[Array, Array, Array]:
        """Return derivatives rr, rz and zz (states, m, q) by gradients (2, states, m, nodes)."""
        second = []
        for component in gradients:
            coefficients = np.empty((len(component), of_gradients.N))
            coefficients[:, of_gradients.element_dofs] = component.swapaxes(1, 2)
            second.append(_combine(of_gradients, coefficients)[1])
        (rr, rz), (_, zz) = second
        return rr, rz, zz

    nodal = _Moved.at_points(at_nodes, displacements)
    r_rr, r_rz, r_zz = differentiate(nodal.of_radial)
    z_rr, z_rz, z_zz = differentiate(nodal.of_axial)
    r, radial, (rr, rz), (zr, _) = _Moved.at_points(cells, displacements)
    # the derivative of u_r / r by the radius
    hoop_r = (rr - radial / r) / r
    along_r = (lame + 2 * shear) * (r_rr + hoop_r) + lame * z_rz + shear * (r_zz + z_rz)
    along_z = lame * (r_rz + rz / r + z_zz) + 2 * shear * z_zz
    along_z += shear * (r_rz + z_rr + (rz + zr) / r)
    volumes = 2 * np.pi * r * cells.dx
    return np.asarray(np.sum((along_r**2 + along_z**2) * volumes, axis=-1))


def _squared_mismatches(
    solid: AxisymmetricElasticity, displacements: Array, space: PressureSpace, pressures: Array
) -> Array:
    """Return the squared mismatch of tractions (states, facets), integrated over each facet.

    It is half of the squared jump inside, for each of both triangles, and the whole squared
    difference from the pressure on the surface. There is none on the axis, which has no area, nor
    on the outer boundary.
    """
    mesh, ratio = solid.mesh, solid.poisson_ratio
    settings = {"intorder": 2 * solid.degree, "dofs": solid.dofs}
    first, second = (
        InteriorFacetBasis(mesh, solid.element, side=side, **settings) for side in (0, 1)
    )
    of_free_surface = FacetBasis(mesh, solid.element, facets=mesh.boundaries["free"], **settings)
    on_contact = FacetBasis(mesh, solid.element, facets=contact_facets(mesh), **settings)

    def tractions(basis: FacetBasis, normals: Array) -> Array:
        return _Moved.at_points(basis, displacements).tractions(normals, ratio)

    # the normals of both sides are those of the first
    jumps = tractions(first, np.asarray(first.normals)) - tractions(
        second, np.asarray(first.normals)
    )
    of_contact = tractions(on_contact, np.asarray(on_contact.normals))
    of_contact[1] -= _given_pressures(on_contact, space, pressures)
    out = np.zeros((len(displacements), mesh.nfacets))
    out[:, first.find] = _integrals(first, jumps) / 2
    out[:, of_free_surface.find] = _integrals(
        of_free_surface, tractions(of_free_surface, np.asarray(of_free_surface.normals))
    )
    out[:, on_contact.find] = _integrals(on_contact, of_contact)
    return out


def _given_pressures(on_contact: FacetBasis, space: PressureSpace, pressures: Array) -> Array:
    """Return pressures (states, facets, q) at the points of the contact facets."""
    mesh, facets = on_contact.mesh, on_contact.find
    local = 2 * on_contact.X[0] - 1
    outwards, inwards = (
        (space.on_elements(along) @ pressures.T).T.reshape(len(pressures), len(facets), -1)
        for along in (local, -local)
    )
    # the coordinate on a facet begins at its first vertex, which may be the farther one
    begins_outside = mesh.facets[0, facets] != facet_ends(mesh, facets)[0]
    return np.where(begins_outside[:, None], inwards, outwards)


def _integrals(basis: FacetBasis, tractions: Array) -> Array:
    """Return ``int |t|^2 dA`` (states, facets) of tractions (2, states, facets, q)."""
    areas = 2 * np.pi * np.asarray(basis.global_coordinates())[0] * basis.dx
    return np.asarray(np.sum((tractions**2).sum(axis=0) * areas, axis=-1))
