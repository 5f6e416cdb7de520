"""Check identities of contact: kinematics, reciprocity, balances, and numbers from fields.

They hold for every punch, in full contact and while edges of the contact move. Let a pressure p0
on the face have the displacement u0. Any pressure fulfils

    u + f = d where p > 0,     u + f >= d elsewhere      contact
    F = int p dA                                         force
    int u p0 dA = int u0 p dA                            reciprocity (Betti)

with the pressure of the flat punch (u0 = d0, so that the right-hand side is F d0), a uniform
pressure, and the pressure of the steady state.
"""

import numpy as np

from ....meshes.radial import ring_areas
from ..problem.norms import LEAST_SLOPE
from .anchor import Row, Rows
from .reported import (
    REFERENCE_ERROR_FACTOR,
    ROUNDOFF_TOLERANCE,
    KnownPressure,
    Reported,
    holds_around,
)

# largest error of mean square slopes on the face, relative, with which they are a reference
LARGEST_SLOPE_ERROR = 0.1
# scale of an integral that is zero; it only prevents a division by zero
SMALLEST_SCALE = 1e-100
# roundoff of the worn depth, over the unit of displacements: up to 2e-14 by some hundred modes
# (physics/test_random_scenes.py::test_numbers_at_extremes_are_right_or_left_out)
ROUNDOFF_OF_DEPTHS = 5e-14


def check_kinematics(report: Reported) -> Rows:
    """Compare displacement plus profile with the indentation, inside and outside the contact."""
    gap = report.take("displacement") + report.shape - report.depth[:, None]
    allowed = report.allowed("indentation", "displacement", "profile") + report.depth_roundoff
    # leave out the last radius in contact, which lies in the cell in which contact ends: a part of
    # this cell has worn for a part of the time only, but the cell has one height
    inside = holds_around(report.contact, 1)
    contact_gap = np.where(inside, np.abs(gap), 0.0).max(axis=1)
    yield Row("u + f = d in contact", contact_gap, 0.0, allowed, report.depth_scale)
    # edges that move leave errors that are large beside them and small in the mean
    weights = inside * report.face.areas
    total = np.maximum(weights.sum(axis=1), np.finfo(float).tiny)
    mean_gap = (weights * gap).sum(axis=1) / total
    names = "indentation", "displacement", "profile"
    tolerance = report.allowed_in_balances(*names) + report.depth_roundoff
    yield Row("u + f = d in the mean", mean_gap, 0.0, tolerance, report.depth_scale)
    penetration = np.maximum(-gap.min(axis=1), 0.0)
    # the factor 2 is for the cell that contains an edge of the contact
    yield Row("no negative gap", penetration, 0.0, 2 * allowed, report.depth_scale)


def check_extremes(report: Reported) -> Rows:
    """Compare the displacement at the centre and the greatest one with the field."""
    displacement, scale = report.take("displacement"), report.depth_scale
    centre, interpolation_error = (
        values[:, 0] for values in report.face.interpolate(displacement, report.reading.edges[:1])
    )
    tolerance = report.allowed("displacement", "displacement_centre") + report.too_few_radii
    tolerance += REFERENCE_ERROR_FACTOR * interpolation_error / scale
    value = report.take("displacement_centre")
    yield Row("displacement at the centre", value, centre, tolerance, scale)
    # the maximum may lie between the radius of the greatest value and one of its neighbours
    neighbours = np.clip(
        displacement.argmax(axis=1)[:, None] + [-1, 0, 1], 0, displacement.shape[1] - 1
    )
    spread = np.ptp(np.take_along_axis(displacement, neighbours, axis=1), axis=1)
    tolerance = report.allowed("displacement", "displacement_max") + report.too_few_radii
    tolerance += spread / scale
    value = report.take("displacement_max")
    yield Row("greatest displacement", value, displacement.max(axis=1), tolerance, scale)


