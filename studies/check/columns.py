"""Choose the columns of a table that are known, and give them our names, signs and radii."""

from collections.abc import Container, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from ..tables.circles import on_circles
from ..tables.frame import Frame
from ..tables.headings import Name, name_of, split_heading


class Known(NamedTuple):
    """The known columns of a table.

    Parameters
    ----------
    values : numbers by our names, over radii that are not negative
    written : the cells as the other program has written them, with the rows of `values`
    units : by our names, where they are known
    remarks : on what is only guessed
    others : headings of the columns that are not known
    """

    values: pd.DataFrame
    written: pd.DataFrame
    units: dict[str, str]
    remarks: list[str]
    others: list[str]


def known_columns(frame: Frame, wanted: Container[str], columns: Mapping[str, str]) -> Known:
    """Return the columns of a table that are known.

    Parameters
    ----------
    frame : the table
    wanted : our names that a column may have
    columns : our names by those of the user

    Raises
    ------
    SceneError
        if two columns may be the same quantity, or if a cell is no number
    """
    names = {heading: ours for theirs, ours in columns.items() for heading in frame.find(theirs)}
    grid = [] if "radius" in names.values() else _grid(frame)
    candidates = dict[str, list[tuple[int, str, Name]]]()
    for heading in frame.cells:
        found = None if heading in (*names, *grid) else name_of(heading, wanted)
        if found and found[1].name not in names.values():
            candidates.setdefault(found[1].name, []).append((found[0], heading, found[1]))
    if grid:
        candidates.pop("radius", None)
    present = {*names.values(), *candidates, *["radius"] * bool(grid)}
    # along a path of forces there is time, and the displacement without a radius is the punch's
    over_time = "normal_force" in present and not present & {"pressure", "profile", "time"}
    signs, remarks = dict[str, float](), list[str]()
    for name, entries in candidates.items():
        heading, entry = _best(frame, name, entries)
        if over_time and split_heading(heading).name == "x":
            name = "time"
        elif entry.signed and name == "displacement" and (over_time or "radius" not in present):
            name = "indentation"
        names[heading] = name
        remark = f"{heading} is read as {name}"
        if entry.signed and np.nansum(frame.values[heading]) < 0:
            signs[name] = -1.0
            remark += ", with the opposite sign, because it is negative"
        if split_heading(heading).name != name:
            remarks.append(remark)
        if heading in frame.clocks:
            remarks.append(f"{heading}: dates are seconds since the first, clocks since 0:00:00")
    used = {heading: name for heading, name in names.items() if name in wanted}
    if len({*used.values()}) < len(used):
        raise SceneError(f"{frame.name} has a column twice among {', '.join(used)}: name one only")
    frame.refuse_faults(used | dict(zip(grid, grid, strict=True)))
    values = frame.values[[*used]].rename(columns=used)
    written = frame.cells[[*used]].rename(columns=used)
    units = {used[heading]: unit for heading, unit in frame.units.items() if heading in used}
    if grid:
        x, y = frame.values[grid].to_numpy().T
        of_grid = {frame.units.get(heading, "") for heading in grid}
        if len(of_grid) > 1:
            raise SceneError(f"{frame.name}: x and y have different units: give both in one")
        units["radius"] = "".join(of_grid)
    elif "radius" in values and values["radius"].min() < 0 < values["radius"].max():
        x = values.pop("radius").to_numpy()
        y = np.zeros(len(x))
    else:
        x = y = np.empty(0)
    if signs:
        values = values.assign(**{name: sign * values[name] for name, sign in signs.items()})
    if len(x):
        values, spreads = _on_circles(values, x, y)
        written, remarks = values, [*remarks, *spreads]
    others = [heading for heading in frame.cells if heading not in (*used, *grid)]
    return Known(values, written, units, remarks, others)


def _grid(frame: Frame) -> list[str]:
    """Return the headings of x and y of values on a grid, else none."""
    places = {split_heading(heading).name: heading for heading in frame.cells}
    if not {"x", "y"} <= places.keys() or {"r", "radius"} & places.keys():
        return []
    return [places["x"], places["y"]] if frame.values[places["y"]].nunique() > 1 else []


def _best(frame: Frame, name: str, entries: list[tuple[int, str, Name]]) -> tuple[str, Name]:
    """Return the heading of a quantity, and its entry in the names.

    Raises
    ------
    SceneError
        if two columns may be that quantity
    """
    least = min(place for place, _, _ in entries)
    best = [(heading, entry) for place, heading, entry in entries if place == least]
    if len(best) > 1:
        # components that vanish are those across the plane
        best = [each for each in best if frame.values[each[0]].any()] or best
    if len(best) > 1:
        both = " and ".join(repr(heading) for heading, _ in best)
        raise SceneError(
            f"{frame.name}: {both} may both be {name}: choose one, and leave out the other; or "
            f"--columns '{best[0][0]}={name}'; if each is of one time, give a table with a row for "
            "each time and radius"
        )
    return best[0]


def _on_circles(frame: pd.DataFrame, x: Array, y: Array) -> tuple[pd.DataFrame, list[str]]:
    """Return a table of the means over circles of the columns of a table of values at points.

    The remarks say how much values on one circle differ.
    """
    times = frame["time"].to_numpy() if "time" in frame else np.zeros(len(frame))
    tables, spreads = list[pd.DataFrame](), dict[str, float]()
    for time in np.unique(times):
        rows, table = times == time, dict[str, Array | float]()
        for name in frame.columns.difference(["time"], sort=False):
            values = frame[name].to_numpy()[rows]
            radii, means, spread = on_circles(x[rows], y[rows], values)
            table |= {"radius": radii, str(name): means}
            spreads[str(name)] = max(spreads.get(str(name), 0.0), spread)
        tables.append(pd.DataFrame({"time": time, **table} if "time" in frame else table))
    remarks = [
        f"{name}: means over circles around the axis, on which values differ by up to {spread:.3g}"
        for name, spread in spreads.items()
    ]
    return pd.concat(tables, ignore_index=True), remarks
