"""Results of other programs held against ours: the verdict is on theirs.

The scene is asked for at their times and radii, so that nothing is interpolated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ..crosscheck.dataset import Result
from ..crosscheck.run import run
from ..crosscheck.table import in_units
from ..methods.base import Method
from ..problem.quantities import FIELDS
from ..problem.scene import Scene, Source, listed
from ..problem.unit_names import UnitNames
from ..registry import METHODS
from . import tables
from .comparison import Comparison
from .diagnose import Diagnosis, diagnose
from .given import Given
from .verdict import Verdict, in_words, reference, verdicts


@dataclass(frozen=True, eq=False, repr=False)
class Checked(Result):
    """A run beside which results of other programs stand.

    Parameters
    ----------
    given : names of these
    within : relative error that they are allowed
    read : what the user should know of their reading
    """

    given: tuple[str, ...]
    within: float
    read: tuple[str, ...]

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Errors of theirs, by program, quantity and time."""
        return tuple(row for name in self.given for row in verdicts(self, name, self.within))

    @property
    def passes(self) -> bool:
        """Whether theirs is within what is allowed, by methods of ours that do not disagree."""
        return all(row.within for row in self.verdicts) and self.verdict != "disagree"

    def compare(self, name: str) -> Comparison:
        """Return what a program gives, and ours at its times and radii."""
        theirs, problem = self.solutions[name].results, self.scene.problem
        ours = {key: reference(self, key)[0].get(key, np.nan * theirs[key]) for key in theirs}
        given = [np.isfinite(values) for values in theirs.values()]
        times = np.any([values.any(axis=tuple(range(1, values.ndim))) for values in given], axis=0)
        radii = np.any([values.any(axis=0) for values in given if values.ndim > 1], axis=0)
        chosen = (
            {key: values[times][:, radii] if key in FIELDS else values[times] for key, values in of}
            for of in (in_units(problem, each).items() for each in (theirs, ours))
        )
        time, radius = self.coordinates["time"][times], self.coordinates["radius"]
        return Comparison(time, radius[radii] if radii.ndim else radius[:0], *chosen, self.scene)

    @cached_property
    def diagnoses(self) -> dict[str, list[Diagnosis]]:
        """What the errors of each program look like."""
        return {name: diagnose(self.compare(name)) for name in self.given}

    @property
    def table_of_verdicts(self) -> pd.DataFrame:
        return pd.DataFrame(asdict(row) for row in self.verdicts)

    @property
    def lines(self) -> list[str]:
        """The verdict on theirs, for people."""
        names, lines = UnitNames.of(self.scene.units), list[str]()
        for name, rows in groupby(self.verdicts, lambda row: row.solver):
            for _, of_quantity in groupby(rows, lambda row: row.quantity):
                lines.append(f"{name}: {in_words(list(of_quantity), names)}")
        return lines

    @property
    def notes(self) -> tuple[str, ...]:
        return (*self.lines, *self.read, *super().notes)

    @property
    def summary(self) -> dict[str, Any]:
        # JSON has null for what is not given
        rows = [
            {key: None if value != value else value for key, value in asdict(row).items()}
            for row in self.verdicts
        ]
        return super().summary | {"verdicts": rows}


def check(
    scene: Source,
    given: Mapping[str, Any],
    methods: Sequence[str | Method] | str | None = None,
    within: float = 0.01,
    columns: Mapping[str, str] | None = None,
    units: str = "",
) -> Checked:
    """Hold results of other programs against ours, at their times and radii.

    Parameters
    ----------
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    given : CSV or netCDF files, DataFrames or xarray Datasets, by the names of their programs
    methods : of ours, in place of the scene's
    within : relative error that theirs are allowed, in the norm of each quantity
    columns : names of ours by theirs, ``{"p": "pressure"}``
    units : of theirs, such as ``"mm, N, MPa, s"``, if not the scene's

    Raises
    ------
    SceneError
        if a table cannot be read, naming the file, the line, the column and the remedy
    """
    scene = Scene.of(scene)
    if taken := [name for name in given if name in METHODS]:
        raise SceneError(f"{taken[0]} is a method of ours: give theirs another name")
    read = {name: tables.read(of, name, scene, columns or {}, units) for name, of in given.items()}
    whole = pd.concat([of.table for of in read.values()])
    default = scene.problem.radii * scene.problem.units.length
    changes = {
        "wear__times": np.unique(whole["time"]).tolist(),
        "output__radii": np.union1d(default, whole.get("radius", default).dropna()).tolist(),
        "output__quantities": ["all"],
        "output__field_times": None,
    }
    scene = scene.changed(**changes)
    # the paper's own algorithm is of first order
    ours = [name for name in scene.methods if name != "mdr-grid"] or ["mdr", "fem"]
    times, radii = np.array(scene.wear.times), np.array(scene.output.radii)
    theirs = [Given.tabled(name, of.table, times, radii) for name, of in read.items()]
    result = run(scene, [*(listed(methods) if methods else ours), *theirs])
    notes = tuple(note for of in read.values() for note in of.notes)
    values = (getattr(result, field.name) for field in fields(Result))
    return Checked(*values, tuple(given), within, notes)
