"""Default sizes of every method, by the wanted accuracy.

`ringwear study tradeoff` shows that no other sizes reach an accuracy much faster,
physics/test_estimates.py that each accuracy is reached on scenes drawn at random, and `ringwear
study convergence` the orders behind the powers. Sizes beside ring edges are in `ring_edges.py`,
degrees of the pressure in `degrees.py`. Lengths are in punch radii. Constants name what
shows them, a test under `tests/` or a study, where there is one.
"""

from dataclasses import replace
from typing import Any, TypedDict

import numpy as np

from ...meshes.contact_cells import ContactCells
from ...meshes.radial import Array
from ...meshes.sizes import EdgeAmplitude, SizeField
from ..problem.problem import Problem
from ..problem.quantities import FINEST_RTOL
from ..problem.sections import DEGREES, LAYERED
from .degrees import degree_of_modes, pressure_degree, with_affordable_field_tolerance
from .layers import depths_of_interfaces, truncation_beside
from .ring_edges import (
    FACTOR,
    RADIAL_ROUNDOFF,
    edge_sizes,
    fem_smallest,
    rim_size,
    ring_sizes,
    smallest_size,
)

# ratio of the widths of neighbouring elements on the radial mesh of the MDR and of boundary
# elements: with more, more elements reach the same size, and with less, each needs a higher degree
# (physics/test_size_rules.py, `ringwear study tradeoff`)
RADIAL_GRADING = 0.2
# highest degree of the pressure on that mesh
HIGHEST_DEGREE = 20
# truncation radius of quadrilaterals with Boussinesq's far field, in a
# (`ringwear study truncation`)
TRUNCATION = 2.5
# truncation radius of triangles, and of a clamped boundary, in a (`ringwear study truncation`)
WIDER_TRUNCATION = 5.0
# growth of quadrilaterals between the patches with the distance from them
# (physics/test_size_rules.py)
GROWTH = 0.5
# least degree of the pressure on quadrilaterals: of less, the coarser solution would have linear
# pressures, too far off to judge by
LEAST_TO_JUDGE_BY = 3.0
# degrees of the displacement above that of the pressure on quadrilaterals, before rounding up
# (physics/test_size_rules.py, `ringwear study convergence`)
ABOVE_PRESSURE = 1.45
# degrees more for each digit that 1 - 2 nu loses; the accuracy near incompressibility is held by
# physics/test_estimates.py::test_nothing_locks
DEGREES_PER_DIGIT_OF_COMPRESSIBILITY = 0.4
# degrees that the displacement has to spare before the first of these is added
DEGREES_TO_SPARE = 0.2
# Poisson's ratio beyond which degrees rise no more: 1/2 is modelled as 0.49999
GREATEST_POISSON_RATIO = 0.4999
# accuracy at which sizes and growth of triangles, and numbers of cells, are told
USUAL_RTOL = 1e-4
# size of triangles at the rim over rtol: it costs d0 a tenth of that or less
# (physics/test_five_rings.py::test_the_dial_of_the_fem)
TRIANGLES_AT_RIM = 0.1
# parts of the outermost ring, or of that beside a hole, that a triangle there is at most one of
TRIANGLES_ACROSS_RINGS = 4
# size of triangles at a ring edge over the first sliding distance, if that is greater than the next
TRIANGLES_PER_WORN_LENGTH = 0.5
# power of rtol below which no size at a ring edge follows the first sliding distance
POWER_OF_LEAST_WORN_LENGTH = 0.75
# size of triangles at a ring edge over the narrower ring beside it, where rtol is 1
TRIANGLES_AT_RINGS = 10
# power of rtol that this falls by: elements of degree 4 converge by a power of their size, not
# by layers
POWER_AT_RINGS = 0.6
# greatest size of triangles at a ring edge over that ring
GREATEST_AT_RINGS = 0.25
# growth of triangles with the distance from ring edges at the usual rtol
# (physics/test_size_rules.py)
TRIANGLE_GROWTH = 0.7
# greatest growth of triangles: beyond, neighbours would differ too much for good shapes
GREATEST_GROWTH = 0.9
# size of triangles at the centre, in a, at the usual rtol: energies hardly feel the value there,
# which people look at
TRIANGLES_AT_CENTRE = 0.2
# greatest size of triangles at the centre, in a
GREATEST_AT_CENTRE = 0.5
# power of rtol that size at the centre and growth follow: an eighth or so, for energies of degree 4
# converge with the power 8 of the size
POWER_OF_TRIANGLES = 0.115
# greatest size of triangles over the truncation. In d0, sides of a quarter of the truncation cost
# 2e-6 in degree 3 and 1e-8 in degree 4, of an eighth nothing
FAR_TRIANGLES = 0.125
# the same in degree 4, down to the next constant
FAR_TRIANGLES_OF_HIGHEST_DEGREE = 0.25
# rtol below which a cost of 1e-8 in d0 is not negligible
FINE_RTOL = 1e-6
# share of the energy that the truncation may lose, at most
# (physics/test_size_rules.py, `ringwear study truncation`)
NEGLIGIBLE = 1e-9
# times by which it stays below rtol
MARGIN_OF_TRUNCATION = 10
# step of the march on the uniform grid over the greatest stable one (`ringwear study march`)
STABLE_PART = 0.5
# cells of the face where edges of the contact move, at the usual rtol; an edge is known to a cell
# (physics/test_contact_march.py::test_random_punches_respect_their_error_estimates)
USUAL_CELLS = 150
# fewest cells, below which an estimate by half as many says nothing
FEWEST_CELLS = 80
# most cells: as many as a tenth of the usual rtol asks for take minutes
MOST_CELLS = 300
# pressures that a shaped punch may have at first, for its cells to become as many as the most; more
# than these take half a minute
PRESSURES_AT_FIRST = 800
# the least part of these that is reckoned with where the load varies and steps begin anew at each
# change of it, as often as if there were so many
PART_UNDER_VARYING_LOADS = 0.5
# greatest cells at ring edges, in a
GREATEST_AT_EDGES = 1e-3
# growth of cells with the distance from ring edges
CELL_GROWTH = 0.4


