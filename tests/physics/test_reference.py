"""The reference solution of other tests against a stored history and closed forms."""

import numpy as np
from wear_reference import Reference

from ringwear import direct, ring_areas


def test_history_of_five_rings(reference):
    states, radii = reference["states"], np.array(reference["radii"])
    edges, wear = np.array(reference["ring_edges"]), np.array(reference["wear_coefficients"])
    fastest = wear.max()
    wear = wear / fastest
    punch = Reference(edges, wear, np.full(5, 1e-10))
    pressure, worn, indentation = punch.at(np.array([state["time"] for state in states]) * fastest)

    def assert_equal(values, name, rtol, first=0):
        expected = np.array([state[name] for state in states]) / reference["normal_force"]
        np.testing.assert_allclose(values[first:], expected[first:], rtol=rtol)

    assert_equal(indentation, "indentation", 1e-10)
    assert_equal(indentation - punch.worn(worn, np.zeros(1))[:, 0], "displacement_centre", 1e-9)
    assert_equal(punch.values(pressure, radii), "pressure", 2e-6, first=3)
    assert_equal(punch.worn(worn, radii), "profile", 2e-6, first=3)
    for average in ("line", "area"):
        assert_equal(punch.rms_slopes(worn, average), f"rms_slope_{average}", 1e-5, first=3)
    expected = np.array(reference["slowest_relaxation_times"]) * fastest
    np.testing.assert_allclose(punch.relaxation_times[: len(expected)], expected, rtol=1e-10)
    # at a late time, the steady state
    pressure, worn, indentation = punch.at(np.array([1e3]))
    steady = direct.steady_pressures(edges, wear)
    np.testing.assert_allclose(punch.wear_rate, wear[0] * steady[0], rtol=1e-12)
    forces = punch.ring_forces(pressure)[0]
    np.testing.assert_allclose(forces, steady * ring_areas(edges), rtol=1e-11)
    greatest = direct.greatest_displacement(edges, steady)
    np.testing.assert_allclose(indentation - punch.lowest(worn), greatest, rtol=1e-9)
