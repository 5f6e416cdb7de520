"""The result of a run, as an xarray Dataset (netCDF-4) and as a summary (JSON), in the scene's
units.
"""

import json
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.quantities import (
    ANSWER,
    ERROR,
    NORMS,
    OF_PROFILES,
    QUANTITIES,
    STATES,
    array,
    common,
    error_name,
    values,
)
from ..problem.scene import Scene
from ..problem.unit_names import UNSTATED, UnitNames
from ..progress import Stages
from ..versions import versions
from ..wear.modes import SHOWN
from .agreement import AGREE, DISAGREE, UNDECIDED, Agreement, by_quantity, overall
from .anchors import Anchor, anchors
from .answer import ALSO, answer
from .interior import Interior, interior
from .operators import OperatorDifference
from .scope import left_out, modelled

DEFINITIONS = {
    "verdict": "agree: every difference is within the uncertainty, or within rtol, and the "
    "uncertainty within a few rtol; "
    "disagree: a difference is beyond both, though neither method states an error above rtol, or "
    "an anchor does not hold; "
    "undecided: anything else. Where edges of a "
    "contact move, what is local to them (`promised` false) does not make the whole undecided, "
    "but can make it disagree",
    "difference": "relative, in the norm of the quantity, where it decides the verdict",
    "uncertainty": "sum of the two methods' own error estimates at that time",
    "anchors": "closed forms and balances that each method is held to by itself",
    "operator_difference": "of the energies two methods give the same pressures, relative: "
    "greatest over all "
    "ring-wise constant pressures (rings), along the history (history), over the first method's "
    "whole space "
    "(space, worst at worst_radius); stability: their least ratio, the square of the inf-sup "
    "constant; residual: "
    "first method's pressures put into the second, against the worn profile, in the energy norm",
    "error_estimate": "relative, of the indentation, over all times",
    "answer": "by each method, in the scene's units; of rings a list from the centre, first at "
    "the start, then steady; "
    "null: infinite, or not given",
    "beyond_rtol": (
        "quantities that the method cannot bring to rtol by its own estimate, with the greatest "
        "estimate"
    ),
}


