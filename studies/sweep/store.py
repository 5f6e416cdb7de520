"""The store: a Zarr group whose axes are the sweep's, readable by xarray while it grows.

A block of scenes is computed at once, and written at once as one file (a shard) of each array. The
index has a row for each block, written after its files: the checksum of their bytes, by which a
block is known to be finished and undamaged, and how many of its scenes are done and have failed.
Nothing in the store depends on the order of the blocks, on the clock or on the machine's name: an
interrupted sweep ends with the same bytes.
"""

import json
import shutil
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import blake2b
from math import ceil, prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray
import zarr
from filelock import FileLock, Timeout

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..methods.quantities import ERROR, NORMS, STATES, error_name
from ..problem.unit_names import KINDS, UNSTATED, UnitNames
from ..versions import fingerprint
from ..wear.modes import SHOWN
from .axes import ANSWERS, JUDGED, KEEPABLE, Sweep

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2


def template(sweep: Sweep) -> xarray.Dataset:
    """Return the results of all scenes before any is computed, as views that take no memory.

    Dimensions are the sweep's, then `solver` and those of each quantity.

    Raises
    ------
    SceneError
        if scenes differ in the times or radii that the quantities to keep are at
    """
    first = sweep.first
    varied = {key: values for axis in sweep.axes for key, values in axis.columns.items()}
    quantities = {name: KEEPABLE[name] for name in sweep.keep}
    _check_times(sweep, varied)
    at_radii = [name for name, quantity in quantities.items() if "radius" in quantity.dims]
    if at_radii and (not first.output.radii or {"output.radii", "punch.radius"} & set(varied)):
        raise SceneError(
            f"{sweep.name}: {at_radii[0]} is kept at radii that all scenes share: give the base "
            "output.radii, and vary neither them nor punch.radius"
        )
    edges = [first.punch.ring_edges or [], *varied.get("punch.ring_edges", [])]
    rings = max([first.punch.rings or 0, *varied.get("punch.rings", []), *map(len, edges)])
    methods = varied.get("methods", [first.methods])
    solvers = list(dict.fromkeys(name for names in methods for name in names))
    stated = "" if "units" in varied else first.units

    def about(text: str, kind: str) -> dict[str, str]:
        return {
            "long_name": text,
            "units": UnitNames.of(stated).name(kind) or stated or UNSTATED,
        }

    coordinates: dict[str, tuple[str, Any, dict[str, str]]] = {
        "time": ("time", first.wear.times, about("time of sliding", "time")),
        "radius": ("radius", first.output.radii or [], about("distance from the axis", "length")),
        "ring": ("ring", np.arange(1, rings + 1), {"long_name": "ring, counted from the centre"}),
        "mode": ("mode", np.arange(1, SHOWN + 1), {"long_name": "wear mode, slowest first"}),
        "state": ("state", np.array(STATES, dtype=object), {}),
        "solver": ("solver", np.array(solvers, dtype=object), {}),
    }
    for name, (dim, key, values) in sweep.coordinates.items():
        text = any(isinstance(value, str) for value in values)
        plain = text and key not in KINDS
        label = {"long_name": key} if plain else about(key, KINDS.get(key, "number"))
        coordinates[name] = dim, np.array(values, dtype=object if text else None), label
    sizes = {dim: len(values) for dim, values, _ in coordinates.values()}
    variables: dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]] = {}

    def add(name: str, dims: tuple[str, ...], about: dict[str, Any], fill: Any = np.nan) -> None:
        dims = sweep.dims + dims
        variables[name] = dims, np.broadcast_to(fill, [sizes[dim] for dim in dims]), about

    for name, quantity in quantities.items():
        add(name, ("solver", *quantity.dims), about(quantity.definition, quantity.unit))
        if name not in ANSWERS:
            error = about(ERROR.format(name, NORMS[quantity.norm]), "number")
            add(error_name(name), ("solver", *quantity.error_dims), error)
    if len(solvers) > 1:
        for name, definition in JUDGED.items():
            add(name, (), about(definition, "number"))
    flags = {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"}
    add("status", (), {"long_name": "what became of the scene"} | flags, np.uint8(PENDING))
    add("reason", (), {"long_name": "why it is not done"}, np.array("", dtype=object))
    used = {dim for dims, *_ in variables.values() for dim in dims}
    return xarray.Dataset(
        variables,
        {name: values for name, values in coordinates.items() if values[0] in used},
        {"title": f"Sweep of {sweep.table['base'].get('title', 'a scene')}"},
    )


def _check_times(sweep: Sweep, varied: dict[str, list[Any]]) -> None:
    """Refuse to keep anything over times that scenes do not have in common."""
    # beginnings of keys that leave relaxation times as they are
    of_one_time_scale = (
        *("load.normal_force", "load.mean_pressure", "accuracy.", "output.", "wear."),
        *("methods", "title", "units"),
    )
    over_time = [name for name in sweep.keep if "time" in KEEPABLE[name].dims]
    if over_time and "wear.times" in varied:
        raise SceneError(f"{sweep.name}: wear.times varies, and {over_time[0]} is kept over time")
    over_time += {"worn_volume"} & set(sweep.keep)
    others = [key for key in varied if not key.startswith(of_one_time_scale)]
    times = [sweep.table["base"].get("wear", {}).get("times"), *varied.get("wear.times", [])]
    if over_time and others and any(isinstance(value, str | dict) for value in times):
        raise SceneError(
            f"{sweep.name}: wear.times counts relaxation times, which {others[0]} may change, and "
            f"{over_time[0]} is kept at times that all scenes share: give wear.times as numbers, "
            "or keep only what is not over time"
        )


def block_shape(sweep: Sweep, blank: xarray.Dataset) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return scenes along each axis of a chunk (what is read at once), and of a block of chunks.

    A chunk holds the scenes of one geometry as far as that is not too many, for they share a
    discretisation; of few scenes it takes several geometries. Of small sweeps it is the block.
    """
    # closed forms take a fraction of a millisecond
    closed = blank["solver"].values.tolist() == ["direct"]
    least, most = (256, 1024) if closed else (8, 64)
    most = max(1, min(most, 2**26 * sweep.count // blank.nbytes))
    # the last axes first, as their scenes stand side by side in the store
    order = range(len(sweep.axes))[::-1]
    alike = [at for at in order if sweep.axes[at].shares_discretisation]
    chunk, several = [1] * len(order), [1] * len(order)
    _fill(chunk, sweep.shape, alike, most)
    _fill(chunk, sweep.shape, [at for at in order if at not in alike], min(least, most))
    chunks = [ceil(length / step) for length, step in zip(sweep.shape, chunk, strict=True)]
    _fill(several, chunks, order, min(16, prod(chunks) // 128))
    return tuple(chunk), tuple(step * times for step, times in zip(chunk, several, strict=True))


def _fill(shape: list[int], lengths: Any, order: Any, most: int) -> None:
    """Lengthen a box along axes, in parts of about one length, to at most so many places."""
    for at in order:
        if (room := most // prod(shape)) > 1:
            shape[at] = ceil(lengths[at] / ceil(lengths[at] / room))


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Be the only sweep in a folder; the lock is the system's, and ends with the process."""
    # a Path of "s3://bucket" has one slash left
    if ":/" in str(folder):
        remedy = "give one, and copy the store from there"
        raise SceneError(f"--out {folder} is no directory of this machine: {remedy}")
    lock = FileLock(folder / ".lock", blocking=False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except Timeout:
        raise SceneError(
            f"another sweep is writing to {folder}: wait for it, or give another --out"
        ) from None
    except OSError as error:
        raise SceneError(f"--out {folder} cannot be written to: {error.strerror}") from error
    try:
        yield
    finally:
        lock.release()


class Store:
    """The results of a sweep in a folder.

    Parameters
    ----------
    sweep, blank : what is computed, and its template
    folder : where `sweep.zarr` and its index are or will be
    resume : whether to go on with what is there
    retry_failed : whether to compute blocks again in which scenes have failed

    Attributes
    ----------
    blank : the template of one scene
    index : (blocks,) array of `checksum`, 0 until a block is finished, and of numbers of scenes
        that are `done` and have `failed`
    """

    def __init__(
        self, sweep: Sweep, blank: xarray.Dataset, folder: Path, resume: bool, retry_failed: bool
    ) -> None:
        self.path = folder / "sweep.zarr"
        if self.path.exists() and not resume:
            raise SceneError(
                f"{self.path} is there: go on with it by --resume, or give another --out"
            )
        about = {"sweep": json.dumps(sweep.table), "versions": fingerprint()}
        self._check(about)
        self.blank = blank.isel(dict.fromkeys(sweep.dims, 0), drop=True)
        self._sweep = sweep
        self._chunk, self._block = block_shape(sweep, blank)
        self._blocks = [ceil(a / b) for a, b in zip(sweep.shape, self._block, strict=True)]
        with TemporaryDirectory() as fresh:
            self._create(Path(fresh), blank.assign_attrs(about))
            shutil.copytree(fresh, self.path, dirs_exist_ok=True)
        for left in self.path.rglob("*.partial"):
            left.unlink()
        index = folder / "sweep.index"
        index.touch()
        row = [("checksum", "<u8"), ("done", "<u4"), ("failed", "<u4")]
        self.index: Any = np.memmap(index, row, "r+", shape=(prod(self._blocks),))
        self._group = zarr.open_group(self.path, mode="r+")
        for number, (checksum, done, failed) in enumerate(self.index):
            sound = checksum and checksum == self._checksum(number, done, failed)
            if not sound or (retry_failed and failed):
                self.index[number] = 0

    def unfinished(self) -> dict[int, Sweep]:
        """Return the blocks that are not finished, each as a sweep of its own, by number."""
        numbers = np.flatnonzero(self.index["checksum"] == 0).tolist()
        return {number: self._sweep.part(self._region(number)) for number in numbers}

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block, and its row of the index last."""
        region, status = self._region(number), values["status"]
        shape = [places.stop - places.start for places in region]
        # what is damaged could not be written over
        for file in self._files(number):
            file.unlink(missing_ok=True)
        for name, array in values.items():
            self._group[name][region] = array.reshape(*shape, *array.shape[1:])
        counts = (status == DONE).sum(), (status == FAILED).sum()
        finished = sum(counts) == len(status)
        self.index[number] = self._checksum(number, *counts) if finished else 0, *counts

    def dataset(self) -> xarray.Dataset:
        """Return what is there so far, read when it is used."""
        # times in "hours" stay numbers
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)

    def _check(self, about: dict[str, str]) -> None:
        """Refuse to go on with the store of another sweep or of another code."""
        try:
            there = json.loads((self.path / "zarr.json").read_text("utf-8"))["attributes"]
        except (OSError, ValueError, KeyError):
            # not there, or damaged: made again
            return
        for name, remedy in (
            ("sweep", "give its own file"),
            ("versions", "install the ringwear, and what it computes with, that began it"),
        ):
            if there.get(name) != about[name]:
                raise SceneError(
                    f"{self.path} was begun with another {name}: {remedy}, or give another --out"
                )

    def _create(self, path: Path, blank: xarray.Dataset) -> None:
        """Write everything but results: metadata and coordinates."""
        with warnings.catch_warnings():
            # metadata in one place are not in the specification yet; others read the rest
            warnings.simplefilter("ignore")
            blank.drop_vars(list(blank.data_vars)).to_zarr(path, zarr_format=3, consolidated=False)
            group = zarr.open_group(path, mode="r+")
            for name, variable in blank.data_vars.items():
                beyond = variable.shape[len(self._block) :]
                text = variable.dtype == object
                group.create_array(
                    name,
                    shape=variable.shape,
                    chunks=(*self._chunk, *beyond),
                    shards=(*self._block, *beyond),
                    dtype="str" if text else variable.dtype,
                    fill_value=self.blank[name].values.flat[0],
                    dimension_names=variable.dims,
                    attributes=variable.attrs,
                    config={"write_empty_chunks": True},
                )
            zarr.consolidate_metadata(path)

    def _place(self, number: int) -> list[int]:
        return [int(at) for at in np.unravel_index(number, self._blocks)]

    def _region(self, number: int) -> tuple[slice, ...]:
        """Return the box of the grid that a block is."""
        places = zip(self._place(number), self._block, self._sweep.shape, strict=True)
        return tuple(slice(at * step, min((at + 1) * step, end)) for at, step, end in places)

    def _files(self, number: int) -> list[Path]:
        """Return the files of a block; an array that is all empty has none."""
        place = "/".join(map(str, self._place(number)))
        return [
            self.path.joinpath(str(name), "c", place, *["0"] * variable.ndim)
            for name, variable in self.blank.data_vars.items()
        ]

    def _checksum(self, number: int, *counts: int) -> int:
        """Return BLAKE2b, 8 bytes, of the files of a block and the rest of its row."""
        digest = blake2b(str([int(count) for count in counts]).encode(), digest_size=8)
        for file in self._files(number):
            content = file.read_bytes() if file.exists() else b""
            digest.update(len(content).to_bytes(8, "little") + content)
        return int.from_bytes(digest.digest(), "little")
