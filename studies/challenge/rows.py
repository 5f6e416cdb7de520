"""Format the tables of the challenge: the errors of each program, and its seconds.

The errors in the table of the README are read from `others/errors.csv`, which `draw.py` writes.
"""

import pandas as pd

from .problems import OTHERS, difficulty, problems

QUANTITIES = {"indentation": "error of d", "pressure": "error of p"}
"""Quantities in the table, and the columns of their errors."""
HEAD = ("problem", "program", *QUANTITIES.values(), "seconds")
PROGRAMS = {
    "contact_mechanics": ("ContactMechanics", "points"),
    "tamaas": ("Tamaas", "points"),
    "scikit_fem": ("scikit-fem", "elements"),
    "calculix": ("CalculiX", "elements"),
}
"""Programs, and the kind of object whose number is in the names of their files, by name there."""
OUR_METHODS = {"mdr": "ringwear, MDR", "fem": "ringwear, FEM"}
ERRORS = OTHERS / "errors.csv"


def errors_table() -> list[str]:
    """Return the table of `others/errors.csv`, a row for each problem and program."""
    errors = pd.read_csv(ERRORS, dtype=str, keep_default_na=False)
    lines, bounds = head_rows(), errors[errors["bound"] != ""]
    for (problem, program), rows in errors[errors["bound"] == ""].groupby(
        ["problem", "program"], sort=False
    ):
        numbers = [", ".join(rows[name]) for name in (*QUANTITIES.values(), "seconds")]
        lines.append(row_of([problem, _settings(program, rows["setting"]), *numbers]))
    for problem, rows in bounds.groupby("problem", sort=False):
        names = " and ".join(
            OUR_METHODS[method].removeprefix("ringwear, ") for method in rows["program"]
        )
        numbers = [f"below {rows[name].iloc[0]}" for name in QUANTITIES.values()]
        seconds = f"{' and '.join(rows['seconds'])}, at {rows['setting'].iloc[0].split()[-1]}"
        lines.append(row_of([problem, f"ringwear, {names}", *numbers, seconds]))
    return lines


def problems_table() -> list[str]:
    """Return the table of the problems with their difficulties."""
    rows = [row_of([f"[`{path.stem}`]({path.name})", difficulty(path)]) for path in problems()]
    return [row_of(["problem", "difficulty"]), "| --- | --- |", *rows]


def _settings(program: str, settings: pd.Series) -> str:
    """Return the name of a program, with the numbers of points or elements of its rows."""
    if program in OUR_METHODS:
        return OUR_METHODS[program]
    counts = [setting.split()[0] for setting in settings]
    return f"{program}, {', '.join(counts)} {settings.iloc[0].split()[1]}"


def head_rows() -> list[str]:
    """Return the first two lines of the table of errors."""
    return [row_of(HEAD), row_of(["---"] * len(HEAD))]


def row_of(cells: "list[str] | tuple[str, ...]") -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cells)} |"


def written_error(error: float) -> str:
    """Return an error in two digits, such as 1.9e-3; NaN as \"not given\"."""
    if error != error:
        return "not given"
    number, _, exponent = f"{error:.1e}".partition("e")
    return f"{number}e{int(exponent)}"
