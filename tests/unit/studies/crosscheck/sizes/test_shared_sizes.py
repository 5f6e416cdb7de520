"""Discretisations that several scenes share are fine enough for each of them."""

from itertools import product

import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck.sizes.shared import covering, groups


def test_scenes_with_different_wear_share_one_discretisation():
    """It is fine enough for the sharpest pressures of the group.

    Scenes with much smoother pressures have their own discretisation.
    """
    five = Scene.load("five_rings").changed(accuracy__rtol=1e-3, wear__times=[0.0, 0.01, 0.3])
    problems = [
        five.changed(punch__wear_coefficients=[1.0, ratio]).problem
        for ratio in (1e-6, 0.1, 2.0, 5.0, 1.0)
    ]
    # equal wear leaves no ring edges
    assert sorted(map(sorted, groups(problems))) == [[0], [1, 2, 3], [4]]
    shared = covering(problems[1:4])
    halves, edges = shared.merged.widths / 2, np.arange(5)
    for problem, distance in product(problems[1:4], np.geomspace(1e-10, 0.1, 40)):
        # at least as sharp at every distance from every edge
        distances = np.full(5, distance)
        sharpest = shared.edge_amplitude(distances, halves, edges)
        assert (sharpest >= problem.edge_amplitude(distances, halves, edges)).all()
