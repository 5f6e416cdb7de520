"""The axisymmetric elastic solid on any scikit-fem mesh of the half-space, its degrees of freedom
numbered by scikit-fem.

Functions inside elements are condensed, all elements of one degree at once, before anything is
assembled.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import splu
from skfem import Element, ElementQuadP, Mesh
from skfem.assembly import Dofs

from ..meshes.half_space import DEEP, LOWER, facet_ends, segments
from ..meshes.radial import Array, Indices
from ..meshes.sizes import LOWEST
from .condensation import symmetric
from .weak_form import element_of_degree, stiffness, tables


@lru_cache(maxsize=1024)
def _side_table(element: Element, side: int, outwards: bool, local: bytes, slope: bool) -> Array:
    """(functions, q) values, or slopes, of the functions of one side of the reference element at
    coordinates along it.
    """
    refdom, along, count = element.refdom, np.frombuffer(local), int(element.facet_dofs)
    ends = list(refdom.facets[side])
    start, end = refdom.p.T[ends if outwards else ends[::-1]]
    value, gradient = tables(element, start[:, None] + (end - start)[:, None] * along)
    functions = np.append(ends, refdom.p.shape[1] + side * count + np.arange(count))
    return (np.einsum("nxq,x->nq", gradient, end - start) if slope else value)[functions]


@dataclass(frozen=True, eq=False)
class Batch:
    """All elements of one degree.

    Parameters
    ----------
    element : scikit-fem's element of that degree
    elements : (m,) their numbers in the mesh
    degree : polynomial degree
    functions : (b + i,) the element's functions that are used, those inside it last
    unknowns : (m, 2 b) radial, then axial unknowns of those that are not inside; one past the last
        if fixed at zero
    inside : (m, i) numbers of those inside
    """

    element: Element
    elements: Indices
    degree: int
    functions: Indices
    unknowns: Indices
    inside: Indices


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
    given_ratio : Poisson's ratio, up to and including 1/2
    own_element : an H1 element of scikit-fem's, or of one's own, of that degree along a side;
        default `element_of_degree`
    highest_ratio : Poisson's ratio that stands for any from there to 1/2
    spared : how much lower the degree is in the subdomain `meshes.half_space.DEEP`
    """

    mesh: Mesh
    degree: int
    given_ratio: float
    own_element: Element | None = None
    highest_ratio: float = 0.49999
    spared: int = 0

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that is modelled: a little less than 1/2 for an incompressible solid.

        With the plane strain modulus given, pressures and displacements on the contact do not
        depend on it, and closer to 1/2 roundoff costs more than it gains. What is inside depends on
        it, in proportion to 1 - 2 nu.
        """
        return min(self.given_ratio, self.highest_ratio)

    @property
    def element(self) -> Element:
        """scikit-fem's element of the highest degree, whose `Dofs` number the functions of all."""
        return self.own_element or element_of_degree(self.mesh, self.degree)

    def _element(self, degree: int) -> Element:
        return self.element if degree == self.degree else element_of_degree(self.mesh, degree)

    @cached_property
    def dofs(self) -> Dofs:
        return Dofs(self.mesh, self.element)

    @property
    def facet_dofs(self) -> Indices:
        """(degree - 1, facets) functions of the facets, by degree."""
        numbers = self.dofs.facet_dofs if self.degree > 1 else np.empty((0, self.mesh.nfacets))
        return np.asarray(numbers, dtype=np.int64)

    @cached_property
    def degrees(self) -> Indices:
        """(m,) degree in each element."""
        out = np.full(self.mesh.nelements, self.degree)
        for name, elements in (self.mesh.subdomains or {}).items():
            if name == DEEP or name.startswith(LOWER):
                lower = self.spared if name == DEEP else int(name.removeprefix(LOWER))
                out[elements] = max(min(self.degree, LOWEST), self.degree - lower)
        return out

    @cached_property
    def facet_degrees(self) -> Indices:
        """(facets,) degree along each facet: the lower of its elements'."""
        beside = self.mesh.f2t
        return np.where(beside < 0, self.degree, self.degrees[beside]).min(axis=0)

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
            out[self.facet_dofs] = np.arange(2, self.degree + 1)[:, None] > self.facet_degrees
        return out

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, those inside elements among them."""
        return 2 * (
            self.nodes - int(self.fixed.sum()) + sum(batch.inside.size for batch in self.batches)
        )

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """Vertices and facets of each element (p, m), in one numbering, and the vertex or facet of
        each node (nodes,).
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
        element = self._element(degree)
        elements = np.flatnonzero(self.degrees == degree)
        corners, sides = self.mesh.t.shape[0], self.mesh.t2f.shape[0]
        outer = corners + sides * int(element.facet_dofs)
        inside = np.arange(int(element.interior_dofs))
        among_highest = inside
        if isinstance(element, ElementQuadP):
            # products of bubbles, and where they stand among those of the highest degree. If their
            # two degrees sum to more than 2 above the degree they cost more than they give, but
            # near incompressibility, where stresses need them
            first, second = np.divmod(inside, degree - 1)
            used = (first + second + 4 <= degree + 2) | (self.given_ratio > 0.45)
            inside, among_highest = inside[used], (first * (self.degree - 1) + second)[used]
        # the functions of a facet come by degree
        on_sides = np.arange(sides)[:, None] * int(self.element.facet_dofs) + np.arange(
            int(element.facet_dofs)
        )
        numbers = self.dofs.element_dofs[np.append(np.arange(corners), corners + on_sides)][
            :, elements
        ].T
        unknowns = np.concatenate([numbers, numbers + self.nodes], axis=1)
        unknowns[np.tile(self.fixed[numbers], 2)] = 2 * self.nodes
        functions = np.append(np.arange(outer), outer + inside)
        within = self.dofs.interior_dofs[among_highest][:, elements].T
        return Batch(element, elements, degree, functions, unknowns, within)

    @cached_property
    def condensed(self) -> tuple[tuple[Array, Array], ...]:
        """Of each batch.

        (m, 2b, 2b) stiffness of the boundary, and (m, 2i, 2b) coefficients inside by those on it.
        """
        return tuple(self._condensed(batch) for batch in self.batches)

    def _condensed(self, batch: Batch) -> tuple[Array, Array]:
        (m, b), i = batch.unknowns.shape, 2 * batch.inside.shape[1]
        n = b // 2
        boundary, from_boundary = np.empty((m, b, b)), np.empty((m, i, b))
        # so many at once that their matrices hold a million numbers
        at_once = max(1, 2**20 // (9 * len(batch.functions) ** 2))
        for start in range(0, m, at_once):
            few = slice(start, start + at_once)
            elements = batch.elements[few]
            whole = stiffness(
                self.mesh,
                batch.element,
                batch.functions,
                elements,
                batch.degree,
                self.poisson_ratio,
            )
            k = len(whole)
            across = whole[:, :, n:, :, :n].reshape(k, i, b)
            inside = whole[:, :, n:, :, n:].reshape(k, i, i)
            from_boundary[few] = -np.linalg.solve(inside, across)
            boundary[few] = whole[:, :, :n, :, :n].reshape(k, b, b)
            boundary[few] += across.transpose(0, 2, 1) @ from_boundary[few]
        return boundary, from_boundary

    def with_insides(self, displacement: Array) -> Array:
        """(states, dofs, 2) coefficients of all functions, by (states, nodes, 2) ones of those not
        inside elements.
        """
        states = len(displacement)
        out = np.zeros((states, int(self.dofs.N), 2))
        out[:, : self.nodes] = displacement
        values = np.concatenate([*np.moveaxis(displacement, 2, 0), np.zeros((states, 1))], axis=1)
        for batch, (_, from_boundary) in zip(self.batches, self.condensed, strict=True):
            outer = values[:, batch.unknowns]
            inside = np.einsum("mib,smb->smi", from_boundary, outer, optimize=True)
            out[:, batch.inside] = np.stack(np.split(inside, 2, axis=2), axis=-1)
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
        for batch, (local, _) in zip(self.batches, self.condensed, strict=True):
            width = local.shape[1]
            lower = np.flatnonzero(np.tri(width))
            first, second = (row[batch.unknowns].take(at, axis=1) for at in divmod(lower, width))
            column = np.minimum(first, second)
            free = column >= 0
            values = local.reshape(-1, width**2).take(lower, axis=1)[free]
            entries.append((values, np.maximum(first, second)[free], column[free]))
        values, *places = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return coo_matrix((values, places), shape=(position.max() + 1,) * 2)

    @cached_property
    def stiffness(self) -> csc_matrix:
        """(2 nodes, 2 nodes) symmetric stiffness without the insides of elements.

        No boundary condition applied.
        """
        return symmetric(self.lower_triangle(np.arange(2 * self.nodes)))

    def forces(self, displacement: Array) -> Array:
        """(2 nodes, k) forces on the functions that make the (2 nodes, k) displacements."""
        values = np.pad(displacement, ((0, 1), (0, 0)))
        moving = values.any(axis=1)
        out = np.zeros_like(values)
        for batch, (local, _) in zip(self.batches, self.condensed, strict=True):
            moved = np.take(moving, batch.unknowns).any(axis=1)
            unknowns = batch.unknowns[moved]
            np.add.at(out, unknowns, local[moved] @ values[unknowns])
        return out[:-1]

    def boundary(self, name: str) -> Indices:
        """Functions on a named boundary that are not fixed, in the order of the radius."""
        mesh, facets = self.mesh, self.mesh.boundaries[name]
        vertices = np.unique(mesh.facets[:, facets])
        on_facets = self.facet_dofs[:, facets]
        middle = np.broadcast_to(mesh.p[0, mesh.facets[:, facets]].mean(axis=0), on_facets.shape)
        numbers = np.concatenate([self.dofs.nodal_dofs[0, vertices], on_facets.T.ravel()])
        radius = np.concatenate([mesh.p[0, vertices], middle.T.ravel()])
        numbers = numbers[np.argsort(radius, kind="stable")]
        return np.asarray(numbers[~self.fixed[numbers]], dtype=np.int64)

    def interpolate(self, name: str, fields: Callable[[Array], Array]) -> Array:
        """(functions, ...) coefficients of fields on a named boundary, in its order, by values (n,
        ...) at (n, 2) points.

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

    def trace(self, facets: Indices, local: Array, slope: bool = False) -> csr_matrix:
        """(facets x points, nodes) values, or slopes along the facet, at local coordinates on
        facets of the boundary.

        Evaluated on the sides of the reference element: `FacetBasis` inverts the mapping by
        Newton's method, which does not end on elements smaller than its tolerance. Local
        coordinates run from 0, at the end nearer to the axis, to 1.
        """
        mesh = self.mesh
        element = mesh.f2t[0, facets]
        side = (mesh.t2f[:, element] == facets).argmax(axis=0)
        ends = mesh.t[np.array(self.element.refdom.facets)[side].T, element]
        outwards = ends[0] == facet_ends(mesh, facets)[0]
        lengths = np.linalg.norm(mesh.p[:, ends[1]] - mesh.p[:, ends[0]], axis=0)
        scale = 1 / lengths if slope else np.ones_like(lengths)
        entries = []
        kinds, kind = np.unique(
            np.stack([side, outwards, self.facet_degrees[facets]]), axis=1, return_inverse=True
        )
        for number, (edge, outward, degree) in enumerate(kinds.T.tolist()):
            chosen = np.flatnonzero(kind == number)
            table = _side_table(self._element(degree), edge, bool(outward), local.tobytes(), slope)
            on_facets = self.facet_dofs[: degree - 1, facets[chosen]]
            columns = np.concatenate([self.dofs.nodal_dofs[0, ends[:, chosen]], on_facets]).T[
                :, None
            ]
            rows = chosen[:, None, None] * len(local) + np.arange(len(local))[:, None]
            parts = np.broadcast_arrays(scale[chosen, None, None] * table.T, rows, columns)
            entries.append([part.ravel() for part in parts])
        values, *places = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return csr_matrix((values, places), shape=(len(facets) * len(local), self.nodes))
