"""Frictionless contact on the finite-element half-space.

Lagrange multipliers, condensed to a compliance.

Unknowns: displacements `u`, the pressure `p` on the contact (the multipliers, on the radial
pressure space), and the indentation `d`. With the coupling ``N_ij = int v_i phi_j dA`` of contact
displacements and pressures,

    K u = N p,      N^T u = d b - int f phi dA,      b . p = F.

`compliance` eliminates `u` once, ``A = N^T K^-1 N``, which is all that contact, wear and steady
states ever need.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import bmat, coo_matrix, csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu
from skfem import Mesh, MeshQuad

from ..meshes.compliance import Compliance
from ..meshes.errors import SolverError
from ..meshes.ground.line_energy import flat_series
from ..meshes.half_space import (
    contact_facets,
    contact_vertices,
    low_parts,
    segments,
    truncation,
)
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, Indices, gauss, layer_degrees
from .condensation import SYMMETRIC, fill_reducing_order, symmetric, trailing_factor
from .elasticity import AxisymmetricElasticity
from .far_field import exterior_stiffness, poles
from .stability import least_ratio, refuse_singular
from .weak_form import moduli


def pressure_space(
    solid: AxisymmetricElasticity, ring_edges: Array, hollow: bool = False
) -> PressureSpace:
    """Return the pressure space on the contact facets of a solid that goes with its displacements.

    Pressures are of a lower degree than displacements. Beneath linear displacements they are
    linear, too; the two facets beside a ring edge then have one linear pressure together, so that
    no pressure breaks at the edge that displacements cannot see. Mortar methods for linear elements
    do the same at the ends of an interface (Bernardi, Maday, Patera, 1994).

    Of a hollow punch the first ring is the hole, where the surface is free.
    """
    breakpoints, below = contact_breakpoints(solid.mesh, ring_edges)
    if isinstance(solid.mesh, MeshQuad):
        # one degree below the displacement, near incompressibility, some pressures would have but 2
        # per cent of their energy
        degrees = np.maximum(solid.facet_degrees[contact_facets(solid.mesh)] - 2, 1)
    else:
        # the highest that is stable, reached within a few facets of a ring edge or the rim, where a
        # low one is as accurate
        highest, lowest = max(solid.degree - 1, 1), max(solid.degree - 2, 1)
        degrees = layer_degrees(breakpoints, ring_edges, highest, rise=0.5, lowest=lowest)
    if hollow:
        degrees = np.where(breakpoints[1:] <= ring_edges[1], 0, degrees)
    space = PressureSpace(breakpoints, degrees, ring_edges, below)
    return space.joined_beside_ring_edges() if solid.degree == 1 else space


def contact_breakpoints(mesh: Mesh, ring_edges: Array) -> tuple[Array, Array]:
    """Return the ends (n+1,) of the n facets of the contact, and what rounding has taken from each.

    Ring edges are exactly as they are given.
    """
    vertices = contact_vertices(mesh)
    breakpoints, below = mesh.p[0, vertices], low_parts(mesh)[vertices]
    at_edges = np.abs((breakpoints[:, None] - ring_edges) + below[:, None]).argmin(axis=0)
    breakpoints[at_edges], below[at_edges] = ring_edges, 0.0
    return breakpoints, below


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """Solve for the half-space under a punch by finite elements, condensed to its contact.

    A `HalfSpace` combines an elastic solid, the contact pressures on its surface, and the solution
    outside its outer boundary. `compliance` condenses it to the contact, and `displacements`
    recovers the inside. The pressure one on the whole disc has ``int u p dA = 16/3``.

    >>> from ringwear.meshes import bisection, sizes
    >>> field = sizes.SizeField((0, 1), rim_size=1e-3, ring_size=1, growth=0.6, truncation=5)
    >>> solid = AxisymmetricElasticity(bisection.mesh(field), 4, nominal_poisson_ratio=0.3)
    >>> space = pressure_space(solid, ring_edges=np.array([0.0, 1.0]))
    >>> moments = HalfSpace(solid, space, poles=(0, 2)).compliance().matrix @ space.uniform
    >>> round(float(space.uniform @ moments), 5)
    5.33333

    Parameters
    ----------
    solid : the elastic solid
    space : pressure space on its contact facets, or on elements of several facets each
    poles : orders of the Boussinesq poles tied to the outer boundary; none clamps it (`fixed`). On
        layers there are as many loads in their place
    """

    solid: AxisymmetricElasticity
    space: PressureSpace
    poles: tuple[int, ...]

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns and amplitudes of poles."""
        return self.solid.unknowns + len(self.poles)

    @property
    def _elasticity(self) -> tuple[float, float]:
        """Poisson's ratio and shear modulus."""
        return self.solid.poisson_ratio, moduli(self.solid.poisson_ratio)[1]

    def far_fields_at(self, points: Array) -> tuple[Array, Array]:
        """Return displacements (k, n, 2) and stresses (k, n, 4) of the poles at points (n, 2).

        On layers there are loads on the contact in place of poles (`layered_far_field.py`).
        """
        if (ground := self.solid.modelled_ground) is None:
            return poles(points, self.poles, *self._elasticity)
        from .layered_far_field import loaded_fields  # homogeneous half-spaces do not need it

        return loaded_fields(points, len(self.poles), ground, truncation(self.solid.mesh))

    def without_dependent_poles(self) -> "HalfSpace":
        """Return the same half-space without poles that a rigid base leaves next to nothing of."""
        if self.solid.ground is None or not self.solid.ground.rigid:
            return self
        from .layered_far_field import independent_count  # homogeneous ones do not need it

        kept = independent_count(self._energies_beyond, float(self.solid.materials[1].min()))
        return replace(self, poles=self.poles[:kept])

    @property
    def _energies_beyond(self) -> Array:
        """(k, k) energies of the poles beyond the outer boundary."""
        far = segments(self.solid.mesh, self.solid.mesh.boundaries["far"])
        return exterior_stiffness(far, self.far_fields_at)

    @cached_property
    def _order(self) -> Indices:
        """Unknowns inside the half-space and on the contact, in the order of `system`.

        The unknowns inside come first, in the order of elimination; the axial unknowns on the
        contact follow by radius.
        """
        solid, n = self.solid, self.solid.nodes
        free = np.tile(~solid.fixed, (2, 1))
        far, contact = solid.boundary("far"), solid.boundary("contact")
        free[0, solid.boundary("axis")] = False
        free[:, far] = False
        free[1, contact] = False
        if "base" in solid.mesh.boundaries:
            free[:, solid.boundary("base")] = False
        # nodes of one corner or side have the same neighbours: theirs is a far smaller graph than
        # that of unknowns
        neighbours, part = solid.parts
        rank = np.argsort(fill_reducing_order(neighbours))
        order = np.argsort(rank[part], kind="stable")
        unknowns = np.stack([order, order + n], axis=1)
        return np.concatenate([unknowns[free.T[order]], contact + n])

    @cached_property
    def _far_fields(self) -> Array:
        """(2n, k) nodal values of the poles on the outer boundary, zero elsewhere."""
        solid, far = self.solid, self.solid.boundary("far")
        if not self.poles:
            return np.zeros((2 * solid.nodes, 0))
        nodal = solid.interpolate(
            "far",
            lambda points: np.moveaxis(self.far_fields_at(points)[0], 0, -1),
        )
        out = np.zeros((2 * solid.nodes, len(self.poles)))
        out[far], out[far + solid.nodes] = nodal.swapaxes(0, 1)
        return out

    @cached_property
    def lower_triangle(self) -> coo_matrix:
        """Lower triangle of `system`, its entries at one place not summed yet.

        All that condensing takes.
        """
        position = np.full(2 * self.solid.nodes, -1)
        position[self._order] = np.arange(len(self._order))
        free = self.solid.lower_triangle(position)
        if not self.poles:
            return free
        border = self.solid.forces(self._far_fields)
        corner = self._far_fields.T @ border + self._energies_beyond
        edge, end = coo_matrix(border[self._order].T), coo_matrix(np.tril((corner + corner.T) / 2))
        return bmat([[free, None], [edge, end]], format="coo")

    @cached_property
    def system(self) -> csc_matrix:
        """Stiffness of (inside, contact, amplitudes of the poles): symmetric positive definite."""
        return symmetric(self.lower_triangle)

    @cached_property
    def _on_contact(self) -> tuple[csr_matrix, csr_matrix, Array]:
        """Displacements (q, m) and pressures (q, n) at Gauss points of the contact, and areas (q,).

        The points are enough for products of two displacements.
        """
        solid, facets = self.solid, self._facet_space
        node, weight = gauss(solid.degree + max(facets.top, 1))
        half = facets.widths[:, None] / 2
        radii = facets.breakpoints[:-1, None] + half * (1 + node)
        displacements = solid.trace(contact_facets(solid.mesh), (1 + node) / 2)
        pressures = facets.on_elements(node)
        if facets is not self.space:
            pressures = pressures @ facets.embedding(self.space)
        areas = (2 * np.pi * radii * half * weight).ravel()
        return displacements[:, solid.boundary("contact")], pressures, areas

    @property
    def _facet_space(self) -> PressureSpace:
        """The pressure space, on the facets of the contact, each with the degree it lies in."""
        breakpoints, below = contact_breakpoints(self.solid.mesh, self.space.ring_edges)
        if len(breakpoints) == len(self.space.breakpoints):
            return self.space
        return self.space.divided(breakpoints, below)

    @cached_property
    def coupling(self) -> Array:
        """(contact nodes + k, size) ``int v_i phi_j dA``; the poles do not touch the contact."""
        displacements, pressures, areas = self._on_contact
        on_contact = displacements.T @ diags(areas) @ pressures
        return np.pad(on_contact.toarray(), ((0, len(self.poles)), (0, 0)))

    def displacements(self, pressures: Array) -> Array:
        """Return the displacement coefficients of all functions under given contact pressures.

        `pressures` (states, size) are coefficients on the pressure space. The result (states,
        functions, 2) holds the radial and axial coefficients.

        Raises
        ------
        SolverError
            if the stiffness of the half-space is singular
        """
        loads, inside = self.coupling @ pressures.T, self.system.shape[0] - len(self.coupling)
        right = np.pad(loads, ((inside, 0), (0, 0)))
        solution = splu(self.system, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).solve(right)
        if not np.isfinite(solution).all():
            raise SolverError(
                "the stiffness of the half-space is singular: no displacement can be recovered"
            )
        free = len(self._order)
        moved = self._far_fields @ solution[free:]
        moved[self._order] = solution[:free]
        return self.solid.with_insides(moved)

    def stability(self, basis: csr_matrix | None = None) -> float:
        """Return how well the displacements see the least visible pressure (`stability`).

        Parameters
        ----------
        basis : (size, n) coefficients of the pressures in question; default all of the space
        """
        displacements, pressures, areas = self._on_contact
        return least_ratio(displacements, pressures if basis is None else pressures @ basis, areas)

    def compliance(self) -> Compliance:
        """Condense the half-space to its compliance on the pressure space.

        The rows of the factor belong to contact nodes, then to poles: without its last row it is
        the compliance of the same half-space with one pole less.

        Raises
        ------
        SolverError
            if a pressure displaces nothing, or if the stiffness of the half-space is singular
        """
        refuse_singular(self.stability(), self.space.size, len(self.coupling) - len(self.poles))
        ground = self.solid.modelled_ground
        series = (1.0,) if ground is None else flat_series(ground)
        return Compliance(self.space, self.condensed(), series)

    def condensed(self) -> Array:
        """Return the factor (contact nodes + k, size) of the compliance, singular or not.

        Pressure spaces within this one, which may be stable where all of it is not, have the factor
        times their bases.
        """
        stiffness = trailing_factor(
            self.lower_triangle, self.lower_triangle.shape[0] - len(self.coupling)
        )
        factor = np.zeros_like(self.coupling)
        # both run along the radius: a pressure has nothing to do with contact nodes closer to the
        # axis
        for start in range(0, self.space.size, 256):
            columns = slice(start, start + 256)
            rows = slice(np.flatnonzero(self.coupling[:, columns].any(axis=1))[0], None)
            factor[rows, columns] = solve_triangular(
                stiffness[rows, rows], self.coupling[rows, columns], lower=True
            )
        return factor
