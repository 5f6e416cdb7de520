"""Handle Ctrl-C (SIGINT), SIGTERM, by which batch systems end jobs, and SIGHUP.

A terminal that is closed sends SIGHUP, which Windows does not have.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

STOPPED = threading.Event()
"""Set after a signal: a library may have caught the KeyboardInterrupt as an error of its own."""


@contextmanager
def ending_on_signals() -> Iterator[None]:
    """Raise a KeyboardInterrupt at each of these signals, which ends the work."""

    def stop(*_: object) -> None:
        STOPPED.set()
        raise KeyboardInterrupt

    STOPPED.clear()
    with _handled_by(stop):
        yield


@contextmanager
def signals_wait() -> Iterator[None]:
    """Hold signals back until the end of the `with` block, in which files are moved."""
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
    numbers = [signal.SIGINT, signal.SIGTERM]
    # `nohup` lets a job ignore the end of its terminal
    end_of_terminal = getattr(signal, "SIGHUP", None)
    if end_of_terminal and signal.getsignal(end_of_terminal) is not signal.SIG_IGN:
        numbers.append(end_of_terminal)
    earlier_handlers = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, earlier_handler in earlier_handlers.items():
            signal.signal(number, earlier_handler)
