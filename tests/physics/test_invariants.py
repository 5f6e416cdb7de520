"""Properties that every method has for every scene: balances, signs and units."""

from functools import cache
from itertools import product

import numpy as np
import pytest
from conftest import METHODS
from groups import nightly, slow

from ringwear import Scene, run

FIVE = Scene.load("five_rings").changed(accuracy__rtol=1e-3)
# from well below the fastest resolved relaxation time to the steady state
TIMES = np.concatenate([[0.0], np.geomspace(1e-4, 1e2, 25)])


@pytest.mark.parametrize(
    ("scene", "method"),
    [
        *product(("flat_punch", "five_rings", "rubber"), METHODS),
        *slow(("many_rings", "mdr"), ("many_rings", "quads")),
        *nightly(*product(["many_rings"], ("bem", "gmsh", "bisection"))),
    ],
)
def test_flat_punches_balance_forces_and_stay_in_full_contact(prepare, scene, method):
    punch = prepare(scene, method)
    history, space = punch.wear.history(TIMES), punch.space
    # forces balance
    assert np.abs(history.pressure @ space.weights - 1).max() <= 1e-12
    on_rings = history.pressure @ space.ring_forces(punch.problem.ring_edges).T
    np.testing.assert_allclose(on_rings.sum(axis=1), 1, rtol=1e-12)
    # a flat start never loses contact: a negative pressure would be an artefact
    everywhere = space.matrix(punch.everywhere)
    assert (everywhere @ history.pressure.T).min() > 0
    # the profile only grows
    profile = everywhere @ history.profile.T
    assert np.abs(profile[:, 0]).max() == 0
    assert np.diff(profile).min() > 0
    # a jump of the wear rate would tear the profile: at ring edges the pressure jumps
    edges, (wear, _) = punch.problem.merged
    later = history.pressure[1:].T
    inside = space.matrix(np.nextafter(edges[1:-1], 0)) @ later * wear[:-1, None]
    outside = space.matrix(edges[1:-1]) @ later * wear[1:, None]
    np.testing.assert_allclose(inside, outside, rtol=1e-9)


def test_wear_is_the_integral_of_the_wear_rate(prepare, method):
    """Archard's law, df = k int p dt, over a time in which p is not linear, by 40 Gauss points."""
    punch = prepare("five_rings", method)
    node, weight = np.polynomial.legendre.leggauss(40)
    begin, half = 0.02, 0.09
    history = punch.wear.history(np.array([begin, begin + 2 * half, *(begin + half * (1 + node))]))
    radii = np.array([0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95])
    values, wear = punch.space.matrix(radii), punch.problem.rings.at(radii)
    worn = wear * (half * weight @ (history.pressure[2:] @ values.T))
    np.testing.assert_allclose(values @ (history.profile[1] - history.profile[0]), worn, rtol=1e-10)


def test_neighbours_of_equal_wear_are_merged():
    merged = FIVE.changed(punch__wear_coefficients=[1.0, 1.0, 10.0, 10.0, 1.0]).problem.merged
    np.testing.assert_allclose(merged.ring_edges, [0, 0.4, 0.8, 1.0], rtol=1e-15)
    np.testing.assert_array_equal(merged.wear_coefficients, [[0.1, 1.0, 0.1]] * 2)


@cache
def dimensionless(a, modulus, force, speed, wear):
    """Return results of uneven rings by every method, in natural units of a, E*, F, v0 and k."""
    height, time = force / a / modulus, a / modulus / speed / wear
    edges = [edge * a for edge in (0.2, 0.47, 0.6, 0.83, 1.0)]
    scene = FIVE.changed(
        punch={"radius": a, "ring_edges": edges, "wear_coefficients": [wear, 10 * wear]},
        half_space={"plane_strain_modulus": modulus},
        load={"normal_force": force, "sliding_speed": speed},
        wear__times=[t * time for t in (0.0, 1e-3, 0.1, 1.0)],
        output__radii=[r * a for r in (0.1, 0.3, 0.5, 0.7, 0.9)],
    )
    data = run(scene).dataset
    units = {
        "indentation": height,
        "displacement_centre": height,
        "profile": height,
        "steady_profile": height,
        "pressure": force / a / a,
        "steady_pressure": force / a / a,
        "ring_force": force,
        "relaxation_time": time,
        "rms_slope": height / a,
        "steady_rms_slope": height / a,
        "steady_wear_rate": height / time,
    }
    return {name: data[name].to_numpy() / unit for name, unit in units.items()}


OTHERS = [(3e-4, 2e9, 5e7, 1e-9, 0.5), (6e8, 4e-6, 2e-3, 8e5, 3e-10)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "units",
    [
        (1e-10, 1e10, 1e-10, 1e10, 1e-6),
        (1e10, 1e-10, 1e10, 1e-10, 7.0),
        *(pytest.param(units, marks=pytest.mark.nightly) for units in OTHERS),
    ],
)
def test_dimensionless_results_do_not_depend_on_units(units):
    """Radius, modulus, force, speed and wear vary by up to twenty decades."""
    expected, values = dimensionless(1.0, 1.0, 1.0, 1.0, 1.0), dimensionless(*units)
    for name, exact in expected.items():
        atol = 1e-9 * np.nanmax(np.abs(exact))
        np.testing.assert_allclose(values[name], exact, rtol=1e-9, atol=atol, err_msg=name)
