"""Rows of the table of the challenge: what a program errs by, and its seconds.

The errors that the README tells are in `others/errors.csv`; `draw.py` measures them anew.
"""

import re
from pathlib import Path

import pandas as pd
import xarray

from ..check.check import check
from ..check.tables import read
from ..problem.scene import Scene
from .problems import OTHERS, difficulty, number_of, problems

QUANTITIES = {"indentation": "error of d", "pressure": "error of p"}
"""What is told, and its column."""
INSIDE = 0.95
"""Radii, in punch radii, inside which pressures are compared."""
HEAD = ("problem", "program", *QUANTITIES.values(), "seconds")
PROGRAMS = {
    "contact_mechanics": ("ContactMechanics", "points"),
    "tamaas": ("Tamaas", "points"),
    "scikit_fem": ("scikit-fem", "elements"),
    "calculix": ("CalculiX", "elements"),
}
"""Programs by the names in their files, and what the numbers there count."""
OURS = {"mdr": "ringwear, MDR", "fem": "ringwear, FEM"}
ERRORS = OTHERS / "errors.csv"


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
    return [*_head(), _row([str(number_of(problem)), file.stem, *numbers, time])]


def errors_table() -> list[str]:
    """Return the table of `others/errors.csv`, a row for each problem and program."""
    told = pd.read_csv(ERRORS, dtype=str, keep_default_na=False)
    lines, bounds = _head(), told[told["bound"] != ""]
    for (problem, program), rows in told[told["bound"] == ""].groupby(
        ["problem", "program"], sort=False
    ):
        numbers = [", ".join(rows[name]) for name in (*QUANTITIES.values(), "seconds")]
        lines.append(_row([problem, _settings(program, rows["setting"]), *numbers]))
    for problem, rows in bounds.groupby("problem", sort=False):
        names = " and ".join(OURS[of].removeprefix("ringwear, ") for of in rows["program"])
        numbers = [f"below {rows[name].iloc[0]}" for name in QUANTITIES.values()]
        seconds = f"{' and '.join(rows['seconds'])}, at {rows['setting'].iloc[0].split()[-1]}"
        lines.append(_row([problem, f"ringwear, {names}", *numbers, seconds]))
    return lines


def problems_table() -> list[str]:
    """Return the table of the problems, and what is hard in each."""
    rows = [_row([f"[`{of.stem}`]({of.name})", difficulty(of)]) for of in problems()]
    return [_row(["problem", "what is hard in it"]), "| --- | --- |", *rows]


def _settings(program: str, settings: pd.Series) -> str:
    """Return the name of a program with its numbers of points or elements."""
    if program in OURS:
        return OURS[program]
    counts = [setting.split()[0] for setting in settings]
    return f"{program}, {', '.join(counts)} {settings.iloc[0].split()[1]}"


def _head() -> list[str]:
    return [_row(HEAD), _row(["---"] * len(HEAD))]


def _row(cells: "list[str] | tuple[str, ...]") -> str:
    return f"| {' | '.join(cells)} |"


def written_error(error: float) -> str:
    """Return an error in two digits, as 1.9e-3."""
    if error != error:
        return "not given"
    number, _, exponent = f"{error:.1e}".partition("e")
    return f"{number}e{int(exponent)}"
