"""What a fit says, in sentences."""

from collections.abc import Iterator

import numpy as np

from ...meshes.radial import Array, ring_areas
from ..problem.unit_names import UnitNames
from ..wear.time_scale import running_in
from .outcome import Estimate, Outcome
from .parameters import REACH
from .statistics.likelihood import inverse_of
from .statistics.residual_tests import LEVEL, combined

# correlation from which on two parameters are named
CORRELATED = 0.9
# deviation of the logarithm of a ratio from which on data cannot separate two parameters
INSEPARABLE = 0.5 * np.log(2.0)
# cosine from which on the best known combination is called the harmonic mean
ALIKE = 0.98


def conclude(fit: Outcome) -> tuple[str, ...]:
    """Return what data say of each parameter, what they cannot tell, and whether the model fits."""
    names = UnitNames.of(fit.scene.units)
    parts = (_values(fit, names), _combinations(fit), _correlated(fit, names), _quality(fit, names))
    return tuple(line for part in parts for line in part)


def _values(fit: Outcome, names: UnitNames) -> Iterator[str]:
    held = {number for combination in fit.combinations for number in combination}
    for number, each in enumerate(fit.found):
        name, parameter = each.parameter.name, each.parameter
        low, high = (parameter.written(end, names) for end in each.ends)
        if number in held:
            yield f"{name} is not identifiable: no value of it changes what was measured alone"
        elif each.identifiable:
            value = parameter.written(each.value, names)
            yield f"{name} = {value} (95 %: {low} to {high}){_relative(each)}"
        else:
            yield f"{name} is not identifiable: {_bounds(each, low, high)}"


def _relative(each: Estimate) -> str:
    """Return half the width of an interval of what is positive, in per cent."""
    if not each.parameter.logarithmic:
        return ""
    return f", known to {50 * (np.exp(each.high - each.best) - np.exp(each.low - each.best)):.2g} %"


def _bounds(each: Estimate, low: str, high: str) -> str:
    if np.isfinite([each.low, each.high]).all():
        return f"it lies between {low} and {high} (95 %), wider than a factor of two"
    if np.isfinite(each.low):
        return f"it is at least {low} (97.5 %), and the data sets no upper end to it"
    if np.isfinite(each.high):
        return f"it is at most {high} (97.5 %), and the data sets no lower end to it"
    return f"the data allows every value within a factor of {REACH:g}"


def _combinations(fit: Outcome) -> Iterator[str]:
    for combination in fit.combinations:
        named = [fit.found[number].parameter.name for number in combination]
        if len(named) == 1:
            yield f"nothing that was measured depends on {named[0]}"
            continue
        together = f"{', '.join(named[:-1])} and {named[-1]}"
        advice = ""
        if {"sensor_offset", "machine_compliance"} <= set(named):
            advice = "; a force that varies would separate them"
        yield (
            f"{together} cannot be separated by these data: only a combination of them is known, "
            f"here with {named[-1]} held where the scene has it{advice}"
        )


def _correlated(fit: Outcome, names: UnitNames) -> Iterator[str]:
    """Yield the correlation that matters most, what is known all the same, and from when on."""
    table = np.abs(np.triu(fit.correlations.to_numpy(), 1))
    if not table.size or table.max() < CORRELATED:
        return
    first, second = np.unravel_index(int(table.argmax()), table.shape)
    pair = [fit.correlations.index[number] for number in (first, second)]
    value = fit.correlations.iloc[int(first), int(second)]
    digits = f"{value:.2f}" if abs(value) < 0.995 else f"{value:.4f}"
    line = f"{pair[0]} and {pair[1]} are hard to separate (correlation {digits})"
    if since := _inseparable_since(fit, int(first), int(second), names):
        line += f": {since}"
    yield line + _harmonic(fit)


