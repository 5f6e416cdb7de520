"""Select the mistakes, one or several, that explain the difference of two results.

A mistake is a parameter of the scene, or of the reading of a table, that is not as it should be.
Each candidate is a set of mistakes whose values are estimated. Candidates are ranked by Bayes'
information criterion (Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773), with errors whose size
is estimated from the residuals of the closest candidate.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ...meshes import Array, RingwearError, SolverError
from ..crosscheck import LOG
from .estimator import Likelihood, Point
from .model import Model
from .parameter import Parameter

# assumed relative error of a program before its results are seen: the random part, and the part
# that all values of a quantity have in common
NOISE, BIAS = 0.02, 0.02
# least random error that is assumed afterwards
MIN_NOISE = 0.002
# greatest number of values that count as independent
MAX_VALUES = 24
# odds that there is no mistake if there are fewer than so many values: these cannot show the errors
# of the program, and users then want to know what a mistake would be
NO_MISTAKE_ODDS, FEW_VALUES = 0.03, 4
# number of candidates that are estimated again, and of evaluations for each without interpolation
MAX_SOLVED, EVALUATIONS_SOLVED = 3, 5
# difference of the criterion up to which a candidate is still consistent with the data
NEAR = 6.0
# number of candidates to which every other mistake is added, and number of starts of a search
MAX_EXTENDED, MAX_STARTS = 4, 2
# relative change of chi-square, and number of evaluations, at which a search for the values of
# mistakes ends
TOLERANCE, EVALUATIONS = 1e-3, 20
# relative error that remains in most programs, and least change of the prediction that a mistake
# must cause
USUAL_ERROR, MIN_EFFECT = 0.03, 1e-3
# relative error up to which no further mistake is sought: coarse meshes have such errors, and
# a thin layer looks like them
MAX_UNEXPLAINED = 0.05
# errors of a changed scene that has no solution, or none that can be computed
NO_SOLUTION = (RingwearError, ArithmeticError, np.linalg.LinAlgError)


@dataclass(frozen=True, eq=False)
class Mistake:
    """A mistake that people often make.

    Parameters
    ----------
    name : in a few words
    sentence : what the difference looks like, with the values of the parameters: a template for
        `str.format`, or a function of the values
    remedy : what the user can do to confirm the mistake
    parameters : unknown numbers, which are fitted; or with values to choose from
    group : what it changes; two mistakes of one group are not combined
    special_of : name of a mistake of which it is a special case
    prior : how often it is made, over how often no mistake is made; our guess
    of_mesh : whether a right model has this error, too, if its mesh is too small or too coarse
    size : returns the number that is reported for the mistake, from the values of the parameters
    """

    name: str
    sentence: str | Callable[..., str]
    remedy: str
    parameters: tuple[Parameter, ...] = ()
    group: str = ""
    special_of: str = ""
    prior: float = 0.04
    of_mesh: bool = False
    size: Callable[..., float] = lambda *values: values[0]

    @property
    def fitted_numbers(self) -> int:
        """Number of parameters that are fitted."""
        return sum(not each.values for each in self.parameters)

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds of each choice of values."""
        choices = [min(len(each.values), 3) for each in self.parameters if each.values]
        return float(np.log(self.prior) - np.sum(np.log(choices or [1])))

    @property
    def starts(self) -> list[tuple[float, ...]]:
        """Values that are tried, or at which a search begins."""
        choices = (each.values or each.starts or (each.value,) for each in self.parameters)
        return list(product(*choices))


