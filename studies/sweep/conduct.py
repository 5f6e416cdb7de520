"""Conduct a sweep, as a command or in Python: compute what is not finished in its store."""

import argparse
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import xarray

from ...meshes.errors import SceneError
from ..calls import naming_arguments
from ..figures.style import new_figure, set_logarithmic
from ..output.folder import Folder, lock_folder, output_folder, refuse_foreign_folders
from ..output.one_file import make
from ..problem.fields import TomlTable
from ..progress import LOG
from ..scene.explain import shown
from ..scene.keys import dotted, listed
from ..scene.scene import Scene
from .axes import Sweep
from .cost import estimate_cost
from .store import DONE, FAILED, PENDING, Store
from .workers import compute_blocks

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
    base : the scene that all others are changed from: a Scene, a bundled name, a file or nested
        dictionaries
    axes : values of scene keys such as ``"punch.rings"``, named as in `Scene.changed`, each crossed
        with every other: a list or an array, ``{"linspace": [...]}`` or
        ``{"geomspace": [first, last, count]}``
    keep : names of quantities; by default all that need neither radius nor ring
    zip : keys whose values go together
    random : ``count``, ``seed``, and what to draw each key from
    out : directory to keep the store in, readable while it grows; by default results stay in memory
    workers, scheduler : processes on this machine (in a script, call from under ``if __name__ ==
        "__main__"`` if more than one), or the address of a Dask scheduler
    resume : go on with what is in `out`
    retry_failed : then try again the scenes that have failed

    Returns
    -------
    Dataset whose dimensions are the axes, then solver, time and so on, in the scenes' own units:
    the quantities kept, the relative error that each method states of them (``<quantity>_error``),
    and `status` (1 done, 2 failed) and `reason` of each scene.

    Raises
    ------
    SceneError
        if the axes or the base are not understood, or the base has functions (`with_heights`),
        which neither a store nor other processes are given; single scenes that fail raise nothing
    """
    table = {
        "base": _table_of(base) if isinstance(base, Scene) else base,
        "keep": None if keep is None else listed(keep),
        "axes": _by_key(axes),
        "zip": _by_key(zip),
        "random": _by_key(random),
    }
    given = Sweep.of({name: value for name, value in table.items() if value is not None})
    if given.heights and (out is not None or workers > 1 or scheduler is not None):
        raise SceneError(
            "functions of with_heights can be swept over in memory by one process only: leave out "
            "`out`, `workers` and `scheduler`, or give the heights by punch.profile = { kind = "
            "'table', ... }"
        )
    options = resume, retry_failed, workers, scheduler
    if out is not None:
        return compute(given, Path(out), *options)
    with TemporaryDirectory() as folder:
        return compute(given, Path(folder), *options).load()


def _by_key(axes: Mapping[str, object] | None) -> TomlTable | None:
    """Return axes by scene keys as files have them, with dots and with lists of numbers."""
    if axes is None:
        return None
    if not isinstance(axes, Mapping):
        raise SceneError(f"axes = {shown(axes)}: write sweep(base, {{'punch.rings': [2, 4, 8]}})")
    return {dotted(key): _as_list(values) for key, values in axes.items()}


def _as_list(values: Any) -> object:
    if isinstance(values, range | tuple):
        return list(values)
    return values.tolist() if hasattr(values, "tolist") else values


def _table_of(scene: Scene) -> TomlTable:
    """Return a scene as nested dictionaries, with the functions of its face."""
    table = scene.table()
    if scene.punch.heights:
        table["punch"]["heights"] = scene.punch.heights
    return table


def compute(
    sweep: Sweep,
    folder: Path,
    resume: bool,
    retry_failed: bool,
    workers: int,
    scheduler: str | None,
    memory: float | None = None,
) -> xarray.Dataset:
    """Compute what is not finished of the store in a folder, and return all that is there."""
    with lock_folder(folder):
        store = Store(sweep, folder, resume or retry_failed)
        blocks, began = store.unfinished(retry_failed), time.perf_counter()
        results = compute_blocks(blocks, store.blank, workers, scheduler, memory)
        for count, (number, values) in enumerate(results, 1):
            store.write(number, values)
            left = (time.perf_counter() - began) / count * (len(blocks) - count)
            ahead = f", about {left:.0f} s left ..." if left else ""
            LOG.info("   sweep  %d of %d blocks%s", count, len(blocks), ahead)
        return store.dataset()


def conduct(source: str, out: Path, options: argparse.Namespace) -> tuple[list[str], bool, bool]:
    """Conduct the command.

    Returns
    -------
    What there is to say, a line each; whether all scenes are done; whether methods agree.
    """
    plan = Sweep.load(source)
    if options.dry_run:
        return estimate_cost(plan, options.workers, options.memory), True, True
    if out.is_dir():
        refuse_foreign_folders(out)
        Folder(out, "sweep").refuse_to_replace([PICTURE])
    kinds = options.resume, options.retry_failed
    workers = options.workers, options.scheduler, options.memory
    dataset = compute(plan, out, *kinds, *workers)
    with output_folder(out, "sweep", [PICTURE]) as hidden:
        failures = make(hidden.hidden / PICTURE, partial(draw, dataset, plan))
    status, reasons = dataset["status"].values, dataset["reason"].to_series()
    done, failed, left = (int((status == flag).sum()) for flag in (DONE, FAILED, PENDING))
    lines = [f"{done} scenes finished, {failed} failed, {left} left: see {out}"]
    for reason, count in reasons[reasons != ""].value_counts().head(10).items():
        lines.append(f"{reason} ({count} scenes)")
    if failed or left:
        lines.append("--resume computes what is left, and --retry-failed what failed, too")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    return lines + failures, done == plan.count and not failures, not disagreeing


def draw(dataset: xarray.Dataset, plan: Sweep, file: Path) -> None:
    """Draw up to four of the quantities kept over the two longest axes of numbers.

    By the first method that has them, at the first value of other axes, and at the last time.
    """
    numbers = (of for of in plan.columns.values() if dataset[of.name].dtype.kind in "fi")
    places = {of.dim: of.name for of in numbers}
    across = sorted(places, key=lambda dim: -plan.sizes[dim])[:2]
    shown = [name for name in plan.keep if not {"radius", "ring"} & {*dataset[name].dims}][:4]
    figure = new_figure(6.0, 0.6 + 3.5 * len(shown))
    for number, name in enumerate(shown if across else (), 1):
        axes = figure.add_subplot(len(shown), 1, number)
        part = dataset[name].dropna("solver", how="all")
        others = {dim: -(dim == "time") for dim in part.dims if dim not in across}
        if part.size:
            part, x = part.isel(others), places[across[0]]
            if part[across[-1]].size > 8 and len(across) > 1:
                part.plot.pcolormesh(x=x, y=places[across[1]], ax=axes)
            else:
                part.plot.line(".", x=x, ax=axes)
            if 0 < 20 * dataset[x].min() < dataset[x].max():
                set_logarithmic(axes, "x")
    figure.savefig(file)
