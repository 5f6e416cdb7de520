"""Faults of single numbers of a shaped punch are noticed, wherever they arise.

The punch wears until all of its face is in contact, so that its answer has every number. Faults of
2 % (20 times rtol) are put into the table, into the answer and into the files, at all times or at
one, of one method or of both, or on the other ring. Faults at one time of what both methods have
computed are larger than the errors that the methods state then.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from faults.changes import scale, swap
from faults.scenes import shared, with_results, with_table
from groups import nightly_but
from natural import natural

from ringwear.studies.crosscheck.problem.quantities import ANSWER, HISTORIES, STEADY

SCENE = natural(
    {
        "radius": 2.0,
        "ring_edges": [0.9, 2.0],
        "wear_coefficients": [1.0, 3.0],
        "profile": {"kind": "ball", "ball_radius": 20.0},
    },
    [0.0, 0.3, 3.0, 12.0, 30.0, 60.0],
    load={"normal_force": 0.05},
)
SIZE = 0.02
LABELS = {"solver", "state", "ring", "mode", "edge", "scene"}


@pytest.fixture(scope="module")
def right():
    result = shared(SCENE)
    assert result.verdict == "agree"
    return result


def inverted(values, *_):
    if "contact" in values:
        values["contact"][...] = 1 - values["contact"]


def finite(result, name):
    return np.isfinite(np.asarray(result.dataset[name], dtype=float)).any()


def in_table(right):
    for name in right.dataset.variables:
        if name in LABELS or not finite(right, name):
            continue
        dims = right.dataset[name].dims
        yield name, scale(name, SIZE)
        if "solver" in dims:
            if "time" in dims and name != "contact":
                yield f"{name} at one time", scale(name, SIZE, 2)
            if dims[-1:] == ("ring",):
                yield f"{name} of the other ring", swap(name)
    yield "contact inverted", inverted


def in_computed(right):
    for name in HISTORIES:
        yield name, scale(name, SIZE)
        yield f"{name} in full contact", scale(name, 0.03, -2)
        # while edges move, methods state errors of several per cent
        yield f"{name} while edges move", scale(name, 0.1, 2)
    for name in (*ANSWER, *STEADY):
        if name in right.dataset and finite(right, name):
            yield name, scale(name, SIZE)
    for name in ("ring_force", "ring_worn_volume", "worn_volume", "force_share"):
        yield f"{name} of the other ring", swap(name)
    yield "contact inverted", inverted


def in_answers(right):
    for name in right.answers["mdr"]:
        if finite(right, name):
            yield name, scale(name, SIZE)
            if np.ndim(right.answers["mdr"][name]) and not name.endswith("_error"):
                yield f"{name} of the other ring", swap(name)


def with_answers(right, change):
    """Return the result with the answers of one of the methods changed."""
    answers = {method: dict(numbers) for method, numbers in right.answers.items()}
    answers["twin"] = {name: np.array(value) for name, value in answers["twin"].items()}
    change(answers["twin"], None, None)
    judgement = replace(right.judgement, answers=answers)
    return replace(right, answers=answers, judgement=judgement)


PLACES = {
    "table": (in_table, with_table),
    "table of one method": (in_table, partial(with_table, alone=True)),
    "computed": (in_computed, with_results),
    "answers": (in_answers, with_answers),
}


# anchors may divide by damaged numbers
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("place", nightly_but(("computed", "answers"), PLACES))
def test_a_wrong_number_is_noticed(right, place):
    faults, with_fault = PLACES[place]
    tried = dict(faults(right))
    assert len(tried) >= 20
    agree = [name for name, of in tried.items() if with_fault(right, of).verdict == "agree"]
    assert agree == []