class QuadSizes(TypedDict):
    """Sizes of quadrilaterals, by the names of the arguments of `meshes.quads.graded`."""

    sizes: Array
    rim_size: float
    factor: float
    growth: float
    outer: float
    edge_amplitude: EdgeAmplitude
    lacking_degrees: int
    interfaces: tuple[float, ...]
    rigid: bool


def mdr_sizes(problem: Problem) -> dict[str, Any]:
    """Return the sizes of the radial mesh of the MDR and of boundary elements.

    The names are those of the arguments of `methods.spaces.radial_space`.

    Notes
    -----
    Sizes at ring edges and rim are those of `ring_sizes` and `rim_size`, but not below
    `smallest_size`; degrees those of `pressure_degree` and `degree_of_modes`, rounded up. What the
    scene gives stays. Shown by physics/test_five_rings.py::test_the_dial_of_the_mdr.
    """
    chosen, grading = problem.mdr, problem.mdr.grading or RADIAL_GRADING
    fields = with_affordable_field_tolerance(problem, grading)
    modes = np.ceil(degree_of_modes(problem))
    degree = np.ceil(pressure_degree(fields, grading))
    smallest = smallest_size(problem, RADIAL_ROUNDOFF)
    return {
        "degree": chosen.degree or min(int(degree), HIGHEST_DEGREE),
        "degree_of_modes": chosen.degree or min(int(modes), HIGHEST_DEGREE),
        "rim_size": chosen.rim_size or max(rim_size(problem, fields), smallest),
        "ring_size": chosen.ring_size or np.maximum(ring_sizes(problem, fields), smallest),
        "grading": grading,
    }


def missing_layers(problem: Problem, smallest: float) -> Array:
    """Return how many layers of elements (T,) a mesh lacks at each time.

    Parameters
    ----------
    problem : the times are its `estimate_times`
    smallest : least size of the elements of the mesh; 0 if it has no least size

    Notes
    -----
    ``ln(wanted / smallest) / ln(FACTOR)``, where `edge_sizes` of that time is below the smallest.
    """
    missing = np.zeros(len(problem.estimate_times))
    for number, time in enumerate(problem.estimate_times):
        since = replace(problem, times=np.array([time]))
        wanted = float(edge_sizes(since).min()) if since.earliest else np.inf
        missing[number] = max(np.log(wanted / smallest) / np.log(FACTOR), 0.0) if smallest else 0.0
    return missing


