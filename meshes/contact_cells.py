"""Cells for a contact that opens, closes and spreads, and the pressure space of a known contact.

Cells are small at ring edges, at the rim and where contact begins. Their size changes with the
distance by no more than a given growth, so that the contact line of a half-space mesh can have the
same sizes as a radial mesh. Lengths are in punch radii.
"""

import itertools
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .pressure_space import PressureSpace
from .radial import Array, from_axis, layer_degrees

# number of points of the grid on which 1 / size is integrated, for each end of a ring and each side
# of a free edge
GRID_POINTS = 400


class FreeEdge(NamedTuple):
    """Cell sizes beside an edge of the first contact that lies inside a ring.

    The pressure may be nearly infinite at such an edge.

    Parameters
    ----------
    radius : radius of the edge
    size : size of the cells at the edge
    growth_below : increase of the size per distance on the side of the axis
    growth_above : increase of the size per distance on the side of the rim
    """

    radius: float
    size: float
    growth_below: float
    growth_above: float

    def sizes(self, radii: Array) -> Array:
        """Return the largest cell sizes that this edge allows at the given radii."""
        distance = radii - self.radius
        growth = np.where(distance < 0, self.growth_below, self.growth_above)
        return self.size + growth * np.abs(distance)

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
    """The target size of cells at each radius.

    Parameters
    ----------
    ring_edges : ring edges, from 0 or the radius of a hole to 1 (the rim)
    largest : largest size
    edge_size : size at ring edges and rim
    growth : increase of the size per distance from ring edges and rim
    spread : increase of the size per distance from the intervals where contact begins
    refinements : intervals where contact begins, with the size there: (inner radius, outer radius,
        size)
    free_edges : edges of the first contact that need smaller cells
    """

    ring_edges: tuple[float, ...]
    largest: float
    edge_size: float
    growth: float = 0.4
    spread: float = 0.2
    refinements: tuple[tuple[float, float, float], ...] = ()
    free_edges: tuple[FreeEdge, ...] = ()

    def __call__(self, radii: Array) -> Array:
        """Return the target sizes at radii, an array of any shape."""
        size = np.full(np.shape(radii), self.largest)
        for ring_edge in filter(None, self.ring_edges):
            size = np.minimum(size, self.edge_size + self.growth * np.abs(radii - ring_edge))
        for inner, outer, smallest in self.refinements:
            distance = np.maximum(np.maximum(inner - radii, radii - outer), 0.0)
            size = np.minimum(size, smallest + self.spread * distance)
        for edge in self.free_edges:
            size = np.minimum(size, edge.sizes(radii))
        return size

    def from_axis(self) -> "ContactCells":
        """Return cells that also fill a hole, as the mesh of a half-space does."""
        return replace(self, ring_edges=tuple(from_axis(self.ring_edges).tolist()))

    def breakpoints(self) -> Array:
        """Return the boundaries of the cells of a radial mesh.

        In each ring, the integral of 1 / size over a cell is the same for all cells.
        """
        pieces = [np.array(self.ring_edges[:1])]
        for inner, outer in itertools.pairwise(self.ring_edges):
            width = outer - inner
            # the grid is finer at both ends, where sizes are small, so that 1 / size is integrated
            # accurately
            depth = np.geomspace(1e-3 * min(self.edge_size, width), width / 2, GRID_POINTS)
            extra_radii = [r for spot in self.refinements for r in spot[:2]]
            for edge in self.free_edges:
                near = np.geomspace(0.1 * edge.size, 1.0, GRID_POINTS)
                extra_radii += [edge.radius, *(edge.radius - near), *(edge.radius + near)]
            grid = np.concatenate(
                [inner + depth, outer - depth, np.linspace(inner, outer, 401), extra_radii]
            )
            grid_radii = np.unique(grid[(grid >= inner) & (grid <= outer)])
            density = 1 / self(grid_radii)
            # by the trapezoidal rule
            integrals = np.diff(grid_radii) * (density[1:] + density[:-1]) / 2
            integral = np.append(0.0, np.cumsum(integrals))
            count = max(4, 2 * int(np.ceil(integral[-1] / 2)))
            cell_edges = np.interp(np.arange(1, count) * integral[-1] / count, integral, grid_radii)
            pieces.append(np.append(cell_edges, outer))
        return np.concatenate(pieces)

    def multiplied(self, factor: float) -> "ContactCells":
        """Return about `factor` times as many cells, which are small at the same places.

        Sizes at ring edges, where pressures are singular, are divided by the square of the factor,
        and their growth by its root.
        """
        return replace(
            self,
            largest=self.largest / factor,
            edge_size=self.edge_size / factor**2,
            growth=self.growth / factor**0.5,
            spread=self.spread / factor,
            refinements=tuple(
                (inner, outer, size / factor) for inner, outer, size in self.refinements
            ),
            free_edges=tuple(edge.scaled(1 / factor) for edge in self.free_edges),
        )

    def space(self) -> PressureSpace:
        """Return the space of piecewise linear pressures that are continuous inside each ring."""
        breakpoints = self.breakpoints()
        linear = np.ones(len(breakpoints) - 1, dtype=np.int64)
        return PressureSpace(breakpoints, linear, np.array(self.ring_edges))


def fitted_space(edges: tuple[float, ...], sizes: ArrayLike, degree: int) -> PressureSpace:
    """Return pressures of high degree on elements that are graded to the axis and to every edge.

    Parameters
    ----------
    edges : edges of the contact, from 0 to 1; pressures may jump at each
    sizes : approximate size of the smallest elements at each edge but the first
    degree : highest degree; the lowest, at the edges, is 2
    """
    # At an edge the pressure is infinite as 1/sqrt(distance) or falls to zero as sqrt(distance); at
    # the axis that of a cone is infinite as a logarithm.
    space = PressureSpace.graded(edges, sizes, 0.2, degree, axis_size=1e-5)
    degrees = layer_degrees(space.breakpoints, edges, degree, rise=1.0, lowest=2)
    # moments of the face are integrated between rounded radii, and so must the pressures be
    return replace(space, degrees=degrees, low_parts=None)
