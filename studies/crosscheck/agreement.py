"""How far two methods agree, in three words.

Every quantity that both give, in its norm, against what each says of itself.

They agree where their difference is within their combined uncertainty, or within the accuracy asked
for, and that uncertainty within a few times this. They disagree where the difference is beyond
both, and neither says of itself that it errs by more than was asked for. All else is undecided, and
it is said what would decide it.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...meshes.radial import Array
from ..methods.base import Solution, method

FINEST_MEASURED = 1e-7
from ..methods.quantities import (
    A_FEW,
    COMPARED_MODES,
    ENERGIES,
    FINEST,
    QUANTITIES,
    common,
    differences,
)
from ..problem.defaults import at_smallest, field_accuracy
from ..problem.problem import Problem

# times as accurate that a method has to be to show what another's error is
BETTER = 10.0
# where contact ends within the face: known to a cell, whatever the accuracy asked for
AT_EDGES = (
    "pressure",
    "profile",
    "displacement",
    "displacement_centre",
    "displacement_max",
    "rms_slope",
    "contact_radius",
)
# of a flat punch: where wear has made layers thinner than coordinates can tell
EARLY = ("rms_slope", "pressure")
AGREE, DISAGREE, UNDECIDED = "agree", "disagree", "undecided"


@dataclass(frozen=True, eq=False)
class Agreement:
    """One quantity of two methods.

    Parameters
    ----------
    quantity, methods : what is compared
    difference, uncertainty : relative, in the norm of the quantity, where they decide the verdict
    verdict : `agree`, `disagree` or `undecided`
    remark : of what is undecided, when, by whose fault, and what would decide it
    promised : whether the verdict on the run waits for it; where edges of a contact move, not for
        what is local to them, nor for fields of a flat punch that cannot be resolved
    """

    quantity: str
    methods: tuple[str, str]
    difference: float
    uncertainty: float
    verdict: str
    remark: str = ""
    promised: bool = True

    @property
    def agrees(self) -> bool:
        return self.verdict == AGREE


def agreements(
    problem: Problem, names: tuple[str, str], solutions: tuple[Solution, Solution]
) -> list[Agreement]:
    """Compare two methods in every quantity that both give, at the times that are checked."""
    found = differences(solutions[0].checked, solutions[1].checked, problem.face)
    return [
        _agreement(problem, name, names, *_compared(problem, name, difference, solutions))
        for name, difference in found.items()
    ]


class Worst(NamedTuple):
    """Of some quantities and every two methods, the worst; NaN where there is nothing to compare.

    Parameters
    ----------
    disagreement : greatest difference over what would make them disagree: above 1 they do
    effectivity : least stated error over the error that a method at least `BETTER` times as
        accurate shows
    """

    disagreement: float
    effectivity: float


def worst(problem: Problem, solutions: Collection[Solution], keep: Collection[str]) -> Worst:
    """The worst of the quantities to keep."""
    disagreement = effectivity = np.nan
    for both in combinations(solutions, 2):
        found = differences(both[0].checked, both[1].checked, problem.face)
        for name in found.keys() & set(keep):
            difference, first, second = _compared(problem, name, found[name], both)
            disagreement = np.fmax(
                disagreement, np.max(_over_bound(problem, difference, first, second), initial=0.0)
            )
            # estimates of errors far below the accuracy asked for may be of chance
            counted = difference > problem.rtol / 20
            for stated, other in ((first, second), (second, first)):
                shown = counted & (stated > BETTER * other)
                effectivity = np.fmin(
                    effectivity, np.min(stated[shown] / difference[shown], initial=np.inf)
                )
    return Worst(float(disagreement), float(effectivity) if np.isfinite(effectivity) else np.nan)


def _over_bound(problem: Problem, difference: Array, first: Array, second: Array) -> Array:
    """Return differences over the bound beyond which methods that state such errors disagree."""
    rtol = problem.rtol
    decisive = (first <= rtol) & (second <= rtol)
    return np.where(decisive, difference / np.maximum(first + second, rtol), 0.0)


def _compared(
    problem: Problem, name: str, difference: Array, solutions: tuple[Solution, Solution]
) -> tuple[Array, Array, Array]:
    """The difference and both methods' own errors, where all are known."""
    errors = [solution.checked_error(problem, name) for solution in solutions]
    if "mode" in QUANTITIES[name].dims:
        difference, *errors = (one[:COMPARED_MODES] for one in (difference, *errors))
    known = common(difference.shape, *(error.shape for error in errors))
    difference, first, second = (np.atleast_1d(one[known]) for one in (difference, *errors))
    return difference, first, second


