"""Measurements of a wearing punch, read from tables as `check` reads them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..check.tables import OthersResults, read
from ..problem.unit_names import UnitNames, number_of
from ..progress import LOG
from ..scene.scene import Scene
from .measurement import Measurement

if TYPE_CHECKING:
    import pandas as pd

NoiseGiven = float | str | Mapping[str, float | str] | None
"""One noise, or noises by column: numbers in the scene's units, or texts such as "2 um", "1 %"."""

# columns that can be fitted, and the kind of their unit
KINDS = {
    "indentation": "displacement",
    "normal_force": "force",
    "profile": "displacement",
    "worn_volume": "volume",
    "lost_mass": "mass",
}
# a part of the range of a column: what its noise is taken for until residuals tell it
FIRST_NOISE = 0.01
# numbers that a column must have for its residuals to tell its noise
FEWEST = 5


def read_measurements(
    scene: Scene,
    data: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
    noise: NoiseGiven = None,
    density: float | str | None = None,
    columns: Mapping[str, str] | None = None,
    units: str = "",
) -> tuple[Measurement, ...]:
    """Return the measurements in files or tables.

    Parameters
    ----------
    scene : whose units they are brought to
    data : one or several files or tables, or these by name
    noise : standard deviations; from the residuals where none is given
    density : of the punch, which lost mass needs: a number, or a text such as "7.8 g/cm^3"
    columns : our names by theirs
    units : of theirs, if not the scene's

    Raises
    ------
    SceneError
        if a table cannot be read, has nothing to fit, or needs a density or a noise
    """
    rings = range(1, len(scene.problem.wear_coefficients) + 1)
    volumes = {name: KINDS[name] for name in ("worn_volume", "lost_mass")}
    volumes |= {f"{name}_{ring}": kind for name, kind in volumes.items() for ring in rings}
    measurements, divisors = list[Measurement](), list[float]()
    for name, source in _named(data).items():
        table = read(source, name, scene, columns or {}, units, volumes)
        divisor = _density(scene, density, table, name)
        found = _measurements(table, divisor)
        left = [key for key in table if key not in ("time", "radius") and _base(key) not in KINDS]
        if left:
            LOG.warning("%s: not fitted: %s", name, ", ".join(left))
        if not found:
            raise SceneError(f"{name} has nothing to fit: give columns of {', '.join(KINDS)}")
        measurements += found
        divisors += [divisor if each.column == "lost_mass" else 1.0 for each in found]
    by_column = _noises(scene, noise, {each.column for each in measurements})
    return tuple(
        _with_noise(each, by_column.get(each.column), divisor)
        for each, divisor in zip(measurements, divisors, strict=True)
    )


def _named(
    data: "Mapping[str, OthersResults] | Sequence[OthersResults] | OthersResults",
) -> "dict[str, OthersResults]":
    if isinstance(data, Mapping):
        return dict(data)
    if isinstance(data, str | Path) or hasattr(data, "to_dataframe") or hasattr(data, "columns"):
        data = [data]
    files = {f"data {number}": each for number, each in enumerate(data, 1)}
    return {str(of) if isinstance(of, str | Path) else name: of for name, of in files.items()}


def _base(column: str) -> str:
    """Return the name of a column without the number of its ring."""
    return re.sub(r"_\d+$", "", column)


def _measurements(table: "pd.DataFrame", density: float) -> list[Measurement]:
    """Return the measurements of one table; volumes in place of masses."""
    found = list[Measurement]()
    for column in table:
        base = _base(column)
        if base not in KINDS:
            continue
        rows = table.dropna(subset=[column])
        if base == "profile":
            for time, at in rows[rows["time"] > 0].groupby("time"):
                times, radii = np.full(len(at), float(time)), at["radius"].to_numpy()
                found.append(_given("profile", "profile", times, at[column].to_numpy(), radii))
            continue
        series = rows.groupby("time")[column].first()
        times, values = series.index.to_numpy(dtype=float), series.to_numpy(dtype=float)
        number = re.search(r"_(\d+)$", column)
        ring = int(number[1]) - 1 if number else None
        quantity = base
        if base in ("worn_volume", "lost_mass"):
            worn, quantity = times > 0, "worn_volume"
            times, values = times[worn], values[worn]
            values = values / density if base == "lost_mass" else values
        if len(times):
            found.append(_given(base, quantity, times, values, None, ring))
    return found


def _given(
    column: str,
    quantity: str,
    times: Array,
    values: Array,
    radii: Array | None,
    ring: int | None = None,
) -> Measurement:
    return Measurement(column, quantity, times, values, np.ones(len(times)), False, radii, ring)


def _density(scene: Scene, given: float | str | None, table: "pd.DataFrame", name: str) -> float:
    """Return the density in the units of the scene; 1 if nothing was weighed."""
    if not any(_base(column) == "lost_mass" for column in table):
        return 1.0
    if given is None:
        raise SceneError(
            f"{name} has lost_mass, and a volume takes a density: give --density, such as "
            "'7.8 g/cm^3'"
        )
    return _number(scene, given, "density", "--density")


def _number(scene: Scene, given: float | str, kind: str, key: str) -> float:
    """Return a positive number, or a quantity of a kind, in the units of a scene."""
    try:
        value = float(given)
    except ValueError:
        value = number_of(str(given), key, kind, UnitNames.of(scene.units))
    if not (value > 0 and np.isfinite(value)):
        raise SceneError(f"{key} = {given}: give a number above 0")
    return value


def _noises(scene: Scene, noise: NoiseGiven, columns: set[str]) -> dict[str, tuple[float, float]]:
    """Return the noise of columns as an absolute and a relative part, one of which is 0."""
    if noise is None:
        return {}
    if not isinstance(noise, Mapping):
        if len(columns) > 1:
            raise SceneError(
                f"--noise {noise}: the data has {', '.join(sorted(columns))}: give a noise for "
                "each, such as --noise indentation=2e-7,profile=1e-6"
            )
        noise = dict.fromkeys(columns, noise)
    if unknown := set(noise) - columns:
        raise SceneError(
            f"--noise of {min(unknown)}: the data has no such column: give some of "
            f"{', '.join(sorted(columns))}"
        )
    found = dict[str, tuple[float, float]]()
    for column, given in noise.items():
        key = f"--noise {column}"
        if isinstance(given, str) and given.strip().endswith("%"):
            found[column] = 0.0, 0.01 * _number(scene, given.strip()[:-1], "share", key)
        else:
            found[column] = _number(scene, given, KINDS[column], key), 0.0
    return found


def _with_noise(
    measurement: Measurement, given: tuple[float, float] | None, divisor: float
) -> Measurement:
    """Return a measurement with its noise; `divisor` turns the unit of that into its own."""
    values = measurement.values
    if given is None:
        if len(values) < FEWEST and measurement.quantity != "worn_volume":
            raise SceneError(
                f"{len(values)} values of {measurement.column} do not tell their noise: give "
                f"--noise {measurement.column}=..."
            )
        # volumes are known to a part of each; anything else to a part of its range
        spread = values if measurement.quantity == "worn_volume" else np.ptp(values)
        return replace(measurement, noise=FIRST_NOISE * np.abs(spread) * np.ones(len(values)))
    absolute, relative = given
    noise = np.where(absolute > 0, absolute / divisor, relative * np.abs(values))
    if not (noise > 0).all():
        raise SceneError(
            f"--noise {measurement.column} in per cent: a value is 0, of which nothing is known so "
            "well: give a number in place of per cent"
        )
    return replace(measurement, noise=noise, noise_known=True)
