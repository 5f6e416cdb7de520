"""Differences along the radius, and the figures that show how small they are."""

import numpy as np
import pytest
from groups import nightly_but

from ringwear import Scene, load, run


def texts(figure):
    return [axes.get_title(loc="left") for axes in figure.axes]


DRAWN = {
    "hollow": ("washer", {}),
    "moving": ("sphere", {"wear__times": [0.0, 0.01, 0.1]}),
    "fixed": ("sphere", {"load": {"indentation": 0.04}, "wear__times": [0.0, 0.05, 1.0]}),
    "loads": ("duty_cycle", {"wear__times": [0.0, 0.5, 4.0, 4.5, 8.0]}),
    "start": ("five_rings", {"wear__times": [0.0]}),
    "no sliding": ("duty_cycle", {"wear__times": [0.0], "wear__steady": False}),
    "steady": ("five_rings", {"wear__times": [], "methods": ["bem", "direct"]}),
}


@pytest.mark.parametrize("kind", nightly_but(("fixed", "steady"), DRAWN))
def test_the_figure_of_any_punch_marks_the_greatest_differences(kind, tmp_path):
    name, changes = DRAWN[kind]
    scene = Scene.load(name).changed(
        **{"methods": ["bem", "mdr"], "accuracy__rtol": 1e-2} | changes
    )
    result = run(scene)
    figure = result.plot("difference") if result.field_comparisons else None
    if kind == "no sliding":
        # without a force, no difference can be relative to anything
        assert figure is None
        return
    figure.savefig(tmp_path / "difference.png")
    (comparison,) = result.field_comparisons
    assert (comparison.reference, comparison.other) == tuple(scene.methods)
    for field_difference in comparison.fields:
        assert np.isfinite(field_difference.norms).all()
        # the same differences from the values in the dataset
        both = result.dataset[field_difference.quantity].values
        gaps = np.abs(both[1] - both[0]).reshape(-1, both.shape[-1])
        row, at = field_difference.largest
        if "pressure" not in field_difference.quantity and gaps.max():
            assert field_difference.radii[at] == result.coordinates["radius"][gaps[row].argmax()]
        assert (np.nanmax(gaps) == 0) == (field_difference.relative[row, at] == 0)


@pytest.mark.slow
def test_a_loaded_result_is_drawn_like_the_saved_one(tmp_path):
    scene = Scene.load("five_rings").changed(methods=["mdr", "bem"], accuracy__rtol=1e-2)
    result = run(scene)
    result.save(tmp_path)
    again = load(tmp_path)
    first, second = (texts(each.plot("difference")) for each in (result, again))
    assert first == second


def test_finite_elements_are_drawn_before_other_methods():
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "bem", "fem"], accuracy__rtol=1e-2, accuracy__fem__mesher="bisection"
    )
    result = run(scene)
    assert [each.other for each in result.field_comparisons] == ["fem", "bem"]
    figure = result.plot("difference")
    assert "Not drawn: BEM minus MDR" in figure.legends[0].get_title().get_text()
