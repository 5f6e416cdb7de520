"""The axisymmetric elastic solid on any scikit-fem mesh of the half-space.

The degrees of freedom are numbered by scikit-fem. Functions inside elements are condensed, all
elements of one degree at once, before anything is assembled.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import splu
from skfem import Element, ElementQuadP, Mesh
from skfem.assembly import Dofs

from ..meshes.ground.ground import Ground
from ..meshes.half_space import DEEP_SUBDOMAIN, LOWER, facet_ends, radial_ranks, segments
from ..meshes.radial import Array, Indices
from ..meshes.sizes import LOWEST_DISPLACEMENT_DEGREE
from .elements import check_element
from .weak_form import element_of_degree, moduli, stiffness


@dataclass(frozen=True, eq=False)
class Batch:
    """All elements of one degree.

    Parameters
    ----------
    solid : that they belong to
    degree : polynomial degree
    elements : (m,) their numbers in the mesh
    functions : (b + i,) those of the element of highest degree that they use, those inside last
    unknowns : (m, 2 b) radial, then axial unknowns of those that are not inside; one past the last
        if fixed at zero
    inside : (m, i) numbers of those inside
    """

    solid: "AxisymmetricElasticity"
    degree: int
    elements: Indices
    functions: Indices
    unknowns: Indices
    inside: Indices

    @cached_property
    def condensed(self) -> tuple[Array, Array]:
        """Condensed stiffness of the element boundaries, and what recovers the functions inside.

        The first array (m, 2b, 2b) is the stiffness of the functions on the boundary of each
        element. The second array (m, 2i, 2b) maps their coefficients to the coefficients of the
        functions inside.
        """
        solid, b, i = self.solid, self.unknowns.shape[1], 2 * self.inside.shape[1]
        # so many at once that their matrices hold a million numbers
        parts = 1 + len(self.elements) * 9 * len(self.functions) ** 2 // 2**20
        boundary, from_boundary = [], []
        lame, shear = solid.materials
        for elements in np.array_split(self.elements, parts):
            whole = stiffness(
                solid.mesh,
                solid.element,
                self.functions,
                elements,
                self.degree,
                (lame[elements], shear[elements]),
            )
            outer, inner = slice(b // 2), slice(b // 2, None)
            across = whole[:, :, inner, :, outer].reshape(len(elements), i, b)
            inside = whole[:, :, inner, :, inner].reshape(len(elements), i, i)
            from_boundary.append(-np.linalg.solve(inside, across))
            boundary.append(
                whole[:, :, outer, :, outer].reshape(len(elements), b, b)
                + across.transpose(0, 2, 1) @ from_boundary[-1]
            )
        return np.concatenate(boundary), np.concatenate(from_boundary)


@dataclass(frozen=True, eq=False)
class AxisymmetricElasticity:
    """The elastic solid on a mesh.

    Unknowns are all radial, then all axial coefficients, numbered by scikit-fem's `Dofs`.

    In subdomains of the mesh that allow it (`meshes.half_space.LOWER`) the degree is lower. A side
    has the lower degree of its two elements: the functions that exceed it are fixed at zero.

    Parameters
    ----------
    mesh : triangles or turned quadrilaterals, with boundaries named (`meshes.half_space`)
    degree : polynomial degree of the displacement: 1 to 4 on triangles, any on quadrilaterals
    nominal_poisson_ratio : Poisson's ratio, up to and including 1/2
    own_element : an H1 element of scikit-fem's, or of one's own, of that degree along a side
        (`fem.elements`); default `element_of_degree`
    highest_ratio : Poisson's ratio that stands for any from there to 1/2
    ground : layers, whose interfaces are lines of the mesh; homogeneous if there are none
    lowered_degrees : by how much the degree is lower in `meshes.half_space.DEEP_SUBDOMAIN`
    """

    mesh: Mesh
    degree: int
    nominal_poisson_ratio: float
    own_element: Element | None = None
    highest_ratio: float = 0.49999
    lowered_degrees: int = 0
    ground: Ground | None = None

    def __post_init__(self) -> None:
        """Check that an element of one's own goes with the mesh and the degree.

        Raises
        ------
        SceneError
            if it does not, in one line that names what to use
        """
        if self.own_element is not None:
            check_element(self.own_element, self.mesh, self.degree)

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that is modelled: a little less than 1/2 for an incompressible solid.

        With the plane strain modulus given, pressures and displacements on the contact do not
        depend on it, and closer to 1/2 roundoff costs more than it gains. What is inside depends on
        it, in proportion to 1 - 2 nu.
        """
        return min(self.nominal_poisson_ratio, self.highest_ratio)

    @cached_property
    def modelled_ground(self) -> Ground | None:
        """The layers that are modelled, of Poisson's ratios a little less than 1/2."""
        if self.ground is None:
            return None
        return self.ground.with_poisson_ratios_below(self.highest_ratio)

    @cached_property
    def layers(self) -> Indices:
        """(m,) number of the layer that each element lies in; all 0 without layers."""
        if self.ground is None:
            return np.zeros(self.mesh.nelements, dtype=np.int64)
        return self.ground.layer_at(self.mesh.p[1, self.mesh.t].mean(axis=0))

    @cached_property
    def materials(self) -> tuple[Array, Array]:
        """Lame's lambda (m,) and the shear modulus (m,) of each element."""
        if (ground := self.modelled_ground) is None:
            lame, shear = moduli(self.poisson_ratio)
            return np.full(self.mesh.nelements, lame), np.full(self.mesh.nelements, shear)
        ratios = np.array(ground.poisson_ratios)[self.layers]
        shears = np.array(ground.shear_moduli)[self.layers]
        return 2 * shears * ratios / (1 - 2 * ratios), shears

    @property
    def element(self) -> Element:
        """scikit-fem's element of the highest degree, whose `Dofs` number the functions of all."""
        return self.own_element or element_of_degree(self.mesh, self.degree)

    @cached_property
    def dofs(self) -> Dofs:
        """scikit-fem's numbering of all functions, as if every element had the highest degree."""
        return Dofs(self.mesh, self.element)

    @cached_property
    def degrees(self) -> Indices:
        """(m,) degree in each element."""
        out = np.full(self.mesh.nelements, self.degree)
        for name, elements in (self.mesh.subdomains or {}).items():
            if name == DEEP_SUBDOMAIN or name.startswith(LOWER):
                lower = (
                    self.lowered_degrees
                    if name == DEEP_SUBDOMAIN
                    else int(name.removeprefix(LOWER))
                )
                out[elements] = max(
                    min(self.degree, LOWEST_DISPLACEMENT_DEGREE), self.degree - lower
                )
        return out

    @cached_property
    def facet_degrees(self) -> Indices:
        """(facets,) degree along each facet: the lower of its elements'."""
        neighbours = self.mesh.f2t
        return np.where(neighbours < 0, self.degree, self.degrees[neighbours]).min(axis=0)

    @property
    def nodes(self) -> int:
        """Number of functions of vertices and facets, numbered first.

        There are twice as many unknowns.
        """
        return int(self.dofs.N) - int(self.element.interior_dofs) * self.mesh.nelements

    @cached_property
    def fixed(self) -> Indices:
        """(nodes,) whether a function is zero: beside its facet an element has a lower degree."""
        out = np.zeros(self.nodes, dtype=bool)
        if self.degrees.min() < self.degree:
            orders = np.arange(2, self.degree + 1)[:, None]
            out[self.dofs.facet_dofs] = orders > self.facet_degrees
        return out

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, those inside elements among them."""
        return 2 * (
            self.nodes - int(self.fixed.sum()) + sum(batch.inside.size for batch in self.batches)
        )

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """Vertices and facets of each element, and the vertex or facet that each node belongs to.

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
        """The elements by degree."""
        return tuple(self._batch(int(degree)) for degree in np.unique(self.degrees))

    def _batch(self, degree: int) -> Batch:
        corners, sides, count = len(self.mesh.t), len(self.mesh.t2f), int(self.element.facet_dofs)
        elements = np.flatnonzero(self.degrees == degree)
        # the functions of a side come by degree
        neighbours = np.append(np.ones(corners), np.tile(np.arange(count) + 2, sides)) <= degree
        within = np.ones(int(self.element.interior_dofs), dtype=bool)
        if isinstance(self.element, ElementQuadP):
            # products of bubbles. If their two degrees sum to more than 2 above the degree they
            # cost more than they give, but near incompressibility, where stresses need them
            first, second = np.indices((count, count)).reshape(2, -1) + 2
            within = np.maximum(first, second) <= degree
            within &= (first + second <= degree + 2) | (self.nominal_poisson_ratio > 0.45)
        numbers = self.dofs.element_dofs[:, elements].T
        outer, inside = np.flatnonzero(neighbours), len(neighbours) + np.flatnonzero(within)
        unknowns = np.concatenate([numbers[:, outer], numbers[:, outer] + self.nodes], axis=1)
        unknowns[np.tile(self.fixed[numbers[:, outer]], 2)] = 2 * self.nodes
        functions = np.concatenate([outer, inside])
        return Batch(self, degree, elements, functions, unknowns, numbers[:, inside])

    def with_insides(self, displacement: Array) -> Array:
        """Return the coefficients of all functions from the unknowns that are not inside elements.

        `displacement` (2 nodes, states) holds those unknowns. The result (states, dofs, 2) holds
        the radial and axial coefficients of all functions.
        """
        states, values = displacement.shape[1], np.pad(displacement, ((0, 1), (0, 0)))
        out = np.zeros((states, int(self.dofs.N), 2))
        out[:, : self.nodes] = displacement.reshape(2, -1, states).T
        for batch in self.batches:
            _, from_boundary = batch.condensed
            inside = from_boundary @ values[batch.unknowns]
            shape = len(inside), 2, -1, states
            out[:, batch.inside] = inside.reshape(shape).transpose(3, 0, 2, 1)
        return out

    def lower_triangle(self, position: Indices) -> coo_matrix:
        """Lower triangle of the stiffness without the insides of elements.

        Entries at one place are to be summed.

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
        values, *places = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return coo_matrix((values, places), shape=(position.max() + 1,) * 2)

    def forces(self, displacement: Array) -> Array:
        """Return the forces (2 nodes, k) on the functions that make (2 nodes, k) displacements."""
        values = np.pad(displacement, ((0, 1), (0, 0)))
        out = np.zeros_like(values)
        for batch in self.batches:
            local, _ = batch.condensed
            np.add.at(out, batch.unknowns, local @ values[batch.unknowns])
        return out[:-1]

    def boundary(self, name: str) -> Indices:
        """Return the functions on a named boundary that are not fixed, along the radius."""
        mesh, (_, part) = self.mesh, self.parts
        numbers = self.dofs.get_facet_dofs(mesh.boundaries[name]).flatten()
        numbers = numbers[~self.fixed[numbers]]
        ranks = radial_ranks(mesh)
        order = np.append(ranks, ranks[mesh.facets].mean(axis=0))[part[numbers]]
        return np.asarray(numbers[np.argsort(order, kind="stable")], dtype=np.int64)

    def interpolate(self, name: str, fields: Callable[[Array], Array]) -> Array:
        """Return the coefficients of fields on the functions of a named boundary.

        The coefficients (functions, ...) are in the order of `boundary`. `fields` returns the
        values (n, ...) of the fields at points (n, 2).

        Least squares at as many points of each facet as it has functions, both ends among them: an
        interpolation.
        """
        facets = self.mesh.boundaries[name]
        local = (1 - np.cos(np.pi * np.arange(self.degree + 1) / self.degree)) / 2
        basis = self.trace(facets, local)[:, self.boundary(name)]
        start, end = segments(self.mesh, facets)[:, :, None].swapaxes(0, 1)
        values = fields((start + local[:, None] * (end - start)).reshape(-1, 2))
        coefficients = splu((basis.T @ basis).tocsc()).solve(
            basis.T @ values.reshape(len(values), -1)
        )
        return np.asarray(coefficients.reshape(-1, *values.shape[1:]))

    def trace(self, facets: Indices, local: Array) -> csr_matrix:
        """Return the values of all nodes' functions at local coordinates on facets of the boundary.

        The matrix has the shape (facets x points, nodes).

        Evaluated on the sides of the reference element: `FacetBasis` inverts the mapping by
        Newton's method, which does not end on elements smaller than its tolerance. Local
        coordinates run from 0, at the end nearer to the axis, to 1.
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
