"""Compare results of other programs with ours.

The scene is solved at the times and radii of the other programs, so that nothing is interpolated.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from ..crosscheck import FIELDS, LOG, METHODS, Method, Problem, Scene, SceneError, Solution, Source
from ..crosscheck.result.outcome import Outcome
from ..crosscheck.result.predictions.memory import refuse_beyond_memory, why_beyond_memory
from ..crosscheck.result.run import run
from ..crosscheck.result.scope import chosen_methods, methods_of, refuse
from ..crosscheck.scene.keys import listed
from ..decks.reports import reach_of_deck
from ..tables import write_csv
from .checked import CheckedOutcome
from .other_program import OtherProgram
from .tables import OthersResults, read

Kind = TypeVar("Kind", bound=CheckedOutcome)
# Copies of the fields of another program that are in memory at once, with their differences to
# ours; and numbers that the verdict on one quantity at one time takes, with its texts. Measured.
COPIES_OF_FIELDS, NUMBERS_OF_VERDICT = 8.0, 250.0


def write_check(result: CheckedOutcome, directory: Path) -> None:
    """Write the errors to `check.csv`."""
    rows = pd.DataFrame(asdict(row) for row in result.verdicts)
    write_csv(rows, directory / "check.csv")


def check(scene: Source, given: Mapping[str, OthersResults], **how: Any) -> CheckedOutcome:
    """Compare results of other programs with ours; `check_as` describes the arguments."""
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
    memory: float | None = None,
) -> Kind:
    """Compare results of other programs with ours, at their times and radii.

    Parameters
    ----------
    kind : class of the outcome, such as one that shows itself in notebooks
    scene : a Scene, the name of a bundled one, a file, or nested dictionaries
    given : CSV or netCDF files, DataFrames or xarray Datasets, by the names of their programs
    methods : our methods, in place of those of the scene
    within : relative error that is allowed, in the norm of each quantity
    columns : our column names by theirs, ``{"p": "pressure"}``
    units : of the results, such as ``"mm, N, MPa, s"``, if not those of the scene
    sizes : decreasing sizes of elements or steps, one for each result, if all results are of one
        program, from coarse to fine
    memory : largest memory to use, in GiB; by default that of the machine

    Raises
    ------
    SceneError
        if a table cannot be read, naming the file, the line, the column and the remedy; if a
        program has the name of one of our methods; if the sizes do not suit the results; or if
        there are so many times and radii that memory does not suffice
    """
    scene = Scene.of(scene)
    if taken_names := [name for name in given if name in METHODS]:
        raise SceneError(
            f"{taken_names[0]} is one of our methods: give the other program another name"
        )
    decreasing = len(sizes) > 1 and (np.diff([*sizes, 0.0]) < 0).all()
    if len(sizes) and not (decreasing and len(sizes) == len(given)):
        raise SceneError(
            f"sizes {', '.join(f'{size:g}' for size in sizes)} of {len(given)} results: give two "
            "or more results, and a size for each, above 0 and decreasing"
        )
    tables = {
        name: read(source, name, scene, columns or {}, units) for name, source in given.items()
    }
    scene = _scene_of_tables(scene, tables.values())
    ours = methods_of(listed(methods)) if methods else chosen_methods(scene)
    refuse(scene, ours)
    if not methods:
        # mdr-grid is the paper's own algorithm, of first order: too inaccurate for a reference
        accurate = {name: entry for name, entry in ours.items() if name != "mdr-grid"}
        ours = accurate or methods_of(["mdr", "fem"])
    numbers = sum(_numbers_at_each_time(scene, table) for table in tables.values())
    with_fields = any(map(_fields_of, tables.values()))
    # our own fields are shown, but not needed to check numbers
    if not with_fields and why_beyond_memory(scene, ours.values(), memory, numbers):
        LOG.warning(
            "%d times are too many for fields: ours are left out, because the results have none",
            len(scene.wear.times),
        )
        scene = scene.changed(output__quantities=["history", "steady"])
    how = {"without_fields": "tables without fields along the radius"} if with_fields else {}
    refuse_beyond_memory(scene, ours.values(), memory, numbers, **how)
    their_methods = [OtherProgram.from_table(name, table, scene) for name, table in tables.items()]
    result = run(scene, [*ours.values(), *their_methods])
    values = {field.name: getattr(result, field.name) for field in fields(Outcome)}
    values["solutions"] = {
        name: solution if name in given else _with_prescribed_force(scene.problem, solution)
        for name, solution in result.solutions.items()
    }
    reaches = {name: reach_of_deck(source, scene) for name, source in given.items()}
    decks = {name: reach for name, reach in reaches.items() if reach is not None}
    return kind(**values, given=tuple(given), within=within, sizes=tuple(sizes), decks=decks)


def _scene_of_tables(scene: Scene, tables: Iterable[pd.DataFrame]) -> Scene:
    """Return a scene at the times and radii of tables, with the quantities that they have."""
    rows = pd.concat(tables)
    radii = scene.problem.radii * scene.problem.units.length
    quantities = scene.output.quantities
    if "all" not in quantities:
        given = rows.columns.drop(["time", "radius"], errors="ignore")
        quantities = [*dict.fromkeys([*quantities, *given])]
    return scene.changed(
        wear__times=np.unique(rows["time"]).tolist(),
        output__radii=np.union1d(radii, rows.get("radius", pd.Series()).dropna()).tolist(),
        output__quantities=quantities,
        output__field_times=None,
    )


def _fields_of(table: pd.DataFrame) -> list[str]:
    """Return the fields along the radius in a table."""
    return [name for name in table if name in FIELDS]


def _numbers_at_each_time(scene: Scene, table: pd.DataFrame) -> float:
    """Return about how many numbers a check of a table needs at each time of the scene."""
    fields, columns = len(_fields_of(table)), len(table.columns)
    return COPIES_OF_FIELDS * fields * len(scene.problem.radii) + NUMBERS_OF_VERDICT * columns


def _with_prescribed_force(problem: Problem, solution: Solution) -> Solution:
    """Return a solution that contains the force if it is prescribed, with an error of 0."""
    if problem.response == "normal_force":
        return solution
    force = {"normal_force": problem.loading.at(problem.times).force}
    zero_error = {"normal_force": np.zeros(len(problem.times))}
    return replace(solution, results=force | solution.results, errors=zero_error | solution.errors)
