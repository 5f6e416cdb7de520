"""Test by the residuals of a fit whether Archard's law with constant wear coefficients holds.

Each test returns the probability of residuals at least as extreme as the observed ones if the law
holds. The smallest of several probabilities is multiplied by their number (Bonferroni), so that at
most about one correct fit in twenty is rejected.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.special import chdtrc, ndtr, stdtr

from ...meshes import Array
from ..estimate.estimator import MAX_NUMERICAL_ERROR, Likelihood

# combined probability below which the law is rejected
LEVEL = 0.05
# least number of values in a series whose differences are tested, and of times for a drift
MIN_VALUES = 5
# least degrees of freedom that remain after a drift is fitted, if the noise is not known
MIN_FREEDOM = 2
# relative change of the times in the differences that estimate time derivatives
TIME_CHANGE = 1e-4


def residual_tests(likelihood: Likelihood, x: Array) -> dict[str, float]:
    """Return the probabilities of the residuals at a point (m,), by the names of the tests.

    Chi-square is tested only if all noises were given. Von Neumann's ratio of successive
    differences detects that neighbouring residuals are alike; series that agree with the model to
    within its numerical error are not tested for that. A score test detects a wear coefficient
    whose logarithm drifts as ``t`` or as ``ln t``. The result is empty if there are too few values
    for any test.
    """
    residuals, probabilities = likelihood.residuals(x), dict[str, float]()
    freedom = likelihood.degrees_of_freedom
    if freedom > 0 and all(each.noise_known for each in likelihood.measurements):
        probabilities["chi-square"] = float(chdtrc(freedom, residuals @ residuals))
    for each, series in zip(likelihood.measurements, likelihood.split(residuals), strict=True):
        # patterns of the numerical error of the model say nothing about the law of wear
        within_numerical_error = series @ series <= MAX_NUMERICAL_ERROR**2 * len(series)
        if len(series) < MIN_VALUES or within_numerical_error:
            continue
        suffix = "" if len(likelihood.measurements) == 1 else f" of {each.label}"
        while f"successive differences{suffix}" in probabilities:
            suffix += " (again)"
        probabilities[f"successive differences{suffix}"] = small_differences(series)
    for name, score in _drift_scores(likelihood, x, residuals):
        probabilities[name] = _probability_of_score(likelihood, residuals, score)
    return probabilities


def combined(tests: dict[str, float]) -> float:
    """Return the smallest probability of several tests times their number; 1 without any test."""
    return min((1.0, *(len(tests) * probability for probability in tests.values())))


def small_differences(series: Array) -> float:
    """Return the probability of successive differences at most so large (von Neumann).

    For fewer than ten values, the normal approximation gives probabilities that are too large.
    """
    ratio = np.sum(np.diff(series) ** 2) / max(float(series @ series), 1e-300)
    count = len(series)
    # the mean of the residuals is known to be zero
    return float(ndtr((ratio - 2 * (count - 1) / count) / np.sqrt(4 / count)))


def _probability_of_score(likelihood: Likelihood, residuals: Array, score: float) -> float:
    """Return the probability of a score at least so far from zero.

    The score is standard normal if all noises were given. Otherwise its scale is that of the
    residuals without the drift, and it has Student's distribution.
    """
    if all(each.noise_known for each in likelihood.measurements):
        return float(2 * ndtr(-abs(score)))
    freedom = likelihood.degrees_of_freedom - 1
    variance = max(float(residuals @ residuals) - score**2, 0.0) / freedom
    # no drift is seen that is smaller than the numerical error of the model
    scale = max(np.sqrt(variance), MAX_NUMERICAL_ERROR)
    return float(2 * stdtr(freedom, -abs(score) / scale))


def _drift_scores(
    likelihood: Likelihood, x: Array, residuals: Array
) -> Iterator[tuple[str, float]]:
    """Yield the scores of drifting wear coefficients; in units of the noise if none drifts."""
    measurements = likelihood.measurements
    times = np.concatenate([each.times for each in measurements])
    if len(np.unique(times)) < MIN_VALUES or likelihood.degrees_of_freedom <= MIN_FREEDOM:
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
        direction = likelihood.whitened(rates * stretch / likelihood.noise)
        length = np.linalg.norm(direction)
        direction = direction - parameter_basis @ (parameter_basis.T @ direction)
        remaining_length = np.linalg.norm(direction)
        # a drift that the parameters themselves can explain cannot be tested
        if remaining_length > 1e-6 * length:
            yield name, float(direction @ residuals / remaining_length)
