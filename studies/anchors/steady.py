"""Check the steady state against direct integration (Eqs. 21 to 27)."""

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, unit_gauss
from ..sampling.norms import radial_weight
from .anchor import Row, Rows
from .reported import DOUBT, EXACT, Reported

# rings that stand for a wear coefficient along the radius; errors go as the inverse square
FEW_RINGS, MANY_RINGS = 100, 200
# tolerance of the extremes of the pressure on a ring of constant wear, to which it is proportional
EXTREMES = 1e-9


def check_steady_state(report: Reported) -> Rows:
    """Compare wear rate and pressures, and for rings of constant wear everything else."""
    problem = report.problem
    pressures = report.steady_wear_rate / report.reading.wear_at(report.radii)
    exact = max(EXACT, report.graded * report.rtol)
    rate = report.take("steady_wear_rate")
    yield Row("steady_wear_rate in closed form", rate, report.steady_wear_rate, exact)
    value = report.take("steady_pressure")
    yield Row("steady pressures of Eq. 24", value, pressures, report.rtol)
    if report.given("force_share"):
        shares = report.steady_wear_rate * report.face.ring_sums(report.face.areas / report.wear)
        value = report.take("force_share")[1]
        yield Row("steady force shares of the answer", value, shares, report.rtol, 1.0)
    if report.given("indentation_steady"):
        value, reference = report.take("indentation_steady"), report.take("steady_displacement_max")
        yield Row("steady indentation of the answer", value, reference, EXACT)
    slowest, fastest = report.reading.extremes_of_wear()
    for name, coefficients in (("pressure_min", fastest), ("pressure_max", slowest)):
        value = report.take_steady_pressure(name)
        reference = report.steady_wear_rate / coefficients
        label = f"steady {name} of the answer"
        yield Row(label, value, reference, max(EXTREMES, report.rtol * report.graded))
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

    Means over rings are of second order, so that two numbers of rings extrapolate.
    """
    few, many = (_displace_by_rings(report, count) for count in (FEW_RINGS, MANY_RINGS))
    greatest = many[0] + (many[0] - few[0]) / 3
    # what extrapolation leaves is far less than what it adds
    doubt = abs(many[0] - few[0])
    value = report.take("steady_displacement_max")
    tolerance = report.rtol + doubt / greatest
    yield Row("steady_displacement_max by many rings", value, greatest, tolerance)
    displacement = many[1] + (many[1] - few[1]) / 3
    doubt += np.abs(many[1] - few[1]).max()
    value, tolerance = report.take("steady_profile"), report.rtol + doubt / greatest
    yield Row("steady_profile by many rings", value, greatest - displacement, tolerance, greatest)
    face = report.face
    weights = radial_weight(face.radii, report.average, report.inner_radius) * face.lengths
    profile = report.steady_profile_on_face[None]
    slope, lower = (np.sqrt(slopes[0] ** 2 @ weights) for slopes in face.slopes(profile))
    if slope > 0:
        tolerance = report.rtol + DOUBT * abs(slope - lower) / slope
        value = report.take("steady_rms_slope")
        yield Row("steady RMS slope of the profile", value, slope, tolerance)


def _displace_by_rings(report: Reported, count: int) -> tuple[float, Array]:
    """Compute the greatest steady displacement, and the steady displacements at the output radii.

    The steady pressure is replaced by its mean on each ring. The rings are `count` rings of
    `_even_edges`, divided at the ring edges of the scene.
    """
    own = report.problem.merged.ring_edges
    edges = np.union1d(_even_edges(report, count), own[own >= report.inner_radius])
    node, weight = unit_gauss(3)
    widths = np.diff(edges)[:, None]
    radii = edges[:-1, None] + widths * node
    pressures = report.steady_wear_rate / report.reading.wear_at(radii)
    means = np.sum(pressures * radii * weight * widths, axis=1) / (np.diff(edges**2) / 2)
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
    radii = np.linspace(report.inner_radius, 1, 4001)
    changes = np.abs(np.diff(np.log(report.reading.wear_at(radii))))
    passed = np.append(0.0, np.cumsum(np.diff(radii) + changes))
    return np.interp(np.linspace(0, passed[-1], count + 1), passed, radii)
