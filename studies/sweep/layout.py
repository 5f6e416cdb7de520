"""What the results of all scenes have in common: variables, labels, units, and blocks of scenes.

A block is what is computed at once, written at once as one file (a shard) of each variable and,
after an interruption, computed again.
"""

from math import ceil, prod
from typing import Any

import numpy as np
import xarray

from ...meshes.errors import SceneError
from ..methods.quantities import ERROR, NORMS, STATES, error_name
from ..problem.unit_names import KINDS, UNSTATED, UnitNames
from ..wear.modes import SHOWN
from .axes import ANSWERS, KEEPABLE, Axis, Sweep

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2
# keys that leave relaxation times as they are
OF_ONE_TIME_SCALE = (
    *("load.normal_force", "load.mean_pressure", "accuracy.", "output.", "wear."),
    *("methods", "title", "units"),
)
# keys that scenes may differ in and yet share a discretisation: wear, load, time and units
SHARING = (
    *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
    *("load.", "wear.", "output.", "title"),
)


def template(sweep: Sweep) -> xarray.Dataset:
    """Return the results of all scenes before any is computed, as views that take no memory.

    Dimensions are the sweep's, then `solver` and those of each quantity.

    Raises
    ------
    SceneError
        if scenes differ in the times or radii that the quantities to keep are at
    """
    first = sweep.scene((0,) * len(sweep.axes))
    keys = {key: values for axis in sweep.axes for key, values in axis.columns.items()}
    dims = {dim for name in sweep.keep for dim in KEEPABLE[name].dims}
    _check_times(sweep, keys)
    if "radius" in dims and (
        first.output.radii is None or {"output.radii", "punch.radius"} & set(keys)
    ):
        raise SceneError(
            f"{sweep.name}: keep names quantities at radii, which all scenes share: give the base "
            "output.radii, and vary neither them nor punch.radius"
        )
    rings = [first.punch.rings or len(first.punch.ring_edges or []), *keys.get("punch.rings", [])]
    rings += [len(edges) for edges in keys.get("punch.ring_edges", [])]
    methods = [name for names in keys.get("methods", [first.methods]) for name in names]
    stated = "" if "units" in keys else first.units

    def about(text: str, kind: str) -> dict[str, str]:
        unit = UnitNames.of(stated).name(kind) or stated or UNSTATED
        return {"long_name": text, "units": unit}

    labels: dict[str, tuple[Any, dict[str, str]]] = {
        "time": (np.array(first.wear.times, dtype=float), about("time of sliding", "time")),
        "radius": (np.array(first.output.radii or []), about("distance from the axis", "length")),
        "ring": (np.arange(1, max(rings) + 1), {"long_name": "ring, counted from the centre"}),
        "mode": (np.arange(1, SHOWN + 1), {"long_name": "wear mode, slowest first"}),
        "state": (np.array(STATES, dtype=object), {}),
        "solver": (np.array(list(dict.fromkeys(methods)), dtype=object), {}),
    }
    coordinates = {
        name: (name, *label) for name, label in labels.items() if name in {*dims, "solver"}
    }
    for name, dim, key, values in sweep.coordinates():
        text = any(isinstance(value, str) for value in values)
        described = about(key, KINDS.get(key, "number"))
        if text and key not in KINDS:
            del described["units"]
        coordinates[name] = dim, np.array(values, dtype=object if text else None), described
    variables: dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]] = {}
    for name in sweep.keep:
        quantity = KEEPABLE[name]
        description = about(quantity.definition, quantity.unit)
        variables[name] = ("solver", *quantity.dims), np.nan, description
        if name not in ANSWERS:
            error = about(ERROR.format(name, NORMS[quantity.norm]), "number")
            variables[error_name(name)] = ("solver", *quantity.error_dims), np.nan, error
    if len(labels["solver"][0]) > 1:
        greatest = "greatest difference of two methods over its uncertainty: above 1 they disagree"
        least = "least error stated, over the error that a far more accurate method shows"
        variables["disagreement"] = (), np.nan, about(greatest, "number")
        variables["effectivity"] = (), np.nan, about(least, "number")
    status = {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"}
    variables["status"] = (), np.uint8(PENDING), {"long_name": "what became of the scene"} | status
    variables["reason"] = (), np.array("", dtype=object), {"long_name": "why it is not done"}
    sizes = dict(zip(sweep.dims, sweep.shape, strict=True))
    sizes |= {name: len(values) for name, (values, _) in labels.items()}
    return xarray.Dataset(
        {
            name: (whole, np.broadcast_to(fill, [sizes[dim] for dim in whole]), attributes)
            for name, (own, fill, attributes) in variables.items()
            for whole in [(*sweep.dims, *own)]
        },
        coordinates,
        {"title": f"Sweep of {sweep.table['base'].get('title', 'a scene')}"},
    )


def _check_times(sweep: Sweep, keys: dict[str, list[Any]]) -> None:
    """Refuse to keep anything over times that scenes do not have in common."""
    over_time = [name for name in sweep.keep if "time" in KEEPABLE[name].dims]
    if over_time and "wear.times" in keys:
        raise SceneError(f"{sweep.name}: wear.times varies, and {over_time[0]} is kept over time")
    times = [sweep.table["base"].get("wear", {}).get("times"), *keys.get("wear.times", [])]
    varied = [key for key in keys if not key.startswith(OF_ONE_TIME_SCALE)]
    over_time += {"worn_volume"} & set(sweep.keep)
    if varied and over_time and any(isinstance(value, str | dict) for value in times):
        raise SceneError(
            f"{sweep.name}: wear.times counts relaxation times, which {varied[0]} may change, and "
            f"{over_time[0]} is kept at times that all scenes share: give wear.times as numbers, "
            "or keep only what is not over time"
        )


def block_shape(sweep: Sweep, blank: xarray.Dataset) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return scenes along each axis of a chunk (what is read at once), and of a block of chunks.

    A chunk holds the scenes of one geometry as far as that is not too many, for they share a
    discretisation; of few scenes it takes several geometries. A block is one file of each variable:
    small where a sweep is, so that little is lost with it.
    """
    # closed forms take a fraction of a millisecond
    least, most = (256, 1024) if blank["solver"].values.tolist() == ["direct"] else (8, 64)
    most = max(1, min(most, 2**26 * sweep.count // blank.nbytes))
    chunk = [1] * len(sweep.axes)
    lengths = list(sweep.shape)
    # the last axes first, as their scenes stand side by side in the store
    order = range(len(chunk))[::-1]
    alike = [number for number in order if shares_discretisation(sweep.axes[number])]
    others = [number for number in order if number not in alike]
    _fill(chunk, lengths, alike, most)
    _fill(chunk, lengths, others, min(least, most))
    chunks = [ceil(length / step) for length, step in zip(lengths, chunk, strict=True)]
    several = [1] * len(chunk)
    _fill(several, chunks, list(order), min(16, prod(chunks) // 128))
    return tuple(chunk), tuple(step * times for step, times in zip(chunk, several, strict=True))


def shares_discretisation(axis: Axis) -> bool:
    """Return whether scenes along an axis can share a discretisation."""
    return all(key.startswith(SHARING) for key in axis.columns)


def _fill(shape: list[int], lengths: list[int], order: list[int], most: int) -> None:
    """Lengthen a box along axes, in parts of about one length, to at most so many places."""
    for number in order:
        if (room := most // prod(shape)) > 1:
            shape[number] = ceil(lengths[number] / ceil(lengths[number] / room))
