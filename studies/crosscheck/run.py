"""Run a scene: every method, its own error estimate, and the verdict on how far they agree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.operators import OperatorDifference, difference, on_space_of
from ringwear.studies.methods.model import Model
from ringwear.studies.methods.outcome import Outcome, estimated, from_direct_integration, relative_difference
from ringwear.studies.methods.radial import MODELS
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages, silent
from ringwear.studies.wear.archard import Wear
from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    import xarray

# results that the verdict compares: numbers, forces and profiles. Pointwise pressures are drawn and kept in the
# results, but at ring edges and the rim they are singular at t = 0 and belong in a norm, not in a verdict
COMPARED = (
    "indentation", "displacement_centre", "displacement_max", "rms_slope", "ring_force", "profile", "relaxation_time",
    "steady_profile", "steady_displacement_max", "steady_rms_slope", "steady_wear_rate",
)  # fmt: skip
COMPARED_MODES = 3

# outcome, errors, indentation errors by part, and what they were made with
Evaluated = tuple[Outcome, Outcome, dict[str, float], tuple[Model, Wear] | None]

REFINABLE = ("pressure space", "discretisation")
MOST_REFINEMENTS = 2
FINEST = 1e-9


@dataclass(frozen=True)
class Agreement:
    """One quantity of two methods: their greatest difference relative to their combined uncertainty."""

    quantity: str
    methods: tuple[str, str]
    difference: float
    uncertainty: float

    @property
    def agrees(self) -> bool:
        return self.difference <= self.uncertainty


@dataclass(frozen=True, eq=False)
class Result:
    """Everything that a run found; natural units inside, the scene's units in `dataset`."""

    scene: Scene
    outcomes: dict[str, Outcome]
    errors: dict[str, Outcome]
    models: dict[str, Model]
    parts: dict[str, dict[str, float]]
    stages: dict[str, Stages]
    agreement: tuple[Agreement, ...]
    operators: tuple[OperatorDifference, ...]
    notes: tuple[str, ...] = field(default=())

    @property
    def agrees(self) -> bool:
        return all(row.agrees for row in self.agreement)

    @property
    def estimates(self) -> dict[str, float]:
        """Each method's own estimate of its relative error, of the indentation over all times."""
        return {method: sum(parts.values()) for method, parts in self.parts.items()}

    @property
    def short_of(self) -> dict[str, float]:
        """Methods whose own estimate is above the accuracy asked for."""
        return {method: value for method, value in self.estimates.items() if value > self.scene.accuracy.rtol}

    @property
    def dataset(self) -> xarray.Dataset:
        """The results as an xarray Dataset, in the scene's units."""
        from ringwear.studies.crosscheck.dataset import dataset

        return dataset(self)

    @property
    def summary(self) -> dict[str, Any]:
        """What was done, at what cost, how accurately, and what was left out."""
        from ringwear.studies.crosscheck.dataset import summary

        return summary(self)


def run(scene: Scene, report: Report = silent) -> Result:
    """Compute everything that a scene asks for.

    Parameters
    ----------
    scene : what to compute, by which methods and how accurately
    report : called with a line of progress at each stage

    Raises
    ------
    RingwearError
        if a mesh or a system fails; the message names the remedy
    """
    natural = scene.natural
    outcomes: dict[str, Outcome] = {}
    errors: dict[str, Outcome] = {}
    models: dict[str, Model] = {}
    wears: dict[str, Wear] = {}
    parts: dict[str, dict[str, float]] = {}
    stages: dict[str, Stages] = {}
    # the dense matrices are small: threads of two linear algebra libraries would spend their time waiting on each other
    with threadpool_limits(1):
        for method in scene.methods:
            stages[method] = Stages(method, report)
            outcomes[method], errors[method], parts[method], made = _to_accuracy(natural, method, stages[method])
            if made is not None:
                models[method], wears[method] = made
        operators = tuple(compare_operators(natural, wears, report))
    rtol = scene.accuracy.rtol
    agreement = tuple(row for a, b in combinations(outcomes, 2) for row in agreements(a, b, outcomes, errors, rtol))
    notes = tuple(note for model in models.values() for note in model.notes)
    return Result(scene, outcomes, errors, models, parts, stages, agreement, operators, notes)


