"""The empty results of a sweep, and the blocks of scenes that are computed together."""

from collections.abc import Iterable
from itertools import product
from math import prod

import numpy as np
import xarray
from numpy.typing import ArrayLike

from ..crosscheck import (
    NO_UNIT,
    Scene,
    Solution,
    UnitNames,
    code,
    error_name,
    kind_of,
    package_versions,
    tabulate,
)
from ..tables.writing import json_text
from .axes import Sweep

# status of a scene
PENDING, DONE, FAILED = 0, 1, 2

# beginnings of keys in which scenes of a flat punch may differ and still share a discretisation
SHARED_KEYS = (
    *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
    *("load.", "wear.", "output.", "title"),
)


def identity(sweep: Sweep) -> dict[str, str]:
    """Return the attributes that tell the results of sweeps apart: sweep, versions and code."""
    return {
        "sweep": json_text(sweep.table),
        "versions": json_text(package_versions()),
        "code": code(),
    }


def template(sweep: Sweep) -> xarray.Dataset:
    """Return an empty dataset for the results of all scenes; its arrays are views without memory.

    Its variables are those of one run. The dimensions are those of the sweep, followed by `solver`
    and the dimensions of each quantity.
    """
    first, varied = sweep.first, {key: column.values for key, column in sweep.columns.items()}
    no_results = Solution({}, {}, {}, {})
    run = tabulate(first, dict.fromkeys(first.methods, no_results)).dataset
    rings = map(len, varied.get("punch.ring_edges", []))
    sizes = dict(run.sizes) | sweep.sizes
    sizes["ring"] = max([run.sizes["ring"], *varied.get("punch.rings", []), *rings])
    names = first.unit_names
    if "units" in varied:
        # numbers of several units have none
        names = UnitNames()
        for variable in run.variables.values():
            variable.attrs["units"] = NO_UNIT
    coordinates: dict[str, object] = {
        name: (run[name].dims, run[name].values, run[name].attrs) for name in ("mode", "state")
    }
    coordinates["ring"] = "ring", np.arange(1, sizes["ring"] + 1), run["ring"].attrs
    for key, (name, dim, values) in [*sweep.shared.items(), *sweep.columns.items()]:
        numbers = all(isinstance(value, int | float) for value in values)
        array = np.array(values if numbers else [*map(str, values)], None if numbers else object)
        label = {"long_name": key, "units": names.name(kind_of(key, Scene))}
        coordinates[name] = dim, array, label
    dataset = xarray.Dataset(coords=coordinates)

    def add(name: str, dims: Iterable[str], label: dict[str, str], fill: ArrayLike) -> None:
        dims = (*sweep.sizes, *dims)
        view = np.broadcast_to(fill, [sizes[dim] for dim in dims])
        # without `fastpath`, xarray would look at each text of a view
        dataset[name] = xarray.Variable(dims, view, label, fastpath=True)

    kept = [each for name in sweep.keep for each in (name, error_name(name)) if each in run]
    for name in kept:
        add(name, map(str, run[name].dims), run[name].attrs, np.nan)
    if run.sizes["solver"] > 1:
        definition = "greatest difference over its uncertainty; methods disagree if it is above 1"
        add("disagreement", (), described(definition), np.nan)
    add("reason", (), described("reason why the scene failed"), np.array("", dtype=object))
    add("status", (), described("0: pending, 1: done, 2: failed"), np.uint8(PENDING))
    # drop coordinates that no variable has
    return dataset[[*dataset.data_vars]]


def described(definition: str) -> dict[str, str]:
    """Return the attributes of a variable without a unit."""
    return {"long_name": definition, "units": NO_UNIT}


def block_sizes(sweep: Sweep, blank: xarray.Dataset) -> dict[str, int]:
    """Return the size of a block along each dimension of the sweep, in scenes.

    The scenes of a block are computed, written and read together. A block contains scenes of one
    geometry, up to a limit, because they share a discretisation. If one geometry has few scenes, or
    if punches are shaped, a block contains several geometries. Blocks of large sweeps are larger.
    """
    shared = SHARED_KEYS if sweep.first.problem.full_contact else ()
    scale = min(max(sweep.count // 8192, 1), 64)
    # scenes whose results take 128 MiB
    most_in_memory = 2**27 * sweep.count // blank.nbytes
    separate_dims = {
        column.dim for key, column in sweep.columns.items() if not key.startswith(shared)
    }
    block: dict[str, int] = {}
    # dimensions of scenes that share a discretisation come first; within both groups the last
    # dimension comes first, because its scenes are neighbours in the store
    last_first = list(sweep.sizes)[::-1]
    for dim in sorted(last_first, key=separate_dims.__contains__):
        greatest_size = min((8 if dim in separate_dims else 64) * scale, most_in_memory)
        block[dim] = max(1, min(greatest_size // prod(block.values()), sweep.sizes[dim]))
    return {dim: block[dim] for dim in sweep.sizes}


def regions(sweep: Sweep, block: dict[str, int]) -> list[dict[str, slice]]:
    """Return the slice of each dimension that each block covers.

    Parameters
    ----------
    sweep : the sweep
    block : size of a block along each dimension, as `block_sizes` returns it
    """
    parts = [
        [slice(start, start + block[dim]) for start in range(0, size, block[dim])]
        for dim, size in sweep.sizes.items()
    ]
    return [dict(zip(block, box, strict=True)) for box in product(*parts)]


def one_scene(sweep: Sweep, blank: xarray.Dataset) -> xarray.Dataset:
    """Return the empty results of one scene from those of all scenes."""
    return blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
