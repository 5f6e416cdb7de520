"""The reported steady state is that of the last load, or is left out if it cannot be reached."""

import numpy as np
import pytest
from natural import natural

from ringwear import Scene, direct, run

PUNCH = {"radius": 2.0, "ring_edges": [1.0, 2.0], "wear_coefficients": [1.0, 4.0]}
BASE = {
    "punch": PUNCH,
    "half_space": {"plane_strain_modulus": 5.0},
    "wear": {"times": [0.0, 10.0]},
    "accuracy": {"rtol": 1e-3},
}
ROUNDED = {"kind": "rounded_rim", "flat_radius": 1.8, "curvature_radius": 2.0}
LOADS = {
    "rising": {"normal_force": {"times": [0.0, 1.0], "values": [0.1, 0.4]}},
    "falling": {
        "normal_force": {"times": [0.0, 1.0, 2.0], "values": [0.1, 0.4, 0.2]},
        "sliding_speed": {"times": [0.0, 1.0], "values": [3.0, 2.0]},
    },
}


@pytest.mark.parametrize("profile", [{}, {"profile": ROUNDED}], ids=["flat", "rounded"])
@pytest.mark.parametrize("name", LOADS)
def test_the_steady_state_is_that_of_the_last_load(name, profile):
    scene = Scene.from_table(BASE | {"punch": PUNCH | profile, "load": LOADS[name]})
    result = run(scene, methods=["mdr", "bem", "direct"])
    assert result.verdict == "agree"
    force, speed = (0.4, 1.0) if name == "rising" else (0.2, 2.0)
    areas, wear = np.pi * np.array([1.0, 3.0]), np.array([1.0, 4.0])
    rate = force / np.sum(areas / wear)
    for solver in ("mdr", "direct"):
        data = result.dataset.sel(solver=solver)
        assert float(data.steady_wear_rate) == pytest.approx(speed * rate, rel=1e-9)
        pressures = np.where(data.radius < 1.0, rate, rate / 4)
        np.testing.assert_allclose(data.steady_pressure, pressures, rtol=1e-6)
        greatest = direct.greatest_displacement(np.array([0.0, 0.5, 1.0]), rate / wear)
        # u in units of a p / E*, with a = 2 and E* = 5
        expected = 2.0 / 5.0 * float(greatest)
        assert float(data.steady_displacement_max) == pytest.approx(expected, rel=1e-4)
    answer = result.answers["mdr"]
    assert answer["force_share"][1] == pytest.approx(rate / wear * areas / force, rel=1e-6)


@pytest.mark.parametrize("what", ["normal_force", "sliding_speed"])
def test_a_load_that_ends_has_no_steady_state(what):
    load = {"normal_force": 0.3} | {what: {"times": [0.0, 5.0], "values": [0.3, 0.0]}}
    result = run(Scene.from_table(BASE | {"load": load}), methods=["mdr"])
    assert np.isnan(result.dataset.steady_wear_rate).all()
    assert "no longer wears" in result.summary["left_out"]["steady state"]


def test_a_steady_state_out_of_reach_is_not_reported():
    """A washer, given by a deep recess, whose inner disc would touch only at t = 2.4e6."""
    punch = {"ring_edges": [0.5, 1.0], "recess": [1e6, 0.0], "wear_coefficients": [1.0, 1.0]}
    result = run(natural(punch, [0.0, 5.0, 10.0, 11.0]))
    assert result.verdict == "agree"
    assert np.isnan(result.dataset.steady_wear_rate).all()
    # until then, 3/4 of the face wears by 1e6: t = 1e6 * 3 pi / 4
    assert "t = 2.4e+06" in result.summary["left_out"]["steady state"]
    answer = result.answers["mdr"]
    for name in ("running_in_time", "indentation_steady"):
        assert np.isnan(answer[name])
    # the wear rate of the washer tends to F / A of the ring
    depths = result.dataset.indentation.sel(solver="mdr").to_numpy()
    assert depths[3] - depths[2] == pytest.approx(1 / (0.75 * np.pi), rel=1e-3)


def test_a_recess_that_will_touch_keeps_its_steady_state():
    recessed = {**BASE, "load": {"normal_force": 0.3}, "wear": {"times": [0.0, 0.1]}}
    scene = Scene.from_table(recessed | {"punch": PUNCH | {"recess": [0.05, 0.0]}})
    result = run(scene, methods=["mdr"])
    assert np.isfinite(result.dataset.steady_wear_rate).all()
    assert any(
        "that of full contact, which the history does not reach" in note for note in result.notes
    )
