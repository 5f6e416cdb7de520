"""The answer of a run: what a user asked of the punch, by each method. Non-dimensional.

How long running-in takes is seen from the approach of the punch, which a displacement sensor on its
holder shows: once it has run in, it rises in a straight line. What ``d(t) - w t`` has still to rise
falls as a sum of positive exponentials.
"""

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, STATES

# quantities that are given with the answer
ALSO = ("steady_wear_rate", "steady_rms_slope")


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the values of `ANSWER` by one method.

    They are NaN where the method does not give them, or the scene does not ask for them.
    """
    sizes = {"state": len(STATES), "ring": len(problem.wear_coefficients)}
    values = {
        name: np.full([sizes[dim] for dim in quantity.dims], np.nan)
        for name, quantity in ANSWER.items()
    }
    results, checked, face = solution.results, solution.checked, problem.face
    if len(problem.times) and solution.wear is not None:
        wear, flat = solution.wear, solution.wear.flat
        # continuous, and rising from the centre to the rim
        pressures = flat.pressure_at(problem.ring_edges[:-1])
        values["running_in_time"][...] = wear.relaxation_times[0]
        if not problem.loading.varies:
            values["time_to_90"][...] = wear.time_to(0.9)
            values["time_to_99"][...] = wear.time_to(0.99)
        values["indentation_start"][...] = flat.indentation
        values["pressure_min"][0], values["pressure_max"][0] = pressures, [*pressures[1:], np.inf]
        values["force_share"][0] = flat.ring_forces(problem.ring_edges)
    if "ring_worn_volume" in results:
        values["worn_volume"] = results["ring_worn_volume"][-1]
    elif problem.full_contact and "profile" in checked:
        values["worn_volume"] = face.ring_sums(face.areas * checked["profile"][-1])
    starts = not problem.full_contact and not problem.loading.varies
    if starts and "indentation" in results and problem.times[0] == 0:
        # pressures at the start may be infinite, and have no closed form
        values["indentation_start"] = results["indentation"][0]
        if {"ring_force", "normal_force"} <= results.keys():
            values["force_share"][0] = results["ring_force"][0] / results["normal_force"][0]
    if "steady_displacement_max" in checked:
        values["indentation_steady"] = checked["steady_displacement_max"]
    if "steady_pressure" in checked:
        pressure = checked["steady_pressure"]
        first = np.flatnonzero(np.diff(face.ring, prepend=-1))
        values["pressure_min"][1] = np.minimum.reduceat(pressure, first)
        values["pressure_max"][1] = np.maximum.reduceat(pressure, first)
        values["force_share"][1] = face.ring_sums(face.areas * pressure)
    return values
