"""Read tables of results of other programs, validate them, and convert them to a scene's units.

A table has a row for each time and radius (`time, radius, pressure, ...`), or for each time (`time,
indentation, normal_force`), or both: numbers that depend on time alone may be repeated at every
radius, or be in rows whose radius is empty. If a table is wrong, the error message names the file,
the line, the column and the remedy.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pandas as pd

from ...meshes import Array, MeshError, SceneError
from ..crosscheck import (
    CHECKSUMS,
    FIELDS,
    LOG,
    QUANTITIES,
    RESULTS,
    SUMMARY,
    Scene,
    UnitNames,
    has_checksums,
    nearest,
    one_line,
    read_folder,
    refuse_large,
    shown,
)
from ..decks.reports import NO_RESULTS, READERS, differing_keys, is_xy_report
from ..tables.text import read_numbers, read_texts, split_heading, text_of_file
from .columns import kind_of, our_name, over_radii, recognised

if TYPE_CHECKING:
    import xarray

# results of another program: a file, or a table in memory
OthersResults: TypeAlias = "str | Path | pd.DataFrame | xarray.Dataset"


COMPARED = ("pressure", "displacement", "profile", "indentation", "normal_force")
"""Columns that messages name as those that `check` compares."""
CLOCKS: Mapping[str, str] = {"distance": "distance", "cycles": "number"}
"""Columns that may take the place of times, each with the kind of its unit."""
LARGE = 200_000
"""Number of bytes above which a CSV file is read by `read_numbers`, if that is possible."""


class NoTimesError(SceneError):
    """A table has no column of times."""


def without_number(name: str) -> str:
    """Return the name of a file without the number at its end: out_0003.csv is out.csv."""
    return re.sub(r"[-_.]?\d+(?=\.\w+$|$)", "", name)


def are_steps(names: Collection[str]) -> bool:
    """Return whether names of files differ in a number at their end only."""
    return len(names) > 1 and len({without_number(name) for name in names}) == 1


def read(
    source: Any,
    name: str,
    scene: Scene,
    columns: Mapping[str, str],
    units: str,
    more: Mapping[str, str] | None = None,
    wanted: Sequence[str] = COMPARED,
    cycle: float | None = None,
    time: float | None = None,
) -> pd.DataFrame:
    """Return the validated results of another program, in the units of a scene.

    Sliding distances, or numbers of cycles, may take the place of times: `attrs["clock"]` says
    which of them the table has.

    Parameters
    ----------
    source : a file (CSV, netCDF, or VTU of a half-space; .dat of CalculiX or .rpt of Abaqus with
        their deck), a DataFrame, or an xarray Dataset; if it has several solvers, the first is read
    name : name of a table in memory in messages
    columns : our column names by theirs
    units : of the results, in the notation of a scene; if empty, those of the scene
    more : further columns that depend on time alone, each with the kind of its unit
    wanted : columns of which the table needs at least one, for messages
    cycle : sliding distance of one cycle, in the units of the scene
    time : of all rows, in the units of the table, if it has no column of times

    Raises
    ------
    SceneError
        if the table cannot be read or is wrong; it names the file, the line, the column and the
        remedy
    """
    if not isinstance(columns, Mapping):
        raise SceneError(
            f"columns = {shown(columns)}: give our names by theirs, such as {{'p': 'pressure'}}"
        )
    place = "row"
    kinds = {"time": "time", "radius": "length"}
    kinds |= {
        key: quantity.unit
        for key, quantity in QUANTITIES.items()
        if {"time"} <= {*quantity.dims} <= {"time", "radius"} and key != "contact"
    }
    kinds |= {**(more or {}), **CLOCKS}
    if not (isinstance(source, str | Path | pd.DataFrame) or hasattr(source, "to_dataframe")):
        raise SceneError(
            f"{name} is of type {type(source).__name__}: give a file, a pandas DataFrame or an "
            "xarray Dataset"
        )
    if isinstance(source, str | Path):
        name, place = str(source), "line"
        if Path(source).suffix == ".vtu":
            source, columns = _read_surface(Path(source), columns, time), {}
        else:
            source = _open(Path(source), scene)
    if hasattr(source, "to_dataframe"):
        if "solver" in source.dims:
            source = source.isel(solver=0)
            LOG.info("%s: the results of %s are read", name, source["solver"].item())
        # numbers of each ring or mode are no columns
        present = [
            key
            for key, values in source.items()
            if columns.get(key, key) in kinds and not {"ring", "mode"} & {*values.dims}
        ]
        source = source[present].reset_coords(drop=True).to_dataframe()
    if source.index.names != [None]:
        source = source.reset_index()
    named = _columns_named(source, columns)
    renamed, heading_units = _rename_headings(source, columns, named, kinds)
    missing = [theirs for theirs, headings in named.items() if not headings]
    headings = ", ".join(map(str, source))
    renamed, on_grid = over_radii(renamed)
    try:
        renamed, more_units, read_as = recognised(renamed, kinds)
    except SceneError as error:
        raise SceneError(f"{name}: {error}") from None
    renamed, on_sides = over_radii(renamed)
    heading_units |= more_units
    for remark in (*on_grid, *read_as, *on_sides):
        LOG.info("%s: %s", name, remark)
    if time is not None and not any(key in renamed for key in ("time", *CLOCKS)):
        renamed = renamed.assign(time=time)
    clock = next((key for key in ("time", *CLOCKS) if key in renamed), "time")
    if clock != "time":
        renamed = renamed.rename(columns={clock: "time"})
        kinds["time"], heading_units["time"] = CLOCKS[clock], heading_units.pop(clock, "")
    known = [key for key in kinds if key not in CLOCKS]
    frame = _select_columns(renamed, name, headings, missing, known, wanted)
    table = _validate(frame, f"{name}, {place}", clock)
    _report_missing(frame, table, name)
    scene_units = scene.unit_names
    if units and scene_units.base is None:
        raise SceneError(f"--units {units}: the scene's numbers have none: give the scene's units")
    table_units = scene_units
    if units:
        table_units = UnitNames.of(units, scene.load_.times_are_distances)
    for key in table:
        kind, unit = kinds[key], heading_units.get(key, "")
        size = table_units.size(kind) / scene_units.size(kind)
        if unit and scene_units.base is None:
            LOG.warning(
                "%s: the unit of %s is ignored, because the numbers of the scene have no units",
                name,
                key,
            )
        elif unit:
            size = scene_units.size_of(unit, kind, f"{name}, the heading of {key}")
        table[key] *= size
    table["time"] = _times(table["time"], clock, scene, cycle, name)
    table.attrs["clock"] = clock
    if "radius" in table:
        radius, rim = table["radius"], scene.punch.radius
        # a radius that roundoff of units has moved beyond the rim is at the rim
        beyond = radius > rim * (1 + 1e-9)
        if beyond.any() and not ((radius > 0) & ~beyond).any():
            power = 1000.0 ** np.round(np.log10(radius.max() / rim) / 3)
            unit = f" (the column radius seems to be {power:g} times ours: a unit)"
            unit = unit if power > 1 else ""
            raise SceneError(
                f"{name}: all radii are beyond punch.radius = {rim:g}: give distances from the "
                f"axis, and --units if they are not in the units of the scene{unit}"
            )
        if beyond.any():
            LOG.warning("%s: %d rows beyond the punch are ignored", name, beyond.sum())
        hole = scene.punch.inner_radius
        in_hole = radius < hole * (1 - 1e-9)
        if in_hole.all():
            raise SceneError(
                f"{name}: all radii are inside the hole, punch.inner_radius = {hole:g}: give "
                "distances from the axis, and --units if they are not in the units of the scene"
            )
        if in_hole.any():
            LOG.warning("%s: %d rows within the hole are ignored", name, in_hole.sum())
        table = table.assign(radius=radius.clip(hole, rim))[~(beyond | in_hole)]
    return table


def _times(
    values: "pd.Series[float]", clock: str, scene: Scene, cycle: float | None, name: str
) -> Array:
    """Return the times at which a scene reaches the values of a column: its clock.

    Raises
    ------
    SceneError
        if the values are cycles of an unknown length, or if the punch does not slide so far
    """
    numbers = values.to_numpy(dtype=float)
    if clock == "time":
        return numbers
    if clock == "cycles" and cycle is None:
        raise SceneError(
            f"{name} has cycles: give the sliding distance of one cycle by --cycle, such as "
            "'20 mm' for a stroke of 10 mm to and fro; or give a column of times or distances"
        )
    distances = numbers * (cycle or 1.0) if clock == "cycles" else numbers
    problem, speed = scene.problem, scene.load_.speed_over_time.greatest
    unit = problem.units.time
    times = problem.loading.times_at(distances / (speed * unit)) * unit
    if np.isnan(times).any():
        raise SceneError(
            f"{name}: the punch of the scene never slides as far as {np.nanmax(distances):.4g}: "
            "give load.sliding_speed for longer, or shorter distances"
        )
    return times


def _columns_named(frame: pd.DataFrame, columns: Mapping[str, str]) -> dict[str, list[object]]:
    """Return the headings of a table that the user means by each name.

    A name is a whole heading, or a heading without its unit in upper or lower case. The list is
    empty if the table has no such column.
    """
    named = dict[str, list[object]]()
    for theirs in columns:
        exact = [heading for heading in frame if str(heading) == theirs]
        without_unit = split_heading(theirs)[0]
        named[theirs] = exact or [
            heading for heading in frame if split_heading(str(heading))[0] == without_unit
        ]
    return named


def _rename_headings(
    frame: pd.DataFrame,
    columns: Mapping[str, str],
    named: Mapping[str, list[object]],
    kinds: Mapping[str, str],
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return a table whose known headings are replaced by our names, and the units in them.

    Columns that the user has named, or that already have our name, keep it.

    Parameters
    ----------
    columns : our names by those of the user
    named : the headings that the user means, by these names
    """
    names = {heading: columns[theirs] for theirs, headings in named.items() for heading in headings}
    units = {
        name: unit
        for heading, name in names.items()
        if (unit := split_heading(str(heading))[1]) and name in kinds
    }
    taken_names = {names.get(heading, str(heading)) for heading in frame}
    for heading in frame:
        name, unit = our_name(str(heading)), split_heading(str(heading))[1]
        if name not in kinds or heading in names:
            continue
        if str(heading) == name or name not in taken_names:
            names[heading] = name
            taken_names.add(name)
            if unit:
                units[name] = unit
    return frame.rename(columns=names), units


