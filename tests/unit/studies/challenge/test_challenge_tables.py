"""Tables of the challenge: generated READMEs, names of problems, and answers on layered ground."""

import pandas as pd
import pytest

from ringwear import SceneError
from ringwear.studies.challenge.answers import (
    COLUMNS,
    certified,
    columns_of_case,
    errors_in,
    read_answers,
)
from ringwear.studies.challenge.printed import FILE, printed_values
from ringwear.studies.challenge.problems import (
    FOLDER,
    OTHERS,
    layered_problems,
    name_of,
    problem_named,
    problems,
)
from ringwear.studies.challenge.rows import (
    answers_table,
    differences_table,
    errors_table,
    printed_table,
    problems_table,
)

LAYERED = layered_problems()


@pytest.mark.parametrize(
    ("page", "table"),
    [
        (FOLDER / "README.md", problems_table()),
        (FOLDER / "README.md", differences_table()),
        (FOLDER / "reference_values.md", printed_table()),
        (OTHERS / "README.md", errors_table()),
        *((path.with_name("README.md"), answers_table(path)) for path in LAYERED),
    ],
)
def test_pages_have_the_generated_tables(page, table):
    assert "\n".join(table) in page.read_text("utf-8")


def test_printed_values_are_compared_with_the_answers():
    table = pd.read_csv(FILE, dtype=str)
    pd.testing.assert_frame_equal(table, printed_values().astype(str), check_dtype=False)
    errors = table["printed"].astype(float) / table["right"].astype(float) - 1
    assert table["error"].astype(float).to_numpy() == pytest.approx(errors.to_numpy(), rel=0.06)


def test_problems_have_names_and_numbers():
    assert [name_of(path)[:2] for path in problems()] == [f"{n:02}" for n in range(1, 17)]
    for name in ("03_five_rings", "five_rings", "3", "03"):
        assert problem_named(name).name == "03_five_rings.toml"
    for name in ("13_bonded_layer", "bonded_layer", "13"):
        assert problem_named(name).parent.name == "13_bonded_layer"


@pytest.mark.parametrize("problem", LAYERED, ids=name_of)
def test_two_methods_agree_in_each_answer(problem):
    """They differ by half a unit of the last digit, and by 1e-7 at most."""
    answers = read_answers(problem)
    assert (answers["digits"] >= 7).all()
    assert (answers["difference"] <= 1e-7).all()
    assert (answers["difference"] <= answers["bound"]).all()
    assert answers["methods"].str.contains(" and ").all()
    assert not answers.duplicated([*columns_of_case(answers), "quantity"]).any()
    digits = answers["value"].str.partition("e")[0].str.count("[0-9]")
    assert (digits == answers["digits"]).all()


def test_a_value_is_given_to_the_digits_in_which_two_methods_agree():
    labels = {"nu": 0.3, "quantity": "stiffness", "unit": "1", "methods": "a and b"}
    pairs = ((2.0, 2.0), (1.23456789, 1.23456789 * (1 + 4e-8)), (-9.9e-5, -9.9e-5 * (1 - 6e-8)))
    table = certified(labels | {"first": first, "second": second} for first, second in pairs)
    assert [*table] == ["nu", *COLUMNS]
    assert [*table["value"]] == ["2.000000000e+00", "1.234568e+00", "-9.90000e-05"]
    assert [*table["digits"]] == [10, 7, 6]
    assert [*table["bound"]] == ["5e-10", "9e-07", "2e-06"]


def test_a_table_of_cases_is_compared_with_the_answers(tmp_path):
    problem, file = problem_named("13"), tmp_path / "mine.csv"
    answers = read_answers(problem).astype({"value": float})
    cases = answers[answers["poisson_ratio"] == 0.3]
    mine = cases[["radius_over_thickness", "poisson_ratio"]].assign(stiffness=cases["value"])
    mine.iloc[2, 2] *= 1.25
    # cases that have no answer are left out
    pd.concat([mine, mine.assign(poisson_ratio=0.31)]).to_csv(file, index=False)
    (row,) = errors_in(problem, file).to_dict("records")
    assert row["values"] == len(mine)
    assert row["error"] == pytest.approx(0.25)
    assert row["case"] == "radius_over_thickness = 0.4, poisson_ratio = 0.3"


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
