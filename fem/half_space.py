"""Frictionless contact on the finite-element half-space, condensed to a compliance.

The contact pressures are Lagrange multipliers. The unknowns are the displacements `u`, the pressure
`p` on the contact, which lies in the radial pressure space, and the indentation `d`. With the
coupling ``N_ij = int v_i phi_j dA`` of contact displacements and pressures and the worn profile
`f`,

    K u = N p,      N^T u = d b - int f phi dA,      b . p = F.

`compliance` eliminates `u` once. The result ``A = N^T K^-1 N`` is all that contact, wear and steady
states need.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular
from scipy.sparse import bmat, coo_matrix, csr_matrix, diags
from skfem import Mesh, MeshQuad

from ..meshes.compliance import Compliance
from ..meshes.errors import SolverError
from ..meshes.ground.ground import HALF_SPACE
from ..meshes.half_space import (
    contact_facets,
    contact_vertices,
    low_parts,
    segments,
    truncation,
)
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, Indices, gauss, layer_degrees
from .condensation import Factor, fill_reducing_order
from .elasticity import AxisymmetricElasticity
from .far_field import exterior_stiffness, poles
from .stability import least_ratio, refuse_singular


def pressure_space(solid: AxisymmetricElasticity, ring_edges: Array) -> PressureSpace:
    """Return a pressure space on the contact facets that is stable with the displacements.

    Pressures have a lower degree than displacements. With linear displacements they are linear,
    too; the two facets next to a ring edge, on either side, then share one linear pressure, so that
    no pressure jumps at the edge in a way that the displacements cannot represent. Mortar methods
    for linear elements do the same at the ends of an interface (Bernardi, Maday, Patera, 1994).

    Parameters
    ----------
    solid : elastic solid
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    """
    breakpoints, low = contact_breakpoints(solid.mesh, ring_edges)
    if isinstance(solid.mesh, MeshQuad):
        # With a pressure one degree below the displacement, some pressures would keep only 2 per
        # cent of their energy near incompressibility. Hence two degrees below.
        degrees = np.maximum(solid.facet_degrees[contact_facets(solid.mesh)] - 2, 1)
    else:
        # The highest stable degree, except on a few facets next to a ring edge or the rim, where a
        # lower degree is as accurate.
        highest, lowest = max(solid.degree - 1, 1), max(solid.degree - 2, 1)
        degrees = layer_degrees(breakpoints, ring_edges, highest, rise=0.5, lowest=lowest)
    space = PressureSpace(breakpoints, degrees, ring_edges, low)
    return space.joined_beside_ring_edges() if solid.degree == 1 else space


def contact_breakpoints(mesh: Mesh, ring_edges: Array) -> tuple[Array, Array]:
    """Return the ends (n+1,) of the n facets of the contact, and their low parts.

    Ring edges have exactly the given radii.
    """
    vertices = contact_vertices(mesh)
    breakpoints, low = mesh.p[0, vertices], low_parts(mesh)[vertices]
    at_edges = np.abs((breakpoints[:, None] - ring_edges) + low[:, None]).argmin(axis=0)
    breakpoints[at_edges], low[at_edges] = ring_edges, 0.0
    return breakpoints, low


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """Solve for the half-space under a punch by finite elements, condensed to its contact.

    A `HalfSpace` combines an elastic solid, the contact pressures on its surface, and the solution
    outside its outer boundary. `compliance` condenses it to the contact, and `displacements`
    recovers the displacement inside. The uniform pressure 1 on the whole disc has
    ``int u p dA = 16/3``.

    >>> from ringwear.meshes import bisection, sizes
    >>> field = sizes.SizeField((0, 1), rim_size=1e-3, ring_size=1, growth=0.6, truncation=5)
    >>> solid = AxisymmetricElasticity(bisection.mesh(field), degree=4)
    >>> space = pressure_space(solid, ring_edges=np.array([0.0, 1.0]))
    >>> moments = HalfSpace(solid, space, poles=(0, 2)).compliance().matrix @ space.uniform
    >>> round(float(space.uniform @ moments), 5)
    5.33333

    Parameters
    ----------
    solid : the elastic solid
    space : pressure space on its contact facets, or on elements of several facets each
    poles : orders of the Boussinesq poles tied to the outer boundary; the boundary is clamped if
        there are none. On layers, the same number of loads replaces the poles
    """

    solid: AxisymmetricElasticity
    space: PressureSpace
    poles: tuple[int, ...]

    def __reduce__(self) -> tuple[object, ...]:
        """Leave out stored matrices when another process returns a solution."""
        return HalfSpace, (replace(self.solid), self.space, self.poles)

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns and pole amplitudes."""
        return self.solid.unknowns + len(self.poles)

    def far_fields_at(self, points: Array) -> tuple[Array, Array]:
        """Return displacements (k, n, 2) and stresses (k, n, 4) of the poles at points (n, 2).

        On layers, loads on the contact replace the poles (`layered_far_field.py`).
        """
        if not (ground := self.solid.modelled_ground).layered:
            return poles(points, self.poles, ground.poisson_ratios[0], ground.shear_moduli[0])
        from .layered_far_field import loaded_fields  # homogeneous half-spaces do not need it

        return loaded_fields(points, len(self.poles), ground, truncation(self.solid.mesh))

    def without_dependent_poles(self) -> "HalfSpace":
        """Return the half-space without the poles whose fields a rigid base makes negligible.

        Loads whose fields at the boundary can no longer be distinguished are left out, too.
        """
        if not self.solid.ground.rigid or not self.poles:
            return self
        from .layered_far_field import independent_count  # homogeneous ones do not need it

        pole_count = independent_count(self._energies_beyond, float(self.solid.materials[1].min()))
        return replace(self, poles=self.poles[:pole_count])

    @property
    def more_compressible(self) -> "HalfSpace | None":
        """The second half-space of an extrapolation to the nominal Poisson's ratios.

        None if the model has the nominal ratios.
        """
        solid = self.solid.more_compressible
        return None if solid is None else replace(self, solid=solid)

    @property
    def _energies_beyond(self) -> Array:
        """(k, k) energies of the poles in the region beyond the outer boundary."""
        far_sides = segments(self.solid.mesh, self.solid.mesh.boundaries["far"])
        return exterior_stiffness(far_sides, self.far_fields_at)

    @cached_property
    def _order(self) -> Indices:
        """Unknowns inside the half-space and on the contact, in the order of the stiffness.

        The unknowns inside come first, in the order of elimination; the axial unknowns on the
        contact follow, ordered by radius.
        """
        solid, n = self.solid, self.solid.nodes
        free = np.tile(~solid.fixed, (2, 1))
        far_functions, contact = solid.boundary("far"), solid.boundary("contact")
        free[0, solid.boundary("axis")] = False
        free[:, far_functions] = False
        free[1, contact] = False
        if "base" in solid.mesh.boundaries:
            free[:, solid.boundary("base")] = False
        # nodes of one corner or side have the same neighbours, so the graph of corners and sides
        # suffices; it is far smaller than the graph of unknowns
        neighbours, vertex_or_facet = solid.parts
        rank = np.argsort(fill_reducing_order(neighbours))
        order = np.argsort(rank[vertex_or_facet], kind="stable")
        unknowns = np.stack([order, order + n], axis=1)
        return np.concatenate([unknowns[free.T[order]], contact + n])

    @cached_property
    def _far_fields(self) -> Array:
        """(2 nodes, k) coefficients of the poles on the outer boundary, zero elsewhere."""
        solid, far_functions = self.solid, self.solid.boundary("far")
        if not self.poles:
            return np.zeros((2 * solid.nodes, 0))
        nodal = solid.interpolate(
            "far",
            lambda points: np.moveaxis(self.far_fields_at(points)[0], 0, -1),
        )
        out = np.zeros((2 * solid.nodes, len(self.poles)))
        out[far_functions], out[far_functions + solid.nodes] = nodal.swapaxes(0, 1)
        return out

    @cached_property
    def lower_triangle(self) -> coo_matrix:
        """Lower triangle of the stiffness, whose duplicate entries are not summed yet.

        The unknowns are those inside, those on the contact, and the amplitudes of the poles. The
        stiffness is symmetric and positive definite.
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
    def _factor(self) -> Factor:
        return Factor(self.lower_triangle)

    @cached_property
    def _on_contact(self) -> tuple[csr_matrix, csr_matrix, Array]:
        """Displacement and pressure functions at Gauss points of the contact, and the areas.

        The displacements are (q, m), the pressures (q, n) and the areas, which are the weights,
        (q,). The Gauss points integrate products of two displacements exactly.
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
        """The pressure space on the facets of the contact, each with the degree of its element."""
        breakpoints, low = contact_breakpoints(self.solid.mesh, self.space.ring_edges)
        if len(breakpoints) == len(self.space.breakpoints):
            return self.space
        return self.space.divided(breakpoints, low)

    @cached_property
    def coupling(self) -> Array:
        """(contact nodes + k, size) ``int v_i phi_j dA``; the rows of the k poles are zero."""
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
        loads = self.coupling @ pressures.T
        right = np.pad(loads, ((self.lower_triangle.shape[0] - len(loads), 0), (0, 0)))
        solution = self._factor.solve(right)
        free = len(self._order)
        displacement = self._far_fields @ solution[free:]
        displacement[self._order] = solution[:free]
        return self.solid.with_insides(displacement)

    def contact_stiffness(self) -> Array:
        """Return the stiffness (k, k) of the k nodes of the contact, ordered by radius.

        The forces on the nodes are this matrix times their axial displacements; all other
        displacements and the poles are eliminated. The elements are Lagrange elements of
        scikit-fem, whose functions belong to nodes.

        Raises
        ------
        SolverError
            if the stiffness of the half-space is singular
        """
        count = len(self.solid.boundary("contact"))
        eliminated = self.lower_triangle.shape[0] - count - len(self.poles)
        factor = self._factor.trailing(eliminated)
        matrix = factor @ factor.T
        nodes, to_poles = matrix[:count, :count], matrix[:count, count:]
        if not self.poles:
            return nodes
        return nodes - to_poles @ np.linalg.solve(matrix[count:, count:], to_poles.T)

    def stability(self, basis: csr_matrix | None = None) -> float:
        """Return the least stability ratio of a pressure with the displacements (`stability`).

        Parameters
        ----------
        basis : (size, n) coefficients of the pressures to examine; by default all of the space
        """
        displacements, pressures, areas = self._on_contact
        return least_ratio(displacements, pressures if basis is None else pressures @ basis, areas)

    def compliance(self) -> Compliance:
        """Condense the half-space to its compliance on the pressure space.

        If Poisson's ratios of layers are too near 1/2 to be modelled, the half-space is condensed
        for two solids, and the compliance is extrapolated (`incompressibility.py`). An elastic
        punch on layers is a second, homogeneous half-space on the same mesh.

        Raises
        ------
        SolverError
            if a pressure displaces nothing, or if the stiffness of the half-space is singular
        """
        return self._compliances([len(self.poles)])[0]

    def compliances_by_poles(self) -> list[Compliance]:
        """Return the compliance without poles, with the first pole, and so on up to all poles.

        Without poles, the outer boundary is clamped. The half-space is condensed only once.

        Raises
        ------
        SolverError
            if a pressure displaces nothing, or if the stiffness of the half-space is singular
        """
        return self._compliances(range(len(self.poles) + 1))

    def _compliances(self, pole_counts: Sequence[int]) -> list[Compliance]:
        """Return the compliance with each of several numbers of poles."""
        node_count = len(self.coupling) - len(self.poles)
        refuse_singular(self.stability(), self.space.size, node_count)
        factors, ground = [self.condensed()], self.solid.ground
        # the compliance of a homogeneous half-space depends on its plane strain modulus alone
        if ground.layered and (second := self.more_compressible):
            factors.append(second.condensed())
        # the rows of a factor belong to contact nodes, then to poles; without the row of the last
        # pole it is the factor of the same half-space with one pole less
        rows = [slice(node_count + count) for count in pole_counts]
        parts = [[factor[used] for factor in factors] for used in rows]
        totals = [extrapolated(*part) if len(part) > 1 else part[0] for part in parts]
        if ground.share < 1:
            punch = replace(self, solid=replace(self.solid, ground=HALF_SPACE)).condensed()
            shares = np.sqrt([ground.share, 1 - ground.share])
            totals = [
                np.concatenate([shares[0] * total, shares[1] * punch[used]])
                for total, used in zip(totals, rows, strict=True)
            ]
        return [Compliance(self.space, total, ground) for total in totals]

    def condensed(self) -> Array:
        """Return the factor (contact nodes + k, size) of the compliance, even if it is singular.

        The factor on a subspace of the pressures is this factor times the basis of the subspace. A
        subspace may be stable although the full space is not.
        """
        stiffness = self._factor.trailing(self.lower_triangle.shape[0] - len(self.coupling))
        factor = self.coupling.copy()
        # Rows and columns are ordered along the radius. The coupling of a pressure with contact
        # nodes closer to the axis is zero, and so are these rows of the solution.
        for start in range(0, self.space.size, 256):
            columns = factor[:, start : start + 256]
            first = np.flatnonzero(columns.any(axis=1))[0]
            _solve_in_place(stiffness[first:, first:], columns[first:])
        return factor


