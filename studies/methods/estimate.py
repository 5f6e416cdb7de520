"""What a method's results are worth, by its own account.

The difference to one coarser discretisation, times one factor.

The coarser one differs in everything (a degree, a layer at every singular point, a pole of the far
field), so that one difference holds all parts of the error. Differences cross zero now and then in
time, where they say nothing: the greatest within a factor of `NEAR` counts. The factor was chosen
on scenes drawn at random, and checked on others (`ringwear study estimates`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..wear.archard import RunningIn
from ..wear.shared_modes import SharedModes
from .quantities import (
    CHANCE,
    CHANCE_OF_ENERGIES,
    COMPARED_MODES,
    ENERGIES,
    QUANTITIES,
    array,
    common,
    differences,
    radial_weight,
)
from .sampler import Evaluation

NEAR = 2.5


# times the difference that errors are stated as; on triangles, whose degree is low, meshes of two
# sizes may miss the same
SAFETY, SAFETY_OF_TRIANGLES = 1.5, 8.0
# up to this degree of the pressure a greatest value is known no better than its field: their
# differences often vanish
LOW = 2
# fields that greatest values, and root mean square slopes, are taken from
OF_FIELD = {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}
SLOPES_OF = {"steady_rms_slope": "steady_profile"}
# fraction of d0 that the element at the rim costs the flat start, over its size (measured: .06 to
# .11)
AT_RIM = 0.2
# and that pressures of the start err by there, over its size: it moves the other functions that the
# start is sought among
START_AT_RIM = 3.0
# of the numbers of elements
ROUNDOFF = 1e-14
# logarithm of the wear ratio within which a history is solved whole, and times before the first
# that it is followed from; punches for each that is solved whole, so that sharing modes is a gain;
# materials at the most
REACH, BEFORE, GAIN, MOST_MATERIALS = np.log(10) / 2 * 1.01, 1000, 2, 8
# share of the accuracy that directions which histories hardly take are below
LEFT_OUT = 2e-3
# safety factor of what shared modes miss where they are checked, checks, and the part of the
# accuracy that they may miss
CHECKED, MOST_CHECKS, SMALL_PART = 4.0, 3, 0.25
# of the times of the estimate, those at which it is looked at what shared modes leave out: it
# changes slowly
LOOKED_AT = 4


@dataclass(frozen=True, eq=False)
class Estimate:
    """A compliance worn and sampled, and what that is worth.

    Parameters
    ----------
    result : the evaluation
    errors : relative, of each quantity in its norm; those over time at the times asked for
    parts : of the indentation, the greatest over all times, by what causes it
    """

    result: Evaluation
    errors: dict[str, Array]
    parts: dict[str, float]


@dataclass(frozen=True, eq=False)
class Together:
    """Modes that punches share which differ in wear alone.

    Parameters
    ----------
    modes : by the identity of each compliance
    left_out : what they leave out of the wear rate of the punch that they were checked on
    errors : by which they miss each quantity of that punch, the greatest over time
    """

    modes: dict[int, SharedModes]
    left_out: float
    errors: dict[str, Array]

    def lost(self, wear: RunningIn, problem: Problem) -> dict[str, Array]:
        """What a punch's quantities may miss.

        As much more than those checked as more is left out of its wear rate.
        """
        factor = CHECKED * max(
            1.0, wear.left_out(_looked_at(problem)) / max(self.left_out, np.finfo(float).eps)
        )
        # fields take the directions left out as they are, energies their square
        wanted = {
            name: error
            for name, error in self.errors.items()
            if problem.wants(name) or name == "indentation"
        }
        least = {name: 0.0 if name in ENERGIES else LEFT_OUT * problem.rtol for name in wanted}
        return {name: least[name] + factor * error for name, error in wanted.items()}

    def negligible(self, lost: dict[str, Array], rtol: float) -> bool:
        """Whether that is a small part of the accuracy asked for."""
        return all(
            float(np.max(np.atleast_1d(error)[:COMPARED_MODES])) <= SMALL_PART * rtol
            for error in lost.values()
        )


def worn_together(
    problems: Sequence[Problem], compliance: Compliance, coarser: Compliance
) -> Together | None:
    """Modes for punches that differ in wear alone, by histories of a few and checked on another.

    None if that is no gain.
    """
    first, rtol = min(one.earliest for one in problems), min(one.rtol for one in problems)
    logs, whole = _logs(problems), solved_whole(problems)
    if not (whole and RunningIn(compliance, np.exp(logs[0]), first).gentle):
        return None
    materials = np.unique(logs, axis=1, return_inverse=True)[1].ravel()
    first, last = first / BEFORE, 2 * max(one.times[-1] for one in problems)
    times = np.geomspace(first, last, 2 * int(np.log2(last / first)) + 3)
    rates = [Evaluation(problems[number], compliance).wear.rates(times) for number in whole]
    for _ in range(MOST_CHECKS):
        number = _farthest(logs, whole)[0]
        checked = replace(problems[number], quantities=None)
        shared = SharedModes.spanned(compliance, materials, np.column_stack(rates), LEFT_OUT * rtol)
        known = Evaluation(checked, compliance)
        found = Evaluation(checked, compliance, shared)
        missed = differences(found.for_estimate, known.for_estimate, checked.face)
        # the greatest over the punch, not at a point of it, where it may cross zero
        errors = {
            name: missed["displacement" if QUANTITIES[name].norm == "indentation" else name]
            for name in missed
        }
        errors = {
            name: error if "mode" in QUANTITIES[name].dims else error.max()
            for name, error in errors.items()
        }
        together = Together({}, found.wear.left_out(_looked_at(checked)), errors)
        if together.negligible(together.lost(found.wear, problems[number]), rtol):
            return replace(
                together, modes={id(one): shared.on(one) for one in (compliance, coarser)}
            )
        whole.append(number)
        rates.append(known.wear.rates(times))
    return None


def solved_whole(problems: Sequence[Problem]) -> list[int]:
    """Numbers of the punches that span the others, one within `REACH` of each.

    None if that is no gain.
    """
    if not all(one.earliest and one.march == "modal" for one in problems):
        return []
    logs, found = _logs(problems), [0]
    while (farthest := _farthest(logs, found))[1] > REACH:
        found.append(farthest[0])
    few = len(np.unique(logs, axis=1)[0]) <= MOST_MATERIALS and len(problems) >= GAIN * (
        len(found) + 1
    )
    return found if few else []


def _logs(problems: Sequence[Problem]) -> Array:
    return np.log([one.merged.wear_coefficients for one in problems])


def _looked_at(problem: Problem) -> Array:
    return problem.estimate_times[problem.estimate_times > 0][::LOOKED_AT]


def _farthest(points: Array, found: list[int]) -> tuple[int, float]:
    """The point farthest from some, and how far it is.

    What all coordinates have in common does not count.
    """
    distances = np.ptp(points[:, None] - points[None, found], axis=2).min(axis=1)
    return int(distances.argmax()), float(distances.max())


def estimated(
    problem: Problem,
    compliance: Compliance,
    coarser: Compliance,
    together: Together | None = None,
    safety: float = SAFETY,
) -> Estimate:
    """Evaluate a compliance, and state errors by a coarser one."""
    result, other = (
        Evaluation(problem, one, together.modes[id(one)] if together else None)
        for one in (compliance, coarser)
    )
    roundoff = ROUNDOFF * len(compliance.space.breakpoints)
    found = differences(other.for_estimate, result.for_estimate, problem.face)
    errors = {}
    for name, difference in found.items():
        least = problem.rtol * (CHANCE_OF_ENERGIES if name in ENERGIES else CHANCE)
        errors[name] = np.maximum(
            safety * at_times(problem, name, difference), max(least, roundoff)
        )
    errors |= {
        name: np.maximum(errors[name], safety * part)
        for name, part in _squares_of_slopes(
            problem, other.for_estimate, result.for_estimate
        ).items()
    }
    for greatest, field in OF_FIELD.items() if compliance.space.top <= LOW else ():
        if greatest in errors and field in errors:
            errors[greatest] = np.maximum(errors[greatest], errors[field])
    parts = {"discretisation": safety * float(np.max(found.get("indentation", 0.0)))}
    start = problem.times == 0
    if "indentation" in errors and start.any():
        size = float(np.diff(compliance.space.breakpoints)[-1])
        # the width of the element at the rim is known to roundoff, with the force that it carries,
        # the root of its width
        unknown = float(np.finfo(float).eps / np.sqrt(size))
        at_rim = {
            "indentation": AT_RIM * size + 0.1 * unknown,
            "pressure": START_AT_RIM * size + unknown,
            "ring_force": unknown,
        }
        for name in at_rim.keys() & errors.keys():
            errors[name] = np.maximum(errors[name], np.where(start, at_rim[name], 0.0))
    if together:
        lost = together.lost(result.wear, problem)
        if not together.negligible(lost, problem.rtol):
            return estimated(problem, compliance, coarser, safety=safety)
        errors |= {name: _added(errors[name], lost[name]) for name in errors.keys() & lost.keys()}
        parts["shared modes"] = float(lost.get("indentation", 0.0))
    if "indentation" in errors and problem.march != "modal":
        exact = result.sampler.history(result.wear.modal(problem.times), on_face=True)
        steps = differences(
            result.sampler.history(result.marched, on_face=True), exact, problem.face
        )
        errors |= {name: errors[name] + step for name, step in steps.items()}
        parts["time step"] = float(steps["indentation"].max())
    return Estimate(result, errors, parts)


def _squares_of_slopes(
    problem: Problem, coarse: xarray.Dataset, fine: xarray.Dataset
) -> dict[str, Array]:
    """Return the mean square of the difference of slopes over that of slopes, for each root mean
    square slope.

    Roots of mean squares may differ by less, where the difference happens to be orthogonal to the
    slope.
    """
    face, found = problem.face, {}
    weights = face.lengths * radial_weight(face.radii, problem.gradient_average)
    for name, field in SLOPES_OF.items():
        if name not in fine or field not in fine:
            continue
        profile = array(fine, field)
        slopes, wrong = (
            face.slopes(one)[0] ** 2 @ weights for one in (profile, profile - array(coarse, field))
        )
        share = np.divide(wrong, slopes, out=np.zeros_like(wrong), where=slopes > 0)
        found[name] = at_times(problem, name, share)
    return found


def at_times(problem: Problem, name: str, error: Array) -> Array:
    """The error of a quantity at each time asked for, by those at the times of the estimate.

    The greatest near it.
    """
    if QUANTITIES[name].dims[:1] != ("time",):
        return error
    grid = problem.estimate_times
    within = (grid >= problem.times[:, None] / NEAR) & (grid <= problem.times[:, None] * NEAR)
    return np.asarray(np.where(within, error, 0.0).max(axis=1))


def _added(one: Array, other: Array) -> Array:
    """The sum of two parts of an error."""
    if not other.shape:
        return one + other
    known = common(one.shape, other.shape)
    return np.asarray(one[known] + other[known])
