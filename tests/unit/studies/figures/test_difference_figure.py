"""Figures of differences of two reports, of histories, and the units of their axes."""

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from two_reports import SCENE, differing, report

from ringwear import Scene
from ringwear.studies.crosscheck.methods.sampling.field_differences import compare_fields
from ringwear.studies.figures.difference import ROWS, draw_difference
from ringwear.studies.figures.scale import Scale
from ringwear.studies.figures.style import new_panels, show_values


def compared(scene, ours, theirs):
    return compare_fields(scene.problem, ("mdr", "fem"), ours, theirs)


def texts(figure):
    return [axes.get_title(loc="left") for axes in figure.axes]


@pytest.mark.parametrize("quantity", ["pressure", "profile", "displacement"])
def test_the_figure_marks_and_names_the_largest_difference(quantity):
    amount = {"pressure": 0.03 * 3e5, "profile": 9e-6, "displacement": 9e-6}[quantity]
    figure = draw_difference(
        Scale(SCENE), SCENE.title, (compared(SCENE, report(), differing(quantity, 2, 70, amount)),)
    )
    number = ["pressure", "profile", "displacement"].index(quantity)
    named = [text for text in texts(figure) if text.startswith("largest")]
    assert named == ["largest 0.03 at r = 3.5 mm, t = 5.56 h"]
    curves, chart = figure.axes[2 * number : 2 * number + 2]
    # a row of the map is a time
    for axes, height in ((curves, 0.03), (chart, 2)):
        (mark,) = [line for line in axes.lines if line.get_label() == "largest difference"]
        assert float(mark.get_xdata()[0]) == pytest.approx(3.5)
        assert float(mark.get_ydata()[0]) == pytest.approx(height)
    assert figure.get_suptitle().startswith("FEM minus MDR")
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"error estimate of MDR (band)", "error estimate of FEM (band)"} <= labels


def test_equal_reports_have_no_difference():
    figure = draw_difference(Scale(SCENE), "", (compared(SCENE, report(), report()),))
    assert texts(figure).count("no difference") == 3
    assert not any("largest" in text for text in texts(figure))


def test_axes_of_histories_do_not_magnify_roundoff():
    figure, panels = new_panels(3, 2)
    panels[0, 0].plot([0, 1], [62.475, 62.475 + 1e-5])
    show_values(panels[0, 0])
    figure.draw_without_rendering()
    low, high = panels[0, 0].get_ylim()
    assert high - low >= 0.62
    assert not panels[0, 0].yaxis.get_offset_text().get_text()


def test_numbers_without_a_unit_are_drawn_in_a_power_of_ten():
    scene = Scene.load("five_rings").changed(load__normal_force=2e-6, punch__radius=1e-2)
    # slopes F / (a^2 E*) are 2e-2, and stresses F / (a^2) as well; heights are F / (2 a E*) = 1e-4
    scale = Scale(scene)
    assert scale.label("rms_slope") == "RMS slope s"
    assert scale.label("displacement_max") == "displacement uₘₐₓ (10⁻⁴)"
    assert scale.shown("displacement_max", 1e-4) == pytest.approx(1.0)
    assert scale.label("radius") == "radius r"


def test_a_map_of_many_times_has_few_rows_and_shows_the_largest_difference():
    """Its rows are about pixels; each shows the greatest difference of its times."""
    count, radii = 3000, np.linspace(0, 1, 9)
    times = np.linspace(0, 2, count)
    scene = Scene.load("five_rings").changed(wear__times=times.tolist())
    ours = {"time": times, "radius": radii, "indentation": np.ones(count),
            "profile": np.zeros((count, 9))}  # fmt: skip
    theirs = ours | {"profile": np.full((count, 9), 1e-4)}
    theirs["profile"][1234, 5] = 0.03
    comparison = compared(scene, ours, theirs)
    figure = draw_difference(Scale(scene), "", (comparison,))
    (mesh,) = [each for each in figure.axes[1].collections if isinstance(each, QuadMesh)]
    drawn = np.asarray(mesh.get_array())
    assert drawn.shape[0] <= ROWS
    assert drawn.max() == pytest.approx(0.03)
