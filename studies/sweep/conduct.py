"""Conduct a sweep, as a command or in Python.

Blocks that are not finished yet, by processes here or by a Dask cluster.
"""

import argparse
import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ..crosscheck.sizes import machine_memory
from ..problem.scene import Scene
from ..progress import LOG
from .axes import Sweep
from .blocks import Block, block_shape, blocks
from .cluster import check_fingerprint, compute_on_cluster
from .compute import computed
from .layout import DONE, FAILED, Layout, Outcome, layout
from .plan import planned
from .store import NAME, Store, alone, write_whole
from .summary import summary

# seconds between lines of progress
EVERY = 2.0
# blocks given to each process, of which it computes one
AHEAD = 2
# times that the process that computes a block may die before the block is left alone
MOST_DEATHS = 3


@dataclass
class Tally:
    """How far a sweep is: scenes."""

    scenes: int
    finished: int = 0
    failed: int = 0
    found: int = 0  # finished by an earlier run
    began: float = field(default_factory=time.perf_counter)

    @property
    def left(self) -> int:
        return self.scenes - self.finished - self.failed

    def line(self) -> str:
        seconds, new = time.perf_counter() - self.began, self.finished + self.failed - self.found
        rate = new / seconds if seconds else 0.0
        ahead = f", about {self.left / rate:.0f} s left" if rate and self.left else ""
        return (
            f"   sweep  {self.finished} finished, {self.failed} failed, {self.left} left; "
            f"{rate:.3g} scenes/s{ahead}"
        )


def conduct(
    store: Store, workers: int = 1, scheduler: str | None = None, retry_failed: bool = False
) -> Tally:
    """Compute what is not finished in a store, by so many processes or by the Dask cluster of a
    scheduler.

    Blocks whose worker dies again and again are left, and counted as such.
    """
    whole = store.sweep
    tally, last = Tally(whole.count), 0.0
    unfinished = []
    for block in blocks(whole, store.block_shape):
        statuses = store.statuses(block)
        if statuses is None or (retry_failed and (statuses == FAILED).any()):
            unfinished.append(block)
        else:
            _count(tally, statuses)
    tally.found = tally.finished + tally.failed
    if tally.found:
        LOG.info("   sweep  %d of %d scenes are finished and sound", tally.found, tally.scenes)
    for block, outcome in _outcomes(whole, store.layout, unfinished, workers, scheduler):
        check_fingerprint(outcome.computed_by, "a worker")
        store.write(block, outcome)
        _count(tally, outcome.status)
        if time.perf_counter() - last > EVERY or not tally.left:
            last = time.perf_counter()
            LOG.info(tally.line() + (" ..." if tally.left else ""))
    return tally


def _count(tally: Tally, statuses: Any) -> None:
    tally.failed += int(np.count_nonzero(statuses == FAILED))
    tally.finished += int(np.count_nonzero(statuses == DONE))


def _outcomes(
    whole: Sweep, laid_out: Layout, todo: list[Block], workers: int, scheduler: str | None
) -> Iterator[tuple[Block, Outcome]]:
    """Blocks as they are finished."""
    if scheduler is not None:
        yield from compute_on_cluster(scheduler, whole, laid_out, todo)
    elif workers > 1 and len(todo) > 1:
        yield from _from_processes(whole, laid_out, todo, workers)
    else:
        for block in todo:
            yield block, computed(whole.part(block.bounds), laid_out)


Running = dict[Future[Outcome], Block]


def _from(
    executor: Executor,
    whole: Sweep,
    laid_out: Layout,
    todo: list[Block],
    running: Running,
    window: int,
) -> Iterator[tuple[Block, Outcome]]:
    """Blocks from an executor, a few at a time, so that neither work nor results pile up."""
    rest = iter(todo)
    while True:
        for block in islice(rest, window - len(running)):
            running[executor.submit(computed, whole.part(block.bounds), laid_out)] = block
        if not running:
            return
        for future in sorted(
            wait(running, return_when=FIRST_COMPLETED).done, key=lambda one: running[one].number
        ):
            outcome = future.result()
            yield running.pop(future), outcome


