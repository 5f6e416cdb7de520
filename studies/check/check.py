"""Results of other programs held against ours: the verdict is on theirs.

The scene is asked for at their times and radii, so that nothing is interpolated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ..crosscheck.dataset import Result
from ..crosscheck.run import run
from ..figures.style import in_style
from ..methods.base import Method
from ..numerics.sequences import draw_errors
from ..problem.scene import Scene, Source, listed
from ..problem.unit_names import UnitNames
from ..registry import METHODS
from .comparison import Comparison
from .diagnose import Diagnosis, diagnose
from .given import Given
from .refinement import Refinement, refinements
from .tables import read
from .verdict import Verdict, best, in_words, verdicts


@dataclass(frozen=True, eq=False, repr=False)
class Checked(Result):
    """A run beside which results of other programs stand.

    Parameters
    ----------
    given : names of these
    within : relative error that they are allowed
    sizes : if they are of one program, from coarse to fine: the verdict is on the last; else empty
    """

    given: tuple[str, ...]
    within: float
    sizes: tuple[float, ...]

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Errors of theirs, by program, quantity and time."""
        return tuple(row for name in self.given for row in verdicts(self, name, self.within))

    @property
    def passes(self) -> bool:
        """Whether theirs is within what is allowed, by methods of ours that do not disagree."""
        judged = all(row.within for row in self.verdicts if row.solver in self.judged)
        return judged and self.verdict != "disagree"

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of those that are judged."""
        return self.given[-1:] if self.sizes else self.given

    @cached_property
    def refinements(self) -> tuple[Refinement, ...]:
        """How theirs converges, by quantity."""
        return tuple(refinements(self.verdicts, self.given, self.sizes)) if self.sizes else ()

    def compare(self, name: str) -> Comparison:
        """Return what a program gives, and ours at its times and radii."""
        theirs = self.dataset[list(self.solutions[name].results)].sel(solver=name)
        for dim in list(theirs.dims):
            theirs = theirs.dropna(dim, how="all")
        given = {str(key): of.values for key, of in theirs.items()}
        ours = {
            key: self.dataset[key].sel(solver=best(self, key)).reindex_like(theirs[key]).values
            for key in given
            if best(self, key)
        }
        times, radii = theirs["time"].values, theirs.get("radius", np.empty(0))
        return Comparison(times, np.asarray(radii), given, ours, self.scene)

    @cached_property
    def diagnoses(self) -> dict[str, list[Diagnosis]]:
        """What the errors of each program look like."""
        return {name: diagnose(self.compare(name)) for name in self.given}

    @property
    def lines(self) -> list[str]:
        """The verdict on theirs, for people."""
        names = UnitNames.of(self.scene.units)
        judged = [row for row in self.verdicts if row.solver in self.judged]
        groups = groupby(judged, lambda row: (row.solver, row.quantity))
        lines = [f"{name}: {in_words(list(rows), names)}" for (name, _), rows in groups]
        return lines + [f"refinement: {row.in_words(names)}" for row in self.refinements]

    @property
    def notes(self) -> tuple[str, ...]:
        return (*self.lines, *super().notes)

    @property
    def summary(self) -> dict[str, Any]:
        # JSON has null for what is not given
        rows = [
            {key: None if value != value else value for key, value in asdict(row).items()}
            for row in self.verdicts
        ]
        return super().summary | {"verdicts": rows}


def write_check(result: Checked, directory: Path) -> None:
    """Write the errors of theirs, and of a refinement its orders and a figure."""
    rows = pd.DataFrame(asdict(row) for row in result.verdicts)
    rows.to_csv(directory / "check.csv", index=False)
    refined = result.refinements
    if not refined:
        return
    pd.DataFrame(row.summary() for row in refined).to_csv(directory / "refinement.csv", index=False)
    names = UnitNames.of(result.scene.units)
    curves = {
        f"{row.at(names)}, order {row.sequence.order:.2g}": (
            row.sequence.sizes,
            row.sequence.errors,
            np.nan,
        )
        for row in refined
    }
    with in_style():
        draw_errors(directory / "refinement.png", {"size": curves}, "error, relative to ours")


def check(
    scene: Source,
    given: Mapping[str, Any],
    methods: Sequence[str | Method] | str | None = None,
    within: float = 0.01,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    sizes: Sequence[float] = (),
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
    sizes : of elements or steps, decreasing, if all are of one program, from coarse to fine

    Raises
    ------
    SceneError
        if a table cannot be read, naming the file, the line, the column and the remedy
    """
    scene = Scene.of(scene)
    if taken := [name for name in given if name in METHODS]:
        raise SceneError(f"{taken[0]} is a method of ours: give theirs another name")
    if len(sizes) and (len(sizes) != len(given) or not (np.diff([*sizes, 0.0]) < 0).all()):
        raise SceneError(
            f"sizes {', '.join(f'{size:g}' for size in sizes)} of {len(given)} results: give one "
            "for each, above 0 and decreasing"
        )
    theirs = {name: read(of, name, scene, columns or {}, units) for name, of in given.items()}
    whole = pd.concat(theirs.values())
    radii = scene.problem.radii * scene.problem.units.length
    changes = {
        "wear__times": np.unique(whole["time"]).tolist(),
        "output__radii": np.union1d(radii, whole.get("radius", pd.Series()).dropna()).tolist(),
        "output__quantities": ["all"],
        "output__field_times": None,
    }
    scene = scene.changed(**changes)
    # the paper's own algorithm is of first order
    ours = [name for name in scene.methods if name != "mdr-grid"] or ["mdr", "fem"]
    tables = [Given.tabled(name, table, scene) for name, table in theirs.items()]
    result = run(scene, [*(listed(methods) if methods else ours), *tables])
    problem = scene.problem
    for name, solution in result.solutions.items():
        if name not in given and problem.indentation is None:
            # of a force that is given no method makes an error
            solution.results.setdefault("normal_force", problem.loading.at(problem.times).force)
            solution.errors.setdefault("normal_force", np.zeros(len(problem.times)))
    values = {field.name: getattr(result, field.name) for field in fields(Result)}
    return Checked(**values, given=tuple(given), within=within, sizes=tuple(sizes))
