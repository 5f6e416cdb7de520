"""The von Mises stress of simple states."""

import numpy as np

from ringwear.fem.stresses import von_mises


def test_von_mises_of_simple_states():
    pull, pressure, shear = [0.0, 2.0, 0.0, 0.0], [3.0, 3.0, 0.0, 3.0], [0.0, 0.0, 1.0, 0.0]
    np.testing.assert_allclose(von_mises(np.array([pull, pressure, shear])), [2, 0, np.sqrt(3)])
