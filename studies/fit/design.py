"""Which further measurement would narrow the widest interval most.

Each candidate adds its information ``J^T J`` to that of the data (Fisher), at the most likely point
or, where something is not identifiable and information at one point is but a guide, on the average
over points that the likelihood allows. Its noise is that of the data, or what is usual.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from ...meshes.radial import Array
from ..problem.unit_names import UnitNames
from .measurement import Measurement
from .outcome import Outcome
from .parameters import REACH
from .statistics.likelihood import Likelihood

# numbers of a further series in time, of a profile, and times that either may be taken at
COUNT, RADII, WHEN = 40, 60, 4
# noise of what the data has none of: part of the range of a profile, part of a volume, and part of
# the range of the indentation
PROFILE_NOISE, VOLUME_NOISE, DEPTH_NOISE = 0.01, 0.01, 1e-3
# points that information is averaged over, candidates that are told, and rings that are weighed
MOST_POINTS, MOST_TOLD, MOST_RINGS = 5, 12, 8


def design_table(fit: Outcome) -> pd.DataFrame:
    """Return further measurements with the half widths of intervals that they would leave.

    Returns
    -------
    table : best first, with columns measurement, parameter (of the widest interval now), before and
        after, and a half width for each parameter that is sought; half widths of 95 %, of
        logarithms or over the scale of a parameter. `attrs["before"]` has those of the data alone
    """
    likelihood = fit.likelihood
    free = [likelihood.parameters[number] for number in likelihood.free]
    names = [f"half width of {each.name}" for each in free]
    # a parameter is known within its reach without any data
    reach = np.array([np.log(REACH) if each.logarithmic else REACH for each in free])
    prior = np.diag(1 / reach**2)
    places = _places(fit)
    own = [likelihood.slopes(x) for x in places]
    before = _half_widths([slopes.T @ slopes + prior for slopes in own])
    widest = int(np.argmax(np.where([each.logarithmic for each in free], before, 0.0)))
    candidates = list(_candidates(fit))
    further = _with_noise(fit, [measurement for _, measurement in candidates])
    model, rows = likelihood.predictor.measuring(tuple(further)), []
    slopes_at = [model.slopes(x) for x in places]
    for number, (told, _) in enumerate(candidates):
        more = [_of_free(slopes[number], further[number], likelihood) for slopes in slopes_at]
        after = _half_widths([a.T @ a + b.T @ b + prior for a, b in zip(own, more, strict=True)])
        rows.append(
            {
                "measurement": told,
                "parameter": free[widest].name,
                "before": before[widest],
                "after": after[widest],
                "widest after": after.max(),
            }
            | dict(zip(names, after, strict=True))
        )
    table = pd.DataFrame(rows).sort_values("after", ignore_index=True).head(MOST_TOLD)
    table.attrs["before"] = dict(zip(names, before, strict=True))
    return table


def _places(fit: Outcome) -> list[Array]:
    """Return the most likely point, and some others if not all is identifiable."""
    if all(each.identifiable for each in fit.found):
        return [fit.best.x]
    others = [point.x for point in fit.profiles.seen]
    chosen = np.linspace(0, len(others) - 1, min(len(others), MOST_POINTS - 1)).astype(int)
    return [fit.best.x, *(others[number] for number in np.unique(chosen))]


def _half_widths(information: list[Array]) -> Array:
    """Return half widths (f,) of 95 % by information (f, f), root mean squares over places."""
    variances = [np.diag(np.linalg.inv(each)) for each in information]
    return np.asarray(1.96 * np.sqrt(np.mean(variances, axis=0)))


def _of_free(slopes: Array, measurement: Measurement, likelihood: Likelihood) -> Array:
    """Return derivatives (n, f) of a measurement over its noise, less an offset of it."""
    if measurement.has_offset:
        slopes = slopes - slopes.mean(axis=0)
    return slopes[:, likelihood.free] / measurement.noise[:, None]


def _with_noise(fit: Outcome, measurements: list[Measurement]) -> list[Measurement]:
    """Return measurements with their noise, by what is predicted for them.

    Of profiles it is that of the data, or a part of the greatest range; of volumes a part of each.
    """
    predicted = fit.likelihood.predictor.measuring(tuple(measurements)).predict(fit.best.x)
    pairs = list(zip(measurements, predicted, strict=True))
    known = [each.noise.mean() for each in fit.measurements if each.quantity == "profile"]
    ranges = [np.ptp(values) for each, values in pairs if each.quantity == "profile"]
    noises = {"profile": known[0] if known else PROFILE_NOISE * max(ranges, default=0.0)}
    found = []
    for each, values in pairs:
        noise = each.noise * noises.get(each.quantity, 1.0)
        if each.quantity == "worn_volume":
            noise = np.maximum(noise * np.abs(values), 1e-300)
        found.append(replace(each, noise=noise))
    return found


def _candidates(fit: Outcome) -> Iterator[tuple[str, Measurement]]:
    """Yield further measurements, with what they are, within the times of the data."""
    names, scene = UnitNames.of(fit.scene.units), fit.scene
    times = np.concatenate([each.times for each in fit.measurements])
    first, last = float(times[times > 0].min()), float(times.max())
    depth_noise = _noise_of(fit, "indentation")
    responds = "normal_force" if scene.problem.indentation is not None else "indentation"
    noise = _noise_of(fit, responds) if responds == "normal_force" else depth_noise
    halves = [(first, last), (first, float(np.sqrt(first * last))), (np.sqrt(first * last), last)]
    what = responds.replace("_", " ")
    for begin, end in halves if last > 2 * first else []:
        between = f"{names.write(begin, 'time', 2)} and {names.write(end, 'time', 2)}"
        series = np.geomspace(begin, end, COUNT)
        yield f"{what} at {COUNT} more times between {between}", _made(responds, series, noise)
    series = np.geomspace(first, last, COUNT)
    yield (
        f"{what} again by a sensor ten times as good",
        _made(responds, series, noise / 10),
    )
    radii = np.linspace(scene.punch.inner_radius, scene.punch.radius, RADII + 2)[1:-1]
    rings = len(scene.problem.wear_coefficients)
    for time in np.geomspace(first, last, WHEN + 1)[1:]:
        when = f"t = {names.write(time, 'time', 2)}"
        profile = _made("profile", np.full(RADII, time), 1.0)
        yield f"a profile at {when}", replace(profile, radii=radii)
        alone = np.array([time])
        whole = _made("worn_volume", alone, VOLUME_NOISE)
        yield f"lost mass of the punch at {when}, to {VOLUME_NOISE:.0%}", whole
        for ring in range(rings if 1 < rings <= MOST_RINGS else 0):
            told = f"lost mass of ring {ring + 1} at {when}, to {VOLUME_NOISE:.0%}"
            yield told, replace(whole, ring=ring)


def _made(quantity: str, times: Array, noise: float) -> Measurement:
    ones = np.ones(len(times))
    return Measurement(quantity, quantity, times, ones, noise * ones, True)


def _noise_of(fit: Outcome, quantity: str) -> float:
    """Return the noise of a quantity in the data, or what is usual for it."""
    for each in fit.measurements:
        if each.quantity == quantity:
            return float(np.median(each.noise))
    units = fit.scene.problem.units
    return DEPTH_NOISE * (units.force if quantity == "normal_force" else units.displacement)
