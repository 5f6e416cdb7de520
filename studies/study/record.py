"""The rows of a study: written to a file as soon as a level is solved, and continued later.

A study that is stopped keeps the rows of the levels that were solved. When it is resumed, these
levels are not solved again, unless a later level needs their solutions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from ..tables.writing import without_formulas

COLUMNS = (
    *("case", "way", "method", "level", "size", "unknowns", "seconds", "quantity", "when"),
    *("error", "estimate", "tolerance", "index", "limit", "reference", "computed", "parameter"),
    *("refined", "least seconds", "greatest seconds", "outcome", "message"),
)
"""Columns of every table of levels; `studies/study/README.md` explains them."""
SOLVED, REFUSED, CRASHED = "solved", "refused", "crashed"
"""Values of the column `outcome`."""
TEXTS = ("case", "way", "method", "level", "quantity", "when", "refined", "outcome", "message")
"""Columns that hold texts."""
NUMBERS = dict.fromkeys((name for name in COLUMNS if name not in TEXTS), float)
"""Types of the other columns."""
Row = Mapping[str, Any]
Place = tuple[str, str]
"""Names of a case and of a way."""


@dataclass
class Record:
    """The rows of a study, which are also written to a file as soon as a level is solved.

    Parameters
    ----------
    file : CSV file; None to keep the rows only in memory
    rows : the rows so far
    remarks : sentences about an interruption, and about what was left out
    """

    file: Path | None = None
    rows: list[Row] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    _earlier: dict[Place, dict[str, list[Row]]] = field(default_factory=dict)

    @classmethod
    def resumed(cls, text: str, file: Path | None) -> "Record":
        """Return a record that continues the rows of a file.

        Parameters
        ----------
        text : content of the file; a last line that is not complete is left out
        file : file to write to
        """
        from io import StringIO

        complete = text[: text.rfind("\n") + 1]
        # numbers are read as texts and converted by Python, which loses no digit
        texts = pd.read_csv(StringIO(complete), dtype=str).reindex(columns=list(COLUMNS))
        table = texts.astype(NUMBERS)
        rows: list[Row] = [
            {
                name: cell
                for name, cell in row.items()
                if not (name in TEXTS and not isinstance(cell, str))
            }
            for row in table.to_dict("records")
        ]
        record = cls(file)
        for row in rows:
            levels = record._earlier.setdefault((row["case"], row["way"]), {})
            levels.setdefault(row["level"], []).append(row)
        return record

    def earlier(self, case: str, way: str) -> dict[str, list[Row]]:
        """Return the rows of the levels of a way that were solved before, by the level."""
        return self._earlier.get((case, way), {})

    def add(self, rows: list[Row]) -> None:
        """Append the rows of a level to the table and to the file."""
        if self.file:
            new = without_formulas(_table(rows))
            text = new.to_csv(index=False, header=not self.rows)
            # one call of the system: a process that is killed writes all rows of a level, or none
            with self.file.open("ab" if self.rows else "wb", buffering=0) as file:
                file.write(text.encode())
        self.rows += rows

    @property
    def table(self) -> pd.DataFrame:
        """The table so far."""
        return _table(self.rows)


def _table(rows: Sequence[Row]) -> pd.DataFrame:
    """Return rows as a table, in which all columns without texts hold numbers."""
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    return table.astype(NUMBERS)
