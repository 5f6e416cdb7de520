"""Differences along the radius, and the figures that show how small they are."""

import numpy as np
import pytest

from ringwear import PressureSpace, Scene, load, run
from ringwear.studies.crosscheck.operators import _shortest_resolved_wave
from ringwear.studies.figures.difference import draw_difference
from ringwear.studies.figures.scale import Scale
from ringwear.studies.figures.style import new_panels, show_values
from ringwear.studies.sampling.field_differences import compare_fields

TIMES = [0.0, 1e3, 2e4, 3e5]
# with one ring, the weight of the norm of the pressure is the area
SCENE = Scene.load("rubber").changed(
    punch__ring_edges=[0.005], punch__wear_coefficients=[1e-15, 1e-15], wear__times=TIMES
)
RADII = np.linspace(0.0, 0.005, 101)


def report(**changed):
    """Return a report of uniform fields in SI units, some of which are replaced."""
    shape = len(TIMES), len(RADII)
    fields = {
        "time": np.array(TIMES),
        "radius": RADII,
        "pressure": np.full(shape, 3e5),
        "profile": np.full(shape, 1e-5) * (RADII > 0),
        "displacement": np.full(shape, 2e-5),
        "indentation": np.array([2e-4, 1e-4, 3e-4, 3e-4]),
        "pressure_error": np.full(len(TIMES), 1e-6),
        "profile_error": np.full(len(TIMES), 2e-6),
    }
    return fields | changed


def differing(quantity, row, at, amount):
    """Return a report in which one value is changed by an amount."""
    values = report()[quantity].copy()
    values[row, at] += amount
    return report(**{quantity: values})


def compared(other, reference=None, names=("mdr", "fem"), scene=SCENE):
    with np.errstate(all="raise"):
        return compare_fields(scene.problem, names, reference or report(), other)


def field(comparison, quantity):
    (difference,) = [each for each in comparison.fields if each.quantity == quantity]
    return difference


def texts(figure):
    return [axes.get_title(loc="left") for axes in figure.axes]


def test_a_known_difference_of_pressure_is_found_at_its_time_and_radius():
    difference = field(compared(differing("pressure", 2, 70, 0.03 * 3e5)), "pressure")
    assert difference.largest == (2, 70)
    assert difference.radii[70] == pytest.approx(0.0035)
    assert difference.relative[2, 70] == pytest.approx(0.03)
    # root of the fraction of the area within half a spacing of that radius
    share = (0.705**2 - 0.695**2) * 0.03**2
    np.testing.assert_allclose(difference.norms, [0, 0, np.sqrt(share), 0], rtol=1e-12)
    np.testing.assert_array_equal(difference.first_error, 1e-6)


def test_differences_of_the_unworn_pressure_are_weighted_as_in_its_norm():
    # where p = p0 / sqrt(1 - r^2/a^2), the weighted pressure is p0 everywhere
    start = 1 / np.sqrt((1 - RADII[:-1] / 0.005) * (1 + RADII[:-1] / 0.005))
    pressure = report()["pressure"].copy()
    pressure[0] = [*start, np.inf]
    other = pressure.copy()
    other[0, 60] *= 1.02
    difference = field(compared(report(pressure=other), report(pressure=pressure)), "pressure")
    assert difference.largest == (0, 60)
    assert difference.relative[0, 60] == pytest.approx(0.02)
    # both pressures are infinite at the rim
    assert np.isnan(difference.relative[0, -1])
    assert np.isfinite(difference.relative[1:]).all()


def test_a_full_punch_has_no_hole_inside_the_first_radius():
    radii = np.array([0.3, 0.5, 0.9])
    np.testing.assert_allclose(SCENE.problem.sampled_face(radii).edge_weights, 1 - radii**2)
    hollow = Scene.load("washer").problem.sampled_face(np.array([0.7, 0.8]))
    assert hollow.edge_weights[1] == pytest.approx((1 - 0.8**2) * (1 - 0.6 / 0.8))


def test_heights_are_relative_to_the_greatest_indentation_so_far():
    difference = field(compared(differing("profile", 1, 5, 4e-6)), "profile")
    # the indentation was 2e-4 before it came back to 1e-4
    assert difference.relative[1, 5] == pytest.approx(0.02)
    assert difference.norms[1] == pytest.approx(0.02)


def test_times_without_pressure_do_not_divide_by_zero():
    pressure = report()["pressure"].copy()
    pressure[[0, 3]] = 0.0
    rest = pressure.copy()
    rest[3] = 1e-14
    difference = field(compared(report(pressure=rest), report(pressure=pressure)), "pressure")
    assert np.isfinite(difference.relative).all()
    assert difference.relative.max() < 1e-9
    zero = np.zeros_like(pressure)
    names = [each.quantity for each in compared(report(), report(pressure=zero)).fields]
    assert names == ["profile", "displacement"]


def test_missing_values_are_left_out():
    sparse = report()["pressure"] * 1.01
    sparse[:, 1::2] = np.nan
    sparse[0] = np.nan
    other = report(pressure=sparse)
    del other["pressure_error"], other["profile"]
    comparison = compared(other)
    difference = field(comparison, "pressure")
    assert difference.times.tolist() == TIMES[1:]
    np.testing.assert_allclose(difference.radii, RADII[::2])
    np.testing.assert_allclose(difference.norms, 0.01, rtol=1e-10)
    assert np.isnan(difference.second_error).all()
    assert [each.quantity for each in comparison.fields] == ["pressure", "displacement"]


