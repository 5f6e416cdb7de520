"""Axisymmetric linear elasticity of high degree on stars of quadrilaterals and the triangles between them.

Functions inside elements are condensed, all elements of one kind and one degree at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from meshes.pressure_space import PressureSpace
from meshes.radial import Array, Indices, snapped
from meshes.stars import StarMesh

from .condensation import symmetric
from .elasticity import LEAST_COMPRESSIBLE
from .hp_numbering import Numbering
from .hp_stiffness import stiffness
from .lobatto import Element
from .trace import Trace


@dataclass(frozen=True, eq=False)
class Batch:
    """All elements of one kind and one degree.

    Parameters
    ----------
    corners : (m, corners, 2) radius and depth
    unknowns : (m, b) radial, then axial unknowns on the boundary of each; one past the last for those left out
    signs : (m, b) of the functions, by the direction of their sides
    """

    element: Element
    degree: int
    corners: Array
    unknowns: Indices
    signs: Array


@dataclass(frozen=True, eq=False)
class HpElasticity:
    """The elastic solid on a mesh with stars; unknowns are the coefficients of all radial, then all axial functions.

    Parameters
    ----------
    mesh : the mesh
    degree : of the displacement in the triangles, at least 2
    given_ratio : Poisson's ratio, up to and including 1/2
    lowest : degree at singular points; from there it rises by one per layer up to `degree`
    """

    mesh: StarMesh
    degree: int
    given_ratio: float
    lowest: int = 3

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that is modelled."""
        return min(self.given_ratio, LEAST_COMPRESSIBLE)

    def coarser(self) -> HpElasticity:
        """The same solid with one shell less in every star, and so one degree lower in every element but the cores."""
        return replace(self, mesh=self.mesh.coarser(), degree=self.degree - 1)

    @cached_property
    def _numbering(self) -> Numbering:
        return Numbering(self.mesh, self.degree, self.lowest)

    @property
    def nodes(self) -> int:
        """Number of functions of vertices and sides; there are twice as many unknowns."""
        return self._numbering.size

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, those inside elements among them."""
        return 2 * (self.nodes + sum(len(batch.corners) * batch.element.inner(batch.degree) for batch in self.batches))

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """(8, m) corners and sides of each element, in one numbering, and (nodes,) the corner or side of each function."""
        return self._numbering.parts

    def boundary(self, name: str) -> Indices:
        """Function numbers on a named boundary, in the order of the radius: vertex, bubbles by degree, vertex, ..."""
        return self._numbering.boundary(name)

    def interpolate(self, name: str, displacement: Callable[[Array], Array]) -> Array:
        """(functions, 2) coefficients on a named boundary, in its order, of a displacement (n, 2) at (n, 2) points."""
        return self._numbering.interpolate(name, displacement)

    def trace(self, breakpoints: Array) -> Trace:
        """Displacements on the contact facets between the breakpoints."""
        return Trace.hierarchical(breakpoints, self._numbering.chain("contact").degrees)

    def pressure_space(self, edges: Array) -> PressureSpace:
        """The pressures on the contact facets: two degrees below the displacement, and at least 1.

        One degree below, near incompressibility, some pressures would have but 2 per cent of their energy.
        """
        degrees = np.maximum(self._numbering.chain("contact").degrees - 2, 1)
        return PressureSpace(snapped(self.mesh.contact_radii, edges), degrees, edges)

    @cached_property
    def batches(self) -> tuple[Batch, ...]:
        """The elements, by kind and degree."""
        made = []
        for group in self._numbering.groups:
            for degree in np.unique(group.degrees):
                chosen = np.flatnonzero(group.degrees == degree)
                functions, signs = self._numbering.functions(group, chosen, int(degree))
                unknowns = np.concatenate([functions, functions + self.nodes], axis=1)
                unknowns[np.tile(functions < 0, 2)] = 2 * self.nodes
                corners = self.mesh.points[group.vertices[chosen]]
                made.append(Batch(group.element, int(degree), corners, unknowns, np.tile(signs, 2)))
        return tuple(made)

    @cached_property
    def condensed(self) -> tuple[tuple[Array, Array], ...]:
        """Of each batch: (m, b, b) stiffness of the boundary, and (m, i, b) coefficients inside by those on it."""
        return tuple(_condensed(batch, self.poisson_ratio) for batch in self.batches)

    def lower_triangle(self, position: Indices) -> coo_matrix:
        """Lower triangle of the stiffness without the insides of elements; entries at one place are to be summed.

        Parameters
        ----------
        position : (2 nodes,) row of each unknown; that of an unknown held at zero is negative
        """
        places = np.append(position, -1).astype(np.int32)
        rows, columns, values = [], [], []
        for batch, (local, _) in zip(self.batches, self.condensed, strict=True):
            width = local.shape[1]
            one, other = np.tril_indices(width)
            own = places[batch.unknowns]
            first, second = own.take(one, axis=1), own.take(other, axis=1)
            column = np.minimum(first, second)
            free = column >= 0
            rows.append(np.maximum(first, second)[free])
            columns.append(column[free])
            values.append(local.reshape(-1, width**2).take(one * width + other, axis=1)[free])
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return coo_matrix(entries, shape=(position.max() + 1,) * 2)

    @cached_property
    def stiffness(self) -> csc_matrix:
        """(2 nodes, 2 nodes) symmetric stiffness without the insides of elements; no boundary condition applied."""
        return symmetric(self.lower_triangle(np.arange(2 * self.nodes)))

    def forces(self, displacement: Array) -> Array:
        """(2 nodes, k) forces on the functions that make the (2 nodes, k) displacements."""
        known = np.concatenate([displacement, np.zeros((1, displacement.shape[1]))])
        held = known.any(axis=1)
        out = np.zeros_like(known)
        for batch, (local, _) in zip(self.batches, self.condensed, strict=True):
            moved = np.asarray(held)[batch.unknowns].any(axis=1)
            unknowns = batch.unknowns[moved]
            np.add.at(out, unknowns, local[moved] @ known[unknowns])
        return out[:-1]


def _condensed(batch: Batch, poisson_ratio: float) -> tuple[Array, Array]:
    whole = stiffness(batch.element, batch.corners, batch.degree, poisson_ratio)
    n, m = batch.element.outer(batch.degree), len(whole)
    b, i = 2 * n, 2 * batch.element.inner(batch.degree)
    boundary = whole[:, :, :n, :, :n].reshape(m, b, b)
    across, inside = whole[:, :, n:, :, :n].reshape(m, i, b), whole[:, :, n:, :, n:].reshape(m, i, i)
    from_boundary = np.asarray(-np.linalg.solve(inside, across), dtype=np.float64)
    boundary += across.transpose(0, 2, 1) @ from_boundary
    signs = batch.signs[:, None, :]
    boundary *= signs
    boundary *= signs.transpose(0, 2, 1)
    from_boundary *= signs
    return boundary, from_boundary
