"""Locate the edges of the contact of a worn face, and what linear pressures miss beside them."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, Indices
from .unilateral import Mask

# power of the distance from an edge with which the worn depth rises there, between 1 (wear that is
# fast and uniform) and 3/2 (an edge that moves slowly under a pressure that vanishes as a root); in
# random punches the edge is then known to a fifth of a cell
WORN_DEPTH_POWER = 1.25
# Greatest part of a cell by which an extrapolated edge lies beyond the cell in which contact ends.
# Under spheres that wear, the edge lies up to a fifth of a cell beyond it; of that, this is half.
BEYOND_CELL = 0.1


def nodes(space: PressureSpace) -> tuple[Array, Indices]:
    """Return the radius (size,) and the ring (size,) of the node of each linear pressure."""
    radius, ring = np.empty(space.size), np.empty(space.size, dtype=np.int64)
    radius[space.dofs] = np.stack([space.breakpoints[:-1], space.breakpoints[1:]], axis=1)
    ring[space.dofs] = space.ring[:, None]
    return radius, ring


def contact_runs(contact: Mask, broken: Mask) -> list[tuple[int, int]]:
    """Return the first and the last node of every run of consecutive nodes in contact.

    Parameters
    ----------
    contact : (size,) array of bool
        Whether each node is in contact.
    broken : (size - 1,) array of bool
        Whether a run ends between each node and the next, even if both are in contact.
    """
    inside = np.flatnonzero(contact)
    if not len(inside):
        return []
    ends = (np.diff(inside) > 1) | broken[inside[:-1]]
    starts = inside[np.append(True, ends)]
    return list(zip(starts.tolist(), inside[np.append(ends, True)].tolist(), strict=True))


def worn_edges(space: PressureSpace, contact: Mask, worn: Array) -> list[tuple[float, float]]:
    """Return the inner and outer radius of every part of the contact of a worn face.

    An edge lies between the last node in contact and the next one. If the contact spreads there,
    the face beyond is unworn, and the edge is found by extrapolating the worn depth to zero.

    Parameters
    ----------
    space : PressureSpace
        Space of the march, of degree 1.
    contact : (size,) array of bool
        Whether each node is in contact.
    worn : (size,) array
        Worn depth at the nodes.

    Notes
    -----
    Independent solutions with cells that are ten times smaller have their edges between these two
    nodes, or up to a fifth of a cell beyond the outer one
    (physics/test_moving_edges.py::test_edges_lie_in_the_cell_in_which_contact_ends).
    """
    radius, _ = nodes(space)
    edges = np.array(
        [
            (
                _worn_edge(radius, contact, worn, first, -1),
                _worn_edge(radius, contact, worn, last, 1),
            )
            for first, last in contact_runs(contact, np.zeros(space.size - 1, dtype=bool))
        ]
    ).reshape(-1, 2)
    # extrapolated edges may not cross: in a narrow gap, they are in the middle between two parts
    outer, inner = edges[:-1, 1], edges[1:, 0]
    crossing = outer > inner
    outer[crossing] = inner[crossing] = (outer[crossing] + inner[crossing]) / 2
    return [(float(start), float(end)) for start, end in edges]


def _worn_edge(radius: Array, contact: Mask, worn: Array, node: int, direction: int) -> float:
    """Return the radius of the edge between the last node in contact and the next one.

    It is extrapolated from the worn depth of the last two nodes. If these are on different rings,
    if the next node has worn, or if the worn depth does not decrease towards the edge, it is the
    middle between the last node in contact and the next one.
    """
    neighbour, inside = node + direction, node - direction
    if not 0 <= neighbour < len(radius):
        return float(radius[node])
    spreads = 0 <= inside < len(radius) and contact[inside] and worn[neighbour] == 0
    if not (spreads and radius[inside] != radius[node] and 0 < worn[node] < worn[inside]):
        return float((radius[node] + radius[neighbour]) / 2)
    remaining = (worn[node] / worn[inside]) ** (1 / WORN_DEPTH_POWER)
    beyond = abs(radius[node] - radius[inside]) * remaining / (1 - remaining)
    greatest = (1 + BEYOND_CELL) * abs(radius[neighbour] - radius[node])
    return float(np.clip(radius[node] + direction * min(beyond, greatest), 0.0, 1.0))


def widths_at_edges(space: PressureSpace, contact: Mask) -> Array:
    """Return the widths (T,) of the cells in which the outermost edges of the contact lie.

    Parameters
    ----------
    space : PressureSpace
        Space of the march, of degree 1.
    contact : (T, size) array of bool
        Whether each node is in contact.

    Returns
    -------
    (T,) array
        Distance of the last node in contact from the next one. If both are at a ring edge, it is
        the width of the wider cell beside that edge; at the rim, it is that of the last cell. It is
        zero without contact.
    """
    radius, _ = nodes(space)
    # cells between successive nodes; those at ring edges have no width
    cells = np.pad(np.diff(radius), 1)
    last = contact.shape[1] - 1 - np.argmax(contact[:, ::-1], axis=1)
    next_cell = cells[last + 1]
    beside = np.maximum(cells[last], np.append(cells, 0.0)[last + 2])
    return np.where(contact.any(axis=1), np.where(next_cell > 0, next_cell, beside), 0.0)


def pressures_beside_edges(
    space: PressureSpace, contact: Mask, pressure: Array, wear_coefficients: Array
) -> Array:
    """Return the pressure (T,) on the cells in which free edges lie, over that on all of the face.

    Parameters
    ----------
    space : PressureSpace
        Space of the march, of degree 1.
    contact : (T, size) array of bool
        Whether each node is in contact.
    pressure : (T, size) array
        Nodal pressures.
    wear_coefficients : (N,) or (2, N) array
        Wear coefficients k of the rings of the space.

    Returns
    -------
    (T,) array
        Square root of ``sum k p^2 dA`` over these cells, with the greatest pressure p of the nodes
        of each cell and of the next ones, over that of all nodes.
    """
    radius, _ = nodes(space)
    weights = space.at_vertices(wear_coefficients)
    squares = pressure**2
    # greatest at the ends of each cell and of the cells beside it; it is zero beyond the edge
    greatest = sliding_window_view(np.pad(squares, ((0, 0), (1, 1))), 4, axis=1).max(axis=2)
    weighted = np.pi * np.diff(radius**2) * np.maximum(weights[:-1], weights[1:])
    lost = np.where(contact[:, :-1] != contact[:, 1:], greatest, 0.0) @ weighted
    total = squares @ (weights * space.weights)
    return np.sqrt(np.divide(lost, total, out=np.zeros(len(lost)), where=total > 0))
