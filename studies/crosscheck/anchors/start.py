"""Check the start of a flat punch, solid or hollow, against closed forms (Eqs. 10 and 11)."""

from .anchor import Row, Rows
from .reported import Reported


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
