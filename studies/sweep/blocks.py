"""Compute blocks of scenes, in this process or by the workers of an executor.

If a block kills its workers, for example because memory is insufficient, it is split into halves,
repeatedly down to single scenes.
"""

import time
from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from math import prod
from typing import Any, NamedTuple

import numpy as np
import xarray

from ...meshes import Array, SceneError, SolverError
from ..crosscheck import LIBRARIES, LOG, computed_with, machine_memory, stamp
from .axes import Sweep
from .cluster import threads_of
from .compute import MOST_TOGETHER, compute_block
from .flags import PENDING, RESUME_HINT
from .largest import find_largest
from .processes import Processes, WorkerDiedError

# number of processes of this machine that a block has to kill before it is split; a single death
# may have another cause
DEATHS_BEFORE_SPLIT = 2
# seconds of computing that processes have to save, or else they are not started: they take about as
# long to start and to load libraries
LEAST_SECONDS_SAVED = 4.0
# a first block that took less than these seconds may consist mainly of loading libraries; a second
# one is then computed here before the time of blocks is estimated
LOADING_SECONDS = 2.0
# number of blocks by which the time of those that remain is estimated
LATEST = 3
# fraction of the machine's memory that the scenes of a block may use in this process, because
# no other process would restart this one if it ran out of memory
GREATEST_MEMORY_FRACTION = 0.5
# tasks that wait or run at once, if an executor does not tell how many workers it has
MOST_TASKS = 16
# seconds without a result after which a warning is logged
PATIENCE = 30.0

Values = dict[str, Array]


class Piece(NamedTuple):
    """A box of the scenes of a block.

    Parameters
    ----------
    number : number of the block
    box : slice of the block along each dimension
    deaths : number of processes that have died while they computed it
    """

    number: int
    box: tuple[slice, ...]
    deaths: int = 0

    @property
    def sizes(self) -> list[int]:
        """Number of scenes of the piece along each dimension."""
        return [extent.stop - extent.start for extent in self.box]

    def halves(self) -> "tuple[Piece, Piece]":
        """Return the two halves of the piece, cut along its longest dimension."""
        along = int(np.argmax(self.sizes))
        extent, (before, after) = self.box[along], (self.box[:along], self.box[along + 1 :])
        middle = (extent.start + extent.stop) // 2
        return (
            Piece(self.number, (*before, slice(extent.start, middle), *after)),
            Piece(self.number, (*before, slice(middle, extent.stop), *after)),
        )


def compute_blocks(
    sweep: Sweep,
    blocks: Mapping[int, Sweep],
    blank: xarray.Dataset,
    executor: Executor | None,
    workers: int,
    memory: float | None,
) -> Iterator[tuple[int, Values]]:
    """Yield the number of each block of a sweep, and its values as returned by `compute_block`.

    If a process dies, another one gets its block. If that dies, too, the block is split into
    halves. A single scene that kills its processes stays pending, with the reason.

    One worker without a memory limit is this process itself. With several workers, this process
    also computes small blocks if the remaining work is too short to justify starting processes.

    Parameters
    ----------
    sweep : all scenes
    blocks : blocks to compute, each as a sweep, by number
    blank : empty results of one scene (`template.one_scene`)
    executor : computes the blocks; None for processes on this machine
    workers : number of these processes
    memory : memory in GiB that these processes may use together; if None, they may use all memory
        of the machine

    Raises
    ------
    SceneError
        if `memory` is less than the libraries of the processes need
    SolverError
        if workers are lost, or if one of them has other code or versions or no ringwear; the blocks
        of such a worker are not yielded
    """
    remaining = dict(blocks)
    if executor is not None:
        yield from _computed_by(executor, remaining, blank, "the memory of its workers")
        return
    if memory is None:
        yield from _computed_here(sweep, remaining, blank, min(workers, len(remaining)))
    if not remaining:
        return
    workers = min(workers, len(remaining))
    _refuse_too_little_memory(workers, memory)
    share = worker_memory(workers, memory)
    with Processes(workers, share * 2**30) as processes:
        available = f"{share:.3g} GiB, the share of --memory of one worker"
        yield from _computed_by(processes, remaining, blank, available)


