"""How far two methods agree, in three words.

Every quantity that both give, in its norm, against what each says of itself. A method states an
**error estimate**; a difference of two has an **uncertainty**, the sum of their estimates.

They agree where their difference is within its uncertainty, or within the accuracy asked for, and
that uncertainty within a few times this. They disagree where the difference is beyond both, and
neither says of itself that it errs by more than was asked for. All else is undecided, and it is
said what would decide it.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.norms import common, differences
from ..problem.defaults import at_smallest, field_accuracy
from ..problem.problem import Problem
from ..problem.quantities import A_FEW, COMPARED_MODES, ENERGIES, FINEST, QUANTITIES

# where contact ends within the face: resolved to a cell, whatever the accuracy asked for
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
    when, remark : of what is undecided: the times, and by whose fault, and what would decide it
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
    when: str = ""

    @property
    def agrees(self) -> bool:
        return self.verdict == AGREE


class Difference(NamedTuple):
    """Differences of two methods in one quantity, and the error estimates of each, (n,)."""

    size: Array
    first: Array
    second: Array

    @property
    def uncertainty(self) -> Array:
        return self.first + self.second

    def over_bound(self, rtol: float) -> Array:
        """Return the differences over the bound beyond which the methods disagree.

        It is 0 where one of them says of itself that it errs by more than was asked for.
        """
        decisive = np.maximum(self.first, self.second) <= rtol
        return np.where(decisive, self.size / np.maximum(self.uncertainty, rtol), 0.0)


def compare(problem: Problem, solutions: Sequence[Solution]) -> dict[str, Difference]:
    """Return the differences of two solutions in every quantity whose error both estimate."""
    first, second = solutions
    compared = {}
    for name, difference in differences(first.checked, second.checked, problem.face).items():
        if name in first.errors and name in second.errors and problem.wants(name):
            parts = [difference, *(each.checked_error(problem, name) for each in solutions)]
            if "mode" in QUANTITIES[name].dims:
                parts = [part[:COMPARED_MODES] for part in parts]
            shared = common(*(part.shape for part in parts))
            compared[name] = Difference(*(np.atleast_1d(part[shared]) for part in parts))
    return compared


def agreements(
    problem: Problem, names: tuple[str, str], solutions: tuple[Solution, Solution]
) -> list[Agreement]:
    """Compare two methods in every quantity that both give, at the times that are checked."""
    rtol, rows = problem.rtol, []
    for quantity, difference in compare(problem, solutions).items():
        size, first, second = difference
        over, uncertainty = difference.over_bound(rtol), difference.uncertainty
        doubtful = (uncertainty > A_FEW * rtol) | (size > np.maximum(uncertainty, rtol))
        # where many are as uncertain, the one that differs most
        worst = int(np.lexsort((size, uncertainty, doubtful))[-1])
        verdict, remark, when, promised = AGREE, "", "", not unresolved(problem, quantity, "")
        if (over > 1).any():
            worst, verdict, promised = int(np.argmax(over)), DISAGREE, True
        elif doubtful.any():
            loser, verdict = names[int(second[worst] > first[worst])], UNDECIDED
            remark = remedy(problem, quantity, loser, float(uncertainty[worst]))
            when = _when(problem, quantity, doubtful)
        numbers = float(size[worst]), float(uncertainty[worst])
        rows.append(Agreement(quantity, names, *numbers, verdict, remark, promised, when))
    return rows


def disagreement(problem: Problem, solutions: Collection[Solution], keep: Collection[str]) -> float:
    """Return the greatest difference over what would make two methods disagree, above 1.

    It is that of the quantities to keep; NaN where there is nothing to compare.
    """
    greatest = np.nan
    for pair in combinations(solutions, 2):
        compared = compare(problem, pair)
        for name in compared.keys() & set(keep):
            over = compared[name].over_bound(problem.rtol)
            greatest = np.fmax(greatest, np.max(over, initial=0.0))
    return float(greatest)


def unresolved(problem: Problem, quantity: str, blamed: str) -> str:
    """Return why the accuracy asked for is not promised of a quantity; empty if it is."""
    if not problem.full_contact:
        edges = "pressures may be infinite at edges"
        if problem.earliest:
            edges = "pressures jump at edges of worn faces that move"
        words = f"{edges}, and fields are known to a cell there; ask for a smaller rtol"
        return words if quantity in AT_EDGES else ""
    if quantity in EARLY and at_smallest(problem):
        return (
            f"the layers that wear makes by the first times are thinner than {blamed} can resolve; "
            "ask for later times"
        )
    if quantity not in ENERGIES and (accuracy := field_accuracy(problem)) > problem.rtol:
        return (
            f"with so many rings fields are resolved to {accuracy:.0e} only; give degree and "
            f"ring_size of {blamed} for more"
        )
    return ""


def _when(problem: Problem, quantity: str, undecided: NDArray[np.bool_]) -> str:
    if QUANTITIES[quantity].dims[:1] != ("time",) or undecided.all():
        return ""
    times = problem.times[problem.checked] * problem.units.time
    last = int(np.flatnonzero(undecided)[-1])
    if not undecided[: last + 1].all():
        return f"at {undecided.sum()} of {len(times)} times"
    return f"{'up to' if last else 'at'} t = {times[last]:.3g}"


def remedy(problem: Problem, quantity: str, blamed: str, error: float) -> str:
    """Return what would decide a quantity: an accuracy to ask for, other sizes, or other times."""
    rtol = problem.rtol**2 / error
    if blamed == "fem" and problem.fem.far_field == "fixed":
        return "the clamped boundary errs by 1.1 a/R; far_field = 'boussinesq' does not"
    if reason := unresolved(problem, quantity, blamed):
        return reason
    if blamed == "mdr-grid":
        return f"{blamed} is of first order; give a finer accuracy.mdr.grid"
    if problem.sizes_given(blamed):
        return f"the sizes given for {blamed} are too coarse; leave them out"
    if problem.march != "modal":
        return "the step is too long; march = 'modal' has none"
    if rtol < FINEST:
        return f"{blamed} states {error:.1e}; no accuracy that can be asked for decides it"
    return f"{blamed} states {error:.1e}; rtol = {rtol:.0e} would decide it"


def overall(rows: Sequence[Agreement]) -> str:
    """Return the least verdict of what is promised; what is not can still disagree."""
    if any(row.verdict == DISAGREE for row in rows):
        return DISAGREE
    undecided = any(row.verdict == UNDECIDED for row in rows if row.promised)
    return UNDECIDED if undecided else AGREE


def by_quantity(rows: Sequence[Agreement]) -> dict[str, Agreement]:
    """Return of each quantity the two methods whose difference says most."""
    order = (AGREE, UNDECIDED, DISAGREE)
    ordered = sorted(rows, key=lambda row: (order.index(row.verdict), row.difference))
    worst = {row.quantity: row for row in ordered}
    return {name: worst[name] for name in QUANTITIES if name in worst}
