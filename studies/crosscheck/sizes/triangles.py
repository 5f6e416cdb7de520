"""Sizes and degrees of graded triangles under a flat punch.

Lengths are in punch radii a. The comment on a constant names the test under `tests/` or the study
that justifies it.
"""

import numpy as np

from ....meshes.radial import Array
from ....meshes.sizes import FAR_TRUNCATION, REFERENCE_RTOL, SizeField
from ..problem.problem import Problem
from ..problem.sections import DEGREES
from .degrees import with_affordable_field_tolerance
from .ring_edges import axis_size, edge_sizes

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
# Ratio of the sizes of neighbouring triangles towards an edge, by bisection.
TRIANGLE_RATIO = 0.5
# Lower limit of sizes at edges, in a: roundoff in the radii of smaller ones would be visible.
SMALLEST_TRIANGLE = 1e-12
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


def size_at_rim(problem: Problem) -> float:
    """Return the wanted size of triangles at the rim: in proportion to `rtol`."""
    across_ring = float(problem.merged.widths[-1]) / MIN_TRIANGLES_ACROSS_RING
    return min(TRIANGLE_SIZE_AT_RIM * problem.rtol, across_ring)


def triangle_ring_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (M-1,) of triangles at the ring edges, rounded down to powers of two.

    Notes
    -----
    The size at an edge is the minimum of

        TRIANGLE_SIZE_AT_RINGS rtol^0.6 b,   MAX_TRIANGLE_SIZE_AT_RINGS b,
        max(TRIANGLE_SIZE_PER_WORN_LENGTH tau, rtol^0.75)

    with the width b of the narrower ring at the edge and the first sliding distance tau. The edge
    of a hole has the size of the rim. Shown by physics/test_five_rings.py::test_fem_on_triangles.
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
    return 2.0 ** np.floor(np.log2(wanted))


def triangle_degree(problem: Problem) -> int:
    """Return the degree of the displacement on triangles: the one of the scene or the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(problem.fem.degree or highest, highest)


def triangle_sizes(problem: Problem) -> SizeField:
    """Return the sizes of graded triangles.

    Notes
    -----
    The size is ``TRIANGLE_SIZE_AT_RIM rtol`` at the rim and that of `triangle_ring_sizes` at ring
    edges. In the highest degree it is at most that of `edge_sizes`, which the layers need that wear
    makes there; fields of a lower degree would not be more accurate. Growth and size at the centre
    are proportional to ``(rtol / REFERENCE_RTOL)^0.115``. Shown by
    physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_fem and by
    physics/test_five_rings.py::test_fem_on_triangles.
    """
    rtol, scene_sizes, ring_edges = problem.rtol, problem.fem, problem.merged.ring_edges
    scale = (rtol / REFERENCE_RTOL) ** TRIANGLE_SIZE_POWER
    highest = triangle_degree(problem) == DEGREES["gmsh"][-1]
    at_rings, at_rim = triangle_ring_sizes(problem), size_at_rim(problem)
    if highest:
        layers = edge_sizes(with_affordable_field_tolerance(problem, TRIANGLE_RATIO))
        layers = 2.0 ** np.floor(np.log2(np.maximum(layers, SMALLEST_TRIANGLE)))
        at_rings, at_rim = np.minimum(at_rings, layers[:-1]), min(at_rim, float(layers[-1]))
    far_size = FAR_TRIANGLE_SIZE_DEGREE_4 if highest and rtol > FINE_RTOL else FAR_TRIANGLE_SIZE
    return SizeField(
        ring_edges=tuple(float(edge) for edge in ring_edges),
        rim_size=scene_sizes.rim_size or at_rim,
        ring_size=scene_sizes.ring_size or tuple(at_rings.tolist()),
        growth=scene_sizes.growth or min(TRIANGLE_GROWTH * scale, MAX_TRIANGLE_GROWTH),
        truncation=scene_sizes.truncation or FAR_TRUNCATION,
        centre_size=min(
            TRIANGLE_SIZE_AT_CENTRE * scale,
            MAX_TRIANGLE_SIZE_AT_CENTRE,
            axis_size(problem) or np.inf,
        ),
        far_size=far_size,
    )
