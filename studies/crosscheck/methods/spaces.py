"""Pressure spaces that suit a problem, and coarser ones for the error estimate.

A flat punch has singular pressures at ring edges and at the rim at early times; its space has
geometric layers of high degree. If edges of the contact move, pressures jump at places that are not
known beforehand; the space then has linear pressures on cells.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.contact_cells import ContactCells
from ....meshes.errors import SceneError
from ....meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.profile import InitialProfile
from ..sizes.cells import cells_of, graded_to_worn_layers
from ..sizes.radial import radial_sizes
from ..wear.contact_edges import (
    covers_face,
    find_first_contact,
    refine_at_free_edges,
    refinements_of,
)
from ..wear.unilateral import Interval, Load

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
    sizes : the sizes from which the fine space was made, for the summary; empty for cells
    """

    fine: PressureSpace
    coarse: PressureSpace
    nested: bool
    sizes: Mapping[str, float]


def choose_spaces(problem: Problem) -> PressureSpaces:
    """Return the pressure spaces that suit the contact of a problem."""
    return SPACES[problem.full_contact](problem)


def pressure_spaces(problem: Problem) -> tuple[PressureSpace, PressureSpace]:
    """Return the pressure space that suits a problem, and one that is coarser in every respect."""
    spaces = choose_spaces(problem)
    return spaces.fine, spaces.coarse


def _graded_spaces(problem: Problem) -> PressureSpaces:
    sizes = radial_sizes(problem)
    space = sizes.space(problem)
    return PressureSpaces(space, space.coarser(), True, sizes.summary)


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
