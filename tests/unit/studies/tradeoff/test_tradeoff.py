"""The price of a digit, effectivities and the table of the study of speed against accuracy."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene
from ringwear.studies.crosscheck.problem.quantities import GROUPS
from ringwear.studies.study.levels import Record
from ringwear.studies.tradeoff import measure
from ringwear.studies.tradeoff.draw import read_challenge
from ringwear.studies.tradeoff.prices import (
    conclude_prices,
    fit_digit_price,
    list_effectivities,
    list_prices,
)
from ringwear.studies.tradeoff.study import COLUMNS
from ringwear.studies.tradeoff.ways import Ways

OTHERS = Path(__file__).parents[4] / "studies" / "challenge" / "others"
ERRORS = 10.0 ** -np.arange(1.0, 7.0)
SCATTER = np.array([1.1, 0.9, 1.05, 0.95, 1.1, 0.9])


@pytest.mark.parametrize("price", [1.15, 2.0, 10.0])
def test_the_price_of_a_digit_of_exact_seconds(price):
    fitted = fit_digit_price(0.02 * price ** np.arange(6), ERRORS)
    assert [fitted.price, fitted.lower, fitted.upper] == pytest.approx([price] * 3)
    assert fitted.levels == 6
    assert not fitted.why_not


def test_the_interval_is_that_of_students_distribution():
    from scipy.stats import linregress, t

    seconds = SCATTER * 1.3 ** np.arange(6)
    fitted = fit_digit_price(seconds, ERRORS)
    line = linregress(np.arange(1.0, 7.0), np.log10(seconds))
    half = t.ppf(0.975, 4) * line.stderr
    expected = 10.0 ** np.array([line.slope, line.slope - half, line.slope + half])
    assert [fitted.price, fitted.lower, fitted.upper] == pytest.approx(expected.tolist())
    assert fitted.lower < 1.3 < fitted.upper


@pytest.mark.parametrize(
    ("seconds", "errors", "reason"),
    [
        ([1.0, 2.0], [1e-1, 1e-2], "fewer than 3 levels"),
        # the second tolerance changed nothing
        ([1.0, 1.0, 2.0], [1e-1, 1e-1, 1e-2], "fewer than 3 levels"),
        ([1.0, 2.0, 3.0, 4.0], [1e-1, 0.0, np.nan, 1e-2], "fewer than 3 levels"),
        (SCATTER, ERRORS, "contains 1"),
        # seconds double, and errors hardly fall
        ([1.0, 2.0, 4.0, 8.0], [0.104, 0.103, 0.102, 0.101], "within 0.013 digits"),
        ([1.0, 2.0, 4.0, 8.0], [1e-4, 1e-3, 1e-2, 1e-1], "errors do not fall"),
    ],
)
def test_a_price_that_cannot_be_determined_says_why(seconds, errors, reason):
    fitted = fit_digit_price(np.array(seconds), np.array(errors))
    assert reason in fitted.why_not
    assert fitted.in_words.startswith("cannot be told: ")


def levels():
    rows = [
        {
            "group": "fields",
            "method": name,
            "seconds": price**digits,
            "tolerance": 10.0**-digits,
            "error": error,
            "estimate": 4 * error,
            "effectivity": 4.0,
        }
        for name, price in (("mdr", 1.5), ("fem", 1.0))
        for digits, error in ((1, 1e-2), (2, 1e-3), (3, 2e-3), (4, 1e-5))
    ]
    return pd.DataFrame(rows)


def test_conclusions_state_the_price_or_that_it_cannot_be_determined():
    rows = levels()
    rows["error"] = rows.tolerance / 10
    conclusion, untold = conclude_prices(list_prices(rows))
    assert conclusion == (
        "fields, mdr: one more digit multiplies the seconds by 1.5 (interval 1.5 to 1.5)."
    )
    assert untold.startswith("fields, fem: the price of a digit cannot be told: ")


def test_effectivities_count_tolerances_that_are_missed():
    row, _ = list_effectivities(levels()).to_dict("records")
    assert (row["median effectivity"], row["levels"]) == (4.0, 4)
    # 2e-3 is above 1e-3, and the estimate of 8e-3 states so
    assert (row["levels beyond the tolerance"], row["of these, stated"]) == (1, 1)


def test_seconds_are_medians_of_at_least_three_runs(monkeypatch):
    clock = iter([0.0, 5.0, 5.0, 6.0, 6.0, 8.0])
    monkeypatch.setattr(measure.time, "process_time", lambda: next(clock))
    _, timing = measure.time_runs(lambda: None)
    assert timing.row == {"seconds": 2.0, "least seconds": 1.0, "greatest seconds": 5.0, "runs": 3}


def test_an_effectivity_is_the_estimate_over_the_error():
    row = measure.row_of_accuracy(2e-3, 2e-2)
    assert (row["estimate"], row["error"], row["effectivity"]) == pytest.approx((2e-2, 2e-3, 10.0))
    assert np.isnan(measure.row_of_accuracy(0.0, 1e-3)["effectivity"])


def test_the_table_has_tolerance_estimate_error_and_effectivity():
    # only the steady state, whose reference is computed quickly
    problem = Scene.load("five_rings").problem.with_quantities(GROUPS["steady"])
    ways = Ways.with_references(problem, ("mdr", "direct"), quick=True)
    families = [each for each in ways.families() if each.name.startswith("steady state")]
    table = Record().solve("tradeoff", families, COLUMNS)
    assert {"seconds", "tolerance", "estimate", "error", "effectivity"} < {*table.columns}
    by_mdr = table[table.method == "mdr"]
    assert by_mdr.tolerance.tolist() == [1e-1, 1e-2, 1e-3]
    # true errors are within the tolerance and within the estimate
    assert (by_mdr.error <= by_mdr.tolerance).all()
    assert (by_mdr.effectivity >= 1).all()
    np.testing.assert_allclose(by_mdr.effectivity, by_mdr.estimate / by_mdr.error)
    assert (by_mdr["least seconds"] <= by_mdr.seconds).all()
    assert (by_mdr.seconds <= by_mdr["greatest seconds"]).all()
    assert (by_mdr.runs >= 3).all()
    assert table[table.method == "direct"].tolerance.isna().all()


def test_the_challenge_is_drawn_as_its_readme_says():
    text = (OTHERS / "README.md").read_text("utf-8")
    lines = [line.strip("| \n").split(" | ") for line in text.splitlines() if line[:1] == "|"]
    written = {}
    for problem, program, *numbers in lines[2:]:
        name = program.split(",")[-1].strip().lower() if "ringwear" in program else program
        name = name.split(",")[0]
        if numbers[0].startswith("below"):
            continue
        values = [[float(of) for of in number.split(", ")] for number in numbers]
        written[int(problem), name] = values
    challenge = read_challenge()
    for (problem, program), rows in challenge[challenge.bound.isna()].groupby(
        ["problem", "program"]
    ):
        drawn = rows[["error of d", "error of p", "seconds"]].to_numpy().T.tolist()
        assert drawn == written[problem, program]
    bounds = challenge[challenge.bound.notna()]
    assert {*bounds.problem} == {7}
    assert "below 2e-11 | below 1e-5 | 0.15 and 0.83, at 1e-1" in text


def test_the_seconds_of_the_challenge_are_those_of_its_files():
    prefix = {
        "ContactMechanics": "contact_mechanics",
        "Tamaas": "tamaas",
        "scikit-fem": "scikit_fem",
        "CalculiX": "calculix",
    }
    others = read_challenge().query("program in @prefix")
    for row in others.itertuples():
        number = int(row.setting.split()[0])
        file = OTHERS / f"{row.problem:02}_{prefix[row.program]}_{number:03}.csv"
        with file.open() as lines:
            seconds = float(next(csv.reader(lines, delimiter=" "))[1])
        assert row.seconds == pytest.approx(seconds, rel=0.05)
