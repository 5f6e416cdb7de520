"""Read CSV tables as other programs write them.

Columns may be separated by commas, semicolons, tabs or spaces. Decimals have a point, or a comma if
columns are not separated by commas. Headings may be in upper or lower case, may be symbols (``t``,
``r``, ``p``), and may have units (``time [s]``, ``p (MPa)``, ``r/mm``); units may also be in a row
of their own below the headings. Empty lines, and all text after a ``#``, are skipped.
"""

import re
from io import StringIO
from pathlib import Path

import pandas as pd

from ...meshes import SceneError
from ..crosscheck import SYMBOLS

LINE = re.compile(r"^[ \t]*[^\s#][^\n]*(?:\n|$)", re.MULTILINE)
"""A line that is neither empty nor a comment."""
UNIT = re.compile(r"^(?P<name>[^\[(/]+?)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|/\s*(?P<c>.+))$")
"""A heading with a unit in brackets, in parentheses or after a slash."""


def split_heading(heading: str) -> tuple[str, str]:
    """Return the name in a heading, in lower case, and the unit in it; empty if there is none."""
    matched = UNIT.match(heading.strip())
    name, unit = heading.strip(), ""
    if matched:
        name, unit = matched["name"], next(filter(None, matched.group("a", "b", "c")), "")
    return re.sub(r"\s+", "_", name.strip().lower()), unit.strip()


def name_and_unit(heading: str) -> tuple[str, str]:
    """Return our name of a column, and the unit in its heading; empty if there is none."""
    name, unit = split_heading(heading)
    return SYMBOLS.get(name, name), unit


def read_csv_text(path: Path, text: str) -> pd.DataFrame:
    """Return a table of texts, indexed by line number, with the headings of the file.

    Units in a row of their own are appended to the headings, in brackets.

    Raises
    ------
    SceneError
        if there are no rows or no headings, or if a row has another length than the headings;
        it names the line
    """
    lines = text.replace('"', "").splitlines()
    content = {
        number: line.partition("#")[0].strip()
        for number, line in enumerate(lines, 1)
        if line.partition("#")[0].strip()
    }
    if len(content) < 2:
        raise SceneError(f"{path} has no rows: give names of columns, and numbers below them")
    first, *others = content
    separator = _separator(content[first])
    decimal_commas = separator != ","
    rows = {number: _cells(line, separator, decimal_commas) for number, line in content.items()}
    headings = rows[first]
    if all(_is_number(cell) for cell in headings):
        raise SceneError(
            f"{path}, line {first}: the first line must name the columns; give names, as in "
            "time,radius,pressure"
        )
    for number in others:
        if len(rows[number]) != len(headings):
            raise SceneError(
                f"{path}, line {number}: {len(rows[number])} cells under {len(headings)} "
                "columns; give as many cells as columns, with points for decimals"
            )
    if not any(cell == "" or _is_number(cell) for cell in rows[others[0]]):
        units = rows[others[0]]
        headings = [
            f"{split_heading(heading)[0]} [{unit.strip('[]()')}]"
            for heading, unit in zip(headings, units, strict=True)
        ]
        others = others[1:]
    return pd.DataFrame([rows[number] for number in others], others, headings)


def read_numbers(path: Path, text: str) -> pd.DataFrame | None:
    """Return a table of numbers, read in one call, which is faster for large files.

    The result is that of `read_csv_text`, as numbers. It is None if the table cannot be read so,
    for example because a cell is not a number.
    """
    first_lines = [match for match, _ in zip(LINE.finditer(text), range(3), strict=False)]
    if len(first_lines) < 3:
        return None
    try:
        head = read_csv_text(path, "\n".join(match[0] for match in first_lines))
    except SceneError:
        return None
    separator = _separator(first_lines[0][0])
    # `head` has one row if a row of units follows the headings, else two
    body_start = first_lines[2 - len(head)].end()
    body = text[body_start:]
    comma = separator != "," and re.search(r"\d,\d", first_lines[2][0])
    try:
        table = pd.read_csv(
            StringIO(body),
            sep=separator or r"\s+",
            decimal="," if comma else ".",
            header=None,
            comment="#",
            dtype=float,
            skipinitialspace=True,
        )
    except ValueError:
        return None
    has_comments_or_blanks = "#" in body or re.search(r"\n[ \t\r]*\n", body)
    has_empty_cells = table.isna().to_numpy().any()
    if table.shape[1] != head.shape[1] or (
        has_empty_cells and (has_comments_or_blanks or not separator)
    ):
        return None
    # pandas fills a row that is too short with empty cells
    if has_empty_cells and body.count(separator) != len(table) * (table.shape[1] - 1):
        return None
    first = text.count("\n", 0, body_start) + 1
    if has_comments_or_blanks:
        lines = enumerate(body.split("\n"), first)
        table.index = pd.Index([number for number, line in lines if LINE.match(line)])
    else:
        table.index = pd.RangeIndex(first, first + len(table))
    table.columns = head.columns
    return table


def _separator(headings: str) -> str:
    """Return the character that separates the columns; empty if spaces do."""
    separators = (mark for mark in (";", "\t", ",") if mark in headings)
    return next(separators, "" if re.search(r"\S\s+[^\s\[(]", headings.strip()) else ",")


def _cells(line: str, separator: str, decimal_commas: bool) -> list[str]:
    """Return the cells of a line; `decimal_commas` replaces commas in numbers by points."""
    # a space before a bracket is no separator: a unit in brackets belongs to the name before it
    parts = line.split(separator) if separator else re.split(r"\s+(?![\[(])", line.strip())
    cells = [cell.strip() for cell in parts]
    if not decimal_commas:
        return cells
    return [re.sub(r"^([-+]?\d*),(\d+([eE][-+]?\d+)?)$", r"\1.\2", cell) for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True
