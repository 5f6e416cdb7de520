"""Two results beside each other: what differs between their scenes, and in their answers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ...meshes.errors import SceneError
from ..crosscheck.answer import ALSO
from ..crosscheck.run import run
from ..methods.quantities import ANSWER, QUANTITIES
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames
from .words import Rows


@dataclass(frozen=True, eq=False)
class Side:
    """One of the two: a folder of results as it is, or a scene, run now."""

    name: str
    scene: Scene
    dataset: xarray.Dataset

    @classmethod
    def of(cls, source: str) -> "Side":
        """Results of a folder, or of a scene by its file or name.

        Raises
        ------
        SceneError
            if there is neither, or the folder holds no results that can be read
        """
        folder = Path(source)
        if not folder.is_dir():
            scene = Scene.load(source)
            return cls(scene.title or source, scene, run(scene).dataset)
        path = folder / "results.nc"
        if not path.exists():
            raise SceneError(
                f"{source} holds no results.nc: give a folder that `ringwear run` has written, or "
                "a scene"
            )
        try:
            with xarray.open_dataset(path, engine="netcdf4") as found:
                dataset = found.load()
            scene = Scene.from_toml(dataset.attrs["scene"], str(path))
        except (OSError, KeyError, ValueError) as error:
            raise SceneError(
                f"{path} cannot be read as results of ringwear: {error}; run the scene again"
            ) from None
        return cls(scene.title or source, scene, dataset)

    def value(self, name: str) -> float:
        """A number of the punch by the first method that gives it; NaN if none does."""
        values = self.dataset[name].values if name in self.dataset else np.array([np.nan])
        return float(next((value for value in values if np.isfinite(value)), np.nan))

    def curve(self, name: str) -> xarray.DataArray | None:
        """A quantity over time or radius by the first method that gives it, if any does."""
        for solver in self.dataset.solver.values if name in self.dataset else ():
            one = self.dataset[name].sel(solver=solver)
            if one.size and np.isfinite(one).all():
                return one
        return None


def both(first: str, second: str) -> tuple[Side, Side]:
    """Two sides in the same units.

    Raises
    ------
    SceneError
        if their units differ
    """
    one, other = Side.of(first), Side.of(second)
    if UnitNames.of(one.scene.units).base != UnitNames.of(other.scene.units).base or (
        one.scene.units != other.scene.units and UnitNames.of(one.scene.units).base is None
    ):
        raise SceneError(
            f"units = {one.scene.units!r} and {other.scene.units!r} differ: compare scenes in the "
            "same units"
        )
    return one, other


def scene_rows(one: Side, other: Side) -> Rows:
    """Keys of the scenes that differ."""
    first, second = _flat(one.scene.table()), _flat(other.scene.table())
    keys = [key for key in {**first, **second} if first.get(key) != second.get(key)]
    rows = [(key, _told(first.get(key)), _told(second.get(key))) for key in keys]
    return Rows(("key", "A", "B"), rows)


def answer_rows(one: Side, other: Side) -> Rows:
    """Each number of the punch on both sides, and the relative difference."""
    names, rows = UnitNames.of(one.scene.units), []
    units = {
        name: quantity.unit for name, quantity in (ANSWER | QUANTITIES).items() if not quantity.dims
    }
    for name in dict.fromkeys((*units, *ALSO)):
        a, b = one.value(name), other.value(name)
        if np.isfinite(a) or np.isfinite(b):
            change = (
                f"{100 * (b / a - 1):+.3g} %" if np.isfinite(a) and np.isfinite(b) and a else ""
            )
            rows.append((name, names.write(a, units[name]), names.write(b, units[name]), change))
    return Rows(("quantity", "A", "B", "B against A"), rows)


def _flat(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        found |= (
            _flat(value, f"{before}{key}.")
            if isinstance(value, dict)
            else {f"{before}{key}": value}
        )
    return found


def _told(value: Any) -> str:
    if value is None:
        return "not given"
    text = str(value)
    return text if len(text) <= 60 else f"{text[:56]} ..."
