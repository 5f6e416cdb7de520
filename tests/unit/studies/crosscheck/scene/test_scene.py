"""Scenes: bad ones are refused with one line that names the key, and good ones are unchanged."""

import numpy as np
import pytest

from ringwear import Scene, SceneError
from ringwear.studies.crosscheck.result.words import defaults_taken
from ringwear.studies.crosscheck.scene.explain import declaration
from ringwear.studies.crosscheck.scene.sources import bundled

TOML = """\
title = "A scene"
methods = ["direct"]
[punch]
radius = 2.0
rings = 3
wear_coefficients = [1.0, 10.0]
[half_space]
plane_strain_modulus = 1.0
poisson_ratio = 0.3
[load]
normal_force = 2.0
sliding_speed = 1.0
[wear]
times = [0.0, 0.1]
[accuracy]
rtol = 1e-3
[output]
radii = [0.5, 1.5]
"""
GOOD = Scene.from_toml(TOML)
INF, NAN = float("inf"), float("nan")
# bad values by key; the message must have the key and its remedy
BAD_VALUES = {
    "title": [3],
    "punch__radius": [0.0, NAN, "one", True, [2.0], None],
    "punch__rings": [0, 2.5, 10**9],
    "punch__inner_radius": [-0.1],
    "punch__width_ratio": [1e-300, INF],
    "punch__ring_edges": [[0.0, 1.0, 2.0]],
    "punch__wear_coefficients": [[1.0, "x"]],
    "punch__recess": [[0.0, -0.1, 0.0]],
    "half_space__plane_strain_modulus": [-1.0],
    "half_space__poisson_ratio": [-1.0, 0.6, NAN],
    "load__normal_force": [0.0],
    "load__sliding_speed": [0.0],
    "wear__times": [0.1, [-1.0], {"taus": [1.0]}, {"tau": [1.0, 0.5]}, {"tau": [-1.0]}],
    "wear__step": [0.0],
    "accuracy__rtol": [1e-12, 0.5, NAN],
    "accuracy__fem__degree": [0, 17],
    "accuracy__fem__truncation": [1.0],
    "accuracy__fem__mesher": ["stars"],
    "output__radii": [[-0.5, 1.5]],
}
RINGS = {"radius": 2.0, "wear_coefficients": [1.0, 10.0]}


def table(radii, heights):
    return {"punch__profile": {"kind": "table", "radii": radii, "heights": heights}}


def along(radii, values):
    return {"punch": {"radius": 2.0, "wear_coefficient": {"radii": radii, "values": values}}}


