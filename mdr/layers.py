"""The contribution of layers to the ring kernel and to closed forms, by Hankel's transform.

A pressure p has the transform ``P(s) = int_0^1 p(r) J_0(s r) r dr``. Layers change the displacement
under it by ``2 int (Phi(s) - 1) P(s) J_0(s r) ds``, which is smooth: Phi - 1 decays as
``exp(-2 h s)`` with the thickness h of the first layer. Non-dimensional: punch radius 1, plane
strain modulus of the first layer 1.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0, j1

from ..meshes.ground.ground import Ground, spectrum
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, unit_gauss

# greatest width of a quadrature panel, relative to the thickness of the first layer
# (tests/physics/test_layers.py)
WIDEST_PANEL = 2.0
# number of Gauss points on a panel in addition to the degree of the pressure
EXTRA_POINTS = 24
# number of values of Bessel functions or cosines that are stored at a time
VALUES_PER_BLOCK = 2**21


def added_by_layers(space: PressureSpace, ground: Ground) -> Array:
    """Return the compliance (size, size) that layers add: ``4 pi int (Phi - 1) P P^T ds``."""
    s, weights = spectrum(ground)
    transforms = hankel_transforms(space, s, WIDEST_PANEL * ground.first_thickness)
    return 4 * np.pi * (transforms * weights) @ transforms.T


def hankel_transforms(space: PressureSpace, s: Array, widest: float) -> Array:
    """Return the Hankel transforms (size, k) of the pressures of a space at wave numbers s (k,).

    `widest` is the greatest width of the quadrature panels.
    """
    panels = space.no_wider(widest)
    node, weight = unit_gauss(space.top + EXTRA_POINTS)
    radii = (panels.breakpoints[:-1, None] + panels.widths[:, None] * node).ravel()
    lengths = (panels.widths[:, None] * weight).ravel()
    panel_values = panels.on_elements(2 * node - 1)
    values = panel_values if panels is space else panel_values @ panels.embedding(space)
    out = np.empty((space.size, len(s)))
    for block in in_blocks(np.arange(len(s)), len(radii)):
        bessel = j0(np.outer(radii, s[block])) * (radii * lengths)[:, None]
        out[:, block] = values.T @ bessel
    return out


def ring_spectrum(ring_edges: Array, steps: Array, ground: Ground) -> tuple[Array, Array]:
    """Return wave numbers (k,), and the contribution (k, ...) of discs of constant pressure there.

    A half-space adds nothing and has no wave numbers.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges
    steps : (M, ...) pressures on the discs that end at the ring edges, except the centre
    ground : the layers
    """
    s, weights = spectrum(ground)
    edges = ring_edges[ring_edges > 0]
    loads = (edges * j1(np.outer(s, edges))) @ steps
    return s, np.asarray(2 * ((weights / s) * loads.T).T)


def added_displacement(ring_edges: Array, steps: Array, radii: Array, ground: Ground) -> Array:
    """Return the displacement (R, ...) that layers add at radii (R,)."""
    s, loads = ring_spectrum(ring_edges, steps, ground)
    return _summed(j0, s, loads, radii)


def added_slope(ring_edges: Array, steps: Array, radii: Array, ground: Ground) -> Array:
    """Return the slope of the displacement (R, ...) that layers add at radii (R,)."""
    s, loads = ring_spectrum(ring_edges, steps, ground)
    return -_summed(j1, s, (s * loads.T).T, radii)


def _summed(bessel: Callable[[Array], Array], s: Array, loads: Array, radii: Array) -> Array:
    """Return the sums over wave numbers at radii, in blocks of radii."""
    parts = [bessel(np.outer(block, s)) @ loads for block in in_blocks(radii, len(s))]
    return np.concatenate(parts)


def in_blocks(values: NDArray[Any], others: int) -> list[NDArray[Any]]:
    """Return values (n,) in blocks whose tables with a number of others fit into memory."""
    return np.array_split(values, 1 + len(values) * others // VALUES_PER_BLOCK)
