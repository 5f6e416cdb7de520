"""Check flat punches: the start in closed form (Eqs. 10 and 11), and the wear of the whole face."""

import numpy as np

from .anchor import Row, Rows
from .reported import HEIGHT_ROUNDOFF, ROUNDOFF_TOLERANCE, Reported


def check_start(report: Reported) -> Rows:
    """Compare the indentation at the start, ``d = F / (2 a E*)`` for a solid punch."""
    tolerance, reference = report.tolerance("indentation"), report.flat.indentation
    if report.includes_start:
        name = report.name_of_start("d", "F / (2 a E*)")
        depth = report.take("indentation")[0]
        yield Row(name, depth, reference * report.forces[0], tolerance[0])
    if report.solution.wear is not None:
        depth, tolerance = report.take("indentation_start"), report.tolerance("indentation_start")
        yield Row("flat start of the answer", depth, reference, tolerance)


def check_start_pressures(report: Reported) -> Rows:
    """Compare pressures and ring forces at the start, ``p = p0 / sqrt(1 - r^2/a^2)``."""
    edges, flat = report.problem.ring_edges, report.flat
    # the pressure is infinite at the rim and at the edge of a hole
    inside = (report.radii < 1) & ((report.radii > report.inner_radius) | (report.radii == 0))
    if report.includes_start:
        pressure, force = (report.tolerance(name)[0] for name in ("pressure", "ring_force"))
        value = report.take("pressure", on_face=False)[0, inside] / report.forces[0]
        name = report.name_of_start("p", "p0 / sqrt(1 - r^2/a^2)")
        yield Row(name, value, flat.pressure_at(report.radii[inside]), pressure)
        value = report.take("ring_force")[0] / report.forces[0]
        yield Row("flat start, forces of the rings", value, flat.ring_forces(edges), force, 1.0)


def check_wear(report: Reported) -> Rows:
    """Compare the wear of the whole face with the work of the force."""
    work, face, rows = report.work, report.face, report.has_slid
    even_wear = report.steady_wear_rate * work[rows]
    exact = max(ROUNDOFF_TOLERANCE, report.graded * report.rtol)
    yield Row("even wear, w F v0 t", report.even_wear[rows], even_wear, exact)
    indentation = report.take("indentation")
    worn, quadrature_error = report.integrate(report.take("profile"), 1 / report.wear)
    # the error of the profile is relative to the indentation
    quadrature_error += report.tolerance("profile") * indentation * (face.areas / report.wear).sum()
    tolerance = np.maximum(quadrature_error[rows] / work[rows], report.rtol)
    yield Row("worn volume over k, F v0 t", worn[rows], work[rows], tolerance)
    worn = report.take("worn_volume") / report.problem.wear_coefficients
    if np.isfinite(worn).all() and not report.graded:
        name = "worn volume of the answer over k, F v0 t"
        exact = max(ROUNDOFF_TOLERANCE, float(report.tolerance("worn_volume")))
        # heights are differences f = d - u; dividing by a small k magnifies their roundoff
        roundoff = HEIGHT_ROUNDOFF * indentation[-1] * (face.areas / report.wear).sum()
        yield Row(name, worn.sum(), work[-1], exact + roundoff / work[-1])
