"""Cells for a contact that opens, closes and spreads.

Small at ring edges, at the rim and where contact begins.

Sizes are known before any mesh is, and vary by no more than a given growth with the distance, so
that the contact line of a mesh of the half-space can follow the same field as a radial mesh.
Lengths in punch radii.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from .pressure_space import PressureSpace
from .radial import Array, layer_degrees, layers
from .sizes import SizeField


@dataclass(frozen=True)
class ContactCells:
    """The wanted size of cells at each radius.

    Parameters
    ----------
    ring_edges : ring edges, 0 first and 1 (the rim) last
    largest : greatest size
    edge_size : size at ring edges and rim
    growth : growth of the size with the distance from them
    spread : growth of the size with the distance from where contact begins
    spots : where it does, and the size there: (inner radius, outer radius, size)
    """

    ring_edges: tuple[float, ...]
    largest: float
    edge_size: float
    growth: float = 0.4
    spread: float = 0.2
    spots: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, radii: Array) -> Array:
        """Sizes at radii, of any shape."""
        size = np.full(np.shape(radii), self.largest)
        for edge in self.ring_edges[1:]:
            size = np.minimum(size, self.edge_size + self.growth * np.abs(radii - edge))
        for inner, outer, smallest in self.spots:
            away = np.maximum(np.maximum(inner - radii, radii - outer), 0.0)
            size = np.minimum(size, smallest + self.spread * away)
        return size

    def breakpoints(self) -> Array:
        """Cells of a radial mesh.

        As many in each ring as the integral of one over their size, made even.
        """
        pieces = [np.zeros(1)]
        for inner, outer in zip(self.ring_edges[:-1], self.ring_edges[1:], strict=True):
            width = outer - inner
            # fine enough to integrate one over the size: crowded at both ends, as the size is
            depth = np.geomspace(1e-3 * min(self.edge_size, width), width / 2, 400)
            spots = [r for spot in self.spots for r in spot[:2]]
            marks = np.concatenate(
                [inner + depth, outer - depth, np.linspace(inner, outer, 401), spots]
            )
            fine = np.unique(marks[(marks >= inner) & (marks <= outer)])
            density = 1 / self(fine)
            along = np.concatenate(
                [[0.0], np.cumsum(np.diff(fine) * (density[1:] + density[:-1]) / 2)]
            )
            count = max(4, 2 * int(np.ceil(along[-1] / 2)))
            inside = np.interp(np.arange(1, count) * along[-1] / count, along, fine)
            pieces.append(np.append(inside, outer))
        return np.concatenate(pieces)

    def space(self) -> PressureSpace:
        """Continuous piecewise linear pressures, broken at ring edges."""
        breakpoints = self.breakpoints()
        degrees = np.ones(len(breakpoints) - 1, dtype=np.int64)
        return PressureSpace(breakpoints, degrees, np.array(self.ring_edges))


@dataclass(frozen=True)
class ContactSizeField(SizeField):
    """Sizes of triangles whose contact line follows the cells; inside the half-space they grow."""

    cells: ContactCells | None = None

    def __call__(self, points: Array) -> Array:
        """(n,) sizes at (n, 2) points."""
        size = super().__call__(points)
        if self.cells is None:
            return size
        radius, depth = points.T
        on_contact = self.cells(np.minimum(radius, 1.0)) + self.growth * np.hypot(
            depth, np.maximum(radius - 1.0, 0.0)
        )
        return np.minimum(size, on_contact)


def contact_mesh_field(cells: ContactCells, growth: float, truncation: float) -> ContactSizeField:
    """The size field of a mesh on those cells."""
    inside = len(cells.ring_edges) - 2
    return ContactSizeField(
        cells.ring_edges,
        cells.edge_size,
        (cells.edge_size,) * inside,
        growth,
        truncation,
        cells.largest,
        0.125,
        cells,
    )


# of a mesh fitted to the edges of a contact: size ratio of neighbours, and sizes at the axis, where
# a cone's pressure is infinite as a logarithm, at edges where the pressure falls to zero as a root,
# and where it is infinite as one
FACTOR, AT_AXIS, AT_FREE, AT_CORNER = 0.2, 1e-5, 1e-7, 1e-10


def fitted_space(
    edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int
) -> PressureSpace:
    """Pressures of high degree, graded to the axis and to every edge.

    Parameters
    ----------
    edges : from 0 to 1; the space is broken at each
    infinite : at which of them the pressure is infinite
    degree : highest; at edges it is 2
    """
    sizes = [AT_AXIS, *(AT_CORNER if one else AT_FREE for one in infinite[1:])]
    pieces = [np.zeros(1)]
    for (inner, outer), (at_inner, at_outer) in zip(
        itertools.pairwise(edges), itertools.pairwise(sizes), strict=True
    ):
        half = (outer - inner) / 2
        pieces += [
            inner + layers(half, at_inner, FACTOR)[:0:-1],
            outer - layers(half, at_outer, FACTOR),
            np.array([outer]),
        ]
    breakpoints = np.concatenate(pieces)
    return PressureSpace(
        breakpoints, layer_degrees(breakpoints, edges, degree, rise=1.0, lowest=2), np.array(edges)
    )
