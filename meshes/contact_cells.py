"""Cells for a contact that opens, closes and spreads, and the space fitted to one that is known.

Cells are small at ring edges, at the rim and where contact begins. Sizes vary by no more than a
given growth with the distance, so that the contact line of a mesh of the half-space can follow the
same field as a radial mesh. Lengths in punch radii.
"""

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .pressure_space import PressureSpace
from .radial import Array, graded_breakpoints, layer_degrees

# points of the grid on which 1 / size is integrated, towards an end of a ring or a free edge
GRID_POINTS = 400


class FreeEdge(NamedTuple):
    """Cells beside an edge of the first contact that lies within the face.

    Pressures may be nearly infinite there.

    Parameters
    ----------
    radius : of the edge
    size : of the cells at the edge
    growth_below, growth_above : growth of the size with the distance, on the side of the axis and
        on that of the rim
    """

    radius: float
    size: float
    growth_below: float
    growth_above: float

    def sizes(self, radii: Array) -> Array:
        """Return the greatest size at radii that this edge allows."""
        distance = radii - self.radius
        growth = np.where(distance < 0, self.growth_below, self.growth_above)
        return np.asarray(self.size + growth * np.abs(distance))

    def scaled(self, factor: float) -> "FreeEdge":
        """Return the same edge with cells larger by a factor everywhere."""
        return FreeEdge(
            self.radius,
            factor * self.size,
            factor * self.growth_below,
            factor * self.growth_above,
        )


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
    free_edges : edges of the first contact that need smaller cells
    hollow : whether the first ring is a hole, on which nothing presses
    """

    ring_edges: tuple[float, ...]
    largest: float
    edge_size: float
    growth: float = 0.4
    spread: float = 0.2
    spots: tuple[tuple[float, float, float], ...] = ()
    free_edges: tuple[FreeEdge, ...] = ()
    hollow: bool = False

    def __call__(self, radii: Array) -> Array:
        """Sizes at radii, of any shape."""
        size = np.full(np.shape(radii), self.largest)
        for ring_edge in self.ring_edges[1:]:
            size = np.minimum(size, self.edge_size + self.growth * np.abs(radii - ring_edge))
        for inner, outer, smallest in self.spots:
            away = np.maximum(np.maximum(inner - radii, radii - outer), 0.0)
            size = np.minimum(size, smallest + self.spread * away)
        for edge in self.free_edges:
            size = np.minimum(size, edge.sizes(radii))
        return size

    def breakpoints(self) -> Array:
        """Return the cells of a radial mesh: in each ring the integral of 1 / size, made even."""
        pieces = [np.zeros(1)]
        for inner, outer in itertools.pairwise(self.ring_edges):
            width = outer - inner
            # fine enough to integrate 1 / size: crowded at both ends, where sizes are small
            depth = np.geomspace(1e-3 * min(self.edge_size, width), width / 2, GRID_POINTS)
            spots = [r for spot in self.spots for r in spot[:2]]
            for edge in self.free_edges:
                near = np.geomspace(0.1 * edge.size, 1.0, GRID_POINTS)
                spots += [edge.radius, *(edge.radius - near), *(edge.radius + near)]
            marks = np.concatenate(
                [inner + depth, outer - depth, np.linspace(inner, outer, 401), spots]
            )
            fine = np.unique(marks[(marks >= inner) & (marks <= outer)])
            density = 1 / self(fine)
            # by the trapezoidal rule
            parts = np.diff(fine) * (density[1:] + density[:-1]) / 2
            along = np.append(0.0, np.cumsum(parts))
            count = max(4, 2 * int(np.ceil(along[-1] / 2)))
            inside = np.interp(np.arange(1, count) * along[-1] / count, along, fine)
            pieces.append(np.append(inside, outer))
        return np.concatenate(pieces)

    def space(self) -> PressureSpace:
        """Return continuous piecewise linear pressures, broken at ring edges."""
        breakpoints = self.breakpoints()
        inner_radius = self.ring_edges[1] if self.hollow else 0.0
        degrees = np.where(breakpoints[1:] <= inner_radius, 0, 1)
        return PressureSpace(breakpoints, degrees, np.array(self.ring_edges))


def fitted_space(
    edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int, smallest: float = 1e-7
) -> PressureSpace:
    """Return pressures of high degree, graded to the axis and to every edge.

    Parameters
    ----------
    edges : from 0 to 1; the space is broken at each
    infinite : at which of them the pressure is infinite
    degree : highest; at edges it is 2
    smallest : size at edges where the pressure is finite
    """
    # infinite as a root, or falling to zero as one; at the axis a cone's is infinite as a logarithm
    sizes = smallest * np.where(infinite, 1e-3, 1.0)[1:]
    breakpoints = graded_breakpoints(edges, sizes[:-1], float(sizes[-1]), 0.2, axis_size=1e-5)
    degrees = layer_degrees(breakpoints, edges, degree, rise=1.0, lowest=2)
    return PressureSpace(breakpoints, degrees, np.array(edges))
