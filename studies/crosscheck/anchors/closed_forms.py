"""Check flat punches and the steady state against closed forms and direct integration.

The start of a flat punch is that of Eqs. 10 and 11, the steady state that of Eqs. 21 to 27.
"""

import numpy as np

from ....mdr import direct
from .anchor import Row, Rows
from .reported import ROUNDOFF_TOLERANCE, Reported

# relative tolerance of the least and greatest steady pressure on a ring with a constant k
PRESSURE_EXTREMES_TOLERANCE = 1e-9


def check_start(report: Reported) -> Rows:
    """Compare the indentation at the start, ``d = F / (2 a E*)`` for a solid punch."""
    tolerance, reference = report.tolerance("indentation"), report.flat.indentation
    if report.includes_start:
        name = report.name_of_start("d", "F / (2 a E*)")
        depth = report.take("indentation")[0]
        yield Row(name, depth, reference * report.forces[0], tolerance[0])
    if report.solution.wear is not None:
        depth, tolerance = report.take("indentation_start"), report.tolerance("indentation_start")
        yield Row("flat start of the answer", depth, reference, tolerance)


def check_start_pressures(report: Reported) -> Rows:
    """Compare pressures and ring forces at the start, ``p = p0 / sqrt(1 - r^2/a^2)``."""
    edges, flat = report.problem.ring_edges, report.flat
    # the pressure is infinite at the rim and at the edge of a hole
    inside = (report.radii < 1) & ((report.radii > report.inner_radius) | (report.radii == 0))
    if report.includes_start:
        pressure, force = (report.tolerance(name)[0] for name in ("pressure", "ring_force"))
        value = report.take("pressure", on_face=False)[0, inside] / report.forces[0]
        name = report.name_of_start("p", "p0 / sqrt(1 - r^2/a^2)")
        yield Row(name, value, flat.pressure_at(report.radii[inside]), pressure)
        value = report.take("ring_force")[0] / report.forces[0]
        yield Row("flat start, forces of the rings", value, flat.ring_forces(edges), force, 1.0)


def check_wear(report: Reported) -> Rows:
    """Compare the wear of the whole face with the work of the force."""
    work, face, rows = report.work, report.face, report.has_slid
    even_wear = report.steady_wear_rate * work[rows]
    exact = max(ROUNDOFF_TOLERANCE, report.graded * report.rtol)
    yield Row("even wear, w F v0 t", report.even_wear[rows], even_wear, exact)
    worn, quadrature_error = report.integrate(report.take("profile"), 1 / report.wear)
    # the error of the profile is relative to the indentation
    quadrature_error += (
        report.tolerance("profile") * report.take("indentation") * (face.areas / report.wear).sum()
    )
    tolerance = np.maximum(quadrature_error[rows] / work[rows], report.rtol)
    yield Row("worn volume over k, F v0 t", worn[rows], work[rows], tolerance)


def check_steady_state(report: Reported) -> Rows:
    """Compare wear rate, pressures, displacement, slope and profile of the steady state.

    If the wear coefficient varies along the radius, displacement and profile have no closed form,
    and are checked by reciprocity.
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
        yield from _compare_by_reciprocity(report)
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


def _compare_by_reciprocity(report: Reported) -> Rows:
    """Compare a steady state that has no closed form with the flat and a uniform pressure."""
    displacement = report.steady_displacement_on_face
    pressure = report.steady_wear_rate / report.wear
    allowed = report.rtol + sum(map(report.stated_error, ("steady_profile", "steady_pressure")))
    for name, of_other, displaced in report.known_pressures:
        (left, right), errors = report.integrate(
            np.array([displacement * of_other, pressure * displaced])
        )
        tolerance = allowed + float(errors.sum()) / right
        yield Row(f"steady state, reciprocity with {name}", left, right, tolerance)
    (square,), (error,) = report.mean_square_slopes(-displacement[None])
    if square > 0:
        tolerance = report.rtol + error / (2 * square)
        value = report.take("steady_rms_slope")
        yield Row("steady RMS slope of the profile", value, np.sqrt(square), tolerance)
