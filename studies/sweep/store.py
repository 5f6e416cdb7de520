"""The store.

One Zarr group whose axes are the sweep's, written by whole blocks, readable by xarray while it
grows.

Each block has chunks of its own, so that none is written twice. A scene's checksum, over all that
is kept of it, is written last: a scene is finished when its checksum holds, whatever happened to
the disk or the process since. Nothing in the store depends on the order of the blocks, on the clock
or on the machine's name: an interrupted sweep ends with the same bytes.
"""

import json
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
import xarray
import zarr
from zarr.codecs import Crc32cCodec, ZstdCodec
from zarr.storage import LocalStore, MemoryStore

from ...meshes.errors import RingwearError, SceneError
from ...meshes.radial import Array
from ..versions import fingerprint
from .axes import Sweep
from .blocks import Block
from .layout import DONE, FAILED, PENDING, Layout, Outcome

NAME = "sweep.zarr"
STATUS = {
    "long_name": "what has become of the scene",
    "flag_values": [PENDING, DONE, FAILED],
    "flag_meanings": "pending done failed",
}
REASON = {"long_name": "why the scene failed, or is pending still"}
CHECKSUM = {
    "long_name": "BLAKE2b of all that is kept of the scene, 8 bytes; 0 until it is finished"
}


@contextmanager
def alone(directory: Path) -> Iterator[None]:
    """The only sweep in a directory, until it ends in whatever way.

    The lock is the system's, and dies with the process.
    """
    import fcntl

    # a Path of "s3://bucket" has one slash left
    if ":/" in str(directory):
        remedy = "give one, and copy the store from there"
        raise SceneError(f"--out {directory} is no directory of this machine: {remedy}")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        lock = (directory / ".lock").open("a")
    except OSError as error:
        raise SceneError(f"--out {directory} cannot be written to: {error.strerror}") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise SceneError(
                f"another sweep is writing to {directory}: wait for it, or give another --out"
            ) from None
        yield


