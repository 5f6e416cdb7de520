"""The method of dimensionality reduction: its energy on a graded radial mesh. Its sizes serve boundary elements, too."""

from typing import Any, ClassVar

import numpy as np

from ringwear.mdr import energy
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import graded_breakpoints, layer_degrees
from ringwear.studies.methods.by_compliance import AnySpaceMethod, Discretised
from ringwear.studies.methods.estimate import RADIAL, RADIAL_FINER, Pair
from ringwear.studies.problem.defaults import mdr_sizes
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages


def radial_space(
    problem: Problem, degree: float, rim_size: float, ring_size: float, grading: float, widest: float = 0.1
) -> PressureSpace:
    """A graded space whose degrees rise away from the singular points.

    A ring narrower than the sizes still gets a layer at each of its edges: none is wider than `widest` of the ring.
    """
    rings = problem.merged
    at_edges = np.minimum(ring_size, widest * rings.narrower)
    at_rim = min(rim_size, widest * float(rings.widths[-1]))
    breakpoints = graded_breakpoints(rings.ring_edges, at_edges, at_rim, grading)
    degrees = layer_degrees(breakpoints, rings.ring_edges, int(degree), rise=1, lowest=int(max(1, degree - 5)))
    return PressureSpace(breakpoints, degrees, rings.ring_edges)


class Mdr(AnySpaceMethod):
    """Exact for full contact, but for the pressure space."""

    name = "mdr"
    what = "the half-space by dimensionality reduction, exact for full contact but for the pressure space"
    look: ClassVar[dict[str, Any]] = {"color": "#1f4e79", "linestyle": "-", "linewidth": 2.2, "alpha": 0.55}

    def compliance(self, space: PressureSpace) -> Compliance:
        return energy.compliance(space)

    def described(self, problem: Problem) -> str:
        return ", ".join(f"{name} {value:.3g}" for name, value in mdr_sizes(problem).items())

    def counted(self, problem: Problem) -> tuple[int, int]:
        size = radial_space(problem, **mdr_sizes(problem)).size
        return size, size

    def sizes_given(self, problem: Problem) -> bool:
        return problem.mdr.given

    def discretised(self, problem: Problem, stages: Stages, pairs: bool = True) -> Discretised:
        sizes = mdr_sizes(problem)
        with stages("assembling"):
            fine = self.compliance(radial_space(problem, **sizes))
        if not pairs:
            return Discretised(fine, (), fine.space.size, dict(sizes))
        with stages("estimating"):
            return Discretised(fine, (self._pair(problem, fine),), fine.space.size, dict(sizes))

    def _pair(self, problem: Problem, fine: Compliance) -> Pair:
        """One layer less at every singular point, and one degree less."""
        sizes = mdr_sizes(problem)
        layer = sizes["grading"]
        coarser = {"degree": max(1, sizes["degree"] - 1), "grading": layer}
        coarser |= {name: min(sizes[name] / layer, 0.5) for name in ("rim_size", "ring_size")}
        # also where the ring's width, not the size asked for, set the layer
        space = radial_space(problem, **coarser, widest=min(0.1 / layer, 0.5))
        if sizes["degree"] > 2 and len(space.breakpoints) < len(fine.space.breakpoints):
            return Pair("pressure space", fine, self.compliance(space), RADIAL)
        narrow = 0.1 * float(problem.merged.widths.min())
        finer = {"degree": sizes["degree"] + 1, "grading": layer}
        finer |= {name: layer * min(sizes[name], narrow) for name in ("rim_size", "ring_size")}
        return Pair("pressure space", self.compliance(radial_space(problem, **finer)), fine, RADIAL_FINER)


METHOD = Mdr()
