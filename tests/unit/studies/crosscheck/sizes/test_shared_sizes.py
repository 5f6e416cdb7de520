"""Degrees of the elements, and discretisations that are fine enough for several scenes."""

from dataclasses import replace
from itertools import product

import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck.sizes.degrees import pressure_degree
from ringwear.studies.crosscheck.sizes.radial import radial_sizes
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


THREE = Scene.load("five_rings").changed(punch__rings=3, load__normal_force=1.0)


def test_a_cap_on_the_degree_changes_only_higher_degrees():
    """Elements whose wanted degree is below the cap keep it; all others have the cap."""
    problem = replace(THREE.problem, rtol=1e-9)
    sizes = radial_sizes(problem)
    wanted = int(np.ceil(pressure_degree(problem, sizes.grading)))
    whole, capped = (
        replace(sizes, degree=highest).space(problem).degrees for highest in (wanted, 18)
    )
    assert whole.max() == wanted > 18
    assert (capped == np.minimum(whole, 18)).all()
