"""Results of other programs as tables: read from files, checked, and brought to a scene's units.

A table has a row for each time and radius (`time, radius, pressure, ...`), or for each time (`time,
indentation, normal_force`), or both in one: what goes by time alone may be repeated at every
radius, or stand in rows whose radius is empty. What is wrong is refused in a line that names the
file, the line, the column and the remedy.
"""

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ..problem.quantities import FIELDS, QUANTITIES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames


class Given(NamedTuple):
    """A checked table in the units of a scene, and what the user should know of its reading."""

    table: pd.DataFrame
    notes: tuple[str, ...]


def kinds() -> dict[str, str]:
    """Return the kind of unit of each column that a table may have."""
    given = {name: of.unit for name, of in QUANTITIES.items() if set(of.dims) <= {"time", "radius"}}
    comparable = {name: given[name] for name in given if "time" in QUANTITIES[name].dims}
    return {"time": "time", "radius": "length"} | comparable


def read(
    source: Any, name: str, scene: Scene, columns: Mapping[str, str], units: str
) -> Given:
    """Return results of another program, checked and in the units of a scene.

    Parameters
    ----------
    source : a CSV or netCDF file, a DataFrame, or an xarray Dataset
    name : what messages call it
    columns : names of ours by theirs
    units : of theirs, as a scene states them; those of the scene if empty

    Raises
    ------
    SceneError
        naming the file, the line, the column and the remedy
    """
    notes = list[str]()
    place = "line" if isinstance(source, str | Path) else "row"
    if place == "line":
        path, name = Path(source), str(source)
        source = _read_netcdf(path) if path.suffix in (".nc", ".nc4") else _read_csv(path)
    if hasattr(source, "to_dataframe"):
        place = "row"
        source, notes = _of_dataset(source, columns, name)
    elif source.index.names != [None]:
        source = source.reset_index()
    frame = _named(source, name, columns)
    if left := [str(column) for column in frame if column not in kinds()]:
        notes.append(f"{name}: not read: {', '.join(left)}")
    table = _checked(frame[[column for column in kinds() if column in frame]], name, place)
    theirs = UnitNames.of(units or scene.units)
    if (theirs.base is None) != ((stated := UnitNames.of(scene.units)).base is None):
        raise SceneError(
            f"--units {units!r}: the scene has numbers without units, or theirs have: give units "
            "to both, or to neither"
        )
    for column in table:
        table[column] *= theirs.size(kinds()[column]) / stated.size(kinds()[column])
    if "radius" in table:
        radius = scene.punch.radius
        # what roundoff of units has moved
        table["radius"] = table["radius"].mask(np.isclose(table["radius"], radius, 1e-9), radius)
        beyond = table["radius"] > radius
        if beyond.all():
            raise SceneError(
                f"{name}: all radii lie beyond punch.radius = {radius:g}: give distances from the "
                "axis, and --units if they are in others than the scene"
            )
        if beyond.any():
            notes.append(f"{name}: {beyond.sum()} rows beyond the punch are left out")
        table = table[~beyond]
    return Given(table, tuple(notes))


def _read_csv(path: Path) -> pd.DataFrame:
    """Return a table of text by the numbers of its lines."""
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(
            f"{path} is not a text file: give CSV in UTF-8, or netCDF that ends in .nc"
        ) from None
    except OSError as error:
        raise SceneError(
            f"{path}: {str(error.strerror).lower()}; give a CSV or a netCDF file"
        ) from None
    written = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.startswith("#")
    ]
    if len(written) < 2:
        raise SceneError(
            f"{path} has {len(written)} lines of text: give names of columns, such as time, radius, "
            "pressure, and lines of numbers below them"
        )
    between = next((mark for mark in ";\t" if mark in written[0][1]), ",")
    (_, heads), *rows = (
        (number, [cell.strip(' "') for cell in line.split(between)]) for number, line in written
    )
    for number, cells in rows:
        if len(cells) != len(heads):
            raise SceneError(
                f"{path}, line {number}: {len(cells)} cells under {len(heads)} columns; give one "
                "for each, empty where there is no number, with points for decimals"
            )
    return pd.DataFrame([cells for _, cells in rows], [number for number, _ in rows], heads)


def _read_netcdf(path: Path) -> Any:
    import xarray

    try:
        return xarray.load_dataset(path)
    except (OSError, ValueError) as error:
        reason = str(getattr(error, "strerror", "") or error).splitlines()[0]
        raise SceneError(f"{path} cannot be read as netCDF: {reason}; give such a file") from None


