"""Which mistakes, one or several, explain the error of a program, and how likely each is.

Every hypothesis is a set of mistakes of some sizes, which predicts what is printed. It is weighed
by its odds beforehand, by how well it predicts, and by how many numbers were fitted for it, as in a
Bayesian choice of models (Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773). The odds are chosen
by us, not measured: shares are no frequencies.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ....meshes.radial import Array
from .cause import Cause, Sizes
from .comparison import Comparison
from .model import Model
from .setting import Setting

# relative error of a program's discretisation, before anything is known of it: by chance, and
# common to all values of a quantity
NOISE, BIAS = 0.02, 0.02
# errors by chance are not taken for less than this, nor is the common one for more than twice them
LEAST_NOISE, MOST_BIAS = 0.002, 0.02
# odds that there is no mistake, where values are too few to show the errors of the program: who
# asks wants to know what a mistake would be
NONE_OF_FEW, FEW = 0.03, 4
# values of a program that count as independent of each other, all together, and times
MOST_VALUES, MOST_TIMES = 24, 12
# single mistakes that are combined with every other, and pairs
MOST_SINGLE, MOST_PAIRS = 5, 2
# candidates from which a search for one mistake begins, and weight by which it holds sizes that
# nothing depends on
MOST_STARTS, HELD = 2, 1e-3
# error that a program has in any case, and no mistake has to explain
USUAL = 0.03
# error that a program may have by its own mesh: if less is left, no further mistake is looked for
OWN_ERROR = 0.01
# change of a quantity from which on a mistake has to explain its error
TOUCHED = 1e-3
# difference of predictions below which they are alike
ALIKE = 0.02


@dataclass(frozen=True, eq=False)
class Part:
    """A mistake of a size."""

    cause: Cause
    sizes: Sizes


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Mistakes that are made together.

    Parameters
    ----------
    parts : the mistakes; none: there is none
    predicted : (S, K) what is printed then
    gaps : (S, K) differences of theirs to it, relative
    errors : (Q,) root mean squares of these, by quantity
    """

    parts: tuple[Part, ...]
    predicted: Array
    gaps: Array
    errors: Array

    @property
    def setting(self) -> Setting:
        """What the other program has modelled and printed."""
        return setting_of(self.parts)

    @property
    def log_prior(self) -> float:
        """Logarithm of its odds against there being no mistake."""
        return float(sum(np.log(part.cause.prior / part.cause.choices) for part in self.parts))

    @property
    def fitted(self) -> int:
        """How many numbers are fitted."""
        return sum(part.cause.fitted for part in self.parts)


def setting_of(parts: Iterable[Part]) -> Setting:
    """Return the setting with mistakes in it."""
    setting = Setting()
    for part in parts:
        setting = part.cause.change(setting, part.sizes)
    return setting


