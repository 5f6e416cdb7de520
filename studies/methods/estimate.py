"""What a method's results are worth, by its own account: finer against coarser computations, and safety factors.

One rule for every quantity at every time: its error is the sum, over pairs of computations that differ in one thing (a
degree and a layer of the mesh, the highest pressure bubbles, the last far-field pole), of their difference times a safety
factor. Differences cross zero now and then in time, where they say nothing: the greatest within a factor of `NEAR` counts.
Energies converge twice as fast as fields, and slopes, whose squares are summed, on their own: each kind of pair has a
factor for each. The factors were chosen on scenes drawn at random, and checked on others (`ringwear study estimates`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.radial import Array
from ringwear.studies.methods.quantities import COMPARED_MODES, ENERGIES, QUANTITIES, common, differences
from ringwear.studies.methods.sampler import Evaluation
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.sections import FemAccuracy
from ringwear.studies.wear.archard import RunningIn
from ringwear.studies.wear.shared_modes import SharedModes

NEAR = 2.5


class Safety(NamedTuple):
    """Safety factors: of energies, which converge twice as fast, of everything else, of RMS slopes, and of the steady one.

    In the steady state pressures jump at every ring edge, which high degrees feel in slopes.
    """

    energies: float
    fields: float
    slopes: float
    steady_slope: float

    def of(self, quantity: str) -> float:
        if quantity in ENERGIES:
            return self.energies
        return {"rms_slope": self.slopes, "steady_rms_slope": self.steady_slope}.get(quantity, self.fields)


# on the radial mesh: one degree less; one layer less at every singular point, which only slopes feel
RADIAL, LAYERS = Safety(1.0, 1.6, 0.65, 1.3), Safety(0.7, 0.5, 1.2, 2.4)
# where nothing is left to coarsen, the pair is finer than the result, and the difference the error itself
RADIAL_FINER = Safety(1.5, 2.0, 3.0, 3.0)
# of finite elements: one degree of the pressure less; then one degree of the displacement (and a layer) less
QUAD_MULTIPLIERS, QUADS = Safety(0.1, 1.4, 0.7, 1.4), Safety(1.5, 1.9, 1.0, 2.0)
TRIANGLE_MULTIPLIERS, TRIANGLES = Safety(20.0, 2.0, 18.0, 18.0), Safety(12.0, 1.0, 18.0, 18.0)
TRIANGLES_FINER = Safety(2.0, 3.0, 12.0, 12.0)
# times more that fields err on P3 than P4 says
CUBIC = 4.0
# with half the springs and twice the step, what is of first order doubles; slopes and jumps at ring edges are of half that
GRID = Safety(1.5, 2.5, 2.5, 2.5)
# fraction of d0 that the element at the rim costs, over its size and times its degree: it cannot hold a pressure that is
# infinite. Measured for degree 1, 2, 4 and 7: 0.05, 0.023, 0.009 and 0.004
AT_RIM = 0.055
# and that pressures of the start err by there, over its size: it moves the other functions that the start is sought among
START_AT_RIM = 8.0
# up to this degree of the pressure a greatest value is known no better than its field: their differences often vanish
LOW, OF_FIELD = 2, {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}
# of the numbers of elements
ROUNDOFF = 1e-14
# part of the accuracy asked for that energies, and everything else, are not known better than: where two computations differ
# by less, it may be by chance
CHANCE_OF_ENERGIES, CHANCE = 1e-4, 0.02
# times roundoff over the root of the smallest size that slopes by finite elements err by: measured from 1e-10 to 1e-12
ROUNDOFF_OF_ELEMENTS = {"rms_slope": 2600.0, "steady_rms_slope": 260.0}
# logarithm of the wear ratio within which a history is solved whole, and times before the first that it is followed from;
# punches for each that is solved whole, so that sharing modes is a gain; materials at the most
REACH, BEFORE, GAIN, MOST_MATERIALS = np.log(10) / 2 * 1.01, 1000, 2, 8
# share of the accuracy that directions which histories hardly take are below
LEFT_OUT = 2e-3
# safety factor of what shared modes miss where they are checked, checks, and the part of the accuracy that they may miss
CHECKED, MOST_CHECKS, SMALL_PART = 4.0, 3, 0.25
# of the times of the estimate, those at which it is looked at what shared modes leave out: it changes slowly
LOOKED_AT = 4


def of_triangles(degree: int, growth: float, safety: Safety) -> Safety:
    """On finer triangles one degree less costs ever more: of a difference in energy, less remains."""
    energies = safety.energies * min(1.0, (growth / 0.75) ** 3)
    return safety._replace(energies=energies, fields=safety.fields * (CUBIC if degree == 3 else 1.0))


def of_truncation(chosen: FemAccuracy, truncation: float) -> Safety:
    """Each pole takes the truncation error down by four orders in a/R (`ringwear study truncation`)."""
    factor = 1.1 if chosen.far_field == "fixed" else 8 / truncation**4
    return Safety(factor, factor, factor, factor)


@dataclass(frozen=True, eq=False)
class Pair:
    """A finer and a coarser computation, whose difference estimates one part of the error.

    Parameters
    ----------
    part : what differs
    finer, coarser : the pair
    safety : factors on their difference
    """

    part: str
    finer: Compliance
    coarser: Compliance
    safety: Safety


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
        """What a punch's quantities may miss: as much more than those checked as more is left out of its wear rate."""
        factor = CHECKED * max(1.0, wear.left_out(_looked_at(problem)) / max(self.left_out, np.finfo(float).eps))
        # fields take the directions left out as they are, energies their square
        wanted = {name: error for name, error in self.errors.items() if problem.wants(name) or name == "indentation"}
        least = {name: 0.0 if name in ENERGIES else LEFT_OUT * problem.rtol for name in wanted}
        return {name: least[name] + factor * error for name, error in wanted.items()}

    def negligible(self, lost: dict[str, Array], rtol: float) -> bool:
        """Whether that is a small part of the accuracy asked for."""
        return all(float(np.max(np.atleast_1d(error)[:COMPARED_MODES])) <= SMALL_PART * rtol for error in lost.values())


