"""Methods compared as operators, for every pressure at once, by whole runs."""

import pytest
from independent import true_errors
from random_scenes import random_scenes

from ringwear import Scene, run
from ringwear.studies.crosscheck.verdict import operators

FIVE = Scene.load("five_rings")


@pytest.mark.slow
def test_the_operator_difference_bounds_the_error_of_histories(random_seed):
    (*_, scene) = random_scenes(20, random_seed + 1, most_rings=3)
    # a comparison on the pressure space does not include the error of that space, which is small
    # relative to rtol
    rtol = max(scene.accuracy.rtol, 1e-5)
    result = run(scene.changed(accuracy__rtol=rtol), methods=["mdr", "fem"])
    error = true_errors(result)["fem"]["indentation"][0].max()
    assert error <= 1.5 * result.operators[0].history + 0.02 * rtol


@pytest.mark.slow
def test_three_methods_are_compared_as_operators():
    result = run(FIVE, methods=["mdr", "bem", "fem"])
    pairs = {row.methods: row for row in result.operators}
    assert set(pairs) == {("fem", "mdr"), ("fem", "bem"), ("mdr", "bem")}
    theory = pairs["mdr", "bem"]
    assert max(theory.rings, theory.history) <= 1e-9
    assert theory.space <= 1e-6
    assert pairs["fem", "mdr"].rings == pytest.approx(pairs["fem", "bem"].rings, rel=1e-3)
    # long waves are resolved best
    by_wave = pairs["fem", "mdr"].differences
    assert by_wave[:5].max() < 1e-5 < by_wave[len(by_wave) // 2 :].min()


def test_on_large_spaces_a_coarser_one_is_compared(monkeypatch):
    """Steady states and histories need few pressures, so that their differences stay the same."""
    scene = Scene.load("five_rings").changed(accuracy__rtol=1e-3)
    whole = run(scene, methods=["bem", "mdr"]).operators[0]
    monkeypatch.setattr(operators, "MOST_PRESSURES", 200)
    result = run(scene, methods=["bem", "mdr"])
    coarser = result.operators[0]
    assert not result.left_out_operators
    assert len(coarser.differences) <= 200 < len(whole.differences)
    for name in ("rings", "history"):
        assert getattr(coarser, name) == pytest.approx(getattr(whole, name), rel=0.5, abs=1e-6)


def test_methods_that_cannot_be_compared_as_operators_are_named(monkeypatch):
    """No subspace has fewer pressures than there are rings."""
    monkeypatch.setattr(operators, "MOST_PRESSURES", 3)
    scene = Scene.load("five_rings").changed(accuracy__rtol=1e-3)
    result = run(scene, methods=["bem", "mdr"])
    assert not result.operators
    assert "bem and mdr" in result.summary["left_out"]["methods as operators"]
    assert any("bem and mdr" in note for note in result.notes)
