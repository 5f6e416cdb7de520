"""Figures in the units of the scene, of faces that wear, are recessed or lose contact.

Overlaps are detected by the extents of all texts (`figure_faults`).
"""

import re

import numpy as np
import pytest
from figure_faults import faults
from groups import nightly, nightly_but
from matplotlib.figure import Figure
from natural import natural

from ringwear import Scene, SceneError, check, load, run, study
from ringwear.studies.crosscheck import bundled
from ringwear.studies.named_studies import STUDIES

UNITS = "mm, N, MPa, s"
PUNCH = {"radius": "10 mm", "rings": 3, "wear_coefficients": ["1e-6 mm^3/(N m)", "1e-5 mm^3/(N m)"]}
LOAD = {"normal_force": "100 N", "sliding_speed": "0.1 m/s"}
WORN = {
    "units": UNITS,
    "methods": ["mdr", "fem"],
    "punch": PUNCH,
    "half_space": {"youngs_modulus": "2 GPa"},
    "load": LOAD,
    "wear": {"times": ["0 s", "1 min", "2 h", "1 day", "365 days"]},
    "accuracy": {"rtol": 1e-2},
}
# only the lands between grooves of 1 mm are in contact, and the load is removed at the end
GROOVED = WORN | {
    "units": "SI",
    "punch": PUNCH | {"recess": ["0 mm", "1 mm", "0 mm"]},
    "load": LOAD
    | {"normal_force": {"times": ["0 h", "10 h", "11 h"], "values": ["500 N", "500 N", "0 N"]}},
    "wear": {"times": ["0 h", "0.3 h", "3 h", "11 h"], "steady": False},
    "output": {"field_times": ["0 h", "3 h", "11 h"]},
}


@pytest.fixture(scope="module")
def worn():
    return run(Scene(**WORN))


@pytest.fixture(scope="module")
def grooved():
    return run(Scene(**GROOVED))


def named(figure, label):
    """Return everything that is drawn under a label, panel by panel."""
    artists = (artist for axes in figure.axes for artist in axes.get_children())
    return [artist for artist in artists if artist.get_label() == label]


def assert_no_faults(result, kinds):
    for kind in kinds:
        assert faults(result.plot(kind)) == [], kind


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["worn", "grooved"])
def test_nothing_overlaps_and_numbers_are_short(scene, request):
    result = request.getfixturevalue(scene)
    assert len(result.plots) >= 6
    assert_no_faults(result, result.plots)


@pytest.mark.parametrize("name", nightly_but(["flat_punch"], bundled()))
def test_each_axis_of_bundled_scenes_has_two_labels_or_more(name):
    """The faults include axes with fewer labels."""
    scene = Scene.load(name)
    result = run(scene.changed(accuracy__rtol=max(scene.accuracy.rtol, 1e-2)))
    assert_no_faults(result, result.plots)


@pytest.mark.parametrize(
    "name", nightly_but(["march", "operators"], [name for name in STUDIES if name != "paper"])
)
def test_each_axis_of_studies_has_two_labels_or_more(name):
    for kind, figure in study(name, quick=True).figures.items():
        assert not [fault for fault in faults(figure) if "tick labels at" in fault], kind


def test_overlapping_labels_are_detected():
    figure = Figure((3, 2), layout=None)
    axes = figure.add_axes((0.2, 0.2, 0.7, 0.7))
    axes.set_xticks([0.5, 0.52], ["0.5001", "99 %"])
    axes.plot([1e6 + 1, 1e6 + 1.5])
    messages = "\n".join(faults(figure))
    for fault in ("'0.5001' at", "is over tick '99 %'", "beside the axis", "spans"):
        assert fault in messages, messages


