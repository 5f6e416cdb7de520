"""Relaxation times: slow rings, and the accuracy of those that are reported."""

import numpy as np
import pytest
import xarray
from natural import natural

from ringwear import Scene, differences, run


def test_results_with_different_numbers_of_modes_are_compared():
    times = np.array([1.0, 0.5, 0.25])
    three, two = (
        xarray.Dataset({"relaxation_time": ("mode", values)}) for values in (1.5 * times, times[:2])
    )
    compared = differences(three, two, Scene.load("five_rings").problem.face)
    np.testing.assert_array_equal(compared["relaxation_time"], [0.5, 0.5])


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize(
    ("edges", "wear"),
    [([1.0], [1.0]), ([0.5, 1.0], [1.0, 1.22]), ([0.2, 0.3, 1.0], [0.03, 1.0, 0.2])],
)
def test_reported_relaxation_times_are_as_accurate_as_stated(edges, wear, rtol):
    """The faster modes are reported only as far as the discretisation resolves them."""
    punch = {"ring_edges": edges, "wear_coefficients": wear}
    output = {"quantities": ["history"]}

    def reported(tolerance):
        scene = natural(punch, [0.0, 0.01, 1.0], tolerance, "mdr", output=output)
        data = run(scene).dataset.sel(solver="mdr")
        return data.relaxation_time.values, data.relaxation_time_error.values

    times, stated = reported(rtol)
    count = int(np.isfinite(times).sum())
    assert count >= 8
    assert not np.isfinite(times[count:]).any()
    # at a rtol that is a thousand times smaller, more of them are resolved
    exact, errors = reported(max(rtol * 1e-3, 1e-9))
    known = np.isfinite(exact[:count])
    error = np.abs(times[:count] / exact[:count] - 1)[known]
    assert (error <= 1.5 * np.maximum(stated[:count], rtol)[known] + errors[:count][known]).all()
    assert stated[:count].max() <= 0.02 or count == 8
