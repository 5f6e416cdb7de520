"""Default sizes of the discretisation of every method, as functions of the tolerance `rtol`.

Each function reads the tolerance from the problem (`problem.rtol`) and returns sizes; sizes that
the scene sets itself replace them. Sizes at ring edges come from `ring_edges.py`, polynomial
degrees of the pressure from `degrees.py`. Lengths are in punch radii a.

The comment on a constant names the test under `tests/` or the study that justifies it, if there is
one. Besides, `ringwear study tradeoff` shows that no other sizes reach a tolerance much faster,
physics/test_estimates.py that the sizes reach each tolerance on random scenes, and `ringwear study
convergence` the orders of convergence behind the powers of `rtol`.
"""

from dataclasses import replace
from typing import Any, TypedDict

import numpy as np

from ....meshes.by_gmsh.outline import truncation_with_interfaces
from ....meshes.radial import Array
from ....meshes.sizes import EdgeAmplitude, SizeField
from ..problem.problem import Problem
from ..problem.sections import DEGREES, LAYERED
from .degrees import (
    degree_of_modes,
    pressure_degree,
    shortest_slow_waves,
    with_affordable_field_tolerance,
)
from .ring_edges import (
    QUAD_GRADING,
    RADIAL_ROUNDOFF,
    edge_sizes,
    fem_smallest,
    rim_size,
    ring_sizes,
    smallest_size,
)

# Size ratio of neighbouring elements on the radial mesh of the MDR and of boundary elements. A
# larger ratio needs more elements to reach the same smallest size, a smaller one a higher degree on
# each (physics/test_size_rules.py, `ringwear study tradeoff`).
RADIAL_GRADING = 0.2
# Highest degree of the pressure on the radial mesh.
HIGHEST_DEGREE = 20
# Truncation radius of the mesh of quadrilaterals with Boussinesq's far field, in a (`ringwear study
# truncation`).
TRUNCATION = 2.5
# Truncation radius of meshes of triangles, and of all meshes with a clamped outer boundary, in a
# (`ringwear study truncation`).
WIDER_TRUNCATION = 5.0
# Growth of the size of quadrilaterals between the patches, per distance from the patches
# (physics/test_size_rules.py).
GROWTH = 0.5
# Lowest degree of the pressure on quadrilaterals. With a lower one, the coarser solution used for
# the error estimate would have linear pressures, which are too inaccurate for that.
LOWEST_PRESSURE_DEGREE = 3.0
# Degree of the displacement minus degree of the pressure on quadrilaterals, before rounding up
# (physics/test_size_rules.py, `ringwear study convergence`).
EXTRA_DISPLACEMENT_DEGREES = 1.45
# Degrees of the displacement that are added per decade by which 1 - 2 nu falls. The accuracy is
# checked by physics/test_estimates.py::test_no_locking_near_incompressibility.
DEGREES_PER_DIGIT_OF_COMPRESSIBILITY = 0.4
# Part of these added degrees that EXTRA_DISPLACEMENT_DEGREES already covers.
SPARE_DISPLACEMENT_DEGREES = 0.2
# Poisson's ratio above which no more degrees are added.
MAX_POISSON_RATIO = 0.4999
# Phase of the shortest of the slowest modes across a quadrilateral of a thin layer, over the degree
# of the displacement (physics/test_thin_layers.py::test_slowest_modes_of_thin_layers).
PHASE_PER_DEGREE = 0.5
# Tolerance at which the constants for triangle sizes and cell counts below are stated.
REFERENCE_RTOL = 1e-4
# Size of triangles at the rim, in a, over rtol. The initial indentation d0 has a relative error of
# at most a tenth of it (physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_fem).
TRIANGLE_SIZE_AT_RIM = 0.1
# Least number of triangles across the outermost ring, and across the ring next to a hole.
MIN_TRIANGLES_ACROSS_RING = 4
# Size of triangles at a ring edge over the first sliding distance (non-dimensional).
TRIANGLE_SIZE_PER_WORN_LENGTH = 0.5
# Lower limit of that size: rtol to this power, in a.
MIN_WORN_LENGTH_POWER = 0.75
# Size of triangles at a ring edge over the narrower ring's width, at rtol = 1 (extrapolated).
TRIANGLE_SIZE_AT_RINGS = 10
# Power of rtol in that size. Elements of degree 4 converge algebraically in their size, not
# exponentially in a number of layers.
TRIANGLE_SIZE_POWER_AT_RINGS = 0.6
# Upper limit of the size of triangles at a ring edge over the width of the narrower ring there.
MAX_TRIANGLE_SIZE_AT_RINGS = 0.25
# Growth of the size of triangles per distance from ring edges at REFERENCE_RTOL
# (physics/test_size_rules.py).
TRIANGLE_GROWTH = 0.7
# Upper limit of that growth, beyond which neighbouring triangles would be badly shaped.
MAX_TRIANGLE_GROWTH = 0.9
# Size of triangles at the centre at REFERENCE_RTOL, in a. Energies hardly depend on it, but people
# look at the value of the solution there.
TRIANGLE_SIZE_AT_CENTRE = 0.2
# Upper limit of the size of triangles at the centre, in a.
MAX_TRIANGLE_SIZE_AT_CENTRE = 0.5
# Power of rtol in the size at the centre and in the growth: about 1/8, because energies of elements
# of degree 4 converge with the power 8 of the size.
TRIANGLE_SIZE_POWER = 0.115
# Upper limit of the size of triangles over the truncation radius. With a quarter, the relative
# error of d0 is 2e-6 in degree 3 and 1e-8 in degree 4; with an eighth, none.
FAR_TRIANGLE_SIZE = 0.125
# The same limit in degree 4 if rtol is above FINE_RTOL.
FAR_TRIANGLE_SIZE_DEGREE_4 = 0.25
# Tolerance below which the relative error 1e-8 of d0 is no longer negligible.
FINE_RTOL = 1e-6
# Upper limit of the share of the energy that the truncation may lose (physics/test_size_rules.py,
# `ringwear study truncation`).
MAX_TRUNCATION_LOSS = 1e-9
# That share is also smaller than rtol by this factor.
TRUNCATION_MARGIN = 10
# Time step of the march on the uniform grid over the largest stable one (`ringwear study march`).
STABLE_STEP_FRACTION = 0.5


