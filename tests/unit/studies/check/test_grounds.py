"""The layer that a diagnosis tries as a cause agrees with `meshes/ground`."""

import numpy as np
import pytest

from ringwear import Ground, Rings
from ringwear.mdr.flat_punch import flat_punch_of
from ringwear.studies.check.causes import grounds

RATIO = 0.3


@pytest.mark.parametrize("thickness", [0.1, 0.8])
@pytest.mark.parametrize("stiffness", [0.1, 5.0])
def test_the_indentation_on_a_layer_agrees_with_the_kernel(thickness, stiffness):
    ground = Ground.from_youngs_moduli([thickness], [stiffness, 1.0], [RATIO, RATIO])
    # relative to the homogeneous half-space below, whose exact indentation is 1/2
    expected = flat_punch_of(0.0, ground).indentation / stiffness / 0.5
    rings = Rings.constant(np.array([0.0, 1.0]), np.ones(1))
    start = np.zeros(1)
    (on_layer,) = grounds.layered(rings, thickness, stiffness, RATIO).history(start)[2]
    (without,) = grounds.half_space(rings).history(start)[2]
    # the diagnosis uses forty elements of constant pressure
    assert on_layer / without == pytest.approx(expected, rel=1e-2)
