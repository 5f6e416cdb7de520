"""Find the intervals of radii in contact, and refine the cells where contact begins."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.contact_cells import ContactCells, FreeEdge
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, Indices
from ..problem.profile import InitialProfile
from .moments import moments
from .unilateral import Contact, Interval, Load, Mask, Press

# growth of the cell size per distance from a free edge. Inside the contact, the pressure decays
# with the distance as it does near a corner. Outside, cells stay small because wear moves the edge
# outwards.
GROWTH_INSIDE, GROWTH_OUTSIDE = 0.4, 0.1
# greatest number of free edges at which cells are refined; on rough faces, which have many, the
# refinement would not end
MOST_FREE_EDGES = 4
# power of the distance from an edge with which the worn depth rises there, between 1 (wear that is
# fast and uniform) and 3/2 (an edge that moves slowly under a pressure that vanishes as a root); in
# random punches the edge is then known to a fifth of a cell
WORN_DEPTH_POWER = 1.25
# Greatest part of a cell by which an extrapolated edge lies beyond the cell in which contact ends.
# Under spheres that wear, the edge lies up to a fifth of a cell beyond it; of that, this is half.
BEYOND_CELL = 0.1
# smallest size of cells on narrow parts of the contact, in punch radii
SMALLEST_REFINED_CELL = 1e-9
# greatest number of refinements at free edges, each of which quarters the size, and greatest number
# of cells after them, over that before
MOST_REFINEMENTS, MOST_CELLS_RATIO = 12, 4


def nodes(space: PressureSpace) -> tuple[Array, Indices]:
    """Return the radius (size,) and the ring (size,) of the node of each linear pressure."""
    radius, ring = np.empty(space.size), np.empty(space.size, dtype=np.int64)
    radius[space.dofs] = np.stack([space.breakpoints[:-1], space.breakpoints[1:]], axis=1)
    ring[space.dofs] = space.ring[:, None]
    return radius, ring


def _contact_runs(contact: Mask, broken: Mask) -> list[tuple[int, int]]:
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


def first_intervals(
    space: PressureSpace, contact: Mask, profile: InitialProfile
) -> tuple[Interval, ...]:
    """Return the contact intervals of an unworn face; they also end at steps of the face.

    The pressure is infinite at a corner beyond which the face recedes, so such an edge is not free.
    """
    radius, ring = nodes(space)
    at_edge = np.diff(ring) > 0
    step = np.zeros(space.size - 1)
    step[at_edge] = profile.steps
    intervals = []
    for first, last in _contact_runs(contact, step != 0):
        inner, inner_free = _unworn_edge(radius, step, first, -1)
        outer, outer_free = _unworn_edge(radius, step, last, 1)
        intervals.append(Interval(inner, outer, inner_free, outer_free))
    return tuple(intervals)


def covers_face(intervals: tuple[Interval, ...]) -> bool:
    """Return whether no edge of the contact is free: it ends at the rim and at steps of the face.

    Thin layers that wear makes at ring edges then limit the accuracy, not edges of the contact.
    """
    return not any(part.inner_free or part.outer_free for part in intervals)


def _unworn_edge(radius: Array, step: Array, node: int, direction: int) -> tuple[float, bool]:
    """Return the radius of the contact edge next to the last node of a run, and if it is free.

    Parameters
    ----------
    radius : (size,) array
        Radii of the nodes.
    step : (size - 1,) array
        Step of the face between each node and the next.
    node : int
        Last node of the run in that direction.
    direction : int
        -1 inwards, 1 outwards.
    """
    neighbour = node + direction
    if not 0 <= neighbour < len(radius):
        return float(radius[node]), False
    if radius[neighbour] != radius[node]:
        return float((radius[node] + radius[neighbour]) / 2), True
    # at a ring edge: a corner, not a free edge, if the face recedes beyond it
    return float(radius[node]), not step[min(node, neighbour)] * direction > 0


def find_first_contact(
    compliance: Callable[[PressureSpace], Compliance],
    profile: InitialProfile,
    load: Load,
    cells: ContactCells,
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return the intervals of first contact, and cells that are small on its narrow parts.

    The search ends if every part of the first contact is many cells wide, or if a number of
    unknowns occurs for the second time, because from then on the cells would repeat.

    Parameters
    ----------
    compliance : callable
        Returns the compliance on a pressure space.
    profile : InitialProfile
        Unworn face.
    load : Load
        Force or indentation.
    cells : ContactCells
        Cells to start from.
    """
    # limit on the number of cells, for narrow first contacts
    most_cells = 5 * _count(cells)
    seen_sizes: set[int] = set()
    for _ in range(24):
        space = cells.space()
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        intervals = first_intervals(space, press.contact, profile)
        # parts between two corners of the face need no refinement: cells are small at ring edges
        free_intervals = [part for part in intervals if part.inner_free or part.outer_free]
        penetrating = _penetrating_parts(
            space, space.projected(matrix @ press.pressure), press, profile
        )
        narrow_parts = [(part.inner, part.outer) for part in free_intervals] + penetrating
        while not (
            with_refinements := _refine_narrow_parts(cells, narrow_parts, most_cells)
        ) and len(narrow_parts) > len(free_intervals):
            # refine only the deeper half: once these parts carry load, others may not touch
            del narrow_parts[(len(narrow_parts) + len(free_intervals)) // 2 :]
        if with_refinements is None:
            # a rough face: its parts are too many or too narrow for `most_cells` cells
            return intervals, cells
        # the width of each part of the contact, as a number of nodes in contact
        carrying = nodes(space)[0][press.contact]
        counts = [
            int(np.sum((carrying >= part.inner) & (carrying <= part.outer)))
            for part in free_intervals
        ]
        wide_enough = min(counts, default=12) >= min(12, 0.5 / with_refinements.spread)
        if (wide_enough and not penetrating) or space.size in seen_sizes:
            return intervals, with_refinements
        seen_sizes.add(space.size)
        cells = with_refinements
    return intervals, cells


def refine_at_free_edges(
    compliance: Callable[[PressureSpace], Compliance],
    profile: InitialProfile,
    load: Load,
    cells: ContactCells,
    tolerance: float,
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return the intervals of first contact, and cells that are small enough at its free edges.

    At the edge of a slightly rounded flat face, the pressure has a high peak just inside the
    contact. The cells there are refined until this no longer changes the indentation, or the force
    if the indentation is given.

    Parameters
    ----------
    compliance : callable
        Returns the compliance on a pressure space.
    profile : InitialProfile
        Unworn face.
    load : Load
        Force or indentation.
    cells : ContactCells
        Cells to start from. They are returned unchanged if the contact has no free edge, or more
        than `MOST_FREE_EDGES`.
    tolerance : float
        Greatest relative change of the indentation or force by the last refinement.
    """
    most_cells = MOST_CELLS_RATIO * _count(cells)
    last_accepted: tuple[tuple[Interval, ...], ContactCells] = (), cells
    last_response, refined = np.nan, cells
    for _ in range(MOST_REFINEMENTS):
        space = refined.space()
        if _count(refined) > most_cells + 1:
            break
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        response = press.force if load.force is None else press.indentation
        if abs(response - last_response) <= tolerance * abs(response):
            break
        intervals = first_intervals(space, press.contact, profile)
        last_response, last_accepted = response, (intervals, refined)
        edges = _refined_edges(space, intervals)
        if not 0 < len(edges) <= MOST_FREE_EDGES:
            break
        refined = replace(refined, free_edges=edges)
    return last_accepted


def _refined_edges(space: PressureSpace, intervals: tuple[Interval, ...]) -> tuple[FreeEdge, ...]:
    """Return the free edges of intervals, each with a quarter of the cell size of a space there."""
    edges = []
    for part in intervals:
        if part.inner_free:
            edges.append((part.inner, GROWTH_OUTSIDE, GROWTH_INSIDE))
        if part.outer_free:
            edges.append((part.outer, GROWTH_INSIDE, GROWTH_OUTSIDE))
    cells = np.searchsorted(space.breakpoints, [radius for radius, *_ in edges])
    sizes = np.diff(space.breakpoints)[cells - 1] / 4
    return tuple(
        FreeEdge(radius, size, below, above)
        for (radius, below, above), size in zip(edges, sizes.tolist(), strict=True)
    )


def _refine_narrow_parts(
    cells: ContactCells, narrow_parts: list[tuple[float, float]], most_cells: int
) -> ContactCells | None:
    """Return cells that are refined on narrow parts of the face, or None if they are too many.

    Away from these parts, the cell size grows as slowly as the limit on the number of cells allows.
    The result is None if even a growth (`ContactCells.spread`) of 0.3 would exceed the limit.

    Parameters
    ----------
    cells : ContactCells
        Cells to refine.
    narrow_parts : list of (float, float)
        Inner and outer radius of each part.
    most_cells : int
        Limit on the number of cells.
    """
    while cells.spread < 0.3:
        with_refinements = replace(cells, refinements=refinements_of(cells.spread, narrow_parts))
        if _count(with_refinements) <= most_cells:
            return with_refinements
        cells = replace(cells, spread=2 * cells.spread)
    return None


def _count(cells: ContactCells) -> int:
    """Return the number of ends of cells, with those in a hole, which finite elements have."""
    return len(cells.from_axis().breakpoints())


def refinements_of(
    spread: float, parts: Iterable[tuple[float, float]]
) -> tuple[tuple[float, float, float], ...]:
    """Return refinements of cells on parts of the face, each with the size of the cells there.

    Parameters
    ----------
    spread : float
        Growth of the cell size per distance from the parts (`ContactCells.spread`), and the size of
        the cells on a part over its width.
    parts : iterable of (float, float)
        Inner and outer radius of each part.
    """
    return tuple(
        (inner, outer, max(spread * (outer - inner), SMALLEST_REFINED_CELL))
        for inner, outer in parts
    )


def _penetrating_parts(
    space: PressureSpace, displacement: Array, press: Press, profile: InitialProfile
) -> list[tuple[float, float]]:
    """Return the parts of the face that penetrate the half-space between nodes without contact.

    They are narrower than a cell. Each is given by its inner and outer radius; the deepest comes
    first.

    Parameters
    ----------
    space : PressureSpace
        Space of the solution.
    displacement : (size,) array
        Coefficients of the displacement of the half-space.
    press : Press
        Solution on that space.
    profile : InitialProfile
        Unworn face.
    """
    # smaller penetrations are ignored
    tolerance = 1e-3 * press.indentation
    radii, heights = profile.sampled(*space.breakpoints)
    carries = space.matrix(radii) @ press.contact > 0
    gap = space.matrix(radii) @ displacement + heights - press.indentation
    last = len(radii) - 1
    runs = _contact_runs((gap < -tolerance) & ~carries, np.zeros(last, dtype=bool))
    runs.sort(key=lambda run: gap[run[0] : run[1] + 1].min())
    return [(float(radii[max(a - 1, 0)]), float(radii[min(b + 1, last)])) for a, b in runs]


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
            for first, last in _contact_runs(contact, np.zeros(space.size - 1, dtype=bool))
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
        Square root of ``sum k p^2 dA`` over these cells, with the greater pressure p of the last
        two nodes in contact, over that of all nodes.
    """
    radius, _ = nodes(space)
    cells = np.diff(radius)
    weights = space.at_vertices(wear_coefficients)
    squares = pressure**2
    # greatest of both ends of the cell on the axis side of each node, and on its other side
    below, above = squares.copy(), squares.copy()
    below[:, 1:] = np.maximum(squares[:, 1:], squares[:, :-1])
    above[:, :-1] = np.maximum(squares[:, 1:], squares[:, :-1])
    outer, inner = contact[:, :-1] & ~contact[:, 1:], contact[:, 1:] & ~contact[:, :-1]
    beside = outer * (weights * below)[:, :-1] + inner * (weights * above)[:, 1:]
    lost = beside @ (np.pi * cells * (radius[:-1] + radius[1:]))
    total = squares @ (weights * space.weights)
    return np.sqrt(np.divide(lost, total, out=np.zeros(len(lost)), where=total > 0))
