"""CSV tables as other programs write them.

Columns may be separated by commas, semicolons, tabs or spaces, with points for decimals, or commas
where columns are not separated by them. Headings may be in any case, have symbols for names (``t``,
``r``, ``p``), and units (``time [s]``, ``p (MPa)``, ``r/mm``); units may also stand in a row of
their own below the headings. Empty lines, and what follows a ``#``, are left out.
"""

import re
from io import StringIO
from pathlib import Path

import pandas as pd

from ...meshes.errors import SceneError

SYMBOLS = {
    "t": "time",
    "r": "radius",
    "p": "pressure",
    "contact_pressure": "pressure",
    "u": "displacement",
    "uz": "displacement",
    "u_z": "displacement",
    "f": "profile",
    "worn_profile": "profile",
    "wear": "profile",
    "d": "indentation",
    "depth": "indentation",
    "approach": "indentation",
    "fn": "normal_force",
    "f_n": "normal_force",
    "force": "normal_force",
    "load": "normal_force",
}
"""Our names by those that other programs and papers use."""
LINE = re.compile(r"^[ \t]*[^\s#][^\n]*(?:\n|$)", re.MULTILINE)
"""A line that is not empty and no remark."""
UNIT = re.compile(r"^(?P<name>[^\[(/]+?)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|/\s*(?P<c>.+))$")
"""A heading with a unit in brackets, in parentheses or after a slash."""


def name_and_unit(heading: str) -> tuple[str, str]:
    """Return our name for a heading, and the unit that it states; empty if it states none."""
    matched = UNIT.match(heading.strip())
    name, unit = heading.strip(), ""
    if matched:
        name, unit = matched["name"], next(filter(None, matched.group("a", "b", "c")), "")
    name = re.sub(r"\s+", "_", name.strip().lower())
    return SYMBOLS.get(name, name), unit.strip()


def read_csv_text(path: Path, text: str) -> pd.DataFrame:
    """Return a table of texts by the numbers of its lines, headings as they stand.

    Units of a row of their own join the headings, in brackets.

    Raises
    ------
    SceneError
        if there are no rows, no headings, or rows of another length, naming the line
    """
    lines = text.replace('"', "").splitlines()
    kept = {
        number: line.partition("#")[0].strip()
        for number, line in enumerate(lines, 1)
        if line.partition("#")[0].strip()
    }
    if len(kept) < 2:
        raise SceneError(f"{path} has no rows: give names of columns, and numbers below them")
    first, *others = kept
    separator = _separator(kept[first])
    commas = separator != ","
    rows = {number: _cells(line, separator, commas) for number, line in kept.items()}
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
                "columns; give as many, with points for decimals"
            )
    if not any(cell == "" or _is_number(cell) for cell in rows[others[0]]):
        units = rows[others[0]]
        headings = [
            f"{name_and_unit(heading)[0]} [{unit.strip('[]()')}]"
            for heading, unit in zip(headings, units, strict=True)
        ]
        others = others[1:]
    return pd.DataFrame([rows[number] for number in others], others, headings)


def read_numbers(path: Path, text: str) -> pd.DataFrame | None:
    """Return a table of numbers at once, which large files need; None if it is not so simple.

    Headings and units are read, and rows are numbered, as `read_csv_text` does it.
    """
    ends = [match for match, _ in zip(LINE.finditer(text), range(3), strict=False)]
    if len(ends) < 3:
        return None
    try:
        head = read_csv_text(path, "\n".join(match[0] for match in ends))
    except SceneError:
        return None
    separator = _separator(ends[0][0])
    body = text[ends[2 - len(head)].end() :]
    comma = separator != "," and re.search(r"\d,\d", ends[2][0])
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
    blank_or_remark = "#" in body or re.search(r"\n[ \t\r]*\n", body)
    short = table.isna().to_numpy().any()
    if table.shape[1] != head.shape[1] or (short and (blank_or_remark or not separator)):
        return None
    # a row that is too short would be filled up
    if short and body.count(separator) != len(table) * (table.shape[1] - 1):
        return None
    first = text.count("\n", 0, ends[2 - len(head)].end()) + 1
    if blank_or_remark:
        lines = enumerate(body.split("\n"), first)
        table.index = pd.Index([number for number, line in lines if LINE.match(line)])
    else:
        table.index = pd.RangeIndex(first, first + len(table))
    table.columns = head.columns
    return table


def _separator(headings: str) -> str:
    """Return what separates the columns; empty if spaces do."""
    marks = (mark for mark in (";", "\t", ",") if mark in headings)
    return next(marks, "" if re.search(r"\S\s+[^\s\[(]", headings.strip()) else ",")


def _cells(line: str, separator: str, commas: bool) -> list[str]:
    """Return the cells of a line, with points for decimals if commas may stand for them."""
    # a unit in brackets belongs to the name before it
    parts = line.split(separator) if separator else re.split(r"\s+(?![\[(])", line.strip())
    cells = [cell.strip() for cell in parts]
    if not commas:
        return cells
    return [re.sub(r"^([-+]?\d*),(\d+([eE][-+]?\d+)?)$", r"\1.\2", cell) for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True