class QuadSizes(TypedDict):
    """Sizes of quadrilaterals; the keys are the arguments of `meshes.by_gmsh.quads.graded`."""

    sizes: Array
    rim_size: float
    factor: float
    growth: float
    outer: float
    edge_amplitude: EdgeAmplitude
    lacking_degrees: int
    interfaces: tuple[float, ...]
    rigid: bool
    under_face: Array


def mdr_sizes(problem: Problem) -> dict[str, Any]:
    """Return the sizes of the radial mesh of the MDR and of boundary elements.

    The keys are the arguments of `methods.spaces.radial_space`. Sizes at ring edges and at the rim
    are those of `ring_sizes` and `rim_size`, but at least `smallest_size`. Degrees are those of
    `pressure_degree` and `degree_of_modes`, rounded up. Values that the scene sets replace these.
    Shown by physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_mdr.
    """
    scene_sizes, grading = problem.mdr, problem.mdr.grading or RADIAL_GRADING
    fields = with_affordable_field_tolerance(problem, grading)
    modes = np.ceil(degree_of_modes(problem))
    degree = np.ceil(pressure_degree(fields, grading))
    smallest = smallest_size(problem, RADIAL_ROUNDOFF)
    return {
        "degree": scene_sizes.degree or min(int(degree), HIGHEST_DEGREE),
        "degree_of_modes": scene_sizes.degree or min(int(modes), HIGHEST_DEGREE),
        "rim_size": scene_sizes.rim_size or max(rim_size(problem, fields), smallest),
        "ring_size": scene_sizes.ring_size or np.maximum(ring_sizes(problem, fields), smallest),
        "grading": grading,
    }


def missing_layers(problem: Problem, smallest: float) -> Array:
    """Return how many layers of elements (T,) the mesh lacks at each time for the error estimate.

    Parameters
    ----------
    problem : its `estimate_times` are those times
    smallest : smallest element size that the method can use; 0 if there is no limit

    Notes
    -----
    ``ln(wanted / smallest) / ln(QUAD_GRADING)``, but at least 0, with the smallest size `wanted` of
    `edge_sizes` if the history begins at that time.
    """
    layers = np.zeros(len(problem.estimate_times))
    for index, time in enumerate(problem.estimate_times):
        problem_at_time = replace(problem, times=np.array([time]))
        wanted = float(edge_sizes(problem_at_time).min()) if problem_at_time.earliest else np.inf
        layers[index] = (
            max(np.log(wanted / smallest) / np.log(QUAD_GRADING), 0.0) if smallest else 0.0
        )
    return layers


