"""Compute blocks of scenes, in this process or by the workers of a Dask cluster.

If a block kills its workers, for example because memory is insufficient, it is split into halves,
repeatedly down to single scenes.
"""

import logging
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray

from ..crosscheck import LOG, Array, SceneError, SolverError
from ..crosscheck.result.output.signals import signals_wait
from ..crosscheck.result.predictions.machine import machine_memory
from ..crosscheck.result.predictions.memory import LIBRARIES
from ..crosscheck.versions import computed_with, stamp
from .axes import Sweep
from .compute import MOST_TOGETHER, compute_block
from .flags import PENDING
from .largest import find_largest

if TYPE_CHECKING:
    from distributed import Client, Future

RESUME_HINT = "finished blocks are stored: continue with --resume"
# number of workers on this machine that a block has to kill before it is split; a single death may
# have another cause
DEATHS_BEFORE_SPLIT = 2
# seconds of computing that workers on this machine have to save, or else they are not started: they
# take about as long to start and to load libraries
LEAST_SECONDS_SAVED = 4.0
# a first block that took less than these seconds may consist mainly of loading libraries; a second
# one is then computed here before the time of blocks is estimated
LOADING_SECONDS = 2.0
# fraction of the machine's memory that the scenes of a block may use in this process, because
# no other process would restart this one if it ran out of memory
GREATEST_MEMORY_FRACTION = 0.5
# seconds to wait for an answer of the scheduler, and for its first worker
SCHEDULER_TIMEOUT = 20.0


class Piece(NamedTuple):
    """A box of the scenes of a block.

    Parameters
    ----------
    number : number of the block
    box : slice of the block along each dimension
    """

    number: int
    box: tuple[slice, ...]

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
    blocks: dict[int, Sweep],
    blank: xarray.Dataset,
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> Iterator[tuple[int, dict[str, Array]]]:
    """Yield the number of each block of a sweep, and its values as returned by `compute_block`.

    If a worker dies, Dask starts a new one and gives the block to another worker. If it kills that
    worker, too, the block is split into halves (on a cluster, after as many deaths as its scheduler
    allows). A single scene that kills its workers stays
    pending, with the reason.

    One worker without a memory limit is this process itself. With several workers, this process
    also computes small blocks if the remaining work is too short to justify starting workers.

    Parameters
    ----------
    blocks : blocks to compute, each as a sweep, by number
    blank : empty results of one scene (`template.one_scene`)
    workers : number of processes on this machine
    scheduler : address of a Dask scheduler; None for processes on this machine
    memory : memory in GiB that all processes on this machine may use; if None, they may use all
        memory of the machine

    Raises
    ------
    SceneError
        if `memory` is less than the libraries of the workers need
    SolverError
        if the scheduler is lost, if it has no workers, or if a worker has other code or versions or
        no ringwear; the blocks of such a worker are not yielded
    """
    workers = min(workers, len(blocks))
    if scheduler is None and memory is None:
        remaining, seconds = dict(blocks), list[float]()
        for number, block in blocks.items():
            if workers > 1 and not (
                _fits_here(block) and _too_short(seconds, len(remaining), workers)
            ):
                break
            began = time.process_time()
            values = compute_block(remaining.pop(number), blank)
            seconds.append(time.process_time() - began)
            if (values["code"] != stamp()).any():
                raise SolverError(
                    f"files of ringwear were edited before this process loaded them; {RESUME_HINT}"
                )
            yield number, values
        blocks = remaining
    if not blocks:
        return
    workers = min(workers, len(blocks))
    if scheduler is None:
        _refuse_too_little_memory(workers, memory)
    shapes = {number: block.sizes.values() for number, block in blocks.items()}
    waiting = deque(
        Piece(number, tuple(slice(0, size) for size in sizes)) for number, sizes in shapes.items()
    )
    running: dict[Future, Piece] = {}
    checked_workers = set[str]()
    # values of blocks that were split, and the number of their scenes that are still missing
    gathered, missing = dict[int, dict[str, Array]](), dict[int, int]()
    with connect(scheduler, workers, memory) as client:
        from distributed import KilledWorker, wait

        while True:
            # each thread has at most one block: a waiting block would die with the worker
            threads = client.nthreads()
            if set(threads) - checked_workers:
                _check_workers(client)
                checked_workers |= set(threads)
            thread_count = max(1, sum(threads.values()))
            while waiting and len(running) < thread_count:
                piece = waiting.popleft()
                block = blocks[piece.number]
                scenes = block.part(dict(zip(block.sizes, piece.box, strict=True)))
                running[client.submit(compute_block, scenes, blank, pure=False)] = piece
            if not running:
                return
            try:
                finished = wait(list(running), 30, "FIRST_COMPLETED").done
            except TimeoutError:
                LOG.warning("   sweep  no results for 30 s from %d workers", len(client.nthreads()))
                continue
            for future in finished:
                piece = running.pop(future)
                number, sizes = piece.number, piece.sizes
                error = future.exception() if future.status == "error" else None
                if isinstance(error, KilledWorker) and prod(sizes) > 1:
                    LOG.info("   sweep  %d scenes kill their workers: they are split", prod(sizes))
                    waiting.extendleft(reversed(piece.halves()))
                    continue
                if isinstance(error, KilledWorker):
                    values = _left_pending(blank, sizes, workers, scheduler, memory)
                elif error:
                    reason = f"{type(error).__name__}: {error}".splitlines()[0]
                    raise SolverError(
                        f"a worker cannot compute ({reason}); {RESUME_HINT}"
                    ) from error
                else:
                    values = future.result()
                    if (values["code"] != stamp()).any():
                        raise SolverError(
                            "a worker has another ringwear or other libraries than this process, "
                            "and its results are discarded: install the same code and versions on "
                            f"it; {RESUME_HINT}"
                        )
                if prod(sizes) < prod(shapes[number]):
                    missing.setdefault(number, prod(shapes[number]))
                    block_values = gathered.setdefault(
                        number,
                        {
                            name: np.empty(
                                (*shapes[number], *array.shape[len(sizes) :]), array.dtype
                            )
                            for name, array in values.items()
                        },
                    )
                    for name, array in values.items():
                        block_values[name][piece.box] = array
                    missing[number] -= prod(sizes)
                    if missing[number]:
                        continue
                    values = gathered.pop(number)
                if pending := int((values["status"] == PENDING).sum()):
                    LOG.warning("   sweep  %d scenes kill every worker: left out", pending)
                yield number, values


