"""The empty results of a sweep, and the blocks of scenes that are computed together."""

import json
from itertools import product
from math import prod

import numpy as np
import xarray
from numpy.typing import ArrayLike

from ..crosscheck import Scene, UnitNames, error_name
from ..crosscheck.problem.quantities import ERROR, STATES
from ..crosscheck.problem.unit_names import kind_of
from ..crosscheck.versions import code, versions
from ..crosscheck.wear.modes import SHOWN_RELAXATION_TIMES
from .axes import ANSWERS, KEEPABLE, Sweep
from .flags import PENDING

# beginnings of keys in which scenes of a flat punch may differ and still share a discretisation
SHARED_KEYS = (
    *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
    *("load.", "wear.", "output.", "title"),
)


def identity(sweep: Sweep) -> dict[str, str]:
    """Return the attributes that tell the results of sweeps apart: sweep, versions and code."""
    return {
        "sweep": json.dumps(sweep.table),
        "versions": json.dumps(versions()),
        "code": code(),
    }


def template(sweep: Sweep) -> xarray.Dataset:
    """Return an empty dataset for the results of all scenes; its arrays are views without memory.

    The dimensions are those of the sweep, followed by `solver` and the dimensions of each quantity.
    """
    first_scene = sweep.first
    varied_values = {key: column.values for key, column in sweep.columns.items()}
    edges, ring_counts = (
        varied_values.get("punch.ring_edges", []),
        varied_values.get("punch.rings", []),
    )
    ring_count = max([len(first_scene.problem.rings.widths), *ring_counts, *map(len, edges)])
    units = UnitNames() if "units" in varied_values else first_scene.unit_names

    def described(text: str, kind: str = "number") -> dict[str, str]:
        return {"long_name": text, "units": units.name(kind)}

    coordinates: dict[str, object] = {
        "ring": np.arange(1, ring_count + 1),
        "mode": np.arange(1, SHOWN_RELAXATION_TIMES + 1),
        "state": np.array(STATES, dtype=object),
    }
    for key, (name, dim, values) in [*sweep.shared.items(), *sweep.columns.items()]:
        numbers = all(isinstance(value, int | float) for value in values)
        array = np.array(values if numbers else [*map(str, values)], None if numbers else object)
        coordinates[name] = dim, array, described(key, kind_of(key, Scene))
    dataset = xarray.Dataset(coords=coordinates)

    def add(
        name: str, dims: tuple[str, ...], label: dict[str, str], fill: ArrayLike = np.nan
    ) -> None:
        dims = (*sweep.sizes, *dims)
        dataset[name] = dims, np.broadcast_to(fill, [dataset.sizes[dim] for dim in dims]), label

    for name in sweep.keep:
        quantity = KEEPABLE[name]
        add(name, ("solver", *quantity.dims), described(quantity.definition, quantity.unit))
        if name not in ANSWERS:
            error = described(ERROR.format(name, quantity.norm.definition))
            add(error_name(name), ("solver", *quantity.error_dims), error)
    if dataset.sizes["solver"] > 1:
        definition = "greatest difference over its uncertainty; methods disagree if it is above 1"
        add("disagreement", (), described(definition))
    add("reason", (), described("reason why the scene failed"), np.array("", dtype=object))
    add(
        "code", (), described("hash of the code and versions that computed the scene"), np.uint64(0)
    )
    add("status", (), described("0: pending, 1: done, 2: failed"), np.uint8(PENDING))
    # drop coordinates that no variable has
    return dataset[[*dataset.data_vars]]


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
