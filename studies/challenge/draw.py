"""Measure what programs of others err by, beside methods of ours; write tables and a figure.

``python -m ringwear.studies.challenge.draw`` reads the files in `others`, whose names tell problem
and program, and whose first lines the seconds; it writes `others/errors.csv`, `others/errors.png`,
and the tables of both READMEs. With ``--tables`` it measures nothing, and goes by `errors.csv`.
Seconds of ours are the processor's.
"""

import re
import sys
from collections.abc import Iterator
from itertools import dropwhile
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

import pandas as pd
import xarray

from ..check.check import check
from ..check.tables import read
from ..outcome.run import run
from ..scene.scene import Scene
from .problems import FOLDER, OTHERS, number_of, problem_named
from .rows import (
    ERRORS,
    PROGRAMS,
    QUANTITIES,
    errors_table,
    head_rows,
    problems_table,
    row_of,
    written_error,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INSIDE = 0.95
"""Radii, in punch radii, inside which pressures are compared."""
SOLVED = ("01", "03", "07")
"""Problems that programs of others have solved."""
DIGITS = (1, 3, 6)
"""Accuracies of ours, as powers of a tenth."""
KNOWN = {"indentation": 2e-11, "pressure": 1e-5}
"""Errors below which ours and what it is compared with cannot be told apart: they are bounds."""


def measure(
    scene: Scene, program: str, seconds: float, results: pd.DataFrame | xarray.Dataset
) -> pd.DataFrame:
    """Return a row: a program, its seconds, and its greatest errors over the times.

    Results are compared with boundary elements at an accuracy of 1e-7. What is not given is NaN.
    """
    exact = scene.changed(accuracy__rtol=1e-7)
    verdicts = pd.DataFrame(check(exact, {"theirs": results}, methods=["bem"]).verdicts)
    errors = verdicts["error"].abs().groupby(verdicts["quantity"]).max().reindex([*QUANTITIES])
    return pd.DataFrame({"program": [program], "seconds": seconds, **errors})


def results_of(path: Path, scene: Scene) -> tuple[pd.DataFrame, float]:
    """Return results of a program inside the radii that are compared, and its seconds.

    The seconds are those of a first line such as ``# 0.25 s``; NaN if there is none.
    """
    table = read(path, path.name, scene, {}, "")
    if "radius" in table:
        inside = table["radius"].isna() | (table["radius"] < INSIDE * scene.punch.radius)
        table = table[inside].drop(columns="normal_force", errors="ignore")
    told = re.match(r"#\s*([\d.]+)\s*s\b", path.open(encoding="utf-8").readline())
    return table, float(told[1]) if told else float("nan")


def submission(problem: Path, file: Path) -> list[str]:
    """Compare a file with a problem: return the head of the table and its row."""
    scene = Scene.load(problem)
    table, seconds = results_of(file, scene)
    row = measure(scene, file.stem, seconds, table).iloc[0]
    numbers = [written_error(row[name]) for name in QUANTITIES]
    time = f"{seconds:.2g}" if seconds == seconds else "not told"
    return [*head_rows(), row_of([str(number_of(problem)), file.stem, *numbers, time])]


def measure_all(scene: Scene, files: list[Path]) -> pd.DataFrame:
    """Return rows of programs of others, by their files, and of ours at their times and radii."""
    rows, methods, wanted = [], ["mdr", "fem"], [*QUANTITIES]
    for path in files:
        table, seconds = results_of(path, scene)
        name, _, count = path.stem[3:].rpartition("_")
        program, counted = PROGRAMS[name]
        row = measure(scene, program, seconds, table)
        rows.append(row.assign(setting=f"{int(count)} {counted}"))
    times, radii = (sorted(table[name].unique().tolist()) for name in ("time", "radius"))
    scene = scene.changed(wear__times=times, output__radii=radii, output__quantities=wanted)
    # what is loaded once is not counted
    measure(scene, "", 0.0, run(scene, methods).dataset)
    for method in methods:
        for digits in DIGITS:
            start = process_time()
            dataset = run(scene.changed(accuracy__rtol=10.0**-digits), [method]).dataset
            row = measure(scene, method, process_time() - start, dataset)
            rows.append(row.assign(setting=f"rtol 1e-{digits}"))
    return pd.concat(rows, ignore_index=True)


def told(problem: int, measured: pd.DataFrame) -> Iterator[dict[str, object]]:
    """Yield rows of `errors.csv`: one bound in place of errors that are too small to be told."""
    for program, chosen in measured.groupby("program", sort=False):
        below = (chosen[[*KNOWN]] <= pd.Series(KNOWN)).all(axis=None)
        for row in chosen[: 1 if below else None].to_dict("records"):
            errors = {column: written_error(row[name]) for name, column in QUANTITIES.items()}
            if below:
                errors = {QUANTITIES[of]: f"{bound:.0e}" for of, bound in KNOWN.items()}
            seconds = f"{row['seconds']:.2f}" if row["seconds"] < 1 else f"{row['seconds']:.2g}"
            named = {"problem": problem, "program": program, "setting": row["setting"]}
            yield named | {"seconds": seconds} | errors | {"bound": "below" if below else ""}


def write_tables() -> None:
    """Put the generated tables in the places of those in the READMEs."""
    for path, head, table in (
        (FOLDER / "README.md", "| problem | what", problems_table()),
        (OTHERS / "README.md", "| problem | program", errors_table()),
    ):
        lines = path.read_text("utf-8").splitlines()
        start = next(number for number, line in enumerate(lines) if line.startswith(head))
        rest = list(dropwhile(lambda line: line.startswith("|"), lines[start:]))
        path.write_text("\n".join([*lines[:start], *table, *rest]) + "\n", "utf-8")


def draw() -> "Figure":
    """Draw the errors of `errors.csv` over seconds, a column for each problem."""
    from matplotlib.figure import Figure

    from ..figures.style import LOOKS, looks_of

    table = pd.read_csv(ERRORS)
    programs = [str(name) for name in table["program"].unique()]
    looks_by_name = looks_of(programs, [name for name in programs if name not in LOOKS])
    figure = Figure((9, 6), layout="constrained")
    axes = figure.subplots(2, len(SOLVED), sharex=True, sharey="row")
    for column, (number, told) in zip(axes.T, table.groupby("problem"), strict=True):
        for program, rows in told.groupby("program", sort=False):
            bound = rows["bound"].notna().any()
            looks = {"marker": "."} | looks_by_name[str(program)]
            looks |= (
                {"label": f"{program} (at most)", "marker": "v"} if bound else {"label": program}
            )
            for (quantity, name), panel in zip(QUANTITIES.items(), column, strict=True):
                panel.loglog(rows["seconds"], rows[name], **looks)
                panel.set(xlabel="seconds", ylabel=f"error of {quantity}")
        column[0].legend(title=f"problem {number}", loc=(0.2, 1.02))
    return figure


if __name__ == "__main__":
    if "--tables" not in sys.argv:
        rows = [
            row
            for number in SOLVED
            for row in told(
                int(number),
                measure_all(
                    Scene.load(problem_named(number)), sorted(OTHERS.glob(f"{number}*.csv"))
                ),
            )
        ]
        pd.DataFrame(rows).to_csv(ERRORS, index=False)
    draw().savefig(OTHERS / "errors.png", dpi=110)
    write_tables()
