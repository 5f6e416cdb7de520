"""The uniform grid of the paper: its error estimates against a far more accurate solution."""

import pytest

from ringwear import Scene, Stages, differences, method


@pytest.mark.parametrize("springs", [60, 120])
@pytest.mark.parametrize(("rings", "ratio"), [(5, 10.0), (2, 0.1), (3, 30.0), (6, 0.3), (1, 1.0)])
def test_errors_are_below_their_estimates(rings, ratio, springs):
    """At each time, in the norm of each quantity; the reference is by the MDR at rtol 1e-5."""
    scene = Scene.load("five_rings").changed(
        punch__rings=rings,
        punch__wear_coefficients=[1.0, ratio],
        accuracy__rtol=1e-5,
        accuracy__mdr__grid=springs,
        wear={"times": [0.0, 0.001, 0.01, 0.1, 0.5, 2.0], "steady": False},
    )
    problem = scene.problem
    grid, exact = (method(name).solve(problem, Stages(name)) for name in ("mdr-grid", "mdr"))
    for name in ("indentation", "displacement", "profile", "pressure", "rms_slope", "ring_force"):
        true_errors = differences(grid.compared, exact.compared, problem.face)[name]
        assert (true_errors <= grid.compared_error(problem, name)).all(), name
