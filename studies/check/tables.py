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
from ..decks.reports import NO_RESULTS, READERS, differing_keys, is_table
from ..tables.frame import MASK, Frame, surface_table
from ..tables.headings import KINDS, TIME, name_of
from ..tables.numbers import is_number
from .columns import known_columns

if TYPE_CHECKING:
    import xarray

# results of another program: a file, or a table in memory
OthersResults: TypeAlias = "str | Path | pd.DataFrame | xarray.Dataset"


COMPARED = ("pressure", "displacement", "profile", "indentation", "normal_force")
"""Columns that messages name as those that `check` compares."""
CLOCKS = ("distance", "cycles")
"""Columns that may take the place of times."""
FAR = 500.0
"""Largest radius, in punch radii, that is read without a unit: others may be in another unit."""


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
    more: Collection[str] = (),
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
    more : further columns that depend on time alone
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
    kinds = {"time": "time", "radius": "length"}
    kinds |= {
        key: quantity.unit
        for key, quantity in QUANTITIES.items()
        if {"time"} <= {*quantity.dims} <= {"time", "radius"} and key != "contact"
    }
    kinds |= {key: KINDS[without_number(key)] for key in (*more, *CLOCKS)}
    if not (isinstance(source, str | Path | pd.DataFrame) or hasattr(source, "to_dataframe")):
        raise SceneError(
            f"{name} is of type {type(source).__name__}: give a file, a pandas DataFrame or an "
            "xarray Dataset"
        )
    name = str(source) if isinstance(source, str | Path) else name
    frame = _frame_of(source, name, scene, columns, [*kinds], time)
    # arrays of a mesh are named already
    columns = {} if Path(name).suffix == ".vtu" else columns
    # a table with a column for each time, unless the user has chosen some of them
    if not any(TIME.fullmatch(theirs) for theirs in columns):
        frame = frame.long()
    known = known_columns(frame, kinds, columns)
    for remark in known.remarks:
        LOG.info("%s: %s", name, remark)
    values, heading_units = known.values, known.units
    if time is not None and not any(key in values for key in ("time", *CLOCKS)):
        values = values.assign(time=time)
    clock = next((key for key in ("time", *CLOCKS) if key in values), "time")
    if clock != "time":
        kinds["time"], heading_units["time"] = kinds[clock], heading_units.pop(clock, "")
    values = values.rename(columns={clock: "time"})
    absent = [theirs for theirs in columns if not frame.find(theirs)]
    _refuse_missing(frame, values, absent, known.others, wanted)
    written = known.written.rename(columns={clock: "time"})
    table = _validate(values, f"{name}, {frame.place}", clock, written)
    _report_missing(written, table, frame)
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
        stated = bool(units or heading_units.get("radius"))
        table = _on_face(table, scene, name, stated)
    return table


def _on_face(table: pd.DataFrame, scene: Scene, name: str, stated: bool) -> pd.DataFrame:
    """Return the rows of a table on the face of the punch; others are reported.

    Raises
    ------
    SceneError
        if there are none, or if radii without a unit are so large that they may be in another one
    """
    radius, rim, hole = table["radius"], scene.punch.radius, scene.punch.inner_radius
    remedy = (
        "give distances from the axis, with their unit in the heading, as in radius [mm]; or "
        "--units if they are not in the units of the scene"
    )
    # a radius that roundoff of units has moved beyond the rim is at the rim
    beyond, in_hole = radius > rim * (1 + 1e-9), radius < hole * (1 - 1e-9)
    far = radius.max() > FAR * rim and not stated
    if far or (beyond.any() and not ((radius > 0) & ~beyond).any()):
        power = 1000.0 ** np.round(np.log10(radius.max() / rim) / 3)
        unit = f" (the column radius seems to be {power:g} times ours: a unit)" * bool(power > 1)
        what = f"radii reach {radius.max() / rim:.4g} times" if far else "all radii are beyond"
        raise SceneError(f"{name}: {what} punch.radius = {rim:g}{unit}: {remedy}")
    if in_hole.all():
        raise SceneError(
            f"{name}: all radii are inside the hole, punch.inner_radius = {hole:g}: {remedy}"
        )
    for rows, where in ((beyond, "beyond the punch"), (in_hole, "within the hole")):
        if rows.any():
            LOG.warning("%s: %d rows %s are ignored", name, rows.sum(), where)
    return table.assign(radius=radius.clip(hole, rim))[~(beyond | in_hole)]


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
            f"{name} has cycles: give a column of times or distances; or the sliding distance of "
            "one cycle by --cycle, such as '20 mm' for a stroke of 10 mm to and fro"
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


def _frame_of(
    source: Any,
    name: str,
    scene: Scene,
    columns: Mapping[str, str],
    kinds: Collection[str],
    time: float | None,
) -> Frame:
    """Return the table in a file or in memory."""
    if isinstance(source, str | Path):
        path = Path(source)
        if path.suffix == ".vtu":
            return _read_surface(path, columns, time)
        source = _open(path, scene)
    if isinstance(source, Frame):
        return source
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
        return Frame.of_xarray(source[present], name)
    return Frame.of_pandas(source, name)


def _open(path: Path, scene: Scene) -> "pd.DataFrame | xarray.Dataset | Frame":
    """Return the dataset of a netCDF file, or the table of another file.

    A scene that differs from that of a deck is reported.
    """
    ending = path.suffix.lower()
    if ending in NO_RESULTS:
        raise SceneError(f"{path} {NO_RESULTS[ending]}")
    try:
        if ending in READERS and path.is_file() and not is_table(path):
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
                return read_folder(path.parent)[0].dataset
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
    return Frame.of_file(path)