def _computed_here(
    sweep: Sweep, remaining: dict[int, Sweep], blank: xarray.Dataset, workers: int
) -> Iterator[tuple[int, Values]]:
    """Compute blocks in this process, as long as others would not help; remove them from those."""
    seconds, fits = list[float](), workers == 1 or _fits_here(sweep)
    for number in list(remaining):
        if workers > 1 and not (fits and _too_short(seconds, len(remaining), workers)):
            return
        began = time.process_time()
        values = compute_block(remaining.pop(number), blank)
        seconds.append(time.process_time() - began)
        if (values["code"] != stamp()).any():
            raise SolverError(
                f"files of ringwear were edited before this process loaded them; {RESUME_HINT}"
            )
        yield number, values


def compute_with_versions(block: Sweep, blank: xarray.Dataset) -> tuple[Values, dict[str, str]]:
    """Compute a block by a worker; return its values, and the code and versions of the worker."""
    values = compute_block(block, blank)
    return values, computed_with()


def _computed_by(
    executor: Executor, blocks: Mapping[int, Sweep], blank: xarray.Dataset, available: str
) -> Iterator[tuple[int, Values]]:
    """Compute blocks by an executor.

    Parameters
    ----------
    available : memory of a worker in words, for scenes that need more
    """
    shapes = {number: [*block.sizes.values()] for number, block in blocks.items()}
    waiting = deque(
        Piece(number, tuple(slice(0, size) for size in sizes)) for number, sizes in shapes.items()
    )
    running: dict[Future[tuple[Values, dict[str, str]]], Piece] = {}
    gathered = _Gathered(shapes)
    last_result, checked = time.monotonic(), set[str]()
    while True:
        count, chosen = workers_of(executor, checked)
        # each worker has at most one block: a waiting one would die with the worker
        while waiting and len(running) < count:
            piece = waiting.popleft()
            block = blocks[piece.number]
            scenes = block.part(dict(zip(block.sizes, piece.box, strict=True)))
            running[executor.submit(compute_with_versions, scenes, blank, **chosen)] = piece
        if not running and not waiting:
            return
        if not running:
            # all workers of a cluster are lost, and others may join
            time.sleep(1.0)
        finished, _ = wait(running, 1.0, FIRST_COMPLETED)
        if finished:
            last_result = time.monotonic()
        elif time.monotonic() > last_result + PATIENCE:
            last_result = time.monotonic()
            LOG.warning("   sweep  no results for %.0f s from %d workers", PATIENCE, count)
        for future in finished:
            piece = running.pop(future)
            if future.cancelled():
                raise CancelledError
            error = future.exception()
            if error is not None and not _is_death(error):
                raise _why_not_computed(error) from error
            if isinstance(error, WorkerDiedError) and piece.deaths + 1 < DEATHS_BEFORE_SPLIT:
                waiting.appendleft(piece._replace(deaths=piece.deaths + 1))
                continue
            if error is not None and prod(piece.sizes) > 1:
                scene_count = prod(piece.sizes)
                LOG.info("   sweep  %d scenes kill their workers: they are split", scene_count)
                waiting.extendleft(reversed(piece.halves()))
                continue
            if error is None:
                values, versions = future.result()
                if (values["code"] != stamp()).any():
                    raise SolverError(
                        f"a worker has another ringwear or other libraries, {versions}, than this "
                        f"process, {computed_with()}, and its results are discarded: install the "
                        f"same code and versions on it; {RESUME_HINT}"
                    )
            else:
                values = _left_pending(blank, piece.sizes, available)
            if (whole := gathered.add(piece, values)) is None:
                continue
            if pending := int((whole["status"] == PENDING).sum()):
                LOG.warning("   sweep  %d scenes kill every worker: left out", pending)
            yield piece.number, whole


def workers_of(executor: Executor, checked: set[str]) -> tuple[int, dict[str, Any]]:
    """Return how many workers an executor has at the moment, and arguments that choose them.

    A worker that joins a cluster gets a block only after it has been checked. If all chosen workers
    are lost before they begin, Dask gives the block to others.

    Parameters
    ----------
    checked : workers of Dask that have been found to have the same code and versions; new ones are
        added

    Raises
    ------
    SolverError
        if a new worker of Dask has other code or versions
    """
    # executors of the standard library and of MPI, and those of Dask
    if (count := getattr(executor, "_max_workers", None)) is not None:
        return int(count), {}
    if (client := getattr(executor, "_client", None)) is None:
        return MOST_TASKS, {}
    threads = threads_of(client, checked)
    return sum(threads.values()), {"workers": [*threads], "allow_other_workers": True}


