"""Modes that punches share which differ in wear alone: found, and checked.

A few histories, solved whole, span all others; on one more it is seen what the span leaves out.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES, ENERGIES, QUANTITIES
from ..wear.full_contact import RunningIn
from ..wear.shared_modes import SharedModes
from .norms import Results, differences

# part of the accuracy asked for that directions which histories hardly take are below
LEFT_OUT = 2e-3


@dataclass(frozen=True, eq=False)
class Together:
    """Modes that punches share.

    Parameters
    ----------
    modes : on a compliance, and on a coarser one
    left_out : what they leave out of the wear rate of the punch that they were checked on
    errors : by which they miss each quantity of that punch, the greatest over time
    """

    modes: tuple[SharedModes, SharedModes]
    left_out: float
    errors: dict[str, Array]

    def lost(self, wear: RunningIn, problem: Problem) -> dict[str, Array]:
        """Return what a punch's quantities may miss.

        It is as much more than what was missed where it was checked as more is left out of its wear
        rate, with a factor of safety.
        """
        left_out = wear.left_out(_looked_at(problem))
        factor = 2.5 * max(1.0, left_out / max(self.left_out, np.finfo(float).eps))
        # fields take the directions left out as they are, energies their square
        return {
            name: factor * error + (0.0 if name in ENERGIES else LEFT_OUT * problem.rtol)
            for name, error in self.errors.items()
            if problem.wants(name) or name == "indentation"
        }

    def negligible(self, lost: Mapping[str, Array], rtol: float) -> bool:
        """Return whether that is a small part of the accuracy asked for."""
        return all(
            float(np.max(np.atleast_1d(error)[:COMPARED_MODES])) <= 0.25 * rtol
            for error in lost.values()
        )


class Evaluated(Protocol):
    """A flat punch, worn on a compliance."""

    wear: RunningIn

    @property
    def for_estimate(self) -> Results:
        """Its quantities, on the face of the punch."""


def worn_together(
    problems: Sequence[Problem],
    compliances: tuple[Compliance, Compliance],
    evaluate: Callable[..., Evaluated],
) -> Together | None:
    """Return modes for punches that differ in wear alone, or None if that is no gain.

    Parameters
    ----------
    problems : on the same ring edges
    compliances : fine and coarser
    evaluate : (problem, compliance, shared=None) -> the punch worn, by its own modes or shared ones
    """
    compliance, coarser = compliances
    earliest, rtol = (
        min(problem.earliest for problem in problems),
        min(problem.rtol for problem in problems),
    )
    whole = _solved_whole(problems)
    logs = _logs(problems)
    if not (whole and RunningIn(compliance, np.exp(logs[0]), earliest).gentle):
        return None
    materials = np.unique(logs, axis=1, return_inverse=True)[1].ravel()
    # histories are followed from long before the first of the times, in steps of the root of two
    first, last = earliest / 1000, 2 * max(problem.times[-1] for problem in problems)
    times = np.geomspace(first, last, 2 * int(np.log2(last / first)) + 3)
    rates = [evaluate(problems[number], compliance).wear.rates(times) for number in whole]
    for _ in range(3):
        number = _farthest(logs, whole)[0]
        problem = replace(problems[number], quantities=None)
        span = SharedModes.spanned(compliance, materials, np.column_stack(rates), LEFT_OUT * rtol)
        exact = evaluate(problem, compliance)
        shared = evaluate(problem, compliance, shared=span)
        errors = _greatest(differences(shared.for_estimate, exact.for_estimate, problem.face))
        modes = span.on(compliance), span.on(coarser)
        together = Together(modes, shared.wear.left_out(_looked_at(problem)), errors)
        if together.negligible(together.lost(shared.wear, problems[number]), rtol):
            return together
        whole.append(number)
        rates.append(exact.wear.rates(times))
    return None


def _greatest(missed: dict[str, Array]) -> dict[str, Array]:
    """Return the greatest difference over time of each quantity."""
    errors = {}
    for name in missed:
        # the greatest over the punch, not at a point of it, where it may cross zero
        error = missed["displacement" if QUANTITIES[name].norm == "indentation" else name]
        errors[name] = error if "mode" in QUANTITIES[name].dims else error.max()
    return errors


def _solved_whole(problems: Sequence[Problem]) -> list[int]:
    """Return numbers of the punches that span the others; none if that is no gain.

    One of them is within half an order of magnitude in wear ratio of each.
    """
    singly = (
        problem.loading.varies or problem.indentation is not None or problem.merged.linear
        for problem in problems
    )
    if any(singly) or not all(
        problem.earliest and problem.march == "modal" for problem in problems
    ):
        return []
    logs, numbers = _logs(problems), [0]
    while (farthest := _farthest(logs, numbers))[1] > np.log(10) / 2 * 1.01:
        numbers.append(farthest[0])
    few_materials = len(np.unique(logs, axis=1)[0]) <= 8
    return numbers if few_materials and len(problems) >= 2 * (len(numbers) + 1) else []


def _logs(problems: Sequence[Problem]) -> Array:
    return np.log([problem.merged.wear_coefficients for problem in problems])


def _looked_at(problem: Problem) -> Array:
    """Return times to look at what is left out, which changes slowly."""
    return problem.estimate_times[problem.estimate_times > 0][::4]


def _farthest(points: Array, numbers: list[int]) -> tuple[int, float]:
    """Return the point farthest from some, and how far it is.

    What all coordinates have in common does not count.
    """
    distances = np.ptp(points[:, None] - points[None, numbers], axis=2).min(axis=1)
    return int(distances.argmax()), float(distances.max())
