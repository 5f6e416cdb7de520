"""Sizes of meshes for elements of a low degree, which are halved before they are used.

Linear elements on triangles, and elements of a degree below `LAYERED` on quadrilaterals, are too
inaccurate for layers that shrink by a factor of four. They are used only if the scene sets
`accuracy.fem.degree`, never by default. Their error is estimated by the same mesh, halved once
less: if errors fall at least in proportion to the size, they are at most the difference of the two
solutions (tests/physics/test_low_degrees.py).
"""

from typing import TypedDict

import numpy as np

from ....meshes.radial import Array
from ..problem.problem import Problem
from .defaults import (
    MIN_TRIANGLES_ACROSS_RING,
    TRIANGLE_SIZE_AT_RIM,
    TRUNCATION,
    WIDER_TRUNCATION,
    triangle_ring_sizes,
)

LOW_DEGREE_HALVINGS = 2
"""How often every element is halved; in the coarser mesh for the error estimate, once less."""
LOW_DEGREE_GRADING = 0.5
"""Size of a layer of quadrilaterals over that of the next layer outwards."""
LOW_DEGREE_GROWTH = 1.0
"""Growth of the size of quadrilaterals between the layers, per distance from them."""
MAX_SIZE_PER_RING_WIDTH = 0.3
"""Largest size at a ring edge before halving, over the width of the narrower ring there."""


class LowDegreeSizes(TypedDict):
    """Sizes of quadrilaterals; the keys are the arguments of `meshes.by_gmsh.quads.graded`."""

    sizes: Array
    rim_size: float
    factor: float
    growth: float
    outer: float


def low_degree_quad_sizes(problem: Problem) -> LowDegreeSizes:
    """Return the sizes of quadrilaterals of a low degree, before they are halved.

    After halving, the sizes at ring edges and at the rim are those that the scene sets, or else
    those of triangles, which also have a low degree.
    """
    scene_sizes, scale = problem.fem, 2**LOW_DEGREE_HALVINGS
    rings, outermost = problem.merged, float(problem.merged.widths[-1])
    at_edges = scene_sizes.ring_size or triangle_ring_sizes(problem)
    at_rim = min(TRIANGLE_SIZE_AT_RIM * problem.rtol, outermost / MIN_TRIANGLES_ACROSS_RING)
    truncation = TRUNCATION if scene_sizes.far_field == "boussinesq" else WIDER_TRUNCATION
    return {
        "sizes": np.minimum(scale * at_edges, MAX_SIZE_PER_RING_WIDTH * rings.narrower),
        "rim_size": min(
            scale * (scene_sizes.rim_size or at_rim), MAX_SIZE_PER_RING_WIDTH * outermost
        ),
        "factor": LOW_DEGREE_GRADING,
        "growth": scene_sizes.growth or LOW_DEGREE_GROWTH,
        "outer": scene_sizes.truncation or truncation,
    }
