"""Find the intervals of radii in contact, and refine the cells where contact begins."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.sparse.linalg import splu

from ...meshes.compliance import Compliance
from ...meshes.contact_cells import ContactCells, FreeEdge
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices
from ..problem.profile import InitialProfile
from ..wear.unilateral import Contact, Interval, Load, Mask, Press
from .moments import moments

# growth of the cell size per distance from a free edge. Inside the contact, the pressure decays
# with the distance as it does near a corner. Outside, cells stay small because wear moves the edge
# outwards.
GROWTH_INSIDE, GROWTH_OUTSIDE = 0.4, 0.1
# greatest number of free edges at which cells are refined; on rough faces, which have many, the
# refinement would not end
MOST_FREE_EDGES = 4
# greatest number of refinements at free edges, each of which quarters the size, and greatest number
# of cells after them, over that before
MOST_REFINEMENTS, MOST_CELLS_RATIO = 12, 4


def nodes(space: PressureSpace) -> tuple[Array, Indices]:
    """Return the radius (size,) and the ring (size,) of the node of each linear pressure."""
    # the last entry receives the values of cells in a hole, which have no unknowns
    radius, ring = np.empty(space.size + 1), np.empty(space.size + 1, dtype=np.int64)
    radius[space.dofs] = np.stack([space.breakpoints[:-1], space.breakpoints[1:]], axis=1)
    ring[space.dofs] = space.ring[:, None]
    return radius[:-1], ring[:-1]


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
    most_cells = 5 * len(cells.breakpoints())
    seen_sizes: set[int] = set()
    for _ in range(24):
        space = cells.space()
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        intervals = first_intervals(space, press.contact, profile)
        # parts between two corners of the face need no refinement: cells are small at ring edges
        free_intervals = [part for part in intervals if part.inner_free or part.outer_free]
        penetrating = _penetrating_parts(
            space, splu(space.mass().tocsc()).solve(matrix @ press.pressure), press, profile
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
    most_cells = MOST_CELLS_RATIO * len(cells.breakpoints())
    last_accepted: tuple[tuple[Interval, ...], ContactCells] = (), cells
    last_response, refined = np.nan, cells
    for _ in range(MOST_REFINEMENTS):
        space = refined.space()
        if len(space.degrees) > most_cells:
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
        refinements = tuple(
            (inner, outer, max(cells.spread * (outer - inner), 1e-9))
            for inner, outer in narrow_parts
        )
        with_refinements = replace(cells, refinements=refinements)
        if len(with_refinements.breakpoints()) <= most_cells:
            return with_refinements
        cells = replace(cells, spread=2 * cells.spread)
    return None


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

    An edge lies between two nodes. If the contact spreads there, the face beyond is unworn, and the
    edge is found by extrapolating the worn depth to zero.

    Parameters
    ----------
    space : PressureSpace
        Space of the march, of degree 1.
    contact : (size,) array of bool
        Whether each node is in contact.
    worn : (size,) array
        Worn depth at the nodes.
    """
    radius, _ = nodes(space)
    runs = _contact_runs(contact, np.zeros(space.size - 1, dtype=bool))
    if not runs:
        return []
    # extrapolated edges may not cross: they are limited to the middle between two parts
    middles = [(radius[last] + radius[first]) / 2 for (_, last), (first, _) in pairwise(runs)]
    edges = []
    for (first, last), least, greatest in zip(runs, [0.0, *middles], [*middles, 1.0], strict=True):
        few_nodes = last - first < 8
        inner = _worn_edge(radius, worn, first, -1, few_nodes)
        outer = _worn_edge(radius, worn, last, 1, few_nodes)
        edges.append((float(max(inner, least)), float(min(outer, greatest))))
    return edges


def _worn_edge(radius: Array, worn: Array, node: int, direction: int, few_nodes: bool) -> float:
    """Return the radius of the edge next to the last node in contact, to within a cell.

    It is extrapolated from the worn depth. If there are few nodes, if the next node has worn, or if
    the worn depth does not decrease towards the edge, it is the middle between the two nodes.
    """
    neighbour = node + direction
    if not 0 <= neighbour < len(radius):
        return float(radius[node])
    # two and four cells inside the edge; closer to it, the discretisation error is visible
    near, far = node - 2 * direction, node - 4 * direction
    if few_nodes or worn[neighbour] > 0 or not worn[far] > worn[near] > 0:
        return float((radius[node] + radius[neighbour]) / 2)
    edge = radius[near] - worn[near] * (radius[near] - radius[far]) / (worn[near] - worn[far])
    cell = abs(radius[node] - radius[node - direction])
    inner, outer = sorted((radius[node], radius[neighbour]))
    return float(np.clip(edge, inner - cell, outer + cell))
