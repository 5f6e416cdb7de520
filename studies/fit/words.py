"""Put the conclusions of a fit into sentences."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...meshes import Array, ring_areas
from ..tables.headings import KINDS
from .parameters import REACH, written
from .residual_tests import LEVEL, combined

if TYPE_CHECKING:
    from .result import Estimate, Fit

# least correlation of two parameters that is reported
MIN_CORRELATION = 0.9
# greatest standard deviation of the harmonic mean, relative, with which it is reported
MAX_DEVIATION_OF_MEAN = 0.25


def conclusions_of_fit(fit: "Fit") -> tuple[str, ...]:
    """Return sentences on the estimates, on what the data do not determine, and on the model."""
    parts = _estimates, _combinations, _correlation, _quality
    return tuple(line for part in parts for line in part(fit))


def _estimates(fit: "Fit") -> Iterator[str]:
    names = fit.scene.unit_names
    undetermined = {number for combination in fit.combinations for number in combination}
    for number, each in enumerate(fit.found):
        name, parameter = each.parameter.name, each.parameter
        low, high = (written(parameter, end, names) for end in each.ends)
        if (number,) in fit.combinations:
            yield (
                f"{name} is not identifiable: it has no effect on any of the measured quantities, "
                "so that every value of it fits the data equally well; leave it out of the "
                "parameters, or measure a quantity that depends on it"
            )
        elif number in undetermined:
            yield f"{name} is not identifiable: the data do not determine it alone"
        elif each.identifiable:
            value = written(parameter, each.value, names)
            error = written(parameter, each.standard_error, names)
            yield f"{name} = {value} (95 %: {low} to {high}) +/- {error}"
        else:
            yield f"{name} is not identifiable: {_bounds(each, low, high)}"


def _bounds(each: "Estimate", low: str, high: str) -> str:
    if not each.low <= each.best <= each.high:
        return (
            f"the best value is beyond a factor of {REACH:g} of the scene's: check the units of "
            "the data, or give other values in the scene to start from"
        )
    if np.isfinite([each.low, each.high]).all():
        return f"it lies between {low} and {high} (95 %), wider than a factor of two"
    if np.isfinite(each.low):
        return f"it is at least {low} (97.5 %), and the data give no upper bound"
    if np.isfinite(each.high):
        return f"it is at most {high} (97.5 %), and the data give no lower bound"
    return f"the data allow every value within a factor of {REACH:g} of the scene's"


def _combinations(fit: "Fit") -> Iterator[str]:
    for combination in fit.combinations:
        names = [fit.found[number].parameter.name for number in combination]
        if len(names) == 1:
            continue
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        advice = ""
        if {"sensor_offset", "machine_compliance"} <= set(names):
            advice = "; data under a force that varies would separate them"
        held = fit.found[combination[-1]]
        value = written(held.parameter, held.value, fit.scene.unit_names)
        yield (
            f"{listed} cannot be separated by these data: only a combination of them is known. "
            f"{names[-1]} is held at {value}{advice}"
        )


def _correlation(fit: "Fit") -> Iterator[str]:
    """Yield a sentence on the greatest correlation, and on the combination that is still known."""
    table = np.abs(np.triu(fit.correlations.to_numpy(), 1))
    if not table.size or table.max() < MIN_CORRELATION:
        return
    first, second = np.unravel_index(int(table.argmax()), table.shape)
    pair = [fit.correlations.index[number] for number in (first, second)]
    value = fit.correlations.iloc[int(first), int(second)]
    digits = f"{value:.2f}" if abs(value) < 0.995 else f"{value:.4f}"
    yield f"{pair[0]} and {pair[1]} are hard to separate (correlation {digits}){_harmonic(fit)}"


def _harmonic(fit: "Fit") -> str:
    """Return the uncertainty of the harmonic mean of wear coefficients, if it is known."""
    likelihood = fit.likelihood
    wear = [
        place
        for place, number in enumerate(likelihood.free)
        if likelihood.parameters[number].name.startswith("punch.wear_coefficients[")
    ]
    punch = fit.scene.punch
    if len(wear) < 2 or punch.table or fit.combinations:
        # if other parameters have no effect alone, the scale of wear coefficients is not known
        return ""
    covariance = fit.profiles.covariance[np.ix_(wear, wear)]
    weights = _steady_weights(fit, wear)
    deviation = float(np.sqrt(weights @ covariance @ weights))
    if deviation > MAX_DEVIATION_OF_MEAN:
        return ""
    return (
        "; their harmonic mean, which sets the steady wear rate, is known to "
        f"{196 * deviation:.2g} %"
    )


def _steady_weights(fit: "Fit", wear: list[int]) -> Array:
    """Return the weight of each wear coefficient in the harmonic mean, ``(A/k) / sum A/k``.

    Parameters
    ----------
    wear : indices of the wear coefficients among the free parameters
    """
    likelihood = fit.likelihood
    problem = fit.scene.problem
    areas, count = ring_areas(problem.ring_edges), len(fit.scene.punch.coefficients)
    by_value = np.bincount(np.arange(len(areas)) % count, areas, count)
    numbers = [likelihood.free[place] for place in wear]
    values = np.array([fit.found[number].value for number in numbers])
    indices = [int(likelihood.parameters[number].name.partition("[")[2][:-1]) for number in numbers]
    weights = by_value[indices] / values
    return weights / weights.sum()


def _quality(fit: "Fit") -> Iterator[str]:
    for column in dict.fromkeys(each.column for each in fit.measurements):
        first = next(each for each in fit.measurements if each.column == column)
        if not first.noise_known:
            # the noise of a mass is that of its volume
            kind = KINDS["worn_volume" if first.quantity == "worn_volume" else column]
            size = fit.scene.unit_names.write(float(np.median(first.noise)), kind, 2)
            yield f"the noise of {column}, estimated from the residuals, is {size}"
    yield (
        f"chi-square is {fit.chi_square:.3g} for {fit.degrees_of_freedom} degrees of freedom "
        f"(reduced: {fit.reduced_chi_square:.3g})"
    )
    probability = combined(fit.tests)
    if not fit.tests:
        yield (
            "whether Archard's law with constant wear coefficients holds cannot be tested: there "
            "are too few values, or they agree with the model to within its numerical error; "
            "measure more, or give the noise, such as --noise '0.2 um'"
        )
    elif probability >= LEVEL:
        yield (
            "the residuals do not contradict Archard's law with constant wear coefficients "
            f"(p = {probability:.2g} by {len(fit.tests)} tests)"
        )
    else:
        worst = min(fit.tests, key=fit.tests.__getitem__)
        yield (
            f"THE MODEL DOES NOT FIT: the test of the residuals '{worst}' has p = "
            f"{fit.tests[worst]:.1g} ({probability:.1g} for all {len(fit.tests)} tests). Wear "
            "coefficients may change in time or with pressure, or the noise is larger than given. "
            "The intervals are not valid"
        )
    bounded = [
        each
        for each in fit.found
        if each.low <= each.best <= each.high and np.isfinite([each.low, each.high]).all()
    ]
    shifts = [2 * each.numerical / (each.high - each.low) for each in bounded]
    yield (
        f"the model was solved to rtol = {fit.rtol:g}; its numerical error is at most "
        f"{fit.model_error:.1g} times the noise, and shifts no parameter by more than "
        f"{max(shifts, default=0.0):.1g} times the half width of its interval"
    )