def quad_sizes(problem: Problem) -> QuadSizes:
    """Return the sizes of quadrilaterals in geometric layers.

    Notes
    -----
    Sizes at ring edges and rim are those of `ring_sizes` and `rim_size`, but not below
    `fem_smallest`. What the scene gives stays. Shown by
    physics/test_five_rings.py::test_the_dial_of_the_fem.
    """
    chosen, fields = problem.fem, with_affordable_field_tolerance(problem, FACTOR)
    wanted = np.maximum(ring_sizes(problem, fields), fem_smallest(problem))
    far = TRUNCATION if chosen.far_field == "boussinesq" else WIDER_TRUNCATION
    interfaces = depths_of_interfaces(problem)
    return {
        "sizes": np.full(len(wanted), chosen.ring_size) if chosen.ring_size else wanted,
        "rim_size": chosen.rim_size or max(rim_size(problem, fields), fem_smallest(problem)),
        "factor": FACTOR,
        "growth": chosen.growth or GROWTH,
        "outer": chosen.truncation or truncation_beside(interfaces, far),
        "edge_amplitude": fields.edge_amplitude,
        "lacking_degrees": max(wanted_quad_degree(problem) - quad_degree(problem), 0),
        "interfaces": interfaces,
        "rigid": problem.ground is not None and problem.ground.rigid,
    }


def quad_degree(problem: Problem) -> int:
    """Return the degree of the displacement on quadrilaterals: the one given, else the wanted one.

    Elements have a least and a greatest degree.
    """
    degree = int(np.clip(wanted_quad_degree(problem), LAYERED, DEGREES["quads"][-1]))
    return problem.fem.degree or degree


def wanted_quad_degree(problem: Problem) -> int:
    """Return the degree of the displacement on quadrilaterals that the accuracy asks for.

    Notes
    -----
    With the degree q of the pressure, the greater of `pressure_degree`, `degree_of_modes` and
    LEAST_TO_JUDGE_BY, it is

        q + ABOVE_PRESSURE + max(0, -0.2 - 0.4 log10(1 - 2 nu))

    rounded up. The last term rises towards incompressibility, which costs two digits in the end.
    Shown by physics/test_estimates.py::test_nothing_locks.
    """
    of_pressure = pressure_degree(with_affordable_field_tolerance(problem, FACTOR), FACTOR)
    compressibility = 1 - 2 * min(problem.poisson_ratio, GREATEST_POISSON_RATIO)
    digits_lost = DEGREES_PER_DIGIT_OF_COMPRESSIBILITY * np.log10(compressibility)
    wanted = (
        max(of_pressure, degree_of_modes(problem), LEAST_TO_JUDGE_BY)
        + ABOVE_PRESSURE
        + max(0.0, -DEGREES_TO_SPARE - digits_lost)
    )
    return int(np.ceil(wanted))


def triangle_ring_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (N-1,) of triangles at the ring edges, in powers of two.

    Notes
    -----
    The least of ``TRIANGLES_AT_RINGS rtol^0.6 b``, ``GREATEST_AT_RINGS b``, with the width b of the
    narrower ring, and the worn length ``max(TRIANGLES_PER_WORN_LENGTH tau, rtol^0.75)`` of the
    first sliding distance tau. Sizes at a hole are as at the rim. The degree of triangles is low,
    and smaller ones would not help fields. Shown by
    physics/test_five_rings.py::test_fem_on_triangles.
    """
    rtol, narrower, worn = problem.rtol, problem.merged.narrower, 1.0
    if problem.earliest:
        least = rtol**POWER_OF_LEAST_WORN_LENGTH
        worn = max(TRIANGLES_PER_WORN_LENGTH * problem.earliest, least)
    share = min(TRIANGLES_AT_RINGS * rtol**POWER_AT_RINGS, GREATEST_AT_RINGS)
    wanted = np.minimum(share * narrower, worn)
    if problem.merged.hollow:
        wanted[0] = min(TRIANGLES_AT_RIM * rtol, float(narrower[0]) / TRIANGLES_ACROSS_RINGS)
    return np.asarray(2.0 ** np.floor(np.log2(wanted)))


def triangle_degree(problem: Problem) -> int:
    """Return the degree of the displacement on triangles: the one given, else the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(problem.fem.degree or highest, highest)