# bad changes, and words that the message must have
BAD_CHANGES = [
    ({"punch": {"rings": 3}}, "missing punch.radius for example"),
    ({"punch__wear_coefficients": None}, "wear_coefficients wear_ratio"),
    (
        {"punch__wear_ratio": 2.0, "punch__wear_coefficients": [1.0, 2.0]},
        "wear_coefficients wear_ratio",
    ),
    ({"punch__rings": None}, "rings ring_edges"),
    ({"punch__ring_edges": [1.0, 2.0], "punch__rings": 2}, "rings ring_edges"),
    (
        {"half_space__youngs_modulus": 1.0, "half_space__plane_strain_modulus": 1.0},
        "plane_strain_modulus youngs_modulus",
    ),
    ({"load__normal_force": None}, "normal_force mean_pressure indentation"),
    ({"punch": RINGS | {"ring_edges": []}}, "ring_edges"),
    ({"punch": RINGS | {"ring_edges": [1.0, 2.1]}}, "ring_edges punch.radius"),
    ({"punch": RINGS | {"ring_edges": [2.0], "width_ratio": 2.0}}, "width_ratio"),
    ({"wear__times": [], "wear__steady": False}, "times steady"),
    ({"wear__march": "implicit"}, "march step"),
    ({"wear__step": 0.1}, "march step"),
    ({"wear__tau": [0.1]}, "times = { tau = [...] }"),
    ({"accuracy__fem": {"mesher": "bisection", "degree": 5}}, "accuracy.fem bisection 1 to 4"),
    ({"accuracy__fem": {"mesher": "gmsh", "degree": 16}}, "accuracy.fem gmsh 1 to 4"),
    ({"load__normal_force": {"times": [0.0, 1.0], "values": [1.0]}}, "load.normal_force 1 2 each"),
    ({"load__sliding_speed": {"times": [0.0], "values": [0.0]}}, "load.sliding_speed 0.0 positive"),
    ({"methods": ["direct", "direct"]}, "methods twice"),
    ({"output__radii": [0.5, 2.5]}, "output.radii 2.5"),
    ({"output__radii": [1.5, 0.5]}, "output.radii increase"),
    ({"punch__inner_radius": 1e-12}, "too small to have an effect"),
    ({"punch__inner_radius": 1.0}, "within the hole"),
    ({"punch__profile": {"kind": "ball", "ball_radius": 0.5}}, "below punch.radius"),
    ({"load__times": 1.0}, "did you mean wear.times"),
    ({"punch__normal_force": 1.0}, "did you mean load.normal_force"),
    ({"punch__recess": [0.0, 0.1]}, "recess 3 rings"),
    (table([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 2.0, 3.0]), "step recess"),
    (table([0.0, 1.0], [0.0, 1.0]), "radii rim"),
    (table([0.0, 2.0], [0.0, float("nan")]), "heights"),
    (
        {"punch__profile": {"kind": "rounded_rim", "flat_radius": 3.0, "curvature_radius": 1.0}},
        "flat_radius",
    ),
    (along([0.0, 2.0], [1.0]), "give a value for each of radii"),
    (along([0.5, 0.4], [1.0, 2.0]), "that do not decrease"),
    (along([0.0, 2.0], [1.0, 0.0]), "wear_coefficient.values.1: 0.0 positive"),
    ({"output__quantities": []}, "quantities"),
    ({"output__quantities": ["indentation"], "wear": {}}, "quantities"),
    (
        {"output__quantities": ["steady"], "wear": {"times": [1.0], "steady": False}},
        "quantities",
    ),
]


def assert_refused(words, make, *arguments, **named):
    """Assert that a call raises a SceneError with these words in one line."""
    with pytest.raises(SceneError) as caught:
        make(*arguments, **named)
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("name", "value"), [(name, value) for name in BAD_VALUES for value in BAD_VALUES[name]], ids=str
)
def test_bad_values(name, value):
    """The message has the key, and the remedy if one is declared with the key."""
    path = name.split("__")
    words = ".".join(path), declaration(path, Scene)[1].description or "should be"
    assert_refused(words, GOOD.changed, **{name: value})


@pytest.mark.parametrize(("changes", "words"), BAD_CHANGES, ids=str)
def test_bad_changes(changes, words):
    assert_refused(words.split(), lambda: GOOD.changed(**changes).problem)


@pytest.mark.parametrize("name", bundled())
def test_bundled_scenes_round_trip(name):
    scene = Scene.load(name)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert Scene.from_table(scene.table()) == scene
    assert scene.changed() == scene
    assert scene.title


def test_a_pin_on_a_disc_has_one_speed_and_a_rotating_pin_that_of_its_radius():
    """Beside the axis the speed is omega times the radius of the track, 2 pi * 1 Hz * 16 mm."""
    pin, rotating = Scene.load("pin_on_disc"), Scene.load("rotating_pin")
    assert pin.punch.table is None
    assert pin.load.sliding_speed == pytest.approx(2 * np.pi * 0.016, rel=1e-3)
    assert not pin.problem.inner_radius
    table = rotating.punch.table
    assert np.divide(table.values, table.radii) == pytest.approx(1e-13)


