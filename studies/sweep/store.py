"""The store of a sweep: a Zarr group with the sweep's axes, readable by xarray while it grows.

The scenes of a block are computed together and then written as one file (a chunk) of each array.
The chunk of their status is written last. A block is finished if its status and all its other
chunks exist, if the checksums of its files are right, if it has the checksum of its values and of
its place, and if it was computed by the code of the store. Nothing in the store depends on the
order of the blocks, on the clock or on the machine's name. A sweep that was interrupted and resumed
therefore ends with the same bytes as an undisturbed one.
"""

import json
import os
import warnings
from collections.abc import Collection
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray
import zarr
from zarr.codecs import ZstdCodec

from ...meshes import Array, SceneError, SolverError
from ..crosscheck import stamp
from .axes import Sweep
from .flags import DONE, FAILED, PENDING
from .template import block_sizes, identity, one_scene, regions, template

# file of a Zarr group with its metadata
ROOT = "zarr.json"
# variable of the store with the checksum of the values of each block and of its place
CHECKSUM = "checksum"
# ending of the files that zarr and this module write before they give them their names
PARTIAL = ".partial"


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
        _refuse_other_store(self.path, identity(sweep))
        blank = template(sweep)
        self.blank = one_scene(sweep, blank)
        self._sweep, block = sweep, block_sizes(sweep, blank)
        self._regions = regions(sweep, block)
        label = {"long_name": "checksum of the values of a block and of its place"}
        checksums = np.broadcast_to(np.uint64(0), list(sweep.sizes.values()))
        stored = blank.assign({CHECKSUM: ([*sweep.sizes], checksums, label)})
        # checksums of the files reveal damaged chunks
        compressed: dict[str, object] = {"compressors": [ZstdCodec(level=0, checksum=True)]}
        encoding = {str(name): dict(compressed) for name in stored.variables}
        for name, variable in stored.data_vars.items():
            encoding[str(name)]["chunks"] = (*block.values(), *variable.shape[len(block) :])
        with TemporaryDirectory() as fresh, warnings.catch_warnings():
            # zarr warns that texts and consolidated metadata are not yet in the specification
            warnings.simplefilter("ignore")
            # a chunk without any results is not written as a file
            attributes = identity(sweep)
            stored.assign_attrs(attributes).to_zarr(
                fresh, mode="w", zarr_format=3, encoding=encoding
            )
            _refuse_foreign_files(self.path, Path(fresh))
            _copy_metadata(Path(fresh), self.path)
        for name in stored.variables:
            for leftover in (self.path / str(name)).rglob(f"*{PARTIAL}"):
                leftover.unlink()
        self._group = zarr.open_group(self.path, mode="r+")
        self._opened = _place_on_disk(self.path)

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
        """Return the stored values of a block; empty if they are lost, moved or from other code."""
        names = [str(name) for name in self.blank]
        if not all(self._chunk(name, place).exists() for name in (*names, CHECKSUM)):
            return {}
        values = {name: np.asarray(self._group[name][place]) for name in names}
        right = self._group[CHECKSUM][place] == checksum(place, values)
        return values if right.all() and (values["code"] == stamp()).all() else {}

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

        Raises
        ------
        SolverError
            if the store was moved, deleted or replaced after it was opened
        """
        place = tuple(self._regions[number].values())
        pending, stored = values["status"] == PENDING, dict[str, Array]()
        if pending.any():
            # reading a damaged chunk can raise many kinds of errors
            with suppress(Exception):
                stored = self._read(place)
        reused = pending & (stored["status"] == DONE) if stored else pending & False
        if reused.any():
            values = {name: array.copy() for name, array in values.items()}
            for name, array in values.items():
                array[reused] = stored[name][reused]
        if _place_on_disk(self.path) != self._opened:
            raise SolverError(
                f"{self.path} was moved, deleted or replaced while the sweep ran, so that nothing "
                "more is written to it: move it back, and continue with --resume"
            )
        # the status comes last
        chunks = {CHECKSUM: np.full_like(values["code"], checksum(place, values))} | values
        # empty chunks are written as files, too, so that a lost file is noticed
        with zarr.config.set({"array.write_empty_chunks": True}):
            for name, array in chunks.items():
                self._group[name][place] = array

    def dataset(self) -> xarray.Dataset:
        """Return the results stored so far; values are read when they are used."""
        # without this argument, times in "hours" would become durations
        stored = xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)
        return stored.drop_vars(CHECKSUM)


def checksum(place: tuple[slice, ...], values: dict[str, Array]) -> np.uint64:
    """Return the checksum of the values of a block at its place in the sweep.

    It reveals chunks that were copied from another place or from another array, whose own checksums
    are right.
    """
    digest = blake2b(repr([(part.start, part.stop) for part in place]).encode(), digest_size=8)
    for name in sorted(values):
        array = values[name]
        digest.update(f"\0{name}\0".encode())
        if array.dtype.kind in "OUT":
            digest.update("\0".join(map(str, array.ravel().tolist())).encode())
        else:
            digest.update(np.ascontiguousarray(array).tobytes())
    return np.frombuffer(digest.digest(), np.uint64)[0]


def _place_on_disk(path: Path) -> tuple[int, int] | None:
    """Return what tells a folder from others, whatever its name; None if there is no folder."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


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
    for file in sorted(_files(source), key=lambda file: (file == Path(ROOT), file)):
        target, content = path / file, (source / file).read_bytes()
        if not (target.is_file() and target.read_bytes() == content):
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(f"{target.name}{PARTIAL}")
            partial.write_bytes(content)
            os.replace(partial, target)


def _files(folder: Path) -> Collection[Path]:
    """Return the files in a folder and below it, by their paths in it."""
    return {file.relative_to(folder) for file in folder.rglob("*") if not file.is_dir()}


def _refuse_foreign_files(path: Path, fresh: Path) -> None:
    """Raise an error if a folder without a root contains other files than those of a new store.

    Parameters
    ----------
    path : path of the store, whose creation may have been interrupted
    fresh : folder of an empty store

    Raises
    ------
    SceneError
        if there are such files, or if the path is no folder; its message names one of them
    """
    if (path / ROOT).exists() or not path.exists():
        return
    ours = _files(fresh)
    ours = {*ours, *(file.with_name(f"{file.name}{PARTIAL}") for file in ours)}
    foreign = sorted({*_files(path)} - ours) if path.is_dir() else [Path()]
    if foreign:
        raise SceneError(
            f"{path / foreign[0]} is not part of a store of ringwear, so that the sweep is not "
            "continued there: give another --out"
        )
