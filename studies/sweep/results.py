"""Results of a sweep: their empty dataset, in memory or as a store that survives interruptions."""

import json
import os
import shutil
import warnings
from importlib.util import find_spec
from itertools import product
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray

from ...meshes import Array, SceneError
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

# first part of the name of a folder beside the store, in which an empty store is made
HIDDEN = ".ringwear_sweep_"
# status of a scene
PENDING, DONE, FAILED = 0, 1, 2

# beginnings of keys in which scenes of a flat punch may differ and still share a discretisation
SHARED_KEYS = (
    *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
    *("load.", "wear.", "output.", "title"),
)


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
    # these tell the results of sweeps apart
    versions = {"versions": json_text(package_versions()), "code": code()}
    identity = {"sweep": json_text(sweep.table)} | versions
    # drop coordinates that no variable has
    return dataset[[*dataset.data_vars]].drop_attrs(deep=False).assign_attrs(identity)


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


def unsolved(blank: xarray.Dataset, *sizes: int) -> dict[str, Array]:
    """Return the values of a block of these sizes before it is computed, from those of a scene."""
    return {
        str(name): np.broadcast_to(variable.values, (*sizes, *variable.shape)).copy()
        for name, variable in blank.data_vars.items()
    }


def one_scene(sweep: Sweep, blank: xarray.Dataset) -> xarray.Dataset:
    """Return the empty results of one scene from those of all scenes."""
    return blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)


class InMemory:
    """Results of a sweep in memory, with the same blocks as a store.

    Parameters
    ----------
    sweep : the sweep

    Attributes
    ----------
    blank : empty results of one scene
    """

    def __init__(self, sweep: Sweep) -> None:
        empty = template(sweep)
        self.blank = one_scene(sweep, empty)
        self._sweep, self._block = sweep, block_sizes(sweep, empty)
        parts = [
            [slice(start, start + self._block[dim]) for start in range(0, size, self._block[dim])]
            for dim, size in sweep.sizes.items()
        ]
        # the slice of each dimension that each block covers
        self._regions = [dict(zip(sweep.sizes, box, strict=True)) for box in product(*parts)]
        self._open(empty)

    def _open(self, empty: xarray.Dataset) -> None:
        # the arrays of the template are views without memory
        self._dataset = empty.copy(data={name: np.array(empty[name]) for name in empty})

    def unfinished(self, retry_failed: bool) -> dict[int, Sweep]:
        """Return the blocks that are not finished, each as a sweep, by number.

        If `retry_failed` is set, blocks with failed scenes are among them.
        """
        final = (DONE,) if retry_failed else (DONE, FAILED)
        return {
            number: self._sweep.part(region)
            for number, region in enumerate(self._regions)
            if not np.isin(self._status(tuple(region.values())), final).all()
        }

    def _status(self, place: tuple[slice, ...]) -> Array:
        """Return the status of the scenes of a block."""
        return self._dataset["status"].values[place]

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Keep the results of a block."""
        place = tuple(self._regions[number].values())
        for name, array in values.items():
            self._dataset[name].values[place] = array

    def dataset(self) -> xarray.Dataset:
        """Return all results."""
        return self._dataset


class Store(InMemory):
    """Results of a sweep in a directory, as a Zarr store that is readable while it grows.

    The results of a block are one file (a chunk) of each variable; the chunk of their status is
    written last. Nothing in the store depends on the order of the blocks, on the clock or on the
    machine, so that an interrupted and resumed sweep ends with the bytes of an undisturbed one.

    Parameters
    ----------
    sweep : the sweep
    folder : folder that contains `sweep.zarr`, or in which it is created
    resume : whether to continue the store that is there

    Raises
    ------
    SceneError
        if Zarr is not installed, if a store is there and is not to be continued, or if it is
        damaged or has another sweep, code or versions
    """

    def __init__(self, sweep: Sweep, folder: Path, resume: bool) -> None:
        if find_spec("zarr") is None:
            raise SceneError("the store of a sweep needs zarr: pip install 'ringwear[sweep]'")
        self.path = folder / "sweep.zarr"
        if os.path.lexists(self.path) and not resume:
            raise SceneError(
                f"{self.path} already exists: continue it with --resume, or give another --out"
            )
        super().__init__(sweep)

    def _open(self, empty: xarray.Dataset) -> None:
        import zarr
        from zarr.codecs import Crc32cCodec, ZstdCodec

        if exists := os.path.lexists(self.path):
            self._refuse_other_store(empty.attrs)
        # a chunk with a wrong checksum cannot be read
        codecs: dict[str, object] = {"compressors": [ZstdCodec(level=0), Crc32cCodec()]}
        encoding = {name: dict(codecs) for name in empty.variables}
        for name, variable in empty.data_vars.items():
            encoding[name]["chunks"] = *self._block.values(), *variable.shape[len(self._block) :]
        for leftover in self.path.parent.glob(f"{HIDDEN}*"):
            shutil.rmtree(leftover)
        with TemporaryDirectory(prefix=HIDDEN, dir=self.path.parent) as folder:
            fresh = Path(folder) / self.path.name
            with warnings.catch_warnings():
                # zarr warns that texts and consolidated metadata are not yet in the specification
                warnings.simplefilter("ignore")
                empty.to_zarr(fresh, zarr_format=3, encoding=encoding)
            if not exists:
                os.replace(fresh, self.path)
            # what describes the results is written again, because it may be damaged
            for file in [file for file in fresh.rglob("*") if file.is_file()]:
                target = self.path / file.relative_to(fresh)
                target.parent.mkdir(parents=True, exist_ok=True)
                os.replace(file, target)
        # zarr gives these names to chunks until they are complete
        for leftover in self.path.rglob(f"*.{'[0-9a-f]' * 32}.partial"):
            leftover.unlink()
        self._group = zarr.open_group(self.path, mode="r+")

    def _refuse_other_store(self, identity: dict[str, str]) -> None:
        """Raise an error unless the root of the store has the attributes of this sweep."""
        try:
            attributes = json.loads((self.path / "zarr.json").read_text("utf-8"))["attributes"]
            same = identity.items() <= attributes.items()
        # a damaged root can raise many kinds of errors
        except Exception as error:
            raise SceneError(
                f"{self.path / 'zarr.json'} is damaged or lost ({error}), so that the sweep is not "
                "continued there: restore it, or give another --out"
            ) from None
        if not same:
            raise SceneError(
                f"{self.path} was begun with another sweep file, other code of ringwear or other "
                "libraries: continue with those, or give another --out"
            )

    def _status(self, place: tuple[slice, ...]) -> Array:
        """Return the status of the scenes of a block, which are pending if a file is damaged."""
        values = dict[str, Array]()
        try:
            for name in map(str, self.blank):
                array = self._group[name]
                starts = [part.start for part in place] + [0] * (array.ndim - len(place))
                chunk = [start // size for start, size in zip(starts, array.chunks, strict=True)]
                self.path.joinpath(name, "c", *map(str, chunk)).stat()
                values[name] = array[place]
        # reading a damaged chunk can raise many kinds of errors
        except Exception:
            return np.array(PENDING)
        return values["status"]

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block; its status, by which it is finished, comes last."""
        import zarr

        place = tuple(self._regions[number].values())
        # chunks without results are files, too, so that a lost file is noticed
        with zarr.config.set({"array.write_empty_chunks": True}):
            for name in (*(values.keys() - {"status"}), "status"):
                self._group[name][place] = values[name]

    def dataset(self) -> xarray.Dataset:
        """Return all results, which are read from the store when they are used."""
        # without this argument, times in "hours" would become durations
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)
