"""Results of methods as a table of arrays by name, in the scene's units."""

import json
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.norms import Results, common
from ..problem.problem import Problem
from ..problem.quantities import (
    ANSWER,
    ERROR,
    NORMS,
    OF_PROFILES,
    QUANTITIES,
    STATES,
    STEPS,
    Quantity,
    error_name,
)
from ..problem.scene import Scene
from ..problem.unit_names import NO_UNIT, UnitNames
from ..versions import versions
from ..wear.modes import SHOWN

Labelled = dict[str, tuple[tuple[str, ...], Array, dict[str, str]]]


class Table(NamedTuple):
    """Results as `xarray.Dataset` takes them: by name, dimensions, values and attributes of each.

    Most runs need no more, and xarray with all that it loads takes as long as some of them.
    """

    variables: Labelled
    coordinates: Labelled
    attributes: dict[str, str]


def tabulate(
    scene: Scene,
    solutions: Mapping[str, Solution],
    given_answers: Mapping[str, dict[str, Array]],
) -> Table:
    """Return all results of methods, with their answers, NaN where one does not give a quantity."""
    problem = scene.problem
    units, names = problem.units, UnitNames.of(scene.units)
    reported, table = [], dict[str, Quantity]()
    for name, solution in solutions.items():
        given = in_units(problem, solution.results)
        errors = {error_name(key): error for key, error in solution.errors.items()}
        reported.append(given | errors | given_answers[name])

    def gives(name: str) -> bool:
        return any(name in given for given in reported)

    for name, quantity in QUANTITIES.items():
        # a flat punch has no more to say
        if (name not in OF_PROFILES or gives(name)) and problem.wants(name):
            table[name] = quantity
            if name not in ("contact", "contact_edge"):
                definition = ERROR.format(name, NORMS[quantity.norm])
                table[error_name(name)] = Quantity(quantity.error_dims, "number", definition)
    edges = [given["contact_edge"].shape[1] for given in reported if "contact_edge" in given]
    sizes = {
        "time": len(problem.times),
        "radius": len(problem.radii),
        "ring": len(problem.wear_coefficients),
        "mode": SHOWN,
        "state": len(STATES),
        "edge": max(edges, default=0),
    }

    def describe(definition: str, kind: str) -> dict[str, str]:
        return {"long_name": definition, "units": names.name(kind)}

    variables: Labelled = {}
    answers = {name: of for name, of in ANSWER.items() if of.always or gives(name)}
    steps = _of_steps(problem, solutions) if scene.output.every_step else {}
    sizes["step"] = max((len(given["step_time"]) for given in steps.values()), default=0)
    if steps:
        for row, name in enumerate(solutions):
            reported[row] |= steps.get(name, {})
        table |= STEPS
    for name, quantity in (table | answers).items():
        gathered = np.full((len(reported), *(sizes[dim] for dim in quantity.dims)), np.nan)
        for row, given in enumerate(reported):
            if name in given:
                shared = common(given[name].shape, gathered.shape[1:])
                gathered[row, ...][shared] = given[name][shared]
        attributes = describe(quantity.definition, quantity.unit)
        variables[name] = (("solver", *quantity.dims), gathered, attributes)
    # as they were asked for: by way of the non-dimensional ones they would differ in the last digit
    radius = problem.radii * units.length if scene.output.radii is None else scene.output.radii
    inner, outer = problem.ring_edges[:-1] * units.length, problem.ring_edges[1:] * units.length
    coefficients = problem.wear_coefficients * units.wear_coefficient
    about_coefficients = describe(
        "k of df/dt = k p v0 on the ring, its harmonic mean by area", "wear_coefficient"
    )
    times = np.array(scene.wear.times[: sizes["time"]], dtype=float)
    coordinates: Labelled = {
        "solver": (("solver",), np.array(list(solutions)), {}),
        "state": (("state",), np.array(STATES), {}),
        "time": (("time",), times, describe("time of sliding", "time")),
        "radius": (("radius",), np.asarray(radius), describe("distance from the axis", "length")),
        "ring_inner_radius": (("ring",), inner, describe("inner edge of the ring", "length")),
        "ring_outer_radius": (("ring",), outer, describe("outer edge of the ring", "length")),
        "wear_coefficient": (("ring",), coefficients, about_coefficients),
    }
    for dim, meaning in (
        ("ring", "ring, counted from the centre"),
        ("mode", "wear mode, slowest first"),
        ("edge", "edge of the contact: inner and outer of each part in turn, from the centre"),
    ):
        if sizes[dim]:
            coordinates[dim] = ((dim,), np.arange(1, sizes[dim] + 1), {"long_name": meaning})
    about = {
        "title": scene.title,
        "units": scene.units or NO_UNIT,
        "definitions": (
            "positive profile: material gone; in contact u_z = d - f; means over the radius "
            "(line) or area"
        ),
        "gradient_average": scene.output.gradient_average,
        "versions": json.dumps(versions()),
        "scene": scene.to_toml(),
    }
    return Table(variables, coordinates, about)


def in_units(problem: Problem, results: Results) -> dict[str, Array]:
    """Return the quantities of non-dimensional results in the units of the scene."""
    described = QUANTITIES | ANSWER | STEPS
    return {
        name: value * getattr(problem.units, described[name].unit)
        for name, value in results.items()
        if name in described
    }


def _of_steps(problem: Problem, solutions: Mapping[str, Solution]) -> dict[str, dict[str, Array]]:
    """Return what is told at each step, by method: nothing of what has no steps."""
    offsets = np.array([0.0, problem.profile.standoff, 0.0, 0.0])
    return {
        name: in_units(problem, dict(zip(STEPS, (solution.march.path + offsets).T, strict=True)))
        for name, solution in solutions.items()
        if solution.march is not None
    }