def _to_accuracy(natural: NaturalScene, method: str, stages: Stages) -> Evaluated:
    """Evaluate a method; as long as its own estimate falls short of the accuracy asked for, again with finer sizes.

    Sizes given by the user stay, and what finer sizes do not mend (roundoff, a time step) is left to the verdict.
    """
    asked = working = natural.scene.accuracy.rtol
    found = _evaluate(natural, method, stages)
    for _ in range(MOST_REFINEMENTS):
        estimate = _of_sizes(found[2])
        if estimate <= asked or working <= FINEST or natural.scene.accuracy.gives_sizes(method):
            break
        working = max(FINEST, working * 0.5 * asked / estimate)
        stages.report(f"{method:>7}  its estimate {estimate:.1e} is above {asked:.1e}: refining ...")
        finer = _evaluate(natural.scene.changed(accuracy__rtol=working).natural, method, stages)
        if _of_sizes(finer[2]) >= estimate:
            break
        found = _with_note(finer, f"{method}: refined from rtol {asked:.1e} to {working:.1e}, for its estimate fell short")
    return found


def _of_sizes(parts: dict[str, float]) -> float:
    return sum(value for part, value in parts.items() if part in REFINABLE)


def _with_note(found: Evaluated, note: str) -> Evaluated:
    result, errors, parts, made = found
    if made is None:
        return found
    model, wear = made
    return result, errors, parts, (replace(model, notes=(*model.notes, note)), wear)


def _evaluate(natural: NaturalScene, method: str, stages: Stages) -> Evaluated:
    if method == "direct":
        with stages("integrating"):
            result, errors = from_direct_integration(natural)
        return result, errors, {"roundoff": float(errors.steady_displacement_max.max(initial=0.0))}, None
    wear = natural.scene.wear
    paper = method == "mdr" and wear.march == "explicit" and bool(wear.times)
    # the paper's grid marches by itself; the graded space beside it gives relaxation times and the steady state
    graded = natural.scene.changed(wear={"times": wear.times, "steady": wear.steady}).natural if paper else natural
    model = MODELS[method](graded, stages)
    with stages("marching" if wear.times else "steady state"):
        result, errors, parts, worn = estimated(graded, model)
    if paper:
        from ringwear.studies.methods.mdr_grid import paper_errors, paper_history, with_steady

        with stages("explicit march"):
            history = paper_history(natural)
            first_order = paper_errors(natural, history)
        result, errors = with_steady(history, result), with_steady(first_order, errors)
        parts = {"grid and step": float(first_order.indentation.max())}
    return result, errors, parts, (model, worn)


def compare_operators(
    natural: NaturalScene, wears: dict[str, Wear], report: Report = silent
) -> Iterator[OperatorDifference]:
    """Compare methods as operators: each on the space of another, where it can be had there.

    A method with a space of its own (the finite elements, on their contact facets) gives the space; the others follow.
    """
    order = sorted(wears, key=lambda method: on_space_of(method) is not None)
    for a, b in combinations(order, 2):
        elsewhere = on_space_of(b)
        if elsewhere is not None:
            with Stages("check", report)(f"{a} against {b}"):
                first = wears[a]
                second = replace(first, compliance=elsewhere(first.compliance.space))
                yield difference(natural, (a, b), first, second)


def agreements(a: str, b: str, outcomes: dict[str, Outcome], errors: dict[str, Outcome], rtol: float) -> list[Agreement]:
    """Compare two methods in every quantity that both give, each at its worst place.

    Of the indentation no method may claim an uncertainty above the accuracy asked for: a difference is not excused by
    a method that says of itself that it is wrong.
    """
    rows = []
    for name in COMPARED:
        first, second = getattr(outcomes[a], name), getattr(outcomes[b], name)
        limit = COMPARED_MODES if name == "relaxation_time" else None
        if not (first.size and second.size):
            continue
        difference = relative_difference(name, first[:limit], second[:limit])
        uncertainty = _combined(getattr(errors[a], name)[:limit], getattr(errors[b], name)[:limit])
        if name == "indentation":
            uncertainty = np.minimum(uncertainty, 2 * rtol)
        worst = np.unravel_index(np.argmax(difference / uncertainty), difference.shape)
        rows.append(Agreement(name, (a, b), float(difference[worst]), float(uncertainty[worst])))
    return rows


def _combined(a: Array, b: Array) -> Array:
    common = tuple(slice(0, min(m, n)) for m, n in zip(a.shape, b.shape, strict=True))
    return a[common] + b[common]


def quantities() -> list[str]:
    """Names of all results, as in the results file."""
    return [item.name for item in fields(Outcome)]
