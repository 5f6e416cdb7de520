"""Use a second core: a copy of this process does a part of the work."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from .signals import signals_wait

Value = TypeVar("Value")


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def end_with_parent(watched: Connection) -> None:
    """End this process as soon as the other end of a pipe is closed, also by the parent's end."""

    def watch() -> None:
        with suppress(OSError):
            watched.poll(None)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def done_apart(work: Callable[[], Value], wanted: bool = True) -> Iterator[Callable[[], Value]]:
    """Run some work in a copy of this process, beside that of the `with` block.

    It yields a function that returns the result, which has to be picklable. If a copy is not
    wanted or not possible, the work is done first; if the work fails in the copy, or the copy is
    lost, it is done again when the result is asked for, so that its errors are raised here.
    """
    # a fork copies no other threads, and breaks the frameworks of macOS
    forks = hasattr(os, "fork") and sys.platform != "darwin"
    if not (wanted and forks and cores() > 1 and threading.active_count() == 1):
        done = work()
        yield lambda: done
        return
    ours, theirs = Pipe()

    def send() -> None:
        # a signal to both processes ends this one by the other
        with signals_wait():
            ours.close()
            end_with_parent(theirs)
            try:
                theirs.send(work())
            finally:
                os._exit(0)

    def result() -> Any:
        try:
            return ours.recv()
        # nothing, or a part of the result
        except (EOFError, OSError):
            return work()

    process = get_context("fork").Process(target=send)
    try:
        # a signal between the fork and its record would leave the process behind
        with signals_wait():
            process.start()
        theirs.close()
        yield result
    finally:
        if process.pid:
            process.kill()
            process.join()
