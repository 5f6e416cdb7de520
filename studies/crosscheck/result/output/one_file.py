"""Write one file of an output folder so that its failure does not affect the other files."""

from collections.abc import Callable
from pathlib import Path

from .signals import STOPPED


def make(path: Path, write: Callable[[Path], object]) -> list[str]:
    """Write a file; if that fails, remove it and return the reason, else an empty list."""
    try:
        write(path)
    except BaseException as error:
        path.unlink(missing_ok=True)
        if STOPPED.is_set():
            raise KeyboardInterrupt from error
        if not isinstance(error, Exception):
            raise
        reason, *_ = str(error).strip().splitlines() or [type(error).__name__]
        return [f"{path.name} could not be written: {reason}"]
    return []