@dataclass(frozen=True, eq=False)
class Result:
    """Everything that a run computed.

    Solutions are non-dimensional, `dataset` is in the scene's units.

    Parameters
    ----------
    scene : what was asked for
    solutions : by method
    stages : seconds by method
    agreement : of every two methods, by quantity
    operators : of every two compliances
    """

    scene: Scene
    solutions: dict[str, Solution]
    stages: dict[str, Stages]
    agreement: tuple[Agreement, ...]
    operators: tuple[OperatorDifference, ...]

    @property
    def verdict(self) -> str:
        """`agree`, `disagree` or `undecided`.

        The least of all that is promised; an anchor that does not hold disagrees.
        """
        if not all(anchor.holds for anchor in self.anchors):
            return DISAGREE
        return overall(self.agreement)

    @property
    def agrees(self) -> bool:
        return self.verdict == AGREE

    @property
    def quantities(self) -> dict[str, str]:
        """The verdict on each quantity, over all pairs of methods."""
        return by_quantity(self.agreement)

    @property
    def verdict_in_words(self) -> str:
        """How many quantities agree."""
        verdicts = list(self.quantities.values())
        words = [f"{verdicts.count(AGREE)} of {len(verdicts)} quantities agree"]
        words += [
            f"{count} {word}" for word in (UNDECIDED, DISAGREE) if (count := verdicts.count(word))
        ]
        agree = (
            "The methods agree"
            if set(verdicts) == {AGREE}
            else "The methods agree in all that is promised"
        )
        final = {AGREE: agree, UNDECIDED: "Not all is decided", DISAGREE: "THE METHODS DISAGREE"}
        return f"{final[self.verdict]}: {', '.join(words)}."

    @property
    def estimates(self) -> dict[str, float]:
        """Each method's own estimate of its relative error, of the indentation over all times."""
        return {name: solution.error_estimate for name, solution in self.solutions.items()}

    @property
    def short_of(self) -> dict[str, float]:
        """Methods whose own estimate is above the accuracy asked for."""
        return {
            name: value
            for name, value in self.estimates.items()
            if value > self.scene.accuracy.rtol
        }

    @property
    def notes(self) -> tuple[str, ...]:
        # what is the same by every method is said once
        notes = (note for solution in self.solutions.values() for note in solution.notes)
        return tuple(dict.fromkeys(notes))

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """What a user asked of the punch, by method.

        `answer.ANSWER`, and the steady wear rate and slope; scene's units.
        """
        units, found = self.scene.problem.units, {}
        for name, solution in self.solutions.items():
            own = answer(self.scene.problem, solution)
            found[name] = {
                key: value * getattr(units, ANSWER[key].unit) for key, value in own.items()
            }
            for key in ALSO:
                value = (
                    array(solution.results, key) if key in solution.results else np.array(np.nan)
                )
                found[name][key] = value * getattr(units, QUANTITIES[key].unit)
        return found

    def given(self, quantity: str) -> dict[str, xarray.Dataset]:
        """Return the non-dimensional results of the methods that give a quantity."""
        every = {name: solution.results for name, solution in self.solutions.items()}
        return {name: results for name, results in every.items() if quantity in results}

    def first_answer(self, key: str) -> Array:
        """Return an answer by the first method that gives it; NaN if none does."""
        values = [answers[key] for answers in self.answers.values()]
        return next((value for value in values if np.isfinite(value).any()), values[0])

    @property
    def has_inside(self) -> bool:
        """Whether finite elements of a flat punch can tell what is inside the half-space."""
        fem = self.solutions.get("fem")
        return self.scene.problem.full_contact and fem is not None and fem.half_space is not None

    @cached_property
    def inside(self) -> Interior:
        """Displacements and stresses inside the half-space."""
        return interior(self.scene, self.solutions["fem"])

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """The results as an xarray Dataset, in the scene's units."""
        return dataset(self)

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """What no method can move, for each method.

        Closed forms and balances that the dataset is held to.
        """
        return tuple(
            anchor
            for name, solution in self.solutions.items()
            for anchor in anchors(self.scene, name, self.dataset.sel(solver=name), solution)
        )

    @property
    def summary(self) -> dict[str, Any]:
        """What was done, at what cost, how accurately, and what was left out."""
        return summary(self)


def dataset(result: Result) -> xarray.Dataset:
    """All results over dimensions solver, time, radius, ring and mode.

    NaN where a method does not give a quantity.
    """
    scene, solutions = result.scene, result.solutions
    problem, names = scene.problem, UnitNames.of(scene.units)
    sizes = {
        "time": len(problem.times),
        "radius": len(problem.radii),
        "ring": len(problem.wear_coefficients),
        "mode": SHOWN,
    }
    sizes["state"] = len(STATES)
    every = [values(solution.results) for solution in solutions.values()]
    errors = [solution.errors for solution in solutions.values()]
    # a flat punch has no more to say
    shown = [
        name for name in QUANTITIES if name not in OF_PROFILES or any(name in one for one in every)
    ]
    sizes["edge"] = max(
        (one["contact_edge"].shape[1] for one in every if "contact_edge" in one), default=0
    )

    def about(definition: str, kind: str) -> dict[str, str]:
        return {"long_name": definition, "units": names.name(kind) or scene.units or UNSTATED}

    variables: dict[str, Any] = {}
    for name, quantity in ((name, QUANTITIES[name]) for name in shown):
        shape = tuple(sizes[dim] for dim in quantity.dims)
        scaled = _gathered(every, name, shape)
        scaled *= getattr(problem.units, quantity.unit)
        variables[name] = (
            ("solver", *quantity.dims),
            scaled,
            about(quantity.definition, quantity.unit),
        )
        if name in ("contact", "contact_edge"):
            continue
        shape = tuple(sizes[dim] for dim in quantity.error_dims)
        of_error = about(ERROR.format(name, NORMS[quantity.norm]), "share")
        variables[error_name(name)] = (
            ("solver", *quantity.error_dims),
            _gathered(errors, name, shape),
            of_error,
        )
    answers = list(result.answers.values())
    for name, quantity in ANSWER.items():
        shape = tuple(sizes[dim] for dim in quantity.dims)
        variables[name] = (
            ("solver", *quantity.dims),
            _gathered(answers, name, shape),
            about(quantity.definition, quantity.unit),
        )
    edges, coefficients = (
        problem.ring_edges * problem.units.length,
        problem.wear_coefficients * problem.units.wear_coefficient,
    )
    # as they were asked for: by way of the non-dimensional ones they would differ in the last digit
    given = scene.output.radii
    radius = problem.radii * problem.units.length if given is None else np.array(given, dtype=float)
    coordinates = {
        "solver": list(solutions),
        "time": ("time", np.array(scene.wear.times), about("time of sliding", "time")),
        "radius": ("radius", radius, about("distance from the axis", "length")),
        "ring": (
            "ring",
            np.arange(1, sizes["ring"] + 1),
            {"long_name": "ring, counted from the centre"},
        ),
        "ring_inner_radius": ("ring", edges[:-1], about("inner edge of the ring", "length")),
        "ring_outer_radius": ("ring", edges[1:], about("outer edge of the ring", "length")),
        "wear_coefficient": (
            "ring",
            coefficients,
            about("k of df/dt = k p v0 on the ring", "wear_coefficient"),
        ),
        "mode": ("mode", np.arange(1, SHOWN + 1), {"long_name": "wear mode, slowest first"}),
        "state": list(STATES),
    }
    if sizes["edge"]:
        meaning = "edge of the contact: inner and outer of each part in turn, from the centre"
        coordinates["edge"] = ("edge", np.arange(1, sizes["edge"] + 1), {"long_name": meaning})
    return xarray.Dataset(variables, coordinates, _attributes(scene))