def quad_sizes(problem: Problem) -> QuadSizes:
    """Return the sizes of quadrilaterals in geometric layers.

    Notes
    -----
    Sizes at ring edges and at the rim are those of `ring_sizes` and `rim_size`, but at least
    `fem_smallest`. A size that the scene sets replaces the one here. Shown by
    physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_fem.
    """
    scene_sizes, fields = problem.fem, with_affordable_field_tolerance(problem, QUAD_GRADING)
    wanted = np.maximum(ring_sizes(problem, fields), fem_smallest(problem))
    truncation = TRUNCATION if scene_sizes.far_field == "boussinesq" else WIDER_TRUNCATION
    interfaces = tuple(problem.ground.depths.tolist())
    return {
        "sizes": np.full(len(wanted), scene_sizes.ring_size) if scene_sizes.ring_size else wanted,
        "rim_size": scene_sizes.rim_size or max(rim_size(problem, fields), fem_smallest(problem)),
        "factor": QUAD_GRADING,
        "growth": scene_sizes.growth or GROWTH,
        "outer": scene_sizes.truncation or truncation_with_interfaces(interfaces, truncation),
        "edge_amplitude": fields.edge_amplitude,
        "lacking_degrees": max(wanted_quad_degree(problem) - quad_degree(problem), 0),
        "interfaces": interfaces,
        "rigid": problem.ground.rigid,
        "under_face": largest_under_face(problem),
    }


def largest_under_face(problem: Problem) -> Array:
    """Return the largest size (N,) of quadrilaterals in the first layer under each ring.

    Notes
    -----
    On thin layers the slowest modes are not the longest ones: a nearly incompressible layer of
    thickness h on a stiff base is most compliant at wavelengths of 3 h. With the greatest wave
    number s of the slowest modes of a ring (`degrees.shortest_slow_waves`), elements of degree p
    are at most ``PHASE_PER_DEGREE p / s`` wide. The size is infinite under rings whose slowest
    modes are their longest ones. Shown by
    physics/test_thin_layers.py::test_slowest_modes_of_thin_layers.
    """
    waves = shortest_slow_waves(problem)
    with np.errstate(divide="ignore"):
        return np.asarray(PHASE_PER_DEGREE * quad_degree(problem) / waves)


def quad_degree(problem: Problem) -> int:
    """Return the degree of the displacement on quadrilaterals.

    It is that of the scene, or else the wanted one, within the limits of the elements.
    """
    degree = int(np.clip(wanted_quad_degree(problem), LAYERED, DEGREES["quads"][-1]))
    return problem.fem.degree or degree


def wanted_quad_degree(problem: Problem) -> int:
    """Return the degree of the displacement on quadrilaterals that the tolerance requires.

    Notes
    -----
    With the degree q of the pressure, the maximum of `pressure_degree`, `degree_of_modes` and
    LOWEST_PRESSURE_DEGREE, it is

        q + EXTRA_DISPLACEMENT_DEGREES + max(0, -0.2 - 0.4 log10(1 - 2 nu))

    rounded up. The last term grows as the half-space becomes incompressible, where up to two digits
    are lost. Shown by physics/test_estimates.py::test_no_locking_near_incompressibility.
    """
    degree_of_fields = pressure_degree(
        with_affordable_field_tolerance(problem, QUAD_GRADING), QUAD_GRADING
    )
    compressibility = 1 - 2 * min(problem.poisson_ratio, MAX_POISSON_RATIO)
    digits_lost = DEGREES_PER_DIGIT_OF_COMPRESSIBILITY * np.log10(compressibility)
    wanted = (
        max(degree_of_fields, degree_of_modes(problem), LOWEST_PRESSURE_DEGREE)
        + EXTRA_DISPLACEMENT_DEGREES
        + max(0.0, -SPARE_DISPLACEMENT_DEGREES - digits_lost)
    )
    return int(np.ceil(wanted))


