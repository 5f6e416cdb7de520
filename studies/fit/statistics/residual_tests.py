"""Does Archard's law with these wear coefficients hold? Tests of what a fit leaves.

Each test gives the probability of residuals like these, or worse, if it does. With several tests
the least of them is told times their number (Bonferroni), so that one of twenty right fits is
called wrong.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.stats import chi2, norm

from ....meshes.radial import Array
from .likelihood import Likelihood

# probability below which a law is called wrong
LEVEL = 0.05
# values that a series must have to be tested for runs
FEWEST = 10
# part of times by which they are moved for derivatives
MOVED = 1e-4


def residual_tests(likelihood: Likelihood, x: Array) -> dict[str, float]:
    """Return the probabilities of residuals at a point, by the names of the tests.

    Chi-square needs noises that are given. Runs of one sign, and von Neumann's ratio of successive
    differences, see that neighbours are alike. The score of a drift asks whether a wear coefficient
    that changes in time, by its logarithm as ``t`` or as ``ln t``, explains what is left.
    """
    residuals, found = likelihood.residuals(x), dict[str, float]()
    if all(each.noise_known for each in likelihood.measurements):
        freedom = max(likelihood.degrees_of_freedom, 1)
        found["chi-square"] = float(chi2.sf(residuals @ residuals, freedom))
    row = 0
    for each in likelihood.measurements:
        series = residuals[row : row + len(each.values)]
        row += len(series)
        if len(series) < FEWEST:
            continue
        where = "" if len(likelihood.measurements) == 1 else f" of {each.label}"
        while f"runs{where}" in found:
            where += " (again)"
        found[f"runs{where}"] = few_runs(series)
        found[f"successive differences{where}"] = small_differences(series)
    for name, score in _drift_scores(likelihood, x, residuals):
        found[name] = float(2 * norm.sf(abs(score)))
    return found


def combined(tests: dict[str, float]) -> float:
    """Return the probability of the least of several tests, by Bonferroni; 1 without any."""
    return min(1.0, len(tests) * min(tests.values(), default=1.0))


def few_runs(series: Array) -> float:
    """Return the probability of so few runs of one sign (Wald and Wolfowitz)."""
    above = series > 0
    up, down = int(above.sum()), int((~above).sum())
    if not up or not down:
        return float(0.5 ** (len(series) - 1))
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    mean = 1 + 2 * up * down / len(series)
    variance = max((mean - 1) * (mean - 2) / (len(series) - 1), 1e-9)
    return float(norm.cdf((runs + 0.5 - mean) / np.sqrt(variance)))


def small_differences(series: Array) -> float:
    """Return the probability of such small successive differences (von Neumann)."""
    ratio = np.sum(np.diff(series) ** 2) / max(float(series @ series), 1e-300)
    count = len(series)
    # the mean is known to be zero
    return float(norm.cdf((ratio - 2 * (count - 1) / count) / np.sqrt(4 / count)))


def _drift_scores(
    likelihood: Likelihood, x: Array, residuals: Array
) -> Iterator[tuple[str, float]]:
    """Yield the scores of wear coefficients that drift: normal, of deviation one, if none does."""
    measurements = likelihood.measurements
    times = np.concatenate([each.times for each in measurements])
    if len(np.unique(times)) < FEWEST:
        return
    later, earlier = (
        likelihood.predictor.measuring(
            tuple(replace(each, times=each.times * factor) for each in measurements)
        ).predict(x)
        for factor in (1 + MOVED, 1 - MOVED)
    )
    # t d/dt of all that is measured: a wear coefficient that changes stretches the time
    rates = (np.concatenate(later) - np.concatenate(earlier)) / (2 * MOVED)
    positive = np.where(times > 0, times, 1.0)
    stretches = {"drift in t": times / times.max(), "drift in ln t": np.log(positive)}
    taken = np.linalg.qr(likelihood.slopes(x))[0]
    for name, stretch in stretches.items():
        direction = likelihood.without_offsets(rates * stretch / likelihood.noise)
        length = np.linalg.norm(direction)
        direction = direction - taken @ (taken.T @ direction)
        left = np.linalg.norm(direction)
        # what the parameters can explain themselves cannot be tested
        if left > 1e-6 * length:
            yield name, float(direction @ residuals / left)