def _is_death(error: BaseException) -> bool:
    """Return whether a task has killed its workers; a scheduler of Dask says so by a KilledWorker.

    An executor whose processes are one pool does not say which task has killed one.
    """
    return isinstance(error, WorkerDiedError) or type(error).__name__ == "KilledWorker"


def _why_not_computed(error: BaseException) -> BaseException:
    """Return the error of a sweep whose worker could not compute."""
    if isinstance(error, SolverError | SceneError | CancelledError | OSError):
        return error
    reason = f"{type(error).__name__}: {error}".splitlines()[0].rstrip(": ")
    if isinstance(error, ImportError):
        return SolverError(
            f"a worker has another ringwear or other libraries, or none ({reason}): install the "
            f"same code and versions on it as here; {RESUME_HINT}"
        )
    if isinstance(error, BrokenExecutor):
        return SolverError(
            f"the executor has lost a worker ({reason}): give it more memory, or give no executor, "
            f"so that blocks that need too much are split; {RESUME_HINT}"
        )
    return SolverError(f"a worker cannot compute ({reason}); {RESUME_HINT}")


class _Gathered:
    """Values of blocks that were split, and the number of their scenes that are still missing."""

    def __init__(self, shapes: Mapping[int, list[int]]) -> None:
        self._shapes = shapes
        self._values, self._missing = dict[int, Values](), dict[int, int]()

    def add(self, piece: Piece, values: Values) -> Values | None:
        """Add the values of a piece; return those of its block if it is complete now."""
        number, sizes, shape = piece.number, piece.sizes, self._shapes[piece.number]
        if prod(sizes) == prod(shape):
            return values
        if number not in self._values:
            self._missing[number] = prod(shape)
            self._values[number] = {
                name: np.empty((*shape, *array.shape[len(sizes) :]), array.dtype)
                for name, array in values.items()
            }
        for name, array in values.items():
            self._values[number][name][piece.box] = array
        self._missing[number] -= prod(sizes)
        return None if self._missing[number] else self._values.pop(number)


def _fits_here(sweep: Sweep) -> bool:
    """Return whether scenes that are solved together need at most `GREATEST_MEMORY_FRACTION`."""
    scene_memory = find_largest(sweep)[1] - LIBRARIES
    scene_count = min(sweep.count, MOST_TOGETHER)
    return LIBRARIES + scene_count * scene_memory <= GREATEST_MEMORY_FRACTION * machine_memory()


def _too_short(seconds: list[float], remaining: int, workers: int) -> bool:
    """Return whether the remaining work is too short to justify starting processes.

    Parameters
    ----------
    seconds : seconds of computing of each block in this process so far
    remaining : number of remaining blocks
    workers : number of processes that would share them
    """
    if not seconds or (len(seconds) == 1 and seconds[0] < LOADING_SECONDS):
        return True
    # blocks may cost more and more, for example if they have more and more rings
    latest = seconds[-LATEST:]
    # n workers save the part 1 - 1 / n of the computing time of one process
    saved = sum(latest) / len(latest) * remaining * (1 - 1 / workers)
    return saved < LEAST_SECONDS_SAVED


def _left_pending(blank: xarray.Dataset, sizes: list[int], available: str) -> Values:
    """Return the values of a scene that kills its workers: empty, pending, and with the reason."""
    values = {
        str(name): np.broadcast_to(variable.values, (*sizes, *variable.shape)).copy()
        for name, variable in blank.data_vars.items()
    }
    values["reason"][...] = f"killed every worker: it seems to need more than {available}"
    values["code"][...] = stamp()
    return values


def worker_memory(workers: int, memory: float | None) -> float:
    """Return the memory in GiB that each process on this machine may use."""
    return (machine_memory() if memory is None else memory) / workers


def _refuse_too_little_memory(workers: int, memory: float | None) -> None:
    """Raise an error if processes would be ended for their memory as soon as they start.

    Raises
    ------
    SceneError
        its message names the memory that is needed
    """
    if memory is not None and worker_memory(workers, memory) < LIBRARIES:
        raise SceneError(
            f"--memory {memory:g} leaves less than the {LIBRARIES} GiB that the libraries of each "
            f"of {workers} workers need: give at least --memory {2 * LIBRARIES * workers:.2g}"
        )
