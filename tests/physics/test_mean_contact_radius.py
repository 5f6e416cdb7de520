"""The mean radius at which the force acts, against closed forms, to within its error estimates."""

import numpy as np
import pytest

from ringwear import Scene, run


def assert_mean_radii(result, expected, radius):
    """Compare mean radii at all times; errors are relative to the radius of the punch."""
    for solver in result.solver.values:
        values, errors = (
            result[name].sel(solver=solver).values
            for name in ("mean_contact_radius", "mean_contact_radius_error")
        )
        assert errors.max() <= 2e-3
        assert (np.abs(values - expected) <= errors * radius).all()


@pytest.mark.gmsh
def test_a_flat_punch_and_its_steady_state():
    """``p = p0 / sqrt(1 - r^2/a^2)`` has the mean radius pi a / 4, and p = const has 2 a / 3."""
    scene = Scene.load("flat_punch").changed(punch__radius=3.0, wear__times=[0.0, 1e4])
    result = run(scene, methods=["mdr", "bem", "fem"]).dataset
    assert_mean_radii(result, [3 * np.pi / 4, 2.0], 3.0)


def test_a_sphere_by_hertz():
    """``p = p0 sqrt(1 - r^2/c^2)`` has the mean radius 3 pi c / 16."""
    scene = Scene.load("sphere").changed(accuracy__rtol=1e-3, wear__times=[0.0])
    result = run(scene, methods=["mdr", "bem"]).dataset
    edge = (0.75 * scene.problem.units.force / scene.half_space.modulus) ** (1 / 3)
    edge *= scene.punch.profile.curvature_radius ** (1 / 3)
    assert_mean_radii(result, [3 * np.pi / 16 * edge], scene.problem.units.length)


def test_a_punch_that_does_not_press_has_none():
    load = {"times": [0.0, 1.0], "values": [0.0, 1.0]}
    scene = Scene.load("flat_punch").changed(load__normal_force=load, wear__times=[0.0, 1.0])
    values = run(scene, methods=["mdr", "bem"]).dataset.mean_contact_radius.values
    assert (values[:, 0] == 0).all()
    assert (values[:, 1] > 0).all()
