"""What the results of all scenes have in common.

Variables, their shapes, and the axes beyond those of the sweep.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..methods.quantities import ERROR, NORMS, STATES, error_name
from ..problem.unit_names import KINDS, UNSTATED, UnitNames
from ..wear.modes import SHOWN
from .axes import Sweep
from .kept import ANSWERS, JUDGED, keepable

# keys that leave relaxation times as they are
OF_ONE_TIME_SCALE = (
    "load.normal_force",
    "load.mean_pressure",
    "accuracy.",
    "output.",
    "wear.",
    "methods",
    "title",
    "units",
)
# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Variable:
    """A variable of the store: dimensions and shape beyond those of the sweep, and its
    attributes.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Layout:
    """What the results of all scenes have in common.

    Parameters
    ----------
    solvers : methods of any scene
    coordinates : of the dimensions that are not the sweep's, in the scenes' units: name, values
    about : attributes of coordinates, the sweep's own among them
    variables : by name
    """

    solvers: tuple[str, ...]
    coordinates: dict[str, Array]
    about: dict[str, dict[str, str]]
    variables: dict[str, Variable]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a block has become.

    Parameters
    ----------
    values : of the layout's variables, the first axis running over the scenes of the block
    status, reason : of each scene
    computed_by : fingerprint of the ringwear that computed it; releases without one send none
    """

    values: dict[str, Array]
    status: Any
    reason: list[str]
    computed_by: str = ""


def layout(sweep: Sweep) -> Layout:
    """The layout of a sweep.

    Raises
    ------
    SceneError
        if scenes differ in the times or radii that the kept quantities are at
    """
    first = sweep.scene((0,) * len(sweep.axes))
    known = keepable()
    dims = {dim for name in sweep.keep for dim in known[name].dims}
    keys = {key: values for axis in sweep.axes for key, values in axis.columns.items()}
    _check_times(sweep, dims, keys)
    if "radius" in dims and (
        first.output.radii is None or {"output.radii", "punch.radius"} & set(keys)
    ):
        raise SceneError(
            f"{sweep.name}: {_needing('radius', sweep)} is kept at radii that all scenes share: "
            "give the base "
            "output.radii, and vary neither them nor punch.radius"
        )
    rings = [first.punch.rings or len(first.punch.ring_edges or []), *keys.get("punch.rings", [])]
    rings += [len(edges) for edges in keys.get("punch.ring_edges", [])]
    methods = keys.get("methods", [first.methods])
    coordinates: dict[str, Any] = {
        "time": np.array(first.wear.times, dtype=float),
        "radius": np.array(first.output.radii or [], dtype=float),
        "ring": np.arange(1, max(rings) + 1),
        "mode": np.arange(1, SHOWN + 1),
        "state": np.array(STATES),
    }
    solvers = tuple(dict.fromkeys(name for names in methods for name in names))
    sizes = {"solver": len(solvers)} | {dim: len(values) for dim, values in coordinates.items()}
    stated = "" if "units" in keys else first.units
    names = UnitNames.of(stated)

    def unit(kind: str) -> str:
        return names.name(kind) or stated or UNSTATED

    variables: dict[str, Variable] = {}

    def add(label: str, own: tuple[str, ...], long_name: str, kind: str) -> None:
        whole = ("solver", *own)
        shape = tuple(sizes[dim] for dim in whole)
        variables[label] = Variable(whole, shape, {"long_name": long_name, "units": unit(kind)})

    for name in sweep.keep:
        quantity = known[name]
        add(name, quantity.dims, quantity.definition, quantity.unit)
        if name not in ANSWERS:
            long_name = ERROR.format(name, NORMS[quantity.norm])
            add(error_name(name), quantity.error_dims, long_name, "number")
    if len(solvers) > 1:
        variables |= {
            name: Variable((), (), {"long_name": text, "units": "1"})
            for name, text in JUDGED.items()
        }
    about = {
        "time": {"long_name": "time of sliding", "units": unit("time")},
        "radius": {"long_name": "distance from the axis", "units": unit("length")},
        "ring": {"long_name": "ring, counted from the centre"},
        "mode": {"long_name": "wear mode, slowest first"},
    }
    for name, _, values, key in sweep.coordinates():
        about[name] = {"long_name": key}
        if key in KINDS or not any(isinstance(value, str) for value in values):
            about[name]["units"] = unit(KINDS.get(key, "number"))
    return Layout(
        solvers,
        {dim: values for dim, values in coordinates.items() if dim in dims},
        about,
        variables,
    )


def _check_times(sweep: Sweep, dims: set[str], keys: dict[str, list[Any]]) -> None:
    """Refuse what is kept over times that scenes do not share."""
    if "time" in dims and "wear.times" in keys:
        raise SceneError(
            f"{sweep.name}: wear.times varies, and {_needing('time', sweep)} is kept: give one list"
        )
    times = [sweep.table["base"].get("wear", {}).get("times"), *keys.get("wear.times", [])]
    counted = any(isinstance(value, str | dict) for value in times)
    kept = [name for name in sweep.keep if "time" in keepable()[name].dims or name == "worn_volume"]
    varied = [key for key in keys if not key.startswith(OF_ONE_TIME_SCALE)]
    if counted and kept and varied:
        remedy = "give wear.times as numbers, or keep only what is not over time"
        raise SceneError(
            f"{sweep.name}: wear.times counts relaxation times, which {varied[0]} may change, "
            f"and {kept[0]} is kept at times that all scenes share: {remedy}"
        )


def _needing(dim: str, sweep: Sweep) -> str:
    return next(name for name in sweep.keep if dim in keepable()[name].dims)
