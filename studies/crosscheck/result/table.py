"""The results of all methods as a table, in the scene's units, and the answer in it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ....meshes.radial import Array
from ...tables.writing import json_text
from ..methods.base import Solution
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import (
    ANSWER,
    DESCRIBED,
    ERROR,
    NOT_COMPARED,
    QUANTITIES,
    STATES,
    STEPS,
    error_name,
)
from ..problem.unit_names import NO_UNIT
from ..scene.scene import Scene
from ..versions import package_versions
from ..wear.modes import SHOWN_RELAXATION_TIMES
from .output.files import CHECKSUMS, SUMMARY
from .output.table import Table, Variable

Answers = dict[str, dict[str, Array]]
"""The numbers of the answer, by method."""

COUNTED = ("mode", "edge", "step")
"""Dimensions in which the numbers of two methods may differ; the first ones correspond."""

# the numbers of the answer, and quantities that are reported together with them
REPORTED = (*ANSWER, "steady_wear_rate", "steady_rms_slope")


class StepsOfMarch(NamedTuple):
    """The steps of a march.

    Parameters
    ----------
    path : (S, 4) time, indentation from the first touch, force and relative contact area
    standoff : height of the plane of the face above the first touch
    """

    path: Array
    standoff: float


def tabulate(scene: Scene, solutions: Mapping[str, Solution]) -> Table:
    """Return the results of all methods; NaN if a method does not compute a quantity."""
    problem = scene.problem
    units, names = problem.units, scene.unit_names
    reported = [_reported(scene, solution) for solution in solutions.values()]

    def greatest_size(name: str) -> int:
        return max((values[name].shape[-1] for values in reported if name in values), default=0)

    sizes = {
        "time": len(problem.times),
        "radius": len(problem.radii),
        "ring": len(problem.wear_coefficients),
        "mode": SHOWN_RELAXATION_TIMES,
        "state": len(STATES),
        "edge": greatest_size("contact_edge"),
        "step": greatest_size(next(iter(STEPS))),
    }
    # name, dimensions, unit and definition of each variable
    table: list[tuple[str, tuple[str, ...], str, str]] = []
    for name, quantity in (QUANTITIES | STEPS | ANSWER).items():
        if name in STEPS and not sizes["step"]:
            continue
        if name in QUANTITIES and not problem.wants(name):
            continue
        table.append((name, quantity.dims, quantity.unit, quantity.definition))
        if name in DESCRIBED.keys() - NOT_COMPARED:
            definition = ERROR.format(name, quantity.norm.definition)
            table.append((error_name(name), quantity.error_dims, "number", definition))

    def describe(definition: str, kind: str) -> dict[str, str]:
        return {"long_name": definition, "units": names.name(kind)}

    variables = dict[str, Variable]()
    for name, dims, unit, definition in table:
        array = np.full([len(reported), *(sizes[dim] for dim in dims)], np.nan)
        shown = tuple(slice(sizes[dim] if dim in COUNTED else None) for dim in dims)
        for row, values in enumerate(reported):
            if name in values:
                part = values[name][shown]
                counts = zip(dims, part.shape, strict=True)
                place = [slice(count if dim in COUNTED else None) for dim, count in counts]
                array[(slice(row, row + 1), *place)] = part
        # in place: scaled copies of all fields would take as much memory as the table
        array *= getattr(units, unit)
        variables[name] = Variable(("solver", *dims), array, describe(definition, unit))
    # take the radii from the scene, because scaling non-dimensional ones may change the last digit
    radius = problem.radii * units.length if scene.output.radii is None else scene.output.radii
    inner, outer = problem.ring_edges[:-1] * units.length, problem.ring_edges[1:] * units.length
    coefficients = problem.wear_coefficients * units.wear_coefficient
    about_coefficients = describe(
        "k of df/dt = k p v0 on the ring, its harmonic mean by area", "wear_coefficient"
    )
    times = np.array(scene.wear.times[: sizes["time"]], dtype=float)
    about_times = describe("sliding distance" if names.distances else "time of sliding", "time")
    coordinates = {
        "solver": Variable(("solver",), np.array(list(solutions)), {}),
        "state": Variable(("state",), np.array(STATES), {}),
        "time": Variable(("time",), times, about_times),
        "radius": Variable(
            ("radius",), np.asarray(radius), describe("distance from the axis", "length")
        ),
        "ring_inner_radius": Variable(
            ("ring",), inner, describe("inner edge of the ring", "length")
        ),
        "ring_outer_radius": Variable(
            ("ring",), outer, describe("outer edge of the ring", "length")
        ),
        "wear_coefficient": Variable(("ring",), coefficients, about_coefficients),
    }
    for dim, meaning in (
        ("ring", "ring, counted from the centre"),
        ("mode", "wear mode, slowest first"),
        ("edge", "edge of the contact: inner and outer of each part in turn, from the centre"),
    ):
        if sizes[dim]:
            coordinates[dim] = Variable(
                (dim,), np.array(range(1, sizes[dim] + 1)), {"long_name": meaning}
            )
    attributes_of_table = {
        "title": scene.title,
        "units": scene.units or NO_UNIT,
        "definitions": (
            "positive profile: material gone; in contact u_z = d - f; means over the radius "
            "(line) or area"
        ),
        "gradient_average": scene.output.gradient_average,
        "versions": json_text(package_versions()),
        "scene": scene.to_toml(),
        CHECKSUMS: f"that of this file: {SUMMARY}",
    }
    return Table(variables, coordinates, attributes_of_table)


def _reported(scene: Scene, solution: Solution) -> dict[str, Array]:
    """Return the results of a solution and their errors, non-dimensional, by name.

    The steps of its march are among them if the scene asks for these.
    """
    values = {name: solution.results[name] for name in DESCRIBED if name in solution.results}
    values |= {
        error_name(name): solution.errors[name] for name in values if name in solution.errors
    }
    if scene.output.every_step and solution.evolution is not None:
        path = StepsOfMarch(solution.evolution.path, scene.problem.profile.standoff)
        values |= {name: np.asarray(step.value(path)) for name, step in STEPS.items()}
    return {name: np.asarray(array, dtype=float) for name, array in values.items()}


def in_units(problem: Problem, results: Results) -> dict[str, Array]:
    """Return the quantities of non-dimensional results in the units of the scene."""
    return {
        name: values * getattr(problem.units, DESCRIBED[name].unit)
        for name, values in results.items()
        if name in DESCRIBED
    }


def report(table: Table, method: str) -> dict[str, Array]:
    """Return the quantities of a method and the coordinates, by their names in a table."""
    row = table.coords["solver"].values.tolist().index(method)
    return {name: array.values for name, array in table.coords.items()} | {
        name: array.values[row] for name, array in table.data_vars.items()
    }


def by_method(table: Table, quantity: str, times: Any = ...) -> dict[str, Array]:
    """Return a quantity by the name of each method that computes it, at all or some times."""
    if quantity not in table.data_vars:
        return {}
    rows = zip(table.coords["solver"].values, table.data_vars[quantity].values, strict=True)
    selected = {str(name): values[times] for name, values in rows}
    return {name: values for name, values in selected.items() if not np.isnan(values).all()}


def answers_of(table: Table) -> Answers:
    """Return the numbers in a table and their errors; NaN if a method or a scene has none."""
    names = [*REPORTED, *map(error_name, REPORTED)]
    reports = {str(method): report(table, method) for method in table.coords["solver"].values}
    return {
        method: {name: np.asarray(values.get(name, np.nan)) for name in names}
        for method, values in reports.items()
    }
