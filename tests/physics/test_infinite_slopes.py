"""RMS slopes of faces whose slope is infinite, or nearly so, at a point."""

import json

import numpy as np
import pytest
from groups import nightly
from natural import natural

from ringwear import run


def ball(radius, times, average="line", methods="mdr"):
    scene = natural(
        {"wear_coefficient": 1.0, "profile": {"kind": "ball", "ball_radius": radius}},
        methods=methods,
        load={"normal_force": 1e-4},
        wear={"times": times, "steady": False},
        output={"gradient_average": average},
    )
    return run(scene)


def mean_square_of_ball(radius, average):
    """Return the mean of ``r^2 / (R^2 - r^2)`` over the radius or the area."""
    if average == "line":
        return radius / 2 * np.log((radius + 1) / (radius - 1)) - 1
    return radius**2 * np.log(radius**2 / ((radius - 1) * (radius + 1))) - 1


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_ball_as_wide_as_the_punch_has_no_rms_slope(tmp_path):
    result = ball(1.0, [0.0, 6.4, 106.0], methods="mdr fem")
    assert result.verdict == "agree"
    assert np.isnan(result.dataset.rms_slope).all()
    assert np.isnan(result.dataset.rms_slope_error).all()
    result.save(tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    (row,) = (row for row in summary["left_out_of_promise"] if row["quantity"] == "rms_slope")
    assert row["times"] == [0.0, 6.4, 106.0]
    assert "no finite value" in row["reason"]
    (left_out,) = (row for row in result.left_out_of_promise if row.quantity == "rms_slope")
    assert left_out.reason == row["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("average", ["line", "area"])
@pytest.mark.parametrize("excess", [1e-7, *nightly(1e-3, 1.0)])
def test_unworn_balls_have_the_slope_in_closed_form(excess, average):
    """At later times only the part in contact has worn; its slope is that of small angles."""
    result = ball(1 + excess, [0.0, 6.4], average)
    slope, error = (result.dataset[name].values[0] for name in ("rms_slope", "rms_slope_error"))
    exact = np.sqrt(mean_square_of_ball(1 + excess, average))
    assert abs(slope[0] / exact - 1) <= error[0]
    assert abs(slope[1] - exact) <= 0.2**2 * exact
    assert result.verdict != "disagree"
