"""Answers for flat punches against closed forms, balances and an independent history."""

import numpy as np
import pytest
from closed_forms import disc_energies

from ringwear import Scene, alternating_edges, direct, ring_areas, run

EDGES, K = alternating_edges(5), np.array([1.0, 10.0, 1.0, 10.0, 1.0])


@pytest.fixture(scope="module")
def five():
    return run(Scene.load("five_rings").changed(methods=["mdr", "direct"]))


def test_running_in_against_an_independent_history(five, reference):
    """`time_until` at the completed fraction of each reference state returns the state's time."""
    wear = five.solutions["mdr"].wear
    assert wear is not None
    slowest = reference["slowest_relaxation_times"][0]
    assert five.answers["mdr"]["running_in_time"] == pytest.approx(slowest, rel=1e-9)
    # final value of d(t) minus the steady wear, under the force F = 2: d F = int u p dA
    pressures = 2 * direct.steady_pressures(EDGES, K)
    rate, (discs, steps) = K[0] * pressures[0], direct.pressure_steps(EDGES, pressures)
    end = steps @ disc_energies(discs) @ steps / 2.0
    for state in reference["states"]:
        way = (state["indentation"] - rate * state["time"] - 1.0) / (end - 1.0)
        # the unit of time belongs to the greatest wear coefficient, which is 10
        time = wear.time_until(1 - way) * five.scene.problem.units.time
        assert time == pytest.approx(state["time"], rel=1e-6)


def test_start_and_steady_state_in_closed_form(five):
    close, answer, root = np.testing.assert_allclose, five.answers["mdr"], np.sqrt(1 - EDGES**2)
    with np.errstate(divide="ignore"):
        pressures = 1 / np.pi / root
    close(answer["indentation_start"], 1.0, rtol=1e-8)
    close(answer["pressure_min"][0], pressures[:-1], rtol=1e-4)
    close(answer["pressure_max"][0], pressures[1:], rtol=1e-4)
    close(answer["force_share"][0], -np.diff(root), rtol=0, atol=1e-8)
    steady = 2 * direct.steady_pressures(EDGES, K)
    for answer in five.answers.values():
        close(answer["pressure_min"][1], steady, rtol=1e-10)
        close(answer["pressure_max"][1], steady, rtol=1e-10)
        close(answer["force_share"][1], steady * ring_areas(EDGES) / 2, rtol=1e-10)
        close(answer["steady_wear_rate"], steady[0], rtol=1e-10)


@pytest.mark.parametrize(
    "coefficients", [[1.0, 10.0], [3.0, 3.0]], ids=["five materials", "one material"]
)
def test_worn_volumes_over_k_sum_to_force_times_distance(coefficients):
    """The sum of V / k over the rings is F v0 t, also if all rings have one material.

    Radius, force and speed differ from 1, so that units are tested, too.
    """
    scene = Scene.load("five_rings").changed(
        methods=["mdr"],
        punch__wear_coefficients=coefficients,
        punch__radius=2.0,
        load__normal_force=5.0,
        load__sliding_speed=3.0,
    )
    data = run(scene).dataset.sel(solver="mdr")
    volumes = data.worn_volume
    assert float((volumes / data.wear_coefficient).sum()) == pytest.approx(30.0, rel=1e-6)
    if coefficients[0] == coefficients[1]:
        # the profile is smooth across edges: compare with its integral over the second ring
        data = run(scene.changed(output__radii=np.linspace(0.4, 0.8, 2001).tolist())).dataset
        rings = 2 * np.pi * data.radius * data.profile[0, -1]
        assert float(volumes[1]) == pytest.approx(float(rings.integrate("radius")), rel=1e-6)


@pytest.mark.slow
def test_the_papers_algorithm_reports_worn_volumes_but_no_running_in_time():
    scene = Scene.load("five_rings").changed(methods=["mdr", "mdr-grid"], wear__steady=False)
    exact, grid = run(scene).answers.values()
    assert np.isnan(grid["running_in_time"])
    np.testing.assert_allclose(grid["worn_volume"], exact["worn_volume"], rtol=1e-2)
