"""Check the start of a flat punch, solid or hollow, against closed forms (Eqs. 10 and 11)."""

import numpy as np

from ....mdr.annulus_bounds import stiffness_bounds
from .anchor import Row, Rows
from .reported import Reported

# relative roundoff of the bounds on the stiffness of an annulus
BOUNDS_ROUNDOFF = 1e-12


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
        if report.inner_radius and not report.reading.ground.layered:
            bounds = stiffness_bounds(report.inner_radius)
            stiffness = 1 / depth
            nearest = np.clip(stiffness, *bounds)
            stated_error = report.errors("indentation_start")[0] + BOUNDS_ROUNDOFF
            yield Row(
                "stiffness of an annulus, within its bounds",
                stiffness,
                nearest,
                stated_error,
            )


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
    if report.solution.wear is not None:
        for name, reference in zip(
            ("pressure_min", "pressure_max"), flat.extremes_on(edges), strict=True
        ):
            finite = np.isfinite(reference)
            value, tolerance = report.take(name)[0], float(np.max(report.tolerance(name)))
            label = f"flat start of the answer, {name}"
            yield Row(label, value[finite], reference[finite], tolerance)
        shares, tolerance = report.take("force_share")[0], report.tolerance("force_share")[0]
        reference = flat.ring_forces(edges)
        yield Row("force shares of the answer at the start", shares, reference, tolerance, 1.0)
