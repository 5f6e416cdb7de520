"""Find which mistakes, one or several, explain the error of a program, and how likely each is.

A hypothesis is a set of mistakes with their sizes; it predicts what the program prints. Its weight
follows from its prior odds, from how well it predicts, and from the number of its fitted numbers,
as in Bayesian model selection (Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773). The priors are
our choice and not calibrated, so the resulting probabilities are not frequencies.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ....meshes import Array, RingwearError
from .cause import Cause, Sizes
from .comparison import Comparison
from .model import Model
from .setting import Setting

# assumed relative error of a program's discretisation before its results are seen: the random part,
# and the part that is common to all values of a quantity
NOISE, BIAS = 0.02, 0.02
# least random error that is assumed afterwards, and greatest common error; the common error is also
# at most twice the random one
MIN_NOISE, MAX_BIAS = 0.002, 0.02
# odds that there is no mistake if there are fewer than so many values: these cannot show the errors
# of the program, and users then want to know what a mistake would be
NO_MISTAKE_ODDS, FEW_VALUES = 0.03, 4
# greatest numbers of values in all, and of times, that count as independent
MAX_VALUES, MAX_TIMES = 24, 12
# numbers of single mistakes, and of pairs, to which every other mistake is added
MAX_SINGLE, MAX_PAIRS = 5, 2
# number of candidates from which the sizes of a single mistake are optimised, and weight of the
# regularisation that keeps sizes at their initial values if the results do not depend on them
MAX_STARTS, REGULARISATION = 2, 1e-3
# relative error that remains in most programs and that no mistake has to explain
USUAL_ERROR = 0.03
# relative error that the program's own mesh may cause: if less remains, no further mistake is added
MESH_ERROR = 0.01
# relative change of a prediction above which a mistake counts as having an effect
MIN_EFFECT = 1e-3
# relative difference of two predictions below which they count as alike
MAX_ALIKE_DIFFERENCE = 0.02


@dataclass(frozen=True, eq=False)
class Mistake:
    """A cause together with its sizes."""

    cause: Cause
    sizes: Sizes


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Mistakes that are made together, and what the program prints then.

    S, K and Q are the numbers of times, compared numbers and quantities in a `Comparison`.

    Parameters
    ----------
    mistakes : empty for the hypothesis that there is no mistake
    predicted : (S, K) printed numbers, in the units of the scene
    differences : (S, K) relative differences of the observed numbers to the predicted ones
    errors : (Q,) root mean squares of the differences, by quantity
    """

    mistakes: tuple[Mistake, ...]
    predicted: Array
    differences: Array
    errors: Array

    @property
    def setting(self) -> Setting:
        """The setting of the other program."""
        return setting_with(self.mistakes)

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds against the hypothesis without a mistake."""
        return float(sum(np.log(each.cause.prior / each.cause.choices) for each in self.mistakes))

    @property
    def fitted_numbers(self) -> int:
        """Number of sizes that are fitted."""
        return sum(each.cause.fitted_numbers for each in self.mistakes)


def setting_with(mistakes: Iterable[Mistake]) -> Setting:
    """Return the setting that contains these mistakes."""
    setting = Setting()
    for mistake in mistakes:
        setting = mistake.cause.change(setting, mistake.sizes)
    return setting


@dataclass(frozen=True, eq=False)
class HypothesisSearch:
    """Find hypotheses that explain the results, and compute their probabilities.

    Parameters
    ----------
    model : predicts what the program prints
    causes : the mistakes that are considered
    doubt : factor on the prior odds of mistakes that are not of the mesh
    """

    model: Model
    causes: Sequence[Cause]
    doubt: float = 1.0

    @property
    def _comparison(self) -> Comparison:
        return self.model.comparison

    def hypothesis(self, mistakes: tuple[Mistake, ...]) -> Hypothesis:
        """Return the hypothesis of these mistakes, with its prediction and errors."""
        predicted = self.model.predict(setting_with(mistakes))
        membership = self._comparison.membership
        differences = self._comparison.relative_differences(predicted)
        counts = self._comparison.present.sum(axis=0) @ membership.T
        errors = np.sqrt((differences**2).sum(axis=0) @ membership.T / np.maximum(counts, 1))
        return Hypothesis(mistakes, predicted, differences, errors)

    def whitened(self, hypothesis: Hypothesis, noise: Array, bias: float) -> Array:
        """Return the differences, in units of the assumed errors, with the common part reduced.

        The error that all values of a quantity have in common then counts as one value.

        Parameters
        ----------
        noise : (Q,) assumed random error of each quantity
        bias : assumed error that is common to all values of a quantity
        """
        membership, differences = self._comparison.membership, hypothesis.differences
        scale = min(1.0, MAX_TIMES / len(differences))
        # change of the differences by a common relative error of 1
        predicted = np.where(self._comparison.present, hypothesis.predicted, 0.0)
        norms = self._comparison.norms(predicted) @ membership
        direction = np.divide(predicted, norms, out=np.zeros_like(predicted), where=norms > 0)
        square = np.maximum((direction**2).sum(axis=0) @ membership.T, 1e-300)
        common = (direction * differences).sum(axis=0) @ membership.T / square
        removed_part = 1 - noise / np.sqrt(noise**2 + bias**2 * square * scale)
        remainder = differences - direction * ((removed_part * common) @ membership)
        scaled = np.sqrt(scale) * (remainder / (noise @ membership))[self._comparison.present]
        return np.asarray(scaled)

    def fit(self, mistakes: tuple[Mistake, ...]) -> Hypothesis | None:
        """Return the hypothesis with the best sizes; None if a size is out of range.

        The search begins at the sizes of the mistakes.
        """
        # imported here because only a diagnosis needs it
        from scipy.optimize import least_squares

        start = [np.array(each.sizes) for each in mistakes if each.cause.searched]
        if not start:
            return self.hypothesis(mistakes)
        first = np.concatenate(start)
        noise = np.full(len(self._comparison.quantities), NOISE)

        def with_sizes(logs: Array) -> tuple[Mistake, ...]:
            sizes = iter((np.sign(first) * np.exp(np.clip(logs, -50, 50))).tolist())
            return tuple(
                Mistake(each.cause, tuple(next(sizes) for _ in each.sizes))
                if each.cause.searched
                else each
                for each in mistakes
            )

        initial_logs = np.log(np.abs(first))

        def residuals(logs: Array) -> Array:
            # the last rows keep sizes that have no effect at their initial values
            return np.append(
                self.whitened(self.hypothesis(with_sizes(logs)), noise, BIAS),
                REGULARISATION * (logs - initial_logs),
            )

        solution = least_squares(
            residuals, initial_logs, method="lm", diff_step=1e-6, xtol=1e-4, ftol=1e-3
        )
        mistakes = with_sizes(solution.x)
        if not all(each.cause.is_possible(self.model, each.sizes) for each in mistakes):
            return None
        return self.hypothesis(mistakes)

    def score(self, hypothesis: Hypothesis, noise: Array, bias: float) -> float:
        """Return the logarithm of the weight of a hypothesis, at assumed errors (see `whitened`).

        With n values, their differences over the assumed errors g, and f fitted numbers, it is
        ``ln prior - n / 2 ln(1 + mean(g^2)) - f / 2 ln n``.
        """
        differences = self.whitened(hypothesis, noise, bias)
        count = min(len(differences), MAX_VALUES)
        likelihood = -count / 2 * np.log1p(np.mean(differences**2))
        prior = hypothesis.log_prior
        doubted = [each for each in hypothesis.mistakes if not each.cause.is_of_mesh]
        prior += len(doubted) * np.log(self.doubt)
        if not hypothesis.mistakes and len(differences) < FEW_VALUES:
            prior = np.log(NO_MISTAKE_ODDS)
        return float(prior + likelihood - hypothesis.fitted_numbers / 2 * np.log(count))

    def rough_score(self, hypothesis: Hypothesis) -> float:
        """Return the score before the errors of the program have been estimated."""
        return self.score(hypothesis, np.full(len(self._comparison.quantities), NOISE), BIAS)

    def best_with(self, cause: Cause, others: tuple[Mistake, ...]) -> Hypothesis | None:
        """Return the best hypothesis that adds a cause to other mistakes.

        It is None if no size of the cause is possible and has an effect, or if the scene with the
        mistake cannot be solved.
        """
        try:
            return self._best_with(cause, others)
        except RingwearError:
            return None

    def _best_with(self, cause: Cause, others: tuple[Mistake, ...]) -> Hypothesis | None:
        trials = [
            self.hypothesis((*others, Mistake(cause, sizes)))
            for sizes in cause.candidates(self.model)
        ]
        trials.sort(key=lambda trial: -self.rough_score(trial))
        without = self.hypothesis(others)
        starts = MAX_STARTS if cause.searched and not others else 1
        fits = [self.fit(trial.mistakes) for trial in trials[:starts]]
        effective = [
            fit for fit in fits if fit is not None and _difference(fit, without) > MIN_EFFECT
        ]
        return max(effective, key=self.rough_score, default=None)

    def ranked_hypotheses(self) -> list[tuple[Hypothesis, float]]:
        """Return all hypotheses with their probabilities, which sum to 1, the likeliest first."""
        values = int(self._comparison.present.sum())
        causes = [
            cause
            for cause in self.causes
            # fewer values than fitted numbers cannot support a cause
            if cause.fitted_numbers <= values and cause.applies(self.model)
        ]
        # single mistakes, then pairs, then triples
        levels = [[best for cause in causes if (best := self.best_with(cause, ()))]]
        tried_sets = set[frozenset[Cause]]()
        for count in (MAX_SINGLE, MAX_PAIRS):
            incomplete = [each for each in levels[-1] if each.errors.max() > MESH_ERROR]
            likeliest = sorted(incomplete, key=lambda each: -self.rough_score(each))[:count]
            combinations = list[Hypothesis]()
            for hypothesis in likeliest:
                present_causes = {mistake.cause for mistake in hypothesis.mistakes}
                groups = {cause.group for cause in present_causes}
                for cause in causes:
                    key = frozenset({*present_causes, cause})
                    if cause.group in groups or key in tried_sets:
                        continue
                    tried_sets.add(key)
                    if combination := self.best_with(cause, hypothesis.mistakes):
                        combinations.append(combination)
            levels.append(combinations)
        hypotheses = [self.hypothesis(()), *(each for level in levels for each in level)]
        closest = min(hypotheses, key=lambda each: float(np.sum(each.errors**2)))
        # the closest prediction estimates the random errors of the program
        min_noise = MIN_NOISE * np.sqrt(MAX_VALUES / min(values, MAX_VALUES))
        noise = np.maximum(closest.errors, min_noise)
        bias = min(MAX_BIAS, 2 * float(noise.max()))
        scores = np.array([self.score(each, noise, bias) for each in hypotheses])
        probabilities = np.exp(scores - scores.max())
        probabilities /= probabilities.sum()
        order = np.argsort(-probabilities)
        return [(hypotheses[index], float(probabilities[index])) for index in order]


def _difference(hypothesis: Hypothesis, other: Hypothesis) -> float:
    """Return the root mean square of the relative difference of two predictions."""
    norm = np.linalg.norm(hypothesis.differences - other.differences)
    return float(norm / np.sqrt(max(1, int(np.count_nonzero(hypothesis.differences)))))


def alike(hypothesis: Hypothesis, other: Hypothesis) -> bool:
    """Return whether two hypotheses predict nearly the same numbers."""
    return _difference(hypothesis, other) < MAX_ALIKE_DIFFERENCE


def explained_error_part(hypothesis: Hypothesis, none: Hypothesis, membership: Array) -> float:
    """Return the square of the part of the error, 0 to 1, that a hypothesis explains.

    Only quantities that its mistakes change are counted.

    Parameters
    ----------
    none : the hypothesis without a mistake
    membership : (Q, K) as in `Comparison`
    """
    change = np.abs(hypothesis.predicted - none.predicted).sum(axis=0) @ membership.T
    affected = change > MIN_EFFECT * (np.abs(none.predicted).sum(axis=0) @ membership.T)
    if not affected.any() or not none.errors[affected].any():
        return 0.0
    square_without, square_with = (
        float(np.mean(each.errors[affected] ** 2)) for each in (none, hypothesis)
    )
    unexplained = np.sqrt(max(square_with - USUAL_ERROR**2, 0.0) / square_without)
    # squared, because a mistake that leaves a sixth of the error is often not the one that was made
    return float(max(0.0, 1 - unexplained) ** 2)
