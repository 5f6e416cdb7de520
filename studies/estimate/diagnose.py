"""Explain the difference of another program's results to ours by mistakes, in words."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes import Array
from .compared import PATTERNS, USUAL_ERROR, Comparison, in_columns, patterns, relative
from .diagnosis import EQUALLY, EXPLAINS, REDUCES, Diagnosis
from .mistakes import mesh_part, mistakes, named, sentence, written_out
from .model import Model
from .select import (
    ALIKE,
    BIAS,
    COARSE_MESH,
    MIN_EFFECT,
    NOISE,
    Candidate,
    Mistake,
    left_out,
    select,
)

# tolerance of the model: errors of other programs are greater
RTOL = 1e-2
# least relative error that is assumed of another program
LEAST_ERROR = 0.01
# factor on the estimated errors of both programs up to which a mistake explains the difference
TRUST = 1.5
# relative difference of two predictions below which they count as alike
MAX_ALIKE_DIFFERENCE = 0.02
# greatest number of mistakes that are named, and least share of a part of one
MOST_NAMED, MIN_SHARE = 4, 0.15
# greatest factor on what the best mistake leaves that another one leaves that is named with it
MOST_WORSE = 3.0
# difference of the score up to which a mistake explains the data as well as another one
NEAR = 6.0
# least part of the errors of pressures that a pattern of a mesh has to be
SURE = 0.7
# factor on the errors of pressures above which those of another quantity are not caused by a mesh
OTHERS_FACTOR = 3.0
# least `explained_part` of an explanation, which leaves at most a sixth of the difference; and of a
# mistake that is named at all
MIN_EXPLAINED, MIN_REDUCED = 0.7, 0.04
# greatest part of the difference of a column that remains if it is written wrongly
MOST_REMAINING = 1 / 3


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
    if not _differ(comparison):
        return []
    # the matrices are so small that several threads would only wait for each other
    with threadpool_limits(1), left_out("every mistake"):
        return _ranked(comparison, deck_reach)
    return []


def _ranked(comparison: Comparison, deck_reach: float | None) -> list[Diagnosis]:
    """Return the diagnoses of a difference that is above the `rtol` of the scene."""
    model, of_mesh = model_of(comparison), (mesh_part(),) * bool(comparison.mesh_results)
    candidates = select(model, list(mistakes(comparison)), of_mesh)
    (none,) = (each for each in candidates if each.mistake is None)
    if diagnoses := _in_column(comparison, none):
        return diagnoses
    diagnoses = _diagnoses(candidates, none, comparison, deck_reach is not None)
    if deck_reach is not None:
        diagnoses = [part for each in diagnoses for part in _split_by_reach(each, deck_reach)]
    diagnoses += _patterns_of_mesh(candidates[0], none, comparison)
    return sorted(diagnoses, key=lambda each: -each.share)


def _in_column(comparison: Comparison, none: Candidate) -> list[Diagnosis]:
    """Return the column that is written wrongly if all others agree; empty if there is none."""
    tried = list(in_columns(comparison))
    if not tried:
        return []
    column, best = min(tried, key=lambda each: each[1].remaining / (each[1].before or 1.0))
    allowed = dict(zip(comparison.quantities, _allowed(comparison), strict=True))
    others = zip(comparison.quantities, none.errors, strict=True)
    agree = all(error <= allowed[name] for name, error in others if name != column)
    if not agree or best.remaining > MOST_REMAINING * best.before or best.before < USUAL_ERROR:
        return []
    return [best]


def _allowed(comparison: Comparison) -> Array:
    """Return the estimated relative errors (Q,) of both programs together, by quantity."""
    ours = comparison.scene.accuracy.rtol
    if not comparison.mesh_results:
        return np.full(len(comparison.quantities), TRUST * (USUAL_ERROR + ours))
    sizes = np.array([float(np.sqrt(np.mean(each**2))) for each in comparison.mesh_errors()])
    return TRUST * (np.maximum(sizes, LEAST_ERROR) + ours)


def _patterns_of_mesh(best: Candidate, none: Candidate, comparison: Comparison) -> list[Diagnosis]:
    """Return the patterns of a mesh in the pressures, if the best candidate does not change them.

    Errors of pressures are not what is wrong, either, if those of another column are much greater.
    """
    errors = dict(zip(comparison.quantities, best.errors, strict=True))
    changes = dict(zip(comparison.quantities, best.changes(none), strict=True))
    if changes.get("pressure", 1.0) > MIN_EFFECT:
        return []
    theirs, ours = (
        results["pressure"][comparison.time_rows]
        for results in (comparison.theirs, comparison.ours)
    )
    others = max((error for name, error in errors.items() if name != "pressure"), default=0.0)
    return [
        Diagnosis(
            name,
            size,
            EXPLAINS,
            PATTERNS[name][0].format(size),
            size,
            size * float(np.sqrt(max(0.0, 1 - part))),
            PATTERNS[name][1],
            part,
        )
        for name, size, part in patterns(
            relative(theirs, ours), comparison.radii, comparison.scene.punch.radius
        )
        if part > SURE
        and size > comparison.scene.accuracy.rtol
        and others < max(USUAL_ERROR, OTHERS_FACTOR * size)
    ]


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
    scene = written_out(comparison.scene).changed(
        output={}, wear__steady=False, wear__march="modal", wear__step=None
    )
    model = Model.of(scene, (), comparison.measurements(NOISE, BIAS), RTOL, rough=True)
    return replace(model, known=comparison.known(), mesh_errors=comparison.mesh_errors())


def _differ(comparison: Comparison) -> bool:
    """Return whether a quantity differs by more than `rtol`, over all of its times and radii."""
    for name in comparison.quantities:
        ours = comparison.ours[name]
        difference = comparison.theirs[name] - ours
        known = np.isfinite(difference)
        allowed = comparison.scene.accuracy.rtol * np.linalg.norm(ours[known])
        if np.linalg.norm(difference[known]) > allowed:
            return True
    return False


def _diagnoses(
    candidates: Sequence[Candidate], none: Candidate, comparison: Comparison, deck: bool
) -> list[Diagnosis]:
    """Return the diagnoses of the mistakes that explain the difference, or else of the best one.

    Parameters
    ----------
    deck : whether the program has solved our deck, so that its inputs are right: if errors of the
        mesh explain the difference, only they are named
    """
    allowed, before = _allowed(comparison), float(none.errors.max(initial=0.0))
    if before <= LEAST_ERROR:
        # a program without a mistake may differ as much
        return []
    made = [
        (each, each.mistake)
        for each in _without_alike(candidates)
        if each.mistake and each.score < none.score and explained_part(each, none) > MIN_REDUCED
    ]

    def explains(candidate: Candidate) -> bool:
        within = bool((candidate.errors <= allowed).all())
        return within and explained_part(candidate, none) > MIN_EXPLAINED

    # an input that leaves about as much as the mesh is not shown to be wrong
    most = min((each.score for each, _ in made), default=0.0) + NEAR
    if any(
        (mistake.name == COARSE_MESH and each.score <= most and explains(each))
        or (deck and mistake.of_mesh and explained_part(each, none) > MIN_EXPLAINED)
        for each, mistake in made
    ):
        made = [(each, mistake) for each, mistake in made if mistake.of_mesh]
    if not made:
        return []
    scores = np.array([each.score for each, _ in made])
    weights = np.exp(-np.maximum(scores - scores.min() - ALIKE, 0.0) / 2)
    parts = weights / weights.sum() * [explained_part(each, none) for each, _ in made]
    # in the order of the score
    shares = {
        each: share for (each, _), share in zip(made, np.minimum.accumulate(parts), strict=True)
    }
    explaining = [(each, mistake) for each, mistake in made if explains(each)]
    first, _ = (explaining or made)[0]
    most_error = MOST_WORSE * max(first.errors.max(), none.floor)
    rows = [
        (each, mistake)
        for each, mistake in explaining
        if each.score < first.score + NEAR and each.errors.max() <= most_error
    ][:MOST_NAMED]
    rows = rows or made[:1]
    names = [named(mistake, each.values, comparison) for each, mistake in rows]
    # the rival of the first one is the second one, and the first one is that of all others
    rivals = [*names[1:2], *names[:1] * (len(names) - 1)]
    judgement = REDUCES if not explaining else EQUALLY if rivals else EXPLAINS
    return [
        Diagnosis(
            name,
            mistake.size(*each.values),
            judgement,
            sentence(mistake, each.values),
            before,
            float(each.errors.max(initial=0.0)),
            mistake.remedy,
            float(shares[each]),
            *interval_of(mistake, each),
            rival,
        )
        for name, (each, mistake), rival in zip(names, rows, rivals or [""], strict=True)
    ]


def _without_alike(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates without those that predict the same as a special or more general one.

    Of two, the one with the better score is kept: a special case says where the number comes from.
    """
    kept = list[Candidate]()
    for each in candidates:
        if not any(_are_one(each, other) for other in kept):
            kept.append(each)
    return kept


