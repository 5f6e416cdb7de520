"""Sizes and degrees of quadrilaterals under a flat punch: in geometric layers, or halved.

Lengths are in punch radii a. The comment on a constant names the test under `tests/` or the study
that justifies it.
"""

from typing import TYPE_CHECKING

import numpy as np

from ....meshes.by_gmsh.outline import truncation_with_interfaces
from ....meshes.radial import Array
from ....meshes.sizes import FAR_TRUNCATION, NEAR_TRUNCATION
from ..problem.problem import Problem
from ..problem.sections import DEGREES, LAYERED
from .degrees import (
    degree_of_modes,
    pressure_degree,
    shortest_slow_waves,
    with_affordable_field_tolerance,
)
from .ring_edges import QUAD_GRADING, axis_size, fem_smallest, rim_size, ring_sizes
from .triangles import size_at_rim, triangle_ring_sizes

if TYPE_CHECKING:
    from ....meshes.by_gmsh.quads import GradedQuads

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
# checked by physics/test_flat_punch.py::test_indentation_on_quadrilaterals.
DEGREES_PER_DIGIT_OF_COMPRESSIBILITY = 0.4
# Part of these added degrees that EXTRA_DISPLACEMENT_DEGREES already covers.
SPARE_DISPLACEMENT_DEGREES = 0.2
# Poisson's ratio above which no more degrees are added.
MAX_POISSON_RATIO = 0.4999
# Phase of the shortest of the slowest modes across a quadrilateral of a thin layer, over the degree
# of the displacement (physics/test_thin_layers.py::test_slowest_modes_of_thin_layers).
PHASE_PER_DEGREE = 0.5
# Size of a layer over that of the next layer outwards, growth between the layers per distance, and
# largest size at a ring edge over the width of the narrower ring there, of elements of a low degree
# before they are halved (physics/test_low_degrees.py).
LOW_DEGREE_GRADING, LOW_DEGREE_GROWTH, LOW_DEGREE_SIZE_PER_RING_WIDTH = 0.5, 1.0, 0.3


def layered_quads(problem: Problem) -> "GradedQuads":
    """Return quadrilaterals in geometric layers round every ring edge.

    Notes
    -----
    Sizes at ring edges and at the rim are those of `ring_sizes` and `rim_size`, but at least
    `fem_smallest`. A size that the scene sets replaces the one here. Shown by
    physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_fem.
    """
    from ....meshes.by_gmsh.quads import graded  # triangles do not need it

    scene_sizes, fields = problem.fem, with_affordable_field_tolerance(problem, QUAD_GRADING)
    smallest, interfaces = fem_smallest(problem), tuple(problem.ground.depths.tolist())
    truncation = truncation_with_interfaces(interfaces, _truncation(problem))
    return graded(
        problem.merged.ring_edges,
        scene_sizes.ring_size or np.maximum(ring_sizes(problem, fields), smallest),
        scene_sizes.rim_size or max(rim_size(problem, fields), smallest),
        QUAD_GRADING,
        scene_sizes.growth or GROWTH,
        scene_sizes.truncation or truncation,
        edge_amplitude=fields.edge_amplitude,
        lacking_degrees=max(wanted_quad_degree(problem) - quad_degree(problem), 0),
        interfaces=interfaces,
        rigid=problem.ground.rigid,
        under_face=largest_under_face(problem),
        axis_size=axis_size(fields),
    )


def quads_to_halve(problem: Problem, halvings: int) -> "GradedQuads":
    """Return the quadrilaterals that elements of a low degree are made from by halving.

    After that, the sizes at ring edges and at the rim are those that the scene sets, or else those
    of triangles, which also have a low degree. Layers that shrink by a factor of four would be too
    inaccurate for these elements.
    """
    from ....meshes.by_gmsh.quads import graded

    scene_sizes, scale, rings = problem.fem, 2**halvings, problem.merged
    at_edges = scale * (scene_sizes.ring_size or triangle_ring_sizes(problem))
    at_rim = scale * (scene_sizes.rim_size or size_at_rim(problem))
    return graded(
        rings.ring_edges,
        np.minimum(at_edges, LOW_DEGREE_SIZE_PER_RING_WIDTH * rings.narrower),
        min(at_rim, LOW_DEGREE_SIZE_PER_RING_WIDTH * float(rings.widths[-1])),
        LOW_DEGREE_GRADING,
        scene_sizes.growth or LOW_DEGREE_GROWTH,
        scene_sizes.truncation or _truncation(problem),
    )


def _truncation(problem: Problem) -> float:
    """Return the truncation radius that the far field of a scene suggests."""
    return NEAR_TRUNCATION if problem.fem.far_field == "boussinesq" else FAR_TRUNCATION


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
        return PHASE_PER_DEGREE * quad_degree(problem) / waves


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
    are lost. Shown by physics/test_flat_punch.py::test_indentation_on_quadrilaterals.
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