def test_other_radii_are_interpolated_and_other_times_left_out():
    linear = report(profile=np.tile(1e-3 * RADII, (len(TIMES), 1)))
    radii = np.linspace(0.0, 0.004, 7)
    other = report(
        time=np.array([1e3, 5e3, 3e5]), radius=radii, profile=np.tile(1e-3 * radii, (3, 1))
    )
    other = {name: other[name] for name in ("time", "radius", "profile")}
    comparison = compared(other, linear)
    difference = field(comparison, "profile")
    assert comparison.interpolated
    assert difference.times.tolist() == [1e3, 3e5]
    assert difference.radii[-1] == pytest.approx(0.004)
    assert difference.relative.max() < 1e-12


@pytest.mark.parametrize("quantity", ["pressure", "profile", "displacement"])
def test_the_figure_marks_and_names_the_largest_difference(quantity):
    amount = {"pressure": 0.03 * 3e5, "profile": 9e-6, "displacement": 9e-6}[quantity]
    figure = draw_difference(
        Scale(SCENE), SCENE.title, (compared(differing(quantity, 2, 70, amount)),)
    )
    number = ["pressure", "profile", "displacement"].index(quantity)
    named = [text for text in texts(figure) if text.startswith("largest")]
    assert named == ["largest 0.03 at r = 3.5 mm, t = 5.56 h"]
    curves, chart = figure.axes[2 * number : 2 * number + 2]
    for axes, height in ((curves, 0.03), (chart, np.log10(2e4 / 86400))):
        (mark,) = [line for line in axes.lines if line.get_label() == "largest difference"]
        assert float(mark.get_xdata()[0]) == pytest.approx(3.5)
        assert float(mark.get_ydata()[0]) == pytest.approx(height)
    assert figure.get_suptitle().startswith("FEM minus MDR")
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"error estimate of MDR (band)", "error estimate of FEM (band)"} <= labels


def test_equal_reports_have_no_difference():
    figure = draw_difference(Scale(SCENE), "", (compared(report()),))
    assert texts(figure).count("no difference") == 3
    assert not any("largest" in text for text in texts(figure))


DRAWN = {
    "hollow": ("washer", {}),
    "moving": ("sphere", {"wear__times": [0.0, 0.01, 0.1]}),
    "fixed": ("sphere", {"load": {"indentation": 0.04}, "wear__times": [0.0, 0.05, 1.0]}),
    "loads": ("duty_cycle", {"wear__times": [0.0, 0.5, 4.0, 4.5, 8.0]}),
    "start": ("five_rings", {"wear__times": [0.0]}),
    "no sliding": ("duty_cycle", {"wear__times": [0.0], "wear__steady": False}),
    "steady": ("five_rings", {"wear__times": [], "methods": ["bem", "direct"]}),
}


@pytest.mark.parametrize("kind", DRAWN)
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


def test_one_method_has_no_difference():
    alone = run(Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-2))
    assert "difference" not in alone.plots


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


def test_axes_of_histories_do_not_magnify_roundoff():
    figure, panels = new_panels(3, 2)
    panels[0, 0].plot([0, 1], [62.475, 62.475 + 1e-5])
    show_values(panels[0, 0])
    figure.draw_without_rendering()
    low, high = panels[0, 0].get_ylim()
    assert high - low >= 0.62
    assert not panels[0, 0].yaxis.get_offset_text().get_text()


def test_no_history_has_offset_text_or_a_narrow_axis():
    scene = Scene.load("five_rings").changed(
        methods=["mdr", "bem"],
        accuracy__rtol=1e-2,
        wear__times=[5e7, 5.0001e7],
        half_space__plane_strain_modulus=1e-7,
    )
    figure = run(scene).plot("history")
    figure.draw_without_rendering()
    for axes in figure.axes:
        assert not axes.yaxis.get_offset_text().get_text()
        assert not axes.xaxis.get_offset_text().get_text()
    for axes in figure.axes[:2]:
        low, high = axes.get_ylim()
        assert high - low >= 0.0099 * max(abs(low), abs(high))


def test_numbers_without_a_unit_are_drawn_in_a_power_of_ten():
    scene = Scene.load("five_rings").changed(load__normal_force=2e-6, punch__radius=1e-2)
    # slopes F / (a^2 E*) are 2e-2, and stresses F / (a^2) as well; heights are F / (2 a E*) = 1e-4
    scale = Scale(scene)
    assert scale.label("rms_slope") == "RMS slope s"
    assert scale.label("displacement_max") == "displacement uₘₐₓ (10⁻⁴)"
    assert scale.shown("displacement_max", 1e-4) == pytest.approx(1.0)
    assert scale.label("radius") == "radius r"


def test_the_shortest_wave_has_pi_degrees_in_the_worst_element():
    # h/p is 0.1, 0.075 and 0.1 on the face; the hole of degree 0 has no pressure
    space = PressureSpace(
        np.array([0.0, 0.4, 0.6, 0.9, 1.0]), np.array([0, 2, 4, 1]), np.array([0.0, 0.4, 1.0])
    )
    assert _shortest_resolved_wave(space) == pytest.approx(0.1 * np.pi)


@pytest.mark.gmsh
@pytest.mark.parametrize("name", ["five_rings", "washer"])
def test_large_differences_of_operators_are_in_the_shaded_part(name):
    result = run(Scene.load(name).changed(methods=["mdr", "fem"], accuracy__rtol=1e-3))
    (pair,) = result.operators
    resolved = pair.wavelengths > pair.shortest_resolved
    assert pair.differences[~resolved].max() > 0.1
    assert pair.differences[resolved].max() < 0.1
    (axes,) = result.plot("operator_difference").axes
    (shaded,) = axes.patches
    assert shaded.get_x() == pytest.approx(axes.get_xlim()[0])
    end = (shaded.get_x() + shaded.get_width()) * result.scene.punch.radius
    assert end == pytest.approx(pair.shortest_resolved)
