"""Read the files of saved results, and compare them with their checksums.

A damaged file can crash the netCDF library. It therefore reads only the file that was written.
"""

import json
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from .....meshes.errors import SceneError
from ...problem.written import one_line
from .checksums import CHECKSUMS, RESULTS, SUMMARY, Json, checksums
from .files import read_table
from .folder import COMPLETE, MARKER

if TYPE_CHECKING:
    import xarray


class Unreadable(Exception):
    """Files of results are damaged or do not belong together; the message names the place."""


def refused(path: Path, error: Exception) -> SceneError:
    """Return the SceneError that tells why the results in a folder cannot be read."""
    reason, remedy = one_line(error), "run its scene again, or restore a copy of the folder"
    if isinstance(error, OSError):
        remedy = "give a folder that `ringwear run` has written"
    if isinstance(error, FileNotFoundError):
        reason = f"it has no {Path(str(error.filename)).name}"
    return SceneError(f"{path} cannot be read as results of ringwear: {reason}; {remedy}")


def has_checksums(path: Path) -> bool:
    """Return whether the `summary.json` in a folder can be read and has checksums."""
    with suppress(OSError, ValueError, RecursionError):
        entries = json.loads((path / SUMMARY).read_text("utf-8"))
        return isinstance(entries, dict) and CHECKSUMS in entries
    return False


def read_folder(path: Path) -> tuple["xarray.Dataset", Json]:
    """Return the content of `results.nc`, and of `summary.json` without the checksums.

    Raises
    ------
    SceneError
        if the files are not as they were written; the message names the one that has changed
    """
    try:
        if (path / COMPLETE / MARKER).exists():
            raise Unreadable(
                f"a command was stopped while it put its files in place, and {COMPLETE} has the "
                "rest"
            )
        entries = json.loads((path / SUMMARY).read_text("utf-8"))
        recorded = entries.pop(CHECKSUMS, None) if isinstance(entries, dict) else None
        if not isinstance(recorded, dict) or recorded.keys() != {RESULTS, SUMMARY}:
            raise Unreadable(f"{SUMMARY} has no checksums of both files, as ringwear writes them")
        for name, checksum in checksums(path, entries).items():
            if recorded[name] != checksum:
                raise Unreadable(f"{name} is not as it was written")
        return read_table(path / RESULTS), entries
    # a RecursionError: JSON that is nested too deeply
    except (OSError, ValueError, RecursionError, Unreadable) as error:
        raise refused(path, error) from None
