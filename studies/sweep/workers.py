"""Compute blocks of scenes, in this process or by the workers of a Dask cluster.

A block that ends its workers, as for lack of memory, is split, down to single scenes.
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

from ...meshes.errors import SolverError
from ...meshes.radial import Array
from ..output.signals import signals_wait
from ..predictions.memory import LIBRARIES, machine_memory
from ..progress import LOG
from ..versions import computed_with, stamp
from .axes import Sweep
from .compute import MOST_TOGETHER, compute_block
from .cost import find_largest
from .store import PENDING

if TYPE_CHECKING:
    from distributed import Client, Future

RESUME = "what is finished is there: go on with --resume"
# deaths of workers of this machine by which a block is split: one may have another cause
DEATHS = 2
# seconds of computing that workers of this machine have to spare this process to be started: they
# take about as long to start and to load libraries
LEAST_GAIN = 4.0
# seconds that a first block may take to load libraries, so that another one is to tell how long
# blocks take
LOADING = 2.0
# part of the machine's memory that the scenes of a block may take in this process, which no other
# one protects from running out of it
MOST_HERE = 0.5
# seconds that a scheduler may take to answer, and its first worker to come
MOST_SILENCE = 20.0


class Piece(NamedTuple):
    """A box of the scenes of a block.

    Parameters
    ----------
    number : of the block
    box : a slice of each of its dimensions
    """

    number: int
    box: tuple[slice, ...]

    @property
    def sizes(self) -> list[int]:
        """Number of scenes along each dimension of the box."""
        return [part.stop - part.start for part in self.box]

    def halves(self) -> "tuple[Piece, Piece]":
        """Return both halves along the longest dimension."""
        along = int(np.argmax(self.sizes))
        part, (before, after) = self.box[along], (self.box[:along], self.box[along + 1 :])
        middle = (part.start + part.stop) // 2
        return (
            Piece(self.number, (*before, slice(part.start, middle), *after)),
            Piece(self.number, (*before, slice(middle, part.stop), *after)),
        )


def compute_blocks(
    blocks: dict[int, Sweep],
    blank: xarray.Dataset,
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> Iterator[tuple[int, dict[str, Array]]]:
    """Yield blocks of a sweep by number, and their values as `compute_block` gives them.

    Dask gives what a lost worker had to another, and starts a new one. What is lost again is split
    in halves. A single scene that ends its workers stays pending, with the reason. One worker of
    any memory is this process itself, which also computes small blocks as long as too little is
    left for more workers to be worth their start.

    Raises
    ------
    SolverError
        if the scheduler is lost, has no workers, or has one with another ringwear or none, whose
        blocks are not yielded
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
                raise SolverError(f"this process has loaded files that were edited; {RESUME}")
            yield number, values
        blocks = remaining
    if not blocks:
        return
    workers = min(workers, len(blocks))
    whole = {number: block.sizes.values() for number, block in blocks.items()}
    waiting = deque(
        Piece(number, tuple(slice(0, size) for size in sizes)) for number, sizes in whole.items()
    )
    running: dict[Future, Piece] = {}
    checked = set[str]()
    gathered, missing = dict[int, dict[str, Array]](), dict[int, int]()
    with connect(scheduler, workers, memory) as client:
        from distributed import KilledWorker, wait

        while True:
            # none waits behind another, with which its worker might die
            threads = client.nthreads()
            if set(threads) - checked:
                _check_workers(client)
                checked |= set(threads)
            window = max(1, sum(threads.values()))
            while waiting and len(running) < window:
                piece = waiting.popleft()
                block = blocks[piece.number]
                part = block.part(dict(zip(block.sizes, piece.box, strict=True)))
                running[client.submit(compute_block, part, blank, pure=False)] = piece
            if not running:
                return
            try:
                finished = wait(list(running), 30, "FIRST_COMPLETED").done
            except TimeoutError:
                LOG.warning("   sweep  nothing for 30 s from %d workers", len(client.nthreads()))
                continue
            for future in finished:
                piece = running.pop(future)
                number, sizes = piece.number, piece.sizes
                error = future.exception() if future.status == "error" else None
                if isinstance(error, KilledWorker) and prod(sizes) > 1:
                    LOG.info("   sweep  %d scenes end their workers: split", prod(sizes))
                    waiting.extendleft(reversed(piece.halves()))
                    continue
                if isinstance(error, KilledWorker):
                    values = _left_pending(blank, sizes, workers, scheduler, memory)
                elif error:
                    reason = f"{type(error).__name__}: {error}".splitlines()[0]
                    raise SolverError(f"a worker cannot compute ({reason}); {RESUME}") from error
                else:
                    values = future.result()
                    if (values["code"] != stamp()).any():
                        raise SolverError(
                            "a worker has another ringwear or other libraries than are here, and "
                            f"what it has computed is not kept: install the same on it; {RESUME}"
                        )
                if prod(sizes) < prod(whole[number]):
                    missing.setdefault(number, prod(whole[number]))
                    total = gathered.setdefault(
                        number,
                        {
                            name: np.empty((*whole[number], *of.shape[len(sizes) :]), of.dtype)
                            for name, of in values.items()
                        },
                    )
                    for name, of in values.items():
                        total[name][piece.box] = of
                    missing[number] -= prod(sizes)
                    if missing[number]:
                        continue
                    values = gathered.pop(number)
                if left := int((values["status"] == PENDING).sum()):
                    LOG.warning("   sweep  %d scenes end worker after worker: left out", left)
                yield number, values


