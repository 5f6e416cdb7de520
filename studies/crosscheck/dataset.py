"""The result of a run, as an xarray Dataset (netCDF-4) and as a summary (JSON), in the scene's
units.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array
from ..methods.base import Method, Solution
from ..methods.quantities import (
    ANSWER,
    ERROR,
    NORMS,
    OF_PROFILES,
    QUANTITIES,
    STATES,
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
    methods : by their names
    solutions : by method
    stages : seconds by method
    agreement : of every two methods, by quantity
    operators : of every two compliances
    """

    scene: Scene
    methods: Mapping[str, Method]
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
        counts = [f"{verdicts.count(AGREE)} of {len(verdicts)} quantities agree"]
        counts += [f"{verdicts.count(of)} {of}" for of in (UNDECIDED, DISAGREE) if of in verdicts]
        promised = "" if set(verdicts) == {AGREE} else " in all that is promised"
        words = {
            AGREE: f"The methods agree{promised}",
            UNDECIDED: "Not all is decided",
            DISAGREE: "THE METHODS DISAGREE",
        }
        return f"{words[self.verdict]}: {', '.join(counts)}."

    @property
    def short_of(self) -> dict[str, float]:
        """Error estimates of the indentation that are above the accuracy asked for, by method."""
        estimates = {name: solution.error_estimate for name, solution in self.solutions.items()}
        rtol = self.scene.accuracy.rtol
        return {name: estimate for name, estimate in estimates.items() if estimate > rtol}

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
        problem, answers = self.scene.problem, {}
        for name, solution in self.solutions.items():
            given = answer(problem, solution)
            given |= {key: np.asarray(solution.results.get(key, np.nan)) for key in ALSO}
            answers[name] = {
                key: value * getattr(problem.units, (ANSWER | QUANTITIES)[key].unit)
                for key, value in given.items()
            }
        return answers

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
    """Return all results over dimensions solver, time, radius, ring and mode.

    NaN where a method does not give a quantity.
    """
    scene, problem, solutions = result.scene, result.scene.problem, result.solutions
    units, names = problem.units, UnitNames.of(scene.units)
    results = [values(solution.results) for solution in solutions.values()]
    errors = [solution.errors for solution in solutions.values()]
    answers = list(result.answers.values())
    edges = [given["contact_edge"].shape[1] for given in results if "contact_edge" in given]
    sizes = {
        "time": len(problem.times),
        "radius": len(problem.radii),
        "ring": len(problem.wear_coefficients),
        "mode": SHOWN,
        "state": len(STATES),
        "edge": max(edges, default=0),
    }
    variables: dict[str, Any] = {}

    def about(definition: str, kind: str = "number") -> dict[str, str]:
        return {"long_name": definition, "units": names.name(kind) or scene.units or UNSTATED}

    def add(
        name: str,
        given: Sequence[Mapping[str, Array]],
        dims: tuple[str, ...],
        scale: float,
        attributes: dict[str, str],
    ) -> None:
        gathered = np.full((len(given), *(sizes[dim] for dim in dims)), np.nan)
        for row, of_method in enumerate(given):
            if name in of_method:
                shared = common(of_method[name].shape, gathered.shape[1:])
                gathered[row, ...][shared] = of_method[name][shared]
        variables[name] = ("solver", *dims), scale * gathered, attributes

    for name, quantity in QUANTITIES.items():
        # a flat punch has no more to say
        if name in OF_PROFILES and not any(name in given for given in results):
            continue
        scale = getattr(units, quantity.unit)
        add(name, results, quantity.dims, scale, about(quantity.definition, quantity.unit))
        if name not in ("contact", "contact_edge"):
            estimates = [{error_name(of): error for of, error in given.items()} for given in errors]
            attributes = about(ERROR.format(name, NORMS[quantity.norm]))
            add(error_name(name), estimates, quantity.error_dims, 1.0, attributes)
    for name, quantity in ANSWER.items():
        add(name, answers, quantity.dims, 1.0, about(quantity.definition, quantity.unit))
    # as they were asked for: by way of the non-dimensional ones they would differ in the last digit
    radius = problem.radii * units.length if scene.output.radii is None else scene.output.radii
    ring_edges = problem.ring_edges * units.length
    coefficients = problem.wear_coefficients * units.wear_coefficient
    coordinates = [
        ("time", "time", scene.wear.times, about("time of sliding", "time")),
        ("radius", "radius", radius, about("distance from the axis", "length")),
        ("ring_inner_radius", "ring", ring_edges[:-1], about("inner edge of the ring", "length")),
        ("ring_outer_radius", "ring", ring_edges[1:], about("outer edge of the ring", "length")),
        (
            "wear_coefficient",
            "ring",
            coefficients,
            about("k of df/dt = k p v0 on the ring", "wear_coefficient"),
        ),
    ]
    numbered = {
        "ring": "ring, counted from the centre",
        "mode": "wear mode, slowest first",
        "edge": "edge of the contact: inner and outer of each part in turn, from the centre",
    }
    coordinates += [
        (dim, dim, np.arange(1, sizes[dim] + 1), {"long_name": meaning})
        for dim, meaning in numbered.items()
        if sizes[dim]
    ]
    labels = {name: (dim, np.asarray(given), of) for name, dim, given, of in coordinates}
    states = {"solver": list(solutions), "state": list(STATES)}
    return xarray.Dataset(variables, labels | states, _attributes(scene))


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
    """Return the run in a page.

    Verdict, cost, error estimates, agreement, what was modelled and what was left out.
    """
    scene, rtol = result.scene, result.scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {
                stage: round(seconds, 6) for stage, seconds in result.stages[name].seconds.items()
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
    numbers = ("methods", "rings", "history", "space", "worst_radius", "stability", "residual")
    return {
        "title": scene.title,
        "units": scene.units,
        "verdict": result.verdict,
        "quantities": result.quantities,
        "answer": {
            name: {key: _without_infinity(value.tolist()) for key, value in given.items()}
            for name, given in result.answers.items()
        },
        "methods": methods,
        "agreement": [asdict(row) | {"agrees": row.agrees} for row in result.agreement],
        "agrees": result.agrees,
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "operator_difference": [
            {name: getattr(row, name) for name in numbers} for row in result.operators
        ],
        "definitions": DEFINITIONS
        | {name: NORMS[quantity.norm] for name, quantity in QUANTITIES.items()}
        | {name: quantity.definition for name, quantity in ANSWER.items()},
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods),
        "notes": result.notes,
        "versions": versions(),
    }


def _without_infinity(value: Any) -> Any:
    """Return numbers as JSON has them: null for what is infinite or not given."""
    if isinstance(value, list):
        return [_without_infinity(part) for part in value]
    return value if np.isfinite(value) else None
