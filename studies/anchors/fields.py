"""Check numbers that are taken from fields of a flat punch, and fields at the reported radii."""

import numpy as np

from ...mdr import energy, ring_kernel
from ..sampling.norms import radial_weight
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_times
from .anchor import Row, Rows
from .reported import DOUBT, EXACT, Reported

# relaxation times that a small problem of its own knows well enough to compare with
COMPARED_TIMES = 8
# the small problem is not used where its two sizes differ by more than this part
MOST_DOUBTFUL = 0.01


def check_fields(report: Reported) -> Rows:
    """Compare displacements with the profile, and centre and greatest values with the field."""
    depth, moved = report.take("indentation"), report.take("displacement")
    sum_of_both, each = moved + report.take("profile"), depth[:, None]
    yield Row("displacement, u = d - f", sum_of_both, each, report.rtol, each)
    centre, doubt = (
        part[:, 0] for part in report.face.interpolate(moved, report.reading.edges[:1])
    )
    tolerance = report.tolerance("displacement_centre") + DOUBT * doubt / depth
    value = report.take("displacement_centre")
    yield Row("displacement at the centre", value, centre, tolerance, depth)
    # between the greatest and its neighbours there may be a greater one
    near = np.clip(moved.argmax(axis=1)[:, None] + [-1, 0, 1], 0, moved.shape[1] - 1)
    near = np.take_along_axis(moved, near, axis=1)
    tolerance = report.tolerance("displacement_max") + np.ptp(near, axis=1) / depth
    value = report.take("displacement_max")
    yield Row("greatest displacement", value, near.max(axis=1), tolerance, depth)


def check_slopes(report: Reported) -> Rows:
    """Compare the RMS slope with the slopes of the profile."""
    slope, face = report.take("rms_slope"), report.face
    resolved = (report.errors("rms_slope")[0] <= report.rtol) & (slope > 0)
    weights = radial_weight(face.radii, report.average, report.inner_radius) * face.lengths
    slopes, lower = (
        np.sqrt(values[resolved] ** 2 @ weights) / slope[resolved]
        for values in face.slopes(report.take("profile"))
    )
    # the difference of the two crosses zero now and then in time
    doubt = DOUBT * np.max(np.abs(slopes - lower), initial=0.0)
    # slopes on the face that are as doubtful tell nothing
    if resolved.any() and doubt <= 0.1:
        yield Row("RMS slope of the profile", slopes, 1.0, report.rtol + doubt)


def check_output(report: Reported) -> Rows:
    """Compare fields at the reported radii with those over the face."""
    # not at the rim, where pressures of the start are infinite
    inside, later = report.radii < report.face.breakpoints[-2], report.later
    if not inside.any():
        return
    for name in ("pressure", "profile", "displacement"):
        values, size = report.take(name)[later], report.take("indentation")[later]
        if name == "pressure":
            size = np.abs(values).max(axis=1)
        reference, doubt = report.face.interpolate(values, report.radii[inside])
        reported = report.take(name, on_face=False)[later][:, inside]
        # in the mean: pressures of elements have kinks of their own
        wrong, doubt = (
            np.sqrt((part**2).mean(axis=1)) / np.maximum(size, np.finfo(float).tiny)
            for part in (reported - reference, doubt)
        )
        tolerance = report.tolerance(name)[later] + DOUBT * doubt
        yield Row(f"{name} at the radii reported", wrong, 0.0, tolerance, 1.0)


def check_modes(report: Reported) -> Rows:
    """Compare relaxation times with those of a small problem that is solved on its own."""
    if (wear := report.solution.wear) is None:
        return
    times = report.take("relaxation_time")
    # another theory than the method's own
    half_space = ring_kernel.compliance if report.name == "mdr" else energy.compliance
    rings, ground = report.problem.merged, report.reading.ground
    coarse, fine = (
        slowest_relaxation_times(rings, report.fixed, sizes, half_space, ground)
        for sizes in (COARSE, FINE)
    )
    stated = report.errors("relaxation_time")[0]
    given = int(np.isfinite(times).sum())
    shown = min(len(coarse), len(fine), len(stated), given, COMPARED_TIMES)
    if shown:
        doubt = np.abs(coarse[:shown] / fine[:shown] - 1)
        allowed = np.fmax(stated[:shown], report.rtol) + DOUBT * doubt
        # the first always counts; of the others those that the small problem knows
        tolerance = np.where(doubt <= MOST_DOUBTFUL, allowed, np.inf)
        tolerance[0] = allowed[0]
        name = "relaxation times, by a small problem of its own"
        yield Row(name, times[:shown], fine[:shown], tolerance)
    if report.given("running_in_time"):
        value = report.take("running_in_time")
        yield Row("running-in time of the answer", value, times[0], EXACT)
    if report.later.any():
        yield Row("modes add up to the flat start", wear.resolved_fraction, 1.0, EXACT)
