"""Check that the problem that was solved, and the coordinates reported, are those of the scene."""

import numpy as np

from .anchor import Row, Rows
from .reported import EXACT, Reported

# tolerances of numbers that are only scaled on the way, and of means that are integrated
COPIED, INTEGRATED, INTEGRATED_TABLE = 1e-12, 1e-9, 1e-5
# beside a step of the wear coefficient a radius of the face may round to the other side
WEAR_AT_RADII = 1e-6


def check_inputs(report: Reported) -> Rows:
    """Compare accuracy, average, rings and wear coefficients with a second reading of the scene."""
    problem, reading, face = report.problem, report.reading, report.face
    yield Row("rtol as asked", problem.rtol, reading.rtol, COPIED)
    same_average = float(problem.gradient_average == reading.average)
    yield Row("average as asked", same_average, 1.0, 0.0)
    yield Row("ring edges as asked", problem.ring_edges, reading.edges, COPIED, 1.0)
    yield Row("wear coefficients as asked", face.wear, report.wear, WEAR_AT_RADII)
    for name, edges in (("inner", reading.edges[:-1]), ("outer", reading.edges[1:])):
        radii = np.asarray(report.table[f"ring_{name}_radius"]) / report.units.length
        yield Row(f"{name} radii reported", radii, edges, COPIED, 1.0)
    if not report.scene.punch.heights:
        unworn = problem.profile(face.radii) + problem.profile.standoff
        asked = reading.unworn(face.radii)
        scale = max(float(np.ptp(asked)), float(asked.max()), np.finfo(float).tiny)
        yield Row("unworn profile as asked", unworn, asked, INTEGRATED, scale)
    yield from _compare_layers(report)
    areas = np.pi * np.diff(reading.edges**2)
    means = areas / face.ring_sums(face.areas / report.wear)
    coefficients = np.asarray(report.table["wear_coefficient"]) / report.units.wear_coefficient
    # the area of a narrow ring is a small difference
    roundoff = 8 * np.finfo(float).eps / np.diff(reading.edges)
    tolerance = (INTEGRATED_TABLE if report.graded else INTEGRATED) + roundoff
    yield Row("wear coefficients reported", coefficients, means, tolerance)


def _compare_layers(report: Reported) -> Rows:
    """Compare the layers of the ground with those of the second reading."""
    solved, asked = report.problem.ground, report.reading.ground
    if solved is None and asked is None:
        return
    same = float((solved is None) == (asked is None))
    yield Row("layers or none, as asked", same, 1.0, 0.0)
    if solved is None or asked is None or len(solved.thicknesses) != len(asked.thicknesses):
        return
    thicknesses = np.array(solved.thicknesses), np.array(asked.thicknesses)
    yield Row("thicknesses of the layers as asked", *thicknesses, COPIED)
    elastic = np.isfinite(asked.shear_moduli)
    for name, value, reference in (
        ("shear moduli", solved.shear_moduli, asked.shear_moduli),
        ("Poisson's ratios", solved.poisson_ratios, asked.poisson_ratios),
    ):
        numbers, wanted = np.array(value)[elastic], np.array(reference)[elastic]
        yield Row(f"{name} of the layers as asked", numbers, wanted, COPIED, 1 + np.abs(wanted))


def check_times(report: Reported) -> Rows:
    """Compare the times, and the force at these times, with a second reading of the scene."""
    problem, reading = report.problem, report.reading
    times = np.asarray(report.table["time"])
    if not len(times) or len(times) != len(reading.times):
        return
    scale = np.maximum(reading.times, np.finfo(float).tiny)
    solved = problem.times * reading.units.time
    yield Row("times as asked", solved, reading.times, COPIED, scale)
    yield Row("times reported", times, reading.times, COPIED, scale)
    if report.fixed or "normal_force" not in report.table:
        return
    force = np.asarray(report.table["normal_force"]) / report.units.force
    if np.isfinite(force).any():
        asked, _, _ = reading.load(times / report.units.time)
        # a march carries the force to the accuracy of its steps
        yield Row("normal force as asked", force, asked, EXACT if report.full else report.rtol, 1.0)
