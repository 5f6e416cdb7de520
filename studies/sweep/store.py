"""The store: a Zarr group whose axes are the sweep's, readable by xarray while it grows.

A block of scenes is computed at once, and written at once as one file (a chunk) of each array, the
status of its scenes last: a block is finished if that is there. Nothing in the store depends on the
order of the blocks, on the clock or on the machine's name: an interrupted sweep ends with the same
bytes.
"""

import json
import shutil
import warnings
from itertools import product
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray
import zarr

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.quantities import ERROR, NORMS, STATES, error_name
from ..problem.unit_names import UnitNames, kind_of
from ..versions import versions
from ..wear.modes import SHOWN
from .axes import ANSWERS, KEEPABLE, Sweep

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2


def template(sweep: Sweep) -> xarray.Dataset:
    """Return the results of all scenes before any is computed, as views that take no memory.

    Dimensions are the sweep's, then `solver` and those of each quantity.
    """
    first, varied = sweep.first, {key: column.values for key, column in sweep.columns.items()}
    edges = varied.get("punch.ring_edges", [])
    rings = max([len(first.problem.rings.widths), *varied.get("punch.rings", []), *map(len, edges)])
    units = UnitNames.of("" if "units" in varied else first.units)

    def described(text: str, kind: str = "number") -> dict[str, str]:
        return {"long_name": text, "units": units.name(kind)}

    coordinates: dict[str, Any] = {
        "ring": np.arange(1, rings + 1),
        "mode": np.arange(1, SHOWN + 1),
        "state": np.array(STATES, dtype=object),
    }
    for key, (name, dim, values) in [*sweep.shared.items(), *sweep.columns.items()]:
        numbers = all(isinstance(value, int | float) for value in values)
        array = np.array(values if numbers else [*map(str, values)], None if numbers else object)
        coordinates[name] = dim, array, described(key, kind_of(key))
    dataset = xarray.Dataset(coords=coordinates)

    def add(name: str, dims: tuple[str, ...], label: dict[str, str], fill: Any = np.nan) -> None:
        dims = (*sweep.sizes, *dims)
        dataset[name] = dims, np.broadcast_to(fill, [dataset.sizes[dim] for dim in dims]), label

    for name in sweep.keep:
        quantity = KEEPABLE[name]
        add(name, ("solver", *quantity.dims), described(quantity.definition, quantity.unit))
        if name not in ANSWERS:
            error = described(ERROR.format(name, NORMS[quantity.norm]))
            add(error_name(name), ("solver", *quantity.error_dims), error)
    if dataset.sizes["solver"] > 1:
        definition = "greatest difference over its uncertainty: above 1 methods disagree"
        add("disagreement", (), described(definition))
    add("reason", (), described("why the scene has failed"), np.array("", dtype=object))
    add("status", (), described("0: pending, 1: done, 2: failed"), np.uint8(PENDING))
    # without labels that no variable has
    return dataset[[*dataset.data_vars]]


def block_sizes(sweep: Sweep, blank: xarray.Dataset) -> dict[str, int]:
    """Return how many scenes along each dimension are computed, written and read at once.

    A block holds the scenes of one geometry as far as that is not too many, for they share a
    discretisation; of few scenes, or of shaped punches, it takes several geometries. Large sweeps
    have larger blocks.
    """
    # beginnings of keys that scenes may differ in and yet share a discretisation
    sharing: tuple[str, ...] = ()
    if sweep.first.problem.full_contact:
        sharing = (
            *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
            *("load.", "wear.", "output.", "title"),
        )
    larger = min(max(sweep.count // 8192, 1), 64)
    in_memory = 2**27 * sweep.count // blank.nbytes
    unlike = {column.dim for key, column in sweep.columns.items() if not key.startswith(sharing)}
    block: dict[str, int] = {}
    # the last dimensions first, as their scenes stand side by side in the store
    last_first = list(sweep.sizes)[::-1]
    for dim in sorted(last_first, key=unlike.__contains__):
        most = min((8 if dim in unlike else 64) * larger, in_memory)
        block[dim] = max(1, min(most // prod(block.values()), sweep.sizes[dim]))
    return {dim: block[dim] for dim in sweep.sizes}


class Store:
    """The results of a sweep in a folder.

    Parameters
    ----------
    sweep : what is computed
    folder : where `sweep.zarr` is or will be
    resume : whether to go on with what is there

    Attributes
    ----------
    blank : the template of one scene
    """

    def __init__(self, sweep: Sweep, folder: Path, resume: bool) -> None:
        self.path = folder / "sweep.zarr"
        if self.path.exists() and not resume:
            raise SceneError(
                f"{self.path} is there: go on with it by --resume, or give another --out"
            )
        about = {"sweep": json.dumps(sweep.table), "versions": json.dumps(versions())}
        try:
            there = json.loads((self.path / "zarr.json").read_text("utf-8"))["attributes"]
        except (OSError, ValueError, KeyError):
            there = about  # not there, or damaged: made again
        if not about.items() <= there.items():
            raise SceneError(
                f"{self.path} was begun with another file, ringwear or libraries: go on by these, "
                "or give another --out"
            )
        blank = template(sweep)
        self.blank = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
        self._sweep, block = sweep, block_sizes(sweep, blank)
        parts = [
            [slice(start, start + block[dim]) for start in range(0, size, block[dim])]
            for dim, size in sweep.sizes.items()
        ]
        # the box of the grid that each block is
        self._regions = [dict(zip(block, box, strict=True)) for box in product(*parts)]
        encoding = {
            str(name): {"chunks": (*block.values(), *variable.shape[len(block) :])}
            for name, variable in blank.data_vars.items()
        }
        with TemporaryDirectory() as fresh, warnings.catch_warnings():
            # texts, and metadata in one place, are not in the specification yet
            warnings.simplefilter("ignore")
            # results that are all empty make no files
            blank.assign_attrs(about).to_zarr(fresh, mode="w", zarr_format=3, encoding=encoding)
            shutil.copytree(fresh, self.path, dirs_exist_ok=True)
        for left in self.path.rglob("*.partial"):
            left.unlink()
        self._group = zarr.open_group(self.path, mode="r+")

    def unfinished(self, retry_failed: bool) -> dict[int, Sweep]:
        """Return the blocks to compute, each as a sweep of its own, by number.

        They are those that are not finished, or cannot be read, and if wanted those in which scenes
        have failed.
        """
        final = (DONE,) if retry_failed else (DONE, FAILED)
        return {
            number: self._sweep.part(region)
            for number, region in enumerate(self._regions)
            if not self._is_finished(tuple(region.values()), final)
        }

    def _is_finished(self, place: tuple[slice, ...], final: tuple[int, ...]) -> bool:
        """Return whether all scenes of a block have a final status, and can be read."""
        try:
            if not np.isin(self._group["status"][place], final).all():
                return False
            for name in self.blank:
                _ = self._group[name][place]
        # what is damaged fails in many ways
        except Exception:
            return False
        return True

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block."""
        for name, array in values.items():
            self._group[name][tuple(self._regions[number].values())] = array

    def dataset(self) -> xarray.Dataset:
        """Return what is there so far, read when it is used."""
        # times in "hours" stay numbers
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)
