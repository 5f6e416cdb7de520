"""Tables with a number or a missing value in each cell, whatever they were read from."""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from .headings import BRACKETS, TIME, name_of, split_heading
from .layout import Layout, content_of_file, layout_of, text_of
from .numbers import marks_of, numbers, refuse

MASK = "vtkvalidpointmask"
"""Column of ParaView that is 0 at points outside of a mesh."""
HEAD = 50_000
"""Number of bytes whose layout is that of a larger file, if all others are plain numbers."""
MOST_CIRCLES = 500
"""Greatest number of circles of equal radius; points of more are put together in rings."""
ROUNDOFF = 1e-9
"""Radii are equal up to this part of the greatest."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A table.

    Parameters
    ----------
    name : of the file, or of the table in memory
    cells : texts or numbers by heading, indexed by the numbers of lines or rows
    values : numbers by heading; NaN in cells that are missing or no numbers
    wrong : cells that are neither missing nor a number, by heading and line
    units : by heading, where they are known
    clocks : headings of columns of times of the day or dates, which are in seconds
    place : what a row is called, line or row
    repeated : headings that several columns have, of which the first is in `cells`
    above : the text above the table in a file
    """

    name: str
    cells: pd.DataFrame
    values: pd.DataFrame
    wrong: Mapping[str, "pd.Series[str]"]
    units: Mapping[str, str]
    clocks: frozenset[str] = frozenset()
    place: str = "row"
    repeated: frozenset[str] = frozenset()
    above: str = ""

    @classmethod
    def of(
        cls,
        name: str,
        cells: pd.DataFrame,
        headings: Sequence[str],
        units: Mapping[str, str] | None = None,
        **about: Any,
    ) -> "Frame":
        """Return a table of texts or numbers, without points outside of a mesh.

        Columns without a heading are called by their numbers.

        Parameters
        ----------
        name : of the table
        cells : by column and line
        headings : of the columns
        units : by heading, if they are not in the headings
        about : `place` and `above`
        """
        labels = pd.Index(
            [each.strip() or f"column {number}" for number, each in enumerate(headings, 1)]
        )
        repeated = labels.duplicated()
        cells = cells.set_axis(labels, axis=1).loc[:, ~repeated]
        for heading in [*cells]:
            if split_heading(heading).name == MASK:
                inside = pd.to_numeric(cells.pop(heading), errors="coerce") != 0
                cells = cells[inside]
        values, wrong, clocks = numbers(cells)
        found = {heading: split_heading(heading).unit for heading in cells}
        found |= {**(units or {}), **dict.fromkeys(clocks, "s")}
        found = {heading: unit for heading, unit in found.items() if unit and heading in cells}
        return cls(
            name, cells, values, wrong, found, clocks, repeated=frozenset(labels[repeated]), **about
        )

    @classmethod
    def of_file(cls, path: Path, headed: bool = True) -> "Frame":
        """Return the table in a file of text; without headings, columns are called 0, 1 and so on.

        Parameters
        ----------
        path : of the file
        headed : whether the table must have headings

        Raises
        ------
        SceneError
            if the file cannot be read, or has no table
        """
        content, plain = content_of_file(path, HEAD), None
        if len(content) == HEAD:
            plain = _plain_rows(path, content)
            content = b"" if plain else content_of_file(path)
        if plain:
            layout, cells = plain
        else:
            layout = layout_of(path, text_of(content, path))
            cells = pd.DataFrame([*layout.rows.values()], [*layout.rows], dtype=object)
        if headed and not layout.headings:
            raise SceneError(
                f"{path}, line {cells.index[0]}: the first line must name the columns; give names, "
                "as in time,radius,pressure"
            )
        headings = layout.headings or [*map(str, cells)]
        return cls.of(str(path), cells, headings, place="line", above=layout.above)

    @classmethod
    def of_pandas(
        cls, table: pd.DataFrame, name: str, units: Mapping[str, str] | None = None
    ) -> "Frame":
        """Return a table of pandas, whose cells may be durations, dates or quantities of pint.

        Parameters
        ----------
        table : headings of several levels are those of the last one, if that has names
        name : of the table
        units : by heading, if they are not in the headings

        Raises
        ------
        SceneError
            if a column has quantities of several units
        """
        if table.index.names != [None] or not table.index.is_unique:
            table = table.reset_index(drop=table.index.names == [None])
        headings, columns, units = list[str](), list["pd.Series[Any]"](), dict(units or {})
        for label, column in table.items():
            several = isinstance(label, tuple) and not isinstance(label[-1], str)
            last = label[-1] if isinstance(label, tuple) else label
            headings.append(" ".join(map(str, label)) if several else str(last))
            if column.dtype.kind not in "iuf":
                given = {str(cell.units) for cell in column if hasattr(cell, "units")}
                if len(given) > 1:
                    raise SceneError(
                        f"{name}, column {headings[-1]!r} has the units "
                        f"{', '.join(sorted(given))}: give one"
                    )
                units |= dict.fromkeys(headings[-1:], "".join(given)) if given else {}
                # dates and durations have the form of texts, which are read as seconds
                column = column.astype(object).map(lambda cell: getattr(cell, "magnitude", cell))
                column = column.map(str).where(column.notna(), "")
            columns.append(column)
        cells = pd.DataFrame(dict(enumerate(columns)), table.index)
        return cls.of(name, cells, headings, units)

    @classmethod
    def of_xarray(cls, data: Any, name: str) -> "Frame":
        """Return a table of a dataset of xarray, with the units in its attributes."""
        data = data.drop_vars([key for key in data.coords if not data[key].dims])
        units = {str(key): str(data[key].attrs.get("units", "")) for key in data.variables}
        # seconds since a date
        units = {key: unit.partition(" since ")[0] for key, unit in units.items()}
        known = {key: unit for key, unit in units.items() if unit not in ("", "1")}
        rows = data if data.dims else data.expand_dims("row")
        return cls.of_pandas(rows.to_dataframe(), name, known)

    def refuse_faults(self, columns: Mapping[str, str]) -> None:
        """Refuse headings that are open, and cells that are neither numbers nor missing.

        Parameters
        ----------
        columns : names of the columns that are needed, in messages, by their headings

        Raises
        ------
        SceneError
            with the line, the column and the cell
        """
        for heading, name in columns.items():
            if heading in self.repeated:
                raise SceneError(
                    f"{self.name}: two columns are called {heading}: give each table or curve in a "
                    "file of its own"
                )
            if len(re.findall(r"[\[(]", heading)) != len(re.findall(r"[\])]", heading)):
                raise SceneError(f"{self.name}: close the brackets of the column {heading!r}")
            # a thousandth of a pascal, or a letter that was lost, which pint would leave out
            if re.search("^mPa$|[?\ufffd]", self.units.get(heading, "")):
                raise SceneError(
                    f"{self.name}: the unit of {heading!r} may be another one: write it as in MPa, "
                    "um or 1e-3 Pa"
                )
            if heading in self.wrong:
                wrong = self.wrong[heading]
                place = f"{self.name}, {self.place} {wrong.index[0]}, column {name!r}"
                refuse(place, wrong.iloc[0])

    def table(self) -> pd.DataFrame:
        """Return a table with the headings without units; columns that have words are texts.

        Raises
        ------
        SceneError
            if a column of numbers has a cell that is none
        """
        words = [key for key in self.cells if self.values[key].isna().all()]
        self.refuse_faults({key: key for key in self.cells if key not in words})
        table = self.values.assign(**{key: self.cells[key] for key in words})
        return table.rename(columns=lambda key: BRACKETS.sub("", key)).reset_index(drop=True)

    def find(self, heading: str) -> list[str]:
        """Return the headings that a user means: a whole one, or one without unit in any case."""
        exact = [each for each in self.cells if each == heading]
        name = split_heading(heading).name
        return exact or [each for each in self.cells if split_heading(each).name == name]

    def long(self) -> "Frame":
        """Return a table with a row for each time, in place of a column for each: p @ t=0, p @ t=1.

        Raises
        ------
        SceneError
            if the times have different units
        """
        matched = {heading: found for heading in self.cells if (found := TIME.fullmatch(heading))}
        if not matched:
            return self
        units = {found["unit"] for found in matched.values()}
        if len(units) > 1:
            raise SceneError(f"{self.name} has times of several units: give all in one")
        time = f"time [{''.join(units)}]" if any(units) else "time"
        others = self.cells.drop(columns=[*matched])
        tables = dict[float, pd.DataFrame]()
        for heading, found in matched.items():
            moment = float(found["time"])
            table = tables.setdefault(moment, others.assign(**{time: moment}))
            table[found["heading"]] = self.cells[heading]
        # lines of the file are no rows any more
        cells = pd.concat(tables.values(), ignore_index=True)
        return replace(Frame.of(self.name, cells, [*cells]), repeated=self.repeated)


