"""Quantities whose accuracy is not promised at some times, with the reason.

The reasons are known before a run. A quantity is left out of the promise only at times at which
there is a reason and a method's error estimate is larger than allowed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..problem.unit_names import UnitNames
from ..sizes.degrees import field_accuracy
from ..sizes.ring_edges import (
    ELEMENTS_PER_THIN_LAYER,
    ROUNDOFF_MARGIN,
    amplified_roundoff,
    edge_sizes,
)


class Limit(NamedTuple):
    """A reason for which the accuracy of a quantity cannot be promised.

    Parameters
    ----------
    cause : the reason in a few words, which begin with "where" or "while"
    reason : the reason in full, with a remedy
    """

    cause: str
    reason: str


MOVING_EDGES = "while edges of the contact move"
THIN_LAYERS = "while the layers that wear has made are thin"
# why an RMS slope is not a number
SLOPE_IS_INFINITE = Limit(
    "where the slope of the face is infinite",
    "the slope of the unworn part of the face is infinite at a ring edge, at the rim or at a kink, "
    "and its root mean square has no finite value; choose times at which that part has worn, or "
    "another profile",
)
# error that each method may state, relative to rtol, by whether the punch is in full contact: under
# contact that moves, half of the uncertainty that the difference of two methods may have
ALLOWED_OVER_RTOL = {True: 1.0, False: 2.0}
# number of quantities that the verdict names, of those that are left out at the same times
MOST_NAMES = 4


@dataclass(frozen=True)
class LeftOut:
    """A quantity that is not promised at some times.

    Parameters
    ----------
    quantity : its name
    times : times in the scene's unit; empty if the quantity has no times
    reason : the reason and a remedy
    cause : the reason in a few words, which begin with "where" or "while"; empty in summaries of
        earlier versions
    """

    quantity: str
    times: tuple[float, ...]
    reason: str
    cause: str = ""


def allowed_error(problem: Problem) -> float:
    """Return the largest error estimate with which methods can agree, relative."""
    return problem.rtol * ALLOWED_OVER_RTOL[problem.full_contact]


def unresolved(
    problem: Problem, quantity: str, solutions: Mapping[str, Solution], at: int = 0
) -> Limit | None:
    """Return why the accuracy of a quantity is not promised; None if it is.

    Parameters
    ----------
    problem : the problem with all its times
    quantity : its name
    solutions : solutions by the names of the methods, whose smallest elements count
    at : index of the compared time, if the quantity has times
    """
    if quantity == "rms_slope" and any(
        np.isnan(solution.compared[quantity][at])
        for solution in solutions.values()
        if quantity in solution.compared
    ):
        return SLOPE_IS_INFINITE
    if not problem.full_contact:
        return _limit_of_cells(problem, solutions) if DESCRIBED[quantity].cells else None
    # earlier times, which need smaller elements, have no influence
    first = int(problem.compared_rows[at]) if DESCRIBED[quantity].over_time else 0
    if quantity in LAYER_QUANTITIES:
        needed_size = _smallest_wanted(problem, first)
        for method, solution in solutions.items():
            if needed_size < ELEMENTS_PER_THIN_LAYER * solution.smallest:
                return Limit(
                    THIN_LAYERS,
                    "the layers that wear has made by then need elements of "
                    f"{needed_size:.0e} a, but the smallest elements of {method} are "
                    f"{solution.smallest:.0e} a; choose later times",
                )
    if quantity == "rms_slope":
        amplified = float(amplified_roundoff(problem)[first])
        for method, solution in solutions.items():
            roundoff = solution.slope_roundoff * amplified
            if roundoff > problem.rtol / ROUNDOFF_MARGIN:
                return Limit(
                    THIN_LAYERS,
                    f"roundoff of {method}, which is large for a nearly incompressible half-space, "
                    f"is about {roundoff:.0e} in the slopes of layers that are so thin; choose "
                    "later times or a larger rtol",
                )
    if quantity in ENERGIES:
        return None
    accuracy = _field_accuracy(problem, first)
    if accuracy > problem.rtol:
        return Limit(
            THIN_LAYERS,
            f"so many rings and so early times need more pressures than memory and time allow; "
            f"fields are therefore only resolved to {accuracy:.0e}; choose later times, a larger "
            "rtol, or fewer rings",
        )
    return None


def _limit_of_cells(problem: Problem, solutions: Mapping[str, Solution]) -> Limit:
    """Return why cells of the face limit the accuracy of fields, with a remedy."""
    evolutions = [each.evolution for each in solutions.values() if each.evolution]
    if evolutions and all(evolution.always_full for evolution in evolutions):
        return Limit(
            THIN_LAYERS,
            "the layers that wear has made by then are thin at ring edges and at the rim, and "
            "cells resolve them to the stated errors only; choose later times or a smaller rtol",
        )
    edges = "pressures may be infinite at edges"
    if problem.earliest:
        edges = "pressures jump at edges of worn faces that move"
    return Limit(
        MOVING_EDGES if problem.earliest else "where pressures may be infinite",
        f"{edges}, where fields are only known to a cell, at any rtol; forces, volumes and the "
        "indentation are not affected",
    )


# cached, because all quantities are checked at the same times
@lru_cache(maxsize=64)
def _smallest_wanted(problem: Problem, first: int) -> float:
    """Return the smallest element size, in punch radii, that times from `first` on need."""
    return float(edge_sizes(_from_time_on(problem, first)).min())


@lru_cache(maxsize=64)
def _field_accuracy(problem: Problem, first: int) -> float:
    """Return the relative accuracy to which fields are resolved at times from `first` on."""
    return field_accuracy(_from_time_on(problem, first))


def _from_time_on(problem: Problem, first: int) -> Problem:
    return replace(problem, times=problem.times[first:])


def left_out_of_promise(
    problem: Problem, solutions: Mapping[str, Solution], times: Sequence[float]
) -> list[LeftOut]:
    """Return the quantities that are not promised and whose error estimates are too large.

    Parameters
    ----------
    problem : the problem
    solutions : solutions by method
    times : all times of the scene, exactly as it gives them
    """
    rows, allowed = [], allowed_error(problem)
    names = {name for solution in solutions.values() for name in solution.errors}
    for quantity in (name for name in DESCRIBED if name in names):
        estimates = [
            np.atleast_1d(solution.compared_error(problem, quantity))
            for solution in solutions.values()
            if quantity in solution.errors
        ]
        count = min(map(len, estimates))
        estimates = [error[:count] for error in estimates]
        beyond = np.any([error > allowed for error in estimates], axis=0)
        if quantity not in ANSWER:
            # values that are not finite; numbers of the answer are NaN if they are not computed
            beyond |= np.isnan(estimates).any(axis=0)
        limits = {
            int(at): limit
            for at in np.flatnonzero(beyond)
            if (limit := unresolved(problem, quantity, solutions, int(at)))
        }
        if not limits:
            continue
        excluded_times: tuple[float, ...] = ()
        if DESCRIBED[quantity].over_time:
            compared = np.asarray(times)[problem.compared_rows]
            excluded_times = tuple(compared[list(limits)].tolist())
        first = next(iter(limits.values()))
        rows.append(LeftOut(quantity, excluded_times, first.reason, first.cause))
    return rows


def in_words(rows: Sequence[LeftOut], times: Sequence[float], names: UnitNames) -> str:
    """Say in sentences which quantities are left out, grouped by the cause and by the times.

    Parameters
    ----------
    rows : quantities that are left out
    times : all times of the scene
    names : units of the scene
    """
    rows_by_cause = {
        cause: [row for row in rows if row.cause == cause]
        for cause in dict.fromkeys(row.cause for row in rows)
    }
    return " ".join(
        f"Undecided {cause}".rstrip() + f"{_with_times(alike, times, names)}."
        for cause, alike in rows_by_cause.items()
    )


def _with_times(rows: Sequence[LeftOut], times: Sequence[float], names: UnitNames) -> str:
    """Return the names of quantities after a colon; their times are before it if all are equal."""
    names_by_times = dict[str, list[str]]()
    for row in rows:
        name = row.quantity.replace("_", " ").replace("rms", "RMS")
        when = f" {times_in_words(row.times, times, names)}" if row.times else ""
        names_by_times.setdefault(when, []).append(name)
    if len(names_by_times) > 1:
        return ": " + "; ".join(f"{_listed(each)}{when}" for when, each in names_by_times.items())
    ((when, quantities),) = names_by_times.items()
    return f"{when and ','}{when}: {_listed(quantities)}"


def share(count: int, of: int) -> str:
    """Return ``"2 of 3"``, ``"all 3"`` or ``"no"``, followed by a noun in the plural."""
    if not of:
        return "no"
    return f"all {of}" if count == of > 1 else f"{count} of {of}"


def _listed(names: list[str]) -> str:
    """Return names as a list in words; if there are many, only the first ones."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def times_in_words(
    selected: Sequence[float], times: Sequence[float], names: UnitNames, until: str = "until"
) -> str:
    """Return some of increasing times in words: how many of them, or the last if all before are."""
    last = selected[-1]
    if len(selected) < sum(time <= last for time in times):
        return f"at {len(selected)} of {len(times)} times"
    return f"{until if len(selected) > 1 else 'at'} t = {names.write(last, 'time', 3)}"
