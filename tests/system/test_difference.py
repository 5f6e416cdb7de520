"""Differences along the radius, and the figures that show how small they are."""

import pytest

from ringwear import Scene, load, run


def texts(figure):
    return [axes.get_title(loc="left") for axes in figure.axes]


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
