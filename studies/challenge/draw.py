"""Measure the errors of other programs and of our methods; write tables and a figure.

``python -m ringwear.studies.challenge.draw`` reads the files in `others`, whose names contain the
problem and the program, and whose first lines contain the seconds. It writes `others/errors.csv`,
`others/errors.png`, and the tables of all READMEs. With ``--tables`` it measures nothing, and
writes the figure and the tables from `errors.csv` and from the answers on layered ground. Seconds
of our methods are processor time.
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
from ..crosscheck import Scene, run
from .answers import errors_in
from .printed import FILE, printed_values
from .problems import FOLDER, OTHERS, layered_problems, number_of, problem_named
from .rows import (
    ERRORS,
    PROGRAMS,
    QUANTITIES,
    answer_errors_table,
    answers_table,
    differences_table,
    errors_table,
    head_rows,
    printed_table,
    problems_table,
    row_of,
    written_error,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INSIDE = 0.95
"""Radius, in punch radii, inside which fields are compared."""
SOLVED = ("01", "03", "07")
"""Problems that other programs have solved."""
DIGITS = (1, 3, 6)
"""Exponents of the tolerances 10^-n of our methods."""
MIN_MEASURABLE_ERRORS = {"indentation": 2e-11, "pressure": 1e-5}
"""Smallest errors that the comparison with the reference can measure; smaller ones are replaced by
these as bounds."""


def measure(
    scene: Scene, program: str, seconds: float, results: pd.DataFrame | xarray.Dataset
) -> pd.DataFrame:
    """Return a row with a program, its seconds, and its greatest errors over the times.

    Results are compared with boundary elements at an `rtol` of 1e-7. Errors of quantities that the
    program does not give are NaN.
    """
    exact = scene.changed(accuracy__rtol=1e-7)
    rows = check(exact, {"theirs": results}, methods=["bem"]).errors
    errors = rows["error"].abs().groupby(rows["quantity"]).max().reindex([*QUANTITIES])
    return pd.DataFrame({"program": [program], "seconds": seconds, **errors})


def results_of(path: Path, scene: Scene) -> tuple[pd.DataFrame, float]:
    """Return the results of a program at the compared radii, and its seconds.

    The seconds are those of a first line such as ``# 0.25 s``; NaN if there is none.
    """
    times = scene.wear.times
    table = read(path, path.name, scene, {}, "", time=times[0] if len(times) == 1 else None)
    if "radius" in table:
        inside = table["radius"].isna() | (table["radius"] < INSIDE * scene.punch.radius)
        table = table[inside].drop(columns="normal_force", errors="ignore")
    seconds = re.match(r"#\s*([\d.]+)\s*s\b", path.open(encoding="utf-8").readline())
    return table, float(seconds[1]) if seconds else float("nan")


def submission(problem: Path, file: Path) -> list[str]:
    """Compare a file with a problem, and return the head of the table and the row of the file.

    A file with a table of cases on layered ground has a row for each quantity.
    """
    errors = errors_in(problem, file)
    if errors is not None:
        return answer_errors_table(problem, file.stem, errors)
    scene = Scene.load(problem)
    table, seconds = results_of(file, scene)
    row = measure(scene, file.stem, seconds, table).iloc[0]
    numbers = [written_error(row[name]) for name in QUANTITIES]
    time = f"{seconds:.2g}" if seconds == seconds else "unknown"
    return [*head_rows(), row_of([str(number_of(problem)), file.stem, *numbers, time])]


def measure_all(scene: Scene, files: list[Path]) -> pd.DataFrame:
    """Return rows of other programs, from files, and of our methods at their times and radii."""
    rows, methods, quantities = [], ["mdr", "fem"], [*QUANTITIES]
    for path in files:
        table, seconds = results_of(path, scene)
        name, _, count = path.stem[3:].rpartition("_")
        program, unit = PROGRAMS[name]
        row = measure(scene, program, seconds, table)
        rows.append(row.assign(setting=f"{int(count)} {unit}"))
    times, radii = (sorted(table[name].unique().tolist()) for name in ("time", "radius"))
    scene = scene.changed(wear__times=times, output__radii=radii, output__quantities=quantities)
    # load all modules before time is measured
    measure(scene, "", 0.0, run(scene, methods).dataset)
    for method in methods:
        for digits in DIGITS:
            start = process_time()
            dataset = run(scene.changed(accuracy__rtol=10.0**-digits), [method]).dataset
            row = measure(scene, method, process_time() - start, dataset)
            rows.append(row.assign(setting=f"rtol 1e-{digits}"))
    return pd.concat(rows, ignore_index=True)


def error_rows(problem: int, measured: pd.DataFrame) -> Iterator[dict[str, object]]:
    """Yield the rows of `errors.csv` for a problem, with all errors as text.

    If no error of a program is large enough to be measured, one row with bounds replaces its rows.
    """
    for program, rows_of_program in measured.groupby("program", sort=False):
        below = (rows_of_program[[*MIN_MEASURABLE_ERRORS]] <= pd.Series(MIN_MEASURABLE_ERRORS)).all(
            axis=None
        )
        for row in rows_of_program[: 1 if below else None].to_dict("records"):
            errors = {column: written_error(row[name]) for name, column in QUANTITIES.items()}
            if below:
                errors = {
                    QUANTITIES[quantity]: f"{bound:.0e}"
                    for quantity, bound in MIN_MEASURABLE_ERRORS.items()
                }
            seconds = f"{row['seconds']:.2f}" if row["seconds"] < 1 else f"{row['seconds']:.2g}"
            labels = {"problem": problem, "program": program, "setting": row["setting"]}
            yield labels | {"seconds": seconds} | errors | {"bound": "below" if below else ""}


def write_tables() -> None:
    """Write the printed values, and replace the tables in all READMEs by newly generated ones."""
    printed_values().to_csv(FILE, index=False)
    for path, table in (
        (FOLDER / "README.md", problems_table()),
        (FOLDER / "README.md", differences_table()),
        (FOLDER / "reference_values.md", printed_table()),
        (OTHERS / "README.md", errors_table()),
        *((path.with_name("README.md"), answers_table(path)) for path in layered_problems()),
    ):
        lines = path.read_text("utf-8").splitlines()
        start = lines.index(table[0])
        rest = list(dropwhile(lambda line: line.startswith("|"), lines[start:]))
        path.write_text("\n".join([*lines[:start], *table, *rest]) + "\n", "utf-8")


def draw() -> "Figure":
    """Draw the errors in `errors.csv` over the seconds, in a column for each problem."""
    from matplotlib.figure import Figure

    from ..figures.style import LOOKS, looks_of

    table = pd.read_csv(ERRORS)
    programs = [str(name) for name in table["program"].unique()]
    looks_by_name = looks_of(programs, [name for name in programs if name not in LOOKS])
    figure = Figure((9, 6), layout="constrained")
    axes = figure.subplots(2, len(SOLVED), sharex=True, sharey="row")
    for column, (number, errors) in zip(axes.T, table.groupby("problem"), strict=True):
        for program, rows in errors.groupby("program", sort=False):
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
            for row in error_rows(
                int(number),
                measure_all(
                    Scene.load(problem_named(number)), sorted(OTHERS.glob(f"{number}*.csv"))
                ),
            )
        ]
        pd.DataFrame(rows).to_csv(ERRORS, index=False)
    draw().savefig(OTHERS / "errors.png", dpi=110)
    write_tables()
