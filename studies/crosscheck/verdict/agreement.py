"""The verdict on two methods: agree, disagree or undecided.

Every quantity and every number of the answer that both methods compute is compared in its norm. A
method has an **error estimate**; a difference of two methods has an **uncertainty**, the sum of
their error estimates. Let ``allowed = rtol``, the tolerance of the scene (2 rtol if edges of the
contact move). Two methods

- **agree** if, at every time, both error estimates are at most `allowed` and the difference is at
  most twice that;
- **disagree** if the difference is larger than twice `allowed` and larger than the uncertainty;
- are **undecided** in all other cases; the result names the times and a remedy.

A larger error estimate can therefore turn *agree* or *disagree* into *undecided*, but it never
results in *agree*. A difference that is not a number never agrees. A quantity is undecided if a
method has no error estimate where it should have one, or if one method alone computes it. A
quantity whose accuracy cannot be promised at some times (`studies/crosscheck/verdict/promise.py`)
is undecided there, but does not make the verdict on the run undecided.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....meshes.radial import Array
from ..methods.base import Solution
from ..problem.norms import Results, common
from ..problem.problem import Problem
from ..problem.quantities import (
    ANSWER,
    COMPARED_MODES,
    DESCRIBED,
    FINEST_RTOL,
    NOT_COMPARED,
    QUANTITIES,
    STEADY,
    differences,
)
from ..problem.unit_names import UnitNames
from .promise import allowed_error, times_in_words, unresolved

AGREE, DISAGREE, UNDECIDED = "agree", "disagree", "undecided"
NO_UNITS = UnitNames()
ONE_METHOD = (
    "one method alone computes it, so that nothing checks it: add a method, such as mdr, bem or fem"
)
# numbers of the answer in which two methods must be compared if the punch is in full contact, in
# addition to the times of its running-in
NUMBERS_OF_FLAT_PUNCHES = {"running_in_time", "indentation_start", "force_share", "worn_volume"}


@dataclass(frozen=True, eq=False)
class Agreement:
    """The verdict on one quantity of two methods.

    Parameters
    ----------
    quantity, methods : names of the quantity and of the methods; one method if no other computes it
    difference, uncertainty : relative, in the norm of the quantity, at the time that decides the
        verdict
    verdict : `agree`, `disagree` or `undecided`
    remark : remedy or reason, if the verdict is `undecided`
    promised : whether the verdict on the run depends on this one; False if it is undecided only at
        times at which the accuracy cannot be promised
    when : the times at which they disagree, or at which it is undecided, in words; empty if these
        are all times
    """

    quantity: str
    methods: tuple[str, ...]
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
    """Differences (n,) of two methods in one quantity, and the error estimates (n,) of both."""

    size: Array
    first: Array
    second: Array

    @property
    def uncertainty(self) -> Array:
        """(n,) sum of the error estimates of both methods."""
        return self.first + self.second

    def over_bound(self, allowed: float) -> Array:
        """Return the differences (n,) over the bound above which the methods disagree."""
        over = self.size / np.fmax(self.uncertainty, 2 * allowed)
        return np.where(np.isfinite(self.size), over, np.inf)

    def doubtful(self, allowed: float) -> NDArray[np.bool_]:
        """Return where (n,) the methods do not agree.

        They do not if an error estimate is missing or larger than `allowed`, or if the difference
        is larger than twice that.
        """
        larger_estimate = np.maximum(self.first, self.second)
        # comparisons with NaN are False
        return ~((larger_estimate <= allowed) & (self.size <= 2 * allowed))


def compare(problem: Problem, solutions: Sequence[Solution]) -> dict[str, Difference]:
    """Return the differences of two solutions in all quantities with an error estimate of both."""
    first, second = solutions
    compared = {}
    for name, difference in _differences_over_larger(problem, first, second).items():
        if name not in first.errors or name not in second.errors or not problem.wants(name):
            continue
        arrays = [difference, *(solution.compared_error(problem, name) for solution in solutions)]
        if "mode" in DESCRIBED[name].dims:
            arrays = [array[:COMPARED_MODES] for array in arrays]
        common_part = common(*(array.shape for array in arrays))
        size, *estimates = (np.atleast_1d(array[common_part]) for array in arrays)
        if name in ANSWER:
            # NaN: closed forms give no start, and shaped punches give no pressures at the start
            defined = ~np.isnan(size)
            size, estimates = size[defined], [error[defined] for error in estimates]
        if size.size:
            compared[name] = Difference(size, *estimates)
    return compared


def _differences_over_larger(problem: Problem, first: Solution, second: Solution) -> Results:
    """Return the differences of two solutions, relative to the larger one of their values.

    Each error estimate is relative to the value of its own method. Two values v1 and v2 with the
    estimates e1 and e2 can both be right if |v1 - v2| <= e1 v1 + e2 v2. Relative to the larger
    value, this difference is then at most e1 + e2; relative to the smaller one, it may be larger.
    """
    # relative to an infinite value, an infinite difference is NaN, which never agrees
    with np.errstate(invalid="ignore"):
        one_way, other_way = (
            differences(values.compared, reference.compared, problem.face)
            for values, reference in ((first, second), (second, first))
        )
    return {
        # a difference relative to zero is reported as zero; the one relative to the other value is
        # then 1
        name: np.where(
            (one_way[name] == 0) | (other_way[name] == 0),
            np.maximum(one_way[name], other_way[name]),
            np.minimum(one_way[name], other_way[name]),
        )
        for name in one_way
    }


def due(problem: Problem) -> set[str]:
    """Return the quantities in which two methods must be compared if both compute everything."""
    names = QUANTITIES.keys() - NOT_COMPARED - STEADY
    if not problem.full_contact:
        names = names - {"relaxation_time"}
    if not len(problem.times):
        names = {"relaxation_time"} & names if problem.quantities else set()
    elif problem.full_contact:
        names |= NUMBERS_OF_FLAT_PUNCHES | problem.remaining_parts.keys()
    if problem.steady:
        names |= STEADY
    return {name for name in names if problem.wants(name)}


def agreements(
    problem: Problem,
    names: tuple[str, str],
    solutions: tuple[Solution, Solution],
    units: UnitNames = NO_UNITS,
) -> list[Agreement]:
    """Compare two methods in all quantities that both compute, at the compared times.

    `units` are those of the scene; times are written in them.
    """
    compared, expected = compare(problem, solutions), due(problem)
    if any(solution.wear is None and solution.evolution is None for solution in solutions):
        # one of the methods computes no history
        expected &= solutions[0].compared.keys() & solutions[1].compared.keys()
    missing = [
        Agreement(quantity, names, np.inf, np.inf, UNDECIDED, "a method has no error estimate")
        for quantity in sorted(expected - compared.keys())
    ]
    by_name = dict(zip(names, solutions, strict=True))
    rows = [_judge(problem, units, by_name, *item) for item in compared.items()]
    return missing + rows


def unchecked(problem: Problem, solutions: Mapping[str, Solution]) -> list[Agreement]:
    """Return a row for each quantity that one of several methods alone computes: undecided."""
    rows = []
    for quantity in sorted(due(problem)) if len(solutions) > 1 else ():
        methods = tuple(name for name, each in solutions.items() if quantity in each.compared)
        if len(methods) == 1:
            rows.append(Agreement(quantity, methods, np.inf, np.inf, UNDECIDED, ONE_METHOD))
    return rows


def _judge(
    problem: Problem,
    units: UnitNames,
    solutions: Mapping[str, Solution],
    quantity: str,
    difference: Difference,
) -> Agreement:
    """Return the verdict on one quantity of two methods."""
    first_name, second_name = names = tuple(solutions)
    sizes, first, second = difference
    allowed, uncertainty = allowed_error(problem), difference.uncertainty
    over_bound, doubtful = difference.over_bound(allowed), difference.doubtful(allowed)
    # values that are not finite have no estimates (NaN)
    uncertainty = np.nan_to_num(uncertainty)
    # a time without agreement; of several, the one with the largest uncertainty, then difference
    worst = int(np.lexsort((sizes, uncertainty, doubtful))[-1])
    verdict, remark, when, promised = AGREE, "", "", True
    if (over_bound > 1).any():
        worst, verdict = int(np.argmax(over_bound)), DISAGREE
        when = when_in_words(problem, units, quantity, over_bound > 1)
    elif doubtful.any():
        verdict, blamed = UNDECIDED, names[int(second[worst] > first[worst])]
        limits = [
            unresolved(problem, quantity, solutions, int(index))
            for index in np.flatnonzero(doubtful)
        ]
        promised = not all(limits)
        remark = next((limit.reason for limit in limits if limit), "")
        if promised:
            error = float(difference.uncertainty[worst])
            remark = remedy(problem, quantity, blamed, solutions[blamed], error)
        when = when_in_words(problem, units, quantity, doubtful)
    numbers = float(sizes[worst]), float(uncertainty[worst])
    pair = first_name, second_name
    return Agreement(quantity, pair, *numbers, verdict, remark, promised, when)


def disagreement(problem: Problem, solutions: Collection[Solution], keep: Collection[str]) -> float:
    """Return the greatest difference over the bound above which two methods disagree.

    Above 1, some pair of solutions disagrees in one of the quantities `keep`. The result is NaN if
    there is nothing to compare.
    """
    greatest = np.nan
    for pair in combinations(solutions, 2):
        compared = compare(problem, pair)
        for name in compared.keys() & set(keep):
            over = compared[name].over_bound(allowed_error(problem))
            greatest = np.fmax(greatest, np.max(over, initial=0.0))
    return float(greatest)


def when_in_words(
    problem: Problem, units: UnitNames, quantity: str, selected: NDArray[np.bool_]
) -> str:
    """Return some of the compared times in words.

    The text is empty if the times are all compared times, or if the quantity has no times.
    """
    if not DESCRIBED[quantity].over_time or selected.all():
        return ""
    times = problem.times[problem.compared_rows] * problem.units.time
    return times_in_words(times[selected].tolist(), times.tolist(), units, "up to")


def remedy(problem: Problem, quantity: str, blamed: str, solution: Solution, error: float) -> str:
    """Return a remedy for an undecided quantity: another `rtol`, other sizes or another march.

    Parameters
    ----------
    quantity : its name
    blamed : name of the method with the larger error estimate
    error : the uncertainty
    """
    rtol = problem.rtol**2 / error
    if solution.remedy:
        return solution.remedy
    if problem.march != "modal":
        return "the time step is too long; march = 'modal' needs none"
    if quantity in solution.limited_by_degree:
        return (
            f"{blamed} states {error:.1e}; its elements have the highest degree, so that a smaller "
            "rtol would not help: give a larger one"
        )
    if rtol < FINEST_RTOL:
        return f"{blamed} states {error:.1e}; no allowed rtol is small enough to decide it"
    return f"{blamed} states {error:.1e}; rtol = {rtol:.0e} would decide it"


def overall(rows: Sequence[Agreement]) -> str:
    """Return the verdict on a run.

    It is `disagree` if any quantity disagrees, promised or not; else `undecided` if a promised
    quantity is undecided, or if there is nothing to compare because only one method has run; else
    `agree`.
    """
    if not rows:
        return UNDECIDED
    if any(row.verdict == DISAGREE for row in rows):
        return DISAGREE
    undecided = any(row.verdict == UNDECIDED for row in rows if row.promised)
    return UNDECIDED if undecided else AGREE


def by_quantity(rows: Sequence[Agreement]) -> dict[str, Agreement]:
    """Return, for each quantity, the pair of methods with the worst verdict and difference."""
    order = (AGREE, UNDECIDED, DISAGREE)
    ordered = sorted(rows, key=lambda row: (order.index(row.verdict), row.difference))
    worst = {row.quantity: row for row in ordered}
    return {name: worst[name] for name in DESCRIBED if name in worst}
