"""What cannot be promised: quantities that are not resolved at some times, with the reason.

The reasons are known before a run. A quantity is left out of the promise only at times at which
there is a reason and a method states more than the accuracy asked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..sizes.degrees import field_accuracy
from ..sizes.ring_edges import ELEMENTS_PER_THIN_LAYER, edge_sizes

# with edges of the contact within the face, these are resolved to a cell, whatever the accuracy
AT_EDGES = (
    "pressure",
    "profile",
    "displacement",
    "displacement_centre",
    "displacement_max",
    "rms_slope",
    "contact_radius",
    "time_to_full_contact",
    "time_to_90",
    "time_to_99",
    "running_in_time",
)
# what rings share of cells that edges of the contact cross: refined, but not promised there
BY_CELLS = ("ring_force", "ring_worn_volume", "force_share", "worn_volume")
# quantities that the first line names, of those that are left out at the same times
MOST_NAMES = 4


@dataclass(frozen=True)
class LeftOut:
    """A quantity that is not promised at some times.

    Parameters
    ----------
    quantity : its name
    times : in the scene's unit; empty if it has none
    reason : why, and what would help
    """

    quantity: str
    times: tuple[float, ...]
    reason: str


def allowed_error(problem: Problem) -> float:
    """Return the error that each method may state."""
    return problem.rtol * problem.contact.allowed_over_rtol


def unresolved(
    problem: Problem, quantity: str, solutions: Mapping[str, Solution], at: int = 0
) -> str:
    """Return why the accuracy is not promised of a quantity; empty if it is.

    Parameters
    ----------
    problem : with all its times
    quantity : its name
    solutions : of the methods that are asked, by name
    at : which of the compared times, if the quantity has times
    """
    if not problem.full_contact:
        edges = "pressures may be infinite at edges"
        if problem.earliest:
            edges = "pressures jump at edges of worn faces that move"
        words = f"{edges}, and fields are known to a cell there; ask for a smaller rtol"
        return words if quantity in (*AT_EDGES, *BY_CELLS) else ""
    # what is asked for before is not felt any more
    first = int(problem.checked[at]) if DESCRIBED[quantity].dims[:1] == ("time",) else 0
    if quantity in LAYER_QUANTITIES:
        wanted = _smallest_wanted(problem, first)
        for method, solution in solutions.items():
            if wanted < ELEMENTS_PER_THIN_LAYER * solution.smallest:
                return (
                    f"elements of {wanted:.0e} a would resolve the layers that wear has made by "
                    f"then, and the smallest of {method} are {solution.smallest:.0e} a; ask for "
                    "later times"
                )
    if quantity in ENERGIES:
        return ""
    accuracy = _field_accuracy(problem, first)
    if accuracy > problem.rtol:
        return (
            f"so many rings and so early times would take more pressures than memory and time "
            f"allow, so that fields are resolved to {accuracy:.0e} only; ask for later times, a "
            "larger rtol, or fewer rings"
        )
    return ""


# all quantities are asked for at the same times, most of which are few
@lru_cache(maxsize=64)
def _smallest_wanted(problem: Problem, first: int) -> float:
    """Return the smallest wanted element size from one of the times on."""
    return float(edge_sizes(_from_time_on(problem, first)).min())


@lru_cache(maxsize=64)
def _field_accuracy(problem: Problem, first: int) -> float:
    """Return the relative accuracy that fields are resolved to from one of the times on."""
    return field_accuracy(_from_time_on(problem, first))


def _from_time_on(problem: Problem, first: int) -> Problem:
    return replace(problem, times=problem.times[first:])


def left_out_of_promise(problem: Problem, solutions: Mapping[str, Solution]) -> list[LeftOut]:
    """Return the quantities that are not promised, where a method states more than is allowed."""
    rows, allowed = [], allowed_error(problem)
    names = {name for solution in solutions.values() for name in solution.errors}
    for quantity in (name for name in DESCRIBED if name in names):
        stated = [
            np.atleast_1d(solution.checked_error(problem, quantity))
            for solution in solutions.values()
            if quantity in solution.errors
        ]
        count = min(map(len, stated))
        beyond = np.any([error[:count] > allowed for error in stated], axis=0)
        reasons = {
            int(at): reason
            for at in np.flatnonzero(beyond)
            if (reason := unresolved(problem, quantity, solutions, int(at)))
        }
        if not reasons:
            continue
        times: tuple[float, ...] = ()
        if DESCRIBED[quantity].dims[:1] == ("time",):
            compared = problem.times[problem.checked] * problem.units.time
            times = tuple(compared[list(reasons)].tolist())
        rows.append(LeftOut(quantity, times, next(iter(reasons.values()))))
    return rows


def in_words(rows: Sequence[LeftOut], times: Sequence[float]) -> str:
    """Say in words what is left out, those quantities together that are left out at the same times.

    Parameters
    ----------
    rows : what is left out
    times : all times of the scene
    """
    together = dict[tuple[float, ...], list[str]]()
    for row in rows:
        name = row.quantity.replace("_", " ").replace("rms", "RMS")
        together.setdefault(row.times, []).append(name)
    return "; ".join(f"{_listed(names)}{_when(some, times)}" for some, names in together.items())


def _listed(names: list[str]) -> str:
    """Return names as a list in words, the first of many."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _when(some: tuple[float, ...], times: Sequence[float]) -> str:
    """Return some of the times of a scene in words."""
    if not some:
        return ""
    before = [time for time in times if time <= some[-1]]
    if len(some) < len(before):
        return f" at {len(some)} of {len(times)} times"
    return f" {'up to' if len(some) > 1 else 'at'} t = {some[-1]:.3g}"
