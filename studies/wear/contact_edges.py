"""Where contact is.

Intervals of the radius by the nodes that carry, and cells fine enough for where it begins.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.sparse.linalg import splu

from ...meshes.compliance import Compliance
from ...meshes.contact_cells import ContactCells
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices
from ..problem.profile import InitialProfile
from .moments import moments
from .unilateral import Contact, Interval, Load, Mask, Press


def nodes(space: PressureSpace) -> tuple[Array, Indices]:
    """(size,) radius and ring of the node of each linear pressure."""
    index = np.arange(space.size)
    last = np.append(space.dofs[:-1, 1][np.diff(space.ring) > 0], space.size)
    ring = np.searchsorted(last, index, side="left")
    ring[ring > space.ring[-1]] = space.ring[-1]
    return space.breakpoints[index - ring], ring


def contact_runs(contact: Mask, broken: Mask) -> list[tuple[int, int]]:
    """First and last node of every run of nodes in contact.

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
    """Intervals of an unworn face, cut where it has a step.

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
    """Where a run that goes as far as a node ends, and whether that edge is free."""
    other = node + way
    if not 0 <= other < len(radius):
        return float(radius[node]), False
    if radius[other] != radius[node]:
        return float((radius[node] + radius[other]) / 2), True
    # at a ring edge: a corner if the face falls away beyond it
    return float(radius[node]), not step[min(node, other)] * way > 0


def located(
    compliance: Callable[[PressureSpace], Compliance],
    profile: InitialProfile,
    load: Load,
    cells: ContactCells,
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Where contact begins, and cells with a spot wherever it begins on a narrow part of the face.

    The looks end where the first contact is many cells wide, or where spots come back to where they
    were before: from then on they would stay, or go round.
    """
    # that narrow first contacts may take
    most = 5 * len(cells.breakpoints())
    seen = [cells]
    for _ in range(24):
        space = cells.space()
        matrix = compliance(space).matrix
        press = Contact(matrix, space.weights).press(moments(profile, space), load)
        intervals = first_intervals(space, press.contact, profile)
        # between corners of the face, at ring edges, cells are small enough
        spreading = [part for part in intervals if part.inner_free or part.outer_free]
        unfelt = _unfelt(
            space, splu(space.mass().tocsc()).solve(matrix @ press.pressure), press, profile
        )
        narrow = [(part.inner, part.outer) for part in spreading] + unfelt
        while not (spotted := _with_spots(cells, narrow, most)) and len(narrow) > len(spreading):
            # the deepest first: where they carry, others may not touch
            del narrow[(len(narrow) + len(spreading)) // 2 :]
        if spotted is None:
            # rough: more parts, or narrower ones, than cells can be made for
            return intervals, cells
        # nodes that carry, of each part of the contact: as many as say how wide it is
        carrying = nodes(space)[0][press.contact]
        counts = [
            int(np.sum((carrying >= part.inner) & (carrying <= part.outer))) for part in spreading
        ]
        wide = min(counts, default=12) >= min(12, 0.5 / spotted.spread)
        if (wide and not unfelt) or any(_same_spots(spotted, earlier) for earlier in seen):
            return intervals, spotted
        seen.append(spotted)
        cells = spotted
    return intervals, cells


def _with_spots(
    cells: ContactCells, narrow: list[tuple[float, float]], most: int
) -> ContactCells | None:
    """Cells with a spot at each of some narrow parts, which spread as slowly as so many cells
    allow; None if they do not.
    """
    while cells.spread < 0.3:
        spots = tuple(
            (inner, outer, max(cells.spread * (outer - inner), 1e-9)) for inner, outer in narrow
        )
        spotted = replace(cells, spots=spots)
        if len(spotted.breakpoints()) <= most:
            return spotted
        cells = replace(cells, spread=2 * cells.spread)
    return None


def _same_spots(cells: ContactCells, other: ContactCells) -> bool:
    """Return whether two have the same spots, to less than a cell of theirs."""
    if cells.spread != other.spread or len(cells.spots) != len(other.spots):
        return False
    moved = np.abs(np.array(cells.spots) - np.array(other.spots))
    sizes = [size for _, _, size in cells.spots]
    return all(move[:2].max() < size for move, size in zip(moved, sizes, strict=True))


def _unfelt(
    space: PressureSpace, displacement: Array, press: Press, profile: InitialProfile
) -> list[tuple[float, float]]:
    """Where the face is in the half-space between nodes that do not carry: on less than a cell.

    The deepest first.
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
    """Inner and outer radius of every part of the contact of a worn face.

    An edge lies between two nodes. Where contact spreads, the face beyond is unworn, and the worn
    depth of the nodes before says where it begins.
    """
    radius, _ = nodes(space)
    out = []
    for first, last in contact_runs(contact, np.zeros(space.size - 1, dtype=bool)):
        few = last - first < 8
        ends = [_worn_end(radius, worn, node, way, few) for node, way in ((first, -1), (last, 1))]
        out.append((ends[0], ends[1]))
    return _apart(out)


def _apart(parts: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return parts whose extrapolated edges do not cross: two that do meet in the middle."""
    edges = np.ravel(parts)
    crossed = np.flatnonzero(edges[1:-1:2] > edges[2::2])
    for first in 2 * crossed + 1:
        edges[first : first + 2] = edges[first : first + 2].mean()
    return [(float(inner), float(outer)) for inner, outer in edges.reshape(-1, 2)]


def _worn_end(radius: Array, worn: Array, node: int, way: int, few: bool) -> float:
    other = node + way
    if not 0 <= other < len(radius):
        return float(radius[node])
    middle = float((radius[node] + radius[other]) / 2)
    # nearer to the edge the cells are felt
    near, far = node - 2 * way, node - 4 * way
    if few or worn[other] > 0 or not worn[far] > worn[near] > 0:
        return middle
    edge = radius[near] - worn[near] * (radius[near] - radius[far]) / (worn[near] - worn[far])
    cell = abs(float(radius[node] - radius[node - way]))
    return float(
        np.clip(
            edge, min(radius[node], radius[other]) - cell, max(radius[node], radius[other]) + cell
        )
    )
