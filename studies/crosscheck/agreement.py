"""How far two methods agree, in three words.

Every quantity and every number of the answer that both methods give is compared in its norm. A
method states an **error estimate**; a difference of two methods has an **uncertainty**, the sum of
their estimates. With the accuracy `rtol` that the scene asks for, and ``allowed = rtol`` (2 rtol
where edges of the contact move),

- they **agree** if, at every time, each states at most `allowed` and they differ by at most twice
  that;
- they **disagree** if they differ by more than twice `allowed` and by more than the uncertainty;
- everything else is **undecided**, at times that are named, with what would decide it.

So a larger error estimate can turn *agree* or *disagree* into *undecided*, but nothing into
*agree*. A difference that is not a number never agrees, and a quantity whose error a method should
estimate, but does not, is undecided. What cannot be promised at some times (`studies/crosscheck/
promise.py`) is undecided there, without making the verdict on the run undecided.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...meshes.radial import Array
from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import (
    ANSWER,
    COMPARED_MODES,
    DESCRIBED,
    FINEST_RTOL,
    QUANTITIES,
    STEADY,
)
from ..sampling.norms import answer_differences, common, differences
from .promise import allowed_error, unresolved

AGREE, DISAGREE, UNDECIDED = "agree", "disagree", "undecided"


@dataclass(frozen=True, eq=False)
class Agreement:
    """One quantity of two methods.

    Parameters
    ----------
    quantity, methods : what is compared
    difference, uncertainty : relative, in the norm of the quantity, where they decide the verdict
    verdict : `agree`, `disagree` or `undecided`
    remark : what would decide it, if it is undecided
    promised : whether the verdict on the run depends on it; False if it is undecided only at times
        at which the accuracy cannot be promised
    when : the times at which it is undecided, in words; empty if at all of them
    """

    quantity: str
    methods: tuple[str, str]
    difference: float
    uncertainty: float
    verdict: str
    remark: str = ""
    promised: bool = True
    when: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the verdict is `agree`."""
        return self.verdict == AGREE


class Difference(NamedTuple):
    """Differences of two methods in one quantity, and the error estimates of each, (n,)."""

    size: Array
    first: Array
    second: Array

    @property
    def uncertainty(self) -> Array:
        """(n,) sum of the error estimates of both methods."""
        return self.first + self.second

    def over_bound(self, allowed: float) -> Array:
        """Return the differences over the bound beyond which the methods disagree."""
        over = self.size / np.maximum(self.uncertainty, 2 * allowed)
        return np.where(np.isfinite(self.size), over, np.inf)

    def doubtful(self, allowed: float) -> NDArray[np.bool_]:
        """Return where a method states more than is allowed, or nothing, or they differ by more."""
        stated = np.maximum(self.first, self.second)
        # comparisons with NaN are False
        return ~((stated <= allowed) & (self.size <= 2 * allowed))


def compare(problem: Problem, solutions: Sequence[Solution]) -> dict[str, Difference]:
    """Return the differences of two solutions in everything whose error both estimate."""
    first, second = solutions
    found = differences(first.checked, second.checked, problem.face)
    found |= answer_differences(first.answers, second.answers)
    compared = {}
    for name, difference in found.items():
        if name not in first.errors or name not in second.errors or not problem.wants(name):
            continue
        parts = [difference, *(each.checked_error(problem, name) for each in solutions)]
        if "mode" in DESCRIBED[name].dims:
            parts = [part[:COMPARED_MODES] for part in parts]
        shared = common(*(part.shape for part in parts))
        size, *stated = (np.atleast_1d(part[shared]) for part in parts)
        if name in ANSWER:
            # closed forms give no start, and shaped punches no pressures then
            given = ~np.isnan(size)
            size, stated = size[given], [error[given] for error in stated]
        if size.size:
            compared[name] = Difference(size, *stated)
    return compared


def due(problem: Problem) -> set[str]:
    """Return what two methods that lack nothing have to be compared in."""
    names = set(QUANTITIES) - {"contact", "contact_edge"} - STEADY - problem.quantities_missing
    if not len(problem.times):
        names = {"relaxation_time"} & names if problem.quantities else set()
    else:
        names |= problem.contact.compared_numbers - problem.load_regime.numbers_missing
    if problem.steady:
        names |= STEADY
    return {name for name in names if problem.wants(name)}


