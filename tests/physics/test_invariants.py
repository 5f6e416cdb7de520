"""What holds for every method and every scene, whatever the numbers."""

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ringwear import Scene, run

# from far inside the fastest relaxation that is resolved to the steady state
TIMES = np.concatenate([[0.0], np.geomspace(1e-4, 1e2, 25)])
SCENES = ["flat_punch", "five_rings", "rubber", "many_rings"]


@pytest.mark.parametrize("scene", SCENES)
def test_forces_balance(prepare, scene, method):
    punch = prepare(scene, method)
    pressure = punch.wear.history(TIMES).pressure
    assert np.abs(pressure @ punch.space.weights - 1).max() <= 1e-12
    on_rings = pressure @ punch.space.ring_forces(punch.problem.ring_edges).T
    np.testing.assert_allclose(on_rings.sum(axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("scene", SCENES)
def test_pressure_stays_positive(prepare, scene, method):
    """A flat start never loses contact: a negative pressure would be an artefact."""
    punch = prepare(scene, method)
    pressure = punch.wear.history(TIMES).pressure @ punch.space.matrix(punch.everywhere).T
    assert pressure.min() > 0


@pytest.mark.parametrize("scene", SCENES)
def test_profile_only_grows(prepare, scene, method):
    punch = prepare(scene, method)
    profile = punch.wear.history(TIMES).profile @ punch.space.matrix(punch.everywhere).T
    assert np.abs(profile[0]).max() == 0
    assert np.diff(profile, axis=0).min() > 0


@pytest.mark.parametrize("scene", ["five_rings", "rubber", "many_rings"])
def test_wear_rate_is_continuous_across_ring_edges(prepare, scene, method):
    """A jump of df/dt would tear the profile.

    The pressure jumps by the ratio of the wear coefficients.
    """
    punch = prepare(scene, method)
    edges, wear = punch.problem.merged
    pressure = punch.wear.history(TIMES[1:]).pressure
    inside = punch.space.matrix(np.nextafter(edges[1:-1], 0)) @ pressure.T * wear[:-1, None]
    outside = punch.space.matrix(edges[1:-1]) @ pressure.T * wear[1:, None]
    np.testing.assert_allclose(inside, outside, rtol=1e-9)


def test_wear_is_the_integral_of_the_wear_rate(prepare, method):
    """Archard's law over a time in which nothing is linear: df = k int p dt, by 40 Gauss points."""
    punch = prepare("five_rings", method)
    node, weight = np.polynomial.legendre.leggauss(40)
    begin, end = 0.02, 0.2
    history = punch.wear.history(
        np.concatenate([[begin, end], begin + (end - begin) * (1 + node) / 2])
    )
    radii = np.array([0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95])
    values = punch.space.matrix(radii)
    wear = punch.problem.wear_coefficients[np.searchsorted(punch.problem.ring_edges, radii) - 1]
    worn = wear * ((end - begin) / 2 * weight @ (history.pressure[2:] @ values.T))
    np.testing.assert_allclose(values @ (history.profile[1] - history.profile[0]), worn, rtol=1e-10)


def test_rings_of_equal_wear_are_no_rings(prepare, method):
    same = {"wear__times": (0.0, 0.1)}
    flat = prepare("flat_punch", method, punch__wear_coefficients=(3.0, 3.0), **same)
    ringed = prepare("five_rings", method, punch__wear_coefficients=(3.0, 3.0), **same)
    np.testing.assert_array_equal(ringed.problem.merged.ring_edges, [0.0, 1.0])
    histories = [punch.wear.history(TIMES) for punch in (flat, ringed)]
    for name in ("pressure", "profile", "indentation"):
        np.testing.assert_array_equal(*(getattr(history, name) for history in histories))


def test_neighbours_of_equal_wear_are_one_ring(prepare, method):
    split = prepare("five_rings", method, punch__wear_coefficients=(1.0, 1.0, 10.0, 10.0, 1.0))
    np.testing.assert_allclose(split.problem.merged.ring_edges, [0, 0.4, 0.8, 1.0], rtol=1e-15)
    np.testing.assert_array_equal(split.problem.merged.wear_coefficients, [0.1, 1.0, 0.1])


@pytest.mark.parametrize("factor", [0.5, 7.0, 1e-6])
def test_scaling_the_wear_coefficients_scales_time(factor):
    def history(scale):
        times = [t / scale for t in (1e-3, 0.1, 1.0)]
        coefficients = [1.0 * scale, 10.0 * scale]
        scene = Scene.load("five_rings").changed(
            punch__wear_coefficients=coefficients, wear__times=times
        )
        return run(scene.changed(methods=["mdr"], accuracy__rtol=1e-3)).dataset

    given, scaled = history(1.0), history(factor)
    powers = dict.fromkeys(("pressure", "profile", "indentation", "rms_slope", "ring_force"), 0)
    for name, power in {**powers, "relaxation_time": -1, "steady_wear_rate": 1}.items():
        np.testing.assert_allclose(scaled[name], factor**power * given[name], rtol=1e-10)


def dimensionless(a, modulus, force, speed):
    """Results of uneven rings over the units made of a, E*, F and v0, by every method."""
    edges = [0.2, 0.47, 0.6, 0.83]
    table: dict[str, Any] = {
        "methods": ["mdr", "direct", "fem"],
        "punch": {
            "radius": a,
            "ring_edges": [edge * a for edge in edges] + [a],
            "wear_coefficients": [1.0, 10.0],
        },
        "half_space": {"plane_strain_modulus": modulus},
        "load": {"normal_force": force, "sliding_speed": speed},
        "wear": {"times": [t * a / modulus / speed for t in (0.0, 1e-3, 0.1, 1.0)]},
        "output": {"radii": [r * a for r in (0.1, 0.3, 0.5, 0.7, 0.9)]},
        "accuracy": {"rtol": 1e-3},
    }
    data = run(Scene.from_table(table)).dataset
    height, time = force / a / modulus, a / modulus / speed
    units = {
        "indentation displacement_centre profile steady_profile": height,
        "pressure steady_pressure": force / a / a,
        "ring_force": force,
        "relaxation_time": time,
        "rms_slope steady_rms_slope": height / a,
        "steady_wear_rate": height / time,
    }
    pairs = ((name, unit) for names, unit in units.items() for name in names.split())
    return {name: data[name].to_numpy() / unit for name, unit in pairs}


decades = st.floats(-10, 10).map(lambda power: 10.0**power)


@pytest.mark.slow
@settings(max_examples=6, deadline=None, derandomize=True)
@given(decades, decades, decades, decades)
@example(1e-10, 1e10, 1e-10, 1e10)
@example(1e10, 1e-10, 1e10, 1e-10)
def test_units_do_not_matter(a, modulus, force, speed):
    """Twenty decades of radius, modulus, force and speed change nothing that has no dimension."""
    expected, values = dimensionless(1.0, 1.0, 1.0, 1.0), dimensionless(a, modulus, force, speed)
    for name, exact in expected.items():
        atol = 1e-9 * np.nanmax(np.abs(exact))
        np.testing.assert_allclose(values[name], exact, rtol=1e-9, atol=atol, err_msg=name)
