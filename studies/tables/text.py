"""Read tables of text as other programs write them.

Columns may be separated by commas, semicolons, tabs or spaces. Decimals have a point, or a comma if
columns are not separated by commas. Headings may be in upper or lower case, may be symbols (``t``,
``r``, ``p``), and may have units (``time [s]``, ``p (MPa)``, ``r/mm``); units may also be in a row
of their own below the headings. Headings may be the last comment above the numbers. Empty lines,
lines that begin with ``%``, and all text after a ``#``, are skipped.
"""

import csv
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from io import StringIO
from itertools import islice
from pathlib import Path

import pandas as pd

from ...meshes import SceneError

COMMENT = re.compile(r"^[ \t]*(?:[#%]+)(.*)$")
"""A line that is a comment, and its text."""
LENGTH_UNIT = re.compile(r"length unit:\s*(\S+)", re.IGNORECASE)
"""A comment of COMSOL with the unit of coordinates."""
UNIT = re.compile(r"^(?P<name>[^\[(/]+?)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|/\s*(?P<c>.+))$")
"""A heading with a unit in brackets, in parentheses or after a slash."""
COMMA_NUMBER = re.compile(r"^([-+]?\d*),(\d+([eE][-+]?\d+)?)$")
"""A number with a decimal comma."""
SPACED_NUMBER = re.compile(r"[-+]?(\d+\.|\d*[.,]?\d+)([eE][-+]?\d+)?|nan|inf", re.IGNORECASE)
"""A number between spaces, with a decimal point or comma."""
USUAL_UNITS = {
    *("", "-", "m", "mm", "cm", "um", "µm", "μm", "nm", "in", "s", "ms", "min", "h", "N", "kN"),
    *("mN", "Pa", "kPa", "MPa", "GPa", "N/mm^2", "N/mm2", "N/m^2", "1", "%"),
}
"""Units that a row of their own may have, if it is not the first after the headings."""
BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff")
"""First bytes of text in UTF-16."""
CONTROL = re.compile(r"[\0-\x08\x0e-\x1a\x1c-\x1f\x7f-\x9f\u0e00-\u1fff\u2c00-\uffef]")
"""Characters that no table has."""
MOST_COMMENTS = 200
"""Number of lines at the beginning of a large file among which its first numbers are."""
NO_HEADINGS = "the first line must name the columns; give names, as in time,radius,pressure"


def text_of_file(path: Path) -> str:
    """Return the text of a file in UTF-8, UTF-16 or, if it is neither, Windows-1252.

    Raises
    ------
    SceneError
        if there is no such file, or if it has other content than text
    """
    try:
        refuse_device(path)
        content = path.read_bytes()
    except ValueError as error:
        raise SceneError(f"{error} of text") from None
    except OSError as error:
        reason = str(error.strerror).lower().removesuffix(" or directory")
        raise SceneError(f"{path} cannot be read: {reason}; give a file of text") from None
    encodings = ("utf-16",) if content[:2] in BYTE_ORDER_MARKS else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if CONTROL.search(text) is None:
                return text
    raise SceneError(
        f"{path} cannot be read: it is not text in UTF-8; give CSV, or netCDF in a file that ends "
        "in .nc"
    )


def refuse_device(path: Path) -> None:
    """Refuse a device such as /dev/zero, which may have no end; pipes and /dev/null are allowed.

    Raises
    ------
    ValueError
        with the path
    """
    if path.is_char_device() and not path.samefile(os.devnull):
        raise ValueError(f"'{path}' is a device, which may have no end: give a file")


def split_heading(heading: str) -> tuple[str, str]:
    """Return the name in a heading, in lower case, and the unit in it; empty if there is none."""
    matched = UNIT.match(heading.strip())
    name, unit = heading.strip(), ""
    if matched:
        name, unit = matched["name"], next(filter(None, matched.group("a", "b", "c")), "")
    return re.sub(r"\s+", "_", name.strip().lower()), unit.strip()


def read_texts(path: Path, text: str, headed: bool = True) -> pd.DataFrame:
    """Return a table of texts, indexed by line number, with the headings of the file.

    Units in a row of their own are appended to the headings, in brackets. Without headings, the
    columns are numbered.

    Parameters
    ----------
    path : of the file, for messages
    text : of the file
    headed : whether the table must have headings

    Raises
    ------
    SceneError
        if there are no rows or no headings, or if a row has another length than the headings;
        it names the line
    """
    lines = text.splitlines()
    content = dict(_content(lines))
    if not content:
        raise SceneError(f"{path} has no rows: give names of columns, and numbers below them")
    rows, separator = _without_preamble(content)
    first, *others = rows
    headings = rows[first]
    if all(map(_is_number, headings)):
        comments = [found[1].strip() for line in lines[:first] if (found := COMMENT.match(line))]
        headings = _with_units_of_all(_headings_of(comments, separator, len(headings)), comments)
        if headed and not headings:
            raise SceneError(f"{path}, line {first}: {NO_HEADINGS}")
        others = [first, *others]
    if not others:
        raise SceneError(f"{path} has no rows: give names of columns, and numbers below them")
    count = len(headings) or len(rows[first])
    if headings and not headings[-1] and all(not rows[number][-1] for number in others):
        # a separator ends each line
        rows, count = {number: cells[:-1] for number, cells in rows.items()}, count - 1
        headings = headings[:-1]
    for number in others:
        if len(rows[number]) != count:
            raise SceneError(
                f"{path}, line {number}: {len(rows[number])} cells under {count} columns; give as "
                "many cells as columns, with points for decimals"
            )
    if headings and not any(cell == "" or _is_number(cell) for cell in rows[others[0]]):
        units, *others = rows[others[0]], *others[1:]
        headings = [
            f"{split_heading(heading)[0]} [{unit.strip('[]()')}]"
            for heading, unit in zip(headings, units, strict=True)
        ]
    columns: Iterable[object] = headings or range(count)
    return pd.DataFrame([rows[number] for number in others], others, [*columns])


