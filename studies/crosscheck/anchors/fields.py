"""Check numbers that are derived from fields of a flat punch, and fields at the reported radii."""

import numpy as np

from ....mdr import energy, ring_kernel
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_times
from ..wear.unilateral import Mask
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, ROUNDOFF_TOLERANCE, Reported

# number of relaxation times that are compared: the independent small problem resolves that many
COMPARED_TIMES = 8
# the small problem is solved on two meshes; a relaxation time is not compared if the relative
# difference of the two is larger than this
LARGEST_MESH_DIFFERENCE = 0.01
# name of the anchor of the contact radius in full contact
RADIUS_OF_FULL_CONTACT = "contact radius, that of the punch"


def check_fields(report: Reported) -> Rows:
    """Compare displacements with the profile, and centre and greatest values with the field."""
    depth, displacement = report.depth_scale, report.take("displacement")
    u_plus_f, d = displacement + report.shape, report.depth[:, None]
    tolerance = report.rtol + report.depth_roundoff[:, None]
    yield Row("displacement, u = d - f", u_plus_f, d, tolerance, depth[:, None])
    centre, interpolation_error = (
        values[:, 0] for values in report.face.interpolate(displacement, report.reading.edges[:1])
    )
    tolerance = (
        report.tolerance("displacement_centre")
        + REFERENCE_ERROR_FACTOR * interpolation_error / depth
    )
    value = report.take("displacement_centre")
    yield Row("displacement at the centre", value, centre, tolerance, depth)
    # the maximum may lie between the radius of the greatest value and one of its neighbours
    neighbours = np.clip(
        displacement.argmax(axis=1)[:, None] + [-1, 0, 1], 0, displacement.shape[1] - 1
    )
    largest_values = np.take_along_axis(displacement, neighbours, axis=1)
    tolerance = report.tolerance("displacement_max") + np.ptp(largest_values, axis=1) / depth
    value = report.take("displacement_max")
    yield Row("greatest displacement", value, largest_values.max(axis=1), tolerance, depth)


def check_slopes(report: Reported) -> Rows:
    """Compare the RMS slope with the slopes of the profile."""
    slope = report.take("rms_slope")
    resolved = (report.errors("rms_slope")[0] <= report.rtol) & (slope > 0)
    squares, errors = report.mean_square_slopes(report.shape[resolved])
    slopes = np.sqrt(squares) / slope[resolved]
    # take the greatest over time, because errors cross zero at some times
    slope_error = np.max(errors / (2 * slope[resolved] ** 2), initial=0.0)
    # slopes on the face are useless as a reference if their own error is larger
    if resolved.any() and slope_error <= 0.1:
        yield Row("RMS slope of the profile", slopes, 1.0, report.rtol + slope_error)


def check_output(report: Reported) -> Rows:
    """Compare fields at the reported radii with the fields over the face, interpolated there."""
    # leave out the element at the rim, where the pressure at the start is infinite
    inside, rows = report.radii < report.face.breakpoints[-2], report.has_slid
    inside &= ~_beside_contact_edges(report)
    if not inside.any():
        return
    even_wear = report.even_wear[rows]
    for name in ("pressure", "profile", "displacement"):
        values = (report.shape if name == "profile" else report.take(name))[rows]
        scale = np.abs(values).max(axis=1) if name == "pressure" else report.depth_scale[rows]
        reference, interpolation_error = report.face.interpolate(values, report.radii[inside])
        reported = report.take(name, on_face=False)[rows][:, inside]
        if name == "profile":
            reported = reported - report.first_touch - even_wear[:, None]
        # root mean square over the radii, because pressures have kinks between elements
        difference, interpolation_error = (
            np.sqrt((error**2).mean(axis=1)) / np.maximum(scale, np.finfo(float).tiny)
            for error in (reported - reference, interpolation_error)
        )
        tolerance = report.tolerance(name)[rows] + REFERENCE_ERROR_FACTOR * interpolation_error
        if name == "profile":
            tolerance = tolerance + report.depth_roundoff[rows]
        yield Row(f"{name} at the reported radii", difference, 0.0, tolerance, 1.0)


def check_contact_radius(report: Reported) -> Rows:
    """Compare the contact radius with that of the punch, which is in full contact."""
    yield Row(RADIUS_OF_FULL_CONTACT, report.take("contact_radius"), 1.0, ROUNDOFF_TOLERANCE)


def _beside_contact_edges(report: Reported) -> Mask:
    """Return which reported radii share an element of the face with an outermost contact edge.

    A contact that is smaller than the element has worn a spot there that interpolation misses.
    """
    if not report.has("contact_radius"):
        return np.zeros(len(report.radii), dtype=bool)
    ends = report.face.breakpoints[1:-1]
    edges = np.searchsorted(ends, report.take("contact_radius"))
    return np.isin(np.searchsorted(ends, report.radii), edges)


def check_modes(report: Reported) -> Rows:
    """Compare relaxation times with those of a small problem that is solved independently."""
    if (running_in := report.solution.wear) is None:
        return
    times = report.take("relaxation_time")
    # use another theory than the method does
    half_space = ring_kernel.compliance if report.name == "mdr" else energy.compliance
    rings, ground = report.problem.merged, report.reading.ground
    coarse, fine = (
        slowest_relaxation_times(rings, report.fixed_indentation, sizes, half_space, ground)
        for sizes in (COARSE, FINE)
    )
    stated_errors = report.errors("relaxation_time")[0]
    reported = int(np.isfinite(times).sum())
    count = min(len(coarse), len(fine), len(stated_errors), reported, COMPARED_TIMES)
    if count:
        mesh_difference = np.abs(coarse[:count] / fine[:count] - 1)
        allowed = (
            np.fmax(stated_errors[:count], report.rtol) + REFERENCE_ERROR_FACTOR * mesh_difference
        )
        # the slowest time is always compared, the others only if the small problem resolves them
        tolerance = np.where(mesh_difference <= LARGEST_MESH_DIFFERENCE, allowed, np.inf)
        tolerance[0] = allowed[0]
        name = "relaxation times, by an independent small problem"
        yield Row(name, times[:count], fine[:count], tolerance)
    if report.has("running_in_time"):
        value = report.take("running_in_time")
        yield Row("running-in time of the answer", value, times[0], ROUNDOFF_TOLERANCE)
    if report.has_slid.any():
        yield Row(
            "modes add up to the flat start", running_in.resolved_fraction, 1.0, ROUNDOFF_TOLERANCE
        )
