"""Compliances compared for every pressure at once."""

from dataclasses import replace

import numpy as np
import pytest
from groups import slow

from ringwear import PressureSpace, RunningIn, Scene, Stages, energy, method
from ringwear.studies.crosscheck.sizes.quads import quad_degree
from ringwear.studies.operators import _shortest_resolved_wave, difference

FIVE = Scene.load("five_rings")


def by_elements(problem):
    return method("fem").discretise(problem, Stages("test")).compliance


def against_mdr(problem, compliance):
    """Compare a compliance with that of the MDR on the same space."""
    first, second = (
        RunningIn(each, problem.merged.wear_coefficients)
        for each in (compliance, energy.compliance(compliance.space))
    )
    return difference(problem, ("fem", "mdr"), first, second)


@pytest.mark.parametrize(
    ("rings", "rtol"),
    [
        *((1, 1e-4), (5, 1e-4), (2, 1e-6)),
        *slow((32, 1e-3)),
    ],
)
def test_finite_elements_agree_with_mdr_for_every_steady_state(rings, rtol):
    problem = FIVE.changed(punch__rings=rings, accuracy__rtol=rtol).problem
    difference = against_mdr(problem, by_elements(problem))
    assert difference.rings <= rtol
    # the multipliers are stable on coarse and fine meshes: the constant falls as 1 / degree
    assert difference.stability >= 2.5 / quad_degree(problem)


@pytest.mark.parametrize("ratio", [0.0, 0.49, 0.5])
def test_poisson_ratio_does_not_matter(ratio):
    problem = FIVE.changed(half_space__poisson_ratio=ratio).problem
    assert against_mdr(problem, by_elements(problem)).rings <= 1e-4


def test_a_wrong_modulus_shows_in_the_operator_difference():
    sound = by_elements(FIVE.problem)
    soft = replace(sound, factor=sound.factor * np.sqrt(1.01))
    assert against_mdr(FIVE.problem, soft).rings >= 9e-3


def test_the_shortest_wave_has_pi_degrees_in_the_worst_element():
    # h/p is 0.1, 0.075 and 0.1
    space = PressureSpace(np.array([0.4, 0.6, 0.9, 1.0]), np.array([2, 4, 1]), np.array([0.4, 1.0]))
    assert _shortest_resolved_wave(space) == pytest.approx(0.1 * np.pi)
