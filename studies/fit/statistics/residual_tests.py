"""Test by the residuals of a fit whether Archard's law with constant wear coefficients holds.

Each test returns the probability of residuals at least as extreme as the observed ones if the law
holds. The smallest of several probabilities is multiplied by their number (Bonferroni), so that at
most about one correct fit in twenty is rejected.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.stats import chi2, norm

from ....meshes.radial import Array
from .likelihood import Likelihood

# combined probability below which the law is rejected
LEVEL = 0.05
# least number of values in a series that is tested for runs, and of times for a drift
MIN_VALUES = 10
# relative change of the times in the differences that estimate time derivatives
TIME_CHANGE = 1e-4


def residual_tests(likelihood: Likelihood, x: Array) -> dict[str, float]:
    """Return the probabilities of the residuals at a point (m,), by the names of the tests.

    Chi-square is tested only if all noises were given. The number of runs of one sign and von
    Neumann's ratio of successive differences detect that neighbouring residuals are alike. A score
    test detects a wear coefficient whose logarithm drifts as ``t`` or as ``ln t``.
    """
    residuals, probabilities = likelihood.residuals(x), dict[str, float]()
    if all(each.noise_known for each in likelihood.measurements):
        freedom = max(likelihood.degrees_of_freedom, 1)
        probabilities["chi-square"] = float(chi2.sf(residuals @ residuals, freedom))
    row = 0
    for each in likelihood.measurements:
        series = residuals[row : row + len(each.values)]
        row += len(series)
        if len(series) < MIN_VALUES:
            continue
        suffix = "" if len(likelihood.measurements) == 1 else f" of {each.label}"
        while f"runs{suffix}" in probabilities:
            suffix += " (again)"
        probabilities[f"runs{suffix}"] = few_runs(series)
        probabilities[f"successive differences{suffix}"] = small_differences(series)
    for name, score in _drift_scores(likelihood, x, residuals):
        probabilities[name] = float(2 * norm.sf(abs(score)))
    return probabilities


def combined(tests: dict[str, float]) -> float:
    """Return the smallest probability of several tests times their number; 1 without any test."""
    return min(1.0, len(tests) * min(tests.values(), default=1.0))


def few_runs(series: Array) -> float:
    """Return the probability of at most so many runs of one sign (Wald and Wolfowitz)."""
    above = series > 0
    positive, negative = int(above.sum()), int((~above).sum())
    if not positive or not negative:
        return float(0.5 ** (len(series) - 1))
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    mean = 1 + 2 * positive * negative / len(series)
    variance = max((mean - 1) * (mean - 2) / (len(series) - 1), 1e-9)
    return float(norm.cdf((runs + 0.5 - mean) / np.sqrt(variance)))


def small_differences(series: Array) -> float:
    """Return the probability of successive differences at most so large (von Neumann)."""
    ratio = np.sum(np.diff(series) ** 2) / max(float(series @ series), 1e-300)
    count = len(series)
    # the mean of the residuals is known to be zero
    return float(norm.cdf((ratio - 2 * (count - 1) / count) / np.sqrt(4 / count)))


def _drift_scores(
    likelihood: Likelihood, x: Array, residuals: Array
) -> Iterator[tuple[str, float]]:
    """Yield the scores of drifting wear coefficients, standard normal if none drifts."""
    measurements = likelihood.measurements
    times = np.concatenate([each.times for each in measurements])
    if len(np.unique(times)) < MIN_VALUES:
        return
    later, earlier = (
        likelihood.predictor.for_measurements(
            tuple(replace(each, times=each.times * factor) for each in measurements)
        ).predict(x)
        for factor in (1 + TIME_CHANGE, 1 - TIME_CHANGE)
    )
    # t d/dt of the predictions: a wear coefficient that changes stretches the time
    rates = (np.concatenate(later) - np.concatenate(earlier)) / (2 * TIME_CHANGE)
    positive = np.where(times > 0, times, 1.0)
    stretches = {"drift in t": times / times.max(), "drift in ln t": np.log(positive)}
    parameter_basis = np.linalg.qr(likelihood.slopes(x))[0]
    for name, stretch in stretches.items():
        direction = likelihood.without_offsets(rates * stretch / likelihood.noise)
        length = np.linalg.norm(direction)
        direction = direction - parameter_basis @ (parameter_basis.T @ direction)
        remaining_length = np.linalg.norm(direction)
        # a drift that the parameters themselves can explain cannot be tested
        if remaining_length > 1e-6 * length:
            yield name, float(direction @ residuals / remaining_length)
