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


# an incompressible solid is modelled as this one: with the plane strain modulus given, pressures and displacements on
# the contact do not depend on Poisson's ratio, and closer to 1/2 roundoff costs more than it gains
LEAST_COMPRESSIBLE = 0.49999


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
    given_ratio : Poisson's ratio, up to and including 1/2
    """

    mesh: HalfSpaceMesh
    degree: int
    given_ratio: float

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that is modelled."""
        return min(self.given_ratio, LEAST_COMPRESSIBLE)

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
        """Number of nodes on vertices and facets, which are numbered first; there are twice as many unknowns."""
        return int(self._dofs.N) - self.interior * len(self.mesh.triangles)

    @property
    def interior(self) -> int:
        """Nodes inside each triangle, the last of its nodes: eliminated before anything is assembled."""
        return int(self.element.interior_dofs)

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, those inside triangles among them."""
        return 2 * int(self._dofs.N)

    @property
    def element_dofs(self) -> Indices:
        """(nodes on the boundary of a triangle, m) node numbers."""
        dofs = self._dofs.element_dofs
        return dofs[: len(dofs) - self.interior]

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
        xi, eta = self.element.doflocs[: len(self.element_dofs)].T
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
        on_facets = self._dofs.facet_dofs[:, found] if self.degree > 1 else np.empty(0, dtype=np.int64)
        return np.unique(np.concatenate([wanted.ravel(), on_facets.ravel()]))

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
    def _local(self) -> Array:
        """(m, 2n, 2n) stiffness of each triangle: radial, then axial displacements of its n nodes."""
        lame, shear = moduli(self.poisson_ratio)
        weighted = self._weighted_gradients()
        rr, zz, rz = weighted(0, 0), weighted(1, 1), weighted(0, 1)
        hoop = self._hoop()
        moments, projection = self._dilatation
        local = lame * (np.swapaxes(moments, 1, 2) @ projection)
        n = rr.shape[-1]
        local[:, :n, :n] += shear * (2 * (rr + hoop) + zz)
        local[:, n:, n:] += shear * (2 * zz + rr)
        local[:, :n, n:] += shear * rz.transpose(0, 2, 1)
        local[:, n:, :n] += shear * rz
        return local

    @cached_property
    def _split(self) -> tuple[Indices, Indices]:
        """Local unknowns on the boundary of a triangle and inside it."""
        n = len(self.element.doflocs)
        inside = np.arange(n) >= n - self.interior
        inside = np.concatenate([inside, inside])
        return np.flatnonzero(~inside), np.flatnonzero(inside)

    @cached_property
    def _from_boundary(self) -> Array:
        """(m, inside, boundary) displacements inside a triangle by those on its boundary."""
        outer, inner = self._split
        inside = self._local[:, inner[:, None], inner]
        return np.asarray(-np.linalg.solve(inside, self._local[:, inner[:, None], outer]), dtype=np.float64)

    @cached_property
    def stiffness(self) -> csc_matrix:
        """(2 nodes, 2 nodes) symmetric stiffness without the insides of triangles; no boundary condition applied."""
        outer, inner = self._split
        local = self._local[:, outer[:, None], outer]
        if len(inner):
            local = local + self._local[:, outer[:, None], inner] @ self._from_boundary
        numbers = np.concatenate([self.element_dofs, self.element_dofs + self.nodes]).T
        width = numbers.shape[1]
        rows, columns = np.repeat(numbers, width, axis=1), np.tile(numbers, (1, width))
        size = 2 * self.nodes
        return csc_matrix((local.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))

    @cached_property
    def graph(self) -> csc_matrix:
        """(nodes, nodes) which nodes share a triangle, themselves included."""
        numbers = self.element_dofs.T
        width = numbers.shape[1]
        rows, columns = np.repeat(numbers, width, axis=1).ravel(), np.tile(numbers, (1, width)).ravel()
        return csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(self.nodes, self.nodes))

    def on_triangles(self, displacement: Array) -> Array:
        """(states, all nodes of a triangle, m, 2) local displacements by (states, nodes, 2) displacements."""
        boundary = displacement[:, self.element_dofs]
        if not self.interior:
            return boundary
        flat = np.concatenate([boundary[..., 0], boundary[..., 1]], axis=1)
        inside = np.einsum("mib,sbm->sim", self._from_boundary, flat, optimize=True)
        inside = np.stack(np.split(inside, 2, axis=1), axis=-1)
        return np.concatenate([boundary, inside], axis=1)

    def _weighted_gradients(self) -> Callable[[int, int], Array]:
        """``(x, y) -> int r d_x phi_i d_y phi_j`` on every triangle."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree - 1)
        _, gradient = self.reference(points)
        tensor = np.einsum("vq,q,iaq,jbq->vabij", _barycentric(points), weights, gradient, gradient, optimize=True)
        inverse, area = self.inverse_jacobian
        n = tensor.shape[-1]

        def block(x: int, y: int) -> Array:
            constants = np.einsum("vm,am,bm->mvab", self.corners[0] * area * 2 * np.pi, inverse[:, x], inverse[:, y])
            return (constants.reshape(-1, 12) @ tensor.reshape(12, -1)).reshape(-1, n, n)

        return block

    def _hoop(self) -> Array:
        """``int phi_i phi_j / r`` on every triangle: rational, so by a richer rule, whose points lie off the axis."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree + 4)
        value, _ = self.reference(points)
        _, area = self.inverse_jacobian
        measure = 2 * np.pi * area[:, None] * weights / (self.corners[0].T @ _barycentric(points))
        n = len(value)
        return (measure @ np.einsum("iq,jq->qij", value, value).reshape(-1, n * n)).reshape(-1, n, n)

    @cached_property
    def _dilatation(self) -> tuple[Array, Array]:
        """(m, t, 2n) moments of ``r div u``, and ``div u`` projected, on the t polynomials one degree lower.

        Near incompressibility lambda multiplies nothing then that could not vanish, and since ``r div u`` is a
        polynomial, no quadrature error either.
        """
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree)
        value, gradient = self.reference(points)
        test = self._lower_values(points)
        corner = _barycentric(points)
        inverse, area = self.inverse_jacobian
        scale = 2 * np.pi * area
        by_radius = (scale * self.corners[0]).T
        n, t = len(value), len(test)
        slopes = np.einsum("vq,q,kq,iaq->vaki", corner, weights, test, gradient, optimize=True).reshape(6, -1)
        moments = np.empty((len(area), t, 2 * n))
        for component, block in enumerate((moments[:, :, :n], moments[:, :, n:])):
            constants = by_radius[:, :, None] * inverse[:, component].T[:, None, :]
            block[:] = (constants.reshape(-1, 6) @ slopes).reshape(-1, t, n)
        moments[:, :, :n] += scale[:, None, None] * np.einsum("q,kq,iq->ki", weights, test, value)
        products = np.einsum("vq,q,kq,lq->vkl", corner, weights, test, test, optimize=True).reshape(3, -1)
        gram = (by_radius @ products).reshape(-1, t, t)
        return moments, np.asarray(np.linalg.solve(gram, moments), dtype=np.float64)

    def _lower_values(self, points: Array) -> Array:
        """(t, q) values of the polynomials one degree below the displacement's."""
        if self.degree == 1:
            return np.ones((1, points.shape[1]))
        lower = ELEMENTS[self.degree - 1]()
        return np.array([lower.lbasis(points, i)[0] for i in range(len(lower.doflocs))])

    def dilatation(self, local: Array, points: Array) -> Array:
        """(states, m, q) projected dilatation at reference points, by (states, nodes, m, 2) local displacements."""
        flat = np.concatenate([local[..., 0], local[..., 1]], axis=1)
        coefficients = np.einsum("mtb,sbm->smt", self._dilatation[1], flat, optimize=True)
        return coefficients @ self._lower_values(points)


def _barycentric(points: Array) -> Array:
    """(3, q) barycentric coordinates of reference points."""
    return np.stack([1 - points[0] - points[1], points[0], points[1]])
