"""Check the steady state against direct integration (Eqs. 21 to 27)."""

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, unit_gauss
from .anchor import Row, Rows
from .reported import ROUNDOFF_TOLERANCE, Reported

# numbers of rings that approximate a wear coefficient along the radius, for an extrapolation: the
# error is proportional to the inverse square of the number
FEW_RINGS, MANY_RINGS = 100, 200
# relative tolerance of the least and greatest steady pressure on a ring with a constant k
PRESSURE_EXTREMES_TOLERANCE = 1e-9


def check_steady_state(report: Reported) -> Rows:
    """Compare wear rate, pressures, displacement, slope and profile of the steady state.

    If the wear coefficient varies along the radius, displacement, slope and profile are compared
    with those of many rings; else with closed forms.
    """
    problem = report.problem
    pressures = report.steady_wear_rate / report.reading.wear_at(report.radii)
    tolerance_of_rate = max(ROUNDOFF_TOLERANCE, report.graded * report.rtol)
    rate = report.take("steady_wear_rate")
    yield Row("steady_wear_rate in closed form", rate, report.steady_wear_rate, tolerance_of_rate)
    value = report.take("steady_pressure")
    yield Row("steady pressures of Eq. 24", value, pressures, report.rtol)
    if report.has("force_share"):
        shares = report.steady_wear_rate * report.face.ring_sums(report.face.areas / report.wear)
        value = report.take("force_share")[1]
        yield Row("steady force shares of the answer", value, shares, report.rtol, 1.0)
    if report.has("indentation_steady"):
        value, reference = report.take("indentation_steady"), report.take("steady_displacement_max")
        yield Row("steady indentation of the answer", value, reference, ROUNDOFF_TOLERANCE)
    slowest, fastest = report.reading.extremes_of_wear()
    for name, coefficients in (("pressure_min", fastest), ("pressure_max", slowest)):
        value = report.take_steady_pressure(name)
        reference = report.steady_wear_rate / coefficients
        label = f"steady {name} of the answer"
        yield Row(
            label, value, reference, max(PRESSURE_EXTREMES_TOLERANCE, report.rtol * report.graded)
        )
    if report.graded:
        yield from _compare_with_many_rings(report)
        return
    rings = problem.merged.ring_edges, report.steady_pressures
    ground = report.reading.ground
    greatest = direct.greatest_displacement(*rings, ground)
    limit = greatest - report.steady_displacement(report.radii)
    for name, reference, scale in (
        ("steady_displacement_max", greatest, None),
        (
            "steady_rms_slope",
            direct.rms_slope(*rings, report.average, report.inner_radius, ground),
            None,
        ),
        ("steady_profile", limit, greatest),
    ):
        tolerance = report.tolerance(name)
        yield Row(f"{name} in closed form", report.take(name), reference, tolerance, scale)


def _compare_with_many_rings(report: Reported) -> Rows:
    """Compare the steady state of a wear coefficient along the radius with that of many rings.

    Replacing the pressure by its means over rings is of second order in their width, which allows
    an extrapolation from two numbers of rings.
    """
    coarse, fine = (_displace_by_rings(report, count) for count in (FEW_RINGS, MANY_RINGS))
    greatest = fine[0] + (fine[0] - coarse[0]) / 3
    # the error of the extrapolated result is much smaller than this difference
    error = abs(fine[0] - coarse[0])
    value = report.take("steady_displacement_max")
    tolerance = report.rtol + error / greatest
    yield Row("steady_displacement_max by many rings", value, greatest, tolerance)
    displacement = fine[1] + (fine[1] - coarse[1]) / 3
    error += np.abs(fine[1] - coarse[1]).max()
    value, tolerance = report.take("steady_profile"), report.rtol + error / greatest
    yield Row("steady_profile by many rings", value, greatest - displacement, tolerance, greatest)
    (square,), (square_error,) = report.mean_square_slopes(report.steady_profile_on_face[None])
    if square > 0:
        tolerance = report.rtol + square_error / (2 * square)
        value = report.take("steady_rms_slope")
        yield Row("steady RMS slope of the profile", value, np.sqrt(square), tolerance)


def _displace_by_rings(report: Reported, count: int) -> tuple[float, Array]:
    """Compute the greatest steady displacement, and the steady displacements at the output radii.

    The steady pressure is replaced by its mean on each ring. The rings are `count` rings of
    `_even_edges`, divided at the ring edges of the scene.
    """
    scene_edges = report.problem.merged.ring_edges
    edges = np.union1d(_even_edges(report, count), scene_edges[scene_edges >= report.inner_radius])
    nodes, weights = unit_gauss(3)
    widths = np.diff(edges)[:, None]
    radii = edges[:-1, None] + widths * nodes
    pressures = report.steady_wear_rate / report.reading.wear_at(radii)
    means = np.sum(pressures * radii * weights * widths, axis=1) / (np.diff(edges**2) / 2)
    if report.inner_radius:
        edges, means = np.append(0.0, edges), np.append(0.0, means)
    ground = report.reading.ground
    greatest = float(direct.greatest_displacement(edges, means, ground))
    return greatest, direct.displacement(edges, means, report.radii, ground)


def _even_edges(report: Reported, count: int) -> Array:
    """Return the edges (count + 1,) of rings across which the wear coefficient k changes little.

    The width of a ring, in punch radii, plus the change of log k across it is the same for all
    rings. So k changes little in any of them, and no ring is much wider than the others.
    """
    even_radii = np.linspace(report.inner_radius, 1, 4001)
    radii = np.union1d(even_radii, report.reading.radii_of_even_wear())
    radii = radii[radii >= report.inner_radius]
    changes = np.abs(np.diff(np.log(report.reading.wear_at(radii))))
    measure = np.append(0.0, np.cumsum(np.diff(radii) + changes))
    return np.interp(np.linspace(0, measure[-1], count + 1), measure, radii)
