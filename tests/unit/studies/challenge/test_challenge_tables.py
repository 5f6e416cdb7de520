"""Tables of the challenge: its pages, names of problems, and answers on layered ground."""

from decimal import Decimal

import pandas as pd
import pytest

from ringwear import SceneError
from ringwear.studies.challenge.answers import (
    columns_of_case,
    errors_in,
    read_answers,
)
from ringwear.studies.challenge.problems import (
    FOLDER,
    SCENE,
    problem_name,
    problem_named,
    problems,
)

LAYERED = [path for path in problems() if path.name == SCENE]
OTHERS = FOLDER / "others"
PROGRAMS = ("ContactMechanics", "Tamaas", "scikit-fem", "CalculiX")


def rows_of(page):
    """Return the rows of all tables of a page, cell by cell."""
    lines = page.read_text("utf-8").splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line[:1] == "|"]


def plain(value):
    """Return a number such as 1.20e+01 without an exponent, with all of its digits."""
    return f"{Decimal(value):f}"


@pytest.mark.parametrize("problem", LAYERED, ids=problem_name)
def test_the_page_of_a_problem_has_its_answers(problem):
    answers = read_answers(problem)
    case = columns_of_case(answers)
    if len({*answers["quantity"]}) == 1:
        *case, last = case
        answers["quantity"] = [f"{last} = {number:g}" for number in answers[last]]
    rows = rows_of(problem.with_name("README.md"))
    (start,) = (number for number, row in enumerate(rows) if row[0] == case[0])
    head, _, *rows = rows[start:]
    written = {
        (*row[: len(case)], heading): value
        for row in rows
        for heading, value in zip(head[len(case) :], row[len(case) :], strict=True)
        if value
    }
    places = [
        ["" if number != number else f"{number:g}" for number in numbers]
        for numbers in answers[case].to_numpy(dtype=float)
    ]
    assert written == {
        (*place, quantity): plain(value)
        for place, quantity, value in zip(
            places, answers["quantity"], answers["value"], strict=True
        )
    }


def test_the_page_of_the_challenge_has_all_problems_and_methods():
    rows = rows_of(FOLDER / "README.md")
    for problem in problems():
        name = problem_name(problem)
        address = f"{name}/README.md" if problem in LAYERED else f"{name}.toml"
        first = problem.read_text("utf-8").partition("\n")[0]
        assert [f"[`{name}`]({address})", first.removeprefix("# ").rstrip(".")] in rows
    for problem in LAYERED:
        for methods, answers in read_answers(problem).groupby("methods"):
            numbers = f"{len(answers)} {answers['difference'].max():.1e} {answers['digits'].min()}"
            assert [problem_name(problem)[:2], methods, *numbers.split()] in rows


def test_printed_values_are_compared_with_the_answers():
    rows = rows_of(FOLDER / "reference_values.md")
    printed = pd.read_csv(FOLDER / "printed_values.csv", dtype=str)
    assert len(printed) == len(rows) - 2
    for row in printed.itertuples():
        answers = read_answers(problem_named(row.problem))
        of_case = answers.query(f"quantity == '{row.quantity}' and {where(row)}")
        assert row.right == of_case["value"].item()
        assert row.methods == of_case["methods"].item()
        assert float(row.difference) == pytest.approx(of_case["difference"].item())
        error = float(row.printed) / float(row.right) - 1
        assert float(row.error) == pytest.approx(error, rel=0.06)
        place = f"{row.quantity}, {row.where}"
        assert [row.source, place, row.printed, plain(row.right), row.error] in rows


def where(row):
    """Return the case of a printed value as an expression."""
    return row.where.replace(" = ", " == ").replace(", ", " and ")


def test_the_errors_of_other_programs_are_written_as_in_their_file():
    rows = rows_of(OTHERS / "README.md")
    errors = pd.read_csv(OTHERS / "errors.csv", dtype=str, keep_default_na=False)
    columns = ["error of d", "error of p", "seconds"]
    for (problem, program), group in errors.query("bound == ''").groupby(["problem", "program"]):
        counts, units = zip(*group["setting"].str.split(" "), strict=True)
        name = f"{program}, {', '.join(counts)} {units[0]}"
        if program not in PROGRAMS:
            name = f"ringwear, {program.upper()}"
        assert [problem, name, *(", ".join(group[column]) for column in columns)] in rows
    bounds = errors.query("bound != ''")
    (of_d,), (of_p,) = ({*bounds[column]} for column in columns[:2])
    seconds = f"{' and '.join(bounds['seconds'])}, at 1e-1"
    assert ["7", "ringwear, MDR and FEM", f"below {of_d}", f"below {of_p}", seconds] in rows


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("radius_over_thickness,stiffness\n1,2", "no column poisson_ratio"),
        ("radius_over_thickness,poisson_ratio,k\n1,0.3,2", "no value of 13_bonded_layer"),
        ("radius_over_thickness,poisson_ratio,stiffness\n1,0.31,2", "no value of 13_bonded"),
    ],
)
def test_tables_without_a_case_are_refused(tmp_path, text, message):
    (tmp_path / "mine.csv").write_text(text, "utf-8")
    with pytest.raises(SceneError, match=message):
        errors_in(problem_named("13"), tmp_path / "mine.csv")


def test_tables_over_times_and_radii_are_left_to_the_check(tmp_path):
    (tmp_path / "mine.csv").write_text("time,radius,pressure\n0,0.5,1\n", "utf-8")
    for name in ("3", "14", "16"):
        assert errors_in(problem_named(name), tmp_path / "mine.csv") is None