def _open(path: Path, scene: Scene) -> "pd.DataFrame | xarray.Dataset":
    """Return the dataset of a netCDF file, or the table of another file.

    A CSV table has texts or numbers, and is indexed by line number. A scene that differs from that
    of a deck is reported.
    """
    ending = path.suffix.lower()
    if ending in NO_RESULTS:
        raise SceneError(f"{path} {NO_RESULTS[ending]}")
    try:
        if ending in READERS and path.is_file() and not is_xy_report(path):
            results = READERS[ending](path)
            if keys := differing_keys(path, scene):
                LOG.warning(
                    "%s has the results of another scene: %s differs in %s",
                    path,
                    path.parent / "scene.toml",
                    ", ".join(keys),
                )
            return results
        if path.suffix == ".nc":
            import xarray

            if path.name == RESULTS and has_checksums(path.parent):
                return read_folder(path.parent)[0]
            with xarray.open_dataset(path) as data:
                refuse_large(path, data.nbytes)
                if CHECKSUMS in data.attrs:
                    LOG.warning("%s could not be checked: %s is not beside it", path, SUMMARY)
                return data.load()
    except (OSError, ValueError) as error:
        reason = one_line(error)
        if path.suffix == ".nc" and "engine" in str(error):
            # xarray lists the packages that it has tried
            reason = "it is not netCDF"
        raise SceneError(
            f"{path} cannot be read: {reason}; give CSV in UTF-8, or netCDF in a file that ends "
            "in .nc"
        ) from None
    if path.is_file() and path.stat().st_size > LARGE:
        table = read_numbers(path)
        if table is not None:
            return table
    return read_texts(path, text_of_file(path))