def _solve_in_place(triangle: Array, right: Array) -> None:
    """Replace right-hand sides (n, k) by the solutions of a lower triangular system (n, n).

    The system is halved until it is small. Products of blocks need no copies of the blocks, which
    take longer than the arithmetic of a large system.
    """
    middle = len(triangle) // 2
    if middle < 64:
        right[:] = solve_triangular(triangle, right, lower=True, check_finite=False)
        return
    _solve_in_place(triangle[:middle, :middle], right[:middle])
    right[middle:] -= triangle[middle:, :middle] @ right[:middle]
    _solve_in_place(triangle[middle:, middle:], right[middle:])


def extrapolated(near: Array, far: Array) -> Array:
    """Return a factor of ``2 A - B`` of two compliances A and B: the linear extrapolation.

    Parameters
    ----------
    near, far : (m, size) factors of A and B, whose distances to the wanted compliance are as 1 to 2

    Notes
    -----
    The factors themselves cannot be extrapolated, because roundoff rotates their rows.

    Raises
    ------
    SolverError
        if the extrapolated compliance is not positive definite
    """
    matrix = 2 * (near.T @ near) - far.T @ far
    # small elements at ring edges have far smaller entries than large ones
    scale = 1 / np.sqrt(np.diag(matrix))
    try:
        return cholesky(matrix * scale * scale[:, None]) / scale
    except LinAlgError as error:
        raise SolverError(
            "the compliance of incompressible layers is not positive definite: give a Poisson's "
            "ratio of 0.4999, or leave fem out of methods"
        ) from error
