"""The compliance by the MDR energy, ``int u p dA = (2/E*) int_0^a q^2 dx``: a Gram matrix.

On layers the energy of a line density q is ``(2/E1*) <q, (I + K) q>``
(`meshes.ground.line_energy`), with

    <q, K q> = (2/pi) int (Phi(s) - 1) Q(s)^2 ds,   Q(s) = int_0^1 q(x) cos(s x) dx.

I + K is well conditioned on orthonormal line densities, so that the factor keeps all digits of tiny
elements.
"""

import numpy as np
from scipy.linalg import cholesky, qr

from ..meshes.compliance import Compliance
from ..meshes.ground.ground import HALF_SPACE, Ground, spectrum
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array
from .layers import in_blocks
from .transforms import EXTRA_POINTS, line_density, panel_quadrature, panels_from_axis

# Points of the quadrature over the thickness of the first layer: what layers add is right to 1e-11
# (physics/test_layers.py::test_boundary_elements_and_the_mdr_are_the_same_operator).
POINTS_PER_THICKNESS = 6


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
    panels = panels_from_axis(space)
    points = 2 * panels.degrees + extra_points
    panels = panels.no_wider(ground.first_thickness * points / POINTS_PER_THICKNESS)
    positions, weights, low_parts = panel_quadrature(panels, extra_points)
    # in place: for hundreds of rings, a copy takes as long as the integrals
    factor = line_density(space, positions, low_parts)
    factor *= np.sqrt(2 * weights)[:, None]
    if ground.layered:
        factor = _on_layers(factor, positions, weights, ground)
    return Compliance(space, factor, ground)


def _on_layers(factor: Array, positions: Array, weights: Array, ground: Ground) -> Array:
    """Return the factor (size, size) on layers from that of a homogeneous half-space."""
    densities, triangle = qr(factor, mode="economic", check_finite=False)
    densities *= np.sqrt(weights)[:, None]
    s, added = spectrum(ground)
    energy = np.eye(len(triangle))
    for block in in_blocks(np.arange(len(s)), len(positions)):
        transforms = densities.T @ np.cos(np.outer(positions, s[block]))
        energy += (transforms * (2 / np.pi * added[block])) @ transforms.T
    return np.asarray(cholesky(energy, check_finite=False) @ triangle)