def triangle_ring_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (M-1,) of triangles at the ring edges, rounded down to powers of two.

    Notes
    -----
    The size at an edge is the minimum of

        TRIANGLE_SIZE_AT_RINGS rtol^0.6 b,   MAX_TRIANGLE_SIZE_AT_RINGS b,
        max(TRIANGLE_SIZE_PER_WORN_LENGTH tau, rtol^0.75)

    with the width b of the narrower ring at the edge and the first sliding distance tau. The edge
    of a hole has the size of the rim. Triangles have a low degree, so that smaller ones than these
    would not make fields more accurate. Shown by physics/test_five_rings.py::test_fem_on_triangles.
    """
    rtol, narrower, worn_length = problem.rtol, problem.merged.narrower, 1.0
    if problem.earliest:
        min_worn_length = rtol**MIN_WORN_LENGTH_POWER
        worn_length = max(TRIANGLE_SIZE_PER_WORN_LENGTH * problem.earliest, min_worn_length)
    size_per_width = min(
        TRIANGLE_SIZE_AT_RINGS * rtol**TRIANGLE_SIZE_POWER_AT_RINGS, MAX_TRIANGLE_SIZE_AT_RINGS
    )
    wanted = np.minimum(size_per_width * narrower, worn_length)
    if problem.inner_radius:
        wanted[0] = min(TRIANGLE_SIZE_AT_RIM * rtol, float(narrower[0]) / MIN_TRIANGLES_ACROSS_RING)
    return np.asarray(2.0 ** np.floor(np.log2(wanted)))


def triangle_degree(problem: Problem) -> int:
    """Return the degree of the displacement on triangles: the one of the scene or the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(problem.fem.degree or highest, highest)


def triangle_sizes(problem: Problem) -> SizeField:
    """Return the sizes of graded triangles.

    Notes
    -----
    The size is ``TRIANGLE_SIZE_AT_RIM rtol`` at the rim and that of `triangle_ring_sizes` at ring
    edges. Growth and size at the centre are proportional to ``(rtol / REFERENCE_RTOL)^0.115``.
    Shown by physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_fem.
    """
    rtol, scene_sizes, ring_edges = problem.rtol, problem.fem, problem.merged.ring_edges
    across_rim = float(ring_edges[-1] - ring_edges[-2]) / MIN_TRIANGLES_ACROSS_RING
    scale = (rtol / REFERENCE_RTOL) ** TRIANGLE_SIZE_POWER
    highest = triangle_degree(problem) == DEGREES["gmsh"][-1]
    far_size = FAR_TRIANGLE_SIZE_DEGREE_4 if highest and rtol > FINE_RTOL else FAR_TRIANGLE_SIZE
    return SizeField(
        ring_edges=tuple(float(edge) for edge in ring_edges),
        rim_size=scene_sizes.rim_size or min(TRIANGLE_SIZE_AT_RIM * rtol, across_rim),
        ring_size=scene_sizes.ring_size
        or tuple(float(size) for size in triangle_ring_sizes(problem)),
        growth=scene_sizes.growth or min(TRIANGLE_GROWTH * scale, MAX_TRIANGLE_GROWTH),
        truncation=scene_sizes.truncation or WIDER_TRUNCATION,
        centre_size=min(TRIANGLE_SIZE_AT_CENTRE * scale, MAX_TRIANGLE_SIZE_AT_CENTRE),
        far_size=far_size,
    )


def pole_orders(problem: Problem, truncation: float) -> tuple[int, ...]:
    """Return the orders of the far-field poles that are tied to the outer boundary.

    Notes
    -----
    The number of poles is that of the scene, or else the smallest with which the truncation loses
    at most the share ``min(MAX_TRUNCATION_LOSS, rtol / TRUNCATION_MARGIN)`` of the energy
    (`fem.far_field.enough_poles`). Shown by
    unit/studies/study/test_ways.py::test_truncation_by_every_far_field.
    """
    from ....fem.far_field import enough_poles

    if problem.fem.poles:
        return tuple(range(0, 2 * problem.fem.poles, 2))
    return enough_poles(truncation, min(MAX_TRUNCATION_LOSS, problem.rtol / TRUNCATION_MARGIN))


def coarser_pole_orders(orders: tuple[int, ...]) -> tuple[int, ...]:
    """Return the orders of the poles of the coarser solution used for the error estimate.

    It has one pole less. But one pole is compared with two, because without any the boundary would
    be clamped: its error is 1.1 a/R, far greater than the (a/R)^5 of one pole.
    """
    return orders[:-1] if len(orders) > 1 else (0, 2)


def grid_step(problem: Problem, stability_limit: float) -> float:
    """Return the time step of the march on the uniform grid.

    It is the step of the scene, or else STABLE_STEP_FRACTION of the largest stable step (`ringwear
    study march`).
    """
    if problem.mdr.step:
        return problem.mdr.step / problem.units.time
    if problem.step and problem.march == "explicit":
        return problem.step
    return STABLE_STEP_FRACTION * stability_limit
