"""What the error of another program's results looks like.

Mistakes that people make (`causes/`) are put into our own results, one or several together. Those
that explain the error share the confidence; if they cannot be told apart, both are named, with what
would tell them apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...meshes.radial import Array
from ..problem.quantities import QUANTITIES
from ..problem.unit_names import UnitNames
from .causes import of_model, of_output
from .causes.cause import Cause
from .causes.comparison import Comparison
from .causes.hypotheses import Hypothesis, Part, Weighing, alike, explained, setting_of
from .causes.mesh import patterns
from .causes.model import Model

__all__ = ["Comparison", "Diagnosis", "diagnose"]

CAUSES: tuple[Cause, ...] = (
    of_model.WearCoefficient(),
    of_model.TruncatedHalfSpace(),
    of_output.Sign(),
    of_output.Units(),
    of_model.PlaneStrain(),
    of_model.ForcePerLength(),
    of_model.Diameter(),
    of_model.Layer(),
    of_model.NoLayers(),
    of_model.Load(),
    of_model.Stiffness(),
    of_model.PoissonsRatio(),
    of_model.SwappedMaterials(),
    of_output.UnitOfTime(),
    of_output.UnitOfRadii(),
    of_output.PressureFactor(),
    of_output.LengthFactor(),
    of_output.ForceFactor(),
    of_output.LateStart(),
    of_output.FirstOrderStep(),
)
"""The mistakes that are looked for; of two that explain as much the likelier one is named first."""
# confidence from which on a mistake is named, and from which on it is named alone
NAMED, SURE = 0.15, 0.7
# part of the confidence of two that are alike, from which on the one that fits fewer numbers names
# both
TELLS_WHY = 1 / 3
# difference of two predictions, relative, from which on a result would tell them apart
TELLING = 0.05
MESH = {
    "coarse rim": (
        "errors of pressure, of {:.2g}, that are at the rim and fall as it wears",
        "half the element size at the rim changes the first pressures most",
    ),
    "checkerboard": (
        "errors of pressure, of {:.2g}, that change their sign from radius to radius",
        "means of neighbours lose it: pressures are too rich for the displacements",
    ),
}


@dataclass(frozen=True)
class Diagnosis:
    """What an error looks like.

    Parameters
    ----------
    name : of the mistake
    size : its number
    confidence : up to 1: how likely it is that this mistake was made, of all that explain the
        error, times the part of the error that these explain
    words : what the results look like, with the number
    confirm : what would confirm it, or tell it from another that explains as much
    """

    name: str
    size: float
    confidence: float
    words: str
    confirm: str


def diagnose(comparison: Comparison) -> list[Diagnosis]:
    """Return what the error of their results looks like, the most confident first.

    Returns
    -------
    list of Diagnosis
        Empty if nothing explains most of the error, or if this is below the accuracy that the scene
        asks for.

    Notes
    -----
    Radius, modulus and force are changed by their units, which is exact of flat punches under one
    load; of others these mistakes may stay unnamed.
    """
    model = Model(comparison)
    weighing = Weighing(model, CAUSES)
    if not comparison.names or _error(comparison) <= comparison.scene.accuracy.rtol:
        return []
    none = weighing.hypothesis(())
    shares = weighing.all()
    likely = shares[0][0]
    found = _of_causes(model, none, shares) + _of_mesh(model, likely)
    return sorted(found, key=lambda fault: -fault.confidence)


def _error(comparison: Comparison) -> float:
    """Return the greatest relative error of a quantity, at all of its times and radii."""
    errors = [0.0]
    for name in comparison.names:
        gap = comparison.theirs[name] - comparison.ours[name]
        given = np.isfinite(gap)
        if norm := np.linalg.norm(comparison.ours[name][given]):
            errors.append(float(np.linalg.norm(gap[given]) / norm))
        elif np.any(gap[given]):
            errors.append(np.inf)
    return max(errors)


def _of_causes(
    model: Model, none: Hypothesis, shares: Sequence[tuple[Hypothesis, float]]
) -> list[Diagnosis]:
    """Return the mistakes that are likely, with the share of all hypotheses that have them."""
    confidence, best = dict[Cause, float](), dict[Cause, Hypothesis]()
    for hypothesis, share in shares:
        part_of_error = explained(hypothesis, none, model.comparison.members)
        for part in hypothesis.parts:
            confidence[part.cause] = confidence.get(part.cause, 0.0) + share * part_of_error
            best.setdefault(part.cause, hypothesis)
    named = sorted(confidence, key=lambda cause: -confidence[cause])
    for cause in named:
        for other in named[named.index(cause) + 1 :]:
            # one mistake by two names, as a modulus and the one that Poisson's ratio is missing in
            if cause.group == other.group and alike(best[cause], best[other]):
                both = confidence[cause] + confidence[other]
                # nearly as likely without a fitted number, it also tells why
                tells = other.fitted < cause.fitted and confidence[other] > both * TELLS_WHY
                kept, dropped = (other, cause) if tells else (cause, other)
                confidence[kept], confidence[dropped] = both, 0.0
    named = [cause for cause in named if confidence[cause] >= NAMED]
    found = []
    for cause in named:
        hypothesis = best[cause]
        (part,) = [part for part in hypothesis.parts if part.cause is cause]
        rivals = [
            other
            for other in named
            if other is not cause and cause not in {of.cause for of in best[other].parts}
        ]
        remedy = cause.remedy
        if rivals and confidence[cause] < SURE:
            remedy = telling(model, part, hypothesis, best[rivals[0]], rivals[0])
        found.append(_told(model, part, hypothesis, min(1.0, confidence[cause]), remedy))
    return found


def _told(
    model: Model, part: Part, hypothesis: Hypothesis, confidence: float, remedy: str
) -> Diagnosis:
    cause, setting = part.cause, hypothesis.setting
    size = cause.size(model, part.sizes)
    if isinstance(cause, of_output.Units):
        size = cause.size_in(model, setting)
    name = cause.named(model, setting, part.sizes)
    words = cause.sentence(model, setting, part.sizes)
    return Diagnosis(name, size, confidence, words, remedy)


def telling(
    model: Model, part: Part, hypothesis: Hypothesis, other: Hypothesis, rival: Cause
) -> str:
    """Return which result would tell a mistake from its rival."""
    unit, names = model.problem.units, UnitNames.of(model.comparison.scene.units)
    last = float(model.times.max())
    later = np.array([0.0, last, 4 * last]) if last else np.zeros(1)
    mine, theirs = (model.mean_history(setting_of(one.parts), later) for one in (hypothesis, other))
    (rival_part,) = [of for of in other.parts if of.cause is rival]
    rival_name = rival.named(model, other.setting, rival_part.sizes)
    best = ("", 0.0, 0)
    for name in mine:
        for row, pair in enumerate(zip(mine[name], theirs[name], strict=True)):
            size = max(abs(pair[0]), abs(pair[1]))
            given = name in model.comparison.names and later[row] <= last
            if size and not given and abs(pair[0] - pair[1]) / size > best[1]:
                best = (name, abs(pair[0] - pair[1]) / size, row)
    if best[1] < TELLING:
        return (
            f"{part.cause.remedy}; results at these times and radii do not tell it from "
            f"{rival_name}: compare the inputs"
        )
    name, _, row = best
    when = names.write(later[row] * unit.time, "time", 3)
    kind = QUANTITIES[name].unit
    values = [names.write(float(of[name][row]), kind, 3) for of in (mine, theirs)]
    return (
        f"the {name.replace('_', ' ')} at t = {when} tells it from {rival_name}: {values[0]} "
        f"against {values[1]}"
    )


def _of_mesh(model: Model, hypothesis: Hypothesis) -> list[Diagnosis]:
    """Return what the errors of pressure that are left look like."""
    comparison = model.comparison
    if "pressure" not in comparison.names:
        return []
    theirs = comparison.theirs["pressure"][comparison.rows]
    right = comparison.ours["pressure"][comparison.rows]
    whole = _relative(theirs, right)
    left = _relative(theirs, right * model.pressure_ratio(hypothesis.setting))
    # what mistakes have explained is no error of the mesh
    share = min(1.0, float(np.linalg.norm(left) / (np.linalg.norm(whole) or 1.0)))
    return [
        Diagnosis(name, size, share * confidence, MESH[name][0].format(size), MESH[name][1])
        for name, size, confidence in patterns(
            left, comparison.radii, comparison.scene.punch.radius
        )
        if share * confidence > SURE and size > comparison.scene.accuracy.rtol
    ]


def _relative(theirs: Array, right: Array) -> Array:
    """Return relative errors, 0 where there is none."""
    with np.errstate(all="ignore"):
        errors = theirs / right - 1
    return np.where(np.isfinite(errors), errors, 0.0)
