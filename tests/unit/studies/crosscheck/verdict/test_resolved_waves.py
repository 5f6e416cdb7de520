"""The shortest wave of a pressure that a space resolves."""

import numpy as np
import pytest

from ringwear import PressureSpace
from ringwear.studies.crosscheck.verdict.operators import _shortest_resolved_wave


def test_the_shortest_wave_has_pi_degrees_in_the_worst_element():
    # h/p is 0.1, 0.075 and 0.1
    space = PressureSpace(np.array([0.4, 0.6, 0.9, 1.0]), np.array([2, 4, 1]), np.array([0.4, 1.0]))
    assert _shortest_resolved_wave(space) == pytest.approx(0.1 * np.pi)