def _agreement(
    problem: Problem, name: str, of: tuple[str, str], difference: Array, first: Array, second: Array
) -> Agreement:
    over, rtol = _over_bound(problem, difference, first, second), problem.rtol
    uncertainty = first + second
    if (over > 1).any():
        worst = int(np.argmax(over))
        return Agreement(name, of, float(difference[worst]), float(uncertainty[worst]), DISAGREE)
    # where many are as uncertain, the one that differs most
    open_ = (uncertainty > A_FEW * rtol) | (difference > np.maximum(uncertainty, rtol))
    worst = int(np.lexsort((difference, uncertainty, open_))[-1])
    row = Agreement(
        name,
        of,
        float(difference[worst]),
        float(uncertainty[worst]),
        AGREE,
        promised=_promised(problem, name),
    )
    if not open_.any():
        return row
    loser = of[int(second[worst] > first[worst])]
    when = _when(problem, name, open_)
    return replace(
        row,
        verdict=UNDECIDED,
        remark=f"{when}{remedy(problem, name, loser, float(uncertainty[worst]))}",
    )


def _promised(problem: Problem, name: str) -> bool:
    """Whether the accuracy asked for is promised of a quantity.

    Fields are not where they cannot be resolved.
    """
    if not problem.full_contact:
        return name not in AT_EDGES
    if name in EARLY and at_smallest(problem):
        return False
    return name in ENERGIES or field_accuracy(problem) <= problem.rtol


def _when(problem: Problem, name: str, undecided: NDArray[np.bool_]) -> str:
    if QUANTITIES[name].dims[:1] != ("time",) or undecided.all():
        return ""
    times, units = problem.times[problem.checked], problem.units.time
    last = int(np.flatnonzero(undecided)[-1])
    if not undecided[: last + 1].all():
        return f"at {undecided.sum()} of {len(times)} times: "
    return (
        f"at t = {times[last] * units:.3g}: "
        if last == 0
        else f"up to t = {times[last] * units:.3g}: "
    )


def remedy(problem: Problem, name: str, blamed: str, error: float) -> str:
    """What would decide a quantity: an accuracy to ask for, with its cost, or other times."""
    one = method(blamed)
    if blamed == "fem" and problem.fem.far_field == "fixed":
        return "the clamped boundary errs by 1.1 a/R; far_field = 'boussinesq' does not"
    if not problem.full_contact and name not in ENERGIES:
        where = "pressures may be infinite at edges"
        if problem.earliest:
            where = "pressures jump at edges of worn faces that move"
        return f"{where}, and fields are known to a cell there; ask for a smaller rtol"
    if name in EARLY and at_smallest(problem):
        return (
            f"the layers that wear makes by the first times are thinner than {blamed} can resolve; "
            "ask for later times"
        )
    if (fields := field_accuracy(problem)) > problem.rtol and name not in ENERGIES:
        return (
            f"with so many rings fields are resolved to {fields:.0e} only; give degree and "
            f"ring_size of {blamed} for more"
        )
    if one.own_march:
        return f"{blamed} is of first order; give a finer accuracy.mdr.grid"
    if one.sizes_given(problem):
        return f"the sizes given for {blamed} are too coarse; leave them out"
    if problem.march != "modal":
        return "the step is too long; march = 'modal' has none"
    rtol = problem.rtol**2 / error
    if rtol < FINEST:
        return f"{blamed} states {error:.1e}; no accuracy that can be asked for decides it"
    seconds = one.cost(replace(problem, rtol=rtol)).seconds
    known = np.isfinite(seconds) and rtol >= FINEST_MEASURED
    cost = f", in about {seconds:.2g} s" if known else ""
    return f"{blamed} states {error:.1e}; rtol = {rtol:.0e} would decide it{cost}"


def worst_verdict(verdicts: list[str]) -> str:
    """The least of some verdicts."""
    return next((one for one in (DISAGREE, UNDECIDED) if one in verdicts), AGREE)


def overall(rows: tuple[Agreement, ...]) -> str:
    """The least verdict of what is promised; what is not can still disagree."""
    return worst_verdict([row.verdict for row in rows if row.promised or row.verdict == DISAGREE])


def by_quantity(rows: list[Agreement] | tuple[Agreement, ...]) -> dict[str, str]:
    """The least verdict on each quantity over all pairs of methods."""
    names = dict.fromkeys(row.quantity for row in rows)
    return {
        name: worst_verdict([row.verdict for row in rows if row.quantity == name]) for name in names
    }
