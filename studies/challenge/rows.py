"""Format the tables of the challenge: the errors of each program, its seconds, and answers.

The errors in the table of the README are read from `others/errors.csv`, which `draw.py` writes, and
answers from `answers.csv` of each problem.
"""

from decimal import Decimal
from pathlib import Path

import pandas as pd

from .answers import columns_of_case, read_answers
from .printed import FILE
from .problems import (
    OTHERS,
    SCENE,
    difficulty,
    layered_problems,
    name_of,
    number_of,
    problems,
)

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
    rows = [
        row_of([f"[`{name_of(path)}`]({_page_of(path)})", difficulty(path)]) for path in problems()
    ]
    return [row_of(["problem", "difficulty"]), "| --- | --- |", *rows]


def _page_of(problem: Path) -> str:
    """Return the address of a problem in the README: its scene file, or its folder's README."""
    return f"{name_of(problem)}/README.md" if problem.name == SCENE else problem.name


def differences_table() -> list[str]:
    """Return the greatest difference of each pair of methods in the answers of each problem."""
    rows = []
    for problem in layered_problems():
        answers = read_answers(problem)
        for methods, of_pair in answers.groupby("methods", sort=False):
            cells = [len(of_pair), f"{of_pair['difference'].max():.1e}", of_pair["digits"].min()]
            rows.append(row_of([str(number_of(problem)), str(methods), *map(str, cells)]))
    head = ["problem", "methods", "values", "greatest difference", "fewest digits"]
    return [row_of(head), row_of(["---"] * len(head)), *rows]


def printed_table() -> list[str]:
    """Return the values that were printed elsewhere, from `printed_values.csv`."""
    table = pd.read_csv(FILE, dtype=str)
    rows = [
        [
            row.source,
            f"{row.quantity}, {row.where}",
            row.printed,
            f"{Decimal(row.right):f}",
            row.error,
        ]
        for row in table.itertuples()
    ]
    head = ["source", "quantity", "printed", "right", "relative error"]
    return [row_of(head), row_of(["---"] * len(head)), *map(row_of, rows)]


def answers_table(problem: Path) -> list[str]:
    """Return the answers of a problem with a row for each case.

    Quantities have columns; a single quantity has a column for each number of the last column of
    the case instead.
    """
    answers = read_answers(problem)
    case = columns_of_case(answers)
    answers["value"] = [f"{Decimal(value):f}" for value in answers["value"]]
    single = answers["quantity"].nunique() == 1
    rows, columns = (case[:-1], case[-1]) if single else (case, "quantity")
    # cases without a number in a column, such as histories without a radius, keep their place
    groups = answers.groupby(rows, sort=False, dropna=False)
    names = [*answers[columns].unique()]
    head = [*rows, *(f"{columns} = {name:g}" if single else str(name) for name in names)]
    lines = [row_of(head), row_of(["---"] * len(head))]
    for numbers, group in groups:
        values = group.set_index(columns)["value"]
        place = [f"{number:g}" if number == number else "" for number in numbers]
        lines.append(row_of([*place, *(values.get(name, "") for name in names)]))
    return lines


def answer_errors_table(problem: Path, program: str, errors: pd.DataFrame) -> list[str]:
    """Return the errors of a program in a table of cases, with a row for each quantity."""
    head = ["problem", "program", "quantity", "values", "greatest relative error", "case"]
    lines = [row_of(head), row_of(["---"] * len(head))]
    for row in errors.itertuples():
        cells = [str(row.quantity), str(row.values), written_error(row.error), str(row.case)]
        lines.append(row_of([str(number_of(problem)), program, *cells]))
    return lines


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
