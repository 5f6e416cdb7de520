"""The store: a Zarr group whose axes are the sweep's, readable by xarray while it grows.

A block of scenes is computed at once, and written at once as one file (a chunk) of each array, the
status of its scenes last: a block is finished if that is there, together with all other chunks,
whose checksums are right, and if the code of the store has computed it. Nothing in the store
depends on the order of the blocks, on the clock or on the machine's name: an interrupted sweep ends
with the same bytes.
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

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.quantities import ERROR, NORMS, STATES, error_name
from ..problem.unit_names import UnitNames, kind_of
from ..scene.scene import Scene
from ..versions import code, stamp, versions
from ..wear.modes import SHOWN_RELAXATION_TIMES
from .axes import ANSWERS, KEEPABLE, Sweep

# what may become of a scene
PENDING, DONE, FAILED = 0, 1, 2
ROOT = "zarr.json"


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

    coordinates: dict[str, object] = {
        "ring": np.arange(1, rings + 1),
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
            error = described(ERROR.format(name, NORMS[quantity.norm]))
            add(error_name(name), ("solver", *quantity.error_dims), error)
    if dataset.sizes["solver"] > 1:
        definition = "greatest difference over its uncertainty: above 1 methods disagree"
        add("disagreement", (), described(definition))
    add("reason", (), described("why the scene has failed"), np.array("", dtype=object))
    add("code", (), described("hash of the code and versions that computed it"), np.uint64(0))
    add("status", (), described("0: pending, 1: done, 2: failed"), np.uint8(PENDING))
    # without labels that no variable has
    return dataset[[*dataset.data_vars]]


def block_sizes(sweep: Sweep, blank: xarray.Dataset) -> dict[str, int]:
    """Return how many scenes along each dimension are computed, written and read at once.

    A block holds the scenes of one geometry as far as that is not too many, for they share a
    discretisation; of few scenes, or of shaped punches, it takes several geometries. Large sweeps
    have larger blocks.
    """
    shared = sweep.first.problem.contact.shared_keys
    larger = min(max(sweep.count // 8192, 1), 64)
    in_memory = 2**27 * sweep.count // blank.nbytes
    unlike = {column.dim for key, column in sweep.columns.items() if not key.startswith(shared)}
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
        about = {
            "sweep": json.dumps(sweep.table),
            "versions": json.dumps(versions()),
            "code": code(),
        }
        _refuse_another(self.path, about)
        blank = template(sweep)
        self.blank = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
        self._sweep, block = sweep, block_sizes(sweep, blank)
        parts = [
            [slice(start, start + block[dim]) for start in range(0, size, block[dim])]
            for dim, size in sweep.sizes.items()
        ]
        # the box of the grid that each block is
        self._regions = [dict(zip(block, box, strict=True)) for box in product(*parts)]
        # what is damaged is found by its checksum
        compressed: dict[str, object] = {"compressors": [ZstdCodec(level=0, checksum=True)]}
        encoding: dict[str, dict[str, object]] = {str(name): compressed for name in blank.variables}
        for name, variable in blank.data_vars.items():
            chunks = (*block.values(), *variable.shape[len(block) :])
            encoding[str(name)] = compressed | {"chunks": chunks}
        with TemporaryDirectory() as fresh, warnings.catch_warnings():
            # texts, and metadata in one place, are not in the specification yet
            warnings.simplefilter("ignore")
            # results that are all empty make no files
            blank.assign_attrs(about).to_zarr(fresh, mode="w", zarr_format=3, encoding=encoding)
            _copy_labels(Path(fresh), self.path)
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
            return bool(np.isin(self._group["status"][place], final).all() and self._read(place))
        # what is damaged fails in many ways
        except Exception:
            return False

    def _read(self, place: tuple[slice, ...]) -> dict[str, Array]:
        """Return what is there of a block; nothing if chunks are lost or of another code."""
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

        Scenes that are done stay where they were not computed again, as for lack of memory.
        """
        place = tuple(self._regions[number].values())
        pending, before = values["status"] == PENDING, dict[str, Array]()
        if pending.any():
            # what is damaged fails in many ways
            with suppress(Exception):
                before = self._read(place)
        kept = pending & (before["status"] == DONE) if before else pending & False
        # also what is empty is a file, so that one that is lost is missed
        with zarr.config.set({"array.write_empty_chunks": True}):
            for name, array in values.items():
                if kept.any():
                    array = array.copy()
                    array[kept] = before[name][kept]
                self._group[name][place] = array

    def dataset(self) -> xarray.Dataset:
        """Return what is there so far, read when it is used."""
        # times in "hours" stay numbers
        return xarray.open_zarr(self.path, chunks=None, decode_timedelta=False)


def _refuse_another(path: Path, about: dict[str, str]) -> None:
    """Refuse a store of something else, and one that does not say of what.

    Raises
    ------
    SceneError
        if its root says something else than `about`, or is damaged or lost
    """
    try:
        there = json.loads((path / ROOT).read_text("utf-8"))["attributes"]
        same = about.items() <= there.items()
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        # a store whose making was stopped has no root yet, and no results
        if not (path / ROOT).exists() and not (path / "status" / "c").exists():
            return
        raise SceneError(
            f"{path / ROOT} is damaged or lost, which says what has computed the store: put a copy "
            "of it there, or give another --out"
        ) from None
    if not same:
        raise SceneError(
            f"{path} was begun with another file, ringwear or libraries: go on by these, "
            "or give another --out"
        )


def _copy_labels(fresh: Path, path: Path) -> None:
    """Copy the labels of a store in order, each file as a whole, the root last."""
    files = [file.relative_to(fresh) for file in sorted(fresh.rglob("*")) if file.is_file()]
    for file in sorted(files, key=lambda file: file == Path(ROOT)):
        target, content = path / file, (fresh / file).read_bytes()
        if not (target.is_file() and target.read_bytes() == content):
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(f"{target.name}.partial")
            partial.write_bytes(content)
            os.replace(partial, target)
