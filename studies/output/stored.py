"""Read results back from the folder that they were written to."""

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
from ..outcome.answer import Answers
from ..outcome.outcome import Outcome
from ..outcome.scope import methods_of
from ..outcome.table import Table
from ..predictions.memory import refuse_large
from ..problem.written import one_line, shown
from ..registry import METHODS
from ..scene.scene import Scene

# an object of `summary.json`
Json = dict[str, Any]
Row = TypeVar("Row", Agreement, Anchor)
Kind = TypeVar("Kind", bound="StoredOutcome")


@dataclass(frozen=True, eq=False, repr=False)
class StoredOutcome(Outcome):
    """Results from a folder: all numbers, and the figures that need only these.

    Parameters
    ----------
    stored_table : the table in `results.nc`
    stored_summary : the content of `summary.json`
    """

    stored_table: Table
    stored_summary: Json

    @cached_property
    def table(self) -> Table:
        """The table in `results.nc`."""
        return self.stored_table

    @property
    def summary(self) -> Json:
        """The content of `summary.json`."""
        return self.stored_summary

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of the programs whose results were checked."""
        return tuple(
            dict.fromkeys(row["solver"] for row in self.stored_summary.get("verdicts", []))
        )

    @property
    def about_others(self) -> tuple[str, ...]:
        """The verdict on the results of other programs, in sentences; empty if there are none."""
        return tuple(self.stored_summary.get("check", {}).get("lines", ()))

    @property
    def verdict(self) -> str:
        """The verdict in `summary.json`: `agree`, `disagree` or `undecided`."""
        return str(self.stored_summary["verdict"])

    @cached_property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that could not be promised, with the times and the reason."""
        rows = self.stored_summary.get("left_out_of_promise", [])
        return tuple(LeftOut(**row | {"times": tuple(row["times"])}) for row in rows)

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of all methods."""
        return tuple(self.stored_summary["notes"])

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """The numbers of the answer, by method, and their relative error estimates."""
        return Answers(
            {
                name: {key: np.array(value, dtype=float) for key, value in values.items()}
                for name, values in self.stored_summary["answer"].items()
            }
        )

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method was checked against."""
        return _rebuilt(Anchor, self.stored_summary["anchors"])


def _rebuilt(kind: type[Row], rows: list[Json]) -> tuple[Row, ...]:
    """Return objects of a class from rows of `summary.json`."""
    names = [field.name for field in fields(kind)]
    return tuple(kind(*(row[name] for name in names)) for row in rows)


def load(folder: str | Path, kind: type[Kind]) -> Kind:
    """Read the results that ``ringwear run --out folder``, or `Result.save`, has written.

    Parameters
    ----------
    folder : the folder with the results
    kind : class of the results, such as `Stored`, which can draw itself

    Raises
    ------
    SceneError
        if the folder contains no results that can be read
    """
    import xarray

    if not isinstance(folder, str | Path):
        raise SceneError(f"{shown(folder)} is no folder: give one that `ringwear run` has written")
    path = Path(folder)
    try:
        summary = json.loads((path / "summary.json").read_text("utf-8"))
        with xarray.open_dataset(path / "results.nc", engine="netcdf4") as dataset:
            refuse_large(path / "results.nc", dataset)
            data: Any = dataset.load()
        scene = Scene.from_toml(data.attrs["scene"], str(path))
        rows = _rebuilt(Agreement, summary["agreement"])
    except (OSError, KeyError, ValueError) as error:
        reason = one_line(error)
        if isinstance(error, FileNotFoundError):
            reason = f"it has no {Path(str(error.filename)).name}"
        raise SceneError(
            f"{path} cannot be read as results of ringwear: {reason}; give a folder that `ringwear "
            "run` has written"
        ) from None
    variables, coordinates = (
        {name: (array.dims, array.values, array.attrs) for name, array in arrays.items()}
        for arrays in (data.data_vars, data.coords)
    )
    methods = methods_of([name for name in summary["methods"] if name in METHODS])
    table = Table(variables, coordinates, data.attrs)
    return kind(scene, methods, {}, {}, rows, (), table, summary)
