"""Compute scenes over axes of scene keys: the unfinished blocks of a store, or all in memory."""

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import xarray

from ...meshes import SceneError
from ..crosscheck import (
    LOG,
    Scene,
    TomlTable,
    cores,
    dotted,
    listed,
    lock_folder,
    named_folder,
    naming_arguments,
    plain,
    shown,
)
from .axes import Sweep
from .blocks import compute_blocks
from .compute import compute_block
from .results import DONE, FAILED, PENDING, InMemory, Store, one_scene, template

# greatest number of different reasons that are printed
MOST_REASONS = 10


@naming_arguments
def sweep(
    scene: Scene | str | Path | Mapping[str, object],
    axes: Mapping[str, object] | None = None,
    store: str | Path | None = None,
    executor: Executor | None = None,
    *,
    keep: Sequence[str] | str | None = None,
    zip: Mapping[str, object] | None = None,
    random: Mapping[str, object] | None = None,
    methods: Sequence[str] | str | None = None,
    workers: int | None = None,
    resume: bool = False,
    retry_failed: bool = False,
) -> xarray.Dataset:
    """Compute many scenes over axes of scene keys, and write them to one store.

    Parameters
    ----------
    scene : base scene, of which the other scenes are variants: a Scene, a bundled name, a file or
        nested dictionaries; without axes, a sweep file or the name of a bundled sweep
    axes : values of scene keys such as ``"punch.rings"``, named as in `Scene.changed`: a list or an
        array, ``{"linspace": [...]}`` or ``{"geomspace": [first, last, count]}``. The sweep has all
        combinations of the values of all axes
    store : directory of the store, which is readable while it grows; by default results stay in
        memory
    executor : what computes blocks of scenes, such as an executor of `concurrent.futures`, of MPI,
        or ``client.get_executor()`` on a Dask cluster; by default processes on this machine
    keep : names of the quantities to keep; by default all quantities that do not depend on radius
        or ring
    zip : values of scene keys that vary together, along one dimension
    random : ``count``, ``seed``, and the values or range that each key is drawn from
    methods : methods, instead of those of the base scene
    workers : number of processes on this machine (default: the number of its cores); a sweep that
        takes seconds starts none
    resume : whether to continue the sweep in the directory
    retry_failed : whether to continue it, and to compute failed scenes again

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
    SolverError
        if the executor is lost, or a worker has other code; finished blocks are in the store

    Examples
    --------
    The five fastest of 500 designs, by the depth that wears off in the steady state:

    >>> designs = {"count": 500, "seed": 1, "punch.width_ratio": {"geomspace": [0.2, 5.0]}}
    >>> designs |= {"punch.wear_ratio": {"geomspace": [0.1, 10.0]}}
    >>> rates = sweep("five_rings", random=designs, keep="steady_wear_rate", methods="direct")
    >>> best = rates.steady_wear_rate.squeeze("solver").to_series().nlargest(5)
    """
    kept, chosen = (None if names is None else listed(names) for names in (keep, methods))
    if axes is None and zip is None and random is None and isinstance(scene, str | Path):
        plan = Sweep.load(scene, chosen, kept)
    else:
        base = _table_of(scene) if isinstance(scene, Scene) else scene
        tables = {"axes": axes, "zip": zip, "random": random}
        table: TomlTable = {
            name: _by_key(each) for name, each in tables.items() if each is not None
        }
        table["base"] = str(base) if isinstance(base, Path) else base
        plan = Sweep.of(table if kept is None else table | {"keep": kept}, methods=chosen)
    processes = executor is not None or (isinstance(workers, int) and workers > 1)
    if plan.heights and (store is not None or processes):
        raise SceneError(
            "a sweep of a scene with functions of with_heights runs only in memory and in one "
            "process: leave out `store`, `executor` and `workers`, or give the heights by "
            "punch.profile = { kind = 'table', ... }"
        )
    return compute(plan, store, executor, workers, resume, retry_failed)


def compute(
    plan: Sweep,
    store: str | Path | None,
    executor: Executor | None,
    workers: int | None = None,
    resume: bool = False,
    retry_failed: bool = False,
) -> xarray.Dataset:
    """Compute the unfinished blocks of a sweep; return the dataset of all blocks.

    The arguments are those of `sweep`.
    """
    count = cores() if workers is None else workers
    if not isinstance(count, int) or count < 1:
        raise SceneError(f"workers = {shown(workers)}: give a whole number, 1 or more")
    folder = None if store is None else named_folder(store)
    with nullcontext() if folder is None else lock_folder(folder):
        results = InMemory(plan) if folder is None else Store(plan, folder, resume or retry_failed)
        blocks, start = results.unfinished(retry_failed), time.perf_counter()
        # functions are in the memory of this process only
        count = 1 if plan.heights else count
        computed = compute_blocks(blocks, results.blank, executor, count)
        for done, (number, values) in enumerate(computed, 1):
            results.write(number, values)
            seconds_left = (time.perf_counter() - start) / done * (len(blocks) - done)
            estimate = f", about {seconds_left:.0f} s left ..." if seconds_left else ""
            LOG.info("   sweep  %d of %d blocks%s", done, len(blocks), estimate)
        return results.dataset()


def estimate(plan: Sweep, workers: int | None) -> list[str]:
    """Return what a sweep will need, by a probe of its first scene."""
    blank, count = template(plan), workers or cores()
    probe = plan.part({dim: slice(0, 1) for dim in plan.sizes})
    # the first time, libraries are loaded
    for _ in range(2):
        start = time.perf_counter()
        values = compute_block(probe, one_scene(plan, blank))
        seconds = time.perf_counter() - start
    return [
        f"{plan.count} scenes; a store of {blank.nbytes / 2**20:.3g} MiB before compression",
        f"a probe, the first scene alone, took {seconds:.2g} s; if every scene took as long, the "
        f"sweep would take {seconds * plan.count / count:.3g} s by {count} processes; scenes that "
        "share a discretisation take less",
        *(f"the first scene fails: {reason}" for reason in values["reason"].ravel() if reason),
    ]


def _by_key(axes: Mapping[str, object]) -> TomlTable:
    """Return axes in the form of sweep files: scene keys with dots, and lists of values."""
    if not isinstance(axes, Mapping):
        raise SceneError(f"axes = {shown(axes)}: write sweep(scene, {{'punch.rings': [2, 4, 8]}})")
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


def conclusions_of_sweep(dataset: xarray.Dataset, out: Path) -> tuple[list[str], bool, bool]:
    """Return lines on the scenes of a sweep, and whether all are done, and whether methods agree.

    Parameters
    ----------
    dataset : results of all scenes
    out : folder of the store
    """
    status, reasons = dataset["status"].values, dataset["reason"].to_series()
    finished, failed, pending = (int((status == flag).sum()) for flag in (DONE, FAILED, PENDING))
    lines = [f"{finished} scenes finished, {failed} failed, {pending} left: see {out}"]
    for reason, count in reasons[reasons != ""].value_counts().head(MOST_REASONS).items():
        lines.append(f"{reason} ({count} scenes)")
    if failed or pending:
        lines.append("--resume computes the scenes left, --retry-failed also those that failed")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    return lines, not (failed or pending), not disagreeing
