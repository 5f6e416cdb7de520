"""The pressure spaces that suit a problem, and coarser ones.

A flat punch has singular pressures at ring edges and rim for early times: geometric layers of high
degree. Where edges of the contact move, pressures jump at places that are not known beforehand:
linear pressures on cells.
"""

from functools import lru_cache

import numpy as np

from ...mdr import energy
from ...meshes.contact_cells import ContactCells
from ...meshes.errors import SceneError
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices, graded_breakpoints, ring_of
from ...meshes.sizes import spared_degrees
from ..problem.defaults import affordable, cells_of, mdr_sizes
from ..problem.problem import Problem
from ..wear.contact_edges import located
from ..wear.unilateral import Interval, Load


def pressure_spaces(problem: Problem) -> tuple[PressureSpace, PressureSpace]:
    """Return the pressure space that suits a problem, and one that is coarser in everything."""
    if not problem.full_contact:
        fine, coarse = contact_cells(problem)
        return fine.space(), coarse.space()
    space = radial_space(problem, **mdr_sizes(problem))
    return space, space.coarser()


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
    intervals, cells = located(energy.compliance, problem.profile, load_at_start(problem), cells)
    if not intervals:
        raise SceneError("load.indentation presses on less than cells can be made for: give more")
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
    """Return a graded space whose degrees rise away from the singular points, to at least that of
    smooth modes in the largest elements.

    A ring narrower than the sizes still gets a layer at each of its edges: none is wider than a
    tenth of the ring.
    """
    rings = problem.merged
    at_edges = np.minimum(ring_size, 0.1 * rings.narrower)
    at_rim = min(rim_size, 0.1 * float(rings.widths[-1]))
    breakpoints = graded_breakpoints(rings.ring_edges, at_edges, at_rim, grading)
    return PressureSpace(
        breakpoints,
        degrees(problem, breakpoints, degree, grading, degree_of_modes),
        rings.ring_edges,
    )


def degrees(
    problem: Problem, breakpoints: Array, highest: int, grading: float, of_modes: int
) -> Indices:
    """Return the degree of each element.

    It is `highest` where most is needed, and as much lower elsewhere as less stands behind it, but
    no lower than 2, nor than smooth modes ask for: half as much in each layer, whose elements are
    several times smaller.
    """
    edges = problem.merged.ring_edges
    ring = ring_of(edges, (breakpoints[1:] + breakpoints[:-1]) / 2)
    from_inner = np.where(ring > 0, breakpoints[1:] - edges[ring], np.inf)
    from_outer = edges[ring + 1] - breakpoints[:-1]
    nearest = np.where(from_outer <= from_inner, ring, ring - 1)
    distance, half = np.minimum(from_inner, from_outer), np.diff(edges)[ring] / 2
    behind = affordable(problem, grading).sharpness(distance, half, nearest)
    layer = np.log(np.minimum(distance / half, 1.0)) / np.log(grading)
    least = np.maximum(np.ceil(of_modes * 0.5**layer), 2).astype(np.int64)
    lower = highest - spared_degrees(behind.max() / behind, grading)
    return np.maximum(lower, np.minimum(least, max(highest, of_modes)))
