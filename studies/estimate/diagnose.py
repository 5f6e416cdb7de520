"""Explain the difference of another program's results to ours by mistakes, in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes import Array
from ..crosscheck import FIELDS, QUANTITIES, UnitNames
from .compared import Comparison
from .measurement import Measurement
from .mesh_patterns import PATTERNS, patterns
from .mistakes import LENGTHS, mistakes, named, sentence
from .model import Model
from .select import (
    BIAS,
    MIN_EFFECT,
    NEAR,
    NOISE,
    USUAL_ERROR,
    Candidate,
    Mistake,
    left_out,
    select,
    shares,
)

# tolerance of the model: errors of other programs are greater
RTOL = 1e-2
# relative difference of two predictions below which they count as alike
MAX_ALIKE_DIFFERENCE = 0.02
# least share of a mistake that is named, and least share of a more special one that gives its name
# to both of two that predict the same
MIN_SHARE, SPECIAL_SHARE = 0.15, 1 / 3
# least part of the errors of pressures that a pattern of a mesh has to be
SURE = 0.7
# factor on the errors of pressures above which those of another quantity are not caused by a mesh
OTHERS_FACTOR = 3.0
# least `explained_part` of an explanation: it leaves at most a sixth of the difference
MIN_EXPLAINED = 0.7
# least relative difference of two predictions at which a result can distinguish them
MIN_DISTINCTION = 0.05
# factor on the prior odds of mistakes that a deck by `ringwear deck` does not have, unless it was
# changed
DOUBT_OF_DECKS = 0.01
EXPLAINS, EQUALLY, CONSISTENT = "explains", "explain equally well", "is consistent with"
"""What is said about a mistake and the difference of two results."""


@dataclass(frozen=True)
class Diagnosis:
    """A mistake that may have been made.

    Parameters
    ----------
    name : of the mistake; empty if none that is known explains the difference
    size : number that describes the mistake, such as a factor
    low, high : ends of its 95 % interval, if the mistake was made; NaN if it has no fitted number
    share : of the mistake among all that are known (`select.shares`), times the square of the part
        of the difference that it explains, with the others that are made with it; no probability
    judgement : "explains": known candidates without the mistake are much worse, and little
        remains; "explain equally well": so does a rival; otherwise "is consistent with"
    looks_like : what the difference looks like, with the number, as a noun phrase
    remaining : relative difference that remains with this mistake and those made with it
    rival : another mistake that explains as much; empty if there is none
    confirm : what would confirm the mistake, or distinguish it from the rival
    program : whose results have the difference
    """

    name: str
    size: float
    low: float
    high: float
    share: float
    judgement: str
    looks_like: str
    remaining: float
    rival: str
    confirm: str
    program: str = ""

    @property
    def words(self) -> str:
        """All of this in a sentence."""
        if not self.name:
            return f"no mistake that we know explains the difference: {self.confirm}"
        interval = "" if np.isnan(self.low) else f" (95 %: {self.low:.4g} to {self.high:.4g})"
        if self.judgement == EQUALLY:
            return (
                f"{self.looks_like}{interval}: this and {self.rival} explain the difference "
                f"equally well. To decide: {self.confirm}"
            )
        remains = f" (what remains is {100 * self.remaining:.2g} %)"
        return (
            f"{self.looks_like}{interval}, which {self.judgement} the difference{remains}. To "
            f"confirm: {self.confirm}"
        )


def diagnose(comparison: Comparison, deck_reach: float | None = None) -> list[Diagnosis]:
    """Return the mistakes that may have caused the difference, that with the highest share first.

    Parameters
    ----------
    comparison : results of the other program and ours
    deck_reach : radius of the half-space, in punch radii, if the program has solved a deck of this
        scene by `ringwear deck`: then errors of the mesh are far likelier than wrong inputs

    Returns
    -------
    list of Diagnosis
        Empty if nothing that is known explains the difference, or if it is below the `rtol` of the
        scene. What cannot be computed is left out, with a warning.
    """
    if not comparison.quantities or _greatest_error(comparison) <= comparison.scene.accuracy.rtol:
        return []
    # the matrices are so small that several threads would only wait for each other
    with threadpool_limits(1), left_out("every mistake"):
        return _ranked(comparison, deck_reach)
    return []


def _ranked(comparison: Comparison, deck_reach: float | None) -> list[Diagnosis]:
    """Return the diagnoses of a difference that is above the `rtol` of the scene."""
    rows = mistakes(comparison)
    if deck_reach is not None:
        rows = [
            each if each.of_mesh else replace(each, prior=DOUBT_OF_DECKS * each.prior)
            for each in rows
        ]
    candidates = select(model_of(comparison), rows)
    diagnoses = _diagnoses(candidates, comparison)
    if deck_reach is not None:
        diagnoses = [part for each in diagnoses for part in _split_by_reach(each, deck_reach)]
    named_mistakes = {each.name for each in diagnoses}
    with left_out("the mesh"):
        patterns = _patterns_of_mesh(candidates, comparison)
        diagnoses += [each for each in patterns if each.name not in named_mistakes]
    return sorted(diagnoses, key=lambda each: -each.share)


def _patterns_of_mesh(candidates: Sequence[Candidate], comparison: Comparison) -> list[Diagnosis]:
    """Return the patterns of a mesh in the pressures that the best candidate does not explain."""
    if "pressure" not in comparison.quantities:
        return []
    theirs = comparison.theirs["pressure"][comparison.time_rows]
    ours = comparison.ours["pressure"][comparison.time_rows]
    (none,) = (each for each in candidates if not each.mistakes)
    others = [
        error
        for name, error in zip(comparison.quantities, candidates[0].errors, strict=True)
        if name != "pressure"
    ]
    explained, as_it_is = (_pressures(each, comparison) for each in (candidates[0], none))
    errors = _relative_errors(theirs, ours)
    with np.errstate(all="ignore"):
        unexplained_errors = _relative_errors(theirs, ours * (explained / as_it_is))
    # the part of the errors that mistakes explain is not caused by the mesh
    norms = float(np.linalg.norm(unexplained_errors)), float(np.linalg.norm(errors) or 1.0)
    remaining = min(1.0, norms[0] / norms[1])
    return [
        Diagnosis(
            name,
            size,
            np.nan,
            np.nan,
            remaining * part,
            EXPLAINS,
            PATTERNS[name][0].format(size),
            size * float(np.sqrt(max(0.0, 1 - part))),
            "",
            PATTERNS[name][1],
        )
        for name, size, part in patterns(
            unexplained_errors, comparison.radii, comparison.scene.punch.radius
        )
        if remaining * part > SURE
        and size > comparison.scene.accuracy.rtol
        # errors of pressures are not what is wrong if those of another column are much greater
        and max(others, default=0.0) < max(USUAL_ERROR, OTHERS_FACTOR * size)
    ]


def _pressures(candidate: Candidate, comparison: Comparison) -> Array:
    """Return the pressures (S, R) that a candidate predicts at their times and radii."""
    times, radii = comparison.times[comparison.time_rows], comparison.radii
    zeros = np.zeros(len(times) * len(radii))
    pressures = Measurement(
        "pressure", "pressure", times, zeros, zeros, False, radii, means=np.eye(len(radii))
    )
    model = replace(candidate.likelihood.predictor, measurements=(pressures,), known=())
    return model.predict(candidate.point.x)[0].reshape(len(times), -1)


def _relative_errors(theirs: Array, ours: Array) -> Array:
    """Return relative errors, 0 where they are not finite."""
    with np.errstate(all="ignore"):
        errors = theirs / ours - 1
    return np.where(np.isfinite(errors), errors, 0.0)


def unexplained(where: str) -> Diagnosis:
    """Return the diagnosis that no mistake explains the difference.

    Parameters
    ----------
    where : the greatest error, where it is, and what to do next
    """
    return Diagnosis("", np.nan, np.nan, np.nan, 0.0, "", "", np.nan, "", where)


def _split_by_reach(diagnosis: Diagnosis, reach: float) -> list[Diagnosis]:
    """Return the diagnosis of a clamped half-space in the parts of the arc and of the mesh.

    Both have the same effect. The arc of a deck is at a known distance, and a coarse mesh causes
    the remaining error. Small parts are left out; other diagnoses are returned as they are.

    Parameters
    ----------
    reach : radius of the half-space of the deck, in punch radii
    """
    if diagnosis.name != "truncated half-space":
        return [diagnosis]
    by_arc = min(1.0, diagnosis.size / reach)
    arc = replace(
        diagnosis,
        size=reach,
        share=diagnosis.share * by_arc,
        looks_like=f"the half-space of the deck, which is clamped at {reach:.4g} radii: this "
        f"causes about {by_arc:.0%} of it",
    )
    coarse = replace(
        diagnosis,
        name="coarse mesh",
        size=1 - by_arc,
        share=diagnosis.share * (1 - by_arc),
        looks_like="a mesh that is too coarse, which makes all displacements too small: this "
        f"causes about {1 - by_arc:.0%} of it, because the arc is at {reach:.4g} radii",
        confirm="write the deck with half the --size: this error decreases",
    )
    return [part for part in (arc, coarse) if part.share >= MIN_SHARE]


def model_of(comparison: Comparison) -> Model:
    """Return the model of the compared numbers, which has no parameter yet."""
    scene = comparison.scene.changed(
        output={}, wear__steady=False, wear__march="modal", wear__step=None
    )
    model = Model.of(scene, (), comparison.measurements(NOISE, BIAS), RTOL, rough=True)
    return replace(model, known=comparison.known())


def _greatest_error(comparison: Comparison) -> float:
    """Return the greatest relative error of a quantity, over all of its times and radii."""
    errors = [0.0]
    for name in comparison.quantities:
        difference = comparison.theirs[name] - comparison.ours[name]
        finite = np.isfinite(difference)
        if norm := np.linalg.norm(comparison.ours[name][finite]):
            errors.append(float(np.linalg.norm(difference[finite]) / norm))
        elif np.any(difference[finite]):
            errors.append(np.inf)
    return max(errors)


def _diagnoses(candidates: Sequence[Candidate], comparison: Comparison) -> list[Diagnosis]:
    (none,) = (each for each in candidates if not each.mistakes)
    best = {each: first_with(candidates, each) for each in shares(candidates)}
    share = {
        mistake: value * explained_part(best[mistake], none)
        for mistake, value in shares(candidates).items()
    }
    _merge_special(share, best)
    order = sorted(share, key=lambda each: -share[each])
    listed = [each for each in order if share[each] > MIN_SHARE]
    lowest = min(each.bic for each in candidates)
    diagnoses = []
    for mistake in listed:
        with left_out(mistake.name):
            candidate = best[mistake]
            values = candidate.values[candidate.mistakes.index(mistake)]
            rivals = [
                each
                for each in listed
                if each not in candidate.mistakes and mistake not in best[each].mistakes
            ]
            without = [each.bic for each in candidates if not _has(each, mistake, best)]
            part = explained_part(candidate, none)
            judgement, rival_name, confirm = CONSISTENT, "", mistake.remedy
            if min(without) - candidate.bic > NEAR and part > MIN_EXPLAINED:
                judgement = EXPLAINS
            elif rivals:
                rival = rivals[0]
                other = best[rival]
                rival_name = named(rival, other.values[other.mistakes.index(rival)], comparison)
                confirm = distinguishing_result(comparison, mistake, candidate, other, rival_name)
                near = max(candidate.bic, other.bic) < lowest + NEAR
                if near and min(part, explained_part(other, none)) > MIN_EXPLAINED:
                    judgement = EQUALLY
            low, high = interval_of(mistake, candidate)
            diagnoses.append(
                Diagnosis(
                    named(mistake, values, comparison),
                    mistake.size(*values),
                    low,
                    high,
                    share[mistake],
                    judgement,
                    sentence(mistake, values),
                    float(candidate.errors.max(initial=0.0)),
                    rival_name,
                    confirm,
                )
            )
    return diagnoses


def first_with(candidates: Sequence[Candidate], mistake: Mistake) -> Candidate:
    """Return the best candidate with a mistake."""
    return next(each for each in candidates if mistake in each.mistakes)


def _has(candidate: Candidate, mistake: Mistake, best: Mapping[Mistake, Candidate]) -> bool:
    """Return whether a candidate has a mistake, or its special case that predicts the same."""
    return any(
        each is mistake or (_is_special(each, mistake) and alike(best[each], best[mistake]))
        for each in candidate.mistakes
    )


def _is_special(mistake: Mistake, other: Mistake) -> bool:
    """Return whether one of two mistakes is a special case of the other."""
    related = mistake.special_of == other.name or other.special_of == mistake.name
    return related and mistake.group == other.group


def _merge_special(share: dict[Mistake, float], best: Mapping[Mistake, Candidate]) -> None:
    """Give the share of a mistake and of its special case that predict the same to one of them.

    A special case without a fitted number also says where the factor comes from.
    """
    order = sorted(share, key=lambda each: -share[each])
    for place, first in enumerate(order):
        for other in order[place + 1 :]:
            if not share[first] or not share[other] or not _is_special(first, other):
                continue
            if alike(best[first], best[other]):
                both = share[first] + share[other]
                special = other.fitted_numbers < first.fitted_numbers
                special = special and share[other] > both * SPECIAL_SHARE
                kept, dropped = (other, first) if special else (first, other)
                share[kept], share[dropped] = both, 0.0


def alike(candidate: Candidate, other: Candidate) -> bool:
    """Return whether two candidates predict nearly the same."""
    return bool(candidate.changes(other).max(initial=0.0) < MAX_ALIKE_DIFFERENCE)


def explained_part(candidate: Candidate, none: Candidate) -> float:
    """Return the square of the part of the difference, 0 to 1, that a candidate explains.

    Only quantities that it changes are counted, and errors that most programs have are not. What
    remains is compared with the difference, or with the data themselves if these are smaller.
    """
    changed = candidate.changes(none) > MIN_EFFECT
    if not changed.any() or not none.errors[changed].any():
        return 0.0
    before, after = (float(np.mean(each.errors[changed] ** 2)) for each in (none, candidate))
    remaining = np.sqrt(max(after - USUAL_ERROR**2, 0.0) / min(before, 1.0))
    return float(max(0.0, 1 - remaining) ** 2)


def interval_of(mistake: Mistake, candidate: Candidate) -> tuple[float, float]:
    """Return the 95 % interval of the size of a mistake; NaN if nothing is fitted."""
    numbers = iter(candidate.intervals)
    for each in candidate.mistakes:
        ends = [next(numbers) for parameter in each.parameters if not parameter.values]
        if each is mistake and ends and len(ends) == len(mistake.parameters):
            sizes = [mistake.size(*corner) for corner in zip(*ends, strict=True)]
            return min(sizes), max(sizes)
    return np.nan, np.nan


def distinguishing_result(
    comparison: Comparison, mistake: Mistake, candidate: Candidate, other: Candidate, rival: str
) -> str:
    """Return a sentence on the result that would distinguish a mistake best from its rival.

    Quantities that the program has given are considered only at times after its last one.
    """
    names, last = UnitNames.of(comparison.scene.units), float(comparison.times.max())
    times = np.array([0.0, last, 4 * last]) if last else np.zeros(1)
    predicted = [means_over_face(each, times) for each in (candidate, other)]
    best = ("", 0.0, 0)
    for name, values in predicted[0].items():
        for row, pair in enumerate(zip(values, predicted[1][name], strict=True)):
            size = max(abs(pair[0]), abs(pair[1]))
            present = name in comparison.quantities and times[row] <= last
            # what the scene prescribes is an input
            present |= name == comparison.scene.problem.prescribed
            if size and not present and abs(pair[0] - pair[1]) / size > best[1]:
                best = (name, abs(pair[0] - pair[1]) / size, row)
    if best[1] < MIN_DISTINCTION:
        return (
            f"{mistake.remedy}; results at these times and radii do not distinguish it from "
            f"{rival}: compare the inputs"
        )
    name, _, row = best
    time = names.write(times[row], "time", 3)
    texts = [names.write(float(each[name][row]), QUANTITIES[name].unit, 3) for each in predicted]
    averaged = ", averaged over the radius" if name in FIELDS else ""
    return (
        f"compare the {name.replace('_', ' ')} at t = {time}{averaged}: with this mistake it is "
        f"{texts[0]}, with {rival} {texts[1]}"
    )


def means_over_face(candidate: Candidate, times: Array) -> dict[str, Array]:
    """Return every quantity (T,) that a candidate predicts at times (T,), fields as means."""
    model = candidate.likelihood.predictor
    radii = np.linspace(0.02, 0.98, 49) * model.scene.punch.radius
    means, zeros = np.full((1, len(radii)), 1 / len(radii)), np.zeros(len(times))
    measurements = tuple(
        Measurement(
            name,
            name,
            times,
            zeros,
            zeros,
            False,
            radii if name in FIELDS else None,
            means=means if name in FIELDS else None,
        )
        for name in ("pressure", "normal_force", *LENGTHS)
    )
    values = replace(model, measurements=measurements, known=()).predict(candidate.point.x)
    return {each.quantity: value for each, value in zip(measurements, values, strict=True)}
