"""Check the steady state against direct integration (Eqs. 21 to 27)."""

import numpy as np

from ....mdr import direct
from .anchor import Row, Rows
from .many_rings import displace_by_many_rings, greatest_by_many_rings
from .reported import ROUNDOFF_TOLERANCE, Reported

# relative tolerance of the least and greatest steady pressure on a ring with a constant k
PRESSURE_EXTREMES_TOLERANCE = 1e-9


def check_steady_state(report: Reported) -> Rows:
    """Compare wear rate, pressures, displacement, slope and profile of the steady state.

    If the wear coefficient varies along the radius, displacement, slope and profile are compared
    with those of many rings; else with closed forms.
    """
    problem = report.problem
    pressures = report.steady_wear_rate / report.reading.wear_at(report.radii)
    tolerance_of_rate = max(ROUNDOFF_TOLERANCE, report.graded * report.rtol)
    rate = report.take("steady_wear_rate")
    yield Row("steady_wear_rate in closed form", rate, report.steady_wear_rate, tolerance_of_rate)
    value = report.take("steady_pressure")
    yield Row("steady pressures of Eq. 24", value, pressures, report.rtol)
    if report.has("force_share"):
        shares = report.steady_wear_rate * report.reading.inverse_wear
        value = report.take("force_share")[1]
        yield Row("steady force shares of the answer", value, shares, report.rtol, 1.0)
    if report.has("indentation_steady"):
        value, reference = report.take("indentation_steady"), report.take("steady_displacement_max")
        yield Row("steady indentation of the answer", value, reference, ROUNDOFF_TOLERANCE)
    slowest, fastest = report.reading.extremes_of_wear()
    for name, coefficients in (("pressure_min", fastest), ("pressure_max", slowest)):
        value = report.take_steady_pressure(name)
        reference = report.steady_wear_rate / coefficients
        label = f"steady {name} of the answer"
        yield Row(
            label, value, reference, max(PRESSURE_EXTREMES_TOLERANCE, report.rtol * report.graded)
        )
    if report.graded:
        yield from _compare_with_many_rings(report)
        return
    rings = problem.merged.ring_edges, report.steady_pressures
    ground = report.reading.ground
    greatest = direct.greatest_displacement(*rings, ground)
    limit = greatest - report.steady_displacement(report.radii)
    for name, reference, scale in (
        ("steady_displacement_max", greatest, None),
        (
            "steady_rms_slope",
            direct.rms_slope(*rings, report.average, ground),
            None,
        ),
        ("steady_profile", limit, greatest),
    ):
        tolerance = report.tolerance(name)
        yield Row(f"{name} in closed form", report.take(name), reference, tolerance, scale)


def _compare_with_many_rings(report: Reported) -> Rows:
    """Compare the steady state of a wear coefficient along the radius with that of many rings.

    Replacing the pressure by its means over rings is of second order in their width, which allows
    an extrapolation from two numbers of rings.
    """
    displacement = displace_by_many_rings(report.reading, report.radii)
    greatest = greatest_by_many_rings(report.reading)
    value = report.take("steady_displacement_max")
    tolerance = report.rtol + greatest.error / greatest.value
    yield Row("steady_displacement_max by many rings", value, greatest.value, tolerance)
    value, reference = report.take("steady_profile"), greatest.value - displacement.value
    tolerance = report.rtol + (greatest.error + displacement.error) / greatest.value
    yield Row("steady_profile by many rings", value, reference, tolerance, greatest.value)
    (square,), (square_error,) = report.mean_square_slopes(report.steady_profile_on_face[None])
    if square > 0:
        tolerance = report.rtol + square_error / (2 * square)
        value = report.take("steady_rms_slope")
        yield Row("steady RMS slope of the profile", value, np.sqrt(square), tolerance)