def check_slope(report: Reported) -> Rows:
    """Compare the RMS slope with the slopes of the profile, unless it has steps."""
    if report.problem.profile.recess.any():
        return
    slope = report.take("rms_slope")
    squares, errors = report.mean_square_slopes(report.shape)
    # the error of a very small slope is relative to the depth over the radius instead
    scale = np.maximum(slope, LEAST_SLOPE * report.depth_scale)
    error = errors / (2 * scale**2)
    tolerance = report.allowed("rms_slope") + np.where(error > LARGEST_SLOPE_ERROR, np.inf, error)
    yield Row("RMS slope of the profile", slope, np.sqrt(squares), tolerance, scale)


def check_force(report: Reported) -> Rows:
    """Compare the force with the integral of the pressure, and with that of the scene."""
    integral, error = report.integrate(report.take("pressure"))
    tolerance = report.allowed_in_balances("pressure") + (error + report.edge_error) / report.scale
    yield Row("F = int p dA", report.force, integral, tolerance, report.scale)
    if not report.fixed_indentation:
        value = report.take("normal_force")
        yield Row("F as in the scene", value, report.forces, 0.1 * report.rtol)


def check_reciprocity(report: Reported) -> Rows:
    """Compare displacement and pressure with known pressures and their displacements."""
    face = report.face
    known = [*report.known_pressures]
    if not report.graded:
        steady = report.steady_wear_rate / report.wear
        displacement = report.steady_displacement(face.radii)
        known.append(KnownPressure("the steady state", steady, displacement))
    allowed = report.allowed_in_balances("displacement", "pressure")
    for name, pressure, known_displacement in known:
        left, error = report.integrate(report.take("displacement"), pressure)
        if np.ndim(known_displacement):
            right, error_right = report.integrate(report.take("pressure"), known_displacement)
            error = error + error_right + report.edge_error
        else:
            right = np.asarray(known_displacement * report.force)
            error = error + report.too_few_radii
        weight = (pressure * face.areas).sum()
        tolerance = allowed * (weight * report.depth_scale + right) + error
        # the integral may be zero if contact is narrower than the distance of two radii
        scale = np.maximum(right, SMALLEST_SCALE)
        yield Row(f"reciprocity with {name}", left, right, tolerance / scale, scale)


def check_forces(report: Reported) -> Rows:
    """Compare ring forces with the force on the punch and with integrals of the pressure."""
    forces, pressure = report.take("ring_force"), report.take("pressure")
    total_force = forces.sum(axis=1)
    if not report.fixed_indentation:
        tolerance = np.maximum(report.errors("ring_force")[0], ROUNDOFF_TOLERANCE)
        yield Row("ring forces add up to F", total_force, report.forces, tolerance)
    tolerance = report.integrate(pressure)[1] + report.too_few_radii
    tolerance += report.tolerance("pressure") * np.maximum(total_force, np.finfo(float).tiny)
    sums = report.face.ring_sums(report.face.areas * pressure)
    yield Row("ring forces are integrals of the pressure", sums, forces, tolerance[:, None], 1.0)


def check_mean_contact_radius(report: Reported) -> Rows:
    """Compare the mean radius of the force with the first moment of the pressure."""
    integral, error = report.integrate(report.take("pressure"), report.face.radii)
    tolerance = report.allowed_in_balances("pressure", "mean_contact_radius")
    tolerance = tolerance + (error + report.edge_error) / report.scale
    moment = report.take("mean_contact_radius") * report.force
    yield Row("moment of the pressure, int p r dA", moment, integral, tolerance, report.scale)


def check_worn_volumes(report: Reported) -> Rows:
    """Compare the sum of worn volumes over k with the work of the force (given force only).

    If k varies on a ring, the worn volume of the ring does not determine the work of its pressure.
    """
    if not (report.fixed_indentation or report.graded):
        coefficients = report.problem.wear_coefficients
        worn = report.take("ring_worn_volume")[report.has_slid] / coefficients
        value, work = worn.sum(axis=1), report.work[report.has_slid]
        tolerance = np.full(len(work), ROUNDOFF_TOLERANCE)
        if report.full_contact:
            # volumes are integrals of d - u, whose roundoff is that of displacements of about 1
            areas = ring_areas(report.problem.ring_edges)
            tolerance += ROUNDOFF_OF_DEPTHS * (areas / coefficients).sum() / work
        yield Row("worn volume over k, F v0 t", value, work, tolerance)
