"""Frictionless contact on the finite-element half-space.

Lagrange multipliers, condensed to a compliance.

Unknowns: displacements `u`, the pressure `p` on the contact (the multipliers, on the radial
pressure space), and the indentation `d`. With the coupling ``N_ij = int v_i phi_j dA`` of contact
displacements and pressures,

    K u = N p,      N^T u = d b - int f phi dA,      b . p = F.

`compliance` eliminates `u` once, ``A = N^T K^-1 N``, which is all that contact, wear and steady
states ever need.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import bmat, coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import splu
from skfem import MeshQuad

from ..meshes.compliance import Compliance
from ..meshes.errors import SolverError
from ..meshes.half_space import contact_facets, contact_vertices, low_parts, segments
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, Indices, gauss, layer_degrees
from .condensation import SYMMETRIC, fill_reducing_order, symmetric, trailing_factor
from .elasticity import AxisymmetricElasticity
from .far_field import exterior_stiffness, poles
from .weak_form import moduli


def pressure_space(
    solid: AxisymmetricElasticity, ring_edges: Array, hollow: bool = False
) -> PressureSpace:
    """Return the pressure space on the contact facets of a solid that goes with its displacements.

    Of a hollow punch the first ring is the hole, where the surface is free.
    """
    vertices = contact_vertices(solid.mesh)
    breakpoints, below = solid.mesh.p[0, vertices], low_parts(solid.mesh)[vertices]
    # ring edges exactly as they are
    at_edges = np.abs((breakpoints[:, None] - ring_edges) + below[:, None]).argmin(axis=0)
    breakpoints[at_edges], below[at_edges] = ring_edges, 0.0
    if isinstance(solid.mesh, MeshQuad):
        # one degree below the displacement, near incompressibility, some pressures would have but 2
        # per cent of their energy
        degrees = np.maximum(solid.facet_degrees[contact_facets(solid.mesh)] - 2, 1)
    else:
        # the highest that is stable, reached within a few facets of a ring edge or the rim, where a
        # low one is as accurate
        highest, lowest = max(solid.degree - 1, 1), max(1, solid.degree - 2)
        degrees = layer_degrees(breakpoints, ring_edges, highest, rise=0.5, lowest=lowest)
    if hollow:
        degrees = np.where(breakpoints[1:] <= ring_edges[1], 0, degrees)
    return PressureSpace(breakpoints, degrees, ring_edges, below)


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
    space : pressure space on its contact facets
    poles : orders of the Boussinesq poles tied to the outer boundary; none clamps it (`fixed`)
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
            lambda points: np.moveaxis(poles(points, self.poles, *self._elasticity)[0], 0, -1),
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
        sides = segments(self.solid.mesh, self.solid.mesh.boundaries["far"])
        exterior = exterior_stiffness(sides, self.poles, *self._elasticity)
        corner = self._far_fields.T @ border + exterior
        edge, end = coo_matrix(border[self._order].T), coo_matrix(np.tril((corner + corner.T) / 2))
        return bmat([[free, None], [edge, end]], format="coo")

    @cached_property
    def system(self) -> csc_matrix:
        """Stiffness of (inside, contact, amplitudes of the poles): symmetric positive definite."""
        return symmetric(self.lower_triangle)

    @cached_property
    def coupling(self) -> Array:
        """(contact nodes + k, size) ``int v_i phi_j dA``; the poles do not touch the contact."""
        solid, space = self.solid, self.space
        node, weight = gauss(solid.degree + space.top)
        half = space.widths[:, None] / 2
        radii = space.breakpoints[:-1, None] + half * (1 + node)
        area = diags((2 * np.pi * radii * half * weight).ravel())
        displacements = solid.trace(contact_facets(solid.mesh), (1 + node) / 2)
        on_contact = displacements[:, solid.boundary("contact")].T @ area @ space.on_elements(node)
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

    def compliance(self) -> Compliance:
        """Condense the half-space to its compliance on the pressure space.

        The rows of the factor belong to contact nodes, then to poles: without its last row it is
        the compliance of the same half-space with one pole less.
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
        return Compliance(self.space, factor)
