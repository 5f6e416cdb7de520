"""Quadrilaterals at a wanted accuracy: the degree grows with it, in geometric layers round every ring edge and the rim.

In d0, indentations and steady states the error falls about tenfold with each degree, and keeps its sign: the difference
to one degree and one layer less tells it reliably.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.methods import triangles
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import DEGREES

if TYPE_CHECKING:
    from ringwear.meshes.quads import GradedQuads

# a layer is smaller by this than the one outside it; elements between the patches grow by that
FACTOR, GROWTH = 0.25, 0.8
TRUNCATION = 2.5
# rings of this width or more need the degree that the accuracy asks for
WIDE = 0.2
NEARLY_INCOMPRESSIBLE = 0.4999
# rings whose widths differ by less are alike
ALIKE = 10.0
# in smaller elements at the rim, coordinates have too few digits left
SMALLEST_RIM = 1e-9


@dataclass(frozen=True)
class QuadSettings:
    """Degree of the displacement, and sizes of the smallest elements in punch radii."""

    degree: int
    sizes: tuple[float, ...]
    rim_size: float
    growth: float
    truncation: float


def settings(natural: NaturalScene) -> QuadSettings:
    """Degree and sizes at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.fem
    edges, _ = natural.phases
    widths = np.diff(edges)
    narrower = np.minimum(widths[:-1], widths[1:])
    degree = chosen.degree or _degree(rtol, widths, natural.scene.half_space.poisson_ratio)
    # as many layers as degrees, fewer for rings that are all narrow; or more if the first time after the start asks for them
    smallest = narrower / 2 * FACTOR ** (degree - 1) * max(1.0, WIDE / widths.max())
    layered = np.minimum(triangles.edge_sizes(natural), smallest)
    sizes = np.full(len(narrower), chosen.ring_size) if chosen.ring_size else layered
    return QuadSettings(
        degree=degree,
        sizes=tuple(float(size) for size in sizes),
        rim_size=chosen.rim_size or max(min(0.1 * rtol, 10.0**-degree), SMALLEST_RIM),
        growth=chosen.growth or GROWTH,
        truncation=chosen.truncation or (TRUNCATION if chosen.far_field == "boussinesq" else triangles.TRUNCATION),
    )


def _degree(rtol: float, widths: Array, poisson_ratio: float) -> int:
    """Degree that an accuracy asks for (`ringwear study convergence`).

    Three for every four digits; one less for rings of a tenth of the width, whose pattern has less of the energy; more
    towards incompressibility, which costs two digits in the end.
    """
    compressibility = 1 - 2 * min(poisson_ratio, NEARLY_INCOMPRESSIBLE)
    wanted = 2.7 - 0.75 * np.log10(rtol) + 0.4 * abs(np.log10(compressibility))
    wanted += 0.9 * np.log10(min(widths.max() / WIDE, 1.0))
    return int(np.clip(round(wanted), DEGREES["quads"][0], DEGREES["quads"][-1]))


def graded_quads(natural: NaturalScene) -> GradedQuads:
    """The mesh of the scene."""
    from ringwear.meshes.quads import graded

    chosen = settings(natural)
    return graded(natural.phases[0], chosen.sizes, chosen.rim_size, FACTOR, chosen.growth, chosen.truncation)
