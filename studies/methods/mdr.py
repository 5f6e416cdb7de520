"""The method of dimensionality reduction.

Its energy on a graded radial mesh. Its sizes serve boundary elements, too.
"""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices, graded_breakpoints, ring_of
from ...meshes.sizes import spared_degrees
from ..problem.defaults import affordable, mdr_sizes, sharpness
from ..problem.problem import Problem
from ..progress import Stages
from .base import Cost
from .by_compliance import AnySpaceMethod, Discretised, marches_contact
from .unilateral import costs


def radial_space(
    problem: Problem,
    degree: int,
    rim_size: float,
    ring_size: float | Array,
    grading: float,
    widest: float = 0.1,
) -> PressureSpace:
    """A graded space whose degrees rise away from the singular points.

    A ring narrower than the sizes still gets a layer at each of its edges: none is wider than
    `widest` of the ring.
    """
    rings = problem.merged
    at_edges = np.minimum(ring_size, widest * rings.narrower)
    at_rim = min(rim_size, widest * float(rings.widths[-1]))
    breakpoints = graded_breakpoints(rings.ring_edges, at_edges, at_rim, grading)
    return PressureSpace(
        breakpoints, degrees(problem, breakpoints, degree, grading), rings.ring_edges
    )


def degrees(problem: Problem, breakpoints: Array, highest: int, grading: float) -> Indices:
    """Degree of each element.

    `highest` where most is needed, and as much lower elsewhere as less stands behind it.
    """
    edges = problem.merged.ring_edges
    ring = ring_of(edges, (breakpoints[1:] + breakpoints[:-1]) / 2)
    from_inner = np.where(ring > 0, breakpoints[1:] - edges[ring], np.inf)
    from_outer = edges[ring + 1] - breakpoints[:-1]
    nearest = np.where(from_outer <= from_inner, ring, ring - 1)
    behind = sharpness(affordable(problem, grading))(
        np.minimum(from_inner, from_outer), np.diff(edges)[ring] / 2, nearest
    )
    return np.maximum(
        highest - spared_degrees(behind.max() / behind, grading), min(highest, LOWEST)
    )


def smallest(sizes: dict[str, Any]) -> dict[str, float]:
    """Sizes of which each ring edge may have its own, by the smallest."""
    return {
        name: value if np.ndim(value) == 0 else float(np.min(value))
        for name, value in sizes.items()
        if np.size(value)
    }


LOWEST = 2  # degree of the pressure at a ring edge or the rim


class Mdr(AnySpaceMethod):
    """Exact for full contact, but for the pressure space."""

    name = "mdr"
    what = (
        "the half-space by dimensionality reduction, exact for full contact but for the pressure "
        "space"
    )
    look: ClassVar[dict[str, Any]] = {
        "color": "#1f4e79",
        "linestyle": "-",
        "linewidth": 2.2,
        "alpha": 0.55,
    }

    def compliance(self, space: PressureSpace) -> Compliance:
        return energy.compliance(space)

    def described(self, problem: Problem) -> str:
        if marches_contact(problem):
            return costs.described(problem)
        return ", ".join(
            f"{name} {value:.3g}" for name, value in smallest(mdr_sizes(problem)).items()
        )

    def counted(self, problem: Problem) -> tuple[int, int]:
        if marches_contact(problem):
            return costs.counted(problem, elements=False)
        size = radial_space(problem, **mdr_sizes(problem)).size
        return size, size

    def cost(self, problem: Problem) -> Cost:
        return (
            costs.cost(problem, elements=False)
            if marches_contact(problem)
            else super().cost(problem)
        )

    def refusal(self, problem: Problem) -> str:
        if not problem.full_contact and problem.mdr.given:
            return (
                "accuracy.mdr sizes the mesh of a flat punch: with an initial profile or a fixed "
                "indentation leave it out"
            )
        return super().refusal(problem)

    def sizes_given(self, problem: Problem) -> bool:
        return problem.mdr.given

    def discretised(self, problem: Problem, stages: Stages, coarser: bool = True) -> Discretised:
        sizes = mdr_sizes(problem)
        with stages("assembling"):
            fine = self.compliance(radial_space(problem, **sizes))
        other = None
        if coarser:
            with stages("estimating"):
                other = self.compliance(_coarser_space(problem, sizes))
        return Discretised(fine, other, fine.space.size, smallest(sizes))


def _coarser_space(problem: Problem, sizes: dict[str, Any]) -> PressureSpace:
    """A degree less in every element, and a layer less at every singular point, also where the
    ring's width set the layer.

    Of degree 1, with every second breakpoint.
    """
    grading = sizes["grading"] ** (2 if sizes["degree"] == 1 else 1)
    larger = {name: np.minimum(sizes[name] / grading, 0.5) for name in ("rim_size", "ring_size")}
    widest = min(0.1 / grading, 0.5)
    space = radial_space(problem, sizes["degree"], **larger, grading=grading, widest=widest)
    return replace(space, degrees=np.maximum(space.degrees - 1, 1))


METHOD = Mdr()
