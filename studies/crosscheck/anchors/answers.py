"""Check that the solved problem is that of the scene, and the answer that of the solution.

The solved problem and the reported coordinates are compared with a second reading of the scene. All
numbers of the table and of the answer are compared with the solution that they came from, whatever
they mean. Times of the answer are compared with what remains, or with the contact, then.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ....meshes.ground.ground import Ground
from ....meshes.radial import Array, ring_areas
from ..problem.norms import common
from ..problem.quantities import ANSWER, DESCRIBED, error_name
from .anchor import Row, Rows
from .reported import ROUNDOFF_TOLERANCE, Reported

# relative tolerances of numbers that are only scaled, of means that are integrated over the face,
# and of such means if the wear coefficient is a table along the radius
COPIED, INTEGRATED, INTEGRATED_TABLE = 1e-12, 1e-9, 1e-5
# relative tolerance of wear coefficients at the radii of the face: next to a step of the wear
# coefficient a radius may be rounded to the other side
WEAR_AT_RADII = 1e-6
TINY = np.finfo(float).tiny
# relative step in time of the difference quotient that gives the decay rate of the running-in
RELATIVE_TIME_STEP = 1e-3
# places in two steps, over their length, at which the greatest change is sought
PARTS_OF_STEP = np.linspace(-1, 1, 17)
# rank, from 0, of the pressure whose difference to the highest one estimates the latter's error
PEAK_RADII = 8


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


def check_table(report: Reported) -> Rows:
    """Compare all numbers with the solution, in units that are read a second time."""
    worst = np.array([difference.max(initial=0.0) for difference in _differences(report)])
    yield Row("the table has the numbers of the solution", worst, 0.0, ROUNDOFF_TOLERANCE, 1.0)


def _differences(report: Reported) -> Iterator[Array]:
    """Yield the differences of all arrays of the table and the answer from those of the solution.

    Numbers on the face, which are compared with other methods, must be those that are reported.
    """
    solution, rows = report.solution, report.problem.compared_rows
    for name, solved in solution.results.items():
        if name not in DESCRIBED:
            continue
        expected = solved * getattr(report.units, DESCRIBED[name].unit)
        places = [(name, expected), (error_name(name), solution.errors.get(name))]
        for numbers in (report.table, report.answers):
            for place, values in places:
                if values is not None and place in numbers:
                    yield _relative_difference(numbers[place], values)
        if name in solution.compared and "radius" not in DESCRIBED[name].dims:
            reported = solved[rows] if DESCRIBED[name].over_time else solved
            yield _relative_difference(solution.compared[name], reported)
    times = report.reading.times[: len(report.problem.times)]
    yield _relative_difference(report.table["time"], times)
    radii = report.problem.radii * report.units.length
    yield _relative_difference(report.table["radius"], radii)


def _relative_difference(values: ArrayLike, expected: Array) -> Array:
    """Return the difference of each number that both have; 0 where both are NaN or equal.

    Methods may have different numbers of relaxation times, edges of the contact, and steps.
    """
    values = np.asarray(values, dtype=float)
    shared = common(values.shape, expected.shape)
    values, expected = values[shared], np.asarray(expected[shared], dtype=float)
    same = (values == expected) | (np.isnan(values) & np.isnan(expected))
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(values - expected) / np.maximum(np.abs(expected), TINY)
    return np.where(same, 0.0, np.nan_to_num(difference, nan=1.0, posinf=1.0))


def check_times_of_running_in(report: Reported) -> Rows:
    """Compare the remaining part of the running-in at `time_to_90` and so on with its definition.

    For a flat punch, the total change from the start to the steady state follows from the steady
    pressure, by direct integration. The method's own total change may differ from it by the errors
    that the method states for the start and for the steady state. For a shaped punch, the greatest
    change is that of its steps, and between them.
    """
    solution, fractions = report.solution, report.problem.remaining_parts
    # the verdict is undecided if such a number is missing
    reported = {name: part for name, part in fractions.items() if report.has(name)}
    if not reported:
        return
    if solution.evolution is not None:
        remaining_at, steps = solution.evolution.remaining, solution.evolution.times
        # the greatest change may lie between two steps
        row = np.abs(remaining_at(steps)).argmax()
        times = np.interp(row + PARTS_OF_STEP, np.arange(len(steps)), steps)
        total_change = float(np.abs(remaining_at(times)).max())
        error = report.rtol * total_change
    elif solution.wear is not None and (report.fixed_indentation or report.has_steady_displacement):
        remaining_at = solution.wear.modes.remaining_change
        total_change, error = _total_change(report)
    else:
        return
    for name, remaining_part in reported.items():
        time = float(report.take(name))
        remaining = np.abs(
            remaining_at(time * np.array([1 - RELATIVE_TIME_STEP, 1.0, 1 + RELATIVE_TIME_STEP]))
        )
        decay = abs(np.log(remaining[2] / remaining[0])) / (2 * RELATIVE_TIME_STEP)
        time_error = float(report.tolerance(name))
        tolerance = time_error * decay + (error + 1e-12) / total_change
        yield Row(
            f"{name}: remaining part of the running-in",
            remaining[1] / total_change,
            remaining_part,
            tolerance,
        )


def _total_change(report: Reported) -> tuple[float, float]:
    """Return the total change during running-in, and a bound on its difference to the method's."""
    if report.fixed_indentation:
        return report.flat.indentation, 0.0
    # the steady pressure, as the weight of a mean, carries the force 1
    pressure = report.steady_wear_rate / report.wear
    (steady,), (error,) = report.integrate(report.steady_displacement_on_face[None], pressure)
    start = report.flat.indentation
    error += report.stated_error("indentation_start") * start
    return steady - start, error + report.stated_error("indentation_steady") * steady


def check_time_to_full_contact(report: Reported) -> Rows:
    """Compare the contact a little before and after `time_to_full_contact` with its definition."""
    evolution, name = report.solution.evolution, "time_to_full_contact"
    if evolution is None or not report.has(name) or not (time := float(report.take(name))):
        return
    error = float(report.tolerance(name))
    full = evolution.at(time * np.array([1 - error, 1 + error])).contact.all(axis=1)
    yield Row(
        f"{name}: contact before and after", full.astype(float), np.array([0.0, 1.0]), 0.0, 1.0
    )


def check_repeated_numbers(report: Reported) -> Rows:
    """Compare numbers of the answer with the first or the last value of their series."""
    results = report.solution.results
    for name, number in ANSWER.items():
        if number.at and {name, number.at[0]} <= results.keys():
            series, at = number.at
            # a flat punch has its start in closed form, and a fitted start is more accurate
            tolerance = report.rtol + report.stated_error(name) + report.stated_error(series)
            # what decays is as accurate as it was at first
            values = results[series] if at else results[series][0]
            scale = float(np.nanmax(np.abs(values))) or 1.0
            if at or (report.includes_start and not report.problem.loading.varies):
                label = f"{name} of the answer"
                yield Row(label, results[name], results[series][at], tolerance, scale)


def check_peak(report: Reported) -> Rows:
    """Compare the peak pressure at the start with the pressure over the face."""
    if report.includes_start:
        pressures = np.sort(report.take("pressure")[0])[::-1]
        peak = float(report.take("pressure_peak_start"))
        highest, nearby = float(pressures[0]), float(pressures[PEAK_RADII])
        if nearby <= highest / 2:
            # the peak may lie between two radii: then it is at least as high as the pressures there
            highest = max(highest, peak)
        tolerance = report.rtol + 4 * (highest - nearby) / highest
        yield Row("peak pressure of the answer", peak, highest, tolerance)
