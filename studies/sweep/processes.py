"""The default executor of a sweep: processes on this machine, each of which may die.

A pool of `concurrent.futures` is lost as a whole if one of its processes dies, without saying whose
task has killed it. Here each process is a pool of its own.
"""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context, parent_process
from threading import Event, Thread
from types import ModuleType
from typing import Any

import psutil

from ...meshes import SolverError
from ..crosscheck import signals_wait

# seconds between two looks at the memory of the processes
INTERVAL = 0.1


class WorkerDiedError(Exception):
    """The process that computed a task has ended, by itself or because of its memory."""


class Processes(Executor):
    """Processes that compute one task each.

    Parameters
    ----------
    count : number of processes; they start with their first tasks
    memory : memory in bytes above which a process is ended, so that its task fails with a
        `WorkerDiedError`; the next task of that process is computed by a new one
    """

    def __init__(self, count: int, memory: float) -> None:
        self._max_workers, self._memory = count, memory
        self._free = [_Worker() for _ in range(count)]
        self._busy = set[_Worker]()
        self._closed = Event()
        Thread(target=self._watch_memory, daemon=True).start()

    # the signature of the base class has positional arguments of any type
    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Compute a task by a free process; there has to be one.

        Raises
        ------
        SolverError
            if no process can be started
        """
        worker = self._free.pop()
        self._busy.add(worker)
        outer: Future[Any] = Future()

        def finish(inner: "Future[Any]") -> None:
            error = CancelledError() if inner.cancelled() else inner.exception()
            if isinstance(error, BrokenExecutor):
                error = worker.why_broken()
            self._busy.discard(worker)
            self._free.append(worker)
            # last, because the next task may follow at once
            if error is not None:
                outer.set_exception(error)
            else:
                outer.set_result(inner.result())

        worker.submit(fn, args, kwargs).add_done_callback(finish)
        return outer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End all processes at once; their tasks are lost."""
        self._closed.set()
        with signals_wait():
            for worker in (*self._free, *self._busy):
                worker.end()

    def _watch_memory(self) -> None:
        """End processes that use more memory than they may."""
        while not self._closed.wait(INTERVAL):
            for worker in list(self._busy):
                with suppress(psutil.Error):
                    if worker.process and worker.process.memory_info().rss > self._memory:
                        worker.process.kill()


class _Worker:
    """One process, which is started anew if it has died."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        # done as soon as the process has begun to work
        self._started: Future[None] | None = None
        self.process: psutil.Process | None = None

    def submit(
        self, function: Callable[..., Any], args: tuple[Any, ...], keywords: dict[str, Any]
    ) -> "Future[Any]":
        """Compute a task; start the process first if it does not run."""
        if self._pool is None:
            context = get_context("spawn")
            others = active_children()
            self._pool = ProcessPoolExecutor(1, context, _begin)
            try:
                with signals_wait(), _starting_without_main():
                    self._started = self._pool.submit(_nothing)
                    (new,) = (child for child in active_children() if child not in others)
                    with suppress(psutil.Error):
                        self.process = psutil.Process(new.pid)
            except OSError as error:
                raise SolverError(
                    f"no process can be started ({error.strerror or error}): give --workers 1"
                ) from error
        try:
            return self._pool.submit(function, *args, **keywords)
        except BrokenExecutor:
            # it has ended after its last task
            self.why_broken()
            return self.submit(function, args, keywords)

    def why_broken(self) -> Exception:
        """Return the error of a process that has ended, and forget it."""
        started, self._started = self._started, None
        self._pool, self.process = None, None
        if started is not None and started.done() and not started.exception():
            return WorkerDiedError()
        return SolverError("processes end while they start: give --workers 1")

    def end(self) -> None:
        """End the process."""
        if self._pool is not None:
            with suppress(psutil.Error):
                if self.process is not None:
                    self.process.kill()
            # wait for the thread of the pool, which would otherwise still end when Python ends
            self._pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Prepare a process of a sweep.

    Only the process that has started it reacts to Ctrl-C and to the end of the terminal. If that
    ends in any way, this process ends, too.
    """
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _nothing() -> None:
    """Do nothing, as the first task of a process."""


@contextmanager
def _starting_without_main() -> Iterator[None]:
    """Start processes that do not run the user's script once more.

    Python would import it in each new process, where it would begin the sweep again unless the
    script guards against that.
    """
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