@dataclass(frozen=True, eq=False)
class Candidate:
    """Mistakes that are made together, with their values.

    Parameters
    ----------
    mistakes : empty for the candidate without a mistake
    likelihood : of the data, with their parameters
    point : best coordinates (m,)
    noise : (Q,) assumed relative error of each measurement
    """

    mistakes: tuple[Mistake, ...]
    likelihood: Likelihood
    point: Point
    noise: Array

    @cached_property
    def predicted(self) -> list[Array]:
        """The predicted values of each measurement."""
        return self.likelihood.predictor.predict(self.point.x)

    @cached_property
    def values(self) -> list[tuple[float, ...]]:
        """The values of the parameters of each mistake."""
        numbers = iter(self.point.x)
        return [
            tuple(each.at(float(next(numbers))) for each in mistake.parameters)
            for mistake in self.mistakes
        ]

    @cached_property
    def intervals(self) -> list[tuple[float, float]]:
        """95 % intervals of the fitted values, by the curvature, within the range of each."""
        free = self.likelihood.free
        deviations = np.zeros(0)
        if free:
            deviations = np.sqrt(np.diag(self.likelihood.covariance(self.point.x)))
        intervals = []
        for number, deviation in zip(free, deviations, strict=True):
            each = self.likelihood.parameters[number]
            low, high = self.point.x[number] + 1.96 * deviation * np.array([-1, 1])
            intervals.append((each.at(max(low, -each.reach)), each.at(min(high, each.reach))))
        return intervals

    @cached_property
    def errors(self) -> Array:
        """(Q,) root mean squares of the relative errors that remain, by measurement."""
        measured = [each.values for each in self.likelihood.measurements]
        return self._relative_sizes(measured, self.predicted)

    def changes(self, other: "Candidate") -> Array:
        """Return the relative changes (Q,) of the prediction from another candidate's."""
        return self._relative_sizes(self.predicted, other.predicted)

    def _relative_sizes(self, first: list[Array], second: list[Array]) -> Array:
        """Return the root mean squares (Q,) of differences, over the sizes of the data."""
        sizes = np.zeros(len(self.noise))
        for number, each in enumerate(self.likelihood.measurements):
            present = np.isfinite(each.noise)
            differences = (first[number] - second[number])[present] / each.noise[present]
            if present.any():
                sizes[number] = self.noise[number] * np.sqrt(np.mean(differences**2))
        return sizes

    def with_errors(self, noise: Array, bias: float) -> "Candidate":
        """Return the candidate with other assumed errors: (Q,) noises, and a bias."""
        scaled = tuple(
            replace(each, noise=each.noise * factor, bias=bias)
            for each, factor in zip(self.likelihood.measurements, noise / self.noise, strict=True)
        )
        model = self.likelihood.predictor.for_measurements(scaled)
        candidate = replace(self, likelihood=replace(self.likelihood, predictor=model), noise=noise)
        # neither depends on the assumed errors
        candidate.__dict__.update(predicted=self.predicted, errors=self.errors)
        return candidate

    @cached_property
    def chi_square(self) -> float:
        """Sum of the squared residuals over the assumed errors."""
        likelihood = self.likelihood
        measured = np.concatenate([each.values for each in likelihood.measurements])
        difference = measured - np.concatenate(self.predicted)
        difference = np.where(np.isfinite(likelihood.noise), difference, 0.0)
        return float(np.sum(likelihood.whitened(difference / likelihood.noise) ** 2))

    @cached_property
    def bic(self) -> float:
        """Bayes' information criterion; lower is better.

        It is ``n ln(1 + chi2 / n) + f ln n - 2 ln prior`` for n values, of which at most
        `MAX_VALUES` count as independent, and f fitted numbers. The logarithm is that of Student's
        distribution: the errors are of about the assumed size, but their size is not known.
        """
        misfit = self.values_counted * np.log1p(self.chi_square / self.values_present)
        return float(misfit + self._penalty(self.mistakes))

    def least_bic(self, further: Mistake) -> float:
        """Return the criterion of a perfect prediction with a further mistake."""
        return self._penalty((*self.mistakes, further))

    def _penalty(self, mistakes: Sequence[Mistake]) -> float:
        fitted = sum(each.fitted_numbers for each in mistakes)
        prior = sum(each.log_prior for each in mistakes)
        if not mistakes and self.values_present < FEW_VALUES:
            prior = np.log(NO_MISTAKE_ODDS)
        return float(fitted * np.log(self.values_counted) - 2 * prior)

    @property
    def values_present(self) -> int:
        """Number of values that the data has."""
        return max(1, int(np.isfinite(self.likelihood.noise).sum()))

    @property
    def values_counted(self) -> int:
        """Number of values that count as independent."""
        return min(self.values_present, MAX_VALUES)


@contextmanager
def left_out(what: str) -> Iterator[None]:
    """End the `with` block, with a word, where a changed scene cannot be solved."""
    try:
        yield
    except NO_SOLUTION as error:
        LOG.warning("not tried as a mistake: %s: %s", what, error)


