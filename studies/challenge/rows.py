"""Rows of the table of the challenge: what a program errs by, and its seconds.

The errors that the README tells are in `others/errors.csv`; `draw.py` measures them anew.
"""

import pandas as pd

from .problems import OTHERS, difficulty, problems

QUANTITIES = {"indentation": "error of d", "pressure": "error of p"}
"""What is told, and its column."""
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


def errors_table() -> list[str]:
    """Return the table of `others/errors.csv`, a row for each problem and program."""
    told = pd.read_csv(ERRORS, dtype=str, keep_default_na=False)
    lines, bounds = head_rows(), told[told["bound"] != ""]
    for (problem, program), rows in told[told["bound"] == ""].groupby(
        ["problem", "program"], sort=False
    ):
        numbers = [", ".join(rows[name]) for name in (*QUANTITIES.values(), "seconds")]
        lines.append(row_of([problem, _settings(program, rows["setting"]), *numbers]))
    for problem, rows in bounds.groupby("problem", sort=False):
        names = " and ".join(OURS[of].removeprefix("ringwear, ") for of in rows["program"])
        numbers = [f"below {rows[name].iloc[0]}" for name in QUANTITIES.values()]
        seconds = f"{' and '.join(rows['seconds'])}, at {rows['setting'].iloc[0].split()[-1]}"
        lines.append(row_of([problem, f"ringwear, {names}", *numbers, seconds]))
    return lines


def problems_table() -> list[str]:
    """Return the table of the problems, and what is hard in each."""
    rows = [row_of([f"[`{of.stem}`]({of.name})", difficulty(of)]) for of in problems()]
    return [row_of(["problem", "what is hard in it"]), "| --- | --- |", *rows]


def _settings(program: str, settings: pd.Series) -> str:
    """Return the name of a program with its numbers of points or elements."""
    if program in OURS:
        return OURS[program]
    counts = [setting.split()[0] for setting in settings]
    return f"{program}, {', '.join(counts)} {settings.iloc[0].split()[1]}"


def head_rows() -> list[str]:
    """Return the first two lines of the table of errors."""
    return [row_of(HEAD), row_of(["---"] * len(HEAD))]


def row_of(cells: "list[str] | tuple[str, ...]") -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cells)} |"


def written_error(error: float) -> str:
    """Return an error in two digits, as 1.9e-3."""
    if error != error:
        return "not given"
    number, _, exponent = f"{error:.1e}".partition("e")
    return f"{number}e{int(exponent)}"
