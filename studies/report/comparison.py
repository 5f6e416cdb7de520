"""Two results beside each other: what differs between their scenes, and in their answers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ...meshes.errors import SceneError
from ..crosscheck.run import run
from ..methods.quantities import ANSWER, QUANTITIES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames
from .words import Rows


@dataclass(frozen=True, eq=False)
class Side:
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

    def curve(self, name: str) -> xarray.DataArray | None:
        """Return a quantity by the first method that gives all of it, if any does."""
        for solver in self.dataset.solver.values if name in self.dataset else ():
            values = self.dataset[name].sel(solver=solver)
            if values.size and np.isfinite(values).all():
                return values
        return None


def both(first: str, second: str) -> tuple[Side, Side]:
    """Return two sides in the same units.

    Raises
    ------
    SceneError
        if their units differ
    """
    sides = Side.of(first), Side.of(second)
    one, other = (UnitNames.of(side.scene.units) for side in sides)
    if one.base != other.base or (one.base is None and one.stated != other.stated):
        raise SceneError(
            f"units = {one.stated!r} and {other.stated!r} differ: compare scenes in the same units"
        )
    return sides


def scene_rows(a: Side, b: Side) -> Rows:
    """Return the keys of the scenes that differ."""
    first, second = _flat(a.scene.table()), _flat(b.scene.table())
    keys = [key for key in first | second if first.get(key) != second.get(key)]
    rows = [(key, _told(first.get(key)), _told(second.get(key))) for key in keys]
    return Rows(("key", "A", "B"), rows)


def answer_rows(a: Side, b: Side) -> Rows:
    """Return each number of the punch on both sides, and the relative difference."""
    names, rows = UnitNames.of(a.scene.units), []
    for name, quantity in (ANSWER | QUANTITIES).items():
        values = [side.curve(name) for side in (a, b)]
        if quantity.dims or all(value is None for value in values):
            continue
        first, second = (np.nan if value is None else float(value) for value in values)
        change = second / first - 1 if first else np.nan
        told = f"{100 * change:+.3g} %" if np.isfinite(change) else ""
        written = (names.write(value, quantity.unit) for value in (first, second))
        rows.append((name, *written, told))
    return Rows(("quantity", "A", "B", "B against A"), rows)


def _flat(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Return a nested table with keys as ``punch.radius``."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        nested = isinstance(value, dict)
        flat |= _flat(value, f"{before}{key}.") if nested else {f"{before}{key}": value}
    return flat


def _told(value: Any) -> str:
    text = "not given" if value is None else str(value)
    return text if len(text) <= 60 else f"{text[:56]} ..."
