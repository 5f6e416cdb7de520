"""Read measurements of a wearing punch from tables in the formats of `check`."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...meshes import SceneError
from ..check.tables import NoTimesError, OthersResults, by_name, read
from ..crosscheck import LOG, Scene, number_of, shown
from ..estimate.measurement import Measurement
from ..estimate.model import is_flat
from ..tables.headings import KINDS

if TYPE_CHECKING:
    from pandas import DataFrame

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
    length, volume_density = (
        None if given is None else _positive_number(scene, given, kind, key)
        for given, kind, key in ((cycle, "length", "--cycle"), (density, "density", "--density"))
    )
    remedy = "give files, DataFrames or Datasets, one, several, or by name"
    by_source = dict[str, list[Measurement]]()
    for name, source in by_name(data, "data", remedy).items():
        source = _without_known(source, scene)
        more = (*VOLUMES, *SCARS)
        try:
            table = read(source, name, scene, columns or {}, units, more, FITTED, length)
        except NoTimesError as error:
            raise SceneError(
                f"{error}; if the force varies, give it over time in the scene, load.normal_force"
            ) from None
        _refuse_unsuitable(table, name, scene, parameters)
        if volume_density is None and "lost_mass" in map(_without_ring, table):
            raise SceneError(
                f"{name} has lost_mass, whose volume needs a density: give --density, such as "
                "'7.8 g/cm^3'"
            )
        in_table = _measurements(table, volume_density or 1.0)
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
    measurements = [each for in_table in by_source.values() for each in in_table]
    by_column = _noises(noise, {each.column for each in measurements})
    return tuple(
        _with_noise(scene, each, by_column.get(each.column), volume_density or 1.0)
        for each in measurements
    )


def _without_known(source: "OthersResults", scene: Scene) -> "OthersResults":
    """Return results of ringwear without what the scene itself determines, else the same table."""
    dataset: Any = source
    if "solver" not in getattr(source, "coords", ()):
        return source
    return dataset.drop_vars(scene.problem.known, errors="ignore")


def _refuse_unsuitable(
    table: "DataFrame", name: str, scene: Scene, parameters: Sequence[str]
) -> None:
    """Refuse a table that cannot belong to the scene, or that does not depend on a parameter.

    Raises
    ------
    SceneError
        if the sliding speed is fitted to distances; if the contact of a flat punch has a radius,
        which is that of its face, whatever wears; if depths fall steadily, although neither the
        force nor wear does; or if the punch does not have a ring. It gives the remedy
    """
    if table.attrs["clock"] != "time" and "load.sliding_speed" in parameters:
        raise SceneError(
            f"load.sliding_speed: {name} has {table.attrs['clock']} in place of times, so that its "
            "values do not depend on the speed: leave this parameter out, or give times"
        )
    scars = [column for column in SCARS if column in table]
    if scars and is_flat(scene.problem):
        raise SceneError(
            f"{name} has {scars[0]}, but the punch of the scene is flat, so that all of its face "
            "is in contact, whatever wears: give punch.profile, such as { kind = 'ball', "
            "ball_radius = ... }, or other columns"
        )
    if "indentation" in table and scene.problem.loading.rising:
        times, depths = table[["time", "indentation"]].dropna().sort_values("time").to_numpy().T
        vary = len(depths) > 1 and np.ptp(depths) and np.ptp(times)
        if vary and np.corrcoef(times, depths)[0, 1] < REVERSED:
            raise SceneError(
                f"{name}: indentation falls from {depths[0]:.4g} to {depths[-1]:.4g}, but rises "
                "while a punch wears: reversed sign? Give depths, positive downwards"
            )
    rings = len(scene.problem.wear_coefficients)
    for column in table:
        base, number = _without_ring(column), _ring(column)
        if number is not None and not 0 <= number < rings:
            existing = f"{base}_1" if rings == 1 else f"{base}_1 to {base}_{rings}"
            raise SceneError(
                f"{name} has {column}, but the rings of the punch are numbered from 1 at the "
                f"centre to {rings}: give {existing}, or {base} for the whole punch"
            )


def _what_to_give(table: "DataFrame") -> str:
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


def _ring(column: str) -> int | None:
    """Return the index of the ring of a column, from 0; None if it is of the whole punch."""
    number = column.removeprefix(_without_ring(column))
    return int(number[1:]) - 1 if number else None


def _measurements(table: "DataFrame", density: float) -> list[Measurement]:
    """Return the measurements of one table without noise, with masses converted to volumes."""
    measurements = list[Measurement]()
    for column in table:
        base = _without_ring(column)
        rows = table.dropna(subset=[column])
        late = rows[rows["time"] > 0]
        if base in VOLUMES and len(late) and (late[column] < 0).all():
            raise SceneError(
                f"all values of {column} are negative: give what has been lost since the start, as "
                "positive numbers"
            )
        by_time = [series for _, series in late.groupby("time")]
        if base != "profile":
            numbers = late if base in VOLUMES else rows
            by_time = [numbers.groupby("time").first().reset_index()]
        for series in by_time if base in FITTED else ():
            if len(series):
                values = series[column].to_numpy() / (density if base == "lost_mass" else 1.0)
                measurements.append(
                    Measurement(
                        base,
                        "worn_volume" if base in VOLUMES else base,
                        series["time"].to_numpy(),
                        values,
                        np.ones(len(values)),
                        False,
                        series["radius"].to_numpy() if base == "profile" else None,
                        _ring(column),
                    )
                )
    return measurements


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


def _noises(noise: NoiseInput, columns: set[str]) -> Mapping[str, float | str]:
    """Return the noise of each column that has one."""
    if noise is None:
        return {}
    if not isinstance(noise, Mapping):
        if len(columns) > 1:
            raise SceneError(
                f"--noise {noise}: the columns are {', '.join(sorted(columns))}: give a noise for "
                "each, such as --noise indentation=2e-7,profile=1e-6"
            )
        return dict.fromkeys(columns, noise)
    if unknown := set(noise) - columns:
        raise SceneError(
            f"--noise of {min(unknown)}: the data has no such column: give noises of "
            f"{', '.join(sorted(columns))}"
        )
    return noise


def _with_noise(
    scene: Scene, measurement: Measurement, given: float | str | None, density: float
) -> Measurement:
    """Return a measurement with its noise.

    Parameters
    ----------
    scene : whose units a noise has
    given : absolute, or relative in per cent; None if it is estimated from the residuals
    density : by which an absolute noise of masses is divided, like the masses

    Raises
    ------
    SceneError
        if there are too few values to estimate the noise, if they are equal, or if a relative noise
        is 0
    """
    column, values = measurement.column, measurement.values
    volumes, key = measurement.quantity == "worn_volume", f"--noise {column}"
    if given is None:
        if len(values) < MIN_VALUES and not volumes:
            raise SceneError(
                f"{column} has too few values, {len(values)}, to estimate the noise: give {key}=..."
            )
        # the initial noise of volumes is relative to each value, otherwise to the range
        spread = values if volumes else np.ptp(values)
        if not np.all(spread):
            raise SceneError(
                f"the noise of {column} cannot be estimated, because its values are equal or 0: "
                f"give {key}=..."
            )
        return replace(measurement, noise=INITIAL_NOISE * np.abs(spread) * np.ones(len(values)))
    if isinstance(given, str) and given.strip().endswith("%"):
        part = 0.01 * _positive_number(scene, given.strip()[:-1], "share", key)
        noise = part * np.abs(values)
        if not noise.all():
            raise SceneError(
                f"{key} in per cent: a value is 0, so its noise would be 0: give a number in place "
                "of per cent"
            )
    else:
        absolute = _positive_number(scene, given, KINDS[column], key)
        noise = absolute / (density if column == "lost_mass" else 1.0) * np.ones(len(values))
    return replace(measurement, noise=noise, noise_known=True)