def select(model: Model, mistakes: Sequence[Mistake], depth: int = 2) -> list[Candidate]:
    """Return candidates of up to `depth` mistakes, the one with the lowest criterion first.

    Parameters
    ----------
    model : without parameters; its measurements have the relative error `NOISE`
    mistakes : that are considered
    """
    noise = np.full(len(model.measurements), NOISE)
    none = Candidate((), Likelihood(model, (), ()), Point(np.empty(0), 0.0), noise)
    levels, by_mistakes = [[none]], {frozenset[Mistake](): none}
    for _ in range(depth):
        # nothing is added to a candidate that leaves no more than most programs do, and nothing at
        # all once the best candidate leaves no more
        first = min(by_mistakes.values(), key=lambda each: each.bic)
        if first.mistakes and first.errors.max() <= MAX_UNEXPLAINED:
            break
        worth = [each for each in levels[-1] if each is none or each.errors.max() > MAX_UNEXPLAINED]
        extended = sorted(worth, key=lambda each: each.bic)[:MAX_EXTENDED]
        level, tried = [], set[frozenset[Mistake]]()
        for candidate in extended:
            groups = {each.group for each in candidate.mistakes}
            for mistake in mistakes:
                key = frozenset({*candidate.mistakes, mistake})
                lowest = min(each.bic for each in by_mistakes.values())
                if mistake.group in groups or key in tried:
                    continue
                tried.add(key)
                # even a perfect prediction could not come near the best candidate
                if candidate.mistakes and candidate.least_bic(mistake) > lowest + NEAR:
                    continue
                found = None
                with left_out(" and ".join(each.name for each in (*candidate.mistakes, mistake))):
                    found = _with_mistake(candidate, mistake)
                if found is not None and all(
                    found.changes(other).max() > USUAL_ERROR
                    for each in candidate.mistakes
                    if (other := by_mistakes.get(key - {each}))
                ):
                    level.append(found)
                    by_mistakes[key] = found
        levels.append(level)
    candidates = sorted((each for level in levels for each in level), key=lambda each: each.bic)
    candidates = [*map(_refined, candidates[:MAX_SOLVED]), *candidates[MAX_SOLVED:]]
    # the closest prediction estimates the errors of the program
    closest = min(candidates, key=lambda each: float(np.sum(each.errors**2)))
    floor = MIN_NOISE * np.sqrt(MAX_VALUES / closest.values_counted)
    noise = np.maximum(closest.errors, floor)
    bias = min(BIAS, 2 * float(noise.max()))
    return sorted((each.with_errors(noise, bias) for each in candidates), key=lambda each: each.bic)


def _refined(candidate: Candidate) -> Candidate:
    """Return a candidate whose values are estimated again, more accurately."""
    likelihood = candidate.likelihood
    if not likelihood.free:
        return candidate
    evaluations = EVALUATIONS
    if likelihood.predictor.interpolates:
        evaluations = EVALUATIONS_SOLVED
        likelihood = replace(likelihood, predictor=likelihood.predictor.solved_directly())
    try:
        point = likelihood.best_from(candidate.point.x, evaluations=evaluations)
    except NO_SOLUTION:
        return candidate
    return replace(candidate, likelihood=likelihood, point=point)


def _with_mistake(candidate: Candidate, mistake: Mistake) -> Candidate | None:
    """Return the best candidate with one more mistake.

    It is None if the mistake has no effect, or an effect that the errors of most programs exceed
    beside another mistake; or if its values are at the ends of their range.

    Raises
    ------
    SolverError
        if it has no finite results
    """
    parameters = (*candidate.likelihood.parameters, *mistake.parameters)
    free = tuple(number for number, each in enumerate(parameters) if not each.values)
    if len(free) > candidate.values_present:
        return None
    model = candidate.likelihood.predictor.with_parameters(parameters)
    likelihood = Likelihood(model, parameters, free)
    points = []
    for values in mistake.starts:
        own = [each.coordinate(v) for each, v in zip(mistake.parameters, values, strict=True)]
        x = np.append(candidate.point.x, own)
        if np.isfinite(chi_square := float(np.sum(likelihood.residuals(x) ** 2))):
            points.append(Point(x, chi_square))
    if not points:
        raise SolverError("its results are not finite")
    points.sort(key=lambda point: point.chi_square)
    count = MAX_STARTS if not candidate.mistakes else 1
    if free:
        points = [
            likelihood.best_from(point.x, tolerance=TOLERANCE, evaluations=EVALUATIONS)
            for point in points[:count]
        ]
    best = min(points, key=lambda point: point.chi_square)
    reach = np.array([parameters[number].reach for number in free])
    if (np.abs(best.x[list(free)]) > reach).any():
        return None
    found = Candidate((*candidate.mistakes, mistake), likelihood, best, candidate.noise)
    least = USUAL_ERROR if candidate.mistakes else MIN_EFFECT
    return found if found.changes(candidate).max() > least else None


def shares(candidates: Sequence[Candidate]) -> Mapping[Mistake, float]:
    """Return the share of each mistake in all candidates, weighted by ``exp(-BIC / 2)``.

    The shares say how much better candidates with a mistake are than all others that are known.
    They are no probabilities that the mistake was made.
    """
    lowest = min(each.bic for each in candidates)
    weights = np.exp(-(np.array([each.bic for each in candidates]) - lowest) / 2)
    weights /= weights.sum()
    shares = dict[Mistake, float]()
    for candidate, weight in zip(candidates, weights.tolist(), strict=True):
        for mistake in candidate.mistakes:
            # the sum may exceed 1 by roundoff
            shares[mistake] = min(shares.get(mistake, 0.0) + weight, 1.0)
    return shares
