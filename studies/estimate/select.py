"""Fit each mistake by itself, and rank the mistakes by what remains.

A mistake is a parameter of the scene, or of the reading of a table, that is not as it should be.
Candidates are ranked by ``n ln e^2 + f ln n`` for n values with the error e and f fitted numbers
(Schwarz, Annals of Statistics 6 (1978) 461).
"""

from collections.abc import Callable, Iterator, Sequence
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

# assumed relative error of a program: the random part, and the part that all values of
# a quantity have in common
NOISE, BIAS = 0.02, 0.02
# part of the difference, at most `NOISE`, below which differences of what remains do not count
FLOOR = 0.1
# greatest number of values that count as independent
MAX_VALUES = 24
# a choice among several values counts as half a fitted number
CHOICE = 0.5
# number of candidates that are estimated again, and of evaluations for each without interpolation
MAX_SOLVED, EVALUATIONS_SOLVED = 3, 5
# difference of the score that is hardly worth mentioning (Kass and Raftery, J. Am. Stat. Assoc. 90
# (1995) 773)
ALIKE = 2.0
# number of starts of a search; relative change of chi-square and number of evaluations at its end
MAX_STARTS, TOLERANCE, EVALUATIONS = 3, 1e-3, 20
# least relative change of the prediction that a mistake must cause
MIN_EFFECT = 1e-3
# name of the mistake that is the mesh itself
COARSE_MESH = "coarse mesh"
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
    special_of : name of a mistake of which it is a special case, if both change the same
    changes : what it changes, to tell mistakes of one name
    of_mesh : whether a right model has this error, too, if its mesh is too small or too coarse
    size : returns the number that is reported for the mistake, from the values of the parameters
    """

    name: str
    sentence: str | Callable[..., str]
    remedy: str
    parameters: tuple[Parameter, ...] = ()
    special_of: str = ""
    changes: str = ""
    of_mesh: bool = False
    size: Callable[..., float] = lambda *values: values[0]

    @property
    def fitted_numbers(self) -> float:
        """Number of parameters that are fitted; choices count as `CHOICE`."""
        return sum(
            1 if not each.values else CHOICE * (len(each.values) > 1) for each in self.parameters
        )

    @property
    def starts(self) -> list[tuple[float, ...]]:
        """Values that are tried, or at which a search begins."""
        choices = (each.values or each.starts or (each.value,) for each in self.parameters)
        return list(product(*choices))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A mistake with its values, or none.

    Parameters
    ----------
    mistake : None for the candidate without a mistake
    likelihood : of the data; its parameters are those of the mistake and, last, those of the errors
        of a mesh
    point : best coordinates (m,)
    floor : relative error that is added to what remains: smaller differences do not count
    """

    mistake: Mistake | None
    likelihood: Likelihood
    point: Point
    floor: float

    @cached_property
    def predicted(self) -> Array:
        """(n,) predicted values of all measurements."""
        return np.concatenate(self.likelihood.predictor.predict(self.point.x))

    @cached_property
    def values(self) -> tuple[float, ...]:
        """The values of the parameters of the mistake."""
        parameters = self.mistake.parameters if self.mistake else ()
        return tuple(each.at(float(x)) for each, x in zip(parameters, self.point.x, strict=False))

    @cached_property
    def errors(self) -> Array:
        """(Q,) root mean squares of the relative errors that remain, by measurement."""
        measured = np.concatenate([each.values for each in self.likelihood.measurements])
        return self._relative_sizes((measured - self.predicted) / self.likelihood.noise)

    def changes(self, other: "Candidate") -> Array:
        """Return the relative changes (Q,) of the prediction from another candidate's."""
        return self._relative_sizes((self.predicted - other.predicted) / self.likelihood.noise)

    def _relative_sizes(self, differences: Array) -> Array:
        """Return root mean squares (Q,) of differences over the noise, over the sizes of data."""
        likelihood, present = self.likelihood, np.isfinite(self.likelihood.noise)
        squares = likelihood.split(np.where(present, differences, 0.0) ** 2)
        pairs = zip(squares, likelihood.split(present), strict=True)
        return NOISE * np.array(
            [np.sqrt(each.sum() / max(1, there.sum())) for each, there in pairs]
        )

    @cached_property
    def score(self) -> float:
        """What remains, with a penalty for each fitted number; lower is better.

        Each measurement has errors of unknown size, and all count the same. At most `MAX_VALUES`
        values count as independent.
        """
        own = self.mistake.fitted_numbers if self.mistake else 0.0
        of_mesh = len(self.likelihood.parameters) - len(self.values)
        # without what the values of a measurement have in common
        unbiased = self._relative_sizes(self.likelihood.residuals(self.point.x))
        # what is wrong by more than its size is only wrong
        squares = np.minimum(unbiased, 1.0) ** 2 + self.floor**2
        remaining = self.values_counted * float(np.mean(np.log(squares)))
        return remaining + (own + of_mesh) * float(np.log(self.values_counted))

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


