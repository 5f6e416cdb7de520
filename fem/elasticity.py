"""The axisymmetric elastic solid on any scikit-fem mesh of the half-space.

The degrees of freedom are numbered by scikit-fem. Before the assembly, the functions inside
elements are condensed for all elements of one degree at once.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import splu
from skfem import Element, ElementQuadP, Mesh
from skfem.assembly import Dofs

from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.half_space import (
    DEEP_SUBDOMAIN,
    LOWERED_DEGREE_PREFIX,
    facet_ends,
    radial_ranks,
    segments,
)
from ..meshes.radial import Array, Indices
from ..meshes.sizes import LOWEST_DISPLACEMENT_DEGREE
from .elements import check_element
from .incompressibility import HIGHEST_RATIO, more_compressible_ratio
from .weak_form import element_of_degree, stiffness


@dataclass(frozen=True, eq=False)
class Batch:
    """All elements of one polynomial degree.

    Parameters
    ----------
    solid : the elastic solid that contains the elements
    degree : polynomial degree
    elements : (m,) numbers of the elements in the mesh
    functions : (b + i,) the functions used, as numbers of the local functions of the element of
        highest degree; functions inside the element come last
    unknowns : (m, 2 b) radial, then axial unknowns of the functions on the element boundary;
        unknowns that are fixed at zero have a number one past the last
    inside : (m, i) numbers of the functions inside the element
    """

    solid: "AxisymmetricElasticity"
    degree: int
    elements: Indices
    functions: Indices
    unknowns: Indices
    inside: Indices

    @cached_property
    def condensed(self) -> tuple[Array, Array]:
        """Condensed stiffness of element boundaries, and a map that recovers the functions inside.

        The first array (m, 2b, 2b) is the condensed stiffness of the functions on the boundary of
        each element. The second array (m, 2i, 2b) maps their coefficients to the coefficients of
        the functions inside.
        """
        solid, b, i = self.solid, self.unknowns.shape[1], 2 * self.inside.shape[1]
        # elements are processed in groups whose matrices hold a million numbers
        group_count = 1 + len(self.elements) * 9 * len(self.functions) ** 2 // 2**20
        boundary, from_boundary = [], []
        lame, shear = solid.materials
        for elements in np.array_split(self.elements, group_count):
            element_stiffness = stiffness(
                solid.mesh,
                solid.element,
                self.functions,
                elements,
                self.degree,
                (lame[elements], shear[elements]),
            )
            on_boundary, in_interior = slice(b // 2), slice(b // 2, None)
            coupling = element_stiffness[:, :, in_interior, :, on_boundary].reshape(
                len(elements), i, b
            )
            inner_stiffness = element_stiffness[:, :, in_interior, :, in_interior].reshape(
                len(elements), i, i
            )
            from_boundary.append(-np.linalg.solve(inner_stiffness, coupling))
            boundary.append(
                element_stiffness[:, :, on_boundary, :, on_boundary].reshape(len(elements), b, b)
                + coupling.transpose(0, 2, 1) @ from_boundary[-1]
            )
        return np.concatenate(boundary), np.concatenate(from_boundary)


@dataclass(frozen=True, eq=False)
class AxisymmetricElasticity:
    """The elastic solid on a mesh.

    The unknowns are all radial coefficients, then all axial coefficients, numbered by scikit-fem's
    `Dofs`.

    In mesh subdomains whose name is `meshes.half_space.LOWERED_DEGREE_PREFIX` followed by a number,
    the degree is lower by that number. A side has the lower of the degrees of its two elements:
    functions of a higher degree are fixed at zero.

    Parameters
    ----------
    mesh : triangles or reoriented quadrilaterals, with named boundaries (`meshes.half_space`)
    degree : polynomial degree of the displacement: 1 to 4 on triangles, any on quadrilaterals
    ground : layers, whose interfaces are lines of the mesh; Poisson's ratios may be 1/2
    own_element : an H1 element of scikit-fem or of the user, of that degree along a side
        (`fem.elements`); default `element_of_degree`
    highest_ratio : Poisson's ratio that replaces all values between it and 1/2
    lowered_degrees : by how much the degree is lower in `meshes.half_space.DEEP_SUBDOMAIN`
    """

    mesh: Mesh
    degree: int
    ground: Ground = HALF_SPACE
    own_element: Element | None = None
    highest_ratio: float = HIGHEST_RATIO
    lowered_degrees: int = 0

    def __post_init__(self) -> None:
        """Check that the user's element fits the mesh and the degree.

        Raises
        ------
        SceneError
            if it does not; the message names usable elements
        """
        if self.own_element is not None:
            check_element(self.own_element, self.mesh, self.degree)

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the model at the surface: less than 1/2 for incompressible solids."""
        return self.modelled_ground.poisson_ratios[0]

    @cached_property
    def modelled_ground(self) -> Ground:
        """The ground of the model, with Poisson's ratios of at most `highest_ratio`.

        For a given plane strain modulus, pressures and displacements on the contact do not depend
        on Poisson's ratio of a homogeneous half-space. Those on layers and the fields inside do
        (`more_compressible`).
        """
        return self.ground.with_poisson_ratios_below(self.highest_ratio)

    @property
    def more_compressible(self) -> "AxisymmetricElasticity | None":
        """The second solid of an extrapolation to the nominal Poisson's ratios.

        None if the model has the nominal ratios.
        """
        if self.ground == self.modelled_ground:
            return None
        ratios = zip(self.modelled_ground.poisson_ratios, self.ground.poisson_ratios, strict=True)
        farther = list(itertools.starmap(more_compressible_ratio, ratios))
        return replace(self, ground=self.ground.with_poisson_ratios(farther))

    @cached_property
    def layers(self) -> Indices:
        """(m,) number of the layer that contains each element."""
        return self.ground.layer_at(self.mesh.p[1, self.mesh.t].mean(axis=0))

    @cached_property
    def materials(self) -> tuple[Array, Array]:
        """Lame's lambda (m,) and the shear modulus (m,) of each element."""
        ratios = np.array(self.modelled_ground.poisson_ratios)[self.layers]
        shears = np.array(self.modelled_ground.shear_moduli)[self.layers]
        return 2 * shears * ratios / (1 - 2 * ratios), shears

    @property
    def element(self) -> Element:
        """scikit-fem's element of the highest degree, whose `Dofs` number all functions."""
        return self.own_element or element_of_degree(self.mesh, self.degree)

    @cached_property
    def dofs(self) -> Dofs:
        """scikit-fem's numbering of the functions, as if all elements had the highest degree."""
        return Dofs(self.mesh, self.element)

    @cached_property
    def degrees(self) -> Indices:
        """(m,) degree in each element."""
        out = np.full(self.mesh.nelements, self.degree)
        for name, elements in (self.mesh.subdomains or {}).items():
            if name == DEEP_SUBDOMAIN or name.startswith(LOWERED_DEGREE_PREFIX):
                lower = (
                    self.lowered_degrees
                    if name == DEEP_SUBDOMAIN
                    else int(name.removeprefix(LOWERED_DEGREE_PREFIX))
                )
                out[elements] = max(
                    min(self.degree, LOWEST_DISPLACEMENT_DEGREE), self.degree - lower
                )
        return out

    @cached_property
    def facet_degrees(self) -> Indices:
        """(facets,) degree along each facet: the lower of the degrees of its elements."""
        neighbours = self.mesh.f2t
        return np.where(neighbours < 0, self.degree, self.degrees[neighbours]).min(axis=0)

    @property
    def nodes(self) -> int:
        """Number of functions at vertices and on facets, which are numbered before those inside.

        The number of unknowns at these nodes is twice as large.
        """
        return int(self.dofs.N) - int(self.element.interior_dofs) * self.mesh.nelements

    @cached_property
    def fixed(self) -> Indices:
        """(nodes,) whether a function is fixed at zero, as is the case next to a lower degree."""
        out = np.zeros(self.nodes, dtype=bool)
        if self.degrees.min() < self.degree:
            orders = np.arange(2, self.degree + 1)[:, None]
            out[self.dofs.facet_dofs] = orders > self.facet_degrees
        return out

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, including those inside elements."""
        return 2 * (
            self.nodes - int(self.fixed.sum()) + sum(batch.inside.size for batch in self.batches)
        )

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """Vertices and facets of each element, and the vertex or facet of each node.

        The first array (p, m) lists the p vertices and facets of each of the m elements in one
        numbering, all vertices first. The second array (nodes,) gives the vertex or facet of each
        node in the same numbering.
        """
        mesh = self.mesh
        per_part = np.repeat([1, int(self.element.facet_dofs)], [mesh.nvertices, mesh.nfacets])
        return np.concatenate([mesh.t, mesh.nvertices + mesh.t2f]), np.repeat(
            np.arange(len(per_part)), per_part
        )

    @cached_property
    def batches(self) -> tuple[Batch, ...]:
        """The elements, grouped by degree."""
        return tuple(self._batch(int(degree)) for degree in np.unique(self.degrees))

    def _batch(self, degree: int) -> Batch:
        corners, sides, count = len(self.mesh.t), len(self.mesh.t2f), int(self.element.facet_dofs)
        elements = np.flatnonzero(self.degrees == degree)
        # the functions of a side are ordered by degree
        on_boundary = np.append(np.ones(corners), np.tile(np.arange(count) + 2, sides)) <= degree
        is_used_inside = np.ones(int(self.element.interior_dofs), dtype=bool)
        if isinstance(self.element, ElementQuadP):
            # Functions inside are products of bubbles. Those whose two degrees sum to more than
            # degree + 2 cost more than they gain in accuracy. They are kept near incompressibility,
            # where stresses need them.
            near_incompressible = self.ground.greatest_poisson_ratio > 0.45
            first, second = np.indices((count, count)).reshape(2, -1) + 2
            is_used_inside = np.maximum(first, second) <= degree
            is_used_inside &= (first + second <= degree + 2) | near_incompressible
        numbers = self.dofs.element_dofs[:, elements].T
        outer, inside = (
            np.flatnonzero(on_boundary),
            len(on_boundary) + np.flatnonzero(is_used_inside),
        )
        unknowns = np.concatenate([numbers[:, outer], numbers[:, outer] + self.nodes], axis=1)
        unknowns[np.tile(self.fixed[numbers[:, outer]], 2)] = 2 * self.nodes
        functions = np.concatenate([outer, inside])
        return Batch(self, degree, elements, functions, unknowns, numbers[:, inside])

    def with_insides(self, displacement: Array) -> Array:
        """Return the coefficients of all functions, computed from those at the nodes.

        `displacement` (2 nodes, states) holds the unknowns of vertices and facets. The result
        (states, dofs, 2) holds the radial and axial coefficients of all functions, including those
        inside elements.
        """
        states, values = displacement.shape[1], np.pad(displacement, ((0, 1), (0, 0)))
        out = np.zeros((states, int(self.dofs.N), 2))
        out[:, : self.nodes] = displacement.reshape(2, -1, states).T
        for batch in self.batches:
            _, from_boundary = batch.condensed
            inner_coefficients = from_boundary @ values[batch.unknowns]
            shape = len(inner_coefficients), 2, -1, states
            out[:, batch.inside] = inner_coefficients.reshape(shape).transpose(3, 0, 2, 1)
        return out

    def lower_triangle(self, position: Indices) -> coo_matrix:
        """Assemble the lower triangle of the stiffness after condensation of the functions inside.

        Duplicate entries are to be summed.

        Parameters
        ----------
        position : (2 nodes,) row of each unknown; negative if it is fixed at zero
        """
        row = np.append(position, -1).astype(np.int32)
        entries = []
        for batch in self.batches:
            local, _ = batch.condensed
            width = local.shape[1]
            lower = np.flatnonzero(np.tri(width))
            first, second = (row[batch.unknowns].take(at, axis=1) for at in divmod(lower, width))
            column = np.minimum(first, second)
            free = column >= 0
            values = local.reshape(-1, width**2).take(lower, axis=1)[free]
            entries.append((values, np.maximum(first, second)[free], column[free]))
        values, *places = (np.concatenate(arrays) for arrays in zip(*entries, strict=True))
        return coo_matrix((values, places), shape=(position.max() + 1,) * 2)

    def forces(self, displacement: Array) -> Array:
        """Return the forces (2 nodes, k) that cause the displacements (2 nodes, k)."""
        values = np.pad(displacement, ((0, 1), (0, 0)))
        out = np.zeros_like(values)
        for batch in self.batches:
            local, _ = batch.condensed
            np.add.at(out, batch.unknowns, local @ values[batch.unknowns])
        return out[:-1]

    def boundary(self, name: str) -> Indices:
        """Return the functions on a named boundary that are not fixed, ordered by radius."""
        mesh, (_, vertex_or_facet) = self.mesh, self.parts
        numbers = self.dofs.get_facet_dofs(mesh.boundaries[name]).flatten()
        numbers = numbers[~self.fixed[numbers]]
        ranks = radial_ranks(mesh)
        order = np.append(ranks, ranks[mesh.facets].mean(axis=0))[vertex_or_facet[numbers]]
        return np.asarray(numbers[np.argsort(order, kind="stable")], dtype=np.int64)

    def interpolate(self, name: str, fields: Callable[[Array], Array]) -> Array:
        """Return the coefficients that interpolate fields on a named boundary.

        Parameters
        ----------
        name : name of the boundary
        fields : function that returns values (n, ...) at points (n, 2)

        Returns
        -------
        (functions, ...) array
            In the order of `boundary`.

        Notes
        -----
        The coefficients follow from least squares at points on each facet, including both ends.
        Each facet has as many points as functions, so that this is an interpolation.
        """
        facets = self.mesh.boundaries[name]
        local = (1 - np.cos(np.pi * np.arange(self.degree + 1) / self.degree)) / 2
        basis = self.trace(facets, local)[:, self.boundary(name)]
        start, end = segments(self.mesh, facets)[:, :, None].swapaxes(0, 1)
        values = fields((start + local[:, None] * (end - start)).reshape(-1, 2))
        coefficients = splu((basis.T @ basis).tocsc()).solve(
            basis.T @ values.reshape(len(values), -1)
        )
        return coefficients.reshape(-1, *values.shape[1:])

    def trace(self, facets: Indices, local: Array) -> csr_matrix:
        """Return the values of all nodes' functions at points on facets of the boundary.

        Parameters
        ----------
        facets : numbers of the facets
        local : local coordinates of the points on each facet, from 0 at the end nearer to the axis
            to 1

        Returns
        -------
        (facets x points, nodes) sparse matrix

        Notes
        -----
        The functions are evaluated on the sides of the reference element. scikit-fem's `FacetBasis`
        would invert the mapping by Newton's method, which does not terminate on elements smaller
        than its tolerance.
        """
        mesh, reference = self.mesh, self.element.refdom
        element = mesh.f2t[0, facets]
        side = (mesh.t2f[:, element] == facets).argmax(axis=0)
        ends = np.array(reference.facets)[side].T
        inwards = mesh.t[ends[0], element] != facet_ends(mesh, facets)[0]
        start, end = reference.p[:, np.where(inwards, ends[::-1], ends)].swapaxes(0, 1)[..., None]
        points = (start + (end - start) * local).reshape(2, -1)
        numbers = self.dofs.element_dofs[:, element]
        outer = np.flatnonzero((numbers < self.nodes).all(axis=1))
        values = [self.element.lbasis(points, function)[0] for function in outer]
        rows, columns = np.arange(points.shape[1]), np.repeat(numbers[outer], len(local), axis=1)
        places = np.tile(rows, len(outer)), columns.ravel()
        return csr_matrix((np.concatenate(values), places), (len(rows), self.nodes))