def agreements(
    problem: Problem, names: tuple[str, str], solutions: tuple[Solution, Solution]
) -> list[Agreement]:
    """Compare two methods in everything that both give, at the times that are compared."""
    compared, expected = compare(problem, solutions), due(problem)
    if any(each.wear is None and each.march is None for each in solutions):
        # one of them lacks the history
        expected &= solutions[0].checked.keys() & solutions[1].checked.keys()
    missing = [
        Agreement(quantity, names, np.inf, np.inf, UNDECIDED, "a method states no error of it")
        for quantity in sorted(expected - compared.keys())
    ]
    by_name = dict(zip(names, solutions, strict=True))
    rows = [_judge(problem, by_name, *item) for item in compared.items()]
    return missing + rows


def _judge(
    problem: Problem, solutions: Mapping[str, Solution], quantity: str, difference: Difference
) -> Agreement:
    """Return the verdict on one quantity of two methods."""
    first_name, second_name = names = tuple(solutions)
    size, first, second = difference
    allowed, uncertainty = allowed_error(problem), difference.uncertainty
    over, doubtful = difference.over_bound(allowed), difference.doubtful(allowed)
    # where many are as uncertain, the one that differs most
    worst = int(np.lexsort((size, uncertainty, doubtful))[-1])
    verdict, remark, when, promised = AGREE, "", "", True
    if (over > 1).any():
        worst, verdict = int(np.argmax(over)), DISAGREE
    elif doubtful.any():
        verdict, blamed = UNDECIDED, names[int(second[worst] > first[worst])]
        reasons = [
            unresolved(problem, quantity, solutions, int(at)) for at in np.flatnonzero(doubtful)
        ]
        promised = not all(reasons)
        remark = next(filter(None, reasons), "")
        if promised:
            remark = remedy(problem, blamed, solutions[blamed], float(uncertainty[worst]))
        when = when_in_words(problem, quantity, doubtful)
    numbers = float(size[worst]), float(uncertainty[worst])
    pair = first_name, second_name
    return Agreement(quantity, pair, *numbers, verdict, remark, promised, when)


def disagreement(problem: Problem, solutions: Collection[Solution], keep: Collection[str]) -> float:
    """Return the greatest difference over what would make two methods disagree, above 1.

    It is that of the quantities to keep; NaN where there is nothing to compare.
    """
    greatest = np.nan
    for pair in combinations(solutions, 2):
        compared = compare(problem, pair)
        for name in compared.keys() & set(keep):
            over = compared[name].over_bound(allowed_error(problem))
            greatest = np.fmax(greatest, np.max(over, initial=0.0))
    return float(greatest)


def when_in_words(problem: Problem, quantity: str, some: NDArray[np.bool_]) -> str:
    """Return some of the compared times in words; empty if they are all, or there are none."""
    if DESCRIBED[quantity].dims[:1] != ("time",) or some.all():
        return ""
    times = problem.times[problem.checked] * problem.units.time
    last = int(np.flatnonzero(some)[-1])
    if not some[: last + 1].all():
        return f"at {some.sum()} of {len(times)} times"
    return f"{'up to' if last else 'at'} t = {times[last]:.3g}"


def remedy(problem: Problem, blamed: str, solution: Solution, error: float) -> str:
    """Return what would decide a quantity: an accuracy to ask for, other sizes, or other times."""
    rtol = problem.rtol**2 / error
    if solution.remedy:
        return solution.remedy
    if problem.march != "modal":
        return "the step is too long; march = 'modal' has none"
    if rtol < FINEST_RTOL:
        return f"{blamed} states {error:.1e}; no accuracy that can be asked for decides it"
    return f"{blamed} states {error:.1e}; rtol = {rtol:.0e} would decide it"


def overall(rows: Sequence[Agreement]) -> str:
    """Return the least verdict of what is promised; what is not promised can still disagree.

    Without anything to compare, as with one method, nothing is decided.
    """
    if not rows:
        return UNDECIDED
    if any(row.verdict == DISAGREE for row in rows):
        return DISAGREE
    undecided = any(row.verdict == UNDECIDED for row in rows if row.promised)
    return UNDECIDED if undecided else AGREE


def by_quantity(rows: Sequence[Agreement]) -> dict[str, Agreement]:
    """Return of each quantity the two methods whose difference says most."""
    order = (AGREE, UNDECIDED, DISAGREE)
    ordered = sorted(rows, key=lambda row: (order.index(row.verdict), row.difference))
    worst = {row.quantity: row for row in ordered}
    return {name: worst[name] for name in DESCRIBED if name in worst}
