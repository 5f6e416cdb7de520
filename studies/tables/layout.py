"""The layout of a table of text: its encoding, delimiter, headings and rows."""

import csv
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from statistics import mode
from typing import NamedTuple

from ...meshes import SceneError
from .devices import refuse_device
from .headings import LENGTH_UNIT, TIME, is_unit, split_heading
from .numbers import is_missing, is_number

COMMENT = re.compile(r"\s*(?:[#%!]+(?!N/A|DIV|VALUE|NUM|REF)|//)\s*(.*)")
"""A line that is a comment, and its text."""
REMARK = re.compile(r"^(\s*[-+.\d].*?)\s+(?:#(?!N/A|DIV|VALUE|NUM|REF)|//|!).*")
"""A row of numbers, and a comment at its end; in a heading, # is a number: Sample #."""
RULE = re.compile(r"[-=+|:\s]*--[-=+|:\s]*")
"""A line under headings, as in Markdown."""
DELIMITERS = (";", "\t", "|", ",", "")
"""Characters between cells, those of numbers last; empty for spaces."""
CONTROL = re.compile(r"[\0-\x08\x0e-\x1a\x1c-\x1f\x7f-\x84\x86-\x9f]")
"""Characters that no table has."""
FORMATS = {
    r"PK\x03\x04|\xd0\xcf\x11\xe0": "a workbook of Excel or an archive: export one sheet as CSV",
    r"\x89HDF|CDF[\x01\x02\x05]": "netCDF or HDF5: give netCDF in a file that ends in .nc",
    r"\x1f\x8b|BZh|7z\xbc\xaf": "compressed: unpack it first",
    r"%PDF": "PDF: give its table as CSV",
    r"# vtk DataFile": "a file of VTK of the old form: write it as .vtu, or give CSV",
    r"(?i)\s*<(!doctype html|html)": "a page in HTML: give its table as CSV",
    r"\s*\*Step\s*=": "a log of FEBio: give a table with columns time, radius and pressure",
    r"\s*<(\?xml|VTKFile)": "XML, such as a list of VTU files: give one .vtu, or CSV",
    r"\s*[{\[]\s*[\"{\[]": "JSON: give CSV",
    r"\s*(TITLE|VARIABLES)\s*=": "a file of Tecplot: give CSV with one row of headings",
    r"\s*\\(begin|documentclass)": "LaTeX: give CSV",
}
"""What a file is that begins with a text, and what to give instead."""
SAMPLE = 200
"""Number of lines at the end that show the delimiter and the width of a table."""


class Layout(NamedTuple):
    """A table of texts.

    Parameters
    ----------
    headings : as the file has them, with units of a row of their own in brackets; empty if none
    rows : cells by line number
    delimiter : between the cells of a row; empty if spaces are
    above : the text above the rows
    """

    headings: list[str]
    rows: dict[int, list[str]]
    delimiter: str
    above: str


def content_of_file(path: Path, size: int = -1) -> bytes:
    """Return the content of a file of text, or its first bytes.

    Raises
    ------
    SceneError
        if there is no such file, or if it is of a known format that is no table of text
    """
    try:
        refuse_device(path)
        with path.open("rb") as file:
            content = file.read(size)
    except ValueError as error:
        raise SceneError(f"{error} of text") from None
    except OSError as error:
        reason = str(error.strerror).lower().removesuffix(" or directory")
        raise SceneError(f"{path} cannot be read: {reason}; give a file of text") from None
    for pattern, what in FORMATS.items():
        if re.match(pattern, content[:SAMPLE].decode("latin-1").removeprefix("ï»¿")):
            raise SceneError(f"{path} is {what}")
    return content


def text_of(content: bytes, path: Path) -> str:
    """Return text in UTF-8, UTF-16, GB 18030 or Windows-1252.

    Raises
    ------
    SceneError
        if it has other content than text
    """
    encodings = ["utf-8-sig", "cp1252"]
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encodings = ["utf-16"]
    # Excel on Windows may leave out the mark of the byte order
    elif content[1:2] == b"\0" and content[3:4] == b"\0":
        encodings = ["utf-16-le"]
    # characters of Chinese have two bytes, and an accent is alone
    elif re.search(rb"[\x81-\xfe]{2}", content):
        encodings.insert(1, "gb18030")
    for encoding in encodings:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if CONTROL.search(text) is None:
                return text
    raise SceneError(
        f"{path} cannot be read: it is not text in UTF-8; give CSV, or netCDF in a file that ends "
        "in .nc"
    )