def _fits_here(block: Sweep) -> bool:
    """Return whether this process has far more memory than the scenes of a block need."""
    of_scene = find_largest(block)[1] - LIBRARIES
    together = min(block.count, MOST_TOGETHER)
    return LIBRARIES + together * of_scene <= MOST_HERE * machine_memory()


def _too_short(seconds: list[float], left: int, workers: int) -> bool:
    """Return whether workers would not be worth their start.

    Parameters
    ----------
    seconds : of computing that each block has taken in this process
    left : number of blocks that are left
    workers : how many would share them
    """
    if not seconds or (len(seconds) == 1 and seconds[0] < LOADING):
        return True
    # one of the workers could be this process
    return min(seconds) * left * (1 - 1 / workers) < LEAST_GAIN


def _left_pending(
    blank: xarray.Dataset,
    sizes: list[int],
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> dict[str, Array]:
    """Return the values of a scene that ends its workers."""
    values = {
        str(name): np.broadcast_to(of.values, (*sizes, *of.shape)).copy()
        for name, of in blank.data_vars.items()
    }
    had = "the memory that its workers have"
    if scheduler is None:
        had = f"{worker_memory(workers, memory):.3g} GiB, the part of --memory of a worker"
    values["reason"][...] = f"ended worker after worker: it seems to need more than {had}"
    values["code"][...] = stamp()
    return values


def worker_memory(workers: int, memory: float | None) -> float:
    """Return the GiB that each process of this machine may take."""
    return (machine_memory() if memory is None else memory) / workers


def _check_workers(client: "Client") -> None:
    """Refuse workers with another ringwear, or none, before they are given anything."""
    for worker, reply in client.run(computed_with, on_error="return").items():
        if reply != computed_with():
            raise SolverError(
                f"{worker} has another ringwear or other libraries, {reply}; here are "
                f"{computed_with()}:"
                f" install the same on it; {RESUME}"
            )


@contextmanager
def connect(scheduler: str | None, workers: int, memory: float | None) -> Iterator["Client"]:
    """Connect to a Dask scheduler, or to so many processes of this machine.

    Processes that take more than their part of the memory (GiB; by default of the machine's) are
    ended, and started anew.
    """
    # a library that is stopped while it is loaded or starts processes leaves some of them
    with signals_wait():
        import dask
        from distributed import Client

    client: Client | None = None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    # results leave at once: there is nothing to spill, nor to wait for
    limits: dict[str, object] = {
        f"distributed.worker.memory.{at}": False for at in ("target", "spill", "pause")
    }
    limits["distributed.scheduler.allowed-failures"] = DEATHS - 1
    processes: dict[str, object] = {
        "n_workers": workers,
        "threads_per_worker": 1,
        "memory_limit": int(worker_memory(workers, memory) * 2**30),
        "dashboard_address": ":0",
        "silence_logs": logging.CRITICAL,
        # Ctrl-C is the affair of this process
        "preload": ["import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)"],
    }
    try:
        with dask.config.set(limits):
            with signals_wait():
                client = Client(scheduler, timeout=MOST_SILENCE, **({} if scheduler else processes))
                client.wait_for_workers(1, timeout=MOST_SILENCE)
            yield client
    except (CancelledError, OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
            f"start it by `dask scheduler`, and some `dask worker`; {RESUME}"
        ) from error
    finally:
        if client is not None:
            with signals_wait():
                client.close()
