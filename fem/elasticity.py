"""Axisymmetric linear elasticity on triangles, assembled block by block from scikit-fem's reference elements.

Energy ``int sigma : eps dV`` with ``dV = 2 pi r dr dz``: stiffness, forces and areas all carry the full 2 pi. Strains
are ``eps_rr = du_r/dr``, ``eps_zz = du_z/dz``, ``eps_hoop = u_r/r``, ``2 eps_rz = du_r/dz + du_z/dr``; z is the depth.
Triangles are straight, so every integral but the hoop one is a reference tensor times element constants, and the
whole matrix costs a few dense products.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix
from skfem import Element, ElementTriP1, ElementTriP2, ElementTriP3, ElementTriP4, MeshTri
from skfem.assembly import Dofs
from skfem.quadrature import get_quadrature

from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array, Indices

ELEMENTS = {1: ElementTriP1, 2: ElementTriP2, 3: ElementTriP3, 4: ElementTriP4}


def moduli(poisson_ratio: float) -> tuple[float, float]:
    """Lame's lambda and shear modulus for plane strain modulus 1."""
    shear = (1 - poisson_ratio) / 2
    return 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio), shear


@dataclass(frozen=True, eq=False)
class AxisymmetricElasticity:
    """The elastic solid on a mesh; unknowns are all radial, then all axial nodal displacements.

    Parameters
    ----------
    mesh : the half-space mesh
    degree : polynomial degree of the displacement, 1 to 4
    poisson_ratio : below 1/2
    """

    mesh: HalfSpaceMesh
    degree: int
    poisson_ratio: float

    @cached_property
    def element(self) -> Element:
        return ELEMENTS[self.degree]()

    @cached_property
    def _triangulation(self) -> MeshTri:
        return MeshTri(np.ascontiguousarray(self.mesh.points.T), np.ascontiguousarray(self.mesh.triangles.T))

    @cached_property
    def _dofs(self) -> Dofs:
        return Dofs(self._triangulation, self.element)

    @property
    def nodes(self) -> int:
        """Number of nodes; there are twice as many unknowns."""
        return int(self._dofs.N)

    @property
    def element_dofs(self) -> Indices:
        """(nodes per triangle, m) node numbers."""
        return self._dofs.element_dofs

    @cached_property
    def corners(self) -> Array:
        """(2, 3, m) radius and depth of the triangles' corners, in the order of the reference element."""
        return self._triangulation.p[:, self._triangulation.t]

    @property
    def vertices(self) -> Indices:
        """(3, m) vertex numbers of the triangles' corners, in the order of the reference element."""
        return self._triangulation.t

    @cached_property
    def positions(self) -> Array:
        """(nodes, 2) radius and depth of the nodes."""
        xi, eta = self.element.doflocs.T
        local = np.stack([1 - xi - eta, xi, eta])
        out = np.empty((self.nodes, 2))
        out[self.element_dofs] = np.einsum("xvm,vn->nmx", self.corners, local)
        out[np.unique(self._boundary_nodes("axis")), 0] = 0.0
        return out

    def boundary(self, name: str) -> Indices:
        """Node numbers on a named boundary, in the order of the radius."""
        nodes = self._boundary_nodes(name)
        return nodes[np.argsort(self.positions[nodes, 0], kind="stable")]

    def _boundary_nodes(self, name: str) -> Indices:
        wanted = self.mesh.boundaries[name]
        facets = self._triangulation.facets
        count = len(self.mesh.points)
        found = np.isin(facets.min(axis=0) * count + facets.max(axis=0), wanted.min(axis=1) * count + wanted.max(axis=1))
        return np.unique(np.concatenate([wanted.ravel(), self._dofs.facet_dofs[:, found].ravel()]))

    @cached_property
    def inverse_jacobian(self) -> tuple[Array, Array]:
        """(2, 2, m) derivative of reference by physical coordinates, and (m,) area factor of each triangle."""
        p = self.corners
        a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        determinant = a[0] * b[1] - b[0] * a[1]
        return np.array([[b[1], -b[0]], [-a[1], a[0]]]) / determinant, np.abs(determinant)

    def reference(self, points: Array) -> tuple[Array, Array]:
        """Values (nodes, q) and reference gradients (nodes, 2, q) of the shape functions."""
        pairs = [self.element.lbasis(points, i) for i in range(len(self.element.doflocs))]
        return np.array([value for value, _ in pairs]), np.array([gradient for _, gradient in pairs])

    @cached_property
    def stiffness(self) -> csc_matrix:
        """(2 nodes, 2 nodes) symmetric stiffness, no boundary condition applied."""
        lame, shear = moduli(self.poisson_ratio)
        with_radius, plain, hoop = self._weighted_gradients(), self._hoop_gradients(), self._hoop_mass()
        rr, zz, rz = with_radius(0, 0), with_radius(1, 1), with_radius(0, 1)
        hr, hz = plain(0), plain(1)
        radial = (lame + 2 * shear) * (rr + hoop) + shear * zz + lame * (hr + hr.transpose(0, 2, 1))
        axial = (lame + 2 * shear) * zz + shear * rr
        mixed = lame * (rz + hz) + shear * rz.transpose(0, 2, 1)
        local = np.concatenate(
            [np.concatenate([radial, mixed], axis=2), np.concatenate([mixed.transpose(0, 2, 1), axial], axis=2)], axis=1
        )
        numbers = np.concatenate([self.element_dofs, self.element_dofs + self.nodes]).T
        width = numbers.shape[1]
        rows, columns = np.repeat(numbers, width, axis=1), np.tile(numbers, (1, width))
        size = 2 * self.nodes
        return csc_matrix((local.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))

    def _weighted_gradients(self) -> Callable[[int, int], Array]:
        """``(x, y) -> int r d_x phi_i d_y phi_j`` on every triangle."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree - 1)
        _, gradient = self.reference(points)
        corner = np.stack([1 - points[0] - points[1], points[0], points[1]])
        tensor = np.einsum("vq,q,iaq,jbq->vabij", corner, weights, gradient, gradient, optimize=True)
        inverse, area = self.inverse_jacobian
        n = tensor.shape[-1]

        def block(x: int, y: int) -> Array:
            constants = np.einsum("vm,am,bm->mvab", self.corners[0] * area * 2 * np.pi, inverse[:, x], inverse[:, y])
            return (constants.reshape(-1, 12) @ tensor.reshape(12, -1)).reshape(-1, n, n)

        return block

    def _hoop_gradients(self) -> Callable[[int], Array]:
        """``y -> int phi_i d_y phi_j`` on every triangle: the radius has cancelled."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree - 1)
        value, gradient = self.reference(points)
        tensor = np.einsum("q,iq,jaq->aij", weights, value, gradient, optimize=True)
        inverse, area = self.inverse_jacobian
        n = tensor.shape[-1]

        def block(y: int) -> Array:
            return ((inverse[:, y] * area * 2 * np.pi).T @ tensor.reshape(2, -1)).reshape(-1, n, n)

        return block

    def _hoop_mass(self) -> Array:
        """``int phi_i phi_j / r`` on every triangle: rational, so by a richer rule; its points lie off the axis."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree + 4)
        value, _ = self.reference(points)
        corner = np.stack([1 - points[0] - points[1], points[0], points[1]])
        _, area = self.inverse_jacobian
        inverse_radius = 1 / np.einsum("vm,vq->mq", self.corners[0], corner)
        products = np.einsum("iq,jq->qij", value, value)
        n = len(value)
        scaled = (2 * np.pi * area)[:, None] * weights * inverse_radius
        return (scaled @ products.reshape(len(weights), -1)).reshape(-1, n, n)