def test_answer_and_figures_are_in_the_units_of_the_scene(worn, command):
    printed = command("run scene.toml --methods mdr --verbose --no-figures", scene=worn.scene).out
    lines = printed.partition("All answers")[2].partition("Accuracy")[0]
    rows = [re.split(r" {2,}", line.strip()) for line in lines.splitlines()[1:]]
    answers = {row[0]: row[1] for row in rows if len(row) == 3}
    units = {what: value.partition(" ")[2] for what, value in answers.items()}
    assert units["indentation start"] == "mm"
    assert units["steady wear rate"] == "mm/h"
    assert units["time to 90"] in ("s", "min", "h", "days")
    (headings,) = [row for row in rows if row[0] == "ring"]
    text = " ".join([*answers.values(), *headings])
    assert {"radii, mm", "p steady, MPa", "worn, mm³", "mean height, mm"} <= set(headings)
    assert not re.search(r"\b(nm|µm|kPa|GPa|cm³|m)\b(?! *m\))", text.replace("mm³/(N m)", ""))
    # F / (2 a E*) with E* = 2000 MPa / (1 - 0.3^2)
    depth = 100 * (1 - 0.3**2) / (2 * 10 * 2000)
    assert float(answers["indentation start"].split()[0]) == pytest.approx(depth, rel=1e-3)
    figures = [worn.plot(kind) for kind in worn.plots]
    labels = " ".join(
        axis.get_label_text().removeprefix("|Δp| / rms(p)")
        for figure in figures
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
    )
    drawn = set(re.findall(r"\((?:[0-9·]*10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ ?)?([^()]*)\)", labels)) - {""}
    assert drawn <= {"mm", "MPa", "h", "min", "s", "days"}
    assert {"mm", "MPa"} <= drawn


def test_the_unworn_punch_is_drawn_at_its_height_above_the_panel(worn):
    figure = worn.plot("profiles_and_pressures")
    lines = named(figure, "unworn punch")
    tops = [line.axes.get_ylim()[1] for line in lines]
    heights = [float(np.max(line.get_ydata())) for line in lines]
    assert heights[0] == 0
    # all of the face has worn by 1.4 mm in a year, a thousand times more than a panel shows
    assert heights[-1] < tops[-1] < 0
    assert "f − 1.4 mm" in lines[-1].axes.get_title()
    assert "the unworn punch is above" in figure.legends[0].get_title().get_text()


@pytest.mark.slow
def test_deep_grooves_do_not_hide_wear(grooved):
    figure = grooved.plot("profiles_and_pressures")
    panels = [line.axes for line in named(figure, "unworn punch")]
    profiles = grooved.by_method("profile")["mdr"]
    edges = np.array([0, 10, 20, 30]) / 3e3
    lands = (grooved.coordinates["radius"] < edges[1]) | (grooved.coordinates["radius"] > edges[2])
    for axes, heights in zip(panels[1:], profiles[1:], strict=True):
        shown = axes.get_ylim()[0] * (1e-6 if "µm" in panels[0].get_ylabel() else np.nan)
        # the wear of other times may be up to ten times as deep
        assert heights[lands].max() < shown < 11 * heights[lands].max() < 1e-3
    note = figure.legends[0].get_title().get_text()
    assert "cut off below: the greatest height of the face is Δf = 1 mm" in note


@pytest.mark.slow
def test_a_recess_that_has_worn_off_does_not_hide_the_profile():
    # after 72 h all of the face is worn below the grooves of 20 µm
    scene = WORN | {
        "methods": ["mdr", "bem"],
        "punch": PUNCH | {"recess": ["0 um", "20 um", "0 um"]},
        "load": LOAD | {"sliding_speed": "1 m/s"},
        "wear": {"times": ["0 h", "2 h", "20 h", "72 h", "200 h"]},
    }
    result = run(Scene(**scene))
    figure = result.plot("profiles_and_pressures")
    last = [line.axes for line in named(figure, "unworn punch")][-1]
    heights = result.by_method("profile")["mdr"][-1]
    span = np.ptp(heights)
    shown = [line.get_ydata() for line in last.lines if line.get_label() == "MDR"]
    power = 10.0 ** np.floor(np.log10(span / np.ptp(shown[0])) + 0.5)
    # panels have the same scale if their heights differ by up to a factor of ten
    assert last.get_ylim()[0] * power < 11 * span
    assert np.min(shown[0]) == pytest.approx(0, abs=1e-6)
    # times of a scene in hours stay in hours
    assert "t = 72 h" in figure.axes[3].get_title()
    assert "time t (h)" in [axes.get_xlabel() for axes in result.plot("history").axes]


def test_labels_at_the_rim_name_its_unit_of_length(worn):
    *_, rim = worn.plot("mesh").axes
    unit = rim.get_xlabel().removeprefix("radius r − a")
    assert "mm" in unit
    assert rim.get_ylabel() == f"depth z{unit}"


