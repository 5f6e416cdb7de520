"""Time scales that are predicted before a run: of running-in, and of contact that spreads."""

import numpy as np
import pytest

from ringwear import Scene, Stages, method
from ringwear.studies.crosscheck.result.scope import time_scale
from ringwear.studies.crosscheck.wear.time_scale import (
    slowest_relaxation_time,
    spreading_times,
)


@pytest.mark.parametrize(
    ("rings", "ratio", "width"),
    [(2, 1e-3, 1.0), (3, 50.0, 0.02), (7, 1e5, 5.0), (1, 1.0, 1.0)],
    ids=str,
)
def test_the_slowest_relaxation_time_is_predicted_without_a_run(rings, ratio, width):
    scene = Scene.load("five_rings").changed(
        methods=["mdr"],
        punch__rings=rings,
        punch__width_ratio=width,
        punch__wear_coefficients=[1.0, ratio],
    )
    computed = method("mdr").solve(scene.problem, Stages("mdr")).results["relaxation_time"]
    assert slowest_relaxation_time(scene.problem) == pytest.approx(float(computed[0]), rel=1e-4)


def test_the_spreading_time_of_a_sphere_against_a_rigid_half_space():
    curvature, force, speed, wear_coefficient, radius = 3.0, 0.1, 3.0, 0.5, 2.0
    scene = Scene.of(
        {
            "punch": {
                "radius": radius,
                "wear_coefficient": wear_coefficient,
                "profile": {"kind": "parabola", "curvature_radius": curvature},
            },
            "half_space": {"plane_strain_modulus": 7.0},
            "load": {"normal_force": force, "sliding_speed": speed},
            "wear": {"times": [0.0, 1.0]},
        }
    )
    start, end = spreading_times(scene.problem)
    # a^4 = 4 R k F v t / pi, where a is the radius of the punch
    worn = np.pi * radius**4 / (4 * curvature * wear_coefficient * force * speed)
    assert end * scene.problem.units.time == pytest.approx(worn, rel=1e-4)
    assert start < 1e-3 * end
    # both are printed before the run
    assert any("spreads" in line for line in time_scale(scene))
