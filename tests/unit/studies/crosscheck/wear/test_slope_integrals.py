"""Integrals of the slope of an unworn face, whose square may be infinite at a point."""

import numpy as np
import pytest

from ringwear import InitialProfile
from ringwear.studies.crosscheck.problem.face import radial_weight
from ringwear.studies.crosscheck.wear.slope_integrals import slope_integrals

BREAKPOINTS = np.concatenate([np.linspace(0, 0.99, 34), [0.995, 0.998, 0.999, 1.0]])


@pytest.mark.parametrize("exponent", [0.3, 0.5, 0.51, 0.6, 0.9, 1.0, 1.5, 4.0])
@pytest.mark.parametrize("average", ["line", "area"])
def test_integrals_of_powers(exponent, average):
    """The mean of ``(n r^(n-1))^2`` is infinite over the radius if n is at most 1/2."""
    profile = InitialProfile(np.array([0.0, 1.0]), np.zeros(1), (lambda radii: radii**exponent,))
    integrals = slope_integrals(
        profile, BREAKPOINTS, lambda radii: radial_weight(radii, average, 0.0)
    )
    exact = exponent
    if average == "line":
        exact = exponent**2 / (2 * exponent - 1) if exponent > 0.5 else np.inf
        assert integrals.slope.sum() == pytest.approx(1.0, rel=1e-5)
    assert integrals.square.sum() == pytest.approx(exact, rel=1e-7)
    assert integrals.weight.sum() == pytest.approx(1.0, rel=1e-14)


def test_integrals_do_not_count_steps_and_are_broken_at_kinks():
    """A truncated cone on a recessed ring: slope 0.3 beyond the kink, zero elsewhere."""
    profile = InitialProfile(
        np.array([0.0, 0.31, 1.0]),
        np.array([0.0, 7.0]),
        (lambda radii: 0.3 * np.maximum(radii - 0.777, 0.0),),
        kinks=(0.777,),
    )
    integrals = slope_integrals(
        profile, BREAKPOINTS, lambda radii: radial_weight(radii, "line", 0.0)
    )
    assert integrals.square.sum() == pytest.approx(0.09 * 0.223, rel=1e-9)
