"""Find the first contact of an unworn face, and cells that are small where contact begins.

The cells are the same for every method. Each step of the search presses the face on cells, and
refines them on parts of the contact that are narrow, or that only touch on smaller cells, and at
last at free edges, until the response to the load no longer changes.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.contact_cells import ContactCells, FreeEdge
from ....meshes.errors import SceneError
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array
from ..problem.problem import Problem
from ..problem.profile import InitialProfile, moments
from ..sizes.cells import cells_of, graded_to_worn_layers
from .contact_edges import contact_runs, nodes
from .unilateral import Contact, ContactSolution, Interval, Load, Mask

# Change of the start by smaller cells that is tolerated, over rtol; and the largest rtol that
# counts, because cells do not get coarser beyond it.
START_TOLERANCE, COARSEST_RTOL = 0.2, 1e-3
# Points of the quadrature, besides two for each degree, in the search for the first contact, which
# only determines cells. Energies are then right to 1e-7 (unit/mdr/test_transforms.py).
EXTRA_POINTS_OF_SEARCH = 4
# growth of the cell size per distance from a free edge. Inside the contact, the pressure decays
# with the distance as it does near a corner. Outside, cells stay small because wear moves the edge
# outwards.
GROWTH_INSIDE, GROWTH_OUTSIDE = 0.4, 0.1
# greatest number of free edges at which cells are refined; on rough faces, which have many, the
# refinement would not end
MOST_FREE_EDGES = 4
# smallest size of cells on narrow parts of the contact, over their radius; at the axis they may be
# as small as the contact is
SMALLEST_REFINED_CELL = 1e-9
# greatest number of refinements at free edges, each of which quarters the size, and greatest number
# of cells after them, over that before
MOST_REFINEMENTS, MOST_CELLS_RATIO = 12, 4


@dataclass(frozen=True, eq=False)
class UnwornPunch:
    """A punch that has not worn yet, under its load at the start.

    Parameters
    ----------
    compliance : callable
        Returns the compliance on a pressure space.
    profile : InitialProfile
        Unworn face.
    load : Load
        Force or indentation.
    """

    compliance: Callable[[PressureSpace], Compliance]
    profile: InitialProfile
    load: Load

    def pressed_on(self, space: PressureSpace) -> tuple[Array, ContactSolution]:
        """Return the matrix (size, size) of the compliance on a space, and the contact there."""
        matrix, weights = self.compliance(space).matrix, space.weights
        heights = moments(self.profile, space)
        # from the lowest node on: on cells that are far larger than the contact, a small force
        # would be lost in the roundoff of heights
        lowest = float((heights / weights).min()) if self.load.force else 0.0
        press = Contact(matrix, weights).press(heights - lowest * weights, self.load)
        return matrix, replace(press, indentation=press.indentation + lowest)


def load_of(problem: Problem) -> Load:
    """Return the largest load: the force, which is the unit, or the given indentation."""
    return Load(1.0) if problem.indentation is None else Load(None, problem.indentation)


def load_at_start(problem: Problem) -> Load:
    """Return the load at the time 0, or the largest load if there is none at that time."""
    load = load_of(problem)
    return Load(float(problem.loading.forces[0]) or 1.0) if load.force else load


@lru_cache(maxsize=16)
def first_contact(problem: Problem) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return the intervals of first contact, and cells for them, the same for every method.

    They only determine the cells. For this, the compliance of any method is sufficient, and that of
    dimensionality reduction is fast to compute.
    """
    punch = _unworn_punch(problem)
    intervals, cells = find_first_contact(punch, cells_of(problem))
    if not intervals:
        raise SceneError(
            "load.indentation makes a contact that is too small for cells: give a larger one"
        )
    if covers_face(intervals):
        cells = graded_to_worn_layers(problem, cells)
    tolerance = START_TOLERANCE * min(problem.rtol, COARSEST_RTOL)
    return refine_at_free_edges(punch, cells, tolerance)


@lru_cache(maxsize=16)
def scaled_cells(problem: Problem, factor: float) -> ContactCells:
    """Return about `factor` times as many cells as those of `first_contact`.

    They are small at the same ring edges and free edges, so that the difference of two solutions
    shows the effect of the size of cells. The places where contact begins are searched for anew, so
    that the difference also shows the error of these places. The cells there have the scaled size:
    the new search may find another one.
    """
    _, at_contact = find_first_contact(_unworn_punch(problem), cells_of(problem).multiplied(factor))
    cells = first_contact(problem)[1].multiplied(factor)
    places = ((inner, outer) for inner, outer, _ in at_contact.refinements)
    return replace(cells, refinements=refinements_of(cells.spread, places))


def contact_cells(problem: Problem) -> tuple[ContactCells, ContactCells]:
    """Return cells of the face, small where contact begins, and half as many cells."""
    return first_contact(problem)[1], scaled_cells(problem, 0.5)


def _unworn_punch(problem: Problem) -> UnwornPunch:
    """Return the punch whose first contact is searched for, with a compliance that is fast."""
    compliance_on = partial(
        energy.compliance, ground=problem.ground, extra_points=EXTRA_POINTS_OF_SEARCH
    )
    return UnwornPunch(compliance_on, problem.profile, load_at_start(problem))


def find_first_contact(
    punch: UnwornPunch, cells: ContactCells
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return the intervals of first contact, and cells that are small on its narrow parts.

    The search ends if every part of the first contact is many cells wide, or if a number of
    unknowns occurs for the second time, because from then on the cells would repeat.

    Parameters
    ----------
    punch : UnwornPunch
        The punch before it wears.
    cells : ContactCells
        Cells to start from.
    """
    # limit on the number of cells, for narrow first contacts
    most_cells = 5 * _count(cells)
    seen_sizes: set[int] = set()
    for _ in range(24):
        space = cells.space()
        matrix, press = punch.pressed_on(space)
        intervals = first_intervals(space, press.contact, punch.profile)
        # parts between two corners of the face need no refinement: cells are small at ring edges
        free_intervals = [part for part in intervals if part.inner_free or part.outer_free]
        penetrating = _penetrating_parts(
            space, space.projected(matrix @ press.pressure), press, punch.profile
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
    for first, last in contact_runs(contact, step != 0):
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


def _penetrating_parts(
    space: PressureSpace, displacement: Array, press: ContactSolution, profile: InitialProfile
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
    press : ContactSolution
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
    runs = contact_runs((gap < -tolerance) & ~carries, np.zeros(last, dtype=bool))
    runs.sort(key=lambda run: gap[run[0] : run[1] + 1].min())
    return [(float(radii[max(a - 1, 0)]), float(radii[min(b + 1, last)])) for a, b in runs]


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
        (inner, outer, max(spread * (outer - inner), SMALLEST_REFINED_CELL * outer))
        for inner, outer in parts
    )


def refine_at_free_edges(
    punch: UnwornPunch, cells: ContactCells, tolerance: float
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return the intervals of first contact, and cells that are small enough at its free edges.

    At the edge of a slightly rounded flat face, the pressure has a high peak just inside the
    contact. The cells there are refined until this no longer changes the indentation, or the force
    if the indentation is given.

    Parameters
    ----------
    punch : UnwornPunch
        The punch before it wears.
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
        _, press = punch.pressed_on(space)
        response = press.force if punch.load.force is None else press.indentation
        if abs(response - last_response) <= tolerance * abs(response):
            break
        intervals = first_intervals(space, press.contact, punch.profile)
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


def _count(cells: ContactCells) -> int:
    """Return the number of ends of cells, with those in a hole, which finite elements have."""
    return len(cells.from_axis().breakpoints())
