"""Read measurements of a wearing punch from tables in the formats of `check`."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from ..check.tables import NoTimesError, OthersResults, read
from ..crosscheck import LOG, Scene, number_of, shown
from ..estimate.measurement import Measurement
from ..estimate.model import is_flat
from ..tables.headings import KINDS

NoiseInput = float | str | Mapping[str, float | str] | None
"""Standard deviations of the data: one, or several by column. Each is a number in the units of the
scene, or a text such as "2 um" or, relative to each value, "1 %"."""

# columns that can be fitted
FITTED = (
    "indentation",
    "normal_force",
    "profile",
    "contact_radius",
    "scar_diameter",
    "worn_volume",
    "lost_mass",
)
VOLUMES = ("worn_volume", "lost_mass")
# columns that depend on wear only if the contact grows
SCARS = ("contact_radius", "scar_diameter")
# correlation with time below which depths fall
REVERSED = -0.9
# number of rings whose columns are recognised
MOST_RINGS = 1000
# initial noise, over the range of a series or over each volume, if it is estimated from residuals
INITIAL_NOISE = 0.01
# least number of values in a series whose noise is estimated from the residuals
MIN_VALUES = 5


def read_measurements(
    scene: Scene,
    data: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
    noise: NoiseInput = None,
    density: float | str | None = None,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    cycle: float | str | None = None,
    parameters: Sequence[str] = (),
) -> tuple[Measurement, ...]:
    """Return the measurements in files or tables.

    Parameters
    ----------
    scene : in whose units the measurements are returned
    data : one or several files or tables, or these by name
    noise : standard deviations; estimated from the residuals if none is given
    density : of the punch, which is necessary for lost mass: a number, or a text such as
        "7.8 g/cm^3"
    columns : our column names by those of the data
    units : of the data, if not those of the scene
    cycle : sliding distance of one cycle, which is necessary for cycles in place of times
    parameters : names of the parameters that will be fitted to the measurements

    Raises
    ------
    SceneError
        if a table cannot be read, has no column to fit, needs a density or a noise, or does not
        depend on a parameter
    """
    rings = len(scene.problem.wear_coefficients)
    # columns of rings that the punch does not have are read, too, and then refused by their names
    more = [*VOLUMES, *(f"{name}_{ring}" for name in VOLUMES for ring in range(MOST_RINGS)), *SCARS]
    length = None
    if cycle is not None:
        length = _positive_number(scene, cycle, "length", "--cycle")
    measurements, divisors = list[Measurement](), list[float]()
    by_source = dict[str, list[Measurement]]()
    for name, source in _sources_by_name(data).items():
        source = _without_known(source, scene)
        try:
            table = read(source, name, scene, columns or {}, units, more, FITTED, length)
        except NoTimesError as error:
            raise SceneError(
                f"{error}; if the force varies, give it over time in the scene, load.normal_force"
            ) from None
        _refuse_speed(table, name, parameters)
        _refuse_scars(table, name, scene)
        _refuse_reversed(table, name, scene)
        _refuse_other_rings(table, name, rings)
        divisor = _density(scene, density, table, name)
        in_table = _measurements(table, divisor)
        unused = [
            key
            for key in table
            if key not in ("time", "radius") and _without_ring(key) not in FITTED
        ]
        if not in_table:
            raise SceneError(f"{name} has nothing to fit: {_what_to_give(table)}")
        if unused:
            LOG.warning("%s: columns that are not fitted: %s", name, ", ".join(unused))
        _refuse_repeated(by_source, name, in_table)
        by_source[name] = in_table
        measurements += in_table
        divisors += [divisor if each.column == "lost_mass" else 1.0 for each in in_table]
    by_column = _noises(scene, noise, {each.column for each in measurements})
    return tuple(
        _with_noise(each, by_column.get(each.column), divisor)
        for each, divisor in zip(measurements, divisors, strict=True)
    )


def _without_known(source: "OthersResults", scene: Scene) -> "OthersResults":
    """Return results of ringwear without what the scene itself determines, else the same table."""
    dataset: Any = source
    if "solver" not in getattr(source, "coords", ()):
        return source
    return dataset.drop_vars(scene.problem.known, errors="ignore")


def _sources_by_name(
    data: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
) -> "dict[str, OthersResults]":
    is_table = hasattr(data, "to_dataframe") or hasattr(data, "columns")
    # a Dataset is a mapping, too
    if isinstance(data, Mapping) and not is_table:
        tables = (str, Path, Mapping)
        named = [isinstance(each, tables) or hasattr(each, "columns") for each in data.values()]
        # else the columns of one table
        if any(named) or not data:
            return {str(name): source for name, source in data.items()}
        try:
            return {"data": pd.DataFrame(data)}
        except ValueError:
            raise SceneError(
                f"{shown(data)} is no table: give files, DataFrames or Datasets, one, several, or "
                "by name"
            ) from None
    if is_table or isinstance(data, str | Path) or not isinstance(data, Sequence):
        data = [data]
    by_name = dict[str, OthersResults]()
    for number, source in enumerate(data, 1):
        name = str(source) if isinstance(source, str | Path) else f"data {number}"
        if name in by_name:
            raise SceneError(f"{name} and {name} are one file: give each table once")
        by_name[name] = source
    return by_name


def _refuse_speed(table: "pd.DataFrame", name: str, parameters: Sequence[str]) -> None:
    """Refuse to fit the sliding speed to a table over distances.

    Raises
    ------
    SceneError
        with the remedy
    """
    if table.attrs["clock"] != "time" and "load.sliding_speed" in parameters:
        raise SceneError(
            f"load.sliding_speed: {name} has {table.attrs['clock']} in place of times, so that its "
            "values do not depend on the speed: leave this parameter out, or give times"
        )


def _refuse_scars(table: "pd.DataFrame", name: str, scene: Scene) -> None:
    """Refuse radii of contacts that are the whole face of the punch, whatever wears.

    Raises
    ------
    SceneError
        with the remedy
    """
    for column in SCARS:
        if column in table and is_flat(scene.problem):
            raise SceneError(
                f"{name} has {column}, but the punch of the scene is flat, so that all of its face "
                "is in contact, whatever wears: give punch.profile, such as { kind = 'ball', "
                "ball_radius = ... }, or other columns"
            )


def _refuse_reversed(table: "pd.DataFrame", name: str, scene: Scene) -> None:
    """Refuse depths that fall steadily, although neither the force nor wear does.

    Raises
    ------
    SceneError
        with the first and the last depth
    """
    if "indentation" not in table or not scene.problem.loading.rising:
        return
    times, depths = table[["time", "indentation"]].dropna().sort_values("time").to_numpy().T
    vary = len(depths) > 1 and np.ptp(depths) and np.ptp(times)
    if vary and np.corrcoef(times, depths)[0, 1] < REVERSED:
        raise SceneError(
            f"{name}: indentation falls from {depths[0]:.4g} to {depths[-1]:.4g}, but rises while "
            "a punch wears: reversed sign? Give depths, positive downwards"
        )


def _refuse_other_rings(table: "pd.DataFrame", name: str, rings: int) -> None:
    """Refuse columns of rings that the punch does not have.

    Raises
    ------
    SceneError
        with the column, and with the columns of the rings that there are
    """
    for column in table:
        number = re.search(r"_(\d+)$", column)
        if number and not 1 <= int(number[1]) <= rings:
            base = _without_ring(column)
            existing = f"{base}_1" if rings == 1 else f"{base}_1 to {base}_{rings}"
            raise SceneError(
                f"{name} has {column}, but the rings of the punch are numbered from 1 at the "
                f"centre to {rings}: give {existing}, or {base} for the whole punch"
            )


def _what_to_give(table: "pd.DataFrame") -> str:
    """Return what a table needs that has nothing to fit."""
    late_columns = [key for key in table if _without_ring(key) in (*VOLUMES, "profile")]
    if late_columns:
        return f"{', '.join(late_columns)} is given only at the start: give later times"
    return f"give columns of {', '.join(FITTED)}"


def _refuse_repeated(
    by_source: Mapping[str, list[Measurement]], name: str, measurements: list[Measurement]
) -> None:
    """Refuse a table whose measurements are those of an earlier one: they would count twice.

    A short series may repeat another one by chance, such as that of two equal weighings, so that
    short ones are refused only if they are everything that the table has.

    Raises
    ------
    SceneError
        with the names of both tables
    """
    for other, others in by_source.items():
        repeated = [each for each in measurements if any(each.repeats(one) for one in others)]
        if len(repeated) == len(measurements) == len(others) or any(
            len(each.values) >= MIN_VALUES for each in repeated
        ):
            columns = ", ".join(dict.fromkeys(each.column for each in repeated))
            raise SceneError(
                f"{other} and {name} have the same {columns}, which would count twice: give each "
                "measurement once"
            )


def _without_ring(column: str) -> str:
    """Return the name of a column without the number of its ring."""
    return re.sub(r"_\d+$", "", column)


def _measurements(table: "pd.DataFrame", density: float) -> list[Measurement]:
    """Return the measurements of one table, with masses converted to volumes."""
    measurements = list[Measurement]()
    for column in table:
        base = _without_ring(column)
        if base not in FITTED:
            continue
        rows = table.dropna(subset=[column])
        if base == "profile":
            for time, profile in rows[rows["time"] > 0].groupby("time"):
                times, radii = np.full(len(profile), float(time)), profile["radius"].to_numpy()
                heights = profile[column].to_numpy()
                measurements.append(_without_noise("profile", "profile", times, heights, radii))
            continue
        series = rows.groupby("time")[column].first()
        times, values = series.index.to_numpy(dtype=float), series.to_numpy(dtype=float)
        number = re.search(r"_(\d+)$", column)
        ring = int(number[1]) - 1 if number else None
        quantity = base
        if base in ("worn_volume", "lost_mass"):
            after_start, quantity = times > 0, "worn_volume"
            times, values = times[after_start], values[after_start]
            if len(values) and (values < 0).all():
                raise SceneError(
                    f"all values of {column} are negative: give what has been lost since the "
                    "start, as positive numbers"
                )
            values = values / density if base == "lost_mass" else values
        if len(times):
            measurements.append(_without_noise(base, quantity, times, values, None, ring))
    return measurements


def _without_noise(
    column: str,
    quantity: str,
    times: Array,
    values: Array,
    radii: Array | None,
    ring: int | None = None,
) -> Measurement:
    return Measurement(column, quantity, times, values, np.ones(len(times)), False, radii, ring)


def _density(scene: Scene, density: float | str | None, table: "pd.DataFrame", name: str) -> float:
    """Return the density in the units of the scene; 1 if the table has no lost mass."""
    value = None if density is None else _positive_number(scene, density, "density", "--density")
    if not any(_without_ring(column) == "lost_mass" for column in table):
        return 1.0
    if value is None:
        raise SceneError(
            f"{name} has lost_mass, whose volume needs a density: give --density, such as "
            "'7.8 g/cm^3'"
        )
    return value


def _positive_number(scene: Scene, text: float | str, kind: str, key: str) -> float:
    """Return a number, or a quantity with a unit of a kind, in the units of the scene.

    Raises
    ------
    SceneError
        if it is not finite and above 0; it names the key
    """
    try:
        value = float(text)
    except TypeError:
        raise SceneError(
            f"{key} = {shown(text)}: give a number, or a text such as '2 um'"
        ) from None
    except ValueError:
        value = number_of(str(text), key, kind, scene.unit_names)
    if not (value > 0 and np.isfinite(value)):
        raise SceneError(f"{key} = {text}: give a number above 0")
    return value


def _noises(scene: Scene, noise: NoiseInput, columns: set[str]) -> dict[str, tuple[float, float]]:
    """Return the absolute and the relative noise of each column, one of which is 0."""
    if noise is None:
        return {}
    if not isinstance(noise, Mapping):
        if len(columns) > 1:
            raise SceneError(
                f"--noise {noise}: the columns are {', '.join(sorted(columns))}: give a noise for "
                "each, such as --noise indentation=2e-7,profile=1e-6"
            )
        noise = dict.fromkeys(columns, noise)
    if unknown := set(noise) - columns:
        raise SceneError(
            f"--noise of {min(unknown)}: the data has no such column: give noises of "
            f"{', '.join(sorted(columns))}"
        )
    noises = dict[str, tuple[float, float]]()
    for column, text in noise.items():
        key = f"--noise {column}"
        if isinstance(text, str) and text.strip().endswith("%"):
            per_cent = _positive_number(scene, text.strip()[:-1], "share", key)
            noises[column] = 0.0, 0.01 * per_cent
        else:
            noises[column] = _positive_number(scene, text, KINDS[column], key), 0.0
    return noises


def _with_noise(
    measurement: Measurement, noises: tuple[float, float] | None, divisor: float
) -> Measurement:
    """Return a measurement with its noise.

    Parameters
    ----------
    noises : absolute and relative noise; None if the noise is estimated from the residuals
    divisor : number by which an absolute noise is divided: the density for masses, else 1

    Raises
    ------
    SceneError
        if there are too few values to estimate the noise, if they are equal, or if a relative noise
        is 0
    """
    values = measurement.values
    if noises is None:
        if len(values) < MIN_VALUES and measurement.quantity != "worn_volume":
            raise SceneError(
                f"{measurement.column} has too few values, {len(values)}, to estimate the noise: "
                f"give --noise {measurement.column}=..."
            )
        # the initial noise of volumes is relative to each value, otherwise to the range
        spread = values if measurement.quantity == "worn_volume" else np.ptp(values)
        if not np.all(spread):
            raise SceneError(
                f"the noise of {measurement.column} cannot be estimated, because its values are "
                f"equal or 0: give --noise {measurement.column}=..."
            )
        return replace(measurement, noise=INITIAL_NOISE * np.abs(spread) * np.ones(len(values)))
    absolute, relative = noises
    noise = np.where(absolute > 0, absolute / divisor, relative * np.abs(values))
    if not (noise > 0).all():
        raise SceneError(
            f"--noise {measurement.column} in per cent: a value is 0, so its noise would be 0: "
            "give a number in place of per cent"
        )
    return replace(measurement, noise=noise, noise_known=True)
