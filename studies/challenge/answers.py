"""Compare files of other programs with the problems, and make rows for the challenge's tables.

Problems on layered ground have printed answers; those on a half-space are solved.
The file `answers.csv` of a problem has a row for each value. Its first columns are those of the
case, such as `poisson_ratio`.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from ..check.check import check
from ..check.tables import read
from ..crosscheck import Scene
from ..study.formats import to_markdown
from ..tables.frame import Frame
from ..tables.headings import split_heading
from .problems import answers_of, number_of, problem_name

PLACE = {"time", "radius"}
"""Columns of a case that `ringwear check` compares at any times and radii."""
NO_TEXT = (".nc", ".vtu")
"""Ends of files that are not text, which `ringwear check` compares."""
SAME_CASE = 1e-6
"""Relative difference of numbers of a case below which they are the same."""


def read_answers(problem: Path) -> pd.DataFrame:
    """Return the rows of `answers.csv` of a problem, values as text."""
    return pd.read_csv(answers_of(problem), dtype={"value": str})


def columns_of_case(answers: pd.DataFrame) -> list[str]:
    """Return the columns of the case in answers: those before `quantity`."""
    return [*answers.columns[: answers.columns.get_loc("quantity")]]


def errors_in(problem: Path, file: Path) -> pd.DataFrame | None:
    """Compare a table of cases with the answers of a problem.

    The table has the columns of the case, and a column for each quantity; quantities and cases may
    be left out.

    Returns
    -------
    errors : for each quantity, the number of its values, the greatest relative error, and the case
        in which it is; None if answers of the problem have no cases, or if the table lacks a column
        of the case, so that `ringwear check` compares it

    Raises
    ------
    SceneError
        if the table cannot be read, or if none of its values has an answer
    """
    if not answers_of(problem).is_file() or file.suffix in NO_TEXT:
        return None
    answers = read_answers(problem)
    case = columns_of_case(answers)
    frame = Frame.of_file(file)
    ours = {heading: split_heading(heading).name for heading in frame.cells}
    theirs = frame.values.rename(columns=ours)
    if set(case) <= PLACE or (not set(case) <= set(theirs) and PLACE & set(theirs)):
        return None
    missing = ", ".join(name for name in case if name not in theirs)
    if missing:
        raise SceneError(f"{file} has no column {missing}: give it, as in answers.csv")
    quantities = [name for name in answers["quantity"].unique() if name in theirs]
    used = {heading: name for heading, name in ours.items() if name in (*case, *quantities)}
    frame.refuse_faults(used)
    numbers = theirs[[*case, *quantities]]
    rows = []
    for quantity in quantities:
        wanted = answers[answers["quantity"] == quantity]
        errors = _relative_errors(wanted, numbers, case, quantity)
        if np.isfinite(errors).any():
            worst = wanted.iloc[int(np.nanargmax(errors))]
            place = ", ".join(f"{name} = {worst[name]:g}" for name in case)
            count = int(np.isfinite(errors).sum())
            row = {"quantity": quantity, "values": count, "error": np.nanmax(errors)}
            rows.append(row | {"case": place})
    if not rows:
        names = ", ".join(answers["quantity"].unique())
        raise SceneError(
            f"{file} has no value of {problem_name(problem)}: give columns {', '.join(case)} with "
            f"numbers of its answers.csv, and {names}"
        )
    return pd.DataFrame(rows)


def _relative_errors(
    answers: pd.DataFrame, theirs: pd.DataFrame, case: list[str], quantity: str
) -> Array:
    """Return the error of a quantity for each answer (n,); NaN where a table has no such case."""
    wanted, given = (table[case].to_numpy(dtype=float) for table in (answers, theirs))
    same = np.isclose(wanted[:, None], given, rtol=SAME_CASE, atol=1e-12).all(axis=2)
    value = answers["value"].to_numpy(dtype=float)
    of_case = theirs[quantity].to_numpy(dtype=float)[same.argmax(axis=1)]
    return np.where(same.any(axis=1), np.abs(of_case / value - 1), np.nan)


INSIDE = 0.95
"""Radius, in punch radii, inside which fields are compared."""
QUANTITIES = {"indentation": "error of d", "pressure": "error of p"}
"""Compared quantities, and the columns of their errors."""


def submission(problem: Path, file: Path) -> list[str]:
    """Compare a file with a problem, and return a table in Markdown, line by line.

    The table has one row with the greatest errors over the times, and the seconds of a first line
    such as ``# 0.25 s``. For a table of cases on layered ground it has a row for each quantity.

    Raises
    ------
    SceneError
        if the file cannot be read
    """
    labels = {"problem": number_of(problem), "program": file.stem}
    errors = errors_in(problem, file)
    if errors is not None:
        table = pd.DataFrame(labels, index=errors.index).join(errors)
        table["error"] = table["error"].map(_written)
        return to_markdown(table.rename(columns={"error": "greatest relative error"})).splitlines()
    scene = Scene.load(problem)
    times = scene.wear.times
    only = times[0] if len(times) == 1 else None
    theirs = read(file, file.name, scene, {}, "", time=only)
    if "radius" in theirs:
        inside = theirs["radius"].isna() | (theirs["radius"] < INSIDE * scene.punch.radius)
        theirs = theirs[inside].drop(columns="normal_force", errors="ignore")
    exact = scene.changed(accuracy__rtol=1e-7)
    rows = check(exact, {"theirs": theirs}, methods=["bem"]).errors
    greatest = rows["error"].abs().groupby(rows["quantity"]).max().reindex([*QUANTITIES])
    errors_of = {QUANTITIES[name]: _written(error) for name, error in greatest.items()}
    with file.open(encoding="utf-8", errors="replace") as lines:
        seconds = re.match(r"#\s*([\d.]+)\s*s\b", lines.readline())
    time = f"{float(seconds[1]):.2g}" if seconds else "unknown"
    return to_markdown(pd.DataFrame([labels | errors_of | {"seconds": time}])).splitlines()


def _written(error: float) -> str:
    """Return an error with two digits, such as 1.2e-4; NaN as "not given"."""
    if error != error:
        return "not given"
    number, _, exponent = f"{error:.1e}".partition("e")
    return f"{number}e{int(exponent)}"