def _read_surface(path: Path, columns: Mapping[str, str], only_time: float | None) -> Frame:
    """Return the results at the surface of a mesh in the plane of radius and depth.

    Names of point arrays consist of quantity and time: ``displacement t=0.5``, and ``pressure
    t=0.5`` or ``stress_zz t=0.5``; or they are names of a quantity alone, at the only time.
    """
    from ...meshes import read_with_meshio

    try:
        mesh = read_with_meshio(path)
    except MeshError as error:
        raise SceneError(f"{path} cannot be read: {error}") from None
    arrays = {columns.get(name, name): values for name, values in mesh.point_data.items()}
    timed = [name for name in arrays if TIME.fullmatch(name)]
    if timed:
        arrays = {name: arrays[name] for name in arrays if name in timed or name.lower() == MASK}
    frame = Frame.of_pandas(surface_table(mesh.points, arrays), str(path)).long()
    known = [name_of(each, FIELDS) for each in frame.cells.columns[1:]]
    if not any(known) or not (timed or only_time is not None):
        raise SceneError(
            f"{path} has no point array with a quantity and a time in its name; its arrays are "
            f"{', '.join(mesh.point_data) or 'none'}: give names such as 'pressure t=0.5'; "
            "or --time T if all are of one time; or --columns such as "
            "'U=displacement t=0.5,S22=stress_zz t=0.5'"
        )
    return frame


def _refuse_missing(
    frame: Frame,
    values: pd.DataFrame,
    absent: list[str],
    others: list[str],
    wanted: Sequence[str],
) -> None:
    """Refuse a table that lacks a necessary column, and report columns that are not read.

    Parameters
    ----------
    frame : the table
    values : its known columns, by our names
    absent : names of columns that the user has given, but the table does not have
    others : headings of the columns that are not known
    wanted : see `read`

    Raises
    ------
    SceneError
        with the name of the column, and the remedies
    """
    needed = ["time", "radius"] if FIELDS.intersection(values) else ["time"]
    missing = absent + [key for key in needed if key not in values]
    if not values.columns.difference(["time", "radius"]).size:
        missing.append(wanted[0])
    if not missing:
        if others:
            LOG.warning("%s: columns that are not read: %s", frame.name, ", ".join(others))
        return
    pairs = [(theirs, nearest(theirs, ["time", "radius", *wanted])) for theirs in others]
    renamed = ",".join(f"{theirs}={ours}" for theirs, ours in pairs if ours) or "theirs=ours"
    remedies = [
        f"give time, radius if there are fields, and some of {', '.join(wanted)}, each once, by "
        f"--columns {renamed} if necessary"
    ]
    if "time" in missing:
        remedies.append("or --time T if all rows are of one time")
    plain = {"" if is_number(each) else without_number(each) for each in others}
    if len(plain) < len(others):
        remedies.append("or, if it has a column for each time, a row for each time instead")
    if missing == ["radius"]:
        field = next(each for each in frame.cells if name_of(each, FIELDS))
        remedies.append(f"or, if it has one depth for each time, --columns '{field}=indentation'")
    raise (NoTimesError if missing == ["time"] else SceneError)(
        f"{frame.name} has no column {missing[0]!r}; its columns are {', '.join(frame.cells)}: "
        f"{'; '.join(remedies)}"
    )


def _validate(frame: pd.DataFrame, place: str, clock: str, written: pd.DataFrame) -> pd.DataFrame:
    """Return the table as numbers, with each time and radius once.

    Parameters
    ----------
    place : name of the table, and the word for its rows
    clock : name of the column that is read as times
    written : the cells as the other program has written them, for messages

    Raises
    ------
    SceneError
        if a cell is wrong; it names the first such line and the remedy
    """
    table = frame.astype(float)
    time, fields = table["time"], table[[key for key in table if key in FIELDS]]
    has_field, radius = fields.notna().any(axis=1), table.get("radius", 0 * time)
    places = pd.DataFrame({"time": time, "radius": radius}).mask(~has_field)
    repeated = has_field & places.duplicated()
    checks = [
        ("time", table["time"].isna(), f"give the {clock} of each row"),
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
        if key not in ("time", "radius", *fields):
            differs = table.groupby(time)[key].transform("nunique") > 1
            checks.append((key, differs, "give one number for each time"))
    for key, wrong, remedy in checks:
        if wrong.any():
            line = wrong.idxmax()
            column = clock if key == "time" else key
            cell = shown((written if key in written else frame)[key][line])
            raise SceneError(f"{place} {line}, column {column!r}: {cell}; {remedy}")
    if table.drop(columns=["time", "radius"], errors="ignore").isna().all(axis=None):
        raise SceneError(
            f"{place.rpartition(',')[0]} has no numbers other than times and radii: give some"
        )
    return table.dropna(axis="columns", how="all")


def _report_missing(written: pd.DataFrame, table: pd.DataFrame, frame: Frame) -> None:
    """Refuse columns in which a file has only NaN, and report those that lack numbers.

    A column that is empty was not filled in, as in a template; NaN is what a failed program writes.

    Parameters
    ----------
    written : the cells as the other program has written them
    table : the validated table, without columns that have no numbers
    frame : from which they were read

    Raises
    ------
    SceneError
        if a column has no numbers, but NaN in a file
    """
    if empty := [key for key in written if key not in table]:
        for key in empty:
            if frame.place == "line" and written[key].ne("").any():
                raise SceneError(
                    f"{frame.name}: column {key!r} has no numbers but NaN: give some, or leave it "
                    "out"
                )
        LOG.warning("%s has no numbers in: %s", frame.name, ", ".join(empty))
    fields = table[[key for key in table if key in FIELDS]]
    for key, missing in fields[fields.notna().any(axis=1)].isna().sum().items():
        if missing:
            LOG.warning("%s: %d rows of fields have no %s", frame.name, missing, key)
