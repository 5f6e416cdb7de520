"""Relaxation times and their accuracy, and long after running-in.

Even wear then grows without bound, the shape of the face does not.
"""

import numpy as np
import pytest
from natural import natural

from ringwear import Scene, differences, direct, run

LATE = [1e3, 1e12, 1e39]
PUNCHES = {
    "one material": {"wear_coefficient": 1.0},
    "three rings": {"rings": 3, "wear_coefficients": [1.0, 0.1]},
    "ball": {
        "rings": 2,
        "wear_coefficients": [1.0, 0.1],
        "profile": {"kind": "ball", "ball_radius": 20.0},
    },
}
# RMS slope of the steady state over the line, under the force 1, by independent codes
RMS_SLOPES = {"one material": 0.97399573592 / np.pi, "three rings": 0.75956}


def scene(punch, times=(1e-3, *LATE), force=1.0):
    return natural(punch, times, 1e-4, load={"normal_force": force})


def rings(punch):
    """Return ring edges, and steady pressures under the force 1; k of the first ring is 1."""
    edges = scene(PUNCHES[punch]).problem.ring_edges
    return edges, direct.steady_pressures(edges, np.resize([1.0, 0.1], len(edges) - 1))


def line_slope(edges, pressures):
    return direct.rms_slope(edges, pressures, "line")


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("punch", PUNCHES)
def test_late_states_are_the_steady_state(punch):
    force, rtol = 0.05 if punch == "ball" else 1.0, 1e-4
    result = run(scene(PUNCHES[punch], force=force))
    assert result.verdict == "agree"
    greatest, slope = (
        float(value(*rings(punch))) for value in (direct.greatest_displacement, line_slope)
    )
    rate = rings(punch)[1][0]
    if punch in RMS_SLOPES:
        assert slope == pytest.approx(RMS_SLOPES[punch], rel=1e-5)
    late = result.dataset.sel(time=LATE[1:])
    # cells resolve the slopes of a ball to the stated errors only
    allowed = np.maximum(2 * rtol, late.rms_slope_error if punch == "ball" else 0.0)
    assert (np.abs(late.rms_slope / (force * slope) - 1) <= allowed).all()
    np.testing.assert_allclose(late.displacement_max, force * greatest, rtol=2 * rtol)
    # the displacement at the centre is a difference of two depths, which both grow
    moved = direct.displacement(*rings(punch), np.zeros(1))
    centre = np.broadcast_to(force * moved, late.displacement_centre.shape)
    np.testing.assert_allclose(late.displacement_centre, centre, atol=2 * rtol * force * greatest)
    # at these times the indentation is even wear
    expected = np.broadcast_to(rate * force * np.array(LATE[1:]), late.indentation.shape)
    np.testing.assert_allclose(late.indentation, expected, rtol=1e-9)


def test_a_wrong_shape_is_noticed_however_much_has_worn(monkeypatch):
    """At t = 1e12 the even wear is 1e11 times the displacement."""
    from ringwear import RunningIn

    modal = RunningIn.modal

    def wrong(running_in, times):
        history = modal(running_in, times)
        history.shape[times > 1] *= 1.01
        return history

    monkeypatch.setattr(RunningIn, "modal", wrong)
    result = run(scene(PUNCHES["three rings"]), methods=["mdr"])
    assert result.verdict == "disagree"


def test_a_rim_of_width_1e_9_that_hardly_wears_carries_its_steady_force():
    """The wear rate is ``F / sum of A / k``, to all digits."""
    edge = 0.999999999
    rim = {"ring_edges": [edge, 1.0], "wear_coefficients": [1.0, 1e-8]}
    result = run(scene(rim, times=[0.0, 1.0]), methods=["mdr", "bem", "direct"])
    assert result.verdict == "agree"
    areas = np.pi * np.array([edge**2, (1 - edge) * (1 + edge)])
    rate = 1 / (areas[0] + areas[1] / 1e-8)
    np.testing.assert_allclose(result.dataset.steady_wear_rate, rate, rtol=1e-12)


def test_results_with_different_numbers_of_modes_are_compared():
    times = np.array([1.0, 0.5, 0.25])
    three, two = ({"relaxation_time": values} for values in (1.5 * times, times[:2]))
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
