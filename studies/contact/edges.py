"""Where contact is.

Intervals of the radius by the nodes that carry, and cells fine enough for where it begins.
"""

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

# growth of cells with the distance from a free edge: inside the contact the pressure falls off like
# that at a corner; outside cells stay small for an edge that moves outwards, as wear moves it
GROWTH_INSIDE, GROWTH_OUTSIDE = 0.4, 0.1
# free edges that cells are refined at: rough faces have many, which would be sought without end
MOST_FREE_EDGES = 4
# refinements, each to a quarter of the size, and by how much they may multiply the cells
MOST_REFINEMENTS, MOST_GROWTH_OF_CELLS = 12, 4


def nodes(space: PressureSpace) -> tuple[Array, Indices]:
    """Return radius and ring (size,) of the node of each linear pressure."""
    # the last takes what a hole has no nodes for
    radius, ring = np.empty(space.size + 1), np.empty(space.size + 1, dtype=np.int64)
    radius[space.dofs] = np.stack([space.breakpoints[:-1], space.breakpoints[1:]], axis=1)
    ring[space.dofs] = space.ring[:, None]
    return radius[:-1], ring[:-1]


def contact_runs(contact: Mask, broken: Mask) -> list[tuple[int, int]]:
    """Return the first and the last node of every run of nodes in contact.

    `broken` (size - 1,) parts a node from the next.
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
    """Return the intervals of an unworn face, cut where it has a step.

    Beside one that falls away, pressures are infinite.
    """
    radius, ring = nodes(space)
    at_edge = np.diff(ring) > 0
    step = np.zeros(space.size - 1)
    step[at_edge] = profile.steps
    out = []
    for first, last in contact_runs(contact, step != 0):
        inner, inner_free = _end(radius, step, first, -1)
        outer, outer_free = _end(radius, step, last, 1)
        out.append(Interval(inner, outer, inner_free, outer_free))
    return tuple(out)


def _end(radius: Array, step: Array, node: int, way: int) -> tuple[float, bool]:
    """Return where a run that goes as far as a node ends, and whether that edge is free."""
    other = node + way
    if not 0 <= other < len(radius):
        return float(radius[node]), False
    if radius[other] != radius[node]:
        return float((radius[node] + radius[other]) / 2), True
    # at a ring edge: a corner if the face falls away beyond it
    return float(radius[node]), not step[min(node, other)] * way > 0


def find_first_contact(
    compliance: Callable[[PressureSpace], Compliance],
    profile: InitialProfile,
    load: Load,
    cells: ContactCells,
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return where contact begins, and cells that are small on every narrow part of it.

    The search ends where the first contact is many cells wide, or where there are as many cells as
    there were before: from then on the cells would stay the same or go round in a circle.
    """
    # that narrow first contacts may take
    most = 5 * len(cells.breakpoints())
    seen: set[int] = set()
    for _ in range(24):
        space = cells.space()
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        intervals = first_intervals(space, press.contact, profile)
        # between corners of the face, at ring edges, cells are small enough
        spreading = [part for part in intervals if part.inner_free or part.outer_free]
        penetrating = _penetrating_parts(
            space, splu(space.mass().tocsc()).solve(matrix @ press.pressure), press, profile
        )
        narrow = [(part.inner, part.outer) for part in spreading] + penetrating
        while not (with_refinements := _with_spots(cells, narrow, most)) and len(narrow) > len(
            spreading
        ):
            # the deepest first: where they carry, others may not touch
            del narrow[(len(narrow) + len(spreading)) // 2 :]
        if with_refinements is None:
            # rough: more parts, or narrower ones, than cells can be made for
            return intervals, cells
        # nodes that carry, of each part of the contact: as many as say how wide it is
        carrying = nodes(space)[0][press.contact]
        counts = [
            int(np.sum((carrying >= part.inner) & (carrying <= part.outer))) for part in spreading
        ]
        wide = min(counts, default=12) >= min(12, 0.5 / with_refinements.spread)
        if (wide and not penetrating) or space.size in seen:
            return intervals, with_refinements
        seen.add(space.size)
        cells = with_refinements
    return intervals, cells


def refine_at_free_edges(
    compliance: Callable[[PressureSpace], Compliance],
    profile: InitialProfile,
    load: Load,
    cells: ContactCells,
    tolerance: float,
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return where contact begins, and cells that are small enough at its free edges.

    Where a flat face is rounded a little, the pressure is nearly infinite just inside the edge of
    the contact. The cells there are made smaller until that no longer changes the indentation, or
    the force where the indentation is given.

    Parameters
    ----------
    compliance : makes the compliance of a pressure space
    profile, load : of the punch
    cells : to start from; they stay as they are if the contact has no free edge, or more than
        `MOST_FREE_EDGES`
    tolerance : greatest relative change of the indentation or force
    """
    most_cells = MOST_GROWTH_OF_CELLS * len(cells.breakpoints())
    found: tuple[tuple[Interval, ...], ContactCells] = (), cells
    last_result, refined = np.nan, cells
    for _ in range(MOST_REFINEMENTS):
        space = refined.space()
        if len(space.degrees) > most_cells:
            break
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        result = press.force if load.force is None else press.indentation
        if abs(result - last_result) <= tolerance * abs(result):
            break
        intervals = first_intervals(space, press.contact, profile)
        last_result, found = result, (intervals, refined)
        edges = _refined_edges(space, intervals)
        if not 0 < len(edges) <= MOST_FREE_EDGES:
            break
        refined = replace(refined, free_edges=edges)
    return found


def _refined_edges(space: PressureSpace, intervals: tuple[Interval, ...]) -> tuple[FreeEdge, ...]:
    """Return the free edges of intervals, with cells a quarter as large as those of a space."""
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


def _with_spots(
    cells: ContactCells, narrow: list[tuple[float, float]], most: int
) -> ContactCells | None:
    """Return cells that are smaller at each of some narrow parts of the face.

    Away from these parts, sizes grow as slowly as `most` cells allow; None if they allow no growth
    below 0.3.
    """
    while cells.spread < 0.3:
        refinements = tuple(
            (inner, outer, max(cells.spread * (outer - inner), 1e-9)) for inner, outer in narrow
        )
        with_refinements = replace(cells, refinements=refinements)
        if len(with_refinements.breakpoints()) <= most:
            return with_refinements
        cells = replace(cells, spread=2 * cells.spread)
    return None


def _penetrating_parts(
    space: PressureSpace, displacement: Array, press: Press, profile: InitialProfile
) -> list[tuple[float, float]]:
    """Return the parts of the face that penetrate the half-space between nodes that do not carry.

    They are narrower than a cell. The deepest comes first.
    """
    # part of the indentation by which that is not felt
    deep = 1e-3 * press.indentation
    radii, heights = profile.sampled(*space.breakpoints)
    carries = space.matrix(radii) @ press.contact > 0
    gap = space.matrix(radii) @ displacement + heights - press.indentation
    last = len(radii) - 1
    runs = contact_runs((gap < -deep) & ~carries, np.zeros(last, dtype=bool))
    runs.sort(key=lambda run: gap[run[0] : run[1] + 1].min())
    return [(float(radii[max(a - 1, 0)]), float(radii[min(b + 1, last)])) for a, b in runs]


def worn_edges(space: PressureSpace, contact: Mask, worn: Array) -> list[tuple[float, float]]:
    """Return the inner and outer radius of every part of the contact of a worn face.

    An edge lies between two nodes. Where contact spreads, the face beyond is unworn, and the worn
    depth of the nodes before says where it begins.
    """
    radius, _ = nodes(space)
    runs = contact_runs(contact, np.zeros(space.size - 1, dtype=bool))
    if not runs:
        return []
    # edges that are extrapolated do not cross: none goes beyond the middle between two parts
    middles = [(radius[last] + radius[first]) / 2 for (_, last), (first, _) in pairwise(runs)]
    edges = []
    for (first, last), least, greatest in zip(runs, [0.0, *middles], [*middles, 1.0], strict=True):
        few = last - first < 8
        inner = _worn_end(radius, worn, first, -1, few)
        outer = _worn_end(radius, worn, last, 1, few)
        edges.append((float(max(inner, least)), float(min(outer, greatest))))
    return edges


def _worn_end(radius: Array, worn: Array, node: int, way: int, few: bool) -> float:
    """Return the edge beyond the last node that carries, to a cell."""
    other = node + way
    if not 0 <= other < len(radius):
        return float(radius[node])
    # nearer to the edge the cells are felt
    near, far = node - 2 * way, node - 4 * way
    if few or worn[other] > 0 or not worn[far] > worn[near] > 0:
        return float((radius[node] + radius[other]) / 2)
    edge = radius[near] - worn[near] * (radius[near] - radius[far]) / (worn[near] - worn[far])
    cell = abs(radius[node] - radius[node - way])
    inner, outer = sorted((radius[node], radius[other]))
    return float(np.clip(edge, inner - cell, outer + cell))