def _plain_rows(path: Path, content: bytes) -> tuple[Layout, pd.DataFrame] | None:
    """Return the layout and the rows of a large file, if all are plain numbers; else None.

    Parameters
    ----------
    path : of the file
    content : its beginning
    """
    try:
        layout = layout_of(path, text_of(content[: content.rfind(b"\n") + 1], path))
    except SceneError:
        return None
    sample = pd.DataFrame([*layout.rows.values()], dtype=str)
    first, marks = next(iter(layout.rows)), marks_of(sample[key] for key in sample)
    try:
        cells = pd.read_csv(
            path,
            sep=layout.delimiter or r"\s+",
            decimal="." if "." in marks else ",",
            header=None,
            skiprows=first - 1,
            dtype=float,
            # an empty line or cell is none of these, and no number
            keep_default_na=False,
            na_values=["nan", "NaN"],
            skip_blank_lines=False,
            # a quote in a comment would hide lines
            quoting=csv.QUOTE_NONE,
            encoding="latin-1",
        )
    except ValueError:
        return None
    cells.index = pd.RangeIndex(first, first + len(cells))
    return (layout, cells) if cells.shape[1] == sample.shape[1] else None


def surface_table(points: Array, arrays: Mapping[str, Array]) -> pd.DataFrame:
    """Return the arrays on the free surface of a half-space, over the radius.

    The plane may be x-y or x-z, with an axis that points into the half-space or out of it. Of
    vectors the component into the half-space is taken, called `name_y`, and of tensors that of the
    normal stress on the surface, called `name_zz`. Points outside of a mesh are left out.

    Parameters
    ----------
    points : (n, 2 or 3) coordinates
    arrays : by name, perhaps with a time, as in ``stress t=0.5``: (n,) or (n, components)
    """
    axis = 2 if points.shape[1] > 2 and not np.ptp(points[:, 1]) else 1
    height = points[:, axis]
    on_surface = np.abs(height) <= 1e-9 * np.ptp(height)
    inward = float(np.sign(height.mean()))
    columns = {"radius": points[:, 0]}
    for name, values in arrays.items():
        components = values.reshape(len(points), -1).T
        quantity, mark, time = name.partition(" t=")
        count = len(components)
        if name.lower() == MASK:
            on_surface &= components[0] != 0
        elif count == 1:
            columns[name] = components[0]
        elif count <= 3:
            # its sign is known, unlike that of a component in a table
            moved = name_of(f"{quantity}_y", ("displacement",))
            label = "displacement" if moved else f"{quantity}_y"
            columns[f"{label}{mark}{time}"] = inward * components[min(axis, count - 1)]
        elif count in (6, 9):
            # symmetric tensors, and full ones; four components have no usual order
            columns[f"{quantity}_zz{mark}{time}"] = components[{6: axis, 9: 4 * axis}[count]]
    table = pd.DataFrame(columns)[on_surface]
    return table.groupby("radius").first().reset_index()


def on_circles(table: pd.DataFrame) -> tuple[pd.DataFrame, "pd.Series[float]"]:
    """Return the means of values on a grid over circles around its origin, and their spreads.

    A spread is the greatest difference of two values on one circle. If the points lie on more than
    `MOST_CIRCLES` circles, those of neighbouring circles are put together; they have their mean
    radius.

    Parameters
    ----------
    table : with columns x and y, perhaps time, and values

    Returns
    -------
    means, spreads
        means with the radius and, if it is given, the time; spreads by the names of the values
    """
    radii = np.hypot(table["x"], table["y"])
    greatest = float(radii.max()) or 1.0
    circles = np.round(radii / greatest / ROUNDOFF)
    if circles.nunique() > MOST_CIRCLES:
        circles = np.round(radii / greatest * MOST_CIRCLES)
    values = table.drop(columns=["x", "y"]).assign(radius=radii, circle=circles)
    groups = values.groupby([*values.columns.intersection(["time"]), "circle"])
    spreads = (groups.max() - groups.min()).max().drop("radius")
    return groups.mean().reset_index().drop(columns="circle"), spreads
