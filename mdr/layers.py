"""What layers add to the ring kernel and to closed forms, by Hankel's transform.

A pressure p has the transform ``P(s) = int_0^1 p(r) J_0(s r) r dr``. Layers change the displacement
that it causes by ``2 int (Phi(s) - 1) P(s) J_0(s r) ds``, which is smooth: Phi - 1 decays as
``exp(-2 h s)`` with the thickness h of the first layer. Non-dimensional: punch radius 1, plane
strain modulus of the first layer 1.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import j0, j1

from ..meshes.ground.ground import Ground, relative_compliance, wave_numbers
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, unit_gauss

# greatest width over the first layer of an element that transforms are integrated over
WIDEST_PANEL = 2.0
# Gauss points in such an element beyond the degree of the pressure
MORE_POINTS = 24
# values of Bessel functions that are held at once
AT_ONCE = 2**21


def spectrum(ground: Ground) -> tuple[Array, Array]:
    """Return wave numbers (k,), and there ``Phi - 1`` times the weights of a quadrature."""
    s, weights = wave_numbers(ground, reach=2.0)
    return s, (relative_compliance(ground, s) - 1) * weights


def added_by_layers(space: PressureSpace, ground: Ground) -> Array:
    """Return what layers add to the compliance (size, size): ``4 pi int (Phi - 1) P P^T ds``."""
    s, weights = spectrum(ground)
    transforms = transformed(space, s, WIDEST_PANEL * ground.first)
    return np.asarray(4 * np.pi * (transforms * weights) @ transforms.T)


def transformed(space: PressureSpace, s: Array, widest: float) -> Array:
    """Return the transforms (size, k) of the pressures of a space at wave numbers s (k,).

    Parameters
    ----------
    widest : greatest width of the panels that are integrated over
    """
    fine = space.no_wider(widest)
    node, weight = unit_gauss(space.top + MORE_POINTS)
    radii = (fine.breakpoints[:-1, None] + fine.widths[:, None] * node).ravel()
    lengths = (fine.widths[:, None] * weight).ravel()
    on_fine = fine.on_elements(2 * node - 1)
    values = on_fine if fine is space else on_fine @ fine.embedding(space)
    out = np.empty((space.size, len(s)))
    for part in np.array_split(np.arange(len(s)), 1 + len(s) * len(radii) // AT_ONCE):
        bessel = j0(np.outer(radii, s[part])) * (radii * lengths)[:, None]
        out[:, part] = values.T @ bessel
    return out


def ring_spectrum(ring_edges: Array, steps: Array, ground: Ground) -> tuple[Array, Array]:
    """Return wave numbers (k,), and what discs of constant pressure add there, (k, ...).

    Parameters
    ----------
    steps : (N, ...) pressures on the discs that end at the ring edges but the centre
    """
    s, weights = spectrum(ground)
    edges = ring_edges[1:]
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
    parts = np.array_split(radii, 1 + len(s) * len(radii) // AT_ONCE)
    return np.concatenate([bessel(np.outer(part, s)) @ loads for part in parts])
