"""Direct integration: the steady state in closed form (Eqs. 21 to 27)."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
import xarray

from ringwear.mdr import direct
from ringwear.meshes.radial import Array, ring_of
from ringwear.studies.methods.base import Method, Solution
from ringwear.studies.methods.costs import Cost, direct_terms, rates
from ringwear.studies.methods.quantities import FIELDS, labelled
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages

# pressures whose greatest displacements are sought at once, few enough to stay in memory
AT_ONCE = 2**16


class Direct(Method):
    """The steady state, to roundoff."""

    name = "direct"
    what = "the steady state by direct integration, in closed form"
    look: ClassVar[dict[str, Any]] = {"color": "black", "linestyle": ":", "linewidth": 1.4, "marker": "x", "markersize": 3.5}
    lacks: ClassVar[dict[str, str]] = {"history": "direct integration knows the steady state only"}

    def described(self, problem: Problem) -> str:
        return "closed form, nothing to resolve"

    def counted(self, problem: Problem) -> tuple[int, int]:
        return 0, len(problem.merged.wear_coefficients)

    def cost(self, problem: Problem) -> Cost:
        rings = len(problem.merged.wear_coefficients)
        return Cost(0, rings, float(rates()["direct"]["seconds"] @ direct_terms(rings)), 1e-12)

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        ring_edges, average = problems[0].merged.ring_edges, problems[0].gradient_average
        pressures = np.stack([direct.steady_pressures(*problem.merged) for problem in problems], axis=1)
        slopes = greatest = np.empty(0)
        with stages("integrating"):
            if any(problem.wants("steady_rms_slope") for problem in problems):
                slopes = direct.rms_slopes(ring_edges, pressures, average)
            if any(problem.wants("steady_displacement_max") or problem.wants("steady_profile") for problem in problems):
                parts = np.array_split(pressures, 1 + pressures.size // AT_ONCE, axis=1)
                greatest = np.concatenate([direct.greatest_displacements(ring_edges, part) for part in parts])
            # a narrow ring of high pressure is the small difference of two discs
            lost = np.abs(direct.pressure_steps(pressures)).T @ ring_edges[1:]
            return [
                _solution(problem, pressures[:, i], greatest[i : i + 1], slopes[i : i + 1], float(lost[i]))
                for i, problem in enumerate(problems)
            ]


def _solution(problem: Problem, pressures: Array, greatest: Array, slope: Array, lost: float) -> Solution:
    """One steady state; `greatest` and `slope` are empty where they are not wanted."""
    ring_edges, wear_coefficients = problem.merged

    def at(radii: Array) -> xarray.Dataset:
        values: dict[str, Callable[[], Array]] = {
            "steady_pressure": lambda: pressures[ring_of(ring_edges, radii)],
            "steady_profile": lambda: np.maximum(greatest - direct.displacement(ring_edges, pressures, radii), 0.0),
            "steady_displacement_max": lambda: greatest[0],
            "steady_rms_slope": lambda: slope[0],
            "steady_wear_rate": lambda: np.asarray(wear_coefficients[0] * pressures[0]),
        }
        return labelled({name: value() for name, value in values.items() if problem.wants(name)}, np.empty(0), radii)

    results = at(problem.radii)
    checked = at(problem.face.radii) if problem.quantities is None or problem.quantities & FIELDS else results
    # the mean displacement is at least that of the mean pressure at the rim (Betti)
    roundoff = 1e-12 + 4 * np.finfo(float).eps * lost / (greatest[0] if len(greatest) else 4 / np.pi**2)
    errors = {str(name): np.asarray(roundoff) for name in results.data_vars}
    return Solution(results, checked, errors, {"roundoff": roundoff})


METHOD = Direct()
