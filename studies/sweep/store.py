"""The store: a Zarr group whose axes are the sweep's, readable by xarray while it grows.

A block of scenes is computed at once, and written at once as one file (a chunk) of each array. The
index has a row for each block, written after its files: the checksum of their bytes, by which a
block is known to be finished and undamaged, and how many of its scenes are done and have failed.
Nothing in the store depends on the order of the blocks, on the clock or on the machine's name: an
interrupted sweep ends with the same bytes.
"""

import json
import shutil
import warnings
from hashlib import blake2b
from itertools import product
from math import ceil, prod
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
from ..versions import fingerprint
from ..wear.modes import SHOWN
from .axes import ANSWERS, JUDGED, KEEPABLE, Sweep

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2


def template(sweep: Sweep) -> xarray.Dataset:
    """Return the results of all scenes before any is computed, as views that take no memory.

    Dimensions are the sweep's, then `solver` and those of each quantity.
    """
    first = sweep.first
    varied = {key: values for _, key, values in sweep.coordinates.values()}
    edges = varied.get("punch.ring_edges", [])
    rings = max([len(first.problem.rings.widths), *varied.get("punch.rings", []), *map(len, edges)])
    solvers = [name for names in varied.get("methods", [first.methods]) for name in names]
    stated = "" if "units" in varied else first.units

    def described(text: str, kind: str) -> dict[str, Any]:
        return {
            "long_name": text,
            "units": UnitNames.of(stated).name(kind),
        }

    coordinates: dict[str, tuple[str, Any, dict[str, Any]]] = {
        "time": ("time", first.wear.times, described("time of sliding", "time")),
        "radius": (
            "radius",
            first.output.radii or [],
            described("distance from the axis", "length"),
        ),
        "ring": ("ring", np.arange(1, rings + 1), {"long_name": "ring, counted from the centre"}),
        "mode": ("mode", np.arange(1, SHOWN + 1), {"long_name": "wear mode, slowest first"}),
        "state": ("state", np.array(STATES, dtype=object), {}),
        "solver": ("solver", np.array([*dict.fromkeys(solvers)], dtype=object), {}),
    }
    for name, (dim, key, values) in sweep.coordinates.items():
        label: dict[str, Any] = {"long_name": key}
        numbers = all(isinstance(value, int | float) for value in values)
        if numbers or kind_of(key) != "number":
            label = described(key, kind_of(key))
        array = np.array(values) if numbers else np.array([*map(str, values)], dtype=object)
        coordinates[name] = dim, array, label
    title = f"Sweep of {sweep.table['base'].get('title', 'a scene')}"
    dataset = xarray.Dataset(coords=coordinates, attrs={"title": title})

    def add(name: str, dims: tuple[str, ...], label: dict[str, Any], fill: Any = np.nan) -> None:
        dims = sweep.dims + dims
        dataset[name] = dims, np.broadcast_to(fill, [dataset.sizes[dim] for dim in dims]), label

    for name in sweep.keep:
        quantity = KEEPABLE[name]
        add(name, ("solver", *quantity.dims), described(quantity.definition, quantity.unit))
        if name not in ANSWERS:
            error = described(ERROR.format(name, NORMS[quantity.norm]), "number")
            add(error_name(name), ("solver", *quantity.error_dims), error)
    if dataset.sizes["solver"] > 1:
        for name, definition in JUDGED.items():
            add(name, (), described(definition, "number"))
    flags = {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"}
    add("status", (), {"long_name": "what became of the scene"} | flags, np.uint8(PENDING))
    add("reason", (), {"long_name": "why it is not done"}, np.array("", dtype=object))
    # without labels that no variable has
    return dataset[[*dataset.data_vars]]


def block_shape(sweep: Sweep, blank: xarray.Dataset) -> tuple[int, ...]:
    """Return how many scenes along each axis are computed, written and read at once.

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
    # closed forms take a fraction of a millisecond
    largest = 256 if blank["solver"].values.tolist() == ["direct"] else 16
    larger = min(max(sweep.count // 8192, 1), largest)
    in_memory = 2**27 * sweep.count // blank.nbytes
    block = dict.fromkeys(sweep.axes, 1)
    # the last axes first, as their scenes stand side by side in the store
    for scenes, shared in ((64, True), (8, False)):
        for dim, rows in reversed(sweep.axes.items()):
            room = min(scenes * larger, in_memory) // prod(block.values())
            if room > 1 and shared == all(key.startswith(sharing) for key in rows[0]):
                # in parts of about one length
                block[dim] = ceil(len(rows) / ceil(len(rows) / room))
    return tuple(block.values())


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
        self._sweep, self._block = sweep, block_shape(sweep, blank)
        steps = zip(sweep.shape, self._block, strict=True)
        parts = ([slice(at, at + step) for at in range(0, end, step)] for end, step in steps)
        # the box of the grid that each block is
        self._regions = list(product(*parts))
        with TemporaryDirectory() as fresh:
            self._create(Path(fresh), blank.assign_attrs(about))
            shutil.copytree(fresh, self.path, dirs_exist_ok=True)
        for left in self.path.rglob("*.partial"):
            left.unlink()
        index = folder / "sweep.index"
        index.touch()
        row = [("checksum", "<u8"), ("done", "<u4"), ("failed", "<u4")]
        self.index: Any = np.memmap(index, row, "r+", shape=(len(self._regions),))
        self._group = zarr.open_group(self.path, mode="r+")
        for number, (checksum, done, failed) in enumerate(self.index):
            sound = checksum and checksum == self._checksum(number, done, failed)
            if not sound or (retry_failed and failed):
                self.index[number] = 0

    def unfinished(self) -> dict[int, Sweep]:
        """Return the blocks that are not finished, each as a sweep of its own, by number."""
        numbers = np.flatnonzero(self.index["checksum"] == 0).tolist()
        return {number: self._sweep.part(self._regions[number]) for number in numbers}

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block, and its row of the index last."""
        region, status = self._regions[number], values["status"]
        shape = self._sweep.part(region).shape
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
        for name, value in about.items():
            if there.get(name) != value:
                raise SceneError(
                    f"{self.path} was begun with another {name}: go on by the file, the ringwear "
                    "and the libraries that began it, or give another --out"
                )

    def _create(self, path: Path, blank: xarray.Dataset) -> None:
        """Write everything but results: metadata and coordinates."""
        with warnings.catch_warnings():
            # metadata in one place are not in the specification yet; others read the rest
            warnings.simplefilter("ignore")
            blank.drop_vars(list(blank.data_vars)).to_zarr(path, zarr_format=3, consolidated=False)
            group = zarr.open_group(path, mode="r+")
            for name, variable in blank.data_vars.items():
                group.create_array(
                    name,
                    shape=variable.shape,
                    chunks=self._block + variable.shape[len(self._block) :],
                    dtype="str" if variable.dtype == object else variable.dtype,
                    fill_value=self.blank[name].values.flat[0],
                    dimension_names=variable.dims,
                    attributes=variable.attrs,
                )
            zarr.consolidate_metadata(path)

    def _files(self, number: int) -> list[Path]:
        """Return the files of a block; an array that is all empty has none."""
        steps = zip(self._regions[number], self._block, strict=True)
        place = [str(places.start // step) for places, step in steps]
        return [
            self.path.joinpath(str(name), "c", *place, *["0"] * variable.ndim)
            for name, variable in self.blank.data_vars.items()
        ]

    def _checksum(self, number: int, *counts: int) -> int:
        """Return BLAKE2b, 8 bytes, of the files of a block and the rest of its row."""
        digest = blake2b(str([int(count) for count in counts]).encode(), digest_size=8)
        for file in self._files(number):
            content = file.read_bytes() if file.exists() else b""
            digest.update(len(content).to_bytes(8, "little") + content)
        return int.from_bytes(digest.digest(), "little")
