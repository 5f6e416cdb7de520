"""Rows for the tables of the challenge, from a file of another program."""

import re
from pathlib import Path

import pandas as pd

from ..check.check import check
from ..check.tables import read
from ..crosscheck import Scene
from ..study.formats import to_markdown
from .answers import errors_in
from .problems import number_of

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
    theirs = read(file, file.name, scene, {}, "", time=times[0] if len(times) == 1 else None)
    if "radius" in theirs:
        inside = theirs["radius"].isna() | (theirs["radius"] < INSIDE * scene.punch.radius)
        theirs = theirs[inside].drop(columns="normal_force", errors="ignore")
    exact = scene.changed(accuracy__rtol=1e-7)
    rows = check(exact, {"theirs": theirs}, methods=["bem"]).errors
    greatest = rows["error"].abs().groupby(rows["quantity"]).max().reindex([*QUANTITIES])
    errors_of = {QUANTITIES[name]: _written(error) for name, error in greatest.items()}
    seconds = re.match(r"#\s*([\d.]+)\s*s\b", file.open(encoding="utf-8").readline())
    time = f"{float(seconds[1]):.2g}" if seconds else "unknown"
    return to_markdown(pd.DataFrame([labels | errors_of | {"seconds": time}])).splitlines()


def _written(error: float) -> str:
    """Return an error with two digits, such as 1.2e-4; NaN as "not given"."""
    if error != error:
        return "not given"
    number, _, exponent = f"{error:.1e}".partition("e")
    return f"{number}e{int(exponent)}"
