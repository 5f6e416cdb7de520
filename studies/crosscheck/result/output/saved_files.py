"""Read the files of saved results, and compare them with their checksums.

A damaged file can crash the netCDF library, and with it the process. If `results.nc` is not byte
for byte the file that was written, a copy of this process reads it first.
"""

import json
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .....meshes.errors import SceneError
from ...problem.written import one_line
from .checksums import CHECKSUMS, FILE, Json, digest_of_file, first_mismatch
from .folder import COMPLETE, MARKER
from .netcdf import RESULTS, SUMMARY, read_netcdf
from .other_process import text_from_copy

if TYPE_CHECKING:
    import xarray

LONGEST_EXAMINATION = 120.0
"""Seconds after which a file that a copy of this process reads counts as damaged."""


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


def read_folder(path: Path) -> tuple["xarray.Dataset", Json, bool]:
    """Read the files of results, and compare them with their checksums.

    Returns
    -------
    dataset : content of `results.nc`
    entries : content of `summary.json` without the checksums
    has_checksums : whether the files have checksums

    Raises
    ------
    SceneError
        if the files cannot be read or do not match their checksums; the message names what does
        not match, and the remedy
    """
    try:
        if (path / COMPLETE / MARKER).exists():
            raise Unreadable(
                f"a command was stopped while it put its files in place, and {COMPLETE} has the "
                "rest"
            )
        entries = _read_summary(path)
        if not _is_as_written(path / RESULTS, entries.get(CHECKSUMS)):
            fault = text_from_copy(partial(_fault, path, entries), LONGEST_EXAMINATION)
            if fault is None:
                raise Unreadable(f"{RESULTS} is damaged, so that the netCDF library cannot read it")
            if fault:
                raise Unreadable(fault)
        return _read_both(path, entries)
    # a RecursionError: JSON that is nested too deeply
    except (OSError, ValueError, RecursionError, Unreadable) as error:
        raise refused(path, error) from None


def _read_summary(path: Path) -> Json:
    entries = json.loads((path / SUMMARY).read_text("utf-8"))
    if not isinstance(entries, dict):
        raise Unreadable(f"{SUMMARY} has no entries")
    return entries


def _read_both(path: Path, entries: Json) -> tuple["xarray.Dataset", Json, bool]:
    """Return dataset, entries without checksums, and whether there are any, if they match."""
    dataset = read_netcdf(path / RESULTS)
    expected = dataset.attrs.pop(CHECKSUMS, None)
    others = {name: value for name, value in entries.items() if name != CHECKSUMS}
    if CHECKSUMS in entries:
        if reason := first_mismatch(entries[CHECKSUMS], dataset, others):
            raise Unreadable(reason)
    elif expected is not None:
        raise Unreadable(f"{SUMMARY} has no checksums of {RESULTS}")
    return dataset, others, CHECKSUMS in entries


def _is_as_written(path: Path, recorded: object) -> bool:
    """Return whether a file has the recorded digest; False if none is recorded."""
    return isinstance(recorded, dict) and recorded.get(FILE) == digest_of_file(path)


def _fault(path: Path, entries: Json) -> str:
    """Return what is wrong with the files of results; empty if nothing is."""
    try:
        _read_both(path, entries)
    except (OSError, ValueError, RecursionError, Unreadable) as error:
        return one_line(error)
    return ""
