"""Check that the solved problem and the reported coordinates agree with the scene."""

import numpy as np

from ....meshes.ground.ground import Ground
from ....meshes.radial import Array, ring_areas
from .anchor import Row, Rows
from .reported import Reported

# relative tolerances of numbers that are only scaled, of means that are integrated over the face,
# and of such means if the wear coefficient is a table along the radius
COPIED, INTEGRATED, INTEGRATED_TABLE = 1e-12, 1e-9, 1e-5
# relative tolerance of wear coefficients at the radii of the face: next to a step of the wear
# coefficient a radius may be rounded to the other side
WEAR_AT_RADII = 1e-6
TINY = np.finfo(float).tiny


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
    unworn = problem.profile(face.radii) + problem.profile.standoff
    expected = reading.unworn(face.radii)
    scale = max(float(np.ptp(expected)), float(expected.max()), TINY)
    yield Row("unworn profile as in the scene", unworn, expected, INTEGRATED, scale)
    same_layers = np.allclose(
        _numbers(problem.ground), _numbers(reading.ground), rtol=COPIED, atol=0
    )
    yield Row("layers as in the scene", float(same_layers), 1.0, 0.0)
    if len(problem.times):
        solved, times = problem.times * reading.units.time, reading.times
        yield Row("times as in the scene", solved, times, COPIED, np.maximum(times, TINY))
        state, of_load = problem.loading.at(problem.times), reading.load(problem.times)
        for name, exact in zip(("force", "distance", "work"), of_load, strict=True):
            scale = float(exact.max()) or 1.0
            yield Row(f"{name} as in the scene", getattr(state, name), exact, INTEGRATED, scale)
    means = ring_areas(reading.edges) / reading.inverse_wear
    coefficients = np.asarray(report.table["wear_coefficient"]) / report.units.wear_coefficient
    # the area of a narrow ring is a small difference of two large numbers
    roundoff = 8 * np.finfo(float).eps / np.diff(reading.edges)
    tolerance = (INTEGRATED_TABLE if report.graded else INTEGRATED) + roundoff
    yield Row("reported wear coefficients", coefficients, means, tolerance)


def _numbers(ground: Ground) -> Array:
    """Return all numbers of the layers; none is infinite."""
    numbers = [ground.share, *ground.thicknesses, *ground.shear_moduli, *ground.poisson_ratios]
    return np.nan_to_num(numbers[: -1 if ground.rigid else None])