@pytest.mark.parametrize(
    ("changes", "left_out"),
    [
        ({"load.mean_pressure": 1.0}, "load.normal_force"),
        ({"load.indentation": 1.0}, "load.normal_force"),
        ({"half_space.youngs_modulus": 1.0}, "half_space.plane_strain_modulus"),
        ({"punch.ring_edges": [1.0, 2.0]}, "punch.rings"),
        ({"punch.wear_ratio": 2.0}, "punch.wear_coefficients"),
    ],
    ids=str,
)
def test_a_key_replaces_its_alternatives(changes, left_out):
    table, key = left_out.split(".")
    changed = GOOD.changed(changes).table()
    assert key in GOOD.table()[table]
    assert key not in changed[table]
    (name,) = changes
    assert GOOD.changed({name.replace(".", "__"): changes[name]}).table() == changed


def test_numbers_of_numpy_are_numbers():
    times = np.linspace(0.0, 1.0, 3)
    changed = GOOD.changed(
        {"wear.times": times, "punch.radius": np.float32(2), "punch.rings": np.int64(3)}
    )
    assert changed == GOOD.changed({"wear.times": [0.0, 0.5, 1.0], "punch.radius": 2.0})


def test_a_scene_is_immutable():
    with pytest.raises(AttributeError, match=r"write scene\.changed"):
        GOOD.punch.radius = 3.0
    changed = GOOD.changed(
        accuracy__rtol=1e-5, accuracy__fem__degree=3, output__gradient_average="area"
    )
    assert (changed.accuracy.rtol, changed.accuracy.fem.degree) == (1e-5, 3)
    assert changed.output.gradient_average == "area"
    assert Scene.from_toml(TOML) == GOOD


def test_integers_are_accepted():
    assert Scene.from_toml(TOML.replace("2.0", "2").replace("[1.0, 10.0]", "[1, 10]")) == GOOD


def test_alternative_keys_give_the_same_problem():
    edges = GOOD.changed(punch__rings=None, punch__ring_edges=[2 / 3, 4 / 3, 2.0])
    each = GOOD.changed(punch__wear_coefficients=[1.0, 10.0, 1.0])
    ratio = GOOD.changed(
        punch__wear_coefficients=None, punch__wear_coefficient=1.0, punch__wear_ratio=10.0
    )
    for problem in (edges.problem, each.problem, ratio.problem):
        np.testing.assert_allclose(problem.ring_edges, GOOD.problem.ring_edges, rtol=1e-15)
        np.testing.assert_array_equal(problem.wear_coefficients, GOOD.problem.wear_coefficients)
    young = {"youngs_modulus": 1 - 0.3**2}
    assert GOOD.changed(half_space=young).problem.units.modulus == pytest.approx(1, rel=1e-15)
    mean = {"mean_pressure": 2 / (4 * np.pi)}
    assert GOOD.changed(load=mean).problem.units.force == pytest.approx(2, rel=1e-15)
    mean["mean_pressure"] = {"times": [1.0, 2.0], "values": [0.0, mean["mean_pressure"]]}
    varied = GOOD.changed(load=mean).problem
    assert varied.units.force == pytest.approx(2, rel=1e-15)
    assert varied.loading.at(np.array([0.5, 1.5, 3.0]) / varied.units.time).force.tolist() == [
        0,
        0.5,
        1,
    ]
    # a load with equal values is constant
    same = {"times": [3.0, 5.0], "values": [2.0, 2.0]}
    assert not GOOD.changed(load__normal_force=same).problem.loading.varies


@pytest.mark.parametrize(("ratio", "count"), [(1.0, 1), (0.1, 2), (1.0, 5), (3.0, 4), (0.25, 16)])
def test_ring_widths(ratio, count):
    edges = GOOD.changed(punch__rings=count, punch__width_ratio=ratio).problem.ring_edges
    widths = np.diff(edges)
    assert (edges[0], edges[-1], len(widths)) == (0.0, 1.0, count)
    np.testing.assert_allclose(widths[::2], widths[0], rtol=1e-12)
    np.testing.assert_allclose(widths[1::2], ratio * widths[0], rtol=1e-12)