def _gathered(every: list[dict[str, Array]], name: str, shape: tuple[int, ...]) -> Array:
    """(methods, *shape) values, NaN where a method has none."""
    out = np.full((len(every), *shape), np.nan)
    for row, results in enumerate(every):
        if name in results:
            known = common(results[name].shape, shape)
            out[row, ...][known] = results[name][known]
    return out


def _attributes(scene: Scene) -> dict[str, str]:
    return {
        "title": scene.title,
        "units": scene.units or UNSTATED,
        "definitions": (
            "positive profile: material gone; in contact u_z = d - f; means over the radius "
            "(line) or area"
        ),
        "gradient_average": scene.output.gradient_average,
        "versions": json.dumps(versions()),
        "scene": scene.to_toml(),
    }


def summary(result: Result) -> dict[str, Any]:
    """The run in a page.

    Verdict, cost, error estimates, agreement, what was modelled and what was left out.
    """
    scene, rtol = result.scene, result.scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {
                stage: round(value, 6) for stage, value in result.stages[name].seconds.items()
            },
            "unknowns": solution.unknowns,
            "settings": solution.settings,
            "rtol_asked": rtol,
            "error_estimate": solution.error_estimate,
            "reaches_rtol": name not in result.short_of,
            "error_estimate_parts": solution.parts,
            "beyond_rtol": solution.beyond(rtol),
        }
        for name, solution in result.solutions.items()
    }
    numbers = ("rings", "history", "space", "worst_radius", "stability", "residual")
    return {
        "title": scene.title,
        "units": scene.units,
        "verdict": result.verdict,
        "quantities": result.quantities,
        "answer": {
            name: {key: _json(value) for key, value in one.items()}
            for name, one in result.answers.items()
        },
        "methods": methods,
        "agreement": [asdict(row) | {"agrees": row.agrees} for row in result.agreement],
        "agrees": result.agrees,
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "operator_difference": [
            {"methods": list(row.methods)} | {name: getattr(row, name) for name in numbers}
            for row in result.operators
        ],
        "definitions": DEFINITIONS
        | {name: NORMS[quantity.norm] for name, quantity in QUANTITIES.items()}
        | {name: quantity.definition for name, quantity in ANSWER.items()},
        "modelled": modelled(scene),
        "left_out": left_out(scene),
        "notes": result.notes,
        "versions": versions(),
    }


def _json(value: Array) -> Any:
    """Numbers as JSON has them: null for what is infinite or unknown."""
    if value.ndim:
        return [_json(part) for part in value]
    return float(value) if np.isfinite(value) else None
