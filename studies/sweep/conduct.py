"""Conduct a sweep from the command line or in Python: compute unfinished blocks of its store."""

import argparse
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray

from ..crosscheck import LOG, Scene, SceneError, output_folder
from ..crosscheck.problem.fields import TomlTable
from ..crosscheck.problem.written import plain, shown
from ..crosscheck.result.output.folder import (
    Folder,
    lock_folder,
    named_folder,
    refuse_foreign_folders,
)
from ..crosscheck.result.output.one_file import make
from ..crosscheck.scene.calls import naming_arguments
from ..crosscheck.scene.keys import dotted, listed
from ..figures.style import new_figure, set_logarithmic
from .axes import Sweep
from .cost import estimate_cost
from .extra import require
from .flags import DONE, FAILED, PENDING
from .memory import InMemory
from .workers import compute_blocks

if TYPE_CHECKING:
    from .store import Store

# file of the figure that the command draws
PICTURE = "sweep.png"


@naming_arguments
def sweep(
    base: Scene | str | Mapping[str, object],
    axes: Mapping[str, object] | None = None,
    keep: Sequence[str] | str | None = None,
    *,
    zip: Mapping[str, object] | None = None,
    random: Mapping[str, object] | None = None,
    out: str | Path | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
    retry_failed: bool = False,
) -> xarray.Dataset:
    """Compute scenes over axes of scene keys.

    Parameters
    ----------
    base : base scene, of which the other scenes are variants: a Scene, a bundled name, a file or
        nested dictionaries
    axes : values of scene keys such as ``"punch.rings"``, named as in `Scene.changed`: a list or an
        array, ``{"linspace": [...]}`` or ``{"geomspace": [first, last, count]}``. The sweep has all
        combinations of the values of all axes.
    keep : names of the quantities to keep; by default all quantities that do not depend on radius
        or ring
    zip : values of scene keys that vary together, along one dimension
    random : ``count``, ``seed``, and the values or range that each key is drawn from
    out : directory of the store, which is readable while it grows; by default results stay in
        memory
    workers : number of processes on this machine; if there are more than one, a script has to call
        this function under ``if __name__ == "__main__"``
    scheduler : address of a Dask scheduler, instead of processes on this machine
    resume : whether to continue the sweep in `out`
    retry_failed : whether to continue the sweep in `out` and compute failed scenes again

    Returns
    -------
    xarray.Dataset
        Its dimensions are the axes, followed by solver, time and so on. It contains the quantities
        to keep, in the units of the scenes, the relative error estimate of each method
        (``<quantity>_error``), and `status` (1 done, 2 failed) and `reason` of each scene.

    Raises
    ------
    SceneError
        if the axes or the base scene are invalid, or if a base scene with functions
        (`with_heights`) is to be stored or sent to other processes; a single scene that fails
        raises nothing
    """
    table = {
        "base": _table_of(base) if isinstance(base, Scene) else base,
        "keep": None if keep is None else listed(keep),
        "axes": _by_key(axes),
        "zip": _by_key(zip),
        "random": _by_key(random),
    }
    plan = Sweep.of({name: value for name, value in table.items() if value is not None})
    if plan.heights and (out is not None or workers > 1 or scheduler is not None):
        raise SceneError(
            "a sweep of a scene with functions of with_heights runs only in memory and in one "
            "process: leave out `out`, `workers` and `scheduler`, or give the heights by "
            "punch.profile = { kind = 'table', ... }"
        )
    if not isinstance(workers, int) or workers < 1:
        raise SceneError(f"workers = {shown(workers)}: give a whole number, 1 or more")
    if out is not None:
        folder = named_folder(out)
        return compute_in_folder(plan, folder, resume, retry_failed, workers, scheduler)
    return compute(InMemory(plan), False, workers, scheduler)


def _by_key(axes: Mapping[str, object] | None) -> TomlTable | None:
    """Return axes in the form of sweep files: scene keys with dots, and lists of values."""
    if axes is None:
        return None
    if not isinstance(axes, Mapping):
        raise SceneError(f"axes = {shown(axes)}: write sweep(base, {{'punch.rings': [2, 4, 8]}})")
    return {dotted(key): _as_list(values) for key, values in axes.items()}


def _as_list(values: Any) -> object:
    if isinstance(values, range | tuple):
        return list(values)
    if isinstance(values, Mapping):
        return {key: plain(entry) for key, entry in values.items()}
    # arrays of xarray have their numbers in `values`
    values = getattr(values, "values", values)
    return values.tolist() if hasattr(values, "tolist") else values


def _table_of(scene: Scene) -> TomlTable:
    """Return a scene as nested dictionaries, including the functions of `with_heights`."""
    table = scene.table()
    if scene.punch.heights:
        table["punch"]["heights"] = scene.punch.heights
    return table


