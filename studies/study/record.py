"""The rows of a study: written to a file as soon as a level is solved, and continued later.

A study that is stopped keeps the rows of the levels that were solved. When it is resumed, these
levels are not solved again, unless a later level needs their solutions. Rows of another study are
refused.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

import pandas as pd

from ...meshes import SceneError
from ..crosscheck import LOG, computed_with
from ..tables.writing import json_text, without_formulas

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
HIDDEN = ".writing"
"""Folder in which a study that was killed has left its rows."""
Row = Mapping[str, Any]


@dataclass
class Record:
    """The rows of a study, which are also written to a file as soon as a level is solved.

    Parameters
    ----------
    file : CSV file; None to keep the rows only in memory
    rows : the rows so far
    remarks : sentences about an interruption, and about what was left out
    before : the rows of an earlier run
    """

    file: Path | None = None
    rows: list[Row] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    before: Sequence[Row] = ()

    @classmethod
    def resumed(cls, text: str, file: Path | None) -> "Record":
        """Return a record that continues the rows of a file.

        Parameters
        ----------
        text : content of the file; a last line that is not complete is left out
        file : file to write to
        """
        complete = StringIO(text[: text.rfind("\n") + 1])
        # numbers are read as texts and converted by Python, which loses no digit
        table = pd.read_csv(complete, dtype=str).astype(NUMBERS)
        before = [
            {str(name): cell for name, cell in row.items() if pd.notna(cell)}
            for row in table.to_dict("records")
        ]
        return cls(file, before=before)

    def earlier(self, case: str, way: str) -> dict[str, list[Row]]:
        """Return the rows of the levels of a way that were solved before, by the level."""
        levels = dict[str, list[Row]]()
        for row in self.before:
            if (row["case"], row["way"]) == (case, way):
                levels.setdefault(row.get("level", ""), []).append(row)
        return levels

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


def rows_before(out: Path, name: str, setup: Mapping[str, Any]) -> str:
    """Return the rows that a stopped study has left in its folder; empty if there are none.

    Parameters
    ----------
    out : output folder
    name : name of the study
    setup : scene and options, which have to be the same

    Raises
    ------
    SceneError
        if the rows are those of another scene, of other options, or of another version
    """
    for folder in (out / HIDDEN, out):
        rows, described = folder / f"{name}.csv", folder / f"{name}.json"
        if not (rows.is_file() and described.is_file()):
            continue
        before, now = json.loads(described.read_text("utf-8")), _described(setup)
        differing = [key for key in now if before.get(key) != now[key]]
        if differing:
            raise SceneError(
                f"--resume: {rows} was written with another {' and '.join(differing)}: leave out "
                "--resume, or give another --out"
            )
        text = rows.read_text("utf-8")
        count = max(text.count("\n") - 1, 0)
        LOG.info("   resuming: %d rows of %s are kept", count, rows)
        return text
    LOG.info("   nothing to resume in %s: the study starts anew", out)
    return ""


def as_before(folder: Path, name: str, setup: Mapping[str, Any], text: str) -> Record:
    """Return the record of a study in a folder, with the rows of a stopped one.

    A file beside the table describes the study, so that it can be resumed.
    """
    described = json_text(_described(setup), indent=1)
    (folder / f"{name}.json").write_text(described + "\n", "utf-8")
    file = folder / f"{name}.csv"
    return Record.resumed(text, file) if text else Record(file)


def _described(setup: Mapping[str, Any]) -> dict[str, Any]:
    """Return what determines the rows of a study, as JSON stores it."""
    described = {**setup, "version": computed_with()}
    return dict(json.loads(json_text(described, default=str)))
