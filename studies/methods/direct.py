"""Direct integration: the steady state in closed form (Eqs. 21 to 27)."""

from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..problem.problem import Problem
from ..problem.quantities import FIELDS
from ..progress import Stages
from .base import Method, Solution
from .norms import Results


class Direct(Method):
    """The steady state, to roundoff."""

    name = "direct"
    what = "the steady state by direct integration, in closed form"
    lacks: ClassVar[dict[str, str]] = {"history": "direct integration knows the steady state only"}

    def refusal(self, problem: Problem) -> str:
        if problem.merged.linear:
            return (
                "direct integration knows pressures that are constant on rings, and with "
                "punch.wear_coefficient along the radius none is: leave direct out of methods, or "
                "give steps, or many rings"
            )
        if problem.indentation is not None:
            return (
                "direct knows steady states, and with load.indentation nothing presses in the "
                "end: leave it out of methods"
            )
        return ""

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        with stages("integrating"):
            states = _states(problems)
            return [
                _solution(problem, state) for problem, state in zip(problems, states, strict=True)
            ]


class State(NamedTuple):
    """A steady state.

    (N,) pressures, greatest displacement and RMS slope; nan where these are not wanted.
    """

    pressures: Array
    greatest: float
    slope: float


def _states(problems: Sequence[Problem]) -> list[State]:
    """Of problems on the same rings."""
    # pressures whose greatest displacements are sought at once, few enough to stay in memory
    at_once = 2**16
    ring_edges = problems[0].merged.ring_edges
    pressures = np.stack([direct.steady_pressures(*problem.merged) for problem in problems], axis=1)
    slopes = greatest = np.full(len(problems), np.nan)
    if any(problem.wants("steady_rms_slope") for problem in problems):
        slopes = direct.rms_slope(ring_edges, pressures, problems[0].gradient_average)
    if any(
        problem.wants("steady_displacement_max") or problem.wants("steady_profile")
        for problem in problems
    ):
        parts = np.array_split(pressures, 1 + pressures.size // at_once, axis=1)
        greatest = np.concatenate(
            [direct.greatest_displacement(ring_edges, part) for part in parts]
        )
    return [
        State(pressures[:, at], float(greatest[at]), float(slopes[at]))
        for at in range(len(problems))
    ]


def steady(problem: Problem, radii: Array) -> Results:
    """The steady state in closed form, its fields at radii (R,); non-dimensional."""
    return _sampled(problem, radii, _states([problem])[0])


def _sampled(problem: Problem, radii: Array, state: State) -> Results:
    (ring_edges, wear_coefficients), pressures = problem.merged, state.pressures
    values: dict[str, Callable[[], Array]] = {
        "steady_pressure": lambda: pressures[ring_of(ring_edges, radii)],
        "steady_profile": lambda: np.maximum(
            state.greatest - direct.displacement(ring_edges, pressures, radii), 0.0
        ),
        "steady_displacement_max": lambda: np.asarray(state.greatest),
        "steady_rms_slope": lambda: np.asarray(state.slope),
        "steady_wear_rate": lambda: np.asarray(wear_coefficients[0] * pressures[0]),
    }
    return {name: value() for name, value in values.items() if problem.wants(name)}


def _solution(problem: Problem, state: State) -> Solution:
    results = _sampled(problem, problem.radii, state)
    fields = problem.quantities is None or problem.quantities & FIELDS
    checked = _sampled(problem, problem.face.radii, state) if fields else results
    # a narrow ring of high pressure is the small difference of two discs
    lost = float(np.abs(direct.pressure_steps(state.pressures)) @ problem.merged.ring_edges[1:])
    # the mean displacement is at least that of the mean pressure at the rim (Betti)
    roundoff = 1e-12 + 4 * np.finfo(float).eps * lost / float(np.fmax(state.greatest, 4 / np.pi**2))
    errors = dict.fromkeys(results, np.asarray(roundoff))
    return Solution(results, checked, errors, {"roundoff": roundoff})


METHOD = Direct()
