"""The store of a sweep: a Zarr group with the sweep's axes, readable by xarray while it grows.

The scenes of a block are computed together and then written as one file (a chunk) of each array.
The chunk of their status is written last. A block is finished if its status and all its other
chunks exist, if their checksums are right, and if it was computed by the code of the store. Nothing
in the store depends on the order of the blocks, on the clock or on the machine's name. A sweep that
was interrupted and resumed therefore ends with the same bytes as an undisturbed one.
"""

import json
import os
import warnings
from contextlib import suppress
from itertools import product
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray
import zarr
from numpy.typing import ArrayLike
from zarr.codecs import ZstdCodec

from ..crosscheck import Array, Scene, SceneError, UnitNames, error_name
from ..crosscheck.problem.quantities import ERROR, STATES
from ..crosscheck.problem.unit_names import kind_of
from ..crosscheck.versions import code, stamp, versions
from ..crosscheck.wear.modes import SHOWN_RELAXATION_TIMES
from .axes import ANSWERS, KEEPABLE, Sweep
from .flags import DONE, FAILED, PENDING

# beginnings of keys in which scenes of a flat punch may differ and still share a discretisation
SHARED_KEYS = (
    *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
    *("load.", "wear.", "output.", "title"),
)
# file of a Zarr group with its metadata
ROOT = "zarr.json"


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


class Store:
    """The results of a sweep in a folder.

    Parameters
    ----------
    sweep : sweep whose results are stored
    folder : folder that contains `sweep.zarr`, or in which it is created
    resume : whether to continue an existing store

    Attributes
    ----------
    path : path of `sweep.zarr`
    blank : empty results of one scene
    """

    def __init__(self, sweep: Sweep, folder: Path, resume: bool) -> None:
        self.path = folder / "sweep.zarr"
        if self.path.exists() and not resume:
            raise SceneError(
                f"{self.path} already exists: continue it with --resume, or give another --out"
            )
        identity = {
            "sweep": json.dumps(sweep.table),
            "versions": json.dumps(versions()),
            "code": code(),
        }
        _refuse_other_store(self.path, identity)
        blank = template(sweep)
        self.blank = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
        self._sweep, block = sweep, block_sizes(sweep, blank)
        parts = [
            [slice(start, start + block[dim]) for start in range(0, size, block[dim])]
            for dim, size in sweep.sizes.items()
        ]
        # the slice of each dimension that a block covers
        self._regions = [dict(zip(block, box, strict=True)) for box in product(*parts)]
        # checksums reveal damaged chunks
        compressed: dict[str, object] = {"compressors": [ZstdCodec(level=0, checksum=True)]}
        encoding: dict[str, dict[str, object]] = {str(name): compressed for name in blank.variables}
        for name, variable in blank.data_vars.items():
            chunks = (*block.values(), *variable.shape[len(block) :])
            encoding[str(name)] = compressed | {"chunks": chunks}
        with TemporaryDirectory() as fresh, warnings.catch_warnings():
            # zarr warns that texts and consolidated metadata are not yet in the specification
            warnings.simplefilter("ignore")
            # a chunk without any results is not written as a file
            blank.assign_attrs(identity).to_zarr(fresh, mode="w", zarr_format=3, encoding=encoding)
            _copy_metadata(Path(fresh), self.path)
        for leftover in self.path.rglob("*.partial"):
            leftover.unlink()
        self._group = zarr.open_group(self.path, mode="r+")

    def unfinished(self, retry_failed: bool) -> dict[int, Sweep]:
        """Return the blocks to compute, each as a sweep, by number.

        They are the blocks that are not finished or cannot be read. If `retry_failed` is set, they
        include the blocks with failed scenes.
        """
        final = (DONE,) if retry_failed else (DONE, FAILED)
        return {
            number: self._sweep.part(region)
            for number, region in enumerate(self._regions)
            if not self._is_finished(tuple(region.values()), final)
        }

    def _is_finished(self, place: tuple[slice, ...], final: tuple[int, ...]) -> bool:
        """Return whether a block can be read and all its scenes have one of the final statuses."""
        try:
            return bool(np.isin(self._group["status"][place], final).all() and self._read(place))
        # reading a damaged chunk can raise many kinds of errors
        except Exception:
            return False

    def _read(self, place: tuple[slice, ...]) -> dict[str, Array]:
        """Return the stored values of a block; empty if chunks are lost or from other code."""
        names = [str(name) for name in self.blank]
        if not all(self._chunk(name, place).exists() for name in names):
            return {}
        values = {name: np.asarray(self._group[name][place]) for name in names}
        return values if (values["code"] == stamp()).all() else {}

    def _chunk(self, name: str, place: tuple[slice, ...]) -> Path:
        """Return the file that holds a block of a variable."""
        array = self._group[name]
        grid = [box.start // size for box, size in zip(place, array.chunks, strict=False)]
        grid += [0] * (array.ndim - len(grid))
        return self.path / name / "c" / "/".join(map(str, grid))

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block.

        Scenes of the block that are still pending, because memory was insufficient, keep the
        results of an earlier run if that run has finished them.
        """
        place = tuple(self._regions[number].values())
        pending, stored = values["status"] == PENDING, dict[str, Array]()
        if pending.any():
            # reading a damaged chunk can raise many kinds of errors
            with suppress(Exception):
                stored = self._read(place)
        reused = pending & (stored["status"] == DONE) if stored else pending & False
        # empty chunks are written as files, too, so that a lost file is noticed
        with zarr.config.set({"array.write_empty_chunks": True}):
            for name, array in values.items():
                if reused.any():
                    array = array.copy()
                    array[reused] = stored[name][reused]
                self._group[name][place] = array

    def dataset(self) -> xarray.Dataset:
        """Return the results stored so far; values are read when they are used."""
        # without this argument, times in "hours" would become durations
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)


def _refuse_other_store(path: Path, identity: dict[str, str]) -> None:
    """Raise an error if a store belongs to another sweep, or if its root does not show its sweep.

    Parameters
    ----------
    path : path of the store, which need not exist
    identity : sweep, versions and code of the sweep to store, as in the attributes of the root

    Raises
    ------
    SceneError
        if the root has other attributes than `identity`, or is damaged or lost
    """
    try:
        attributes = json.loads((path / ROOT).read_text("utf-8"))["attributes"]
        same = identity.items() <= attributes.items()
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        # a store whose creation was interrupted has neither a root nor results
        if not (path / ROOT).exists() and not (path / "status" / "c").exists():
            return
        raise SceneError(
            f"{path / ROOT} is damaged or lost. It records the sweep and the code of the store: "
            "restore a copy of it, or give another --out"
        ) from None
    if not same:
        raise SceneError(
            f"{path} was begun with another sweep file, other code of ringwear or other libraries: "
            "continue with those, or give another --out"
        )


def _copy_metadata(source: Path, path: Path) -> None:
    """Copy the files of an empty store, each atomically, with the root last."""
    files = [file.relative_to(source) for file in sorted(source.rglob("*")) if file.is_file()]
    for file in sorted(files, key=lambda file: file == Path(ROOT)):
        target, content = path / file, (source / file).read_bytes()
        if not (target.is_file() and target.read_bytes() == content):
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(f"{target.name}.partial")
            partial.write_bytes(content)
            os.replace(partial, target)
