"""Default sizes: every rule from the wanted accuracy to a size or a degree, with the study that shows it.

`ringwear study tradeoff` shows that no other sizes reach an accuracy much faster, `ringwear study estimates` that each
accuracy is reached on scenes drawn at random, `ringwear study convergence` the orders behind the powers.
Lengths in punch radii.
"""

from dataclasses import dataclass

import numpy as np

from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import SizeField
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.sections import DEGREES

# of the half-space: quadrilaterals with Boussinesq's far field, and anything else (`ringwear study truncation`)
TRUNCATION, WIDER_TRUNCATION = 2.5, 5.0
# of quadrilaterals: a layer is smaller by this than the one outside it; elements between the patches grow by that
FACTOR, GROWTH = 0.25, 0.8
# in smaller elements at the rim, coordinates have too few digits left (`ringwear study extremes`)
SMALLEST_RIM = 1e-9
# rings of this width or more need the degree that the accuracy asks for
WIDE = 0.2


def mdr_sizes(problem: Problem) -> dict[str, float]:
    """Of the radial mesh of the MDR and of boundary elements."""
    rtol, chosen = problem.rtol, problem.mdr
    return {
        "degree": chosen.degree or round(3 - np.log10(rtol)),
        "rim_size": chosen.rim_size or 0.1 * rtol,
        "ring_size": chosen.ring_size or 3e-3 * rtol**0.25,
        "grading": chosen.grading or 0.2,
    }


def ring_sizes(problem: Problem) -> Array:
    """(N-1,) wanted sizes at the ring edges between centre and rim, in a few distinct values."""
    rtol, narrower = problem.rtol, problem.merged.narrower
    # in proportion to the narrower ring beside each edge, and less so where rings are so narrow that their pattern has
    # little of the energy
    share = np.minimum(10 * rtol**0.6 * np.maximum(1, 1 / (32 * narrower)), 0.25)
    # wear blunts a ring edge over a length of k E* v0 t: the first time asked for is the sharpest to resolve
    blunted = max(0.5 * problem.earliest, rtol**0.75) if problem.earliest else 1.0
    return np.asarray(2.0 ** np.floor(np.log2(np.minimum(share, blunted / narrower) * narrower)))


@dataclass(frozen=True)
class QuadSizes:
    """Degree of the displacement, and sizes of the smallest elements."""

    degree: int
    ring_sizes: tuple[float, ...]
    rim_size: float
    growth: float
    truncation: float
    factor: float = FACTOR


def quad_sizes(problem: Problem) -> QuadSizes:
    """Of quadrilaterals in geometric layers."""
    rtol, chosen, narrower = problem.rtol, problem.fem, problem.merged.narrower
    widest = problem.merged.widths.max()
    degree = chosen.degree or quad_degree(rtol, widest, problem.poisson_ratio)
    # as many layers as degrees, fewer for rings that are all narrow; or more if the first time after the start asks for them
    smallest = narrower / 2 * FACTOR ** (degree - 1) * max(1.0, WIDE / widest)
    layered = np.minimum(ring_sizes(problem), smallest)
    sizes = np.full(len(narrower), chosen.ring_size) if chosen.ring_size else layered
    return QuadSizes(
        degree=degree,
        ring_sizes=tuple(float(size) for size in sizes),
        rim_size=chosen.rim_size or max(min(0.1 * rtol, 10.0**-degree), SMALLEST_RIM),
        growth=chosen.growth or GROWTH,
        truncation=chosen.truncation or (TRUNCATION if chosen.far_field == "boussinesq" else WIDER_TRUNCATION),
    )


def quad_degree(rtol: float, widest: float, poisson_ratio: float) -> int:
    """Degree that an accuracy asks for (`ringwear study convergence`).

    Three for every four digits; one less for rings of a tenth of the width, whose pattern has less of the energy; more
    towards incompressibility, which costs two digits in the end.
    """
    compressibility = 1 - 2 * min(poisson_ratio, 0.4999)
    wanted = 2.7 - 0.75 * np.log10(rtol) + 0.4 * abs(np.log10(compressibility))
    wanted += 0.9 * np.log10(min(widest / WIDE, 1.0))
    return int(np.clip(round(wanted), DEGREES["quads"][0], DEGREES["quads"][-1]))


def triangle_degree(problem: Problem) -> int:
    """Degree of the displacement on triangles: the one given, else the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(problem.fem.degree or highest, highest)


def triangle_sizes(problem: Problem) -> SizeField:
    """Of graded triangles."""
    rtol, chosen, ring_edges = problem.rtol, problem.fem, problem.merged.ring_edges
    return SizeField(
        ring_edges=tuple(float(edge) for edge in ring_edges),
        rim_size=chosen.rim_size or min(0.1 * rtol, float(ring_edges[-1] - ring_edges[-2]) / 4),
        ring_size=chosen.ring_size or tuple(float(size) for size in ring_sizes(problem)),
        growth=chosen.growth or min(0.7 * (rtol / 1e-4) ** 0.115, 0.9),
        truncation=chosen.truncation or WIDER_TRUNCATION,
        centre_size=min(0.2 * (rtol / 1e-4) ** 0.115, 0.5),
        # in d0, sides of a quarter of the truncation cost 2e-6 in degree 3 and 1e-8 in degree 4, of an eighth nothing
        far_size=0.25 if triangle_degree(problem) == DEGREES["gmsh"][-1] and rtol > 1e-6 else 0.125,
    )


def truncation(problem: Problem) -> float:
    """Radius of the half-space."""
    return (quad_sizes if problem.fem.meshed_by == "quads" else triangle_sizes)(problem).truncation


def pole_orders(problem: Problem, truncation: float) -> tuple[int, ...]:
    """Orders of the poles tied to the outer boundary: those asked for, or enough of them."""
    from ringwear.fem.far_field import enough_poles

    if problem.fem.poles:
        return tuple(range(0, 2 * problem.fem.poles, 2))
    return enough_poles(truncation, min(1e-9, problem.rtol / 10))


def grid_step(problem: Problem, stability_limit: float) -> float:
    """Of the march on the uniform grid: half of the greatest stable one (`ringwear study march`)."""
    if problem.mdr.step:
        return problem.mdr.step / problem.units.time
    return problem.step if problem.step and problem.march == "explicit" else 0.5 * stability_limit