def compute_in_folder(
    sweep: Sweep,
    folder: Path,
    resume: bool,
    retry_failed: bool,
    workers: int,
    scheduler: str | None,
    memory: float | None = None,
) -> xarray.Dataset:
    """Compute the unfinished blocks of the store in a folder; return the dataset of all blocks.

    Parameters
    ----------
    sweep : sweep to compute
    folder : folder of the store
    resume, retry_failed : as in the function `sweep`
    workers, scheduler, memory : as in `compute`

    Raises
    ------
    SceneError
        if the extra `sweep` is needed and is not installed
    """
    require(("zarr",), "the store of a sweep")
    from .store import Store

    with lock_folder(folder):
        store = Store(sweep, folder, resume or retry_failed)
        return compute(store, retry_failed, workers, scheduler, memory)


def compute(
    results: "Store | InMemory",
    retry_failed: bool,
    workers: int,
    scheduler: str | None,
    memory: float | None = None,
) -> xarray.Dataset:
    """Compute the unfinished blocks of a sweep; return the dataset of all blocks.

    Parameters
    ----------
    results : results of the sweep so far, which know its blocks
    retry_failed : whether to compute failed scenes again
    workers, scheduler : as in the function `sweep`
    memory : memory in GiB that all processes on this machine may use; if None, they may use all
        memory of the machine

    Raises
    ------
    SceneError
        if the extra `sweep` is needed and is not installed
    """
    if workers > 1 or scheduler is not None or memory is not None:
        require(("dask", "distributed"), "a sweep by several processes, or with --memory,")
    blocks, start = results.unfinished(retry_failed), time.perf_counter()
    computed = compute_blocks(blocks, results.blank, workers, scheduler, memory)
    for count, (number, values) in enumerate(computed, 1):
        results.write(number, values)
        seconds_left = (time.perf_counter() - start) / count * (len(blocks) - count)
        estimate = f", about {seconds_left:.0f} s left ..." if seconds_left else ""
        LOG.info("   sweep  %d of %d blocks%s", count, len(blocks), estimate)
    return results.dataset()


def conduct(source: str, out: Path, options: argparse.Namespace) -> tuple[list[str], bool, bool]:
    """Conduct a sweep for the command line.

    Parameters
    ----------
    source : sweep file, or the name of a bundled sweep
    out : output folder
    options : options of the command line

    Returns
    -------
    lines : text to print
    complete : whether all scenes are done and all files are written
    agree : whether the methods agree in all scenes
    """
    plan = Sweep.load(source)
    if options.dry_run:
        return estimate_cost(plan, options.workers, options.memory), True, True
    if out.is_dir():
        refuse_foreign_folders(out)
        Folder(out, "sweep").refuse_to_replace([PICTURE])
    resume_options = options.resume, options.retry_failed
    worker_options = options.workers, options.scheduler, options.memory
    dataset = compute_in_folder(plan, out, *resume_options, *worker_options)
    with output_folder(out, "sweep", [PICTURE]) as hidden:
        failures = make(hidden.hidden / PICTURE, partial(draw, dataset, plan))
    status, reasons = dataset["status"].values, dataset["reason"].to_series()
    finished, failed, pending = (int((status == flag).sum()) for flag in (DONE, FAILED, PENDING))
    lines = [f"{finished} scenes finished, {failed} failed, {pending} left: see {out}"]
    for reason, count in reasons[reasons != ""].value_counts().head(10).items():
        lines.append(f"{reason} ({count} scenes)")
    if failed or pending:
        lines.append("--resume computes the scenes left, --retry-failed also those that failed")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    return lines + failures, finished == plan.count and not failures, not disagreeing


def draw(dataset: xarray.Dataset, plan: Sweep, file: Path) -> None:
    """Draw up to four of the kept quantities over the two longest numerical axes.

    The figure shows the first method that has the quantity, at the first value of the other axes,
    and at the last time.
    """
    numerical = (
        column for column in plan.columns.values() if dataset[column.name].dtype.kind in "fi"
    )
    coordinate_names = {column.dim: column.name for column in numerical}
    drawn_dims = sorted(coordinate_names, key=lambda dim: -plan.sizes[dim])[:2]
    drawn_quantities = [
        name for name in plan.keep if not {"radius", "ring"} & {*dataset[name].dims}
    ][:4]
    figure = new_figure(6.0, 0.6 + 3.5 * len(drawn_quantities))
    for number, name in enumerate(drawn_quantities if drawn_dims else (), 1):
        axes = figure.add_subplot(len(drawn_quantities), 1, number)
        values = dataset[name].dropna("solver", how="all")
        other_indices = {dim: -(dim == "time") for dim in values.dims if dim not in drawn_dims}
        if values.size:
            values, x = values.isel(other_indices), coordinate_names[drawn_dims[0]]
            other = coordinate_names[drawn_dims[1]] if len(drawn_dims) > 1 else None
            if other and values[drawn_dims[-1]].size > 8 and _in_order(values[x], values[other]):
                values.plot.pcolormesh(x=x, y=other, ax=axes)
            else:
                values.plot.line(".", x=x, hue=other, ax=axes)
            if 0 < 20 * dataset[x].min() < dataset[x].max():
                set_logarithmic(axes, "x")
    figure.savefig(file)


def _in_order(*coordinates: xarray.DataArray) -> bool:
    """Return whether coordinates rise or fall, as a map of cells needs; random draws do not."""
    steps = [np.diff(coordinate) for coordinate in coordinates]
    return all(bool((step > 0).all() or (step < 0).all()) for step in steps)
