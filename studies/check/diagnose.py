"""Diagnose the error of another program's results: find the mistakes that it looks like.

The mistakes that people often make (`causes/`) are put into our own results, one or several at a
time. The mistakes that explain the error share the confidence. If two of them explain it equally
well, both are named, together with a result that would distinguish them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...meshes import Array
from ..crosscheck import FIELDS, QUANTITIES
from .causes import mesh, modelling_mistakes, output_mistakes
from .causes.cause import Cause
from .causes.comparison import Comparison
from .causes.histories import LENGTHS
from .causes.hypotheses import (
    USUAL_ERROR,
    Hypothesis,
    HypothesisSearch,
    Mistake,
    alike,
    explained_error_part,
    setting_with,
)
from .causes.inputs import input_causes
from .causes.model import Model
from .solve import solve

CAUSES: tuple[Cause, ...] = (
    modelling_mistakes.WearCoefficient(),
    mesh.TruncatedHalfSpace(),
    mesh.CoarseRim(),
    output_mistakes.Sign(),
    output_mistakes.Units(),
    output_mistakes.ColumnUnits(),
    modelling_mistakes.PlaneStrain(),
    modelling_mistakes.ForcePerLength(),
    modelling_mistakes.Diameter(),
    modelling_mistakes.Layer(),
    modelling_mistakes.NoLayers(),
    modelling_mistakes.Load(),
    modelling_mistakes.Stiffness(),
    modelling_mistakes.PoissonsRatio(),
    modelling_mistakes.SwappedMaterials(),
    output_mistakes.UnitOfTime(),
    output_mistakes.UnitOfRadii(),
    output_mistakes.PressureFactor(),
    output_mistakes.LengthFactor(),
    output_mistakes.ForceFactor(),
    *map(output_mistakes.ColumnFactor, LENGTHS),
    output_mistakes.LateStart(),
    output_mistakes.FirstOrderStep(),
)
"""The mistakes that are considered. Of two that explain the error equally well, the one with the
higher prior is named first."""
# least confidence with which a mistake is named, and with which no rival has to be ruled out
MIN_CONFIDENCE, SURE = 0.15, 0.7
# least part of the joint confidence of two mistakes that predict the same, with which the one with
# fewer fitted numbers gives its name to both
SIMPLER_PART = 1 / 3
# least relative difference of two predictions at which a result can distinguish them
MIN_DISTINCTION = 0.05
# probability below which a hypothesis does not count
NEGLIGIBLE = 1e-3
# factor on the prior odds of mistakes that a deck by `ringwear deck` does not have, unless it was
# changed
DOUBT_OF_DECKS = 0.01
MESH = {
    "coarse rim": (
        "errors of pressure of about {:.2g} at the rim, which decrease as the rim wears",
        "halve the element size at the rim: the first pressures change most",
    ),
    "checkerboard": (
        "errors of pressure of about {:.2g} whose sign alternates from radius to radius",
        "average neighbouring pressures: the errors disappear, because the pressure space is too "
        "rich for the displacements",
    ),
}
"""What each error pattern of a mesh looks like, with the size of the errors, and its remedy."""


@dataclass(frozen=True)
class Diagnosis:
    """A mistake that may explain the error.

    Parameters
    ----------
    name : of the mistake
    size : number that describes the mistake, such as a factor
    confidence : 0 to 1: the probability that this mistake was made, according to all hypotheses,
        times the square of the part of the error that these explain
    words : what the error looks like, with the number, as a noun phrase
    confirm : what would confirm the mistake, or distinguish it from another that explains as much
    program : whose results have the error
    """

    name: str
    size: float
    confidence: float
    words: str
    confirm: str
    program: str = ""


def diagnose(comparison: Comparison, deck_reach: float | None = None) -> list[Diagnosis]:
    """Return the mistakes that the error of the other program looks like, most confident first.

    Parameters
    ----------
    comparison : results of the other program and ours
    deck_reach : radius of the half-space, in punch radii, if the program has solved a deck of this
        scene by `ringwear deck`: then errors of the mesh are far likelier than wrong inputs

    Returns
    -------
    list of Diagnosis
        Empty if no mistake is likely enough to be named, or if the error is below the `rtol` of
        the scene.

    Notes
    -----
    Changes of radius, modulus and force are predicted by scaling our history, which is exact for
    flat punches under one load. For other punches these mistakes may not be found.
    """
    model = Model(comparison, solve)
    doubt = 1.0 if deck_reach is None else DOUBT_OF_DECKS
    search = HypothesisSearch(model, (*CAUSES, *input_causes(model)), doubt)
    if not comparison.quantities or _greatest_error(comparison) <= comparison.scene.accuracy.rtol:
        return []
    none = search.hypothesis(())
    hypotheses = search.ranked_hypotheses()
    mistakes = _diagnose_mistakes(search, none, hypotheses)
    if deck_reach is not None:
        mistakes = [part for each in mistakes for part in _split_by_reach(each, deck_reach)]
    named = {diagnosis.name for diagnosis in mistakes}
    patterns = _diagnose_mesh(model, hypotheses[0][0])
    diagnoses = [*mistakes, *(each for each in patterns if each.name not in named)]
    return sorted(diagnoses, key=lambda diagnosis: -diagnosis.confidence)


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


def _diagnose_mistakes(
    search: HypothesisSearch, none: Hypothesis, hypotheses: Sequence[tuple[Hypothesis, float]]
) -> list[Diagnosis]:
    """Return the likely mistakes.

    Parameters
    ----------
    none : the hypothesis without a mistake
    hypotheses : all hypotheses with their probabilities, the likeliest first
    """
    model = search.model
    confidence, best = dict[Cause, float](), dict[Cause, Hypothesis]()
    for hypothesis, probability in hypotheses:
        explained_part = explained_error_part(hypothesis, none, model.comparison.membership)
        for mistake in hypothesis.mistakes:
            cause = mistake.cause
            part = 0.0
            if probability > NEGLIGIBLE:
                part = min(explained_part, _named_part(search, hypothesis, mistake, none))
            confidence[cause] = confidence.get(cause, 0.0) + probability * part
            best.setdefault(cause, hypothesis)
    causes = sorted(confidence, key=lambda cause: -confidence[cause])
    for cause in causes:
        for other in causes[causes.index(cause) + 1 :]:
            # two causes may describe one mistake, such as a modulus that Poisson's ratio explains
            same = isinstance(cause, type(other)) or isinstance(other, type(cause))
            same = same and cause.group == other.group
            if same and alike(best[cause], best[other]):
                both = confidence[cause] + confidence[other]
                # the cause without a fitted number also explains where the factor comes from
                simpler = other.fitted_numbers < cause.fitted_numbers
                simpler = simpler and confidence[other] > both * SIMPLER_PART
                remaining, dropped = (other, cause) if simpler else (cause, other)
                confidence[remaining], confidence[dropped] = both, 0.0
    causes = [cause for cause in causes if confidence[cause] >= MIN_CONFIDENCE]
    diagnoses = []
    for cause in causes:
        hypothesis = best[cause]
        (mistake,) = [each for each in hypothesis.mistakes if each.cause is cause]
        rivals = rival_causes(cause, causes, best)
        remedy = cause.remedy
        if rivals and confidence[cause] < SURE:
            rival = rivals[0]
            remedy = distinguishing_result(model, mistake, hypothesis, best[rival], rival)
        diagnoses.append(
            _diagnosis(model, mistake, hypothesis, min(1.0, confidence[cause]), remedy)
        )
    return diagnoses


def _split_by_reach(diagnosis: Diagnosis, reach: float) -> list[Diagnosis]:
    """Return the diagnosis of a clamped half-space in the parts of the arc and of the mesh.

    Both have the same effect. The arc of a deck is at a known distance, and a coarse mesh causes
    the remaining error. A part below `MIN_CONFIDENCE` is left out; other diagnoses are returned.

    Parameters
    ----------
    reach : radius of the half-space of the deck, in punch radii
    """
    if diagnosis.name != mesh.TruncatedHalfSpace.name:
        return [diagnosis]
    by_arc = min(1.0, diagnosis.size / reach)
    parts = [
        replace(
            diagnosis,
            size=reach,
            confidence=diagnosis.confidence * by_arc,
            words=f"the half-space of the deck, which is clamped at {reach:.4g} radii: this causes "
            f"about {by_arc:.0%} of it",
            confirm=mesh.TruncatedHalfSpace.remedy,
        ),
        replace(
            diagnosis,
            name="coarse mesh",
            size=1 - by_arc,
            confidence=diagnosis.confidence * (1 - by_arc),
            words="a mesh that is too coarse, which makes all displacements too small: this causes "
            f"about {1 - by_arc:.0%} of it, because the arc is at {reach:.4g} radii",
            confirm="write the deck with half the --size: this error decreases",
        ),
    ]
    return [part for part in parts if part.confidence >= MIN_CONFIDENCE]


def _named_part(
    search: HypothesisSearch, hypothesis: Hypothesis, mistake: Mistake, none: Hypothesis
) -> float:
    """Return the part, 0 to 1, by which a mistake is named beside the others of a hypothesis.

    It is small if the mistake changes the prediction by no more than the error that remains in most
    programs. A coarse rim, which most programs have, is named by the part of the error that it
    explains.
    """
    others = tuple(each for each in hypothesis.mistakes if each is not mistake)
    without = search.hypothesis(others)
    if isinstance(mistake.cause, mesh.CoarseRim):
        all_errors, errors_without, errors = (
            float(np.linalg.norm(each.errors)) for each in (none, without, hypothesis)
        )
        return max(0.0, errors_without - errors) / (all_errors or 1.0)
    if not others or search.doubt < 1:
        return 1.0
    members = search.model.comparison.membership.T
    squares = ((hypothesis.differences - without.differences) ** 2).sum(axis=0) @ members
    counts = search.model.comparison.present.sum(axis=0) @ members
    effect = float(np.sqrt(squares / np.maximum(counts, 1)).max())
    return float(np.sqrt(max(0.0, 1 - (USUAL_ERROR / effect) ** 2))) if effect else 0.0


def rival_causes(
    cause: Cause, causes: Sequence[Cause], best: Mapping[Cause, Hypothesis]
) -> list[Cause]:
    """Return the causes that belong to other hypotheses than a cause does, in the same order.

    Mistakes that are made together are not rivals.

    Parameters
    ----------
    causes : the likely causes
    best : the likeliest hypothesis with each cause
    """
    together = {mistake.cause for mistake in best[cause].mistakes}
    return [
        other
        for other in causes
        if other not in together and cause not in {each.cause for each in best[other].mistakes}
    ]


def _diagnosis(
    model: Model, mistake: Mistake, hypothesis: Hypothesis, confidence: float, remedy: str
) -> Diagnosis:
    cause, setting = mistake.cause, hypothesis.setting
    size = cause.size(model, mistake.sizes)
    if isinstance(cause, output_mistakes.Units):
        size = cause.size_in(model, setting)
    name = cause.name_of(model, setting, mistake.sizes)
    words = cause.sentence(model, setting, mistake.sizes)
    return Diagnosis(name, size, confidence, words, remedy)


def distinguishing_result(
    model: Model, mistake: Mistake, hypothesis: Hypothesis, other: Hypothesis, rival: Cause
) -> str:
    """Return a sentence on the result that would distinguish a mistake best from its rival.

    Quantities that the program has given are considered only at times after its last one.

    Parameters
    ----------
    mistake : one of the mistakes of `hypothesis`
    rival : cause of one of the mistakes of `other`
    """
    unit, names = model.problem.units, model.names
    last = float(model.times.max())
    times = np.array([0.0, last, 4 * last]) if last else np.zeros(1)
    with_mistake, with_rival = (
        model.mean_history(setting_with(each.mistakes), times) for each in (hypothesis, other)
    )
    (rival_mistake,) = [each for each in other.mistakes if each.cause is rival]
    rival_name = rival.name_of(model, other.setting, rival_mistake.sizes)
    best = ("", 0.0, 0)
    for name in with_mistake:
        for row, pair in enumerate(zip(with_mistake[name], with_rival[name], strict=True)):
            size = max(abs(pair[0]), abs(pair[1]))
            present = name in model.comparison.quantities and times[row] <= last
            if size and not present and abs(pair[0] - pair[1]) / size > best[1]:
                best = (name, abs(pair[0] - pair[1]) / size, row)
    if best[1] < MIN_DISTINCTION:
        return (
            f"{mistake.cause.remedy}; results at these times and radii do not distinguish it from "
            f"{rival_name}: compare the inputs"
        )
    name, _, row = best
    time = names.write(times[row] * unit.time, "time", 3)
    kind = QUANTITIES[name].unit
    values = [names.write(float(means[name][row]), kind, 3) for means in (with_mistake, with_rival)]
    averaged = ", averaged over the radius" if name in FIELDS else ""
    return (
        f"compare the {name.replace('_', ' ')} at t = {time}{averaged}: with this mistake it is "
        f"{values[0]}, with {rival_name} {values[1]}"
    )


def _diagnose_mesh(model: Model, hypothesis: Hypothesis) -> list[Diagnosis]:
    """Return the error patterns of a mesh in the pressures that a hypothesis does not explain."""
    comparison = model.comparison
    if "pressure" not in comparison.quantities:
        return []
    theirs = comparison.theirs["pressure"][comparison.time_rows]
    ours = comparison.ours["pressure"][comparison.time_rows]
    errors = _relative_errors(theirs, ours)
    unexplained = _relative_errors(theirs, ours * model.pressure_ratio(hypothesis.setting))
    # the part of the errors that mistakes explain is not caused by the mesh
    norms = float(np.linalg.norm(unexplained)), float(np.linalg.norm(errors) or 1.0)
    unexplained_part = min(1.0, norms[0] / norms[1])
    return [
        Diagnosis(name, size, unexplained_part * part, MESH[name][0].format(size), MESH[name][1])
        for name, size, part in mesh.patterns(
            unexplained, comparison.radii, comparison.scene.punch.radius
        )
        if unexplained_part * part > SURE and size > comparison.scene.accuracy.rtol
    ]


def _relative_errors(theirs: Array, ours: Array) -> Array:
    """Return relative errors, 0 where they are not finite."""
    with np.errstate(all="ignore"):
        errors = theirs / ours - 1
    return np.where(np.isfinite(errors), errors, 0.0)
