"""The coarse probe of a plan, and the predicted memory."""

import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck.result.predictions.plan import coarsen


def test_a_probe_is_small():
    scene = Scene.load("five_rings").changed(
        methods=["mdr", "mdr-grid"],
        punch__rings=300,
        accuracy={"rtol": 1e-8, "mdr": {"degree": 20, "grid": 4000}},
        wear={"times": np.linspace(0, 1, 1000).tolist(), "march": "implicit", "step": 1e-5},
    )
    problem = coarsen(scene).problem
    assert problem.rtol == 1e-2
    assert not problem.mdr.given_by_user
    assert problem.mdr.grid <= 100
    assert len(problem.wear_coefficients) <= 16
    assert problem.times[-1] <= 101 * problem.step
