"""Check the start of a flat punch against its closed form (Eqs. 10 and 11)."""

import numpy as np

from ..problem.problem import D0, P0
from .anchor import Row, Rows
from .reported import Reported, root


def check_start(report: Reported) -> Rows:
    """Compare the indentation at the start, ``d = F / (2 a E*)``."""
    tolerance = report.tolerance("indentation")
    if report.starts:
        depth = report.take("indentation")[0]
        yield Row("flat start, d = F / (2 a E*)", depth, D0 * report.forces[0], tolerance[0])
    if report.solution.wear is not None:
        depth = report.take("indentation_start")
        yield Row("flat start of the answer", depth, D0, report.tolerance("indentation_start"))


def check_start_pressures(report: Reported) -> Rows:
    """Compare pressures and ring forces at the start, ``p = p0 / sqrt(1 - r^2/a^2)``."""
    edges, inside = report.problem.ring_edges, report.radii < 1
    if report.starts:
        pressure, force = (report.tolerance(name)[0] for name in ("pressure", "ring_force"))
        radii = report.radii[inside]
        value = report.take("pressure", on_face=False)[0, inside] / report.forces[0]
        yield Row("flat start, p = p0 / sqrt(1 - r^2/a^2)", value, P0 / root(radii), pressure)
        value = report.take("ring_force")[0] / report.forces[0]
        yield Row("flat start, forces of the rings", value, -np.diff(root(edges)), force, 1.0)
    if report.solution.wear is not None:
        # infinite at the rim
        least, greatest = report.take("pressure_min")[0], report.take("pressure_max")[0, :-1]
        reference = P0 / root(np.append(edges[:-1], edges[1:-1]))
        tolerance = max(report.tolerance(name)[0] for name in ("pressure_min", "pressure_max"))
        value = np.append(least, greatest)
        yield Row("flat start of the answer, pressures", value, reference, tolerance)
        shares, tolerance = report.take("force_share")[0], report.tolerance("force_share")[0]
        reference = -np.diff(root(edges))
        yield Row("force shares of the answer at the start", shares, reference, tolerance, 1.0)
