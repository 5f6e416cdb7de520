"""Results of other programs as tables: read, checked, and brought to a scene's units.

A table has a row for each time and radius (`time, radius, pressure, ...`), or for each time (`time,
indentation, normal_force`), or both: what goes by time alone may be repeated at every radius, or
stand in rows whose radius is empty. What is wrong is refused in a line that names the file, the
line, the column and the remedy.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pandas as pd

from ...meshes.errors import MeshError, SceneError
from ..decks.reports import READERS
from ..predictions.memory import refuse_large
from ..problem.fields import refuse_device
from ..problem.quantities import FIELDS, QUANTITIES
from ..problem.unit_names import UnitNames, size_of_unit
from ..progress import LOG
from ..scene.scene import Scene
from .csv_files import name_and_unit, read_csv_text, read_numbers

if TYPE_CHECKING:
    import xarray

# a file, or a table in memory
OthersResults: TypeAlias = "str | Path | pd.DataFrame | xarray.Dataset"


LARGE = 200_000
"""Characters from which on a CSV file is read as numbers at once, if it has nothing else."""


def read(
    source: Any,
    name: str,
    scene: Scene,
    columns: Mapping[str, str],
    units: str,
    more: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Return results of another program, checked and in the units of a scene.

    Parameters
    ----------
    source : a file (CSV, netCDF, or VTU of a half-space), a DataFrame, or an xarray Dataset, of
        several solvers the first
    name : what messages call a table that is no file
    columns : names of ours by theirs
    units : of theirs, as a scene states them; those of the scene if empty
    more : further columns that go by time alone, each with the kind of its unit

    Raises
    ------
    SceneError
        naming the file, the line, the column and the remedy
    """
    place = "row"
    kinds = {"time": "time", "radius": "length"}
    kinds |= {
        key: of.unit
        for key, of in QUANTITIES.items()
        if {"time"} <= {*of.dims} <= {"time", "radius"} and key != "contact"
    }
    kinds |= more or {}
    if isinstance(source, str | Path):
        name, place = str(source), "line"
        if Path(source).suffix == ".vtu":
            source, columns = _surface(Path(source), columns), {}
        else:
            source = _open(Path(source))
    if hasattr(source, "to_dataframe"):
        if "solver" in source.dims:
            source = source.isel(solver=0)
            LOG.info("%s: results of %s are taken", name, source["solver"].item())
        given = [key for key in source if columns.get(key, key) in kinds]
        source = source[given].reset_coords(drop=True).to_dataframe()
    if source.index.names != [None]:
        source = source.reset_index()
    source, of_headings = _with_our_headings(source, columns, kinds)
    frame = _named(source, name, columns, list(kinds))
    table = _checked(frame, f"{name}, {place}")
    stated = UnitNames.of(scene.units)
    if units and stated.base is None:
        raise SceneError(f"--units {units}: the scene's numbers have none: give its units")
    for key in table:
        kind, unit = kinds[key], of_headings.get(key, "")
        theirs = UnitNames.of(units or scene.units).size(kind)
        if unit and stated.base is None:
            LOG.warning("%s: the unit of %s is not read, for the scene has none", name, key)
        elif unit:
            theirs = size_of_unit(unit, kind, f"{name}, the heading of {key}")
        table[key] *= theirs / stated.size(kind)
    if "radius" in table:
        radius, rim = table["radius"], scene.punch.radius
        # what roundoff of units has moved beyond the rim is on it
        beyond = radius > rim * (1 + 1e-9)
        if beyond.any() and not ((radius > 0) & ~beyond).any():
            raise SceneError(
                f"{name}: all radii lie beyond punch.radius = {rim:g}: give distances from the "
                "axis, and --units if theirs are not the scene's"
            )
        if beyond.any():
            LOG.warning("%s: %d rows beyond the punch are left out", name, beyond.sum())
        hole = scene.punch.inner_radius
        within = radius < hole * (1 - 1e-9)
        if within.all():
            raise SceneError(
                f"{name}: all radii lie within the hole of radius punch.inner_radius = {hole:g}: "
                "give distances from the axis, and --units if theirs are not the scene's"
            )
        if within.any():
            LOG.warning("%s: %d rows within the hole are left out", name, within.sum())
        table = table.assign(radius=radius.clip(hole, rim))[~(beyond | within)]
    return table


