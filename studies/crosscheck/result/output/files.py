"""Write the numbers of a run to files, read them, and compare them with their checksums.

Checksums reveal files that were changed, damaged or mixed. A damaged file can crash the netCDF
library. It therefore reads only the file that was written.
"""

import json
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .....meshes.errors import RingwearError, SceneError
from ....tables.writing import json_text, write_csv
from ...problem.unit_names import NO_UNIT
from ...problem.written import one_line
from ...progress import LOG
from .folder import COMPLETE, MARKER
from .table import Table, read_table, write_table

if TYPE_CHECKING:
    import xarray

Json = dict[str, Any]

RESULTS, SUMMARY = "results.nc", "summary.json"
"""Files of saved results: the table, and the summary, which has the checksums of both."""

CHECKSUMS = "checksums"
"""Entry of `summary.json` with the checksums, and attribute of `results.nc` that points to it."""

INSIDE = "half_space.vtu"
# files of a run besides its figures
RUN_FILES = (RESULTS, SUMMARY, "report.html", INSIDE)


def write_numbers(table: Table, entries: Json, directory: Path, csv: bool = False) -> None:
    """Write `results.nc` and `summary.json` of a run, and CSV tables if `csv`.

    Parameters
    ----------
    table : `Result.table`
    entries : `Result.summary`
    """
    LOG.info("  output  writing ...")
    try:
        write_table(table, directory / RESULTS)
    except RuntimeError as error:
        # netCDF raises a RuntimeError if the disk is full
        raise RingwearError(
            f"results.nc could not be written ({error}): is the disk full?"
        ) from error
    recorded = {CHECKSUMS: checksums(directory, entries)}
    summary = json_text(entries | recorded, indent=1)
    (directory / SUMMARY).write_text(summary + "\n", "utf-8")
    _refuse_other_numbers(table, directory)
    if csv:
        write_tables(table.dataset, directory)


def _refuse_other_numbers(table: Table, directory: Path) -> None:
    """Raise if the files that were written have other numbers than the results in memory."""
    if not read_table(directory / RESULTS).equals(table):
        raise RingwearError(f"{RESULTS} was not written correctly: its numbers are not the results")
    answers = json.loads((directory / SUMMARY).read_text("utf-8")).get("answer", {})
    for row, numbers in enumerate(answers.values()):
        for name in numbers.keys() & table.data_vars.keys():
            result = table.data_vars[name].values[row]
            number = np.array(numbers[name], dtype=float)
            if not np.array_equal(number, np.where(np.isfinite(result), result, np.nan), True):
                raise RingwearError(
                    f"{SUMMARY} was not written correctly: {name} is not the result"
                )


def write_tables(dataset: "xarray.Dataset", directory: Path) -> None:
    """Write all variables as CSV: one file for the variables of the same dimensions.

    The file is named after the dimensions, the column headings contain the units, and rows without
    any value are left out.
    """
    units = {name: dataset[name].attrs.get("units", NO_UNIT) for name in dataset.variables}
    heads = {name: f"{name} [{unit}]" for name, unit in units.items() if unit != NO_UNIT}
    for dims in {variable.dims for variable in dataset.values()}:
        names = [name for name in dataset if dataset[name].dims == dims]
        table = dataset[names].to_dataframe().dropna(how="all", subset=names).reset_index()
        if len(table):
            file = "_".join(map(str, dims)) + ".csv"
            write_csv(table.rename(columns=heads), directory / file)


def checksums(directory: Path, entries: Json) -> dict[str, str]:
    """Return the SHA-256 checksums of the table, byte for byte, and of the entries of the summary.

    Parameters
    ----------
    directory : folder with `results.nc`
    entries : content of `summary.json` without its checksums
    """
    text = json_text(entries, sort_keys=True)
    contents = {RESULTS: (directory / RESULTS).read_bytes(), SUMMARY: text.encode()}
    return {name: sha256(content).hexdigest() for name, content in contents.items()}


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


def read_folder(path: Path) -> tuple[Table, Json]:
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
