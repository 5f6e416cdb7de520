"""Do work that may crash in a copy of this process."""

import faulthandler
import os
import select
import signal
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn


def text_from_copy(work: Callable[[], str], seconds: float) -> str | None:
    """Return the text that a function returns in a copy of this process.

    A copy begins at once, whereas a new process would have to load all libraries again. Systems
    that cannot copy a process, such as Windows, do the work in this process.

    Parameters
    ----------
    work : function whose text is short
    seconds : time after which the copy is ended

    Returns
    -------
    text : None if the copy crashes, or if it takes longer
    """
    if not hasattr(os, "fork"):
        return work()
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        # Python warns that other threads do not exist in the copy, which needs none
        warnings.simplefilter("ignore", DeprecationWarning)
        copy = os.fork()
    if copy == 0:
        _write_and_exit(work, writer)
    os.close(writer)
    try:
        with open(reader, "rb") as pipe:
            in_time, _, _ = select.select([pipe], [], [], seconds)
            answer = pipe.read() if in_time else b""
    finally:
        os.kill(copy, signal.SIGKILL)
        os.waitpid(copy, 0)
    return answer.removeprefix(DONE).decode() if answer.startswith(DONE) else None


DONE = b"done:"
"""Beginning of the answer of a copy, which may be empty otherwise."""


def _write_and_exit(work: Callable[[], str], writer: int) -> NoReturn:
    """Write the text of a function, and end this process without any cleaning up."""
    try:
        # a crash is no fault of ringwear: leave neither a message nor a core file
        faulthandler.disable()
        with suppress(ImportError):
            import resource

            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        os.write(writer, DONE + work().encode())
    finally:
        os._exit(0)
