"""Check the wear of a flat punch: volumes and power."""

import numpy as np

from .anchor import Row, Rows
from .reported import (
    HEIGHT_ROUNDOFF,
    ROUNDOFF_TOLERANCE,
    Reported,
)


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