def _from_processes(
    whole: Sweep, laid_out: Layout, todo: list[Block], workers: int
) -> Iterator[tuple[Block, Outcome]]:
    """Blocks from processes on this machine.

    When one dies they begin anew, and what was running comes last, one by one.
    """
    deaths = {block.number: 0 for block in todo}
    while deaths:
        left = [block for block in todo if block.number in deaths]
        fresh = [block for block in left if not deaths[block.number]]
        batch, count = (fresh, workers) if fresh else (left[:1], 1)
        running: Running = {}
        try:
            with _processes(count) as executor:
                for block, outcome in _from(
                    executor, whole, laid_out, batch, running, AHEAD * count
                ):
                    del deaths[block.number]
                    yield block, outcome
        except BrokenProcessPool:
            for block in running.values():
                deaths[block.number] += 1
                if deaths[block.number] == MOST_DEATHS:
                    del deaths[block.number]
                    LOG.warning(
                        "   sweep  %d scenes killed their process %d times: left out",
                        block.count,
                        MOST_DEATHS,
                    )


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    """So many processes of this machine, which end with this one, whatever ends it."""
    others = set(multiprocessing.active_children())
    # a fork would hold the lock of the directory, and the state of every library, for ever
    context = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=_end_with_the_parent)
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - others:
            child.terminate()
        raise
    executor.shutdown()


def _end_with_the_parent() -> None:
    """In a process of the pool.

    Ctrl-C is the parent's affair, and without the parent there is nothing to do.
    """

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=watch, daemon=True).start()


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
    table: dict[str, Any] = {"base": base.table() if isinstance(base, Scene) else base}
    given = {
        "axes": axes,
        "zip": zip,
        "random": random,
        "keep": None if keep is None else list(keep),
    }
    made = Sweep.of(table | {name: value for name, value in given.items() if value is not None})
    if out is None:
        store = _store(made, None, resume)
        conduct(store, workers, scheduler)
        return store.dataset().load()
    with alone(Path(out)):
        store = _store(made, Path(out), resume)
        conduct(store, workers, scheduler, retry_failed)
        return store.dataset()


def _store(made: Sweep, directory: Path | None, resume: bool) -> Store:
    kept = layout(made)
    return Store(made, kept, block_shape(made, kept), directory, resume)


def swept(source: str, out: Path, options: argparse.Namespace) -> tuple[list[str], bool, bool]:
    """The command: what it found, a line each; whether all scenes are done; whether methods
    agree.
    """
    from .figure import drawn

    made = Sweep.load(source)
    plan = planned(made, options.memory or machine_memory(), options.workers).said(options.workers)
    if options.dry_run:
        return plan, True, True
    for line in plan:
        LOG.info("   sweep  %s", line)
    with alone(out):
        store = _store(made, out, options.resume)
        tally = conduct(store, options.workers, options.scheduler, options.retry_failed)
        dataset = store.dataset()
        found = summary(dataset, made)
        write_whole(out / "summary.json", (json.dumps(found, indent=1) + "\n").encode())
        write_whole(out / "sweep.png", drawn(dataset, made))
    lines = [*_said(tally, found), f"{NAME}, sweep.png and summary.json in {out}"]
    return lines, tally.finished == tally.scenes, not found.get("disagreeing")


def _said(tally: Tally, found: dict[str, Any]) -> list[str]:
    lines = [f"{tally.finished} scenes finished, {tally.failed} failed, {tally.left} left"]
    lines += [f"failed: {reason} ({count} scenes)" for reason, count in found["reasons"].items()]
    pending = found["reasons_pending"]
    lines += [f"left: {reason} ({count} scenes)" for reason, count in pending.items()]
    if tally.failed or tally.left:
        lines.append("--resume computes what is left, and with --retry-failed what failed")
    return [*lines, *found["conclusions"]]
