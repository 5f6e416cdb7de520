"""Fit parameters of a scene to measurements: estimates, intervals, and what is not identifiable."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtri, stdtrit
from threadpoolctl import threadpool_limits

from ...meshes import Array, SceneError
from ..crosscheck import LOG, Scene, Source, listed, naming_arguments, shown
from ..estimate.estimator import (
    MAX_NUMERICAL_ERROR,
    Likelihood,
    Point,
    fix_ineffective_parameters,
    inverse_of_information,
    with_estimated_noise,
)
from ..estimate.histories import CELL
from ..estimate.measurement import Measurement
from ..estimate.model import Model
from ..estimate.parameter import Parameter
from ..estimate.profiles import BetterPointError, Profiles
from .data import SCARS, NoiseInput, read_measurements
from .parameters import find_parameters
from .residual_tests import residual_tests
from .result import Estimate, Fit

if TYPE_CHECKING:
    from ..check.tables import OthersResults

CONFIDENCE = 0.95
# tolerances of the model that are tried, until the next one changes the predictions by little
RTOLS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
# number of them for radii of contacts, which cells resolve to about a thousandth: more would take
# minutes, and the error is reported
RTOLS_OF_SCARS = 3
# standard deviation of a logarithm above which the interval does not follow from the curvature
MAX_QUADRATIC_DEVIATION = 0.05
# greatest number of computations of the profiles, which begin anew at each better point
MAX_RESTARTS = 4


@naming_arguments
def fit(
    scene: Source,
    data: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
    parameters: Sequence[str] | str,
    noise: NoiseInput = None,
    density: float | str | None = None,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    cycle: float | str | None = None,
) -> Fit:
    """Fit parameters of a scene to measurements, and report how well the data determine them.

    The likelihood for Gaussian noise is maximised. The 95 % intervals follow from the curvature of
    the likelihood if it is nearly quadratic, and otherwise from its profile. The tolerance of the
    model follows from the noise: the numerical error is at most a tenth of the noise.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries; its values are the
        initial ones, and parameters are fitted up to a factor of 1000 from them. Its times are
        replaced by those of the data
    data : files or tables, one, several, or by name. Columns are time, indentation, normal_force;
        time, radius, profile; contact_radius or scar_diameter; worn_volume or lost_mass, for ring N
        worn_volume_N or lost_mass_N, counted from the centre, from 1. Instead of time, the sliding
        distance or the number of cycles may be given
    parameters : keys of the scene, such as ``punch.wear_coefficients[1]``, counted from 0, where
        the key of a list means all of its values; or unknowns of the rig: ``start_time``,
        ``sensor_offset``, ``machine_compliance``
    noise : standard deviation of the data, or those of its columns by name: numbers in the units of
        the scene, or texts such as ``"0.2 um"`` or, relative to each value, ``"2 %"``; estimated
        from the residuals if none is given
    density : of the punch, for lost mass, such as ``"7.8 g/cm^3"``
    columns : our column names by those of the data, ``{"depth": "indentation"}``
    units : of the data, such as ``"mm, N, MPa, s"``, if not those of the scene
    cycle : sliding distance of one cycle, for cycles in place of times, such as ``"20 mm"``

    Returns
    -------
    fit : with `estimates` (value, stderr, low, high and identifiable by parameter),
        `correlations`, `conclusions`, `chi_square`, `tests`, `figures`, `save(folder)`, and
        `report()` in the form of lmfit

    Raises
    ------
    SceneError
        if scene, data or parameters cannot be read or do not suit each other, with the remedy

    Examples
    --------
    >>> import numpy as np, pandas as pd, ringwear
    >>> scene = ringwear.Scene.load("flat_punch")
    >>> times = np.geomspace(0.01, 5.0, 40)
    >>> depth = ringwear.run(scene.changed(wear__times=times.tolist()), methods=["mdr"]).dataset
    >>> shown = depth.indentation.values[0] + np.random.default_rng(1).normal(0, 1e-3, 40)
    >>> data = pd.DataFrame({"time": times, "indentation": shown})
    >>> found = ringwear.fit(scene, data, "punch.wear_coefficients", noise=1e-3)
    >>> bool(found.estimates.identifiable.all())
    True
    """
    scene = Scene.of(scene)
    names = listed(parameters)
    if wrong := [name for name in names if not isinstance(name, str)]:
        raise SceneError(
            f"parameters has {shown(wrong[0])}: give names, such as 'punch.wear_coefficients'"
        )
    measurements = read_measurements(scene, data, noise, density, columns, units, cycle, names)
    times = np.unique(np.concatenate([each.times for each in measurements]))
    if not (times > 0).any():
        raise SceneError("the data has no time after the start: give later times")
    scene = scene.changed(wear__times=times.tolist(), wear__march="modal", wear__step=None)
    scene, fitted = find_parameters(scene, names)
    # the matrices are so small that several threads would only wait for each other
    with threadpool_limits(1):
        return fit_measurements(scene, _with_scales(fitted, measurements), measurements)


def fit_measurements(
    scene: Scene,
    parameters: tuple[Parameter, ...],
    measurements: tuple[Measurement, ...],
    model: Callable[..., Model] = Model.of,
) -> Fit:
    """Fit parameters to measurements that have been read.

    The model is refined until a finer tolerance changes no prediction by more than a tenth of the
    noise.

    Parameters
    ----------
    scene : with the times of the data
    model : returns the model for a tolerance and for the coordinates at which it is to be most
        accurate
    """
    has_scars = any(each.quantity in SCARS for each in measurements)
    rtol, *finer_rtols = RTOLS[:RTOLS_OF_SCARS] if has_scars else RTOLS
    predictor = model(scene, parameters, measurements, rtol, np.zeros(len(parameters)))
    likelihood = Likelihood(predictor, parameters, tuple(range(len(parameters))))
    likelihood, combinations = fix_ineffective_parameters(likelihood)
    best = likelihood.best_from(np.zeros(len(parameters)))
    likelihood = with_estimated_noise(likelihood, best)
    error = np.zeros(len(likelihood.noise))
    for finer_rtol in finer_rtols:
        best = likelihood.best_from(best.x)
        finer = model(scene, parameters, likelihood.measurements, finer_rtol, best.x)
        finer_likelihood = replace(likelihood, predictor=finer)
        error = finer_likelihood.residuals(best.x) - likelihood.residuals(best.x)
        LOG.info("     fit  numerical error %.2g times the noise", np.abs(error).max())
        if np.abs(error).max() <= MAX_NUMERICAL_ERROR:
            break
        likelihood = finer_likelihood
    best, profiles, intervals = _intervals(likelihood, likelihood.best_from(best.x))
    if has_scars:
        error = np.maximum(np.abs(error), _widths_of_cells(likelihood, best.x) / likelihood.noise)
    slopes = likelihood.slopes(best.x)
    shifts = inverse_of_information(slopes) @ (slopes.T @ error)
    undetermined = {number for combination in combinations for number in combination}
    fitted = zip(np.sqrt(np.diag(profiles.covariance)), np.abs(shifts), strict=True)
    by_number = dict(zip(likelihood.free, fitted, strict=True))
    estimates = []
    for number, parameter in enumerate(parameters):
        ends = (-np.inf, np.inf) if number in undetermined else intervals[number]
        deviation, shift = by_number.get(number, (np.nan, 0.0))
        estimates.append(
            Estimate(
                parameter,
                float(best.x[number]),
                *ends,
                float(deviation),
                float(shift),
                number in profiles.traces,
            )
        )
    return Fit(
        scene=scene,
        likelihood=likelihood,
        best=best,
        found=tuple(estimates),
        profiles=profiles,
        combinations=tuple(combinations),
        tests=residual_tests(likelihood, best.x),
        rtol=likelihood.predictor.rtol,
        model_error=float(np.abs(error).max()),
    )


def _widths_of_cells(likelihood: Likelihood, x: Array) -> Array:
    """Return the widths (n,) of the cells at the edge of the contact; 0 for all but its radii.

    A tolerance does not bound the error of the edge, which is at most so large.
    """
    cells = tuple(replace(each, quantity=CELL) for each in likelihood.measurements)
    widths = likelihood.predictor.for_measurements(cells).predict(x)
    return np.concatenate(
        [
            width if each.quantity in SCARS else np.zeros(len(width))
            for each, width in zip(likelihood.measurements, widths, strict=True)
        ]
    )


def _with_scales(
    parameters: tuple[Parameter, ...], measurements: tuple[Measurement, ...]
) -> tuple[Parameter, ...]:
    """Return the parameters, with scales for those that are not logarithmic."""
    times = np.concatenate([each.times for each in measurements])
    depths = [np.ptp(each.values) for each in measurements if each.quantity == "indentation"]
    depth = max(depths, default=0.0) or 1.0
    # at REACH times the scale: the last time, and a hundred times the range of the sensor
    scales = {"start_time": times.max() / 1e3, "sensor_offset": 0.1 * depth}
    return tuple(
        replace(each, scale=float(scales.get(each.name, 0.1 * depth)))
        if not each.logarithmic
        else each
        for each in parameters
    )


def threshold(likelihood: Likelihood) -> float:
    """Return the rise of chi-square at the ends of the interval of one parameter.

    It is the square of the normal quantile, or of Student's quantile if any noise is estimated from
    the residuals.
    """
    level = (1 + CONFIDENCE) / 2
    if all(each.noise_known for each in likelihood.measurements):
        return float(ndtri(level) ** 2)
    return float(stdtrit(max(likelihood.degrees_of_freedom, 1), level) ** 2)


def _intervals(
    likelihood: Likelihood, best: Point
) -> tuple[Point, Profiles, dict[int, tuple[float, float]]]:
    """Return the best point, its profiles, and the intervals of the free parameters by index."""
    for _ in range(MAX_RESTARTS):
        covariance, rise = likelihood.covariance(best.x), threshold(likelihood)
        profiles = Profiles(likelihood, best, covariance, rise)
        deviations = dict(zip(likelihood.free, np.sqrt(np.diag(covariance)), strict=True))
        intervals = {
            number: (
                float(best.x[number] - deviation * np.sqrt(rise)),
                float(best.x[number] + deviation * np.sqrt(rise)),
            )
            for number, deviation in deviations.items()
        }
        not_quadratic = [
            number
            for number, deviation in deviations.items()
            if likelihood.parameters[number].logarithmic and deviation > MAX_QUADRATIC_DEVIATION
        ]
        try:
            intervals |= profiles.intervals(not_quadratic)
        except BetterPointError as error:
            best = likelihood.best_from(error.args[0].x)
            continue
        break
    return best, profiles, intervals
