"""Files made one by one, in two processes where the system can fork, so that no failure of one
loses another.
"""

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..progress import STOPPED


class Job(NamedTuple):
    """A file by its name, and what writes it to a path."""

    name: str
    write: Callable[[Path], object]


def make(jobs: Sequence[Job], others: Sequence[Job], directory: Path) -> list[str]:
    """Write both lists of files, at the same time where there is a second core.

    Returns what failed, with the reason.
    """
    if not (jobs and others) or not _can_fork():
        return _make([*jobs, *others], directory)
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_make_and_tell, args=(others, directory, sender), daemon=True)
    child.start()
    sender.close()
    try:
        failures = _make(jobs, directory)
        try:
            reported = receiver.recv()
        except EOFError:
            reported = [
                f"{', '.join(job.name for job in others)}: the process that made them was killed"
            ]
    finally:
        child.terminate()
        child.join()
    return [*failures, *reported]


def _can_fork() -> bool:
    return "fork" in multiprocessing.get_all_start_methods() and len(os.sched_getaffinity(0)) > 1


def _make(jobs: Sequence[Job], directory: Path) -> list[str]:
    failures = []
    for job in jobs:
        path = directory / job.name
        try:
            job.write(path)
        except BaseException as error:
            # nothing half-written is left; and of a failure, nothing else is lost for it
            path.unlink(missing_ok=True)
            if not isinstance(error, Exception):
                raise
            if STOPPED.is_set():
                raise KeyboardInterrupt from error
            lines = str(error).strip().splitlines() or [type(error).__name__]
            failures.append(f"{job.name} could not be made: {lines[0]}")
    return failures


def _make_and_tell(jobs: Sequence[Job], directory: Path, sender: Any) -> None:
    # Ctrl-C is for the process that has started this one, and ends it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sender.send(_make(jobs, directory))
