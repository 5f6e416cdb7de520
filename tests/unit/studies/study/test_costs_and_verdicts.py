"""The worst quantity, verdicts on extreme scenes, and the seconds of the challenge."""

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError
from ringwear.studies.extremes import parse, values_of_keys
from ringwear.studies.study.answer import worst
from ringwear.studies.study.declared import verdicts

RUN = {"case": "k = 1", "way": "MDR", "method": "mdr", "quantity": "indentation", "when": "later"}
RUN |= {"seconds": 1.0, "message": None, "outcome": "solved"}


def verdict_of(**facts):
    (verdict,) = verdicts(pd.DataFrame([RUN | {"tolerance": 1e-3} | facts]))
    return verdict


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


def test_the_worst_quantity_of_a_level_decides():
    rows = [RUN | {"error": 1e-5, "estimate": 2e-4, "verdict": "within"}]
    rows += [RUN | {"error": -0.1, "estimate": 1e-4, "verdict": "wrong"}]
    (row,) = worst(pd.DataFrame(rows).assign(level="1", reference=1e-9)).to_dict("records")
    assert (row["verdict"], row["error"], row["estimate"]) == ("wrong", 0.1, 2e-4)


def test_values_of_a_key_are_parsed():
    assert parse("a.b=0:1:3") == ("a.b", {"linspace": [0, 1, 3]})
    key, spaced = parse("punch.wear_ratio=geom:1e-8:1e8:5")
    assert (key, spaced) == ("punch.wear_ratio", {"geomspace": [1e-8, 1e8, 5]})
    assert parse("load.normal_force=1 kN:2 kN:2")[1] == {"linspace": ["1 kN", "2 kN", 2]}
    for text in ("a.b=0:1", "0:1:3", "a.b=0:1:0"):
        with pytest.raises(SceneError, match="give KEY=LOW:HIGH:N"):
            parse(text)
    for text in ("punch.radius=x:1:3", "punch.wear_ratio=geom:0:1:3"):
        with pytest.raises(SceneError, match=text.partition("=")[0]):
            values_of_keys(Scene.load("five_rings"), text, quick=True)
