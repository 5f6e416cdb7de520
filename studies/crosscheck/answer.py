"""The answer of a run: what a user asked of the punch, by each method. Non-dimensional.

How long running-in takes is seen from the approach of the punch, which a displacement sensor on its
holder shows: once it has run in, it rises in a straight line. What ``d(t) - w t`` has still to rise
falls as a sum of positive exponentials.
"""

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.quantities import ANSWER, STATES, array
from ..problem.problem import Problem

# given with it, and kept as quantities of their own
ALSO = ("steady_wear_rate", "steady_rms_slope")


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Values of `ANSWER` by one method: NaN where it does not give them, or the scene does
    not ask.
    """
    sizes = {"state": len(STATES), "ring": len(problem.wear_coefficients)}
    found = {
        name: np.full([sizes[dim] for dim in one.dims], np.nan) for name, one in ANSWER.items()
    }
    if len(problem.times):
        _running_in(solution, found)
        if problem.full_contact:
            _start(problem, solution, found)
            _wear(problem, solution, found)
        else:
            _with_profile(problem, solution, found)
    if "steady_pressure" in solution.checked:
        found["indentation_steady"][...] = array(solution.checked, "steady_displacement_max")
        _steady(problem, solution, found)
    return found


def _running_in(solution: Solution, found: dict[str, Array]) -> None:
    if solution.wear is not None:
        found["running_in_time"][...] = solution.wear.relaxation_times[0]
        found["time_to_90"][...] = solution.wear.time_to(0.9)
        found["time_to_99"][...] = solution.wear.time_to(0.99)


def _start(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    if solution.wear is None:
        return
    flat = solution.wear.flat
    # continuous, and rising from the centre to the rim
    at_edges = flat.pressure_at(problem.ring_edges[:-1])
    found["indentation_start"][...] = flat.indentation
    found["pressure_min"][0] = at_edges
    found["pressure_max"][0] = [*at_edges[1:], np.inf]
    found["force_share"][0] = flat.ring_forces(problem.ring_edges)


def _steady(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    pressure, face = array(solution.checked, "steady_pressure"), problem.face
    for number in range(len(problem.wear_coefficients)):
        own = pressure[face.ring == number]
        found["pressure_min"][1, number], found["pressure_max"][1, number] = own.min(), own.max()
    found["force_share"][1] = face.ring_sums(face.areas * pressure)


def _wear(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    if "profile" in solution.checked:
        worn = problem.face.areas * array(solution.checked, "profile")[-1]
        found["worn_volume"][:] = problem.face.ring_sums(worn)


def _with_profile(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    """Where contact opens, closes and spreads.

    Pressures at the start may be infinite, and have no closed form.
    """
    if "ring_worn_volume" not in solution.results:
        return
    found["worn_volume"][:] = array(solution.results, "ring_worn_volume")[-1]
    if problem.times[0] == 0:
        found["indentation_start"][...] = array(solution.results, "indentation")[0]
        found["force_share"][0] = (
            array(solution.results, "ring_force")[0] / array(solution.results, "normal_force")[0]
        )