def _read_surface(
    path: Path, columns: Mapping[str, str], only_time: float | None = None
) -> pd.DataFrame:
    """Return the results at the surface of a mesh in the plane of radius and height.

    Names of point arrays consist of quantity and time: ``displacement t=0.5``, and ``pressure
    t=0.5`` or ``stress_zz t=0.5``; or they are names of a quantity alone, at the only time. Vectors
    are read by their second component.
    """
    from ...meshes import read_with_meshio

    try:
        mesh = read_with_meshio(path)
    except MeshError as error:
        raise SceneError(f"{path} cannot be read: {error}") from None
    radius, height = mesh.points.T[:2]
    surface = np.abs(height) <= 1e-9 * np.ptp(height)
    # sign of the direction into the half-space
    inward = np.sign(height.mean())
    tables = []
    for array_name, values in mesh.point_data.items():
        quantity, _, label = columns.get(array_name, array_name).partition(" t=")
        time = np.nan if only_time is None else only_time
        if label:
            time = pd.to_numeric(label, errors="coerce")
        if values.ndim == 2 and values.shape[1] in (2, 3):
            values = inward * values[:, 1]
        quantity = our_name(quantity)
        kind = kind_of(quantity)
        if quantity not in FIELDS and kind is not None:
            # stresses are negative where they press
            values = -values if kind.name == "pressure" and kind.signed else values
            quantity = kind.name
        if quantity in ("displacements", "disp", "displ"):
            quantity = "displacement"
        if np.isfinite(time) and quantity in FIELDS:
            rows = {"time": time, "radius": radius[surface], "value": values[surface]}
            tables.append(pd.DataFrame(rows | {"quantity": quantity}))
    if not tables:
        raise SceneError(
            f"{path} has no point array with a quantity and a time in its name; its arrays are "
            f"{', '.join(mesh.point_data) or 'none'}: give --time T if all are of one time, or "
            "--columns such as 'U=displacement t=0.5,S22=stress_zz t=0.5'"
        )
    values = pd.concat(tables).groupby(["time", "radius", "quantity"])["value"].first()
    return values.unstack().reset_index()


