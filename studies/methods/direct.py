"""Direct integration: the steady state in closed form (Eqs. 21 to 27)."""

from typing import Any, ClassVar

import numpy as np
import xarray

from ringwear.mdr import direct
from ringwear.meshes.radial import Array, ring_of
from ringwear.studies.methods.base import Cost, Method, Solution
from ringwear.studies.methods.quantities import labelled
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages


def steady(problem: Problem, radii: Array) -> xarray.Dataset:
    """The steady state in closed form, its fields at radii (R,); non-dimensional."""
    ring_edges, wear_coefficients = problem.merged
    pressures = direct.steady_pressures(ring_edges, wear_coefficients)
    greatest = direct.greatest_displacement(ring_edges, pressures)
    values = {
        "steady_pressure": pressures[ring_of(ring_edges, radii)],
        "steady_profile": np.maximum(greatest - direct.displacement(ring_edges, pressures, radii), 0.0),
        "steady_displacement_max": np.asarray(greatest),
        "steady_rms_slope": np.asarray(direct.rms_slope(ring_edges, pressures, problem.gradient_average)),
        "steady_wear_rate": np.asarray(wear_coefficients[0] * pressures[0]),
    }
    return labelled(values, radii)


class Direct(Method):
    """The steady state, to roundoff."""

    name = "direct"
    what = "the steady state by direct integration, in closed form"
    look: ClassVar[dict[str, Any]] = {"color": "black", "linestyle": ":", "linewidth": 1.4, "marker": "x", "markersize": 3.5}
    lacks: ClassVar[dict[str, str]] = {"history": "direct integration knows the steady state only"}

    def described(self, problem: Problem) -> str:
        return "closed form, nothing to resolve"

    def refusal(self, problem: Problem) -> str:
        if problem.indentation is not None:
            return (
                "direct knows steady states, and with load.indentation nothing presses in the end: leave it out of methods"
            )
        return ""

    def counted(self, problem: Problem) -> tuple[int, int]:
        return 0, len(problem.merged.wear_coefficients)

    def cost(self, problem: Problem) -> Cost:
        rings = len(problem.merged.wear_coefficients)
        return Cost(0, rings, 1e-3 + 4e-6 * rings**2, 0.1, 1e-12)

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        with stages("integrating"):
            results, checked = (steady(problem, radii) for radii in (problem.radii, problem.face.radii))
        # a narrow ring of high pressure is the small difference of two discs
        steps = np.abs(direct.pressure_steps(direct.steady_pressures(*problem.merged)))
        greatest = float(results.steady_displacement_max)
        roundoff = 1e-12 + 4 * np.finfo(float).eps * float(steps @ problem.merged.ring_edges[1:]) / greatest
        errors = {str(name): np.asarray(roundoff) for name in results.data_vars}
        return Solution(results, checked, errors, {"roundoff": roundoff})


METHOD = Direct()
