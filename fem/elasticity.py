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
from scipy.sparse import coo_matrix, csc_matrix
from skfem import Element, ElementTriP1, ElementTriP2, ElementTriP3, ElementTriP4, MeshTri
from skfem.assembly import Dofs
from skfem.quadrature import get_quadrature

from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array, Indices

from .condensation import symmetric
from .trace import Trace

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

    def interpolate(self, name: str, displacement: Callable[[Array], Array]) -> Array:
        """(nodes, 2) nodal values on a named boundary, in its order, of a displacement (n, 2) at (n, 2) points."""
        return displacement(self.positions[self.boundary(name)])

    def trace(self, breakpoints: Array) -> Trace:
        """Displacements on the contact facets between the breakpoints."""
        return Trace.nodal(breakpoints, self.degree)

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

    def _block(self, rows: slice, columns: slice) -> Array:
        """(m, 2 i, 2 j) stiffness of each triangle: radial, then axial displacements of some of its nodes by others."""
        lame, shear = moduli(self.poisson_ratio)
        moments, inverse_gram = self._dilatation
        slopes, by_slopes = self._slopes
        hoop, by_hoop = self._hoop
        (rr, rz), (zr, zz) = shear * by_slopes
        slopes, hoop = slopes[:, rows, columns], hoop[:, rows, columns]
        left, right = (moments[..., nodes].reshape(*moments.shape[:2], -1) for nodes in (rows, columns))
        block = np.swapaxes(left, 1, 2) @ (lame * inverse_gram) @ right
        _, i, j = slopes.shape
        block[:, :i, :j] += np.tensordot(2 * rr + zz, slopes, 1) + np.tensordot(2 * shear * by_hoop, hoop, 1)
        block[:, :i, j:] += np.tensordot(zr, slopes, 1)
        block[:, i:, :j] += np.tensordot(rz, slopes, 1)
        block[:, i:, j:] += np.tensordot(2 * zz + rr, slopes, 1)
        return block

    @cached_property
    def _condensed(self) -> tuple[Array, Array]:
        """(m, b, b) stiffness of each triangle's boundary, and (m, i, b) displacements inside by those on it."""
        boundary, inside = slice(len(self.element_dofs)), slice(len(self.element_dofs), None)
        across = self._block(inside, boundary)
        from_boundary = np.asarray(-np.linalg.solve(self._block(inside, inside), across), dtype=np.float64)
        condensed = self._block(boundary, boundary)
        condensed += np.swapaxes(across, 1, 2) @ from_boundary
        # an axial translation has no energy: roundoff, alike in all triangles, would add up to 1e-10 of the indentation
        n = len(self.element_dofs)
        axial = np.arange(n, 2 * n)
        condensed[:, axial, axial] -= condensed[:, n:, n:].sum(axis=2)
        return condensed, from_boundary

    @cached_property
    def _numbers(self) -> Indices:
        """(m, b) unknowns on the boundary of each triangle."""
        return np.concatenate([self.element_dofs, self.element_dofs + self.nodes]).T

    def lower_triangle(self, position: Indices) -> coo_matrix:
        """Lower triangle of the stiffness without the insides of triangles; entries at one place are to be summed.

        Parameters
        ----------
        position : (2 nodes,) row of each unknown; that of an unknown held at zero is negative
        """
        width = self._numbers.shape[1]
        one, other = np.tril_indices(width)
        places = position.astype(np.int32)[self._numbers]
        first, second = places.take(one, axis=1), places.take(other, axis=1)
        rows, columns = np.maximum(first, second), np.minimum(first, second)
        free = columns >= 0
        values = self._condensed[0].reshape(-1, width**2).take(one * width + other, axis=1)
        return coo_matrix((values[free], (rows[free], columns[free])), shape=(position.max() + 1,) * 2)

    @cached_property
    def stiffness(self) -> csc_matrix:
        """(2 nodes, 2 nodes) symmetric stiffness without the insides of triangles; no boundary condition applied."""
        return symmetric(self.lower_triangle(np.arange(2 * self.nodes)))

    def forces(self, displacement: Array) -> Array:
        """(2 nodes, k) nodal forces that make the (2 nodes, k) displacements."""
        moved = displacement[self._numbers].any(axis=(1, 2))
        numbers = self._numbers[moved]
        out = np.zeros_like(displacement)
        np.add.at(out, numbers, self._condensed[0][moved] @ displacement[numbers])
        return out

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """(6, m) corners and sides of each triangle, in one numbering, and (nodes,) the corner or side of each node."""
        mesh = self._triangulation
        part = np.arange(mesh.nvertices + mesh.nfacets)
        per_part = np.where(part < mesh.nvertices, 1, self.degree - 1)
        return np.concatenate([mesh.t, mesh.nvertices + mesh.t2f]), np.repeat(part, per_part)

    def on_triangles(self, displacement: Array) -> Array:
        """(states, all nodes of a triangle, m, 2) local displacements by (states, nodes, 2) displacements."""
        boundary = displacement[:, self.element_dofs]
        if not self.interior:
            return boundary
        flat = np.concatenate([boundary[..., 0], boundary[..., 1]], axis=1)
        inside = np.einsum("mib,sbm->sim", self._condensed[1], flat, optimize=True)
        inside = np.stack(np.split(inside, 2, axis=1), axis=-1)
        return np.concatenate([boundary, inside], axis=1)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """Tables (12, n, n) and (x, y, m, 12): their product is ``int r d_x phi_i d_y phi_j``."""
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree - 1)
        _, gradient = self.reference(points)
        table = np.einsum("vq,q,iaq,jbq->vabij", _barycentric(points), weights, gradient, gradient, optimize=True)
        inverse, area = self.inverse_jacobian
        by_radius = self.corners[0] * area * 2 * np.pi
        by_triangle = np.einsum("vm,axm,bym->xymvab", by_radius, inverse, inverse, optimize=True)
        return table.reshape(12, *table.shape[-2:]), by_triangle.reshape(2, 2, -1, 12)

    @cached_property
    def _hoop(self) -> tuple[Array, Array]:
        """Tables (q, n, n) and (m, q): their product is ``int phi_i phi_j / r``.

        The integrand is rational: a richer rule, whose points lie off the axis.
        """
        points, weights = get_quadrature(self._triangulation.refdom, 2 * self.degree + 4)
        value, _ = self.reference(points)
        _, area = self.inverse_jacobian
        measure = 2 * np.pi * area[:, None] * weights / (self.corners[0].T @ _barycentric(points))
        return np.einsum("iq,jq->qij", value, value), measure

    @cached_property
    def _dilatation(self) -> tuple[Array, Array]:
        """(m, t, 2, n) moments of ``r div u`` on the t polynomials one degree lower, and their inverse Gram matrices.

        Their product is ``div u`` projected. Near incompressibility lambda multiplies nothing then that could not
        vanish, and since ``r div u`` is a polynomial, no quadrature error either.
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
        moments = np.empty((len(area), t, 2, n))
        for component in range(2):
            constants = by_radius[:, :, None] * inverse[:, component].T[:, None, :]
            moments[:, :, component] = (constants.reshape(-1, 6) @ slopes).reshape(-1, t, n)
        moments[:, :, 0] += scale[:, None, None] * np.einsum("q,kq,iq->ki", weights, test, value)
        products = np.einsum("vq,q,kq,lq->vkl", corner, weights, test, test, optimize=True).reshape(3, -1)
        gram = (by_radius @ products).reshape(-1, t, t)
        return moments, np.linalg.inv(gram)

    def _lower_values(self, points: Array) -> Array:
        """(t, q) values of the polynomials one degree below the displacement's."""
        if self.degree == 1:
            return np.ones((1, points.shape[1]))
        lower = ELEMENTS[self.degree - 1]()
        return np.array([lower.lbasis(points, i)[0] for i in range(len(lower.doflocs))])

    def dilatation(self, local: Array, points: Array) -> Array:
        """(states, m, q) projected dilatation at reference points, by (states, nodes, m, 2) local displacements."""
        moments, inverse_gram = self._dilatation
        coefficients = np.einsum("mut,mtcn,snmc->smu", inverse_gram, moments, local, optimize=True)
        return coefficients @ self._lower_values(points)


def _barycentric(points: Array) -> Array:
    """(3, q) barycentric coordinates of reference points."""
    return np.stack([1 - points[0] - points[1], points[0], points[1]])
