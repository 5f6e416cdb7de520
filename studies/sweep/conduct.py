"""Conduct a sweep, as a command or in Python.

Blocks that are not finished yet are computed in this process, by processes of this machine, or by
the workers of a Dask scheduler. Only this process writes.
"""

import argparse
import json
import logging
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas
import xarray

from ...meshes.errors import RingwearError, SolverError
from ..methods.base import method
from ..problem.scene import Scene
from ..problem.shared import groups
from ..progress import LOG
from ..versions import differing, fingerprint
from .axes import Sweep, described
from .compute import Outcome, compute_block, solve
from .figure import draw
from .layout import FAILED, PENDING, template
from .store import NAME, Store, lock_folder, write_whole

KEPT = "what is finished is kept: go on with --resume"


def sweep(
    base: Scene | str | Mapping[str, Any],
    axes: Mapping[str, Any] | None = None,
    keep: Sequence[str] | None = None,
    *,
    zip: Mapping[str, Any] | None = None,
    random: Mapping[str, Any] | None = None,
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
    axes : values of scene keys such as ``"punch.rings"``, each crossed with every other: a list,
        ``{"linspace": [...]}`` or ``{"geomspace": [first, last, count]}``
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
        if the axes or the base are not understood; single scenes that fail raise nothing
    """
    table = {
        "base": base.table() if isinstance(base, Scene) else base,
        "keep": None if keep is None else list(keep),
        "axes": axes,
        "zip": zip,
        "random": random,
    }
    given = {name: value for name, value in table.items() if value is not None}
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()) if out is None else out)
        stack.enter_context(lock_folder(folder))
        store = compute_store(Sweep.of(given), folder, workers, scheduler, resume, retry_failed)
        return store.dataset().load() if out is None else store.dataset()


def swept(source: str, out: Path, options: argparse.Namespace) -> tuple[list[str], bool, bool]:
    """Conduct the command.

    Returns
    -------
    What there is to say, a line each; whether all scenes are done; whether methods agree.
    """
    plan = Sweep.load(source)
    if options.dry_run:
        return estimate_cost(plan, options.workers), True, True
    with lock_folder(out):
        store = compute_store(
            plan,
            out,
            options.workers,
            options.scheduler,
            options.resume,
            options.retry_failed,
            options.memory,
        )
        dataset = store.dataset()
        summary = summarise(dataset, plan)
        write_whole(out / "summary.json", (json.dumps(summary, indent=1) + "\n").encode())
        write_whole(out / "sweep.png", draw(dataset, plan))
    done, failed = summary["finished"], summary["failed"]
    lines = [f"{done} scenes finished, {failed} failed, {plan.count - done - failed} left"]
    for word, key in (("failed", "reasons"), ("left", "reasons_pending")):
        lines += [f"{word}: {reason} ({count} scenes)" for reason, count in summary[key].items()]
    if done < plan.count:
        lines.append("--resume computes what is left, and with --retry-failed what failed")
    lines += [*summary["conclusions"], f"{NAME}, sweep.png and summary.json in {out}"]
    return lines, done == plan.count, not summary.get("disagreeing")


def compute_store(
    whole: Sweep,
    folder: Path,
    workers: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
    retry_failed: bool = False,
    memory: float | None = None,
) -> Store:
    """Compute what is not finished in a store.

    Blocks whose worker dies again and again are left out.
    """
    blank = template(whole)
    store = Store(whole, blank, folder, resume)
    index, began, last = store.index, time.perf_counter(), 0.0
    todo = (index["checksum"] == 0) | (retry_failed & (index["failed"] > 0))
    before = int(index["done"][~todo].sum() + index["failed"][~todo].sum())
    index[todo] = 0
    if before:
        LOG.info("   sweep  %d of %d scenes are finished and sound", before, whole.count)
    parts = {int(number): whole.part(store.region(number)) for number in np.flatnonzero(todo)}
    of_scene = blank.isel(dict.fromkeys(whole.dims, 0), drop=True)
    for number, outcome in compute_parts(parts, of_scene, workers, scheduler, memory):
        if outcome.computed_by != fingerprint():
            raise SolverError(
                f"a worker has another {differing(outcome.computed_by)} than this process: install "
                f"the same on it; {KEPT}"
            )
        store.write(number, outcome.values)
        done, failed, now = int(index["done"].sum()), int(index["failed"].sum()), time.perf_counter()
        left, rate = whole.count - done - failed, (done + failed - before) / (now - began)
        if now - last > 2 or not left:
            last, ahead = now, f", about {left / rate:.0f} s left ..." if left and rate else ""
            counts = f"{done} finished, {failed} failed, {left} left"
            LOG.info("   sweep  %s; %.3g scenes/s%s", counts, rate, ahead)
    return store


def compute_parts(
    parts: dict[int, Sweep],
    blank: xarray.Dataset,
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> Iterator[tuple[int, Outcome]]:
    """Yield the parts of a sweep, by number, as they are computed.

    Dask gives what a lost worker had to another, and starts a new one; what kills four is left out.
    """
    if not parts or (scheduler is None and min(workers, len(parts)) == 1):
        for number, part in parts.items():
            yield number, compute_block(part, blank)
        return
    from distributed import KilledWorker, wait

    rest, running = iter(parts.items()), dict[Any, int]()
    with connect(scheduler, min(workers, len(parts)), memory) as client:
        while True:
            # none waits behind another, with which its worker might die
            window = max(1, sum(client.nthreads().values()))
            for number, part in islice(rest, max(0, window - len(running))):
                running[client.submit(compute_block, part, blank, pure=False)] = number
            if not running:
                return
            try:
                finished = wait(list(running), 30, "FIRST_COMPLETED").done
            except TimeoutError:
                LOG.warning("   sweep  nothing for 30 s from %d workers", len(client.nthreads()))
                continue
            for future in finished:
                number = running.pop(future)
                error = future.exception() if future.status == "error" else None
                if isinstance(error, KilledWorker):
                    count = parts[number].count
                    LOG.warning("   sweep  %d scenes kill worker after worker: left out", count)
                elif error:
                    reason = f"{type(error).__name__}: {error}".splitlines()[0]
                    raise SolverError(
                        f"the cluster cannot compute ({reason}): install the same ringwear on its "
                        f"scheduler and workers; {KEPT}"
                    ) from error
                else:
                    yield number, future.result()


@contextmanager
def connect(scheduler: str | None, workers: int, memory: float | None) -> Iterator[Any]:
    """Connect to a Dask scheduler, or to so many processes of this machine.

    Processes that take more than their part of the memory (GiB; by default of the machine's) are
    ended, and started anew.
    """
    import dask
    from distributed import Client, LocalCluster

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    # results leave at once: there is nothing to spill, nor to wait for
    limits = {f"distributed.worker.memory.{at}": False for at in ("target", "spill", "pause")}
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(limits))
        try:
            address: Any = scheduler or stack.enter_context(
                LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    memory_limit="auto" if memory is None else int(memory * 2**30 / workers),
                    host="127.0.0.1",
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            )
            client = stack.enter_context(Client(address, timeout=20))
            client.wait_for_workers(1, timeout=20)
            yield client
        except TimeoutError as error:
            raise SolverError(
                f"the scheduler {scheduler} does not answer, or has no workers ({error}): start "
                "them by `dask scheduler` and `dask worker`, or leave out --scheduler"
            ) from error
        except (CancelledError, OSError, ValueError) as error:
            raise SolverError(f"the scheduler {scheduler} is lost: {error}; {KEPT}") from error


def summarise(dataset: xarray.Dataset, plan: Sweep) -> dict[str, Any]:
    """Summarise a map in numbers.

    How many scenes are done, the commonest reasons why others are not, where methods disagree most
    and where their errors are least honest.
    """
    status, reason = dataset["status"].values.ravel(), dataset["reason"].values.ravel()

    def commonest(of: int) -> dict[str, int]:
        texts = pandas.Series(reason[(status == of) & (reason != "")], dtype=object)
        return {str(text): int(count) for text, count in texts.value_counts().head(10).items()}

    def least(values: Any) -> tuple[float, str]:
        place = np.unravel_index(np.nanargmin(values), values.shape)
        return float(values[place]), described(plan.changes(tuple(map(int, place))))

    summary: dict[str, Any] = {
        "scenes": plan.count,
        "finished": int((status == 1).sum()),
        "failed": int((status == FAILED).sum()),
        "reasons": commonest(FAILED),
        "reasons_pending": commonest(PENDING),
        "sweep": plan.table,
        "conclusions": [],
    }
    if "disagreement" in dataset and np.isfinite(values := dataset["disagreement"].values).any():
        greatest, scene = least(-values)
        summary["greatest_disagreement"] = {"over_uncertainty": -greatest, "scene": scene}
        summary["disagreeing"] = int((values > 1).sum())
        summary["conclusions"].append(
            f"methods disagree in {summary['disagreeing']} scenes; greatest difference over its "
            f"uncertainty: {-greatest:.2g}, at {scene}"
        )
    if "effectivity" in dataset and np.isfinite(values := dataset["effectivity"].values).any():
        smallest, scene = least(values)
        summary["least_effectivity"] = {"stated_over_error": smallest, "scene": scene}
        summary["conclusions"].append(
            "least error stated, over the one that a far more accurate method shows: "
            f"{smallest:.2g}, at {scene}"
        )
    return summary


def estimate_cost(plan: Sweep, workers: int) -> list[str]:
    """Say what a sweep will take, by computing one scene of it as a probe."""
    places = np.unique(np.linspace(0, plan.count - 1, 1000).astype(int))
    scenes = []
    for place in places:
        try:
            scenes.append(plan.scene(tuple(map(int, np.unravel_index(place, plan.shape)))))
        except RingwearError as error:
            LOG.warning("   sweep  %s", error)
    problems = [plan.problem(scene) for scene in scenes]
    together = groups(problems)
    # the sharpest scene comes first
    number = max(together, key=len)[0]
    seconds = []
    # the second time everything is loaded
    for _ in range(2):
        start = time.perf_counter()
        for name in scenes[number].methods:
            solve(method(name), [problems[number]])
        seconds.append(time.perf_counter() - start)
    sampled = "" if len(places) == plan.count else f" ({len(places)} of them looked at)"
    return [
        f"{plan.count} scenes{sampled} in {len(together)} groups that share a discretisation",
        f"a store of {template(plan).nbytes / 2**20:.3g} MiB before compression",
        f"at most about {min(seconds) * plan.count / min(workers, plan.count):.2g} s by {workers} "
        f"processes: a probe, one scene of the largest group by itself, took {min(seconds):.2g} s; "
        "scenes that share a discretisation take less",
    ]
