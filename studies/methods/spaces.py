"""The pressure spaces that suit a problem, and coarser ones.

A flat punch has singular pressures at ring edges and rim for early times: geometric layers of high
degree. Where edges of the contact move, pressures jump at places that are not known beforehand:
linear pressures on cells.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ...mdr import energy
from ...meshes.contact_cells import ContactCells
from ...meshes.errors import SceneError
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices, exact_graded_breakpoints
from ...meshes.sizes import degree_reduction
from ..contact.edges import find_first_contact, refine_at_free_edges
from ..problem.problem import Problem
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..sizes.defaults import cells_of, mdr_sizes, pressure_degree, with_affordable_field_tolerance
from ..sizes.layers import narrowed_for_layers
from ..wear.unilateral import Interval, Load

# strength of a kink of the wear coefficient (`Rings.kinks`) that asks for no layer
WEAK_KINK = 0.1
# part of the accuracy asked for by which smaller cells may change the start; cells do not get
# coarser than the coarsest accuracy asks for
START_TOLERANCE, COARSEST_RTOL = 0.2, 1e-3


class PressureSpaces(NamedTuple):
    """The pressure space that suits a problem, and one that is coarser in everything.

    Parameters
    ----------
    fine, coarse : the spaces
    nested : whether the coarse one lies within the fine one, so that a compliance on it need not be
        computed anew
    smallest_sizes : the sizes that the fine one was made by, the smallest where each ring edge has
        its own; empty of cells
    """

    fine: PressureSpace
    coarse: PressureSpace
    nested: bool
    smallest_sizes: Mapping[str, float]


def choose_spaces(problem: Problem) -> PressureSpaces:
    """Return the pressure spaces that suit the contact of a problem, and how they were made."""
    return SPACES[problem.contact](problem)


def pressure_spaces(problem: Problem) -> tuple[PressureSpace, PressureSpace]:
    """Return the pressure space that suits a problem, and one that is coarser in everything."""
    spaces = choose_spaces(problem)
    return spaces.fine, spaces.coarse


def _graded_spaces(problem: Problem) -> PressureSpaces:
    sizes = mdr_sizes(problem)
    space = radial_space(problem, **sizes)
    smallest = {name: np.min(size).item() for name, size in sizes.items() if np.size(size)}
    return PressureSpaces(space, space.coarser(), True, smallest)


def _spaces_of_cells(problem: Problem) -> PressureSpaces:
    fine, coarse = contact_cells(problem)
    return PressureSpaces(fine.space(), coarse.space(), False, {})


SPACES = {FULL_CONTACT: _graded_spaces, MOVING_CONTACT: _spaces_of_cells}


def load_of(problem: Problem) -> Load:
    """Return the greatest load: the force, which is the unit, or the indentation that is given."""
    return Load(1.0) if problem.indentation is None else Load(None, problem.indentation)


def load_at_start(problem: Problem) -> Load:
    """Return the load at the time 0, or the greatest where that is none."""
    load = load_of(problem)
    return Load(float(problem.loading.forces[0]) or 1.0) if load.force else load


@lru_cache(maxsize=16)
def first_contact(
    problem: Problem, finer: float = 1.0
) -> tuple[tuple[Interval, ...], ContactCells]:
    """Return where contact begins, and cells for it, the same for every method.

    It decides on the cells only: any method's compliance will do, and this one is quick.
    """
    cells = cells_of(problem, finer)
    load, on_ground = load_at_start(problem), partial(energy.compliance, ground=problem.ground)
    intervals, cells = find_first_contact(on_ground, problem.profile, load, cells)
    if not intervals:
        raise SceneError("load.indentation presses on less than cells can be made for: give more")
    if finer == 1:
        tolerance = START_TOLERANCE * min(problem.rtol, COARSEST_RTOL)
        intervals, cells = refine_at_free_edges(on_ground, problem.profile, load, cells, tolerance)
    else:
        # the same edges for both, so that their difference says what the size of cells costs
        edges = first_contact(problem)[1].free_edges
        cells = replace(cells, free_edges=tuple(edge.scaled(1 / finer) for edge in edges))
    return intervals, cells


def contact_cells(problem: Problem) -> tuple[ContactCells, ContactCells]:
    """Return cells over the face, small where contact begins, and half as many."""
    return first_contact(problem)[1], first_contact(problem, 0.5)[1]


def radial_space(
    problem: Problem,
    degree: int,
    rim_size: float,
    ring_size: float | Array,
    grading: float,
    degree_of_modes: int = 1,
) -> PressureSpace:
    """Return a graded space whose degrees rise away from the singular points.

    In the largest elements the degrees are at least those that smooth modes need.

    A ring narrower than the sizes still gets a layer at each of its edges, no wider than a tenth of
    the ring. Where the wear coefficient has but a weak kink, it may have none.
    """
    rings = problem.merged
    widest = np.where(rings.kinks[:-1] < WEAK_KINK, 1.0, 0.1)
    at_edges = np.minimum(ring_size, widest * rings.narrower)
    at_rim = min(rim_size, 0.1 * float(rings.widths[-1]))
    breakpoints, low_parts = exact_graded_breakpoints(rings.ring_edges, at_edges, at_rim, grading)
    linear = np.ones(len(breakpoints) - 1, dtype=np.int64)
    space = PressureSpace(breakpoints, linear, rings.ring_edges, low_parts)
    space = narrowed_for_layers(space, problem.ground)
    return replace(space, degrees=degrees(problem, space, degree, grading, degree_of_modes))


def degrees(
    problem: Problem, space: PressureSpace, highest: int, grading: float, of_modes: int
) -> Indices:
    """Return the degree of each element of a space.

    It is the degree that the accuracy asks for, but at most `highest`: most where the amplitude of
    high degrees is greatest, and lower elsewhere, but no lower than 2, nor than smooth modes ask
    for: half as much in each layer, whose elements are several times smaller. It is 0 in a hole.
    """
    edges, ring = problem.merged.ring_edges, space.ring
    at_edges, element = np.searchsorted(space.sort_keys, edges + 0j), np.arange(len(ring))
    # distances of the far ends of the elements from the edges of their rings
    from_inner = np.where(ring > 0, space.distance(at_edges[ring], element + 1), np.inf)
    from_outer = space.distance(element, at_edges[ring + 1])
    nearest = np.where(from_outer <= from_inner, ring, ring - 1)
    distance, half = np.minimum(from_inner, from_outer), np.diff(edges)[ring] / 2
    fields = with_affordable_field_tolerance(problem, grading)
    amplitude = fields.edge_amplitude(distance, half, nearest)
    layer = np.log(np.minimum(distance / half, 1.0)) / np.log(grading)
    least = np.maximum(np.ceil(of_modes * 0.5**layer), 2).astype(np.int64)
    # elements that can have the degree wanted of them have it, also where the highest is too low
    lacking = max(int(np.ceil(pressure_degree(fields, grading))) - highest, 0)
    reduction = degree_reduction(amplitude.max() / amplitude, grading)
    lower = highest - np.maximum(reduction - lacking, 0)
    raised = np.maximum(lower, np.minimum(least, max(highest, of_modes)))
    return np.where((ring == 0) & problem.merged.hollow, 0, raised)
