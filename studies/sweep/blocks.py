"""Compute the blocks of a sweep: here, in processes of this machine, or by another executor."""

import logging
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager
from importlib.util import find_spec
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any

import xarray

from ...meshes import Array, RingwearError, SceneError, SolverError
from ..crosscheck import LOG, computed_with, end_with_parent, signals_wait
from .axes import Sweep
from .compute import compute_block
from .results import FAILED, unsolved

# seconds that processes must save before they are started; that takes about as long
LEAST_SECONDS_SAVED = 4.0
# seconds to wait for an answer of a scheduler of Dask
TIMEOUT = 20.0
# seconds without a finished block after which a warning is logged
PATIENCE = 30.0
RESUME_HINT = "finished blocks are stored: continue with --resume"

Values = dict[str, Array]


def compute_blocks(
    blocks: Mapping[int, Sweep], blank: xarray.Dataset, executor: Executor | None, workers: int
) -> Iterator[tuple[int, Values]]:
    """Yield the number and the results of each block, in the order in which they are finished.

    If the worker of a block is lost, the block is computed once more after all others, alone. If
    its worker is lost again, its scenes have failed.

    Parameters
    ----------
    blocks : the blocks by number
    blank : empty results of one scene
    executor : what computes the blocks; by default processes on this machine
    workers : number of these processes; with one, or if they save little, none is started

    Raises
    ------
    SolverError
        if the executor is lost, or if a worker has other code or versions, or no ringwear
    """
    versions, remaining, start = computed_with(), dict(blocks), time.perf_counter()
    for done, (number, block) in enumerate(blocks.items(), 1):
        if executor is not None:
            break
        values, used = _compute(block, blank)
        _refuse_other_code(used, versions)
        yield number, values
        del remaining[number]
        seconds = (time.perf_counter() - start) / done * len(remaining) * (1 - 1 / workers)
        # the first block also loads libraries
        if done > 1 and seconds > LEAST_SECONDS_SAVED:
            break
    # processes of this machine end as soon as this end of the pipe is closed
    held, watched = get_context("spawn").Pipe()
    count = min(workers, len(remaining))
    places = [executor] * len(remaining) if executor else [_Process(watched) for _ in range(count)]
    try:
        lost = yield from _compute_by(places, remaining, blank, versions)
        again = {number: remaining[number] for number in lost}
        lost = yield from _compute_by(places[:1], again, blank, versions)
    except Exception as error:
        if isinstance(error, RingwearError | OSError):
            raise
        reason = f"{type(error).__name__}: {error}".splitlines()[0].rstrip(": ")
        raise SolverError(
            "the sweep has lost a worker or its scheduler, or a worker has another ringwear or "
            f"none ({reason}); {RESUME_HINT}"
        ) from error
    finally:
        held.close()
    for number, reason in lost.items():
        failed = unsolved(blank, *blocks[number].sizes.values())
        failed["reason"][...], failed["status"][...] = reason, FAILED
        yield number, failed


def _compute(block: Sweep, blank: xarray.Dataset) -> tuple[Values, dict[str, str]]:
    """Return the results of a block, and the code and versions that have computed them."""
    return compute_block(block, blank), computed_with()


def _refuse_other_code(theirs: dict[str, str], ours: dict[str, str]) -> None:
    """Raise an error if a worker has other code or versions than this process."""
    if theirs != ours:
        raise SolverError(
            f"a worker has another ringwear or other libraries, {theirs}, than this process, "
            f"{ours}: install the same versions on it; {RESUME_HINT}"
        )


def _compute_by(
    places: Sequence[Executor],
    blocks: Mapping[int, Sweep],
    blank: xarray.Dataset,
    versions: dict[str, str],
) -> Generator[tuple[int, Values], None, dict[int, str]]:
    """Yield the results of blocks; return the reason of each block whose worker was lost.

    Parameters
    ----------
    places : executors, each of which computes one block at a time
    blocks : the blocks by number
    blank : empty results of one scene
    versions : the code and versions of this process
    """
    free, waiting, lost = list(places), deque(blocks), dict[int, str]()
    running: dict[Future[tuple[Values, dict[str, str]]], tuple[int, Executor]] = {}
    while waiting or running:
        while waiting and free:
            number, place = waiting.popleft(), free.pop()
            running[place.submit(_compute, blocks[number], blank)] = number, place
        finished = wait(running, PATIENCE, FIRST_COMPLETED).done
        if not finished:
            LOG.warning("   sweep  no block has been finished for %.0f s", PATIENCE)
        for future in finished:
            number, place = running.pop(future)
            free.append(place)
            error = future.exception()
            # the error of Dask, which is loaded only if it is used
            if type(error).__name__ == "KilledWorker" or (
                isinstance(error, BrokenExecutor) and isinstance(place, _Process)
            ):
                lost[number] = f"the worker was lost twice, perhaps for lack of memory: {error}"
                continue
            values, used = future.result()
            _refuse_other_code(used, versions)
            yield number, values
    return lost


@contextmanager
def cluster(scheduler: str) -> Iterator[Executor]:
    """Connect to a Dask scheduler; the executor computes on its workers.

    Raises
    ------
    SceneError
        if Dask is not installed
    SolverError
        if the scheduler does not answer or is lost, or if a worker has other code or versions
    """
    if find_spec("distributed") is None:
        raise SceneError(
            "a sweep on a Dask cluster needs dask and distributed: pip install 'ringwear[sweep]'"
        )
    from distributed import Client

    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        with Client(scheduler, timeout=TIMEOUT) as client:
            client.wait_for_workers(1, timeout=TIMEOUT)
            for versions in client.run(computed_with, on_error="return").values():
                _refuse_other_code(versions, computed_with())
            # blocks of equal content are computed again, because a worker may have been lost
            yield client.get_executor(pure=False)
    except (OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
            f"start it with `dask scheduler`, and workers with `dask worker`; {RESUME_HINT}"
        ) from error


class _Process(Executor):
    """A process that computes one task at a time, and is replaced if it is lost.

    Parameters
    ----------
    watched : end of a pipe; if the other end is closed, also because its process has ended, this
        process ends at once
    """

    def __init__(self, watched: Connection) -> None:
        self._arguments = 1, get_context("spawn"), _begin, (watched,)
        self._pool = ProcessPoolExecutor(*self._arguments)

    # the signature of the base class has arguments of any type
    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Compute a task."""
        with signals_wait(), _starting_without_main():
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenExecutor:
                self._pool = ProcessPoolExecutor(*self._arguments)
                return self._pool.submit(fn, *args, **kwargs)


def _begin(watched: Connection) -> None:
    """Ignore Ctrl-C, which the parent handles, and end with the parent."""
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    end_with_parent(watched)


@contextmanager
def _starting_without_main() -> Iterator[None]:
    """Start processes that do not run the script of the user again."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
