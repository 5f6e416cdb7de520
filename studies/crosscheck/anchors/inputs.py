"""Check that the solved problem and the reported coordinates agree with the scene."""

import numpy as np

from ....meshes.radial import ring_areas
from .anchor import Row, Rows
from .reported import ROUNDOFF_TOLERANCE, Reported

# relative tolerances of numbers that are only scaled, of means that are integrated over the face,
# and of such means if the wear coefficient is a table along the radius
COPIED, INTEGRATED, INTEGRATED_TABLE = 1e-12, 1e-9, 1e-5
# relative tolerance of wear coefficients at the radii of the face: next to a step of the wear
# coefficient a radius may be rounded to the other side
WEAR_AT_RADII = 1e-6


def check_inputs(report: Reported) -> Rows:
    """Compare accuracy, average, rings and wear coefficients with a second reading of the scene."""
    problem, reading, face = report.problem, report.reading, report.face
    yield Row("rtol as in the scene", problem.rtol, reading.rtol, COPIED)
    same_average = float(problem.gradient_average == reading.average)
    yield Row("gradient average as in the scene", same_average, 1.0, 0.0)
    yield Row("ring edges as in the scene", problem.ring_edges, reading.edges, COPIED, 1.0)
    yield Row("wear coefficients as in the scene", face.wear, report.wear, WEAR_AT_RADII)
    for name, edges in (("inner", reading.edges[:-1]), ("outer", reading.edges[1:])):
        radii = np.asarray(report.table[f"ring_{name}_radius"]) / report.units.length
        yield Row(f"reported {name} radii", radii, edges, COPIED, 1.0)
    if not report.scene.punch.heights:
        unworn = problem.profile(face.radii) + problem.profile.standoff
        expected = reading.unworn(face.radii)
        scale = max(float(np.ptp(expected)), float(expected.max()), np.finfo(float).tiny)
        yield Row("unworn profile as in the scene", unworn, expected, INTEGRATED, scale)
    yield from _compare_layers(report)
    means = ring_areas(reading.edges) / reading.inverse_wear
    coefficients = np.asarray(report.table["wear_coefficient"]) / report.units.wear_coefficient
    # the area of a narrow ring is a small difference of two large numbers
    roundoff = 8 * np.finfo(float).eps / np.diff(reading.edges)
    tolerance = (INTEGRATED_TABLE if report.graded else INTEGRATED) + roundoff
    yield Row("reported wear coefficients", coefficients, means, tolerance)


def _compare_layers(report: Reported) -> Rows:
    """Compare the layers of the ground with those of the second reading."""
    solved, expected = report.problem.ground, report.reading.ground
    if not (solved.layered or expected.layered):
        return
    same = float(solved.layered == expected.layered)
    yield Row("presence of layers as in the scene", same, 1.0, 0.0)
    if len(solved.thicknesses) != len(expected.thicknesses):
        return
    thicknesses = np.array(solved.thicknesses), np.array(expected.thicknesses)
    yield Row("thicknesses of the layers as in the scene", *thicknesses, COPIED)
    elastic = np.isfinite(expected.shear_moduli)
    for name, solved_values, expected_values in (
        ("shear moduli", solved.shear_moduli, expected.shear_moduli),
        ("Poisson's ratios", solved.poisson_ratios, expected.poisson_ratios),
    ):
        values, references = np.array(solved_values)[elastic], np.array(expected_values)[elastic]
        yield Row(
            f"{name} of the layers as in the scene",
            values,
            references,
            COPIED,
            1 + np.abs(references),
        )


def check_times(report: Reported) -> Rows:
    """Compare the times, and the force at these times, with a second reading of the scene."""
    problem, reading = report.problem, report.reading
    times = np.asarray(report.table["time"])
    if not len(times) or len(times) != len(reading.times):
        return
    scale = np.maximum(reading.times, np.finfo(float).tiny)
    solved = problem.times * reading.units.time
    yield Row("times as in the scene", solved, reading.times, COPIED, scale)
    yield Row("reported times", times, reading.times, COPIED, scale)
    if report.fixed_indentation or "normal_force" not in report.table:
        return
    force = np.asarray(report.table["normal_force"]) / report.units.force
    if np.isfinite(force).any():
        expected, _, _ = reading.load(times / report.units.time)
        # a march fulfils the force balance to the accuracy of its steps only
        yield Row(
            "normal force as in the scene",
            force,
            expected,
            ROUNDOFF_TOLERANCE if report.full_contact else report.rtol,
            1.0,
        )
