"""Numbers in cells of text: one grammar for all files that others wrote.

A column is read as a whole, because a cell alone may be ambiguous: 1,600 is 1600 beside 1.00625,
and 1.6 beside 0,25. If its own cells and the other columns leave it open, it is refused.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ...meshes import SceneError

SIGNS = str.maketrans(
    "\u2212\u2010\u2011\u2012\u2013\ufe63\uff0d\u2019\xa0\u2009\u202f", "-------'   "
)
"""Signs and spaces of other alphabets, and ours."""
MISSING = re.compile(
    r"|-+|\*+|\.+|\?|n/?a|null|none|nil|masked|bad|missing|(no|not) ?(data|available|measured)"
    r"|#(n/a|div/0!|value!|num!|ref!|name\?).*|[-+]?nan(\(.*\)|q|s)?|[-+]?1\.#(?!inf)\w+",
    re.IGNORECASE,
)
"""Cells without a value."""
EXPONENT = re.compile(r"[dDqQ]|\s?[x*·×]\s?10\^?|(?<=[\d.])(?=[-+]\d)")
"""What is `e` in other numbers: 1.6D+02 and 1.6+02 of Fortran, and 1.6x10^2."""
CLOCK = re.compile(r"(\d+ days?,? )?\d+:[0-5]\d:[0-5]\d([.,]\d+)?")
DATE = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,]\d+)?)?(Z|[-+]\d\d:?\d\d)?)?")
FRACTION = re.compile(r"(-?\d+) ?/ ?(\d*[1-9]\d*)")


def _grammar(point: str, comma: str) -> re.Pattern[str]:
    whole = rf"(?:[1-9]\d{{0,2}}(?P<thousands>[{comma}' ]\d{{3}})+|\d*)"
    exponent = r"(?:[eEdDqQ][-+]?\d+|\s?[x*·×]\s?10\^?[-+]?\d+)"
    usual = rf"{whole}(?P<decimals>[{point}]\d*)?{exponent}?"
    number = rf"[-+]?(?=[{point}]?\d)(?:{usual}|\d*[{point}]\d*[-+]\d+) ?%?"
    return re.compile(rf"{number}|[-+]?inf(inity)?", re.IGNORECASE | re.ASCII)


GRAMMARS = {".": _grammar(".", ","), ",": _grammar(",", ".")}
"""Numbers with each mark of decimals, and with the other one, a space or ' between thousands."""


