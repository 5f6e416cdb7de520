"""Write JSON, and tables as CSV without spreadsheet formulas; keep rows of stopped studies."""

import json
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pandas import DataFrame

Row = Mapping[str, Any]
# what conclusions of a study say if it was stopped
INTERRUPTED = "INTERRUPTED: tables and figures hold the rows that were finished."
# first characters of a text that spreadsheets evaluate as a formula
FORMULA = ("=", "+", "-", "@", "\t", "\r")
# a signed number, with or without a unit, is no formula
NUMBER = re.compile(r"[-+][\d.]+(e[-+]?\d+)?( [\w%/^³]+)?")


def as_json(value: Any) -> Any:
    """Return a value that JSON can express: None in place of numbers that are not finite."""
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: as_json(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(each) for each in value]
    if hasattr(value, "tolist"):  # an array or a number of numpy
        return as_json(value.tolist())
    return value


def json_text(value: object, **layout: Any) -> str:
    """Return a value as the text of `as_json`; all JSON is written by this function.

    Parameters
    ----------
    layout : arguments of `json.dumps`
    """
    return json.dumps(as_json(value), allow_nan=False, **layout)


def write_csv(table: "DataFrame", path: Path) -> None:
    """Write a table as CSV, so that spreadsheets evaluate none of its texts as a formula."""
    without_formulas(table).to_csv(path, index=False)


def without_formulas(table: "DataFrame") -> "DataFrame":
    """Return a table with an apostrophe before each text that spreadsheets would evaluate."""
    return table.rename(columns=_as_text).map(_as_text)


def _as_text(cell: object) -> object:
    if isinstance(cell, str) and cell.startswith(FORMULA) and not NUMBER.fullmatch(cell):
        return f"'{cell}"
    return cell


@contextmanager
def keeping_rows(conclusions: list[str]) -> Iterator[None]:
    """End the `with` block, but not the study, at Ctrl-C.

    The study still writes tables and figures of the finished rows; a conclusion says that it was
    interrupted.
    """
    try:
        yield
    except KeyboardInterrupt:
        conclusions.append(INTERRUPTED)


def keep_tables(directory: Path) -> None:
    """Remove all files except the tables of a study that was interrupted.

    Tables are complete after every row, but other files may be incomplete. Files whose names begin
    with a dot are kept.

    Raises
    ------
    KeyboardInterrupt
        if the tables have no rows
    """
    tables = set(directory.glob("*.csv"))
    for file in set(directory.iterdir()) - tables:
        if not file.name.startswith("."):
            file.unlink()
    if not any(len(table.read_text("utf-8").splitlines()) > 1 for table in tables):
        raise KeyboardInterrupt
