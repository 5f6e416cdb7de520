"""Check contact that opens, closes or spreads: kinematics, reciprocity, and Galin's force.

With the displacements u1 and u0 by a uniform and by the flat punch's pressure, any pressure has

    int u dA = int u1 p dA,    int u p0 dA = F d0        reciprocity (Betti)
    u + f = d where p > 0,     u + f >= d elsewhere      contact
    F = 2 int_0^c (d - g) dx                             contact on one disc of radius c (Galin)

with g the Abel transform (Eq. 3) of the reported profile f.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...mdr.transforms import profile_transform
from ...meshes.radial import Array, unit_gauss
from ..sampling.norms import radial_weight
from ..sizes.defaults import tolerance_range
from ..wear.unilateral import Mask
from .anchor import Row, Rows
from .reported import DOUBT, Reported

# an integral of the pressure over the face may miss this many times the largest part of one radius,
# because contact ends between two of them
AT_EDGES = 4.0
# a reported error counts in the balances of whole fields up to this many times the accuracy asked
# for, or of the finest that cells follow: it is the greatest over the face, near an edge
MOST_STATED = 4.0
# cells of the face within which the edge of the contact is known
CELLS = 3.0
# radii of the face that have to press for an integral over it
FEWEST = 20
# a number below which integrals are next to nothing
LEAST = 1e-100
# part of the indentation over the radius that slopes are compared with at the least
LEAST_SLOPE = 1e-3
# elements of the face from an edge of the contact beyond which the pressure is smooth
AWAY = 2
# radii from the greatest pressure over which it is compared
NEAR_PEAK = 8


def check_kinematics(report: Reported) -> Rows:
    """Compare displacement and profile with the indentation where it presses, and elsewhere."""
    pressure, depth = report.take("pressure"), report.take("indentation")
    gap = report.take("displacement") + report.take("profile") - depth[:, None]
    stated = report.errors("indentation", "displacement", "profile")
    allowed, scale = report.rtol + stated.sum(axis=0), _elastic_depth(report)
    # the last radius that presses lies in the cell in which contact ends: the face was worn there
    # for a part of the time only, and one height for the cell cannot tell that
    inside = _with_neighbours(pressure > 0, 1)
    touching = np.where(inside, np.abs(gap), 0.0).max(axis=1)
    yield Row("u + f = d where it presses", touching, 0.0, allowed, scale)
    below = np.maximum(-gap.min(axis=1), 0.0)
    # in the cell that holds an edge of the contact, the face is not known better
    yield Row("no gap below zero", below, 0.0, 2 * allowed, scale)


def check_reciprocity(report: Reported) -> Rows:
    """Compare displacement and pressure by reciprocity, and the pressure with the force."""
    pressure, moved = report.take("pressure"), report.take("displacement")
    force, rtol, flat = report.take("normal_force"), report.rtol, report.flat
    depth, scale = _elastic_depth(report), np.maximum(force, np.finfo(float).tiny)
    missed = AT_EDGES * (pressure * report.face.areas).max(axis=1) + _unseen(pressure)
    stated_p, stated_u = report.errors("pressure", "displacement")
    whole, doubt = report.integrate(pressure)
    most = MOST_STATED * max(rtol, tolerance_range(report.problem, 0)[0])
    tolerance = rtol + np.minimum(stated_p, most) + (doubt + missed) / scale
    yield Row("F = int p dA", force, whole, tolerance, scale)
    if not report.fixed:
        yield Row("F as asked", force, report.forces, 0.1 * rtol)
    allowed = rtol + np.minimum(stated_u + stated_p, most)
    left, doubt_left = report.integrate(moved)
    right, doubt_right = report.integrate(pressure, report.uniform_displacement)
    # contact narrower than the distance of two radii may leave nothing to integrate
    size = np.maximum(right, LEAST)
    tolerance = allowed * (report.area * depth + right) + doubt_left + doubt_right + missed
    yield Row("reciprocity with a uniform pressure", left, right, tolerance / size, size)
    left, doubt_left = report.integrate(moved, flat.pressure_at(report.face.radii))
    tolerance = (allowed * (depth + force) + doubt_left + _unseen(pressure)) / scale
    yield Row("reciprocity with the flat punch", left, flat.indentation * force, tolerance, scale)


def check_numbers_of_fields(report: Reported) -> Rows:
    """Compare contact radius, slope, centre and greatest displacement with the fields."""
    pressure, moved, face = report.take("pressure"), report.take("displacement"), report.face
    scale, rtol = _elastic_depth(report), report.rtol
    widest = np.diff(face.breakpoints).max()
    tolerance = CELLS * widest + rtol + report.errors("contact_radius")[0]
    # a part narrower than the distance of two radii may lie between them
    inner, outer = (report.take("contact_edge")[:, end::2] for end in (0, 1))
    width = np.subtract(
        *(np.nan_to_num(edges).max(axis=1, initial=0.0) for edges in (outer, inner))
    )
    tolerance = np.where(width < 2 * widest, np.inf, tolerance)
    radius = report.take("contact_radius")
    yield Row("contact ends where p does", radius, _outermost(report, pressure), tolerance, 1.0)
    stated = report.errors("displacement", "displacement_centre", "displacement_max")
    centre, doubt = (part[:, 0] for part in face.interpolate(moved, report.reading.edges[:1]))
    unseen = _unseen(pressure)
    tolerance = rtol + stated[0] + stated[1] + DOUBT * doubt / scale + unseen
    value = report.take("displacement_centre")
    yield Row("displacement at the centre", value, centre, tolerance, scale)
    near = np.clip(moved.argmax(axis=1)[:, None] + [-1, 0, 1], 0, moved.shape[1] - 1)
    spread = np.ptp(np.take_along_axis(moved, near, axis=1), axis=1)
    tolerance = rtol + stated[0] + stated[2] + spread / scale + unseen
    value = report.take("displacement_max")
    yield Row("greatest displacement", value, moved.max(axis=1), tolerance, scale)
    if not report.problem.profile.recess.any():
        weights = radial_weight(face.radii, report.average, report.inner_radius) * face.lengths
        heights = report.take("profile") - report.problem.profile.standoff
        slopes, lower = (np.sqrt(values**2 @ weights) for values in face.slopes(heights))
        reported = report.take("rms_slope")
        # slopes that are far below the mean one of the indentation have the error of that
        size = np.maximum(reported, LEAST_SLOPE * scale)
        tolerance = rtol + report.errors("rms_slope")[0] + DOUBT * np.abs(slopes - lower) / size
        yield Row("RMS slope of the face", reported, slopes, tolerance, size)


def check_pressures_inside(report: Reported) -> Rows:
    """Compare pressures at the reported radii with those over the face, away from its edges."""
    face, pressure = report.face, report.take("pressure")
    element = np.searchsorted(face.breakpoints, report.radii, side="right") - 1
    elements = len(face.breakpoints) - 1
    element = np.clip(element, 0, elements - 1)
    carries = (pressure.reshape(len(pressure), elements, -1) > 0).all(axis=2)
    inside = _with_neighbours(np.asarray(carries), AWAY)[:, element]
    # at the start pressures may be infinite on the axis, as under a cone
    inside[np.ix_(report.distances == 0, element == 0)] = False
    reference, doubt = face.interpolate(pressure, report.radii)
    wrong = report.take("pressure", on_face=False) - reference
    count = inside.sum(axis=1)
    rows = np.flatnonzero(count)
    size = pressure.max(axis=1)[rows]
    wrong, doubt = (
        np.sqrt(np.where(inside, part**2, 0.0).sum(axis=1)[rows] / count[rows]) / size
        for part in (wrong, doubt)
    )
    if len(rows):
        tolerance = report.rtol + DOUBT * doubt
        yield Row("pressure at the radii reported, inside the contact", wrong, 0.0, tolerance, 1.0)


def check_disc(report: Reported) -> Rows:
    """Compare the force with that of the reported profile where contact is one disc.

    Galin's relation is that of a homogeneous half-space.
    """
    if report.reading.ground is not None:
        return
    pressure, heights = report.take("pressure"), report.take("profile")
    radii, force, depth = report.face.radii, report.take("normal_force"), report.take("indentation")
    edge = _outermost(report, pressure)
    disc = ((pressure > 0) == (radii <= edge[:, None])).all(axis=1) & (force > 0) & (edge > 0)
    disc &= not report.inner_radius
    rows = np.flatnonzero(disc)
    if report.problem.profile.recess.any() or not len(rows):
        return
    fine, coarse = (
        np.array([_abel_integral(radii[::every], heights[row, ::every], edge[row]) for row in rows])
        for every in (1, 2)
    )
    of_depth, of_profile = report.rtol + report.errors("indentation", "profile")[:, rows]
    depths = _elastic_depth(report)[rows]
    # the Abel transform of heights that err by some part may err by twice that
    tolerance = of_depth * (force[rows] + 2 * depths) + 4 * of_profile * depths
    tolerance += DOUBT * np.abs(fine - coarse)
    # the edge is known to a radius of the face; F does not depend on it to the first order
    value = 2 * (depth[rows] * edge[rows] - fine)
    name = "force of the profile on a disc (Galin)"
    yield Row(name, force[rows], value, tolerance / force[rows], force[rows])


def check_peak(report: Reported) -> Rows:
    """Compare the peak pressure at the start with the pressure over the face."""
    if report.starts and report.given("pressure_peak_start"):
        pressures = np.sort(report.take("pressure")[0])[::-1]
        highest, near, peak = (
            float(value)
            for value in (pressures[0], pressures[NEAR_PEAK], report.take("pressure_peak_start"))
        )
        if near <= highest / 2:
            # narrower than the distance of two radii: it is at least as high as what they see
            highest = max(highest, peak)
        tolerance = report.rtol + 4 * (highest - near) / highest
        yield Row("peak pressure of the answer", peak, highest, tolerance)


def _with_neighbours(mask: Mask, reach: int) -> Mask:
    """Return where a mask (T, n) holds, and at so many neighbours on each side, too."""
    padded = np.pad(mask, ((0, 0), (reach, reach)), mode="edge")
    around = np.asarray(sliding_window_view(padded, 2 * reach + 1, axis=1))
    return np.asarray(around.all(axis=2))


def _unseen(pressure: Array) -> Array:
    """Return infinity at times (T,) at which too few radii of the face press for an integral."""
    return np.where((pressure > 0).sum(axis=1) < FEWEST, np.inf, 0.0)


def _elastic_depth(report: Reported) -> Array:
    """Return the greatest indentation so far beyond the first touch (T,), which errors refer to."""
    beyond = report.take("indentation") - report.problem.profile.standoff
    return np.maximum(np.maximum.accumulate(beyond), np.finfo(float).tiny)


def _outermost(report: Reported, pressure: Array) -> Array:
    """Return the outermost radius of the face (T,) at which it presses."""
    return np.where(pressure > 0, report.face.radii, 0.0).max(axis=1)


def _abel_integral(radii: Array, heights: Array, edge: float) -> float:
    """Return ``int_0^c g dx`` up to an edge c for heights that are linear between radii."""
    node, weight = unit_gauss(60)
    radii, heights = np.append(0.0, radii), np.append(heights[0], heights)
    transformed = profile_transform(radii, edge * node) @ heights
    return float(edge * weight @ transformed)
