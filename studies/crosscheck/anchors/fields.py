"""Check fields at the reported radii, and the contact radius of full contact."""

import numpy as np

from ..wear.unilateral import Mask
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, Reported


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


def _beside_contact_edges(report: Reported) -> Mask:
    """Return which reported radii share an element of the face with an outermost contact edge.

    A contact that is smaller than the element has worn a spot there that interpolation misses.
    """
    if not report.has("contact_radius"):
        return np.zeros(len(report.radii), dtype=bool)
    ends = report.face.breakpoints[1:-1]
    edges = np.searchsorted(ends, report.take("contact_radius"))
    return np.isin(np.searchsorted(ends, report.radii), edges)
