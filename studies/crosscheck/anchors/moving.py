"""Check contact that opens, closes or spreads: kinematics, reciprocity, and Galin's force.

Let u1 be the displacement under a uniform pressure, and p0 and d0 the pressure and the indentation
of the flat punch. Any pressure fulfils

    int u dA = int u1 p dA,    int u p0 dA = F d0        reciprocity (Betti)
    u + f = d where p > 0,     u + f >= d elsewhere      contact
    F = 2 int_0^c (d - g) dx                             contact on one disc of radius c (Galin)

with g the Abel transform (Eq. 3) of the reported profile f.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ....meshes.radial import Array
from ..problem.face import radial_weight
from ..problem.norms import LEAST_SLOPE
from ..sizes.cells import tolerance_range
from ..wear.unilateral import Mask
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, Reported

# error of an integral of the pressure over the face, over the largest contribution of one radius:
# contact ends between two radii
EDGE_QUADRATURE_FACTOR = 4.0
# largest error estimate that enters the balances of whole fields, over rtol or over the smallest
# tolerance that cell sizes respond to: a larger error estimate belongs to radii near an edge only
LARGEST_STATED_FACTOR = 4.0
# uncertainty of the contact radius, in cells of the face
CONTACT_EDGE_CELLS = 3.0
# least number of radii of the face in contact for an integral over it
FEWEST_CONTACT_RADII = 20
# scale of an integral that is zero; it only prevents a division by zero
SMALLEST_SCALE = 1e-100
# number of elements of the face next to an edge of the contact in which the pressure is not smooth
EDGE_ELEMENTS = 2
# rank, from 0, of the pressure whose difference to the highest one estimates the latter's error
PEAK_RADII = 8


def check_kinematics(report: Reported) -> Rows:
    """Compare displacement plus profile with the indentation, inside and outside the contact."""
    pressure = report.take("pressure")
    gap = report.take("displacement") + report.shape - report.depth[:, None]
    stated_errors = report.errors("indentation", "displacement", "profile")
    allowed = report.rtol + stated_errors.sum(axis=0) + report.depth_roundoff
    scale = _depth_scale(report)
    # leave out the last radius in contact, which lies in the cell in which contact ends: a part of
    # this cell has worn for a part of the time only, but the cell has one height
    inside = _holds_around(pressure > 0, 1)
    contact_gap = np.where(inside, np.abs(gap), 0.0).max(axis=1)
    yield Row("u + f = d in contact", contact_gap, 0.0, allowed, scale)
    penetration = np.maximum(-gap.min(axis=1), 0.0)
    # the factor 2 is for the cell that contains an edge of the contact
    yield Row("no negative gap", penetration, 0.0, 2 * allowed, scale)


def check_reciprocity(report: Reported) -> Rows:
    """Compare displacement and pressure by reciprocity, and the force with that of the pressure."""
    pressure, displacement = report.take("pressure"), report.take("displacement")
    force, rtol, flat = report.take("normal_force"), report.rtol, report.flat
    depth, scale = _depth_scale(report), np.maximum(force, np.finfo(float).tiny)
    edge_error = EDGE_QUADRATURE_FACTOR * (pressure * report.face.areas).max(
        axis=1
    ) + _too_few_radii(pressure)
    stated_p, stated_u = report.errors("pressure", "displacement")
    integral, quadrature_error = report.integrate(pressure)
    largest_error = LARGEST_STATED_FACTOR * max(rtol, tolerance_range(report.problem, 0)[0])
    tolerance = rtol + np.minimum(stated_p, largest_error) + (quadrature_error + edge_error) / scale
    yield Row("F = int p dA", force, integral, tolerance, scale)
    if not report.fixed_indentation:
        yield Row("F as in the scene", force, report.forces, 0.1 * rtol)
    allowed = rtol + np.minimum(stated_u + stated_p, largest_error)
    left, error_left = report.integrate(displacement)
    right, error_right = report.integrate(pressure, report.uniform_displacement)
    # the integral may be zero if contact is narrower than the distance of two radii
    integral_scale = np.maximum(right, SMALLEST_SCALE)
    tolerance = allowed * (report.area * depth + right) + error_left + error_right + edge_error
    yield Row(
        "reciprocity with a uniform pressure",
        left,
        right,
        tolerance / integral_scale,
        integral_scale,
    )
    left, error_left = report.integrate(displacement, flat.pressure_at(report.face.radii))
    tolerance = (allowed * (depth + force) + error_left + _too_few_radii(pressure)) / scale
    yield Row("reciprocity with the flat punch", left, flat.indentation * force, tolerance, scale)


def check_numbers_of_fields(report: Reported) -> Rows:
    """Compare contact radius, slope, centre and greatest displacement with the fields."""
    pressure, displacement, face = report.take("pressure"), report.take("displacement"), report.face
    scale, rtol = _depth_scale(report), report.rtol
    widest = np.diff(face.breakpoints).max()
    tolerance = CONTACT_EDGE_CELLS * widest + rtol + report.errors("contact_radius")[0]
    # skip times at which every part of the contact may lie between two radii of the face
    inner, outer = (report.take("contact_edge")[:, end::2] for end in (0, 1))
    width = np.subtract(
        *(np.nan_to_num(edges).max(axis=1, initial=0.0) for edges in (outer, inner))
    )
    tolerance = np.where(width < 2 * widest, np.inf, tolerance)
    radius = report.take("contact_radius")
    yield Row(
        "contact radius, from the pressure",
        radius,
        _outermost_contact_radius(report, pressure),
        tolerance,
        1.0,
    )
    stated_errors = report.errors("displacement", "displacement_centre", "displacement_max")
    centre, interpolation_error = (
        values[:, 0] for values in face.interpolate(displacement, report.reading.edges[:1])
    )
    too_few_radii = _too_few_radii(pressure)
    tolerance = (
        rtol
        + stated_errors[0]
        + stated_errors[1]
        + REFERENCE_ERROR_FACTOR * interpolation_error / scale
        + too_few_radii
    )
    reported_value = report.take("displacement_centre")
    yield Row("displacement at the centre", reported_value, centre, tolerance, scale)
    neighbours = np.clip(
        displacement.argmax(axis=1)[:, None] + [-1, 0, 1], 0, displacement.shape[1] - 1
    )
    spread = np.ptp(np.take_along_axis(displacement, neighbours, axis=1), axis=1)
    tolerance = rtol + stated_errors[0] + stated_errors[2] + spread / scale + too_few_radii
    reported_value = report.take("displacement_max")
    yield Row("greatest displacement", reported_value, displacement.max(axis=1), tolerance, scale)
    if not report.problem.profile.recess.any():
        weights = radial_weight(face.radii, report.average, report.inner_radius) * face.lengths
        slopes, less_accurate_slopes = (
            np.sqrt(values**2 @ weights) for values in face.slopes(report.shape)
        )
        slope = report.take("rms_slope")
        # the error of a very small slope is relative to the depth over the radius instead
        slope_scale = np.maximum(slope, LEAST_SLOPE * scale)
        tolerance = (
            rtol
            + report.errors("rms_slope")[0]
            + REFERENCE_ERROR_FACTOR * np.abs(slopes - less_accurate_slopes) / slope_scale
        )
        yield Row("RMS slope of the face", slope, slopes, tolerance, slope_scale)


def check_pressures_inside(report: Reported) -> Rows:
    """Compare pressures at the reported radii with those over the face, away from contact edges."""
    face, pressure = report.face, report.take("pressure")
    element = np.searchsorted(face.breakpoints, report.radii, side="right") - 1
    elements = len(face.breakpoints) - 1
    element = np.clip(element, 0, elements - 1)
    carries = (pressure.reshape(len(pressure), elements, -1) > 0).all(axis=2)
    inside = _holds_around(np.asarray(carries), EDGE_ELEMENTS)[:, element]
    # at the start pressures may be infinite on the axis, as under a cone
    inside[np.ix_(report.distances == 0, element == 0)] = False
    reference, interpolation_error = face.interpolate(pressure, report.radii)
    difference = report.take("pressure", on_face=False) - reference
    count = inside.sum(axis=1)
    rows = np.flatnonzero(count)
    largest_pressure = pressure.max(axis=1)[rows]
    difference, interpolation_error = (
        np.sqrt(np.where(inside, error**2, 0.0).sum(axis=1)[rows] / count[rows]) / largest_pressure
        for error in (difference, interpolation_error)
    )
    if len(rows):
        tolerance = report.rtol + REFERENCE_ERROR_FACTOR * interpolation_error
        yield Row(
            "pressure at the reported radii, inside the contact", difference, 0.0, tolerance, 1.0
        )


def check_disc(report: Reported) -> Rows:
    """Compare the force with that of the reported profile by Galin's relation, on one disc.

    Times at which the contact is not one disc are skipped. The relation holds on a homogeneous
    half-space only.
    """
    if report.reading.ground.layered:
        return
    pressure, heights = report.take("pressure"), report.shape
    radii, force, depth = report.face.radii, report.take("normal_force"), report.depth
    edge = _outermost_contact_radius(report, pressure)
    disc = ((pressure > 0) == (radii <= edge[:, None])).all(axis=1) & (force > 0) & (edge > 0)
    disc &= not report.inner_radius
    rows = np.flatnonzero(disc)
    if report.problem.profile.recess.any() or not len(rows):
        return
    fine, coarse = (
        np.array(
            [_abel_integral(radii[::stride], heights[row, ::stride], edge[row]) for row in rows]
        )
        for stride in (1, 2)
    )
    indentation_error, profile_error = (
        report.rtol + report.errors("indentation", "profile")[:, rows]
    )
    depths = _depth_scale(report)[rows]
    # the relative error of the Abel transform may be twice that of the heights
    tolerance = indentation_error * (force[rows] + 2 * depths) + 4 * profile_error * depths
    tolerance += REFERENCE_ERROR_FACTOR * np.abs(fine - coarse)
    tolerance += 2 * report.depth_roundoff[rows] * depths
    # the edge is only known to within the distance of two radii, but dF/dc = 0 at the edge c
    value = 2 * (depth[rows] * edge[rows] - fine)
    name = "force of the profile on a disc (Galin)"
    yield Row(name, force[rows], value, tolerance / force[rows], force[rows])


def check_peak(report: Reported) -> Rows:
    """Compare the peak pressure at the start with the pressure over the face."""
    if report.includes_start and report.has("pressure_peak_start"):
        pressures = np.sort(report.take("pressure")[0])[::-1]
        highest, nearby, peak = (
            float(value)
            for value in (pressures[0], pressures[PEAK_RADII], report.take("pressure_peak_start"))
        )
        if nearby <= highest / 2:
            # the peak may lie between two radii: then it is at least as high as the pressures there
            highest = max(highest, peak)
        tolerance = report.rtol + 4 * (highest - nearby) / highest
        yield Row("peak pressure of the answer", peak, highest, tolerance)


def _holds_around(mask: Mask, reach: int) -> Mask:
    """Return where a mask (T, n) is true, also at `reach` neighbours on each side."""
    padded = np.pad(mask, ((0, 0), (reach, reach)), mode="edge")
    around = np.asarray(sliding_window_view(padded, 2 * reach + 1, axis=1))
    return np.asarray(around.all(axis=2))


def _too_few_radii(pressure: Array) -> Array:
    """Return infinity at times (T,) with too few radii in contact for an integral, else 0."""
    return np.where((pressure > 0).sum(axis=1) < FEWEST_CONTACT_RADII, np.inf, 0.0)


def _depth_scale(report: Reported) -> Array:
    """Return the scale (T,) of errors: the greatest depth so far, without the even wear."""
    return np.maximum(np.maximum.accumulate(report.depth_scale), np.finfo(float).tiny)


def _outermost_contact_radius(report: Reported, pressure: Array) -> Array:
    """Return the outermost radius of the face (T,) in contact."""
    return np.where(pressure > 0, report.face.radii, 0.0).max(axis=1)


def _abel_integral(radii: Array, heights: Array, edge: float) -> float:
    """Return ``int_0^c g dx`` up to an edge c for heights f that are linear between radii.

    It is the integral of ``f r / sqrt(c^2 - r^2)``, which has a closed form between two radii. A
    rule for the transform g itself would miss the steep layers of worn faces.
    """
    ends = np.concatenate([[0.0], radii[radii < edge], [edge]])
    f = np.interp(ends, radii, heights)
    rise, root = np.diff(f) / np.diff(ends), np.sqrt((edge - ends) * (edge + ends))
    # integrals of r and of r^2 over sqrt(c^2 - r^2)
    first = -np.diff(root)
    second = np.diff(edge**2 * np.arcsin(np.minimum(ends / edge, 1.0)) - ends * root) / 2
    return float(np.sum((f[:-1] - rise * ends[:-1]) * first + rise * second))
