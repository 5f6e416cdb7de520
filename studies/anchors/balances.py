"""Check sums: forces of rings, worn volumes, and what is worn and pressed in at a fixed depth."""

import numpy as np

from ..problem.face import POINTS
from .anchor import Row, Rows
from .reported import DOUBT, EXACT, Reported


def check_forces(report: Reported) -> Rows:
    """Compare ring forces with the force on the punch and with integrals of the pressure."""
    forces, parts = report.take("ring_force"), report.face.areas * report.take("pressure")
    whole = forces.sum(axis=1)
    if not report.fixed:
        error = np.maximum(report.errors("ring_force")[0], EXACT)
        yield Row("ring forces add up to F", whole, report.forces, error)
    doubt = DOUBT * report.face.integral_error(parts)
    # contact may lie between the radii of the face
    doubt[(parts > 0).sum(axis=1) < POINTS] = np.inf
    doubt += report.tolerance("pressure") * np.maximum(whole, np.finfo(float).tiny)
    sums = report.face.ring_sums(parts)
    yield Row("ring forces are integrals of the pressure", sums, forces, doubt[:, None], 1.0)


def check_worn_volumes(report: Reported) -> Rows:
    """Compare what has worn where contact opens and closes with the work of the force.

    Where k varies on a ring, no volume tells how much the pressure has worn.
    """
    if not (report.fixed or report.graded):
        worn = report.take("ring_worn_volume")[report.later] / report.problem.wear_coefficients
        value, work = worn.sum(axis=1), report.work[report.later]
        yield Row("worn volume over k, F v0 t", value, work, EXACT)


def check_decay(report: Reported) -> Rows:
    """Compare the force at a fixed indentation, which decays, with what it wears."""
    force = report.take("normal_force")
    if report.full and report.starts:
        tolerance = report.tolerance("normal_force")[0]
        name = "flat start, F = 2 a E* d"
        if report.inner_radius or report.reading.ground:
            name = f"flat start, F {report.kind_of_punch}"
        yield Row(name, force[0], 1.0, tolerance)
    if report.graded:
        return
    volumes, coefficients = report.take("ring_worn_volume"), report.problem.wear_coefficients
    worn = (volumes / coefficients).sum(axis=1)
    # at a stop nothing changes
    distances, at = np.unique(report.distances, return_index=True)
    greatest = np.maximum.accumulate(force)
    # errors of volumes are relative to their sum, also that of a ring that hardly wears
    most = volumes.sum(axis=1) * np.sum(1 / coefficients)
    errors = report.errors("normal_force", "ring_worn_volume") * [greatest, most]
    passed, force, worn, errors = np.diff(distances), force[at], worn[at], errors[:, at]
    error, lost = errors[:, 1:] + errors[:, :-1]
    doubt = EXACT * force[0] + error + lost / passed
    rates, scale = np.diff(worn) / passed, np.maximum(force[:-1], np.finfo(float).tiny)
    between = np.clip(rates, force[1:], force[:-1])
    yield Row("worn volume over k, between F v0 t", rates, between, doubt / scale, scale)


def check_fixed_indentation(report: Reported) -> Rows:
    """Compare what is worn and still pressed in with what the unworn face overlaps."""
    depth, unworn = report.take("indentation"), report.problem.profile
    pressure, radii = report.take("pressure"), report.face.radii
    uniform = report.uniform_displacement
    heights = pressure * uniform + unworn(radii) + unworn.standoff
    gap = report.take("displacement") + report.take("profile") - depth[:, None]
    parts, doubt = report.integrate(heights - gap)
    unseen = report.take("normal_force") - report.integrate(pressure)[0]
    doubt += np.abs(unseen) * uniform.max()
    stated = report.errors("pressure", "profile", "displacement").sum(axis=0)
    tolerance = report.rtol + stated + doubt / depth
    value = report.take("ring_worn_volume").sum(axis=1) + parts
    whole = report.area * depth
    yield Row("worn, unworn and pressed in, of the overlap A d", value, whole, tolerance, depth)
