"""Options of the study of speed against accuracy."""

from __future__ import annotations

import pytest

from ringwear import Scene, SceneError, study


def test_a_user_quantity_is_a_group():
    # Boussinesq: F / (2 a E*) for a flat punch
    def first_depth(result):
        return float(result.dataset.indentation[0, 0])

    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 0.1])
    results = study("tradeoff", scene, quick=True, quantities=[first_depth], methods=["mdr"])
    assert results.table.group.unique().tolist() == ["first_depth"]
    assert (results.table.error.astype(float) <= results.table.tolerance).all()
    assert results.table.estimate.isna().all()
    assert set(results.tables) == {"digit_price"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"methods": ["rope"]}, "has no 'rope': give some of mdr, bem, fem, direct"),
        ({"methods": ["naive"], "quantities": {"d": lambda _: 1.0}}, "has no 'naive'"),
    ],
)
def test_unknown_methods_are_refused(options, message):
    with pytest.raises(SceneError, match=message):
        study("tradeoff", "flat_punch", quick=True, **options)
