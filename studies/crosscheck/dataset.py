"""Results as an xarray Dataset (netCDF-4) and a summary (JSON), in the scene's units."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import xarray

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.agreement import Agreement
from ringwear.studies.crosscheck.operators import OperatorDifference
from ringwear.studies.crosscheck.scope import left_out, modelled
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import QUANTITIES, array, common, error_name
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Stages

MODES = 20
ERROR = "relative error of {}, the method's own estimate"


def dataset(scene: Scene, solutions: Mapping[str, Solution]) -> xarray.Dataset:
    """All results over dimensions method, time, radius, ring and mode; NaN where a method does not give a quantity."""
    problem = scene.problem
    stated = scene.units or "the scene's own consistent units"
    sizes = {"time": len(problem.times), "radius": len(problem.radii), "ring": len(problem.wear_coefficients), "mode": MODES}
    every = [solution.results for solution in solutions.values()]
    variables: dict[str, Any] = {}
    for name, quantity in QUANTITIES.items():
        shape = tuple(sizes[dim] for dim in quantity.dims)
        about = {"long_name": quantity.definition, "units": "1" if quantity.unit == "slope" else stated}
        scaled = _gathered(every, name, shape) * getattr(problem.units, quantity.unit)
        variables[name] = (("method", *quantity.dims), scaled, about)
        about = {"long_name": ERROR.format(name), "units": "1"}
        variables[error_name(name)] = (("method", *quantity.dims), _gathered(every, error_name(name), shape), about)
    time, radius = problem.times * problem.units.time, problem.radii * problem.units.length
    coordinates = {
        "method": list(solutions),
        "time": ("time", time, {"long_name": "time of sliding", "units": stated}),
        "radius": ("radius", radius, {"long_name": "distance from the axis", "units": stated}),
        "ring": ("ring", np.arange(1, sizes["ring"] + 1), {"long_name": "ring, counted from the centre"}),
        "mode": ("mode", np.arange(1, MODES + 1), {"long_name": "wear mode, slowest first"}),
    }
    return xarray.Dataset(variables, coordinates, _attributes(scene, stated))


def _gathered(every: list[xarray.Dataset], name: str, shape: tuple[int, ...]) -> Array:
    """(methods, *shape) values, NaN where a method has none."""
    out = np.full((len(every), *shape), np.nan)
    for row, results in enumerate(every):
        if name in results:
            values = array(results, name)
            known = common(values.shape, shape)
            out[row, ...][known] = values[known]
    return out


def _attributes(scene: Scene, units: str) -> dict[str, str]:
    return {
        "title": scene.title,
        "units": units,
        "definitions": "positive profile: material gone; in contact u_z = d - f; means over the radius (line) or area",
        "gradient_average": scene.output.gradient_average,
        "versions": json.dumps(versions()),
        "scene": scene.to_toml(),
    }


def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    known = {}
    for name in ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "meshio", "xarray"):
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "not installed"
    return known


def summary(
    scene: Scene,
    solutions: Mapping[str, Solution],
    stages: Mapping[str, Stages],
    agreement: Sequence[Agreement],
    operators: Sequence[OperatorDifference],
) -> dict[str, Any]:
    """The run in a page: cost, error estimates, agreement, what was modelled and what was left out."""
    rtol = scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {stage: round(value, 6) for stage, value in stages[name].seconds.items()},
            "unknowns": solution.unknowns,
            "settings": solution.settings,
            "rtol_asked": rtol,
            "error_estimate": solution.error_estimate,
            "reaches_rtol": solution.error_estimate <= rtol,
            "error_estimate_parts": solution.parts,
        }
        for name, solution in solutions.items()
    }
    numbers = ("rings", "history", "space", "worst_radius", "stability", "residual")
    return {
        "title": scene.title,
        "units": scene.units,
        "methods": methods,
        "agreement": [asdict(row) | {"agrees": row.agrees} for row in agreement],
        "agrees": all(row.agrees for row in agreement),
        "operator_difference": [
            {"methods": list(row.methods)} | {name: getattr(row, name) for name in numbers} for row in operators
        ],
        "definitions": {
            "difference": "|a - b| / |b| where it is greatest against the uncertainty; of fields, the greatest over r",
            "uncertainty": "sum of the two methods' own relative error estimates at that place",
            "operator_difference": "of the energies two methods give the same pressures, relative: greatest over all "
            "ring-wise constant pressures (rings), along the history (history), over the first method's whole space "
            "(space, worst at worst_radius); stability: their least ratio, the square of the inf-sup constant; residual: "
            "first method's pressures put into the second, against the worn profile, in the energy norm",
            "error_estimate": "relative, of the indentation, over all times",
        },
        "modelled": modelled(scene),
        "left_out": left_out(scene),
        "notes": [note for solution in solutions.values() for note in solution.notes],
        "versions": versions(),
    }