def select(
    model: Model, mistakes: Sequence[Mistake], of_mesh: tuple[Parameter, ...] = ()
) -> list[Candidate]:
    """Return the candidates of each mistake and of none, the lowest score first.

    Parameters
    ----------
    model : without parameters; its measurements have the relative error `NOISE`
    mistakes : that are considered
    of_mesh : parameters of the errors of a mesh, which are fitted together with each mistake
    """
    none = Candidate(None, Likelihood(model, (), ()), Point(np.empty(0), 0.0), 0.0)
    none = replace(none, floor=min(NOISE, FLOOR * float(none.errors.max(initial=0.0))))
    candidates = [none]
    for mistake in mistakes:
        with left_out(mistake.name):
            # the mesh itself has the same parameter
            further = of_mesh if mistake.name != COARSE_MESH else ()
            if found := _with_mistake(none, mistake, further):
                candidates.append(found)
    first = sorted(candidates, key=lambda each: each.score)[:MAX_SOLVED]
    candidates = [_refined(each) if each in first else each for each in candidates]
    # of mistakes that leave about the same, the one with fewest parameters is first, and then
    # the first one of the table
    best = min(each.score for each in candidates)
    return sorted(
        candidates,
        key=lambda each: (max(each.score - best - ALIKE, 0.0), len(each.likelihood.parameters)),
    )


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


def _with_mistake(
    none: Candidate, mistake: Mistake, of_mesh: tuple[Parameter, ...]
) -> Candidate | None:
    """Return the best candidate with a mistake.

    It is None if the mistake has no effect, or if its values are at the ends of their range.

    Raises
    ------
    SolverError
        if it has no finite results
    """
    parameters = (*mistake.parameters, *of_mesh)
    free = tuple(number for number, each in enumerate(parameters) if not each.values)
    if len(free) > none.values_present:
        return None
    likelihood = Likelihood(none.likelihood.predictor.with_parameters(parameters), parameters, free)
    points = []
    for values in mistake.starts:
        x, starts = np.zeros(len(parameters)), zip(mistake.parameters, values, strict=True)
        x[: len(values)] = [each.coordinate(value) for each, value in starts]
        if np.isfinite(chi_square := float(np.sum(likelihood.residuals(x) ** 2))):
            points.append(Point(x, chi_square))
    if not points:
        raise SolverError("its results are not finite")
    points.sort(key=lambda point: point.chi_square)
    if free:
        points = [
            likelihood.best_from(point.x, tolerance=TOLERANCE, evaluations=EVALUATIONS)
            for point in points[:MAX_STARTS]
        ]
    best = min(points, key=lambda point: point.chi_square)
    own = zip(mistake.parameters, best.x.tolist(), strict=False)
    if any(abs(x) > each.reach for each, x in own):
        return None
    found = Candidate(mistake, likelihood, best, none.floor)
    return found if found.changes(none).max() > MIN_EFFECT else None