@pytest.mark.slow
def test_all_words_of_a_single_stress_panel_are_in_the_figure():
    # without contact at the end and without steady state, only the start is drawn
    falling = LOAD | {"normal_force": {"times": ["0 h", "1 h"], "values": ["100 N", "0 N"]}}
    title = "A polishing tool of three rings under a load that falls"
    wear = {"times": ["0 h", "0.5 h", "1 h"], "steady": False}
    result = run(Scene(**WORN | {"title": title, "load": falling, "wear": wear}))
    figure = result.plot("stress")
    assert faults(figure) == []
    assert "stress under the rings" in figure.get_suptitle()


def test_differences_over_time_look_like_their_method(worn):
    figure = worn.plot("history")
    differences, fem, mdr = (
        {line.get_color() for line in named(figure, label)}
        for label in ("FEM minus MDR", "FEM", "MDR")
    )
    assert differences == fem
    assert len(fem) == len(mdr) == len(fem | mdr) - 1 == 1


@pytest.mark.slow
def test_stress_is_drawn_only_at_times_with_contact_and_shows_where_it_is(grooved):
    figure = grooved.plot("stress")
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert [title.split("\n")[0] for title in titles] == ["t = 0 s", "t = 3 h"]
    assert "states without contact, not drawn: 1" in figure.legends[0].get_title().get_text()
    bars = [
        [float(end) for end in line.get_xdata()]
        for line in figure.axes[0].lines
        if line.get_linewidth() == 2
    ]
    np.testing.assert_allclose(bars, [[0, 10 / 3], [20 / 3, 10]], rtol=1e-3)


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("thickness", [*nightly(0.3), 0.05, *nightly(0.01)])
def test_panels_of_stresses_show_layers_of_any_thickness(thickness):
    layer = {"thickness": thickness, "youngs_modulus": 1.0, "poisson_ratio": 0.3}
    scene = natural(
        {"wear_coefficient": 1.0},
        [],
        1e-2,
        "fem",
        half_space={"rigid": True, "layers": [layer]},
    )
    result = run(scene)
    assert_no_faults(result, ("stress", "mesh"))
    figure = result.plot("stress")
    bottom, _ = figure.axes[0].get_ylim()
    # the layer fills at least a tenth of the panel
    assert thickness < bottom < 10 * thickness
    note = figure.legends[0].get_title().get_text()
    assert ("depths are stretched" in note) == (thickness < 0.1)


def test_other_programs_have_different_colours(worn):
    table = worn.dataset.sel(solver="mdr")[["pressure", "profile", "indentation"]]
    table = table.isel(radius=slice(None, None, 40), time=[1, 2]).drop_vars("solver")
    checked = check(Scene(**WORN), {"ansys": table, "abaqus": table}, methods=["mdr"])
    figures = worn.plot("profiles_and_pressures"), checked.plot("profiles_and_pressures")
    ours, theirs = (
        {line.get_color() for name in names for figure in figures for line in named(figure, name)}
        for names in (("MDR", "FEM"), ("ansys", "abaqus"))
    )
    assert len(ours) == len(theirs) == 2
    assert not ours & theirs


def test_a_field_at_one_time(worn):
    """It has a curve for each method, and notebooks show it."""
    time = float(worn.dataset.time[-1])
    figure = worn.plot("pressure", time=f"{time} s")
    (axes,) = figure.axes
    drawn = axes.lines[0].get_ydata()
    pressure = worn.dataset.pressure.sel(time=time).isel(solver=0).to_numpy()
    ratio = pressure.max() / pressure.min()
    assert np.nanmax(drawn) / np.nanmin(drawn) == pytest.approx(ratio)
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(SceneError, match="no results then; the nearest are at"):
        worn.plot("profile", time=1.01 * time)
    with pytest.raises(SceneError, match="time is that of a field"):
        worn.plot("history", time=time)


@pytest.mark.slow
def test_a_loaded_result_is_drawn_like_the_saved_one(tmp_path):
    scene = Scene.load("five_rings").changed(methods=["mdr", "bem"], accuracy__rtol=1e-2)
    result = run(scene)
    result.save(tmp_path)
    titles, again = (
        [axes.get_title(loc="left") for axes in each.plot("difference").axes]
        for each in (result, load(tmp_path))
    )
    assert titles == again


def test_finite_elements_are_drawn_before_other_methods():
    scene = Scene.load("flat_punch").changed(
        methods=["mdr", "bem", "fem"], accuracy__rtol=1e-2, accuracy__fem__mesher="bisection"
    )
    result = run(scene)
    assert [each.other for each in result.field_comparisons] == ["fem", "bem"]
    figure = result.plot("difference")
    assert "Not drawn: BEM minus MDR" in figure.legends[0].get_title().get_text()
