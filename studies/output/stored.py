"""Results read back from the folder that they were written to."""

import json
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..anchors.anchor import Anchor
from ..crosscheck.agreement import Agreement
from ..crosscheck.promise import LeftOut
from ..outcome.outcome import Outcome
from ..outcome.scope import methods_of
from ..outcome.table import Table
from ..predictions.memory import refuse_large
from ..registry import METHODS
from ..scene.scene import Scene

# an object of `summary.json`
Json = dict[str, Any]
Row = TypeVar("Row", Agreement, Anchor)
Kind = TypeVar("Kind", bound="StoredOutcome")


@dataclass(frozen=True, eq=False, repr=False)
class StoredOutcome(Outcome):
    """Results that were written: all numbers, and the figures that need no more.

    Parameters
    ----------
    written : the table in `results.nc`
    told : the content of `summary.json`
    """

    written: Table
    told: Json

    @cached_property
    def table(self) -> Table:
        """The table in `results.nc`."""
        return self.written

    @property
    def summary(self) -> Json:
        """The content of `summary.json`."""
        return self.told

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results were checked."""
        return tuple(dict.fromkeys(row["solver"] for row in self.told.get("verdicts", [])))

    @property
    def verdict(self) -> str:
        """The verdict that was written: `agree`, `disagree` or `undecided`."""
        return str(self.told["verdict"])

    @cached_property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that could not be promised, with the times and the reason."""
        rows = self.told.get("left_out_of_promise", [])
        return tuple(LeftOut(**row | {"times": tuple(row["times"])}) for row in rows)

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes that the methods gave."""
        return tuple(self.told["notes"])

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """What a user asked of the punch, by method, and the relative errors of these numbers."""
        return {
            name: {key: np.array(value, dtype=float) for key, value in given.items()}
            for name, given in self.told["answer"].items()
        }

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method was checked against."""
        return _rebuilt(Anchor, self.told["anchors"])


def _rebuilt(kind: type[Row], rows: list[Json]) -> tuple[Row, ...]:
    """Return rows of `summary.json` as what they were."""
    names = [field.name for field in fields(kind)]
    return tuple(kind(*(row[name] for name in names)) for row in rows)


def load(folder: str | Path, kind: type[Kind]) -> Kind:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Parameters
    ----------
    folder : that they were written to
    kind : of the outcome, such as one that shows itself

    Raises
    ------
    SceneError
        if the folder holds none that can be read
    """
    import xarray

    if not isinstance(folder, str | Path):
        raise SceneError(f"{folder!r} is no folder: give one that `ringwear run` has written")
    path = Path(folder)
    try:
        told = json.loads((path / "summary.json").read_text("utf-8"))
        with xarray.open_dataset(path / "results.nc", engine="netcdf4") as opened:
            refuse_large(path / "results.nc", opened)
            data: Any = opened.load()
        scene = Scene.from_toml(data.attrs["scene"], str(path))
        rows = _rebuilt(Agreement, told["agreement"])
    except (OSError, KeyError, ValueError) as error:
        raise SceneError(
            f"{path} cannot be read as results of ringwear: {error}; give a folder that `ringwear "
            "run` has written"
        ) from None
    variables, coordinates = (
        {name: (of.dims, of.values, of.attrs) for name, of in part.items()}
        for part in (data.data_vars, data.coords)
    )
    methods = methods_of([name for name in told["methods"] if name in METHODS])
    table = Table(variables, coordinates, data.attrs)
    return kind(scene, methods, {}, {}, rows, (), table, told)
