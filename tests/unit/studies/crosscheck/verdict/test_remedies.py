"""The verdict on a run from the verdicts on its quantities, and remedies for undecided ones."""

from dataclasses import replace

import pytest

from ringwear import Scene, Solution
from ringwear.studies.crosscheck.verdict.agreement import Agreement, by_quantity, overall, remedy

FLAT = Scene.load("five_rings").changed(accuracy__rtol=1e-3)
RECESSED = FLAT.changed(punch__recess=[0.0, 0.01, 0.0, 0.01, 0.0])


def test_quantities_at_moving_edges_can_only_cause_disagreement():
    both = ("mdr", "fem")
    sure = Agreement("indentation", both, 1e-5, 1e-4, "agree")
    local = Agreement("pressure", both, 1e-2, 1e-1, "undecided", promised=False)
    assert overall((sure, local)) == "agree"
    assert overall((replace(sure, verdict="undecided"), local)) == "undecided"
    assert overall((sure, replace(local, verdict="disagree"))) == "disagree"


def test_a_quantity_is_shown_with_its_worst_verdict_whatever_the_differences():
    sure = Agreement("indentation", ("mdr", "fem"), 1e-5, 1e-4, "agree")
    worse = replace(sure, difference=1e-6, verdict="undecided")
    assert by_quantity([worse, sure]) == {"indentation": worse}


@pytest.mark.parametrize("scene", [FLAT, RECESSED], ids=["flat", "recessed"])
def test_the_remedy_suggests_a_smaller_rtol(scene):
    """Errors are proportional to rtol: an uncertainty of ten rtol needs a tenth of it."""
    advice = remedy(scene.problem, "profile", "mdr", Solution({}, {}, {}, {}), 1e-2)
    assert "rtol = 1e-04" in advice


def test_the_remedy_suggests_a_larger_rtol_if_elements_have_the_highest_degree():
    solution = Solution({}, {}, {}, {}, limited_by_degree=frozenset({"relaxation_time"}))
    advice = remedy(FLAT.problem, "relaxation_time", "fem", solution, 1e-2)
    assert "a smaller rtol would not help: give a larger one" in advice