def worn_together(problems: Sequence[Problem], compliance: Compliance, pairs: tuple[Pair, ...]) -> Together | None:
    """Modes for punches that differ in wear alone, by histories of a few and checked on another; None if that is no gain."""
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
        errors = {name: missed["displacement" if QUANTITIES[name].norm == "indentation" else name] for name in missed}
        errors = {name: error if "mode" in QUANTITIES[name].dims else error.max() for name, error in errors.items()}
        together = Together({}, found.wear.left_out(_looked_at(checked)), errors)
        if together.negligible(together.lost(found.wear, problems[number]), rtol):
            every = (compliance, *(one for pair in pairs for one in (pair.finer, pair.coarser)))
            return replace(together, modes={id(one): shared.on(one) for one in every})
        whole.append(number)
        rates.append(known.wear.rates(times))
    return None


def solved_whole(problems: Sequence[Problem]) -> list[int]:
    """Numbers of the punches that span the others, one within `REACH` of each; none if that is no gain."""
    if not all(one.earliest and one.march == "modal" for one in problems):
        return []
    logs, found = _logs(problems), [0]
    while (farthest := _farthest(logs, found))[1] > REACH:
        found.append(farthest[0])
    few = len(np.unique(logs, axis=1)[0]) <= MOST_MATERIALS and len(problems) >= GAIN * (len(found) + 1)
    return found if few else []


def _logs(problems: Sequence[Problem]) -> Array:
    return np.log([one.merged.wear_coefficients for one in problems])


def _looked_at(problem: Problem) -> Array:
    return problem.estimate_times[problem.estimate_times > 0][::LOOKED_AT]


def _farthest(points: Array, found: list[int]) -> tuple[int, float]:
    """The point farthest from some, and how far it is; what all coordinates have in common does not count."""
    distances = np.ptp(points[:, None] - points[None, found], axis=2).min(axis=1)
    return int(distances.argmax()), float(distances.max())


def estimated(
    problem: Problem, compliance: Compliance, pairs: tuple[Pair, ...], together: Together | None = None
) -> Estimate:  # fmt: skip
    """Evaluate a compliance and its pairs."""
    cache: dict[int, Evaluation] = {}

    def evaluated(one: Compliance) -> Evaluation:
        if id(one) not in cache:
            cache[id(one)] = Evaluation(problem, one, together.modes[id(one)] if together else None)
        return cache[id(one)]

    result, roundoff = evaluated(compliance), ROUNDOFF * len(compliance.space.breakpoints)
    errors: dict[str, Array] = {}
    parts: dict[str, float] = {}
    for pair in pairs:
        found = differences(evaluated(pair.coarser).for_estimate, evaluated(pair.finer).for_estimate, problem.face)
        for name, difference in found.items():
            part = pair.safety.of(name) * at_times(problem, name, difference)
            least = problem.rtol * (CHANCE_OF_ENERGIES if name in ENERGIES else CHANCE)
            if pair.part == "discretisation":
                size = float(np.diff(compliance.space.breakpoints).min())
                of_elements = np.finfo(float).eps / np.sqrt(size)
                least = max(least, ROUNDOFF_OF_ELEMENTS.get(name, 0.0) * of_elements)
            errors[name] = np.maximum(_added(errors.get(name, np.zeros(part.shape)), part), max(roundoff, least))
        parts[pair.part] = pair.safety.energies * float(np.max(found.get("indentation", 0.0)))
    for greatest, field in OF_FIELD.items() if compliance.space.top <= LOW else ():
        if greatest in errors and field in errors:
            errors[greatest] = np.maximum(errors[greatest], errors[field])
    start = problem.times == 0
    if "indentation" in errors and start.any():
        size, degree = float(np.diff(compliance.space.breakpoints)[-1]), int(compliance.space.degrees[-1])
        # the width of the element at the rim is known to roundoff, with the force that it carries, the root of its width
        unknown = float(np.finfo(float).eps / np.sqrt(size))
        at_rim = {
            "indentation": AT_RIM / degree * size,
            "pressure": START_AT_RIM * size + unknown,
            "ring_force": unknown,
        }
        for name in at_rim.keys() & errors.keys():
            errors[name] = np.maximum(errors[name], np.where(start, at_rim[name], 0.0))
    if together:
        lost = together.lost(result.wear, problem)
        if not together.negligible(lost, problem.rtol):
            return estimated(problem, compliance, pairs)
        errors |= {name: _added(errors[name], lost[name]) for name in errors.keys() & lost.keys()}
        parts["shared modes"] = float(lost.get("indentation", 0.0))
    if "indentation" in errors and problem.march != "modal":
        exact = result.sampler.history(result.wear.modal(problem.times), on_face=True)
        steps = differences(result.sampler.history(result.marched, on_face=True), exact, problem.face)
        errors |= {name: errors[name] + step for name, step in steps.items()}
        parts["time step"] = float(steps["indentation"].max())
    return Estimate(result, errors, parts)


def at_times(problem: Problem, name: str, error: Array) -> Array:
    """The error of a quantity at each time asked for, by those at the times of the estimate: the greatest near it."""
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
