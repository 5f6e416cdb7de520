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
from ..wear.flat_contact import FittedPress
from ..wear.moving_contact import ContactMarch

# quantities that are given with the answer
ALSO = ("steady_wear_rate", "steady_rms_slope")


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the values of `ANSWER` by one method.

    They are NaN where the method does not give them, or the scene does not ask for them; those that
    not every run has are left out then.
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
        for name, part in _parts(problem).items():
            values[name][...] = wear.modes.time_to(1 - part)
        values["indentation_start"][...] = flat.indentation
        values["pressure_min"][0], values["pressure_max"][0] = pressures, [*pressures[1:], np.inf]
        values["force_share"][0] = flat.ring_forces(problem.ring_edges)
    if problem.indentation is not None and "normal_force" in results:
        force = results["normal_force"]
        values["force_end"][...] = force[-1]
        if problem.times[0] == 0:
            values["force_start"][...] = force[0]
    if (march := solution.march) is not None:
        values["running_in_time"][...] = march.slowest_time
        if not problem.loading.varies:
            values["time_to_full_contact"][...] = march.time_of_full_contact
        for name, part in _parts(problem).items():
            values[name][...] = _time_left(march, part)
    if solution.presses:
        values["contact_radius_start"][...] = solution.presses[0].radius
        values["pressure_peak_start"][...] = _peak(solution.presses, problem.rtol)
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
    return {
        name: value
        for name, value in values.items()
        if ANSWER[name].always or np.isfinite(value).all()
    }


def _parts(problem: Problem) -> dict[str, float]:
    """Return what part of the way is left at each of the times that are told, of one load."""
    if problem.loading.varies:
        return {}
    if problem.indentation is not None:
        return {"time_to_half_force": 0.5}
    return {"time_to_90": 0.1, "time_to_99": 0.01}


def _time_left(march: ContactMarch, part: float) -> float:
    """Return the time from which no more than a part of the way is left; NaN if after the march."""
    from scipy.interpolate import PchipInterpolator  # few runs need it

    paths = [march.left()]
    if np.isfinite(march.time_of_full_contact):
        # what is left decays, at least as fast as the slowest mode
        paths.append(march.left(paths[0][0][-1] + march.slowest_time * np.geomspace(1e-3, 20, 400)))
    elif march.load.force is not None:
        # it may cross zero, and come back
        return float("nan")
    times, left = np.concatenate(paths, axis=1)
    left = np.abs(left) / np.abs(left).max()
    more = np.flatnonzero(left > part)[-1]
    if more + 1 == len(times):
        return float("nan")
    # by its logarithm it falls in nearly straight lines
    near = slice(max(more - 2, 0), more + 4)
    near_left = np.log(np.maximum(left[near], part / 1e3) / part)
    return float(PchipInterpolator(times[near], near_left).roots(extrapolate=False)[-1])


def _peak(presses: tuple[FittedPress, ...], rtol: float) -> float:
    """Return the greatest pressure of a press; NaN if that is infinite.

    At corners it is, and, where a coarser press has another, at kinks.
    """
    corners = [
        not part.outer_free or (part.inner > 0 and not part.inner_free)
        for part in presses[0].intervals
    ]
    peaks = [
        press.pressure_at(press.radius * np.sin(np.linspace(0, np.pi / 2, 2001))).max()
        for press in presses
    ]
    finite = not any(corners) and np.ptp(peaks) <= rtol * peaks[0]
    return float(peaks[0]) if finite else float("nan")
