"""The price of a digit, effectivities of estimates, and verdicts on extreme scenes."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ringwear import SceneError
from ringwear.studies.extremes import Varied, judged, parse, verdicts
from ringwear.studies.tradeoff import (
    conclude_prices,
    fit_digit_price,
    list_effectivities,
    list_prices,
)

ERRORS = 10.0 ** -np.arange(1.0, 7.0)
SCATTER = np.array([1.1, 0.9, 1.05, 0.95, 1.1, 0.9])


@pytest.mark.parametrize("price", [1.15, 2.0, 10.0])
def test_the_price_of_a_digit_of_exact_seconds(price):
    fitted = fit_digit_price(0.02 * price ** np.arange(6), ERRORS)
    assert [fitted.price, fitted.lower, fitted.upper] == pytest.approx([price] * 3)
    assert fitted.levels == 6
    assert not fitted.why_not


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
    assert reason in fit_digit_price(np.array(seconds), np.array(errors)).why_not


def levels():
    rows = [
        {
            "case": "fields",
            "way": name,
            "seconds": price**digits,
            "tolerance": 10.0**-digits,
            "error": error,
            "estimate": 4 * error,
            "reference": 1e-9,
        }
        for name, price in (("MDR", 1.5), ("FEM", 1.0))
        for digits, error in ((1, 1e-2), (2, 1e-3), (3, 2e-3), (4, 1e-5))
    ]
    return pd.DataFrame(rows)


def test_conclusions_state_the_price_or_that_it_cannot_be_determined():
    rows = levels()
    rows["error"] = rows.tolerance / 10
    conclusion, untold = conclude_prices(list_prices(rows))
    assert conclusion == (
        "MDR: one more digit multiplies the seconds by: fields: 1.5 (interval 1.5 to 1.5)."
    )
    assert untold.startswith(
        "FEM: one more digit multiplies the seconds by: fields: cannot be told"
    )


def test_effectivities_count_tolerances_that_are_missed():
    row, _ = list_effectivities(levels()).to_dict("records")
    assert (row["median effectivity"], row["levels"]) == (4.0, 4)
    # 2e-3 is above 1e-3, and the estimate of 8e-3 states so
    assert (row["levels beyond the tolerance"], row["of these, stated"]) == (1, 1)
    # an error below that of the reference says nothing about the estimate
    hidden = list_effectivities(levels().assign(reference=1e-4))
    assert hidden["levels"].tolist() == [3, 3]


RUN = {"case": "k = 1", "way": "MDR", "method": "mdr", "quantity": "indentation", "when": "later"}
RUN |= {"seconds": 1.0, "message": None, "outcome": "solved"}


def verdict_of(**facts):
    table = pd.DataFrame([RUN | facts])
    return judged(table, {"k = 1": Varied("k", 1.0, 1.0, None)}, 1e-3)["verdict"].item()


@pytest.mark.parametrize(
    ("error", "estimate", "verdict"),
    [
        # the error is below the tolerance, whatever the estimate
        (5e-4, 1e-6, "within"),
        (5e-4, 1.0, "within"),
        (2e-3, 1e-3, "degraded"),
        (-2e-3, 1e-3, "degraded"),
        (0.1, 1.0, "degraded"),
        (4e-3, 1e-3, "wrong"),
        # a naive solver states nothing
        (4e-3, np.nan, "wrong"),
        (np.inf, 1e-3, "wrong"),
        (np.nan, 1e-3, "unjudged"),
    ],
)
def test_verdicts_on_a_promise(error, estimate, verdict):
    assert verdict_of(error=error, estimate=estimate) == verdict


@pytest.mark.parametrize("outcome", ["refused", "crashed"])
def test_runs_without_a_result_have_their_outcome_as_verdict(outcome):
    assert verdict_of(error=np.nan, estimate=np.nan, outcome=outcome) == outcome


def test_the_worst_quantity_of_a_run_decides():
    rows = [RUN | {"error": 1e-5, "estimate": 1e-4}]
    rows += [RUN | {"quantity": "pressure", "error": 0.1, "estimate": 1e-4}]
    table = judged(pd.DataFrame(rows), {"k = 1": Varied("k", 1.0, 1.0, None)}, 1e-3)
    (row,) = verdicts(table.assign(parameter=1.0)).to_dict("records")
    assert (row["verdict"], row["quantity"]) == ("wrong", "pressure")


def test_values_of_a_key_are_parsed():
    assert parse("a.b=0:1:3") == ("a.b", [0, 0.5, 1])
    key, values = parse("punch.wear_ratio=geom:1e-8:1e8:5")
    assert key == "punch.wear_ratio"
    assert values == [1e-8, 1e-4, 1, 1e4, 1e8]
    for text in ("a.b=0:1", "a.b=geom:0:1:3", "0:1:3", "a.b=0:1:0", "a.b=x:1:3"):
        with pytest.raises(SceneError, match="give KEY=LOW:HIGH:N"):
            parse(text)
