"""Tables of studies: on disk row by row, as CSV."""

import csv
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .registry import INTERRUPTED

Row = Mapping[str, Any]


class Table:
    """Rows that are on disk as CSV as soon as they are known.

    Columns that a row does not name stay empty.
    """

    def __init__(self, path: Path, fields: Iterable[str], rows: Iterable[Row] = ()) -> None:
        self.path, self.fields = path, tuple(fields)
        self.rows: list[Row] = []
        self._append("w", self.fields)
        for row in rows:
            self.add(**row)

    def add(self, **row: Any) -> None:
        """Add a row: values by the names of their columns."""
        self.rows.append(row)
        self._append("a", (row.get(name, "") for name in self.fields))

    def _append(self, mode: str, values: Iterable[Any]) -> None:
        with self.path.open(mode, newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerow(list(values))


@contextmanager
def keeping_rows(conclusions: list[str]) -> Iterator[None]:
    """Ctrl-C ends the computing, not the study.

    What is finished is still tabulated, drawn and named incomplete.
    """
    try:
        yield
    except KeyboardInterrupt:
        conclusions.append(INTERRUPTED)


def keep_tables(directory: Path) -> None:
    """Remove what may be half there of a study that was stopped between its rows: tables are whole
    after every row.

    Raises
    ------
    KeyboardInterrupt
        if there are no rows either
    """
    tables = set(directory.glob("*.csv"))
    for file in set(directory.iterdir()) - tables:
        file.unlink()
    if not any(len(table.read_text("utf-8").splitlines()) > 1 for table in tables):
        raise KeyboardInterrupt
