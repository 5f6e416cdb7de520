"""Tables as files: cells are no formulas, and of studies that were stopped rows are kept."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .registry import INTERRUPTED

if TYPE_CHECKING:
    from pandas import DataFrame

Row = Mapping[str, Any]
# beginnings of a text that spreadsheets compute
FORMULA = ("=", "+", "-", "@", "\t", "\r")
# a signed number, with a unit or without, is harmless
NUMBER = re.compile(r"[-+][\d.]+(e[-+]?\d+)?( [\w%/^³]+)?")


def write_csv(table: "DataFrame", path: Path) -> None:
    """Write a table as CSV, whose texts no spreadsheet computes."""
    without_formulas(table).to_csv(path, index=False)


def without_formulas(table: "DataFrame") -> "DataFrame":
    """Return a table with an apostrophe before each text that spreadsheets would compute."""
    return table.rename(columns=_as_text).map(_as_text)


def _as_text(cell: object) -> object:
    if isinstance(cell, str) and cell.startswith(FORMULA) and not NUMBER.fullmatch(cell):
        return f"'{cell}"
    return cell


@contextmanager
def keeping_rows(conclusions: list[str]) -> Iterator[None]:
    """Stop the computing, not the study, at Ctrl-C.

    What is finished is still tabulated, drawn and named incomplete.
    """
    try:
        yield
    except KeyboardInterrupt:
        conclusions.append(INTERRUPTED)


def keep_tables(directory: Path) -> None:
    """Remove all files but the tables of a study that was stopped between its rows.

    Other files may be incomplete, but tables are complete after every row. Files whose names begin
    with a dot stay.

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
