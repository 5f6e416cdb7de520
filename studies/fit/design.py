"""Find the further measurement that would narrow the widest interval most.

The Fisher information ``J^T J`` of each candidate, with derivatives J over the noise, is added to
that of the data. It is computed at the most likely point. If a parameter is not identifiable, the
variances are averaged over several points within the threshold of the likelihood, and the result is
only a guide. The noise of a candidate is that of the data, or a usual value.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from ...meshes import Array
from ..estimate.estimator import Likelihood
from ..estimate.measurement import Measurement
from .outcome import Outcome
from .parameters import REACH

# numbers of values in a further series in time, and in a further profile, and number of times at
# which profiles and volumes are considered
SERIES_VALUES, PROFILE_RADII, CANDIDATE_TIMES = 40, 60, 4
# noise of quantities that are not in the data: of a profile over its range, of a volume over its
# value, and of the indentation or the force over its greatest value
PROFILE_NOISE, VOLUME_NOISE, DEPTH_NOISE = 0.01, 0.01, 1e-3
# greatest numbers of points over which variances are averaged, of candidates in the table, and of
# rings that are weighed one by one
MAX_POINTS, MAX_ROWS, MAX_RINGS = 5, 12, 8


def design_table(fit: Outcome) -> pd.DataFrame:
    """Return a table of further measurements with the half widths of the intervals after each.

    Half widths are those of 95 % intervals of the coordinates: of logarithms, or over the scale of
    the parameter.

    Returns
    -------
    table : best first, with the columns measurement, parameter (the one with the widest interval
        now), before and after (its half widths), widest after (of all parameters), and a half width
        for each free parameter. `attrs["before"]` has the half widths of the data alone
    """
    likelihood = fit.likelihood
    free = [likelihood.parameters[number] for number in likelihood.free]
    names = [f"half width of {each.name}" for each in free]
    # without any data, a parameter is known to be within its reach
    reach = np.array([np.log(REACH) if each.logarithmic else REACH for each in free])
    prior = np.diag(1 / reach**2)
    points = _points(fit)
    data_slopes = [likelihood.slopes(x) for x in points]
    before = _half_widths([slopes.T @ slopes + prior for slopes in data_slopes])
    widest = int(np.argmax(np.where([each.logarithmic for each in free], before, 0.0)))
    candidates = list(_candidates(fit))
    measurements = _with_noise(fit, [measurement for _, measurement in candidates])
    model, rows = likelihood.predictor.for_measurements(tuple(measurements)), []
    all_slopes = [model.slopes(x) for x in points]
    for number, (description, _) in enumerate(candidates):
        further_slopes = [
            _free_slopes(slopes[number], measurements[number], likelihood) for slopes in all_slopes
        ]
        pairs = zip(data_slopes, further_slopes, strict=True)
        after = _half_widths([a.T @ a + b.T @ b + prior for a, b in pairs])
        rows.append(
            {
                "measurement": description,
                "parameter": free[widest].name,
                "before": before[widest],
                "after": after[widest],
                "widest after": after.max(),
            }
            | dict(zip(names, after, strict=True))
        )
    table = pd.DataFrame(rows).sort_values("after", ignore_index=True).head(MAX_ROWS)
    table.attrs["before"] = dict(zip(names, before, strict=True))
    return table


def _points(fit: Outcome) -> list[Array]:
    """Return the coordinates of the most likely point, and of others if any is not identifiable."""
    if all(each.identifiable for each in fit.found):
        return [fit.best.x]
    others = [point.x for point in fit.profiles.seen]
    chosen = np.linspace(0, len(others) - 1, min(len(others), MAX_POINTS - 1)).astype(int)
    return [fit.best.x, *(others[number] for number in np.unique(chosen))]


def _half_widths(information: list[Array]) -> Array:
    """Return the 95 % half widths (f,) for informations (f, f), root mean squares over points."""
    variances = [np.diag(np.linalg.inv(each)) for each in information]
    return 1.96 * np.sqrt(np.mean(variances, axis=0))


def _free_slopes(slopes: Array, measurement: Measurement, likelihood: Likelihood) -> Array:
    """Return the derivatives (n, f) by the free parameters, over the noise, without an offset."""
    if measurement.has_offset:
        slopes = slopes - slopes.mean(axis=0)
    return slopes[:, likelihood.free] / measurement.noise[:, None]


def _with_noise(fit: Outcome, measurements: list[Measurement]) -> list[Measurement]:
    """Return candidates with their final noise, which may depend on the predicted values.

    The noise of profiles is that of profiles in the data, or relative to the greatest range of a
    predicted profile. The noise of volumes is relative to each predicted volume.
    """
    predicted = fit.likelihood.predictor.for_measurements(tuple(measurements)).predict(fit.best.x)
    pairs = list(zip(measurements, predicted, strict=True))
    data_noises = [each.noise.mean() for each in fit.measurements if each.quantity == "profile"]
    ranges = [np.ptp(values) for each, values in pairs if each.quantity == "profile"]
    noises = {
        "profile": data_noises[0] if data_noises else PROFILE_NOISE * max(ranges, default=0.0)
    }
    with_noise = []
    for each, values in pairs:
        noise = each.noise * noises.get(each.quantity, 1.0)
        if each.quantity == "worn_volume":
            noise = np.maximum(noise * np.abs(values), 1e-300)
        with_noise.append(replace(each, noise=noise))
    return with_noise


def _candidates(fit: Outcome) -> Iterator[tuple[str, Measurement]]:
    """Yield further measurements within the times of the data, each with its description."""
    names, scene = fit.scene.unit_names, fit.scene
    times = np.concatenate([each.times for each in fit.measurements])
    first, last = float(times[times > 0].min()), float(times.max())
    depth_noise = _noise_of(fit, "indentation")
    response = "normal_force" if scene.problem.indentation is not None else "indentation"
    noise = _noise_of(fit, response) if response == "normal_force" else depth_noise
    ranges = [(first, last), (first, float(np.sqrt(first * last))), (np.sqrt(first * last), last)]
    name = response.replace("_", " ")
    for begin, end in ranges if last > 2 * first else []:
        between = f"{names.write(begin, 'time', 2)} and {names.write(end, 'time', 2)}"
        series = np.geomspace(begin, end, SERIES_VALUES)
        yield (
            f"{name} at {SERIES_VALUES} more times between {between}",
            _candidate(response, series, noise),
        )
    series = np.geomspace(first, last, SERIES_VALUES)
    yield (
        f"{name} at {SERIES_VALUES} times by a sensor with a tenth of the noise",
        _candidate(response, series, noise / 10),
    )
    radii = np.linspace(scene.punch.inner_radius, scene.punch.radius, PROFILE_RADII + 2)[1:-1]
    rings = len(scene.problem.wear_coefficients)
    for time in np.geomspace(first, last, CANDIDATE_TIMES + 1)[1:]:
        when = f"t = {names.write(time, 'time', 2)}"
        profile = _candidate("profile", np.full(PROFILE_RADII, time), 1.0)
        yield f"a profile at {when}", replace(profile, radii=radii)
        single_time = np.array([time])
        volume = _candidate("worn_volume", single_time, VOLUME_NOISE)
        yield f"lost mass of the punch at {when}, to {VOLUME_NOISE:.0%}", volume
        for ring in range(rings if 1 < rings <= MAX_RINGS else 0):
            description = f"lost mass of ring {ring + 1} at {when}, to {VOLUME_NOISE:.0%}"
            yield description, replace(volume, ring=ring)


def _candidate(quantity: str, times: Array, noise: float) -> Measurement:
    ones = np.ones(len(times))
    return Measurement(quantity, quantity, times, ones, noise * ones, True)


def _noise_of(fit: Outcome, quantity: str) -> float:
    """Return the noise of a quantity in the data, or else a usual value."""
    for each in fit.measurements:
        if each.quantity == quantity:
            return float(np.median(each.noise))
    times = np.unique(np.concatenate([each.times for each in fit.measurements]))
    model = fit.likelihood.predictor.for_measurements((_candidate(quantity, times, 1.0),))
    (values,) = model.predict(fit.best.x)
    return DEPTH_NOISE * float(np.abs(values).max())
