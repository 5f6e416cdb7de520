"""Two results beside each other: what differs between their scenes, and in their answers."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray

from ...meshes.errors import SceneError
from ..crosscheck.run import run
from ..problem.quantities import ANSWER, QUANTITIES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames


class Side(NamedTuple):
    """One of the two: a folder of results as it is, or a scene, run now."""

    scene: Scene
    dataset: xarray.Dataset

    @classmethod
    def of(cls, source: str) -> "Side":
        """Read the results of a folder, or compute a scene by its file or name.

        Raises
        ------
        SceneError
            if there is neither, or the folder holds no results that can be read
        """
        if not Path(source).is_dir():
            scene = Scene.load(source)
            return cls(scene, run(scene).dataset)
        path = Path(source) / "results.nc"
        try:
            dataset = xarray.load_dataset(path, engine="netcdf4")
            return cls(Scene.from_toml(dataset.attrs["scene"], str(path)), dataset)
        except (OSError, KeyError, ValueError) as error:
            raise SceneError(
                f"{path} cannot be read as results of ringwear: {error}; give a folder that "
                "`ringwear run` has written, or a scene"
            ) from None

    def number(self, name: str) -> float:
        """Return a number of the punch by the first method that gives it; NaN if none does."""
        values = self.dataset[name].values if name in self.dataset else np.empty(0)
        return float(next(iter(values[np.isfinite(values)]), np.nan))


def both(first: str, second: str) -> tuple[Side, Side]:
    """Return two sides in the same units.

    Raises
    ------
    SceneError
        if their units differ
    """
    a, b = Side.of(first), Side.of(second)
    stated = [side.scene.units for side in (a, b)]
    bases = [UnitNames.of(units).base for units in stated]
    if bases[0] != bases[1] or (bases[0] is None and stated[0] != stated[1]):
        raise SceneError(
            f"units = {stated[0]!r} and {stated[1]!r} differ: compare scenes in the same units"
        )
    return a, b


def scene_rows(a: Side, b: Side) -> pd.DataFrame:
    """Return the keys of the scenes that differ."""
    tables = [pd.json_normalize(side.scene.table()).iloc[0].astype(str) for side in (a, b)]
    table = pd.concat(tables, axis=1, keys=["A", "B"]).fillna("not given")
    return table[table.A != table.B].map(_cut).rename_axis("key").reset_index()


def answer_rows(a: Side, b: Side) -> pd.DataFrame:
    """Return each number of the punch on both sides, and the relative difference."""
    names, rows = UnitNames.of(a.scene.units), []
    for name, quantity in (ANSWER | QUANTITIES).items():
        first, second = a.number(name), b.number(name)
        if quantity.dims or np.isnan([first, second]).all():
            continue
        change = second / first - 1 if first else np.nan
        rows.append(
            {
                "quantity": name,
                "A": names.write(first, quantity.unit),
                "B": names.write(second, quantity.unit),
                "B against A": f"{100 * change:+.3g} %" if np.isfinite(change) else "",
            }
        )
    return pd.DataFrame(rows)


def _cut(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:56]} ..."
