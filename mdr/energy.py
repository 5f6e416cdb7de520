"""The compliance by the MDR energy, ``int u p dA = (2/E*) int_0^a q^2 dx``: a Gram matrix.

On layers the energy of a line density q is ``(2/E1*) <q, (I + K) q>`` (`meshes.ground`). K is zero
except on some Legendre polynomials. The square root of I + K therefore changes the factor on these
polynomials only, and no matrix of the size of the pressure space is factorised.
"""

import numpy as np

from ..meshes.compliance import Compliance
from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.ground.line_energy import even_legendre, line_energy_modes
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array
from .layers import WIDEST_PANEL
from .transforms import EXTRA_POINTS, line_density, panel_quadrature, panels_from_axis


def compliance(
    space: PressureSpace, ground: Ground = HALF_SPACE, extra_points: int = EXTRA_POINTS
) -> Compliance:
    """Return the compliance on a pressure space, with the weighted line density as its factor.

    Parameters
    ----------
    space : pressure space
    ground : layers
    extra_points : points of the quadrature on each panel (`panel_quadrature`)
    """
    panels = panels_from_axis(space).no_wider(WIDEST_PANEL * ground.first_thickness)
    positions, weights, low_parts = panel_quadrature(panels, extra_points)
    # in place: for hundreds of rings, a copy takes as long as the integrals
    factor = line_density(space, positions, low_parts)
    factor *= np.sqrt(2 * weights)[:, None]
    if ground.layered:
        factor += _added(factor, positions, weights, ground)
    return Compliance(space, factor, ground)


def _added(factor: Array, positions: Array, weights: Array, ground: Ground) -> Array:
    """Return ``sqrt(I + K) - I`` times the factor of a homogeneous half-space."""
    values, vectors = line_energy_modes(ground)
    scale = np.sqrt(4 * np.arange(len(values)) + 1)
    polynomials = even_legendre(positions, len(values)) @ (scale[:, None] * vectors)
    basis = np.sqrt(weights)[:, None] * polynomials
    return (basis * (np.sqrt(values) - 1)) @ (basis.T @ factor)
