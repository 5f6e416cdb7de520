"""Faults of single numbers of a shaped punch are noticed, wherever they arise.

The punch wears until all of its face is in contact, so that its answer has every number. Faults of
2 % (20 times rtol) are put into the table, into the answer and into the files, at all times or at
one, of one method or of both, or on the other ring. Faults at one time of what both methods have
computed are larger than the errors that the methods state then.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from faults import computed
from faults.scenes import shared, with_table
from groups import nightly_but

from ringwear import RingwearError, Scene, SceneError, load
from ringwear.studies.crosscheck import write_numbers
from ringwear.studies.crosscheck.problem.quantities import ANSWER, HISTORIES, STEADY

SCENE = Scene.from_table(
    {
        "punch": {
            "radius": 2.0,
            "ring_edges": [0.9, 2.0],
            "wear_coefficients": [1.0, 3.0],
            "profile": {"kind": "ball", "ball_radius": 20.0},
        },
        "half_space": {"plane_strain_modulus": 1.0},
        "load": {"normal_force": 0.05},
        "wear": {"times": [0.0, 0.3, 3.0, 12.0, 30.0, 60.0]},
        "accuracy": {"rtol": 1e-3},
    }
)
SIZE = 0.02
LABELS = {"solver", "state", "ring", "mode", "edge", "scene"}


@pytest.fixture(scope="module")
def right():
    result = shared(SCENE)
    assert result.verdict == "agree"
    return result


def scaled(name, *where, size=SIZE):
    def change(values, *_):
        # the contact and its edges are not among the values on the face
        if name in values:
            values[name][where or ...] *= 1 + size

    return change


def reversed_last(name):
    def change(values, *_):
        values[name][...] = values[name][..., ::-1].copy()

    return change


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
        yield name, scaled(name)
        if "solver" in dims:
            yield f"{name} of one method", scaled(name, 1)
        if "time" in dims and "solver" in dims and name != "contact":
            yield f"{name} at one time", scaled(name, slice(None), 2)
        if dims[-1:] == ("ring",) and "solver" in dims:
            yield f"{name} of the other ring", reversed_last(name)
    yield "contact inverted", inverted


def noticed_in_table(right, change):
    return with_table(right, change).verdict == "disagree"


def in_computed(right):
    for name in HISTORIES:
        yield name, scaled(name)
        yield f"{name} in full contact", scaled(name, -2, size=0.03)
        # while edges move, methods state errors of several per cent
        yield f"{name} while edges move", scaled(name, 2, size=0.1)
    for name in (*ANSWER, *STEADY):
        if name in right.dataset and finite(right, name):
            yield name, scaled(name)
    for name in ("ring_force", "ring_worn_volume", "worn_volume", "force_share"):
        yield f"{name} of the other ring", reversed_last(name)
    yield "contact inverted", inverted


def noticed_in_computed(right, change):
    return computed.with_results(right, change).verdict == "disagree"


def in_answers(right):
    for name in right.answers["mdr"]:
        if finite(right, name):
            yield name, scaled(name)
            if np.ndim(right.answers["mdr"][name]) and not name.endswith("_error"):
                yield f"{name} of the other ring", reversed_last(name)


def _with_answers(right, change):
    """Return the answers of all methods, those of one of them changed."""
    answers = {method: dict(numbers) for method, numbers in right.answers.items()}
    answers["twin"] = {name: np.array(value) for name, value in answers["twin"].items()}
    change(answers["twin"])
    return answers


def noticed_in_answers(right, change):
    answers = _with_answers(right, change)
    judgement = replace(right.judgement, answers=answers)
    return replace(right, answers=answers, judgement=judgement).verdict == "disagree"


PLACES = {
    "table": (in_table, noticed_in_table),
    "computed": (in_computed, noticed_in_computed),
    "answers": (in_answers, noticed_in_answers),
}


# anchors may divide by damaged numbers
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("place", nightly_but(("computed", "answers"), PLACES))
def test_a_wrong_number_is_noticed(right, place):
    faults, noticed = PLACES[place]
    tried = dict(faults(right))
    assert len(tried) >= 20
    assert [name for name, change in tried.items() if not noticed(right, change)] == []


def test_other_numbers_in_the_files_are_refused(right, tmp_path):
    wrong = replace(right, answers=_with_answers(right, scaled("time_to_90"))).summary
    with pytest.raises(RingwearError, match="time_to_90 is not the result"):
        write_numbers(right.dataset, wrong, tmp_path)
    write_numbers(right.dataset, right.summary, tmp_path)
    entries = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    entries["answer"]["mdr"]["time_to_full_contact"] *= 1 + SIZE
    (tmp_path / "summary.json").write_text(json.dumps(entries), "utf-8")
    with pytest.raises(SceneError, match=r"summary\.json is not as it was written"):
        load(tmp_path)