def _are_one(candidate: Candidate, other: Candidate) -> bool:
    """Return whether two candidates are the same mistake, in two forms.

    One is a special case of the other, and they predict nearly the same.
    """
    first, second = candidate.mistake, other.mistake
    if not first or not second or first.changes != second.changes:
        return False
    special = second.name == first.special_of or first.name == second.special_of
    return special and bool(candidate.changes(other).max(initial=0.0) < MAX_ALIKE_DIFFERENCE)


def explained_part(candidate: Candidate, none: Candidate) -> float:
    """Return the square of the part of the difference, 0 to 1, that a candidate explains.

    Only quantities that it changes are counted, and errors that most programs have are not. What is
    wrong by more than its size is only wrong.
    """
    changed = candidate.changes(none) > MIN_EFFECT
    if not changed.any() or not none.errors[changed].any():
        return 0.0
    before, after = (
        float(np.mean(np.minimum(each.errors[changed], 1.0) ** 2)) for each in (none, candidate)
    )
    remaining = np.sqrt(max(after - USUAL_ERROR**2, 0.0) / before)
    return float(max(0.0, 1 - remaining) ** 2)


def interval_of(mistake: Mistake, candidate: Candidate) -> tuple[float, float]:
    """Return the 95 % interval of the size of a mistake, by the curvature and within its range.

    It is NaN if nothing is fitted.
    """
    if any(each.values for each in mistake.parameters):
        return np.nan, np.nan
    x = candidate.point.x
    deviations = np.sqrt(np.diag(candidate.likelihood.covariance(x)))
    sizes = []
    for end in (-1.96, 1.96):
        ends = zip(mistake.parameters, x + end * deviations, strict=False)
        values = (each.at(float(np.clip(at, -each.reach, each.reach))) for each, at in ends)
        sizes.append(mistake.size(*values))
    return min(sizes), max(sizes)
