"""The answer of a run: what a user asked of the punch, by each method. Non-dimensional.

How long running-in takes is seen from the approach of the punch, which a displacement sensor on its holder shows: once it
has run in, it rises in a straight line. What ``d(t) - w t`` has still to rise falls as a sum of positive exponentials.
"""

import numpy as np

from ringwear.meshes.radial import Array, Indices, ring_of
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import ANSWER, STATES, array
from ringwear.studies.problem.problem import Problem

# given with it, and kept as quantities of their own
ALSO = ("steady_wear_rate", "steady_rms_slope")


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Values of `ANSWER` by one method: NaN where it does not give them, or the scene does not ask."""
    sizes = {"state": len(STATES), "ring": len(problem.wear_coefficients)}
    found = {name: np.full([sizes[dim] for dim in one.dims], np.nan) for name, one in ANSWER.items()}
    if len(problem.times):
        _running_in(solution, found)
        if problem.profile is None:
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
    space, flat = solution.wear.compliance.space, solution.wear.flat
    # continuous, and rising from the centre to the rim
    at_edges = space.matrix(problem.ring_edges[:-1]) @ flat.pressure
    found["indentation_start"][...] = flat.indentation
    found["pressure_min"][0] = at_edges
    found["pressure_max"][0] = [*at_edges[1:], np.inf]
    found["force_share"][0] = space.ring_forces(problem.ring_edges) @ flat.pressure


def _steady(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    pressure, ring, areas = array(solution.checked, "steady_pressure"), *_by_ring(problem)
    for number in range(len(problem.wear_coefficients)):
        own = pressure[ring == number]
        found["pressure_min"][1, number], found["pressure_max"][1, number] = own.min(), own.max()
    found["force_share"][1] = np.bincount(ring, areas * pressure)


def _wear(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    if "profile" in solution.checked:
        ring, areas = _by_ring(problem)
        found["worn_volume"][:] = np.bincount(ring, areas * array(solution.checked, "profile")[-1])


def _with_profile(problem: Problem, solution: Solution, found: dict[str, Array]) -> None:
    """Where contact opens, closes and spreads: pressures at the start may be infinite, and have no closed form."""
    if "ring_worn_volume" not in solution.results:
        return
    found["worn_volume"][:] = array(solution.results, "ring_worn_volume")[-1]
    if problem.times[0] == 0:
        found["indentation_start"][...] = array(solution.results, "indentation")[0]
        found["force_share"][0] = array(solution.results, "ring_force")[0] / array(solution.results, "normal_force")[0]


def _by_ring(problem: Problem) -> tuple[Indices, Array]:
    """The ring of each radius of the face, and the area that it stands for."""
    radii, weights = problem.face
    ring = ring_of(problem.ring_edges, radii)
    return ring, weights / problem.wear_coefficients[ring]
