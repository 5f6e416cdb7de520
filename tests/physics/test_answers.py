"""Worn volumes in the answers of flat punches, against a balance and between methods."""

import numpy as np
import pytest

from ringwear import Scene, run


@pytest.mark.parametrize("method", ["mdr", "bem", "fem"])
def test_rings_of_one_material_share_the_force_of_one_disc(method):
    """The force within r is ``F (1 - sqrt(1 - r^2/a^2))`` first, and ``F r^2/a^2`` in the end."""
    scene = Scene.load("five_rings").changed(
        punch={"radius": 2.0, "rings": 2, "wear_coefficients": [2.0, 2.0]},
        load__normal_force=5.0,
        wear__times=[0.0, 0.1, 100.0],
        output__radii=np.linspace(1.0, 2.0, 2001).tolist(),
    )
    data = run(scene, methods=[method], rtol=1e-3).dataset.isel(solver=0)
    inner = np.array([1 - np.sqrt(1 - 0.5**2), 0.5**2])
    forces = 5.0 * np.stack([inner, 1 - inner], axis=1)
    np.testing.assert_allclose(data.ring_force[[0, -1]], forces, rtol=1e-3)
    np.testing.assert_allclose(5.0 * data.force_share, forces, rtol=1e-3)
    # the profile is smooth across the edge: compare with its integral over the second ring
    worn = (2 * np.pi * data.radius * data.profile).integrate("radius")
    np.testing.assert_allclose(data.ring_worn_volume[1:, 1], worn[1:], rtol=1e-3)


@pytest.mark.slow
def test_the_papers_algorithm_reports_worn_volumes_but_no_running_in_time():
    scene = Scene.load("five_rings").changed(methods=["mdr", "mdr-grid"], wear__steady=False)
    exact, grid = run(scene).answers.values()
    assert np.isnan(grid["running_in_time"])
    np.testing.assert_allclose(grid["worn_volume"], exact["worn_volume"], rtol=1e-2)
