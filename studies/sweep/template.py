"""The empty results of a sweep, and the blocks of scenes that are computed together."""

from itertools import product
from math import prod

import numpy as np
import xarray

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
    names = first.unit_names
    if "units" in varied:
        # numbers of several units have none
        names = UnitNames()
        for variable in run.variables.values():
            variable.attrs["units"] = NO_UNIT
    rings = map(len, varied.get("punch.ring_edges", []))
    count = max([run.sizes["ring"], *varied.get("punch.rings", []), *rings])
    kept = [each for name in sweep.keep for each in (name, error_name(name)) if each in run]
    dataset = run.reset_coords(drop=True).reindex(ring=np.arange(1, count + 1))[kept]
    if run.sizes["solver"] > 1:
        definition = "greatest difference over its uncertainty; methods disagree if it is above 1"
        dataset["disagreement"] = (), np.nan, described(definition)
    reason = np.array("", dtype=object)
    dataset["reason"] = (), reason, described("reason why the scene failed")
    status = described("0: pending, 1: done, 2: failed")
    dataset["status"] = (), np.uint8(PENDING), status
    dataset = dataset.expand_dims(sweep.sizes)
    for key, (name, dim, values) in [*sweep.shared.items(), *sweep.columns.items()]:
        numbers = all(isinstance(value, int | float) for value in values)
        array = np.array(values if numbers else [*map(str, values)], None if numbers else object)
        label = {"long_name": key, "units": names.name(kind_of(key, Scene))}
        dataset = dataset.assign_coords({name: (dim, array, label)})
    # drop coordinates that no variable has
    return dataset[[*dataset.data_vars]].drop_attrs(deep=False)


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
