"""Degrees of the elements along the radius."""

from dataclasses import replace

import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck.sizes.degrees import pressure_degree
from ringwear.studies.crosscheck.sizes.radial import radial_sizes

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