@dataclass(frozen=True, eq=False)
class Weighing:
    """Finds hypotheses, and weighs them.

    Parameters
    ----------
    model : predicts what a program prints
    causes : the mistakes that are looked for
    """

    model: Model
    causes: Sequence[Cause]

    @property
    def _comparison(self) -> Comparison:
        return self.model.comparison

    def hypothesis(self, parts: tuple[Part, ...]) -> Hypothesis:
        """Return mistakes with what they predict."""
        predicted = self.model.predict(setting_of(parts))
        gaps, members = self._comparison.gaps(predicted), self._comparison.members
        counts = self._comparison.given.sum(axis=0) @ members.T
        errors = np.sqrt((gaps**2).sum(axis=0) @ members.T / np.maximum(counts, 1))
        return Hypothesis(parts, predicted, gaps, errors)

    def whitened(self, hypothesis: Hypothesis, noise: Array, bias: float) -> Array:
        """Return differences over the errors that programs make, which then are independent.

        An error that is common to all values of a quantity counts as one.

        Parameters
        ----------
        noise : (Q,) of each quantity, by chance
        bias : common to all values of a quantity
        """
        members, gaps = self._comparison.members, hypothesis.gaps
        scale = min(1.0, MOST_TIMES / len(gaps))
        # what a common error of one changes
        predicted = np.where(self._comparison.given, hypothesis.predicted, 0.0)
        norms = self._comparison.norms(predicted) @ members
        along = np.divide(predicted, norms, out=np.zeros_like(predicted), where=norms > 0)
        square = np.maximum((along**2).sum(axis=0) @ members.T, 1e-300)
        common = (along * gaps).sum(axis=0) @ members.T / square
        kept = 1 - noise / np.sqrt(noise**2 + bias**2 * square * scale)
        left = gaps - along * ((kept * common) @ members)
        return np.asarray(np.sqrt(scale) * (left / (noise @ members))[self._comparison.given])

    def fit(self, parts: tuple[Part, ...]) -> Hypothesis | None:
        """Return mistakes with the sizes that suit best; None if there is no such mistake."""
        # only a diagnosis needs it, not who reads results
        from scipy.optimize import least_squares

        start = [np.array(part.sizes) for part in parts if part.cause.searched]
        if not start:
            return self.hypothesis(parts)
        first = np.concatenate(start)
        noise = np.full(len(self._comparison.names), NOISE)

        def sized(logs: Array) -> tuple[Part, ...]:
            sizes = iter((np.sign(first) * np.exp(np.clip(logs, -50, 50))).tolist())
            return tuple(
                Part(part.cause, tuple(next(sizes) for _ in part.sizes))
                if part.cause.searched
                else part
                for part in parts
            )

        begin = np.log(np.abs(first))

        def gaps(logs: Array) -> Array:
            # the last rows hold sizes that nothing depends on
            return np.append(
                self.whitened(self.hypothesis(sized(logs)), noise, BIAS), HELD * (logs - begin)
            )

        found = least_squares(gaps, begin, method="lm", diff_step=1e-6, xtol=1e-4, ftol=1e-3)
        parts = sized(found.x)
        if not all(part.cause.within(self.model, part.sizes) for part in parts):
            return None
        return self.hypothesis(parts)

    def score(self, hypothesis: Hypothesis, noise: Array, bias: float) -> float:
        """Return the logarithm of the weight of a hypothesis."""
        gaps = self.whitened(hypothesis, noise, bias)
        count = min(len(gaps), MOST_VALUES)
        likelihood = -count / 2 * np.log1p(np.mean(gaps**2))
        prior = hypothesis.log_prior
        if not hypothesis.parts and len(gaps) < FEW:
            prior = np.log(NONE_OF_FEW)
        return float(prior + likelihood - hypothesis.fitted / 2 * np.log(count))

    def rough_score(self, hypothesis: Hypothesis) -> float:
        """Return the logarithm of its weight before the errors of the program are known."""
        return self.score(hypothesis, np.full(len(self._comparison.names), NOISE), BIAS)

    def best_of(self, cause: Cause, others: tuple[Part, ...]) -> Hypothesis | None:
        """Return a cause of the size that suits best, beside other mistakes."""
        tried = [
            self.hypothesis((*others, Part(cause, sizes))) for sizes in cause.candidates(self.model)
        ]
        tried.sort(key=lambda one: -self.rough_score(one))
        without = self.hypothesis(others)
        starts = MOST_STARTS if cause.searched and not others else 1
        fitted = [self.fit(one.parts) for one in tried[:starts]]
        found = [one for one in fitted if one is not None and _change(one, without) > TOUCHED]
        return max(found, key=self.rough_score, default=None)

    def all(self) -> list[tuple[Hypothesis, float]]:
        """Return hypotheses with their shares, which sum to 1, the likeliest first."""
        values = int(self._comparison.given.sum())
        causes = [
            cause
            for cause in self.causes
            # fewer values than numbers that are fitted say nothing of them
            if cause.fitted <= values and cause.applies(self.model)
        ]
        levels = [[one for cause in causes if (one := self.best_of(cause, ()))]]
        seen = set[frozenset[Cause]]()
        for most in (MOST_SINGLE, MOST_PAIRS):
            open_ones = [one for one in levels[-1] if one.errors.max() > OWN_ERROR]
            likeliest = sorted(open_ones, key=lambda one: -self.rough_score(one))[:most]
            together = list[Hypothesis]()
            for one in likeliest:
                made = {part.cause for part in one.parts}
                groups = {cause.group for cause in made}
                for cause in causes:
                    key = frozenset({*made, cause})
                    if cause.group in groups or key in seen:
                        continue
                    seen.add(key)
                    if both := self.best_of(cause, one.parts):
                        together.append(both)
            levels.append(together)
        found = [self.hypothesis(()), *(one for level in levels for one in level)]
        closest = min(found, key=lambda one: float(np.sum(one.errors**2)))
        least = LEAST_NOISE * np.sqrt(MOST_VALUES / min(values, MOST_VALUES))
        noise = np.maximum(closest.errors, least)
        bias = min(MOST_BIAS, 2 * float(noise.max()))
        scores = np.array([self.score(one, noise, bias) for one in found])
        shares = np.exp(scores - scores.max())
        shares /= shares.sum()
        return [(found[place], float(shares[place])) for place in np.argsort(-shares)]


def _change(hypothesis: Hypothesis, other: Hypothesis) -> float:
    """Return by how much predictions differ, relative to them."""
    gap = np.linalg.norm(hypothesis.gaps - other.gaps)
    return float(gap / np.sqrt(max(1, int(np.count_nonzero(hypothesis.gaps)))))


def alike(hypothesis: Hypothesis, other: Hypothesis) -> bool:
    """Return whether two hypotheses predict nearly the same."""
    return _change(hypothesis, other) < ALIKE


def explained(hypothesis: Hypothesis, none: Hypothesis, members: Array) -> float:
    """Return the part of the error of quantities that mistakes change which they explain."""
    changed = np.abs(hypothesis.predicted - none.predicted).sum(axis=0) @ members.T
    touched = changed > TOUCHED * (np.abs(none.predicted).sum(axis=0) @ members.T)
    if not touched.any() or not none.errors[touched].any():
        return 0.0
    before, after = (float(np.mean(one.errors[touched] ** 2)) for one in (none, hypothesis))
    left = np.sqrt(max(after - USUAL**2, 0.0) / before)
    return float(max(0.0, 1 - left))