class Store:
    """The results of a sweep, in a directory or in memory.

    Parameters
    ----------
    sweep, layout : what is kept, and its shapes
    block_shape : scenes of a block along each axis
    directory : where `sweep.zarr` is or will be; None for memory
    resume : whether to go on with what is there
    """

    def __init__(
        self,
        sweep: Sweep,
        layout: Layout,
        block_shape: tuple[int, ...],
        directory: Path | None,
        resume: bool = False,
    ) -> None:
        self.sweep, self.layout, self.block_shape = sweep, layout, block_shape
        self.path = None if directory is None else directory / NAME
        blank: dict[str, Any] = {}
        self._store: Any = MemoryStore(blank)
        self._create(self._store)
        if self.path is not None:
            try:
                _put_in_place(
                    self.path, {name: content.to_bytes() for name, content in blank.items()}, resume
                )
            except OSError as error:
                raise RingwearError(f"{self.path} cannot be written: {error.strerror}") from error
            self._store = LocalStore(self.path)
        self._group = zarr.open_group(self._store, mode="r+")
        names = (*layout.variables, "status", "reason", "checksum")
        self._arrays: dict[str, Any] = {name: self._group[name] for name in names}

    def _create(self, store: Any) -> None:
        """Everything but results: metadata and coordinates."""
        sweep, layout = self.sweep, self.layout
        about = {
            "title": f"Sweep of {sweep.table['base'].get('title', 'a scene')}",
            "sweep": sweep.to_json(),
            "versions": fingerprint(),
            "block_shape": list(self.block_shape),
            # those that are not named as their dimension; xarray reads it
            "coordinates": " ".join(name for name, dim, *_ in sweep.coordinates() if name != dim),
        }
        group = zarr.open_group(store, mode="w", zarr_format=3, attributes=about)
        coders: dict[str, Any] = {"compressors": [ZstdCodec(level=3), Crc32cCodec()]}
        kept = {
            name: (one.dims, one.shape, "f8", np.nan, one.attributes)
            for name, one in layout.variables.items()
        }
        of_scenes = {
            "status": ("u1", PENDING, STATUS),
            "reason": ("str", "", REASON),
            "checksum": ("u8", 0, CHECKSUM),
        }
        every: dict[str, Any] = kept | {name: ((), (), *what) for name, what in of_scenes.items()}
        kind: Any
        for name, (dims, shape, kind, fill, attributes) in every.items():
            group.create_array(
                name,
                shape=(*sweep.shape, *shape),
                chunks=(*self.block_shape, *shape),
                dtype=kind,
                fill_value=fill,
                dimension_names=(*sweep.dims, *dims),
                attributes=attributes,
                config={"write_empty_chunks": True},
                **coders,
            )
        common = {"solver": list(layout.solvers)} | {
            dim: list(values) for dim, values in layout.coordinates.items()
        }
        along = {name: (dim, values) for name, dim, values, _ in sweep.coordinates()}
        along |= {dim: (dim, values) for dim, values in common.items()}
        for name, (dim, values) in along.items():
            kind = (
                "str"
                if any(isinstance(value, str) for value in values)
                else np.asarray(values).dtype
            )
            array = group.create_array(
                name,
                shape=(len(values),),
                dtype=kind,
                chunks=(len(values),),
                dimension_names=(dim,),
                attributes=layout.about.get(name, {}),
                **coders,
            )
            array[:] = np.array(values, dtype=object if kind == "str" else kind)
        with warnings.catch_warnings():
            # consolidated metadata are not in the specification yet; readers without it read the
            # rest
            warnings.simplefilter("ignore")
            zarr.consolidate_metadata(store)

    def write(self, block: Block, outcome: Outcome) -> None:
        """The results of a block; the checksums last."""
        parts: dict[str, Any] = dict(outcome.values)
        parts |= {"status": outcome.status, "reason": np.array(outcome.reason, dtype=object)}
        parts["checksum"] = np.where(outcome.status == PENDING, np.uint64(0), checksums(parts))
        try:
            for name, values in parts.items():
                self._arrays[name][block.region] = values.reshape(*block.shape, *values.shape[1:])
        except OSError as error:
            raise RingwearError(
                f"{self.path} cannot be written: {error.strerror}; what is finished is kept: mend "
                "that, and "
                "go on with --resume"
            ) from error

    def statuses(self, block: Block) -> Array | None:
        """Status of each scene of a block, if all of them are finished and their checksums hold.

        Else None.
        """
        try:
            parts = {name: np.asarray(array[block.region]) for name, array in self._arrays.items()}
        except Exception:  # of many kinds: whatever a damaged chunk makes a decoder do
            return None
        parts = {
            name: values.reshape(block.count, *values.shape[len(block.shape) :])
            for name, values in parts.items()
        }
        known = parts.pop("checksum")
        holds = bool((known == checksums(parts)).all() and (parts["status"] != PENDING).all())
        return parts["status"].ravel() if holds else None

    def dataset(self) -> xarray.Dataset:
        """What is there so far, as an xarray Dataset, read when it is used."""
        # times in "hours" stay numbers
        return xarray.open_dataset(
            self._store, engine="zarr", consolidated=True, decode_timedelta=False
        )


def checksums(parts: dict[str, Any]) -> Any:
    """(scenes,) of all that is kept of each scene."""
    numbers = [np.ascontiguousarray(values) for name, values in parts.items() if name != "reason"]
    rows = np.concatenate(
        [values.reshape(len(values), -1).view(np.uint8) for values in numbers], axis=1
    )
    texts = [str(text).encode() for text in parts["reason"]]
    found = [
        blake2b(row.tobytes() + text, digest_size=8).digest()
        for row, text in zip(rows, texts, strict=True)
    ]
    return np.frombuffer(b"".join(found), dtype="<u8").astype(np.uint64)


def _put_in_place(path: Path, wanted: dict[str, bytes], resume: bool) -> None:
    """Files of metadata and coordinates on disk as they should be, around the results that may be
    there.
    """
    about = json.loads(wanted["zarr.json"])["attributes"]
    if path.exists():
        if not resume:
            raise SceneError(f"{path} is there: go on with it by --resume, or give another --out")
        try:
            there = json.loads((path / "zarr.json").read_text("utf-8"))["attributes"]
        except (OSError, ValueError, KeyError, TypeError):
            there = about  # damaged: made again, as everything else is that is
        remedies = {
            "sweep": "give its own file",
            "block_shape": "delete it",
            "versions": "install the ringwear, and what it computes with, that began it",
        }
        for name, remedy in remedies.items():
            if there.get(name) != about[name]:
                raise SceneError(
                    f"{path} was begun with another {name}: {remedy}, or give another --out"
                )
        for left in path.rglob("*.partial"):
            left.unlink()
    for name, content in wanted.items():
        file = path / name
        if not file.exists() or file.read_bytes() != content:
            write_whole(file, content)


def write_whole(file: Path, content: bytes) -> None:
    """A file that is there whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    os.replace(partial, file)
