"""The independent reference that estimates are judged by is judged itself.

By closed forms and by numbers from elsewhere.
"""

import numpy as np
import pytest
from wear_reference import Reference

from ringwear.mdr import direct


def test_history_of_five_rings(reference):
    wear, states = np.array(reference["wear_coefficients"]), reference["states"]
    fastest, radii = wear.max(), np.array(reference["radii"])
    punch = Reference(np.array(reference["ring_edges"]), wear / fastest, np.full(5, 1e-13))
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


def test_late_it_is_the_steady_state_in_closed_form():
    edges, wear = np.array([0.0, 0.2, 0.5, 0.55, 1.0]), np.array([1.0, 0.1, 1.0, 0.3])
    punch = Reference(edges, wear, np.full(4, 1e-13), factor=0.25)
    pressures = direct.steady_pressures(edges, wear)
    assert punch.wear_rate == pytest.approx(wear[0] * pressures[0], rel=1e-12)
    pressure, worn, indentation = punch.at(np.array([1e3]))
    middle = (edges[1:] + edges[:-1]) / 2
    np.testing.assert_allclose(punch.values(pressure, middle)[0], pressures, rtol=1e-11)
    expected = direct.displacement(edges, pressures, middle)
    np.testing.assert_allclose(indentation - punch.worn(worn, middle)[0], expected, rtol=1e-10)
    greatest = direct.greatest_displacement(edges, pressures)
    assert (indentation - punch.lowest(worn))[0] == pytest.approx(greatest, rel=1e-9)
    for average in ("line", "area"):
        slope = direct.rms_slope(edges, pressures, average)
        assert punch.rms_slopes(worn, average)[0] == pytest.approx(slope, rel=1e-7)
    early, _, _ = punch.at(np.array([1e-6, 1e-3, 1.0]))
    np.testing.assert_allclose(punch.ring_forces(early).sum(axis=1), 1, rtol=1e-13)