def _inseparable_since(fit: Outcome, first: int, second: int, names: UnitNames) -> str:
    """Return from when on data alone would not tell two parameters apart; empty if they would."""
    likelihood = fit.likelihood
    slopes = likelihood.slopes(fit.best.x)
    times = np.concatenate([each.times for each in fit.measurements])
    for time in np.unique(times)[1:]:
        later = slopes[times >= time]
        if np.linalg.matrix_rank(later) < later.shape[1]:
            return ""
        deviations = np.sqrt(np.diag(inverse_of(later)))
        if deviations[[first, second]].max() > INSEPARABLE:
            (slowest,) = running_in(fit.scene.problem, [1.0])
            parts = time / fit.scene.problem.units.time / slowest
            counted = f" ({parts:.2g} relaxation times)" if np.isfinite(parts) else ""
            return f"data from t = {names.write(time, 'time', 2)}{counted} on would not do so"
    return ""


def _harmonic(fit: Outcome) -> str:
    """Return how well the harmonic mean of wear coefficients is known, if that is known best."""
    likelihood = fit.likelihood
    wear = [
        place
        for place, number in enumerate(likelihood.free)
        if likelihood.parameters[number].name.startswith("punch.wear_coefficients[")
    ]
    punch = fit.scene.punch
    if len(wear) < 2 or punch.table:
        return ""
    covariance = fit.covariance[np.ix_(wear, wear)]
    best_known = np.linalg.eigh(covariance)[1][:, 0]
    weights = _steady_weights(fit, wear)
    if abs(best_known @ weights) < ALIKE * np.linalg.norm(weights):
        return ""
    known = float(np.sqrt(weights @ covariance @ weights) / weights.sum())
    return (
        f"; their harmonic mean, which sets the steady wear rate, is known to {196 * known:.2g} %"
    )


def _steady_weights(fit: Outcome, wear: list[int]) -> Array:
    """Return the share of each wear coefficient in the harmonic mean, ``(A/k) / sum A/k``."""
    likelihood = fit.likelihood
    problem = fit.scene.problem
    areas, count = ring_areas(problem.ring_edges), len(fit.scene.punch.coefficients)
    by_value = np.bincount(np.arange(len(areas)) % count, areas, count)
    numbers = [likelihood.free[place] for place in wear]
    values = np.array([fit.found[number].value for number in numbers])
    listed = [int(likelihood.parameters[number].name.partition("[")[2][:-1]) for number in numbers]
    shares = by_value[listed] / values
    return np.asarray(shares / shares.sum())


def _quality(fit: Outcome, names: UnitNames) -> Iterator[str]:
    for column in dict.fromkeys(each.column for each in fit.measurements):
        first = next(each for each in fit.measurements if each.column == column)
        if not first.noise_known:
            kind = "volume" if first.quantity == "worn_volume" else None
            kind = kind or ("force" if first.quantity == "normal_force" else "displacement")
            size = names.write(float(np.median(first.noise)), kind, 2)
            yield f"the noise of {column}, taken from the residuals, is {size}"
    yield f"chi-square is {fit.chi_square:.3g} of {fit.degrees_of_freedom} degrees of freedom"
    probability = combined(fit.tests)
    if probability >= LEVEL:
        yield (
            "the residuals do not speak against Archard's law with constant wear coefficients "
            f"(p = {probability:.2g} by {len(fit.tests)} tests)"
        )
    elif fit.tests:
        worst = min(fit.tests, key=fit.tests.__getitem__)
        yield (
            f"THE MODEL DOES NOT FIT: {worst} of the residuals has p = {fit.tests[worst]:.1g} "
            f"({probability:.1g} for {len(fit.tests)} tests); wear coefficients may change in time "
            "or with pressure, or the noise is larger than given: the intervals are void"
        )
    sought = [each for each in fit.found if np.isfinite([each.low, each.high]).all()]
    parts = [2 * each.numerical / (each.high - each.low) for each in sought]
    yield (
        f"the model was solved to rtol = {fit.rtol:g}, its error is at most {fit.model_error:.1g} "
        f"of the noise, and moves no parameter by more than {max(parts, default=0.0):.1g} of half "
        "its interval"
    )
    if len(fit.design):
        row = fit.design.iloc[0]
        yield (
            f"the next measurement that narrows the widest interval, of {row['parameter']}, most: "
            f"{row['measurement']}; its half width falls from {row['before']:.2g} to "
            f"{row['after']:.2g} of the logarithm"
        )
