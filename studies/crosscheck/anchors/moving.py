"""Check contact that opens, closes or spreads: its radius, pressures inside it, Galin's force.

In contact on one disc of radius c,

    F = 2 int_0^c (d - g) dx                             (Galin)

with g the Abel transform (Eq. 3) of the reported profile f.
"""

import numpy as np

from ....meshes.radial import Array
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, Reported, holds_around

# uncertainty of the contact radius, in cells of the face
CONTACT_EDGE_CELLS = 3.0
# number of elements of the face next to an edge of the contact in which the pressure is not smooth
EDGE_ELEMENTS = 2
# rank, from 0, of the pressure whose difference to the highest one estimates the latter's error
PEAK_RADII = 8


def check_contact_radius(report: Reported) -> Rows:
    """Compare the contact radius with the outermost radius at which the pressure is positive."""
    widest = np.diff(report.face.breakpoints).max()
    tolerance = CONTACT_EDGE_CELLS * widest + report.allowed("contact_radius")
    # skip times at which every part of the contact may lie between two radii of the face
    inner, outer = (report.take("contact_edge")[:, end::2] for end in (0, 1))
    width = np.subtract(
        *(np.nan_to_num(edges).max(axis=1, initial=0.0) for edges in (outer, inner))
    )
    tolerance = np.where(width < 2 * widest, np.inf, tolerance)
    radius, reference = report.take("contact_radius"), _outermost_contact_radius(report)
    yield Row("contact radius, from the pressure", radius, reference, tolerance, 1.0)


def check_pressures_inside(report: Reported) -> Rows:
    """Compare pressures at the reported radii with those over the face, away from contact edges."""
    face, pressure = report.face, report.take("pressure")
    element = np.searchsorted(face.breakpoints, report.radii, side="right") - 1
    elements = len(face.breakpoints) - 1
    element = np.clip(element, 0, elements - 1)
    carries = (pressure.reshape(len(pressure), elements, -1) > 0).all(axis=2)
    inside = holds_around(np.asarray(carries), EDGE_ELEMENTS)[:, element]
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
    radii, heights = report.face.radii, report.shape
    force, depth = report.take("normal_force"), report.depth
    edge = _outermost_contact_radius(report)
    disc = (report.contact == (radii <= edge[:, None])).all(axis=1) & (force > 0) & (edge > 0)
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
    depths = report.depth_scale[rows]
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


def _outermost_contact_radius(report: Reported) -> Array:
    """Return the outermost radius of the face (T,) in contact."""
    return np.where(report.contact, report.face.radii, 0.0).max(axis=1)


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