def _of_dataset(
    dataset: Any, columns: Mapping[str, str], name: str
) -> tuple[pd.DataFrame, list[str]]:
    """Return the quantities of a dataset, of several solvers those of the first."""
    notes = []
    if "solver" in dataset.dims:
        notes = [f"{name}: by its first solver, {dataset.solver.values[0]}"]
        dataset = dataset.isel(solver=0, drop=True)
    wanted = [
        key
        for key, values in dataset.data_vars.items()
        if columns.get(key, key) in kinds()
        and values.dims in (("time",), ("time", "radius"), ("radius", "time"))
    ]
    if not wanted:
        raise SceneError(
            f"{name}: no variable over time is one of {', '.join(kinds())}; name them so, or by "
            "--columns theirs=ours"
        )
    return dataset[wanted].reset_coords(drop=True).to_dataframe().reset_index(), notes


def _named(frame: pd.DataFrame, name: str, columns: Mapping[str, str]) -> pd.DataFrame:
    """Return a table with our names for its columns."""
    heads = ", ".join(map(str, frame.columns))
    if absent := [theirs for theirs in columns if theirs not in frame]:
        raise SceneError(f"{name} has no column {absent[0]!r} of --columns: it has {heads}")
    if wrong := [ours for ours in columns.values() if ours not in kinds()]:
        raise SceneError(
            f"--columns: no quantity is called {wrong[0]!r}: give one of {', '.join(kinds())}"
        )
    frame = frame.rename(columns=columns)
    if (twice := frame.columns[frame.columns.duplicated()]).size:
        raise SceneError(f"{name}, column {twice[0]!r}: it is there twice: give it once")
    quantities = [column for column in frame if column in QUANTITIES]
    needed = ["time", *(["radius"] if FIELDS.intersection(quantities) else [])]
    missing = [column for column in needed if column not in frame]
    if missing or not quantities:
        sought = [*missing, *([] if quantities else list(kinds())[2:])]
        alike = [
            f"{near[0]}={ours}"
            for ours in sought
            if (near := difflib.get_close_matches(ours, map(str, frame.columns), 1, 0.5))
        ]
        remedy = f"--columns {alike[0]}" if alike else "name them so, or by --columns theirs=ours"
        what = f"no column {missing[0]!r}" if missing else f"none of {', '.join(sought)}"
        raise SceneError(f"{name} has {what}; its columns are {heads}: {remedy}")
    return frame


def _checked(frame: pd.DataFrame, name: str, place: str) -> pd.DataFrame:
    """Return a table of numbers, each time and radius once."""
    table = frame.apply(pd.to_numeric, errors="coerce").astype(float)
    blank = frame.isna() | frame.astype(str).apply(lambda text: text.str.lower().isin(["", "nan"]))
    time, fields = table["time"], [column for column in table if column in FIELDS]
    checks = [
        (key, table[key].isna() & ~blank[key], "is no number: give one with a decimal point")
        for key in table
    ]
    checks += [
        (key, np.isinf(table[key]), "is infinite: leave it empty where there is no number")
        for key in table
    ]
    checks += [
        ("time", time.isna(), "is missing: give the time of each row"),
        ("time", time < 0, "is before the start: give the time since sliding began"),
    ]
    if "radius" in table:
        radius, given = table["radius"], table[fields].notna().any(axis=1)
        again = table.duplicated(["time", "radius"]) & given
        remedy = "is there twice at this time: give it once, beside an edge where pressure jumps"
        checks += [
            ("radius", radius < 0, "is negative: give the distance from the axis"),
            ("radius", radius.isna() & given, "is missing: give the radius of each row of a field"),
            ("radius", again, remedy),
        ]
    for key in table.columns.difference(["time", "radius", *fields]):
        first = table.groupby("time")[key].transform("first")
        differs = (table[key] != first) & table[key].notna()
        checks.append((key, differs, "is not the number given for this time before: give one"))
    for key, wrong, remedy in checks:
        if wrong.any():
            line = wrong.idxmax()
            raise SceneError(f"{name}, {place} {line}, column {key!r}: {frame[key][line]} {remedy}")
    results = table.columns.difference(["time", "radius"])
    if table[results].isna().all(axis=None):
        raise SceneError(f"{name}: no number in {', '.join(results)}: give some")
    return table