def triangle_sizes(problem: Problem) -> SizeField:
    """Return the sizes of graded triangles.

    Notes
    -----
    At the rim ``TRIANGLES_AT_RIM rtol``, at ring edges those of `triangle_ring_sizes`. The growth
    and the size at the centre follow ``(rtol / USUAL_RTOL)^0.115``. Shown by
    physics/test_five_rings.py::test_the_dial_of_the_fem.
    """
    rtol, chosen, ring_edges = problem.rtol, problem.fem, problem.merged.ring_edges
    across_rim = float(ring_edges[-1] - ring_edges[-2]) / TRIANGLES_ACROSS_RINGS
    coarser = (rtol / USUAL_RTOL) ** POWER_OF_TRIANGLES
    highest = triangle_degree(problem) == DEGREES["gmsh"][-1]
    far = FAR_TRIANGLES_OF_HIGHEST_DEGREE if highest and rtol > FINE_RTOL else FAR_TRIANGLES
    return SizeField(
        ring_edges=tuple(float(edge) for edge in ring_edges),
        rim_size=chosen.rim_size or min(TRIANGLES_AT_RIM * rtol, across_rim),
        ring_size=chosen.ring_size or tuple(float(size) for size in triangle_ring_sizes(problem)),
        growth=chosen.growth or min(TRIANGLE_GROWTH * coarser, GREATEST_GROWTH),
        truncation=chosen.truncation or WIDER_TRUNCATION,
        centre_size=min(TRIANGLES_AT_CENTRE * coarser, GREATEST_AT_CENTRE),
        far_size=far,
    )


def pole_orders(problem: Problem, truncation: float) -> tuple[int, ...]:
    """Return the orders of the poles tied to the outer boundary.

    Notes
    -----
    Those asked for, or as many as keep the share of the energy that the truncation loses below
    ``min(NEGLIGIBLE, rtol / MARGIN_OF_TRUNCATION)`` (`fem.far_field.enough_poles`). Shown by
    physics/test_orders.py::test_truncation_by_every_far_field.
    """
    from ...fem.far_field import enough_poles

    if problem.fem.poles:
        return tuple(range(0, 2 * problem.fem.poles, 2))
    return enough_poles(truncation, min(NEGLIGIBLE, problem.rtol / MARGIN_OF_TRUNCATION))


def coarser_pole_orders(orders: tuple[int, ...]) -> tuple[int, ...]:
    """Return the orders of the poles that those of a solution are compared with.

    They are one less; but one pole is compared with two, because without any the boundary would be
    clamped, which errs by far more than one pole does (1.1 a/R in place of (a/R)^5).
    """
    return orders[:-1] if len(orders) > 1 else (0, 2)


def grid_step(problem: Problem, stability_limit: float) -> float:
    """Return the step of the march on the uniform grid.

    Notes
    -----
    The one asked for, or STABLE_PART of the greatest stable one, above which the explicit march
    blows up (`ringwear study march`).
    """
    if problem.mdr.step:
        return problem.mdr.step / problem.units.time
    if problem.step and problem.march == "explicit":
        return problem.step
    return STABLE_PART * stability_limit


def tolerance_range(problem: Problem, pressures: int) -> tuple[float, float]:
    """Return the least and the greatest accuracy that sizes follow.

    Parameters
    ----------
    problem : for a shaped punch, sizes are those of `cells_of`
    pressures : number of pressures at first

    Notes
    -----
    Of a shaped punch, ``USUAL_RTOL (USUAL_CELLS / n)^2`` with the greatest and the least number n
    of cells. Where there were more than PRESSURES_AT_FIRST pressures at first, the least accuracy
    is not so far below that asked for, so that a refinement ends in half a minute.
    """
    if problem.full_contact:
        return FINEST_RTOL, 1.0
    least, greatest = (
        USUAL_RTOL * (USUAL_CELLS / count) ** 2 for count in (MOST_CELLS, FEWEST_CELLS)
    )
    ratio = max(pressures / PRESSURES_AT_FIRST, PART_UNDER_VARYING_LOADS * problem.loading.varies)
    return max(least, min(problem.rtol, greatest) * ratio**2), greatest


def cells_of(problem: Problem, finer: float = 1.0) -> ContactCells:
    """Return the cells that an accuracy asks for, before it is known where contact begins.

    Parameters
    ----------
    problem : with its accuracy and its rings
    finer : factor on the number of cells

    Notes
    -----
    ``USUAL_CELLS sqrt(USUAL_RTOL / rtol)`` cells, of a number between the fewest and the most,
    because the edges of the contact are known to a cell, and d errs by less than fields do. At ring
    edges they are no larger than rtol, because pressures are singular there. Shown by
    physics/test_contact_march.py::test_random_punches_respect_their_error_estimates.
    """
    wanted = USUAL_CELLS * (USUAL_RTOL / problem.rtol) ** 0.5
    count = finer * float(np.clip(wanted, FEWEST_CELLS, MOST_CELLS))
    edge = min(problem.rtol, GREATEST_AT_EDGES) / finer**2
    return ContactCells(
        tuple(problem.merged.ring_edges.tolist()),
        1 / count,
        edge,
        growth=CELL_GROWTH / finer**0.5,
        spread=1 / count,
        hollow=problem.merged.hollow,
    )
