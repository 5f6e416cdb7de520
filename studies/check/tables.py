"""Read tables of results of other programs, validate them, and convert them to a scene's units.

A table has a row for each time and radius (`time, radius, pressure, ...`), or for each time (`time,
indentation, normal_force`), or both: numbers that depend on time alone may be repeated at every
radius, or be in rows whose radius is empty. If a table is wrong, the error message names the file,
the line, the column and the remedy.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pandas as pd

from ...meshes import Array, MeshError, RingwearError, SceneError
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
from ..decks.reports import results_of_deck
from ..tables.columns import known_columns
from ..tables.frame import MASK, Frame, surface_table
from ..tables.headings import KINDS, TIME, name_of
from ..tables.numbers import is_number

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


def by_name(
    given: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
    alone: str,
    remedy: str,
) -> "dict[str, OthersResults]":
    """Return results of other programs, or measurements, by their names.

    Parameters
    ----------
    given : by names, or one or several, which are named after their files
    alone : name of a table in memory that has none
    remedy : what to give instead of what is no table

    Raises
    ------
    SceneError
        if they are no files or tables, or if a file is given twice
    """
    no_table = SceneError(f"{shown(given)} is no table: {remedy}")
    is_table = hasattr(given, "to_dataframe") or hasattr(given, "columns")
    # a Dataset is a mapping, too
    if isinstance(given, Mapping) and given and not is_table:
        kinds = (str, Path, Mapping)
        if any(isinstance(each, kinds) or hasattr(each, "columns") for each in given.values()):
            return {str(name): each for name, each in given.items()}
        # else the columns of one table
        try:
            return {alone: pd.DataFrame(given)}
        except ValueError:
            raise no_table from None
    if is_table:
        return {alone: given}
    sources = [given] if isinstance(given, str | Path) else given
    if not isinstance(sources, list | tuple) or not sources:
        raise no_table
    named = dict[str, OthersResults]()
    for number, source in enumerate(sources, 1):
        name = str(source) if isinstance(source, str | Path) else f"{alone} {number}"
        if name in named:
            raise SceneError(f"{name} and {name} are one file: give each table once")
        named[name] = source
    return named


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
    if not (isinstance(source, str | Path | pd.DataFrame) or hasattr(source, "to_dataframe")):
        raise SceneError(
            f"{name} is of type {type(source).__name__}: give a file, a pandas DataFrame or an "
            "xarray Dataset"
        )
    known = {
        *("time", "radius", *CLOCKS, *more),
        *(
            key
            for key, quantity in QUANTITIES.items()
            if {"time"} <= {*quantity.dims} <= {"time", "radius"} and key != "contact"
        ),
    }
    frame = _frame_of(source, name, scene, columns, known, time)
    # arrays of a mesh are named already
    columns = {} if Path(frame.name).suffix == ".vtu" else columns
    # a table with a column for each time, unless the user has chosen some of them
    if not any(TIME.fullmatch(theirs) for theirs in columns):
        frame = frame.long()
    ours, remarks, others = known_columns(frame, known, columns)
    for remark in remarks:
        LOG.info("%s: %s", frame.name, remark)
    clock = next((key for key in ("time", *CLOCKS) if key in ours.values), "time")
    if clock not in ours.values and time is not None:
        ours = replace(ours, values=ours.values.assign(time=time))
    absent = [theirs for theirs in columns if not frame.find(theirs)]
    present = {"time" if key == clock else key for key in ours.values}
    _refuse_missing(frame, present, absent, others, wanted)
    table = _validate(ours, clock)
    names = scene.unit_names
    if units and names.base is None:
        raise SceneError(f"--units {units}: the scene's numbers have none: give the scene's units")
    given = UnitNames.of(units, scene.load_.times_are_distances) if units else names
    for key in table:
        kind = QUANTITIES[key].unit if key in QUANTITIES else KINDS[without_number(key)]
        unit = ours.units.get(key, "")
        size = given.size(kind) / names.size(kind)
        if unit and names.base is None:
            LOG.warning(
                "%s: the unit of %s is ignored, because the numbers of the scene have no units",
                frame.name,
                key,
            )
        elif unit:
            size = names.size_of(unit, kind, f"{frame.name}, the heading of {key}")
        table[key] *= size
    table[clock] = _times(table[clock], clock, scene, cycle, frame.name)
    table = table.rename(columns={clock: "time"})
    table.attrs["clock"] = clock
    if "radius" in table:
        table = _on_face(table, scene, frame.name, bool(units or ours.units.get("radius")))
    return table


def _on_face(table: pd.DataFrame, scene: Scene, name: str, stated: bool) -> pd.DataFrame:
    """Return the rows of a table on the face of the punch; others are reported.

    Raises
    ------
    SceneError
        if there are none, or if radii without a unit are so large that they may be in another one
    """
    radius, rim, hole = table["radius"], scene.punch.radius, scene.punch.inner_radius
    # a radius that roundoff of units has moved beyond the rim is at the rim
    outside = (radius > rim * (1 + 1e-9)) | (radius < hole * (1 - 1e-9))
    far = radius.max() > FAR * rim and not stated
    if far or (outside.any() and not ((radius > 0) & ~outside).any()):
        power = 1000.0 ** np.round(np.log10(radius.max() / rim) / 3)
        unit = f" (the column radius seems to be {power:g} times ours: a unit)" * bool(power > 1)
        what = f"radii reach {radius.max() / rim:.4g} times" if far else "all radii are beyond"
        raise SceneError(
            f"{name}: {what} punch.radius = {rim:g}{', or in its hole' * bool(hole)}{unit}: give "
            "distances from the axis, with their unit in the heading, as in radius [mm]; or "
            "--units if they are not in the units of the scene"
        )
    if outside.any():
        where = "beyond the punch, or in its hole," if hole else "beyond the punch"
        LOG.warning("%s: %d rows %s are ignored", name, outside.sum(), where)
    return table.assign(radius=radius.clip(hole, rim))[~outside]


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
    known: Collection[str],
    time: float | None,
) -> Frame:
    """Return the table in a file or in memory."""
    if isinstance(source, str | Path):
        path, name = Path(source), str(source)
        if path.suffix == ".vtu":
            return _read_surface(path, columns, time)
        source = _dataset(path) if path.suffix == ".nc" else results_of_deck(path, scene)
        if source is None:
            return Frame.of_file(path)
    if isinstance(source, pd.DataFrame):
        return Frame.of_pandas(source, name)
    if "solver" in source.dims:
        source = source.isel(solver=0)
        LOG.info("%s: the results of %s are read", name, source["solver"].item())
    # numbers of each ring or mode are no columns
    present = [
        key
        for key, values in source.items()
        if columns.get(key, key) in known and not {"ring", "mode"} & {*values.dims}
    ]
    if not present:
        raise SceneError(
            f"{name} has no variables over time, or over time and radius, that are known; it has "
            f"{', '.join(map(str, source)) or 'none'}: give {', '.join(COMPARED)}, if necessary by "
            "--columns theirs=ours"
        )
    return Frame.of_xarray(source[present], name)


def _dataset(path: Path) -> "xarray.Dataset":
    """Return the dataset of a netCDF file."""
    import xarray

    try:
        if path.name == RESULTS and has_checksums(path.parent):
            return read_folder(path.parent)[0].dataset
        with path.open("rb") as file:
            classic = file.read(4) in (b"CDF\1", b"CDF\2")
        # the library of netCDF-4 ends the program at some faults of older files
        with xarray.open_dataset(path, engine="scipy" if classic else None) as data:
            refuse_large(path, data.nbytes)
            if CHECKSUMS in data.attrs:
                LOG.warning("%s could not be checked: %s is not beside it", path, SUMMARY)
            return data.load()
    except RingwearError:
        raise
    except Exception as error:  # readers of older files raise many
        # xarray lists the packages that it has tried
        reason = "it is not netCDF" if "engine" in str(error) else one_line(error)
        raise SceneError(
            f"{path} cannot be read: {reason}; give CSV in UTF-8, or netCDF in a file that ends "
            "in .nc"
        ) from None


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
    present: Collection[str],
    absent: list[str],
    others: list[str],
    wanted: Sequence[str],
) -> None:
    """Refuse a table that lacks a necessary column, and report columns that are not read.

    Parameters
    ----------
    frame : the table
    present : our names of its known columns, with time if it has a clock
    absent : names of columns that the user has given, but the table does not have
    others : headings of the columns that are not known
    wanted : see `read`

    Raises
    ------
    SceneError
        with the name of the column, and the remedies
    """
    needed = ["time", "radius"] if FIELDS.intersection(present) else ["time"]
    missing = absent + [key for key in needed if key not in present]
    if not {*present} - {"time", "radius", *CLOCKS}:
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


def _validate(frame: Frame, clock: str) -> pd.DataFrame:
    """Return a table as numbers, with each time and radius once; gaps are reported.

    Parameters
    ----------
    frame : with our names of columns
    clock : name of the column that is read as times

    Raises
    ------
    SceneError
        if a cell is wrong, with its line and the remedy; or if a column has no numbers, but NaN in
        a file, as a failed program writes it, while an empty one was not filled in
    """
    table = frame.values
    time, fields = table[clock], table[[key for key in table if key in FIELDS]]
    has_field, radius = fields.notna().any(axis=1), table.get("radius", 0 * time)
    places = pd.DataFrame({"time": time, "radius": radius}).mask(~has_field)
    checks = [
        (key, np.isinf(table[key]), "leave it empty where the value is infinite") for key in table
    ]
    checks += [
        (clock, ~(time >= 0), f"give the {clock} since sliding began, 0 or more, in each row"),
        (
            "radius",
            (radius < 0) | (radius.isna() & has_field),
            "give the distance from the axis, 0 or more, in each row of a field",
        ),
        (
            "radius",
            has_field & places.duplicated(),
            "give each radius once for each time; where pressure jumps, give radii on both sides",
        ),
    ]
    numbers = table.drop(columns=[clock, "radius"], errors="ignore")
    checks += [
        (key, numbers.groupby(time)[key].transform("nunique") > 1, "give one number for each time")
        for key in numbers.columns.difference(fields.columns)
    ]
    for key, wrong, remedy in checks:
        if wrong.any():
            line = wrong.idxmax()
            cell = shown((frame.cells if key in frame.cells else table)[key][line])
            raise SceneError(
                f"{frame.name}, {frame.place} {line}, column {key!r}: {cell}; {remedy}"
            )
    if numbers.isna().all(axis=None):
        raise SceneError(f"{frame.name} has no numbers other than times and radii: give some")
    empty = [key for key in numbers if numbers[key].isna().all()]
    for key in empty:
        if frame.place == "line" and frame.cells[key].ne("").any():
            raise SceneError(
                f"{frame.name}: column {key!r} has no numbers but NaN: give some, or leave it out"
            )
    if empty:
        LOG.warning("%s has no numbers in: %s", frame.name, ", ".join(empty))
    for key, missing in fields.drop(columns=empty, errors="ignore")[has_field].isna().sum().items():
        if missing:
            LOG.warning("%s: %d rows of fields have no %s", frame.name, missing, key)
    return table.drop(columns=empty)
