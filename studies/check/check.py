"""Hold results of other programs against ours.

The scene is asked for at their times and radii, so that nothing is interpolated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ..figures.style import in_style
from ..methods.base import Method, Solution
from ..outcome.outcome import Outcome
from ..outcome.run import run
from ..problem.problem import Problem
from ..problem.unit_names import UnitNames
from ..registry import METHODS
from ..scene.keys import listed
from ..scene.scene import Scene, Source
from ..study.errors_over_size import draw_errors
from ..tables import write_csv
from .checked import CheckedOutcome
from .given import Given
from .tables import OthersResults, read

Kind = TypeVar("Kind", bound=CheckedOutcome)


def write_check(result: CheckedOutcome, directory: Path) -> None:
    """Write the errors of theirs, and a figure of them over the size of a refinement."""
    rows = pd.DataFrame(asdict(row) for row in result.verdicts)
    write_csv(rows, directory / "check.csv")
    names = UnitNames.of(result.scene.units)
    curves = {
        f"{row.at(names)}, order {row.sequence.order:.2g}": row.sequence
        for row in result.refinements
    }
    if curves:
        with in_style():
            figure = draw_errors({"size": curves}, "error, relative to ours", result.scene.title)
            figure.savefig(directory / "refinement.png")


def check(scene: Source, given: Mapping[str, OthersResults], **how: Any) -> CheckedOutcome:
    """Hold results of other programs against ours; `check_as` tells what can be given."""
    return check_as(CheckedOutcome, scene, given, **how)


def check_as(
    kind: type[Kind],
    scene: Source,
    given: Mapping[str, OthersResults],
    methods: Sequence[str | Method] | str | None = None,
    within: float = 0.01,
    columns: Mapping[str, str] | None = None,
    units: str = "",
    sizes: Sequence[float] = (),
) -> Kind:
    """Hold results of other programs against ours, at their times and radii.

    Parameters
    ----------
    kind : of the outcome, such as one that shows itself
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
    falling = len(sizes) > 1 and (np.diff([*sizes, 0.0]) < 0).all()
    if len(sizes) and not (falling and len(sizes) == len(given)):
        raise SceneError(
            f"sizes {', '.join(f'{size:g}' for size in sizes)} of {len(given)} results: give one "
            "for each of two or more, above 0 and decreasing"
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
    values = {field.name: getattr(result, field.name) for field in fields(Outcome)}
    values["solutions"] = {
        name: solution if name in given else _with_given_force(scene.problem, solution)
        for name, solution in result.solutions.items()
    }
    return kind(**values, given=tuple(given), within=within, sizes=tuple(sizes))


def _with_given_force(problem: Problem, solution: Solution) -> Solution:
    """Return a solution with the force as a quantity: no method makes an error of what is given."""
    if problem.load_regime.response == "normal_force":
        return solution
    force = {"normal_force": problem.loading.at(problem.times).force}
    exact = {"normal_force": np.zeros(len(problem.times))}
    return replace(solution, results=force | solution.results, errors=exact | solution.errors)
