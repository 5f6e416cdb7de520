"""Number and sizes of the cells of a face whose contact opens, closes and spreads.

Lengths are in punch radii a. The comment on a constant names the test under `tests/` that justifies
it, if there is one.
"""

from dataclasses import replace

import numpy as np

from ....meshes.contact_cells import ContactCells
from ....meshes.sizes import REFERENCE_RTOL
from ..problem.problem import Problem
from ..problem.quantities import FINEST_RTOL

# Number of cells of the face at REFERENCE_RTOL if edges of the contact move. An edge is located to
# within a cell (physics/test_random_punches.py::
# test_estimates_of_contact_radii_include_the_cell_at_the_edge).
REFERENCE_CELLS = 150
# Smallest number of cells. With fewer, half as many cells would give no valid error estimate.
FEWEST_CELLS = 80
# Largest number of cells. The number that a tenth of REFERENCE_RTOL would need takes minutes.
MOST_CELLS = 300
# Largest number of pressures of a refined shaped punch. A march with more takes half a minute.
MAX_REFINED_PRESSURES = 800
# Lower limit of (number of pressures / MAX_REFINED_PRESSURES) under varying loads: the march begins
# anew with small steps at every change of the load, which costs about as much.
MIN_PRESSURE_RATIO_UNDER_VARYING_LOADS = 0.5
# Upper limit of the size of cells at ring edges, in a.
MAX_CELL_SIZE_AT_EDGES = 1e-3
# Growth of the size of cells per distance from ring edges.
CELL_GROWTH = 0.4
# For contact that has no free edge at the start, as under a flat face. There, the thin layers that
# wear makes at ring edges by the first time limit the accuracy of fields, not edges of the contact
# (physics/test_random_scenes.py::test_early_layers_under_a_full_face_are_resolved).
#
# Size of the cells at ring edges and at the rim over the worn length at the first time after the
# start: this number times rtol, but at most the second. Errors of the slope are proportional to it.
CELL_PER_WORN_LENGTH, MAX_CELL_PER_WORN_LENGTH = 0.05, 0.02
# Smallest such size, in a.
SMALLEST_CELL_IN_LAYERS = 1e-11
# Growth of the size of these cells per distance over sqrt(rtol): pressures are linear on cells,
# so that their error is proportional to the square of the growth.
GROWTH_IN_LAYERS = 2.0
# Number of cells in the layers of all ring edges above which the growth is larger than that.
MOST_CELLS_IN_LAYERS = 400


def tolerance_range(problem: Problem, pressures: int) -> tuple[float, float]:
    """Return the smallest and the largest tolerance that sizes respond to.

    Parameters
    ----------
    problem : the problem; for a shaped punch, sizes are those of `cells_of`
    pressures : number of pressures on its cells before any refinement; 0 without a history

    Notes
    -----
    For a shaped punch with n cells the tolerance is ``REFERENCE_RTOL (REFERENCE_CELLS / n)^2``,
    with the largest and the smallest n. The number of pressures grows as ``rtol^-1/2``; the
    smallest tolerance is raised so that a refinement has at most MAX_REFINED_PRESSURES of them.
    """
    if problem.full_contact:
        return FINEST_RTOL, 1.0
    least, greatest = (
        REFERENCE_RTOL * (REFERENCE_CELLS / count) ** 2 for count in (MOST_CELLS, FEWEST_CELLS)
    )
    ratio = max(
        pressures / MAX_REFINED_PRESSURES,
        MIN_PRESSURE_RATIO_UNDER_VARYING_LOADS * problem.loading.varies,
    )
    return max(least, min(problem.rtol, greatest) * ratio**2), greatest


def cells_of(problem: Problem) -> ContactCells:
    """Return the cells that the tolerance requires, before the places of first contact are known.

    Parameters
    ----------
    problem : the problem, with its tolerance and its rings

    Notes
    -----
    There are ``REFERENCE_CELLS sqrt(REFERENCE_RTOL / rtol)`` cells, within FEWEST_CELLS and
    MOST_CELLS: edges of the contact are located to within a cell, and d is more accurate than
    fields are. At ring edges, where pressures are singular, cells are no larger than rtol. Shown by
    test_at_most_one_of_12_punches_is_undecided of physics/test_random_punches.py.
    """
    wanted = REFERENCE_CELLS * (REFERENCE_RTOL / problem.rtol) ** 0.5
    size = 1 / float(np.clip(wanted, FEWEST_CELLS, MOST_CELLS))
    return ContactCells(
        tuple(problem.merged.ring_edges.tolist()),
        size,
        min(problem.rtol, MAX_CELL_SIZE_AT_EDGES),
        growth=CELL_GROWTH,
        spread=size,
    )


def graded_to_worn_layers(problem: Problem, cells: ContactCells) -> ContactCells:
    """Return cells that also resolve the layers that wear makes at ring edges by the first time.

    Parameters
    ----------
    problem : the problem, with its tolerance, rings and times
    cells : cells for it
    """
    worn_length = float(problem.edge_amplitude.worn_length_slow.min())
    size_per_length = min(CELL_PER_WORN_LENGTH * problem.rtol, MAX_CELL_PER_WORN_LENGTH)
    size = min(max(size_per_length * worn_length, SMALLEST_CELL_IN_LAYERS), cells.edge_size)
    # cells of the layers on one side of an edge, times their growth: from `size` to `largest`
    cells_times_growth = np.log(cells.largest / size)
    sides = 2 * len(problem.merged.from_axis) - 3
    growth = max(
        GROWTH_IN_LAYERS * problem.rtol**0.5, sides * cells_times_growth / MOST_CELLS_IN_LAYERS
    )
    return replace(cells, edge_size=size, growth=min(cells.growth, growth))
