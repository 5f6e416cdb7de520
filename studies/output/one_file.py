"""One file of an output folder, whose failure loses nothing else."""

from collections.abc import Callable
from pathlib import Path

from .signals import STOPPED


def make(path: Path, write: Callable[[Path], object]) -> list[str]:
    """Write a file whose failure is to lose nothing else; return why it failed, if it has.

    Nothing half-written is left.
    """
    try:
        write(path)
    except BaseException as error:
        path.unlink(missing_ok=True)
        if STOPPED.is_set():
            raise KeyboardInterrupt from error
        if not isinstance(error, Exception):
            raise
        reason, *_ = str(error).strip().splitlines() or [type(error).__name__]
        return [f"{path.name} could not be made: {reason}"]
    return []
