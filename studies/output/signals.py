"""Ctrl-C, and SIGTERM, by which a batch system ends a job."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

STOPPED = threading.Event()
"""Set when the work is to end: a library may take the exception for a failure of its own."""


@contextmanager
def ending_on_signals() -> Iterator[None]:
    """Turn either signal into a KeyboardInterrupt, which ends the work."""

    def stop(*_: object) -> None:
        STOPPED.set()
        raise KeyboardInterrupt

    STOPPED.clear()
    with _handled_by(stop):
        yield


@contextmanager
def signals_wait() -> Iterator[None]:
    """Hold signals back until files are in place."""
    waiting: list[int] = []
    try:
        with _handled_by(lambda number, _: waiting.append(number)):
            yield
    finally:
        for number in waiting[:1]:
            signal.raise_signal(number)


@contextmanager
def _handled_by(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)
