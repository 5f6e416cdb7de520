"""Check balances of forces, of worn volumes, and of the overlap at a fixed indentation."""

import numpy as np

from ....meshes.radial import ring_areas
from ..problem.face import POINTS
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, ROUNDOFF_TOLERANCE, Reported

# roundoff of the worn depth, over the unit of displacements: up to 2e-14 by some hundred modes
# (physics/test_random_scenes.py::test_numbers_at_extremes_are_right_or_left_out)
ROUNDOFF_OF_DEPTHS = 5e-14


def check_forces(report: Reported) -> Rows:
    """Compare ring forces with the force on the punch and with integrals of the pressure."""
    forces, parts = report.take("ring_force"), report.face.areas * report.take("pressure")
    total_force = forces.sum(axis=1)
    if not report.fixed_indentation:
        tolerance = np.maximum(report.errors("ring_force")[0], ROUNDOFF_TOLERANCE)
        yield Row("ring forces add up to F", total_force, report.forces, tolerance)
    quadrature_error = REFERENCE_ERROR_FACTOR * report.face.integral_error(parts)
    # with too few radii in contact, contact may lie between the radii of the face
    quadrature_error[(parts > 0).sum(axis=1) < POINTS] = np.inf
    quadrature_error += report.tolerance("pressure") * np.maximum(total_force, np.finfo(float).tiny)
    sums = report.face.ring_sums(parts)
    yield Row(
        "ring forces are integrals of the pressure", sums, forces, quadrature_error[:, None], 1.0
    )


def check_mean_contact_radius(report: Reported) -> Rows:
    """Compare the mean radius of the force with the first moment of the pressure."""
    pressure, force = report.take("pressure"), report.take("normal_force")
    parts = pressure * report.face.areas * report.face.radii
    quadrature_error = REFERENCE_ERROR_FACTOR * report.face.integral_error(parts)
    # with too few radii in contact, contact may lie between the radii of the face
    quadrature_error[(parts > 0).sum(axis=1) < POINTS] = np.inf
    scale = np.maximum(force, np.finfo(float).tiny)
    tolerance = report.allowed_in_balances("pressure", "mean_contact_radius")
    tolerance = tolerance + (quadrature_error + report.edge_error) / scale
    moment = report.take("mean_contact_radius") * force
    yield Row("moment of the pressure, int p r dA", moment, parts.sum(axis=1), tolerance, scale)


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
