"""Pressure spaces that suit a problem, and coarser ones for the error estimate.

A flat punch has singular pressures at ring edges and at the rim at early times; its space has
geometric layers of high degree. If edges of the contact move, pressures jump at places that are not
known beforehand; the space then has linear pressures on cells.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.contact_cells import ContactCells
from ....meshes.errors import SceneError
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, Indices, exact_graded_breakpoints
from ....meshes.sizes import degree_reduction
from ..problem.problem import Problem
from ..problem.profile import InitialProfile
from ..sizes.cells import cells_of, graded_to_worn_layers
from ..sizes.defaults import mdr_sizes, pressure_degree, with_affordable_field_tolerance
from ..sizes.layers import narrowed_for_layers
from ..wear.contact_edges import (
    covers_face,
    find_first_contact,
    refine_at_free_edges,
    refinements_of,
)
from ..wear.unilateral import Interval, Load

# Strength of a kink of the wear coefficient (`Rings.kinks`) below which an edge needs no layer.
WEAK_KINK = 0.1
# Change of the start by smaller cells that is tolerated, over rtol; and the largest rtol that
# counts, because cells do not get coarser beyond it.
START_TOLERANCE, COARSEST_RTOL = 0.2, 1e-3
# Points of the quadrature, besides two for each degree, in the search for the first contact, which
# only determines cells. Energies are then right to 1e-7 (unit/mdr/test_transforms.py).
EXTRA_POINTS_OF_SEARCH = 4


class PressureSpaces(NamedTuple):
    """The pressure space that suits a problem, and one that is coarser in every respect.

    Parameters
    ----------
    fine, coarse : the spaces
    nested : whether the coarse space is a subspace of the fine one; its compliance is then a
        restriction and need not be computed anew
    smallest_sizes : the sizes from which the fine space was made, the smallest where each ring edge
        has its own; empty for cells
    """

    fine: PressureSpace
    coarse: PressureSpace
    nested: bool
    smallest_sizes: Mapping[str, float]


def choose_spaces(problem: Problem) -> PressureSpaces:
    """Return the pressure spaces that suit the contact of a problem."""
    return SPACES[problem.full_contact](problem)


def pressure_spaces(problem: Problem) -> tuple[PressureSpace, PressureSpace]:
    """Return the pressure space that suits a problem, and one that is coarser in every respect."""
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


# by whether the punch is in full contact
SPACES = {True: _graded_spaces, False: _spaces_of_cells}


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
    intervals, cells = find_first_contact(*_initial_press(problem), cells_of(problem))
    if not intervals:
        raise SceneError(
            "load.indentation makes a contact that is too small for cells: give a larger one"
        )
    if covers_face(intervals):
        cells = graded_to_worn_layers(problem, cells)
    tolerance = START_TOLERANCE * min(problem.rtol, COARSEST_RTOL)
    return refine_at_free_edges(*_initial_press(problem), cells, tolerance)


@lru_cache(maxsize=16)
def scaled_cells(problem: Problem, factor: float) -> ContactCells:
    """Return about `factor` times as many cells as those of `first_contact`.

    They are small at the same ring edges and free edges, so that the difference of two solutions
    shows the effect of the size of cells. The places where contact begins are searched for anew, so
    that the difference also shows the error of these places. The cells there have the scaled size:
    the new search may find another one.
    """
    _, at_contact = find_first_contact(
        *_initial_press(problem), cells_of(problem).multiplied(factor)
    )
    cells = first_contact(problem)[1].multiplied(factor)
    places = ((inner, outer) for inner, outer, _ in at_contact.refinements)
    return replace(cells, refinements=refinements_of(cells.spread, places))


def _initial_press(
    problem: Problem,
) -> tuple[Callable[[PressureSpace], Compliance], InitialProfile, Load]:
    """Return the compliance on a space, the face and the load that determine the first contact."""
    compliance_on = partial(
        energy.compliance, ground=problem.ground, extra_points=EXTRA_POINTS_OF_SEARCH
    )
    return compliance_on, problem.profile, load_at_start(problem)


def contact_cells(problem: Problem) -> tuple[ContactCells, ContactCells]:
    """Return cells of the face, small where contact begins, and half as many cells."""
    return first_contact(problem)[1], scaled_cells(problem, 0.5)


def radial_space(
    problem: Problem,
    degree: int,
    rim_size: float,
    ring_size: float | Array,
    grading: float,
    degree_of_modes: int = 1,
) -> PressureSpace:
    """Return a graded space whose degrees rise away from the singular points.

    In the largest elements the degrees are at least those that smooth modes need. At each of its
    edges, a ring has a layer that is no wider than a tenth of the ring, even if the wanted sizes
    are larger. An edge where the wear coefficient has only a weak kink may have none.
    """
    rings = problem.merged
    max_part_of_ring = np.where(rings.kinks[:-1] < WEAK_KINK, 1.0, 0.1)
    at_edges = np.minimum(ring_size, max_part_of_ring * rings.narrower)
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

    The degree is `highest` where the amplitude of high degrees is largest. Elsewhere it is lower,
    as far as the amplitude allows, but at least 2 and at least the degree that smooth modes need.
    That degree halves from layer to layer towards the edges, because the elements there are several
    times smaller.

    Parameters
    ----------
    problem, space : the problem, and a space with the same elements
    highest : highest degree of the pressure
    grading : size ratio of neighbouring elements
    of_modes : degree that smooth modes need on the largest elements
    """
    edges, ring = problem.merged.ring_edges, space.ring
    at_edges, element = np.searchsorted(space.sort_keys, edges + 0j), np.arange(len(ring))
    # distances of the far end of each element from both edges of its ring
    from_inner = np.where(edges[ring] > 0, space.distance(at_edges[ring], element + 1), np.inf)
    from_outer = space.distance(element, at_edges[ring + 1])
    # amplitudes are those at edges except the centre
    nearest = np.where(from_outer <= from_inner, ring + 1, ring) - int(edges[0] == 0)
    distance, half_width = np.minimum(from_inner, from_outer), np.diff(edges)[ring] / 2
    fields = with_affordable_field_tolerance(problem, grading)
    amplitude = fields.edge_amplitude(distance, half_width, nearest)
    layer = np.log(np.minimum(distance / half_width, 1.0)) / np.log(grading)
    lowest = np.maximum(np.ceil(of_modes * 0.5**layer), 2).astype(np.int64)
    # If `highest` is below the wanted degree, elements whose own wanted degree is possible keep it.
    lacking = max(int(np.ceil(pressure_degree(fields, grading))) - highest, 0)
    # `pressure_degree` counts a hole like a ring at the axis
    hole = edges[:1][edges[:1] > 0]
    in_hole = fields.edge_amplitude(hole, hole / 2, np.zeros(len(hole), dtype=np.int64))
    greatest = max(amplitude.max(), in_hole.max(initial=0.0))
    reduction = degree_reduction(greatest / amplitude, grading)
    lowered = highest - np.maximum(reduction - lacking, 0)
    return np.maximum(lowered, np.minimum(lowest, max(highest, of_modes)))