def test_output_radii_show_every_ring_and_touch_no_edge():
    problem = Scene.load("many_rings").problem
    radii, edges = problem.radii, problem.ring_edges
    assert radii[0] == 0
    assert (np.diff(radii) > 0).all()
    assert not np.isin(radii, edges[1:]).any()
    assert np.histogram(radii, edges)[0].min() >= 8


def test_defaults_are_reported():
    table = Scene.load("five_rings").table()
    del table["half_space"]["poisson_ratio"], table["load"]["sliding_speed"]
    ratio, speed = defaults_taken(Scene.from_table(table))
    assert "poisson_ratio is not given: using 0.3" in ratio
    assert "sliding_speed is not given: using 1" in speed


def test_times_in_units_of_the_running_in():
    table = Scene.load("five_rings").table() | {"wear": {"times": {"tau": [0.0, 0.5, 2.0]}}}
    scene = Scene.from_table(table)
    # 0.3440589, the slowest relaxation time of the reference, to three digits
    assert scene.wear.times == [0.0, 0.172, 0.688]
    np.testing.assert_allclose(scene.problem.times, [0.0, 1.72, 6.88])
    near = Scene.from_table(table | {"wear": {"times": {"tau": [1.0, 1.00001]}}})
    assert near.wear.times[0] < near.wear.times[1]
    assert Scene.from_toml(scene.to_toml()).wear.times == scene.wear.times
    # another speed changes the relaxation time, and with it the times
    assert scene.changed(load__sliding_speed=2.0).wear.times == [0.0, 0.086, 0.344]
    named = Scene.from_table(table | {"wear": {"times": "running-in"}})
    assert (named.wear.times[0], named.wear.times[-1]) == (0.0, 1.72)
    assert scene.changed(wear__times=[1.0]).wear.times == [1.0]


LAYER = {"thickness": 0.1, "youngs_modulus": 5.0}


@pytest.mark.parametrize(
    ("layers", "changes", "words"),
    [
        ([], {"half_space__layers__0__thickness": 0.2}, "give all of them, half_space.layers = [{"),
        ([], {"half_space.layers[0].thickness": 0.2}, "the scene has no half_space.layers"),
        ([LAYER], {"half_space.layers.1.thickness": 0.2}, "0 for the only one"),
        ([LAYER, LAYER], {"half_space.layers.2.thickness": 0.2}, "0 to 1, and one of its keys"),
        ([LAYER], {"half_space.layers.thickness": 0.2}, "such as half_space.layers.0.thickness"),
        ([LAYER], {"half_space.layers.0": 0.2}, "such as half_space.layers.0.thickness"),
        ([LAYER], {"layers.0.thicknes": 0.2}, "changed({'half_space.layers.0.thickness': 0.2})"),
        ([LAYER], {"half_space.layers.0.thicknes": 0.2}, "did you mean thickness?"),
        ([], {"punch.wear_coefficients.1": 2.0}, "give punch.wear_coefficients as a whole"),
        ([], {"punch.radius.x": 2.0}, "punch.radius = 1.0 is not a table"),
        ([], {"load.normal_force.values": [2.0]}, "give load.normal_force as a whole"),
    ],
)
def test_keys_of_lists_and_of_layers_are_answered_with_a_remedy(layers, changes, words):
    scene = Scene.load("five_rings").changed(half_space__layers=layers)
    with pytest.raises(SceneError) as refusal:
        scene.changed(changes)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_index_may_be_in_brackets():
    scene = Scene.load("five_rings").changed(half_space__layers=[LAYER, LAYER])
    changed = scene.changed({"half_space.layers[1].thickness": 0.3})
    assert [layer.thickness for layer in changed.half_space.layers] == [0.1, 0.3]
