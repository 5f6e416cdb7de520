"""Options of the study of speed against accuracy."""

from __future__ import annotations

import pytest

from ringwear import Scene, SceneError, study


@pytest.mark.slow
def test_a_user_quantity_replaces_the_groups():
    # Boussinesq: F / (2 a E*) for a flat punch
    def first_depth(result):
        return float(result.dataset.indentation[0, 0])

    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 0.1])
    results = study("tradeoff", scene, quick=True, quantities=[first_depth], methods=["mdr"])
    assert results.table["quantity"].unique().tolist() == ["first_depth"]
    assert (results.table["error"].abs() <= results.table["tolerance"]).all()
    assert results.table["estimate"].isna().all()
    assert set(results.tables) == {"digit_price"}


@pytest.mark.slow
def test_direct_integration_is_timed_for_the_steady_state():
    scene = Scene.load("five_rings").changed(wear__times=[])
    results = study("tradeoff", scene, quick=True, methods=["mdr", "direct"])
    table = results.table[results.table["case"] == "steady state"]
    by_mdr = table[table["method"] == "mdr"]
    assert by_mdr["tolerance"].unique().tolist() == [1e-1, 1e-2, 1e-3]
    # true errors are within the tolerance and within the estimate
    assert (by_mdr["error"].abs() <= by_mdr["tolerance"]).all()
    assert (by_mdr["estimate"] >= by_mdr["error"].abs()).all()
    assert table[table["method"] == "direct"]["tolerance"].isna().all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"methods": ["rope"]}, "has no 'rope', because it is not a method: give some of mdr, bem"),
        ({"methods": ["naive"], "quantities": {"d": lambda _: 1.0}}, "has no 'naive'"),
    ],
)
def test_unknown_methods_are_refused(options, message):
    with pytest.raises(SceneError, match=message):
        study("tradeoff", "flat_punch", quick=True, **options)
