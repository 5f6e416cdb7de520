"""Balls, cones and parabolas without a punch radius: the scar goes on growing.

The face is only wider than the contact gets, and no number depends on how much wider.
"""

import numpy as np
import pytest
from groups import nightly_but

from ringwear import Scene, SceneError, run
from ringwear.studies.crosscheck.scene import scar

BALL = {"kind": "ball", "ball_radius": 3.0}
SHAPES = {
    "ball": BALL,
    "parabola": {"kind": "parabola", "curvature_radius": 3.0},
    "cone": {"kind": "cone", "slope": 0.02},
}
MODULUS, FORCE, SPEED, K = 210e3 / (1 - 0.3**2), 10.0, 100.0, 1e-6


def scene(shape="ball", times=(0.0, 360.0, 3600.0), methods="mdr", **tables):
    table = {
        "units": "mm, N, MPa, s",
        "methods": methods.split(),
        "punch": {"profile": SHAPES[shape], "wear_coefficient": K},
        "half_space": {"youngs_modulus": 210e3},
        "load": {"normal_force": FORCE, "sliding_speed": SPEED},
        "wear": {"times": list(times)},
        "accuracy": {"rtol": 1e-3},
    }
    return Scene.from_table(table | tables)


def test_a_scar_starts_as_hertz_and_grows_with_the_worn_volume():
    result = run(scene(methods="mdr bem"))
    assert result.verdict == "agree"
    data, times = result.dataset.sel(solver="mdr"), np.array([0.0, 360.0, 3600.0])
    volumes = K * FORCE * SPEED * times
    np.testing.assert_allclose(data.ring_worn_volume[:, 0], volumes, rtol=1e-3)
    hertz = (3 * FORCE * 3.0 / (4 * MODULUS)) ** (1 / 3)
    assert float(data.contact_radius[0]) == pytest.approx(hertz, rel=1e-3)
    # the volume of the cap of a ball, from which the elastic part takes less than 1 %
    depth = 3.0 - np.sqrt(9.0 - data.contact_radius[1:] ** 2)
    caps = np.pi * depth**2 * (3.0 - depth / 3)
    np.testing.assert_allclose(caps, volumes[1:], rtol=2e-2)
    answer = result.answers["mdr"]
    assert answer["contact_radius_end"] == pytest.approx(float(data.contact_radius[-1]))
    assert answer["worn_depth_end"] == pytest.approx(float(depth[-1]), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
def test_numbers_do_not_depend_on_how_much_wider_the_face_is(shape, monkeypatch):
    results, faces = [], []
    for factor in (1.0, 1.2, 3.0):
        monkeypatch.setattr(scar, "MARGIN", 1.2 * factor)
        own = scene(shape, times=[0.0, 3.6, 36.0])
        faces.append(own.punch.radius)
        results.append(run(own).dataset.isel(solver=0))
    assert faces[1:] == pytest.approx([1.2 * faces[0], 3 * faces[0]])
    for name in ("indentation", "ring_worn_volume"):
        for other in results[1:]:
            np.testing.assert_allclose(other[name], results[0][name], rtol=1e-3)
    for other in results[1:]:
        error = other.contact_radius_error + results[0].contact_radius_error
        apart = np.abs(other.contact_radius - results[0].contact_radius)
        assert (apart <= error).all()


FORCES = {"times": [0.0, 1000.0, 2000.0], "values": [10.0, 1.0, 10.0]}
COAT = {"thickness": 0.05, "youngs_modulus": 2e3}


@pytest.mark.slow
@pytest.mark.parametrize("shape", nightly_but(("cone",), SHAPES))
@pytest.mark.parametrize(
    "tables",
    [
        {},
        {"times": [0.0]},
        {"load": {"normal_force": FORCES, "sliding_speed": SPEED}},
        {"load": {"indentation": 0.003, "sliding_speed": SPEED}, "times": [0.0, 100.0]},
        {"half_space": {"youngs_modulus": 210e3, "layers": [COAT]}, "times": [0.0, 36.0]},
    ],
    ids=["constant", "unworn", "varying", "held", "coated"],
)
def test_the_contact_stays_within_the_face(shape, tables):
    """The bound of the contact radius has the margin in hand, and is not far above it."""
    own = scene(shape, accuracy={"rtol": 1e-2}, **tables)
    result = run(own)
    assert result.verdict != "disagree"
    widest = float(result.dataset.contact_radius.max()) / own.punch.radius
    assert 0.5 < widest < 1.02 / scar.MARGIN


def test_what_depends_on_a_rim_is_left_out_with_the_reason():
    own = scene(times=[0.0, 36.0])
    result = run(own)
    assert "radius" not in own.table()["punch"]
    assert Scene.from_toml(own.to_toml()).punch.radius == own.punch.radius
    assert not {"rms_slope", "steady_pressure", "relaxation_time"} & {*result.dataset}
    rim = ("running_in_time", "time_to_90", "time_to_99", "time_to_full_contact")
    assert np.isnan([result.answers["mdr"][name] for name in rim]).all()
    left_out = result.summary["left_out"]
    assert left_out["steady state"] == "the scar goes on growing"
    assert "goes on growing" in left_out["times of running-in and full contact"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"punch": {"profile": BALL, "wear_coefficients": [1.0, 2.0]}}, "one of rings, ring_edges"),
        ({"punch": {"profile": BALL, "wear_coefficient": K, "rings": 2}}, "other keys of punch"),
        ({"load": {"mean_pressure": 1.0, "sliding_speed": 1.0}}, "load.mean_pressure"),
        ({"wear": {"times": "running-in"}}, "running-in"),
        ({"wear": {}}, "without wear.times"),
        ({"wear": {"times": [1e9]}}, "wider than the ball, whose radius is 3"),
        ({"punch": {"profile": {"kind": "ball"}, "wear_coefficient": K}}, "ball_radius"),
        ({"load": {"normal_force": -1.0}}, "load.normal_force"),
        ({"punch": {"profile": {"kind": "power"}, "wear_coefficient": K}}, "punch.radius"),
    ],
)
def test_scenes_that_need_a_radius_are_refused(changes, words):
    with pytest.raises(SceneError, match=words):
        scene(**changes)