def _fits_here(block: Sweep) -> bool:
    """Return whether the scenes of a block fit into `GREATEST_MEMORY_FRACTION` of the memory."""
    scene_memory = find_largest(block)[1] - LIBRARIES
    scene_count = min(block.count, MOST_TOGETHER)
    return LIBRARIES + scene_count * scene_memory <= GREATEST_MEMORY_FRACTION * machine_memory()


def _too_short(seconds: list[float], remaining: int, workers: int) -> bool:
    """Return whether the remaining work is too short to justify starting workers.

    Parameters
    ----------
    seconds : seconds of computing of each block in this process so far
    remaining : number of remaining blocks
    workers : number of workers that would share them
    """
    if not seconds or (len(seconds) == 1 and seconds[0] < LOADING_SECONDS):
        return True
    # n workers save the part 1 - 1 / n of the computing time of one process
    return min(seconds) * remaining * (1 - 1 / workers) < LEAST_SECONDS_SAVED


def _left_pending(
    blank: xarray.Dataset,
    sizes: list[int],
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> dict[str, Array]:
    """Return the values of a scene that kills its workers: empty, pending, and with the reason."""
    values = {
        str(name): np.broadcast_to(variable.values, (*sizes, *variable.shape)).copy()
        for name, variable in blank.data_vars.items()
    }
    available = "the memory of its workers"
    if scheduler is None:
        available = f"{worker_memory(workers, memory):.3g} GiB, the share of --memory of one worker"
    values["reason"][...] = f"killed every worker: it seems to need more than {available}"
    values["code"][...] = stamp()
    return values


def worker_memory(workers: int, memory: float | None) -> float:
    """Return the memory in GiB that each process on this machine may use."""
    return (machine_memory() if memory is None else memory) / workers


def _refuse_too_little_memory(workers: int, memory: float | None) -> None:
    """Raise an error if workers would be ended for their memory as soon as they start.

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


def _check_workers(client: "Client") -> None:
    """Raise an error if a worker has other code or versions of ringwear, or no ringwear.

    Raises
    ------
    SolverError
        its message names the worker and both versions
    """
    for worker, versions_of_worker in client.run(computed_with, on_error="return").items():
        if versions_of_worker != computed_with():
            raise SolverError(
                f"{worker} has another ringwear or other libraries, {versions_of_worker}, than "
                f"this process, {computed_with()}: install the same code and versions on it; "
                f"{RESUME_HINT}"
            )


@contextmanager
def connect(scheduler: str | None, workers: int, memory: float | None) -> Iterator["Client"]:
    """Connect to a Dask scheduler, or start a number of processes on this machine.

    A process that uses more than its share of the memory is ended and started again.

    Parameters
    ----------
    scheduler : address of a Dask scheduler; None to start processes
    workers : number of processes to start
    memory : memory in GiB that all these processes may use; None for all memory of the machine

    Raises
    ------
    SolverError
        if the scheduler does not answer, has no workers or is lost
    """
    # signals wait, because Dask would leave processes behind if it were interrupted while it is
    # loaded or starts them
    with signals_wait():
        import dask
        from distributed import Client

    client: Client | None = None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    # workers return results at once, so that spilling data or pausing would not free memory
    limits: dict[str, object] = {
        f"distributed.worker.memory.{action}": False for action in ("target", "spill", "pause")
    }
    limits["distributed.scheduler.allowed-failures"] = DEATHS_BEFORE_SPLIT - 1
    processes: dict[str, object] = {
        "n_workers": workers,
        "threads_per_worker": 1,
        "memory_limit": int(worker_memory(workers, memory) * 2**30),
        "dashboard_address": ":0",
        "silence_logs": logging.CRITICAL,
        # only this process reacts to Ctrl-C and to the end of the terminal
        "preload": [
            "import signal\n"
            "for name in ('SIGINT', 'SIGHUP'):\n"
            "    if hasattr(signal, name):\n"
            "        signal.signal(getattr(signal, name), signal.SIG_IGN)"
        ],
    }
    try:
        with dask.config.set(limits):
            with signals_wait():
                client = Client(
                    scheduler, timeout=SCHEDULER_TIMEOUT, **({} if scheduler else processes)
                )
                client.wait_for_workers(1, timeout=SCHEDULER_TIMEOUT)
            yield client
    except (CancelledError, OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
            f"start it with `dask scheduler`, and workers with `dask worker`; {RESUME_HINT}"
        ) from error
    finally:
        if client is not None:
            with signals_wait():
                client.close()
