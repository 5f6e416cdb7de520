"""The results of all methods as an xarray Dataset, in the scene's units."""

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....meshes.radial import Array
from ..methods.base import Solution
from ..problem.norms import Results, common
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
from ..versions import versions
from ..wear.modes import SHOWN_RELAXATION_TIMES

if TYPE_CHECKING:
    import xarray

Arrays = dict[str, tuple[tuple[str, ...], Array, dict[str, str]]]
"""Dimensions, values and attributes of arrays, by name."""


class StepsOfMarch(NamedTuple):
    """The steps of a march: `problem.quantities.Path`.

    Parameters
    ----------
    path : (S, 4) time, indentation from the first touch, force and relative contact area
    standoff : height of the plane of the face above the first touch
    """

    path: Array
    standoff: float


def tabulate(
    scene: Scene,
    solutions: Mapping[str, Solution],
    answers: Mapping[str, dict[str, Array]],
) -> "xarray.Dataset":
    """Return all results and answers of methods; NaN if a method does not compute a quantity."""
    import xarray  # help, plans and refusals need none

    problem, reported = scene.problem, []
    units, names = problem.units, scene.unit_names
    for name, solution in solutions.items():
        results, march = solution.results, solution.march
        if scene.output.every_step and march is not None:
            path = StepsOfMarch(march.path, problem.profile.standoff)
            steps = {name: np.asarray(step.value(path)) for name, step in STEPS.items()}
            results = results | steps
        errors = {error_name(key): error for key, error in solution.errors.items()}
        # with their units; scaled copies of all fields would take as much memory as the table
        scaled = {key: (results[key], size) for key, size in unit_sizes(problem, results).items()}
        final = {key: (values, 1.0) for key, values in (errors | answers[name]).items()}
        reported.append(scaled | final)

    def longest(name: str) -> int:
        return max((values[name][0].shape[-1] for values in reported if name in values), default=0)

    sizes = {
        "time": len(problem.times),
        "radius": len(problem.radii),
        "ring": len(problem.wear_coefficients),
        "mode": SHOWN_RELAXATION_TIMES,
        "state": len(STATES),
        "edge": longest("contact_edge"),
        "step": longest("step_time"),
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

    variables: Arrays = {}
    for name, dims, unit, definition in table:
        array = np.full((len(reported), *(sizes[dim] for dim in dims)), np.nan)
        for row, values in enumerate(reported):
            if name in values:
                own, scale = values[name]
                common_part = common(own.shape, array.shape[1:])
                array[row, ...][common_part] = own[common_part] * scale
        variables[name] = (("solver", *dims), array, describe(definition, unit))
    # take the radii from the scene, because scaling non-dimensional ones may change the last digit
    radius = problem.radii * units.length if scene.output.radii is None else scene.output.radii
    inner, outer = problem.ring_edges[:-1] * units.length, problem.ring_edges[1:] * units.length
    coefficients = problem.wear_coefficients * units.wear_coefficient
    about_coefficients = describe(
        "k of df/dt = k p v0 on the ring, its harmonic mean by area", "wear_coefficient"
    )
    times = np.array(scene.wear.times[: sizes["time"]], dtype=float)
    about_times = describe("sliding distance" if names.distances else "time of sliding", "time")
    coordinates: Arrays = {
        "solver": (("solver",), np.array(list(solutions)), {}),
        "state": (("state",), np.array(STATES), {}),
        "time": (("time",), times, about_times),
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
            coordinates[dim] = ((dim,), np.array(range(1, sizes[dim] + 1)), {"long_name": meaning})
    attributes_of_table = {
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
    return xarray.Dataset(variables, coordinates, attributes_of_table)


def in_units(problem: Problem, results: Results) -> dict[str, Array]:
    """Return the quantities of non-dimensional results in the units of the scene."""
    return {name: results[name] * size for name, size in unit_sizes(problem, results).items()}


def unit_sizes(problem: Problem, names: Iterable[str]) -> dict[str, float]:
    """Return the sizes of the units of those names that are quantities, in the scene's units."""
    described = QUANTITIES | ANSWER | STEPS
    return {
        name: float(getattr(problem.units, described[name].unit))
        for name in names
        if name in described
    }
