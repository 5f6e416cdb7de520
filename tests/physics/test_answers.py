"""Quantities and answers of every load, against closed forms and balances, and between methods."""

import numpy as np
import pytest
from loads import LOADS, pressed_by

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


@pytest.fixture(scope="module")
def sphere():
    return run(Scene.load("sphere").changed(wear__times=[0.0, 0.1]), methods=["mdr"], rtol=1e-2)


@pytest.mark.parametrize("name", LOADS)
def test_results_of_every_load_have_the_same_quantities(name, sphere):
    result = run(pressed_by(**LOADS[name]), methods=["mdr"], rtol=1e-2)
    data = result.dataset.isel(solver=0)
    assert set(data) == set(sphere.dataset)
    for quantity, values in data.items():
        is_error = str(quantity).endswith("_error")
        if values.dims[:1] == ("time",) and quantity != "contact_edge" and not is_error:
            # pressures of a flat punch are infinite at its rim at the start
            assert np.isfinite(values[1:]).all(), quantity
    # only a punch that loses contact has no relaxation modes
    assert data.relaxation_time.isnull().all() == (name == "falling")
    assert result.verdict != "disagree"


def test_a_flat_punch_has_the_contact_of_its_face():
    scene = Scene.load("flat_punch").changed(punch__radius=2.0, load__normal_force=3.0)
    result = run(scene, methods=["mdr"])
    data, answer = result.dataset.isel(solver=0), result.answers["mdr"]
    assert data.contact_radius.values == pytest.approx(2.0)
    assert data.normal_force.values == pytest.approx(3.0, rel=1e-6)
    assert data.contact.values.all()
    np.testing.assert_allclose(data.contact_edge.values, [[0.0, 2.0]] * data.sizes["time"])
    assert answer["contact_radius_start"] == pytest.approx(2.0)
    assert answer["time_to_full_contact"] == 0
    # the force is that of the load, and the volume is k times its work
    assert [answer["force_start"], answer["force_end"]] == pytest.approx([3.0, 3.0], rel=1e-6)
    wear = scene.problem.units.wear_coefficient
    work = 3.0 * data.time.values * wear
    np.testing.assert_allclose(data.ring_worn_volume.values[:, 0], work, rtol=1e-6, atol=1e-12)


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