def _select_columns(
    frame: pd.DataFrame,
    name: str,
    headings: str,
    missing: list[str],
    our_names: list[str],
    wanted: Sequence[str],
) -> pd.DataFrame:
    """Return the columns that we know.

    Parameters
    ----------
    frame : whose columns have our names, if we know them
    name : of the table
    headings : of the table itself, for messages
    missing : names of columns that the user has given, but the table does not have

    Raises
    ------
    SceneError
        if a necessary column is missing, or if a column occurs twice
    """
    unknown = [str(key) for key in frame if key not in our_names]
    frame = frame[[key for key in frame if key in our_names]]
    needed = ["time", "radius"] if FIELDS.intersection(frame) else ["time"]
    missing = missing + [key for key in needed if key not in frame]
    if not frame.columns.difference(["time", "radius"]).size:
        missing.append(wanted[0])
    if missing or not frame.columns.is_unique:
        fault = f"no column {missing[0]!r}" if missing else "a column twice"
        pairs = [(theirs, nearest(theirs, ["time", "radius", *wanted])) for theirs in unknown]
        renamed = ",".join(f"{theirs}={ours}" for theirs, ours in pairs if ours)
        only_times = missing == ["time"]
        raise (NoTimesError if only_times else SceneError)(
            f"{name} has {fault}; its columns are {headings}: give time, radius if there are "
            f"fields, and some of {', '.join(wanted)}, each once, by --columns "
            f"{renamed or 'theirs=ours'} if necessary"
            + ("; or --time T if all rows are of one time" if "time" in missing else "")
        )
    if unknown:
        LOG.warning("%s: columns that are not read: %s", name, ", ".join(unknown))
    return frame


def _validate(frame: pd.DataFrame, place: str, clock: str) -> pd.DataFrame:
    """Return the table as numbers, with each time and radius once.

    Parameters
    ----------
    place : name of the table, and the word for its rows
    clock : name of the column that is read as times

    Raises
    ------
    SceneError
        if a cell is wrong; it names the first such line and the remedy
    """
    table = frame.apply(pd.to_numeric, errors="coerce").astype(float)
    blank = frame.isna() | frame.isin(["", "nan", "NaN"])
    time, fields = table["time"], table[[key for key in table if key in FIELDS]]
    has_field, radius = fields.notna().any(axis=1), table.get("radius", 0 * time)
    places = pd.DataFrame({"time": time, "radius": radius}).mask(~has_field)
    repeated = has_field & places.duplicated()
    checks = [
        ("time", blank["time"], f"give the {clock} of each row"),
        ("time", time < 0, f"give the {clock} since sliding began, 0 or more"),
        ("radius", radius < 0, "give the distance from the axis, 0 or more"),
        ("radius", radius.isna() & has_field, "give the radius of each row of a field"),
        (
            "radius",
            repeated,
            "give each radius once for each time; where pressure jumps, give radii on both sides",
        ),
    ]
    for key in table:
        checks.insert(0, (key, np.isinf(table[key]), "leave it empty where the value is infinite"))
        checks.insert(0, (key, table[key].isna() & ~blank[key], "give a number, such as 0.5"))
        if key not in ("time", "radius", *fields):
            differs = table.groupby(time)[key].transform("nunique") > 1
            checks.append((key, differs, "give one number for each time"))
    for key, wrong, remedy in checks:
        if wrong.any():
            line = wrong.idxmax()
            column = clock if key == "time" else key
            cell = shown(frame[key][line])
            raise SceneError(f"{place} {line}, column {column!r}: {cell}; {remedy}")
    if table.drop(columns=["time", "radius"], errors="ignore").isna().all(axis=None):
        raise SceneError(
            f"{place.rpartition(',')[0]} has no numbers other than times and radii: give some"
        )
    return table.dropna(axis="columns", how="all")


def _report_missing(frame: pd.DataFrame, table: pd.DataFrame, name: str) -> None:
    """Refuse columns in which a file has only NaN, and report those that lack numbers.

    A column that is empty was not filled in, as in a template; NaN is what a failed program writes.

    Parameters
    ----------
    frame, table : before and after validation, which leaves out columns without numbers

    Raises
    ------
    SceneError
        if a column has no numbers, but NaN in a file
    """
    if empty := [key for key in frame if key not in table]:
        for key in empty:
            if frame[key].isin(["nan", "NaN"]).any():
                raise SceneError(
                    f"{name}: column {key!r} has no numbers but NaN: give some, or leave it out"
                )
        LOG.warning("%s has no numbers in: %s", name, ", ".join(empty))
    fields = table[[key for key in table if key in FIELDS]]
    for key, missing in fields[fields.notna().any(axis=1)].isna().sum().items():
        if missing:
            LOG.warning("%s: %d rows of fields have no %s", name, missing, key)
