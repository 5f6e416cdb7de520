"""Check fields at the reported radii, and the edges of the contact."""

import numpy as np

from ....meshes.radial import Array
from ..wear.unilateral import Mask
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, ROUNDOFF_TOLERANCE, Reported

# greatest distance of an edge from the radius at which the pressure begins, in cells of the march:
# an edge that moves is extrapolated beyond the cell in which contact ends
CONTACT_EDGE_CELLS = 1.5


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


def check_contact(report: Reported) -> Rows:
    """Compare the edges of the contact with its radius, and with contact and pressure over radii.

    A radius may be in contact on the wrong side of an edge only in the cells beside the edge.
    """
    evolution, face = report.solution.evolution, report.face
    edges, radius = report.take("contact_edge"), report.take("contact_radius")
    outermost = np.nanmax(edges, axis=1, initial=0.0)
    yield Row("contact radius, the outermost edge", radius, outermost, ROUNDOFF_TOLERANCE, 1.0)
    cells = evolution.punch.space.breakpoints if evolution else face.breakpoints
    for name, radii, contact in (
        ("contact", report.radii, report.take("contact", on_face=False)),
        ("pressure", face.radii, report.contact),
    ):
        distance = _cells_from_edges(edges, radii, cells)
        wrong = contact != _between(edges, radii)
        value = np.where(wrong, distance, 0.0).max(axis=1)
        yield Row(f"edges of the contact, by the {name}", value, 0.0, CONTACT_EDGE_CELLS, 1.0)


def _between(edges: Array, radii: Array) -> Mask:
    """Return which radii (T, R) lie between the inner and the outer edge of a part (T, E)."""
    inner, outer = (edges[:, end::2, None] for end in (0, 1))
    return np.any((radii >= inner) & (radii <= outer), axis=1)


def _cells_from_edges(edges: Array, radii: Array, cells: Array) -> Array:
    """Return the distance of radii (R,) from the nearest edge (T, R), in cells between them."""
    # positions that grow by 1 from each end of a cell to the next
    of_edges, of_radii = (np.interp(each, cells, np.arange(len(cells))) for each in (edges, radii))
    distances = np.abs(of_radii - np.nan_to_num(of_edges, nan=np.inf)[..., None])
    return distances.min(axis=1, initial=np.inf)
