"""Results as an xarray Dataset (netCDF-4) and a summary (JSON), in the scene's units."""

from __future__ import annotations

import json
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.scope import left_out, modelled
from ringwear.studies.methods.outcome import Outcome

if TYPE_CHECKING:
    import xarray
    from ringwear.studies.crosscheck.run import Result

MODES = 20

# name: dimensions after `method`, unit (of NaturalScene), definition
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "pressure": (("time", "radius"), "pressure", "contact pressure p(r, t)"),
    "profile": (("time", "radius"), "displacement", "worn height f(r, t) of the punch, material gone"),
    "displacement": (("time", "radius"), "displacement", "displacement u_z = d - f of the half-space under the punch"),
    "indentation": (("time",), "displacement", "indentation d(t) of the unworn face plane of the punch"),
    "displacement_centre": (("time",), "displacement", "u_z at the centre"),
    "displacement_max": (("time",), "displacement", "greatest u_z under the punch"),
    "rms_slope": (("time",), "slope", "root mean square of df/dr (Eq. 18), average: see gradient_average"),
    "ring_force": (("time", "ring"), "force", "normal force on each ring, from the centre"),
    "relaxation_time": (("mode",), "time", "relaxation times of the wear modes, slowest first"),
    "steady_pressure": (("radius",), "pressure", "contact pressure in the steady state (Eq. 24)"),
    "steady_profile": (("radius",), "displacement", "limiting profile, its minimum at zero (Eq. 27)"),
    "steady_displacement_max": ((), "displacement", "greatest u_z in the steady state, u_max of Eq. 27"),
    "steady_rms_slope": ((), "slope", "root mean square slope of the limiting profile (Eq. 18)"),
    "steady_wear_rate": ((), "wear_rate", "df/dt in the steady state (Eq. 23)"),
}
ERRORS = {
    "indentation_error": ("indentation", "relative error of the indentation, the method's own estimate"),
    "steady_rms_slope_error": ("steady_rms_slope", "relative error of steady_rms_slope, the method's own estimate"),
}


def dataset(result: Result) -> xarray.Dataset:
    """All outcomes over dimensions method, time, radius, ring and mode; NaN where a method does not give a quantity."""
    import xarray

    natural = result.scene.natural
    methods = list(result.outcomes)
    sizes = {"time": len(natural.times), "radius": len(natural.radii), "ring": len(natural.wear), "mode": MODES}
    unit = {name: getattr(natural, name) for name in ("pressure", "displacement", "force", "time", "wear_rate")}
    unit["slope"] = natural.displacement / natural.length
    stated = result.scene.units or "the scene's own consistent units"

    def gathered(outcomes: dict[str, Outcome], name: str, dims: tuple[str, ...]) -> Array:
        shape = tuple(sizes[dim] for dim in dims)
        return np.stack([_filled(getattr(outcomes[method], name), shape) for method in methods])

    variables: dict[str, Any] = {}
    for name, (dims, kind, definition) in VARIABLES.items():
        values = gathered(result.outcomes, name, dims) * unit[kind]
        variables[name] = (("method", *dims), values, {"long_name": definition, "units": stated if kind != "slope" else "1"})
    for name, (of, definition) in ERRORS.items():
        dims = VARIABLES[of][0]
        variables[name] = (("method", *dims), gathered(result.errors, of, dims), {"long_name": definition, "units": "1"})
    coordinates = {
        "method": methods,
        "time": ("time", natural.times * natural.time, {"long_name": "time of sliding", "units": stated}),
        "radius": ("radius", natural.radii * natural.length, {"long_name": "distance from the axis", "units": stated}),
        "ring": ("ring", np.arange(1, sizes["ring"] + 1), {"long_name": "ring, counted from the centre"}),
        "mode": ("mode", np.arange(1, MODES + 1), {"long_name": "wear mode, slowest first"}),
    }
    attributes = {
        "title": result.scene.title,
        "units": stated,
        "definitions": "positive profile: material gone; in contact u_z = d - f; means over the radius (line) or area",
        "gradient_average": result.scene.output.gradient_average,
        "versions": json.dumps(versions()),
        "scene": result.scene.to_toml(),
    }
    return xarray.Dataset(variables, coordinates, attributes)


def _filled(values: Array, shape: tuple[int, ...]) -> Array:
    out = np.full(shape, np.nan)
    if values.size:
        values = values.reshape(shape) if shape == () else values
        common = tuple(slice(0, min(a, b)) for a, b in zip(values.shape, shape, strict=True))
        out[common] = values[common]
    return out


def versions() -> dict[str, str]:
    """Versions of ringwear and of what it computes with."""
    found = {}
    for name in ("ringwear", "numpy", "scipy", "scikit-fem", "gmsh", "meshio", "xarray"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def summary(result: Result) -> dict[str, Any]:
    """The run in a page: cost, error estimates, agreement, what was modelled and what was left out."""
    methods = {
        name: {
            "seconds": {stage: round(value, 6) for stage, value in stages.seconds.items()},
            "unknowns": result.models[name].unknowns if name in result.models else 0,
            "settings": result.models[name].settings if name in result.models else {},
            "rtol_asked": result.scene.accuracy.rtol,
            "error_estimate": result.estimates[name],
            "reaches_rtol": name not in result.short_of,
            "error_estimate_parts": result.parts[name],
        }
        for name, stages in result.stages.items()
    }
    agreement = [
        {"quantity": row.quantity, "methods": list(row.methods), "difference": row.difference,
         "uncertainty": row.uncertainty, "agrees": row.agrees}
        for row in result.agreement
    ]  # fmt: skip
    return {
        "title": result.scene.title,
        "units": result.scene.units,
        "methods": methods,
        "agreement": agreement,
        "agrees": result.agrees,
        "operator_difference": [
            {
                "methods": list(row.methods),
                "rings": row.rings,
                "history": row.history,
                "space": row.space,
                "worst_radius": row.worst_radius,
                "stability": row.stability,
                "residual": row.residual,
            }
            for row in result.operators
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
        "modelled": modelled(result.scene),
        "left_out": left_out(result.scene),
        "notes": list(result.notes),
        "versions": versions(),
    }