def layout_of(path: Path | str, text: str) -> Layout:
    """Return the headings and rows of a table of text.

    Parameters
    ----------
    path : of the file, for messages
    text : of the file

    Raises
    ------
    SceneError
        if there are no rows, if a row has another length than the others, or if a line of text is
        between rows of numbers; it names the line
    """
    lines, comments, all_lines = dict[int, str](), list[str](), re.split(r"\r\n?|\n", text)
    for number, line in enumerate(all_lines, 1):
        if comment := COMMENT.fullmatch(line):
            comments += [] if lines else [comment[1]]
        elif line.strip() and not RULE.fullmatch(line):
            line = REMARK.sub(r"\1", line).strip()
            # a row of Markdown has a mark at both ends
            lines[number] = line[1:-1] if line[0] == "|" == line[-1] else line
    last = [*lines.values()][-SAMPLE:]
    delimiter = max(DELIMITERS, key=lambda each: _fit(last, each))
    rows = {number: cells_of(line, delimiter) for number, line in lines.items()}
    numeric = [cells for cells in [*rows.values()][-SAMPLE:] if any(map(is_number, cells))]
    width = mode(map(len, numeric)) if numeric else 0
    words = mode(_words(cells) for cells in numeric if len(cells) == width) if numeric else 0
    first = next((number for number in rows if _fits(rows[number], width, words)), None)
    if first is None:
        raise SceneError(f"{path} has no rows: give names of columns, and numbers below them")
    # a line between has the number of rows
    above = [lines[number] for number in lines if number < first and not lines[number].isdigit()]
    rows = {number: cells for number, cells in rows.items() if number >= first}
    for number, cells in rows.items():
        uneven = len(cells) != width
        alone = uneven or cells[0][:1].isalpha()
        if alone and _words(cells) and not any(map(is_number, cells)):
            raise SceneError(
                f"{path}, line {number}: {lines[number].strip()!r} is no row of numbers; give each "
                "table or curve in a file of its own"
            )
        if uneven:
            raise _unequal(path, number, len(cells), width)
    # a delimiter at the end of rows makes no column, unless that has a heading
    filled = width
    while filled > 1 and not any(cells[filled - 1] for cells in rows.values()):
        filled -= 1
    headings = _headings(above, comments, delimiter, filled)
    headings = headings or _headings(above, comments, delimiter, width)
    if len(above) == 1 and not headings:
        raise _unequal(path, first, width, len(cells_of(above[0], delimiter)))
    rows = {number: cells[: len(headings) or filled] for number, cells in rows.items()}
    return Layout(headings, rows, delimiter, "\n".join(all_lines[: first - 1]))


def _unequal(path: Path | str, line: int, cells: int, columns: int) -> SceneError:
    return SceneError(
        f"{path}, line {line}: {cells} cells under {columns} columns; give as many cells as "
        "columns, with points for decimals"
    )


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line."""
    if '"' in line and len(line) < csv.field_size_limit():
        (parts,) = csv.reader([line], delimiter=delimiter or " ", skipinitialspace=True)
    elif delimiter:
        parts = line.split(delimiter)
    elif line[:1] in "+-.0123456789" and "o" not in line and "O" not in line:
        return line.split()
    else:
        # a unit in brackets belongs to the name before it
        line = re.sub(r"\bno data\b", "NaN", line, flags=re.IGNORECASE)
        parts = re.split(r"\s+(?![\[(])", line.strip())
    return [cell.strip() for cell in parts] if " " in line else parts


def _words(cells: Iterable[str]) -> int:
    """Return the number of cells that are neither numbers nor missing."""
    return sum(not (is_number(cell) or is_missing(cell)) for cell in cells)


def _fit(lines: list[str], delimiter: str) -> tuple[int, int]:
    """Return how many numbers lines have if a character separates their cells, less the words."""
    rows = [cells_of(line, delimiter) for line in lines]
    rows = [cells for cells in rows if len(cells) > 1 and any(map(is_number, cells))]
    return sum(len(cells) - 2 * _words(cells) for cells in rows), len(rows)


def _fits(cells: list[str], width: int, words: int) -> bool:
    """Return whether a row is one of numbers; one that begins with a number has a wrong cell."""
    few = _words(cells) <= words or is_number(cells[0])
    return len(cells) == width and few and any(map(is_number, cells))


def _headings(
    above: Sequence[str], comments: Sequence[str], delimiter: str, width: int
) -> list[str]:
    """Return the headings in the lines above the numbers, or in the last comment; else none."""
    splits = [_split_above(line, delimiter, width) for line in above]
    last = splits.pop() if splits else []
    # one unit of a row may be misspelt, and is refused later
    count = sum(map(is_unit, filter(None, last)))
    units = last if count and (all(map(is_unit, last)) or (2 * count >= width and splits)) else []
    if units and splits:
        last = splits.pop()
    if not last and comments:
        last = _split_above(comments[-1], delimiter, width)
        return _with_units_of_all(last, comments)
    if not units:
        return last
    units = [unit.strip("[]() ") for unit in units]
    named = last and not all(map(is_unit, last))
    names = last if named else [str(number) for number in range(width)]
    return [
        f"{split_heading(name).name} [{unit}]" if unit else name
        for name, unit in zip(names, units, strict=True)
    ]


def _split_above(line: str, delimiter: str, width: int) -> list[str]:
    """Return as many texts in a line as there are columns; none if it has another number."""
    splits = [cells_of(line, delimiter)]
    if not delimiter or delimiter not in line:
        splits += [re.split(r"\s{2,}|\t|;", line.strip()), cells_of(line, "")]
    for cells in splits:
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) == width and any(cells) and not all(map(is_number, filter(None, cells))):
            return cells
    return []


def _with_units_of_all(headings: list[str], comments: Sequence[str]) -> list[str]:
    """Return headings in a comment with units in all of them, or in none.

    COMSOL writes coordinates without a unit, and their unit in another comment, if at all. Without
    it, the units of other columns are those of a model whose units are not known.
    """
    units = [split_heading(TIME.sub(r"\g<heading>", heading)).unit for heading in headings]
    if all(units) or not any(units):
        return headings
    lengths = next((unit for text in comments if (unit := LENGTH_UNIT.match(text))), None)
    if lengths:
        return [
            heading if unit else f"{heading} [{lengths[1]}]"
            for heading, unit in zip(headings, units, strict=True)
        ]
    return [re.sub(r"\s*[\[(][^\[(=]*[\])]", "", heading) for heading in headings]
