"""Use the other cores: copies of this process do parts of its work."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from .signals import signals_wait

Works = tuple[Callable[[], Any], ...]
Apart = Callable[..., Works]

# thread that only waits for the end of the parent, so that its process may have copies
WATCHER = "watcher"


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

    threading.Thread(target=watch, name=WATCHER, daemon=True).start()


def here(*works: Callable[[], Any]) -> Works:
    """Return works as they are: each is done in this process, when its result is asked for."""
    return works


@contextmanager
def copies(wanted: bool = True) -> Iterator[Apart]:
    """Yield a function that begins works, one after the other, in a copy of this process.

    It returns a function for each work, which returns its result; they are called in this order,
    each once. Results have to be picklable. If a work fails in the copy, or the copy is lost, it is
    done in this process, so that its errors are raised here. If copies are not wanted or not
    possible, this holds for all works (`here`). The copies are ended after the `with` block.
    """
    # a fork copies no other threads, and breaks the frameworks of macOS
    forks = hasattr(os, "fork") and sys.platform != "darwin"
    if not (wanted and forks and cores() > 1):
        yield here
        return
    processes = list[BaseProcess]()

    def apart(*works: Callable[[], Any]) -> Works:
        if any(thread.name not in (WATCHER, "MainThread") for thread in threading.enumerate()):
            return here(*works)
        ours, theirs = Pipe()

        def send() -> None:
            # a signal to both processes ends this one by the other
            with signals_wait():
                ours.close()
                end_with_parent(theirs)
                try:
                    for work in works:
                        theirs.send(work())
                finally:
                    os._exit(0)

        def result(work: Callable[[], Any]) -> Any:
            try:
                return ours.recv()
            # nothing, or a part of the result
            except (EOFError, OSError):
                return work()

        # a signal between the fork and its record would leave the process behind
        with signals_wait():
            process = get_context("fork").Process(target=send)
            process.start()
            processes.append(process)
        theirs.close()
        return tuple(partial(result, work) for work in works)

    try:
        yield apart
    finally:
        for process in processes:
            process.kill()
            process.join()
