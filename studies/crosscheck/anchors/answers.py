"""Check the numbers of the answer against the start, the steady state and the reported series."""

import numpy as np

from ....meshes.radial import Array
from .anchor import Row, Rows
from .many_rings import displace_by_many_rings
from .reported import REFERENCE_ERROR_FACTOR, ROUNDOFF_TOLERANCE, Reported

# relative step in time of the difference quotient that gives the decay rate of the running-in
RELATIVE_TIME_STEP = 1e-3
# scale of a difference if all values are zero; it only prevents a division by zero
SMALLEST_SCALE = 1e-300
# relative error of a sum over the face if the punch is shaped: edges of its contact lie between the
# radii of the face
SHAPED_SUM_ERROR = 1e-3


def check_times_of_running_in(report: Reported) -> Rows:
    """Compare the remaining part of the running-in at `time_to_90` and so on with its definition.

    The total change from the start to the steady state follows from the steady pressure, by direct
    integration. The method's own total change may differ from it by the errors that the method
    states for the start and for the steady state.
    """
    running_in, fractions = report.solution.wear, report.problem.remaining_parts
    # the verdict is undecided if such a number is missing
    reported = {name: part for name, part in fractions.items() if report.has(name)}
    if running_in is None or not report.full_contact or not reported:
        return
    total_change, error = _total_change(report)
    for name, remaining_part in reported.items():
        time = float(report.take(name))
        remaining = running_in.modes.remaining_change(
            time * np.array([1 - RELATIVE_TIME_STEP, 1.0, 1 + RELATIVE_TIME_STEP])
        )
        decay = abs(np.log(remaining[2] / remaining[0])) / (2 * RELATIVE_TIME_STEP)
        time_error = float(report.tolerance(name))
        tolerance = time_error * decay + (error + 1e-12) / total_change
        yield Row(
            f"{name}: remaining part of the running-in",
            remaining[1] / total_change,
            remaining_part,
            tolerance,
        )


def _total_change(report: Reported) -> tuple[float, float]:
    """Return the total change during running-in, and a bound on its difference to the method's."""
    if report.fixed_indentation:
        return report.flat.indentation, 0.0
    displacement, change = _steady_displacement(report)
    # the steady pressure, as the weight of a mean, carries the force 1
    pressure = report.steady_wear_rate / report.wear
    means, errors = report.integrate(np.array([displacement, change]), pressure)
    steady, start = float(means[0]), report.flat.indentation
    error = float(errors[0]) + abs(float(means[1]))
    error += report.stated_error("indentation_start") * start
    return steady - start, error + report.stated_error("indentation_steady") * steady


def _steady_displacement(report: Reported) -> tuple[Array, Array]:
    """Return the steady displacement (R,) on the face, and a change (R,) that bounds its error.

    It has a closed form if the wear coefficient is constant on rings. Otherwise, the change is that
    of the extrapolation. The error of a mean is bounded by the mean of the change.
    """
    radii = report.face.radii
    if not report.graded:
        return report.steady_displacement(radii), np.zeros(len(radii))
    displacement = displace_by_many_rings(report.reading, radii)
    return displacement.value, displacement.change


def check_repeated_numbers(report: Reported) -> Rows:
    """Compare numbers of the answer with the first or the last value of the reported series."""
    problem = report.problem
    has_start = len(report.reading.times) > 0 and report.reading.times[0] == 0
    if report.full_contact and report.has("force_start"):
        # at a fixed indentation, F = 2 a E* d of a flat punch is the unit of force
        exact = 1.0 if report.fixed_indentation else float(report.reading.load(np.zeros(1))[0][0])
        tolerance = report.tolerance("force_start")
        force, scale = report.take("force_start"), exact or 1.0
        yield Row("force_start in closed form", force, exact, tolerance, scale)
    for answer, name, index in (
        ("force_start", "normal_force", 0),
        ("force_end", "normal_force", -1),
        ("contact_radius_start", "contact_radius", 0),
        ("worn_volume", "ring_worn_volume", -1),
        ("indentation_start", "indentation", 0),
    ):
        if answer == "indentation_start" and (report.full_contact or problem.loading.varies):
            # a flat punch has this number in closed form, also if the force is 0 at the time 0
            continue
        if report.has(answer) and name in report.table and (has_start or index):
            series = np.asarray(report.table[name])[index]
            value = np.asarray(report.table[answer])
            scale = max(float(np.nanmax(np.abs(np.asarray(report.table[name])))), SMALLEST_SCALE)
            yield Row(f"{answer} of the answer", value, series, ROUNDOFF_TOLERANCE, scale)


def check_worn_volumes_of_profile(report: Reported) -> Rows:
    """Compare the worn volumes of the rings with integrals of the profile at the last time."""
    problem, face = report.problem, report.face
    unworn = problem.profile(face.radii) + problem.profile.standoff
    # both heights contain the standoff of a flat face, which cancels
    parts = face.areas * (report.solution.compared["profile"][-1] - unworn)
    volumes, quadrature_error = (
        face.ring_sums(parts),
        REFERENCE_ERROR_FACTOR * face.integral_error(parts[None])[0],
    )
    total_volume = volumes.sum()
    if not total_volume > 0:
        return
    stated_error = report.tolerance("worn_volume")
    # the error of the profile is relative to the indentation, at every radius of the face
    depth = float(report.take("indentation")[-1]) if len(report.times) else 0.0
    stated_error = (
        stated_error + float(report.errors("profile")[0][-1]) * report.area * depth / total_volume
    )
    if not report.full_contact:
        quadrature_error += SHAPED_SUM_ERROR * np.abs(parts).sum()
    tolerance = stated_error + quadrature_error / total_volume
    value = report.take("worn_volume")
    yield Row(
        "worn volumes of the answer, from the profile", value, volumes, tolerance, total_volume
    )
