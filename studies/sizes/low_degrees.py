"""Sizes of meshes for elements of a low degree, which are halved before they are used.

Linear elements on triangles, and elements of a degree below `LAYERED` on quadrilaterals, do not
resolve layers that shrink fourfold. They are asked for by `accuracy.fem.degree`, and never chosen
by default. What they err by is judged by the same mesh, halved once less: where errors fall with
the first power of the size or faster, they are at most the difference
(tests/physics/test_low_degrees.py).
"""

from typing import TypedDict

import numpy as np

from ...meshes.radial import Array
from ..problem.problem import Problem
from .defaults import (
    TRIANGLES_ACROSS_RINGS,
    TRIANGLES_AT_RIM,
    TRUNCATION,
    WIDER_TRUNCATION,
    triangle_ring_sizes,
)

LOW_DEGREE_HALVINGS = 2
"""Times that every element is halved; those that it is judged by are halved once less."""
LAYER_FACTOR = 0.5
"""Size of a layer of quadrilaterals over that of the layer outside it."""
LOW_DEGREE_GROWTH = 1.0
"""Growth of quadrilaterals between the layers with the distance from them."""
GREATEST_PART_OF_RING = 0.3
"""Greatest size at a ring edge, before halving, over the narrower ring beside it."""


class LowDegreeSizes(TypedDict):
    """Sizes of quadrilaterals, by the names of the arguments of `meshes.by_gmsh.quads.graded`."""

    sizes: Array
    rim_size: float
    factor: float
    growth: float
    outer: float


def low_degree_quad_sizes(problem: Problem) -> LowDegreeSizes:
    """Return the sizes of quadrilaterals of a low degree, before they are halved.

    Once halved, sizes at ring edges and rim are those of triangles, whose degree is low, too, or
    those that the scene gives.
    """
    chosen, halves = problem.fem, 2**LOW_DEGREE_HALVINGS
    rings, outermost = problem.merged, float(problem.merged.widths[-1])
    at_edges = chosen.ring_size or triangle_ring_sizes(problem)
    at_rim = min(TRIANGLES_AT_RIM * problem.rtol, outermost / TRIANGLES_ACROSS_RINGS)
    far = TRUNCATION if chosen.far_field == "boussinesq" else WIDER_TRUNCATION
    return {
        "sizes": np.minimum(halves * at_edges, GREATEST_PART_OF_RING * rings.narrower),
        "rim_size": min(halves * (chosen.rim_size or at_rim), GREATEST_PART_OF_RING * outermost),
        "factor": LAYER_FACTOR,
        "growth": chosen.growth or LOW_DEGREE_GROWTH,
        "outer": chosen.truncation or far,
    }