def read_numbers(path: Path) -> pd.DataFrame | None:
    """Return a table of numbers from a large file, without its text in memory.

    The result is that of `read_texts`, as numbers. It is None if the table cannot be read so, for
    example because a cell is not a number.
    """
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        head = list(islice(file, MOST_COMMENTS))
    content = [number for number, _ in _content(head)][:3]
    if len(content) < 3:
        return None
    try:
        table = read_texts(path, "".join(head[: content[-1]]))
    except SceneError:
        return None
    first = int(table.index[0])
    separator = _separator([line for _, line in _content(head)][:3])
    comma = separator != "," and any(re.search(r"\d,\d", line) for line in head[first - 1 :])
    try:
        numbers = pd.read_csv(
            path,
            sep=separator or r"\s+",
            decimal="," if comma else ".",
            header=None,
            skiprows=first - 1,
            dtype=float,
            skipinitialspace=True,
            skip_blank_lines=False,
            encoding="utf-8-sig",
        )
    except ValueError:
        return None
    # empty lines and comments have no numbers, and a row that is too short has some missing
    if numbers.shape[1] != table.shape[1] or numbers.isna().to_numpy().any():
        return None
    numbers.index = pd.RangeIndex(first, first + len(numbers))
    numbers.columns = table.columns
    return numbers


def _content(lines: Iterable[str]) -> Iterable[tuple[int, str]]:
    """Yield the number and the text of each line that is neither empty nor a comment."""
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].strip()
        if text and not text.startswith("%"):
            yield number, text


def _without_preamble(content: dict[int, str]) -> tuple[dict[int, list[str]], str]:
    """Return the rows of a table without lines that describe it before, and its separator.

    Such lines have another number of cells than the last line. The table begins with headings, or
    with numbers that follow at least two such lines.
    """
    lines = [*content.values()]
    separator, of_rows = _separator(lines[:3]), _separator(lines[-2:])
    cells = [_cells(line, of_rows) for line in lines]
    as_it_is = cells if separator == of_rows else [_cells(line, separator) for line in lines]
    whole = dict(zip(content, as_it_is, strict=True)), separator
    count = len(cells[-1])
    start = next(number for number, row in enumerate(cells) if len(row) == count)
    if count < 2 or len(as_it_is[0]) == count:
        # a description may have as many cells as the table: headings are above the first numbers
        numbers = (number for number, row in enumerate(cells) if all(map(_is_number, row)))
        start = next(numbers, 0) - 1
        if start > 0 and all(cell.strip("[]()") in USUAL_UNITS for cell in cells[start]):
            start -= 1
        if start < 1 or any(map(_is_number, cells[start])):
            return whole
    named = not any(map(_is_number, cells[start]))
    # a table is longer than its description
    if not start or 2 * start > len(lines) or not (named or start > 1):
        return whole
    return dict([*zip(content, cells, strict=True)][start:]), of_rows


def _with_units_of_all(headings: list[str], comments: list[str]) -> list[str]:
    """Return headings in a comment with units in all of them, or in none.

    COMSOL writes coordinates without a unit, and their unit in another comment, if at all. Without
    it, the units of other columns are those of a model whose units are not known.
    """
    units = [split_heading(heading)[1] for heading in headings]
    if all(units) or not any(units):
        return headings
    lengths = next((unit for text in comments if (unit := LENGTH_UNIT.match(text))), None)
    if lengths:
        return [
            heading if unit else f"{heading} [{lengths[1]}]"
            for heading, unit in zip(headings, units, strict=True)
        ]
    return [split_heading(heading)[0] for heading in headings]


def _headings_of(comments: list[str], separator: str, count: int) -> list[str]:
    """Return the headings in the last of some comments; none if it does not have so many."""
    last = comments[-1] if comments else ""
    # names may have spaces if more than one separates them
    for cells in (_cells(last, separator), re.split(r"\s{2,}", last)):
        if len(cells) == count and not any(map(_is_number, cells)):
            return cells
    return []


def _separator(lines: list[str]) -> str:
    """Return the character that separates the columns of lines; empty if spaces do."""
    headings, last = lines[0], lines[-1]
    if ";" in headings:
        return ";"
    if "\t" in headings:
        return "\t"
    # with decimal commas, spaces separate numbers
    if len(parts := last.split()) > 1 and all(map(SPACED_NUMBER.fullmatch, parts)):
        return ""
    if "," in headings:
        return ","
    return "" if re.search(r"\S\s+[^\s\[(]", headings.strip()) else ","


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line, with points in place of decimal commas."""
    if '"' in line:
        (parts,) = csv.reader(StringIO(line), delimiter=separator or " ", skipinitialspace=True)
    else:
        # a space before a bracket is no separator: a unit in brackets belongs to the name before it
        parts = line.split(separator) if separator else re.split(r"\s+(?![\[(])", line.strip())
    cells = [cell.strip() for cell in parts]
    return cells if separator == "," else [COMMA_NUMBER.sub(r"\1.\2", cell) for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True