def _with_our_headings(
    frame: pd.DataFrame, columns: Mapping[str, str], kinds: Mapping[str, str]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return a table with our names where headings mean them, and the units of these headings.

    What the user names, and what has our name already, stays.
    """
    names, units = dict[object, str](), dict[str, str]()
    taken = {columns.get(str(heading), str(heading)) for heading in frame}
    for heading in frame:
        name, unit = name_and_unit(str(heading))
        if name not in kinds or str(heading) in columns:
            continue
        if str(heading) == name or name not in taken:
            names[heading] = name
            taken.add(name)
            if unit:
                units[name] = unit
    return frame.rename(columns=names), units


def _open(path: Path) -> "pd.DataFrame | xarray.Dataset":
    """Return a dataset of a netCDF file, or a CSV table of text by the numbers of its lines."""
    try:
        if path.suffix in READERS and path.is_file():
            return READERS[path.suffix](path)
        if path.suffix == ".nc":
            import xarray

            with xarray.open_dataset(path) as data:
                refuse_large(path, data)
                return data.load()
        refuse_device(path)
        text = path.read_text("utf-8-sig")
    except (OSError, ValueError) as error:
        raise SceneError(
            f"{path} cannot be read: {getattr(error, 'strerror', None) or error}; give CSV in "
            "UTF-8, or netCDF in a file that ends in .nc"
        ) from None
    table = read_numbers(path, text) if len(text) > LARGE else None
    return read_csv_text(path, text) if table is None else table


def _surface(path: Path, columns: Mapping[str, str]) -> pd.DataFrame:
    """Return what stands at the surface of a mesh in the plane of radius and height.

    Arrays of the points are called by quantity and time: ``displacement t=0.5``, and ``pressure
    t=0.5`` or ``stress_zz t=0.5``. Of vectors the second component is taken.
    """
    from ...meshes.files import read_with_meshio  # with it come scikit-fem and meshio

    try:
        mesh = read_with_meshio(path)
    except MeshError as error:
        raise SceneError(f"{path} cannot be read: {error}") from None
    radius, height = mesh.points.T[:2]
    surface = np.abs(height) <= 1e-9 * np.ptp(height)
    into = np.sign(height.mean())
    tables = []
    for theirs, values in mesh.point_data.items():
        quantity, _, label = columns.get(theirs, theirs).partition(" t=")
        time = pd.to_numeric(label, errors="coerce")
        if values.ndim == 2:
            values = into * values[:, 1]
        if quantity == "stress_zz":
            quantity, values = "pressure", -values
        if np.isfinite(time) and quantity in FIELDS:
            here = {"time": time, "radius": radius[surface], "value": values[surface]}
            tables.append(pd.DataFrame(here | {"quantity": quantity}))
    if not tables:
        raise SceneError(
            f"{path} has no arrays of a time among {', '.join(mesh.point_data) or 'none'}: give "
            "those that are, as in --columns 'U=displacement t=0.5,S22=stress_zz t=0.5'"
        )
    whole = pd.concat(tables).groupby(["time", "radius", "quantity"])["value"].first()
    return whole.unstack().reset_index()


def _named(
    frame: pd.DataFrame, name: str, columns: Mapping[str, str], ours: list[str]
) -> pd.DataFrame:
    """Return the columns that we have, by our names."""
    heads = ", ".join(map(str, frame))
    absent = [theirs for theirs in columns if theirs not in frame]
    frame = frame.rename(columns=columns)
    left = [str(key) for key in frame if key not in ours]
    frame = frame[[key for key in frame if key in ours]]
    needed = ["time", "radius"] if FIELDS.intersection(frame) else ["time"]
    absent += [key for key in needed if key not in frame]
    if not frame.columns.difference(["time", "radius"]).size:
        absent.append("pressure")
    if absent or not frame.columns.is_unique:
        what = f"no column {absent[0]!r}" if absent else "a column twice"
        raise SceneError(
            f"{name} has {what}: of {heads} give each of time, radius, pressure, displacement, "
            "profile, indentation, normal_force once, by --columns theirs=ours if need be"
        )
    if left:
        LOG.warning("%s: not read: %s", name, ", ".join(left))
    return frame


def _checked(frame: pd.DataFrame, place: str) -> pd.DataFrame:
    """Return numbers, each time and radius once."""
    table = frame.apply(pd.to_numeric, errors="coerce").astype(float)
    blank = frame.isna() | frame.isin(["", "nan", "NaN"])
    time, fields = table["time"], table[[key for key in table if key in FIELDS]]
    given, radius = fields.notna().any(axis=1), table.get("radius", 0 * time)
    again = given & pd.DataFrame({"time": time, "radius": radius}).mask(~given).duplicated()
    checks = [
        ("time", blank["time"], "give the time of each row"),
        ("time", time < 0, "give the time since sliding began, 0 or more"),
        ("radius", radius < 0, "give the distance from the axis, 0 or more"),
        ("radius", radius.isna() & given, "give the radius of each row of a field"),
        ("radius", again, "give each radius once in a time, beside an edge where pressure jumps"),
    ]
    for key in table:
        checks.insert(0, (key, np.isinf(table[key]), "leave it empty where it is infinite"))
        checks.insert(0, (key, table[key].isna() & ~blank[key], "give a number, as 0.5"))
        if key not in ("time", "radius", *fields):
            differs = table.groupby(time)[key].transform("nunique") > 1
            checks.append((key, differs, "give one number for each time"))
    for key, wrong, remedy in checks:
        if wrong.any():
            line = wrong.idxmax()
            raise SceneError(f"{place} {line}, column {key!r}: {frame[key][line]!r}; {remedy}")
    if table.drop(columns=["time", "radius"], errors="ignore").isna().all(axis=None):
        raise SceneError(f"{place.rpartition(',')[0]} has no number but times and radii: give some")
    return table.dropna(axis="columns", how="all")
