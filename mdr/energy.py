"""The compliance by the MDR energy, ``int u p dA = (2/E*) int_0^a q^2 dx``: a Gram matrix."""

import numpy as np

from ..meshes.compliance import Compliance
from ..meshes.pressure_space import PressureSpace
from .transforms import line_density, panel_quadrature


def compliance(space: PressureSpace) -> Compliance:
    """Return the compliance of the half-space on `space`.

    Its factor is the line density itself, weighted by the quadrature.
    """
    positions, weights, low_parts = panel_quadrature(space)
    density = line_density(space, positions, low_parts)
    return Compliance(space, np.sqrt(2 * weights)[:, None] * density)