class Numbers(NamedTuple):
    """The numbers in a table of texts.

    Parameters
    ----------
    values : numbers by heading; NaN in cells that are missing or wrong
    wrong : cells that are neither missing nor a number, by heading and line; none for most headings
    clocks : headings of columns of times of the day or dates, which are in seconds
    """

    values: pd.DataFrame
    wrong: Mapping[str, "pd.Series[str]"]
    clocks: frozenset[str]


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, a time of the day or a date, with any mark of decimals."""
    if cell.isdecimal():
        return True
    cell = _clean(cell)
    patterns = (*GRAMMARS.values(), CLOCK, DATE, FRACTION)
    return any(pattern.fullmatch(cell) for pattern in patterns)


def fortran_number(text: str) -> float:
    """Return the number in a text, whose exponent may be written as in Fortran.

    Raises
    ------
    ValueError
        if the text is no number
    """
    return float(EXPONENT.sub("e", text, count=1))


def is_missing(cell: str) -> bool:
    """Return whether a cell says that there is no value."""
    return MISSING.fullmatch(_clean(cell)) is not None


def _clean(cell: object) -> str:
    return str(cell).translate(SIGNS).strip()


def marks_of(columns: Iterable["pd.Series[str]"]) -> set[str]:
    """Return the marks of decimals with which most cells of each column are numbers."""
    found = set(GRAMMARS)
    for column in columns:
        counts = {mark: column.str.fullmatch(each).sum() for mark, each in GRAMMARS.items()}
        found &= {mark for mark, count in counts.items() if count == max(counts.values())}
    return found


def numbers(cells: pd.DataFrame) -> Numbers:
    """Return the numbers in a table of texts and numbers.

    Dates are seconds since the first.
    """
    values, wrong, clocks = cells.copy(), dict[str, Any](), set[str]()
    texts = cells.select_dtypes(exclude="number").map(_clean)
    given = {str(key): column[~column.str.fullmatch(MISSING)] for key, column in texts.items()}
    marks = {"."}
    if any(column.str.contains(",").any() for column in given.values()):
        marks = marks_of(given.values()) or set(GRAMMARS)
    for key, column in given.items():
        found = _seconds(column)
        if found is not None:
            clocks.add(key)
        else:
            found = pd.to_numeric(column, errors="coerce")
            # a point may be between thousands, if another cell has a decimal comma
            if found.isna().any() or marks != {"."}:
                found = _column(column, marks & marks_of([column]) or marks_of([column]))
        values[key] = found
        if found.isna().any():
            wrong[key] = cells[key][found.index[found.isna()]]
    return Numbers(values.astype(float), wrong, frozenset(clocks))


def _seconds(column: "pd.Series[str]") -> "pd.Series[float] | None":
    """Return seconds, if all cells of a column are times of the day, or dates."""
    times: pd.Series[pd.Timedelta]
    if column.empty:
        return None
    if column.str.fullmatch(CLOCK).all():
        times = pd.to_timedelta(column.str.replace(r",(?=\d)", ".", regex=True))
        # after midnight, clocks begin again, but not durations of pandas
        again = (times.diff() < pd.Timedelta(hours=-12)) & ~column.str.contains("day")
        times = times.mask(again)
    elif column.str.fullmatch(DATE).all():
        dates = pd.to_datetime(column.str.replace(",", "."), format="ISO8601", utc=True)
        times = dates - dates.min()
    else:
        return None
    return times.dt.total_seconds()


def _column(column: "pd.Series[str]", marks: set[str]) -> "pd.Series[float]":
    """Return the numbers in a column without missing values; NaN in cells that are none."""
    if column.str.fullmatch(FRACTION).any():
        parts = column.str.extract(FRACTION).astype(float)
        return (parts[0] / parts[1]).fillna(pd.to_numeric(column, errors="coerce"))
    if len(marks) > 1 and column.str.contains(",").any():
        return pd.Series(float("nan"), column.index)
    mark = "." if "." in marks else ","
    other = {".": ",", ",": "."}[mark]
    parts = column.str.extract(GRAMMARS[mark])
    # where some numbers have decimals, 1,600 is no whole number
    whole = parts["thousands"].fillna("").str.startswith(other) & parts["decimals"].isna()
    mixed = whole & parts["decimals"].notna().any()
    plain = column.where(column.str.fullmatch(GRAMMARS[mark]) & ~mixed, "")
    plain = plain.str.replace(EXPONENT, "e", n=1, regex=True)
    plain = plain.str.replace(rf"[' {other}]", "", regex=True).str.replace(mark, ".")
    size = np.where(plain.str.endswith("%"), 0.01, 1.0)
    return pd.to_numeric(plain.str.rstrip("%"), errors="coerce") * size


def refuse(place: str, cell: str) -> None:
    """Raise an error for a cell that is no number.

    Raises
    ------
    SceneError
        with its place, and the remedy
    """
    text, remedy = _clean(cell), "; give a number, such as 0.5"
    if all(each.fullmatch(text) for each in GRAMMARS.values()):
        remedy = (
            " may have a decimal comma or a separator of thousands: leave out such separators, and "
            "give points for decimals"
        )
    elif re.search(r"\d[:/]\d", text):
        remedy += ", a time such as 0:30:00 or a date such as 2026-03-02, all in one form"
    raise SceneError(f"{place}: {cell!r}{remedy}")
