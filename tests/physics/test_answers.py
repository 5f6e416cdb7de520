"""Worn volumes in the answers of flat punches, against a balance and between methods."""

import numpy as np
import pytest

from ringwear import Scene, run


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
