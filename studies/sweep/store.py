"""The store: a Zarr group whose axes are the sweep's, readable by xarray while it grows.

Each block of scenes is a file of its own (a shard) in each array, so that none is written twice.
The index has a row for each block, written after its files: the checksum of their bytes, by which
a block is known to be finished and undamaged, and how many of its scenes are done and have failed.
Nothing in the store depends on the order of the blocks, on the clock or on the machine's name: an
interrupted sweep ends with the same bytes.
"""

import json
import os
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

from ...meshes.errors import RingwearError, SceneError
from ...meshes.radial import Array
from ..versions import fingerprint
from .axes import Sweep
from .layout import DONE, FAILED, PENDING, block_shape

NAME = "sweep.zarr"


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
    sweep : what is computed
    blank : its `layout.template`
    folder : where `sweep.zarr` and its index are or will be
    resume : whether to go on with what is there

    Attributes
    ----------
    index : (blocks,) array of `checksum`, 0 until a block is finished, and of numbers of scenes
        that are `done` and have `failed`
    """

    def __init__(self, sweep: Sweep, blank: xarray.Dataset, folder: Path, resume: bool) -> None:
        self.path = folder / NAME
        if self.path.exists() and not resume:
            raise SceneError(
                f"{self.path} is there: go on with it by --resume, or give another --out"
            )
        self._names = list(blank.data_vars)
        self._chunk, self._block = block_shape(sweep, blank)
        self._sizes = sweep.shape
        self._blocks = [
            ceil(size / step) for size, step in zip(sweep.shape, self._block, strict=True)
        ]
        about = {"sweep": json.dumps(sweep.table), "versions": fingerprint()}
        self._check(about)
        try:
            with TemporaryDirectory() as fresh:
                self._create(Path(fresh), blank.assign_attrs(about))
                shutil.copytree(fresh, self.path, dirs_exist_ok=True)
            for left in self.path.rglob("*.partial"):
                left.unlink()
            index = folder / "sweep.index"
            index.touch()
            row = [("checksum", "<u8"), ("done", "<u4"), ("failed", "<u4")]
            self.index: Any = np.memmap(index, row, "r+", shape=(prod(self._blocks),))
        except OSError as error:
            raise RingwearError(f"{self.path} cannot be written: {error.strerror}") from error
        self._group = zarr.open_group(self.path, mode="r+")
        damaged = [number for number in range(len(self.index)) if not self._is_sound(number)]
        self.index[damaged] = 0

    def region(self, number: int) -> tuple[slice, ...]:
        """Return the box of the grid that a block is."""
        return tuple(
            slice(place * step, min((place + 1) * step, size))
            for place, step, size in zip(
                self._place(number), self._block, self._sizes, strict=True
            )
        )

    def write(self, number: int, values: dict[str, Array]) -> None:
        """Write the results of a block, and its row of the index last."""
        region, status = self.region(number), values["status"]
        shape = [places.stop - places.start for places in region]
        try:
            for name, array in values.items():
                self._group[name][region] = array.reshape(*shape, *array.shape[1:])
        except OSError as error:
            raise RingwearError(
                f"{self.path} cannot be written: {error.strerror}; what is finished is kept: mend "
                "that, and go on with --resume"
            ) from error
        checksum = 0 if (status == PENDING).any() else self._checksum(number)
        self.index[number] = checksum, (status == DONE).sum(), (status == FAILED).sum()

    def dataset(self) -> xarray.Dataset:
        """Return what is there so far, read when it is used."""
        # times in "hours" stay numbers
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)

    def _check(self, about: dict[str, str]) -> None:
        """Refuse to go on with the store of another sweep or of another code."""
        try:
            there = json.loads((self.path / "zarr.json").read_text("utf-8"))["attributes"]
        except (OSError, ValueError, KeyError, TypeError):
            # not there, or damaged: made again
            return
        remedies = {
            "sweep": "give its own file",
            "versions": "install the ringwear, and what it computes with, that began it",
        }
        for name, remedy in remedies.items():
            if there.get(name) != about[name]:
                raise SceneError(
                    f"{self.path} was begun with another {name}: {remedy}, or give another --out"
                )

    def _create(self, path: Path, blank: xarray.Dataset) -> None:
        """Write everything but results: metadata and coordinates."""
        with warnings.catch_warnings():
            # metadata in one place are not in the specification yet; others read the rest
            warnings.simplefilter("ignore")
            blank.drop_vars(self._names).to_zarr(path, zarr_format=3, consolidated=False)
            group = zarr.open_group(path, mode="r+")
            for name, variable in blank.data_vars.items():
                beyond = variable.shape[len(self._sizes) :]
                group.create_array(
                    name,
                    shape=variable.shape,
                    chunks=(*self._chunk, *beyond),
                    shards=(*self._block, *beyond),
                    dtype="str" if variable.dtype == object else variable.dtype,
                    fill_value="" if variable.dtype == object else variable.values.flat[0],
                    dimension_names=variable.dims,
                    attributes=variable.attrs,
                    config={"write_empty_chunks": True},
                )
            zarr.consolidate_metadata(path)

    def _place(self, number: int) -> tuple[int, ...]:
        return tuple(map(int, np.unravel_index(number, self._blocks)))

    def _is_sound(self, number: int) -> bool:
        """Return whether a block is finished, and its files are as they were then."""
        checksum = self.index[number]["checksum"]
        return bool(checksum) and checksum == self._checksum(number)

    def _checksum(self, number: int) -> int:
        """Return BLAKE2b, 8 bytes, of the files of a block; 0 if any is missing."""
        digest = blake2b(digest_size=8)
        for name in self._names:
            beyond = [0] * (self._group[name].ndim - len(self._sizes))
            file = self.path.joinpath(str(name), "c", *map(str, [*self._place(number), *beyond]))
            try:
                content = file.read_bytes()
            except OSError:
                return 0
            digest.update(len(content).to_bytes(8, "little") + content)
        return int.from_bytes(digest.digest(), "little")


def write_whole(file: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all."""
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    os.replace(partial, file)
