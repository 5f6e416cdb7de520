"""A flat punch on one layer bonded to a rigid base, by formulas that ringwear does not use.

The kernel is that of `layered_disc.py`. The start follows from the Fredholm equation of
Lebedev and Ufliand (J. Appl. Math. Mech. 22, 1958, 442) by Nystroem's method; the relaxation times
from Galerkin's method on Legendre polynomials of ``1 - 2 r^2``, whose Hankel transforms are Bessel
functions. Lengths are in punch radii, moduli in units of the layer's plane strain modulus.
"""

import numpy as np
from layered_disc import Layer, gauss, surface_displacements, wave_numbers
from scipy.linalg import eigh
from scipy.special import jv


def kernel(x, poisson_ratio):
    """Return the compliance of a bonded layer to waves, relative to a half-space.

    Parameters
    ----------
    x : wave number times thickness, positive
    poisson_ratio : up to and including 1/2
    """
    return surface_displacements([Layer(1.0, 1 - poisson_ratio**2, poisson_ratio)], x) * x / 2


def start(thickness, poisson_ratio, compliance=None):
    """Return the indentation of a flat punch under the force 1.

    `compliance` replaces the kernel of one layer: a function of wave numbers.

    The line density phi of the pressure, whose Hankel transform is ``int phi(t) cos(s t) dt``,
    satisfies ``phi(x) - 1/pi int (K(x - t) + K(x + t)) phi(t) dt = d / pi`` with ``K(t) = int (1 -
    kernel(s h)) cos(s t) ds``; the force is ``2 pi int phi dt``.
    """
    # panels are at most as wide as the layer is thick
    panels = max(int(np.ceil(1 / thickness)), 8)
    node, weight = gauss(np.linspace(0, 1, panels + 1), max(600 // panels, 8))
    s, lengths = wave_numbers(thickness, 2.0)
    cosines = np.cos(np.outer(node, s))
    relative = compliance(s) if compliance else kernel(s * thickness, poisson_ratio)
    added = (cosines * (lengths * (1 - relative))) @ cosines.T
    root = np.sqrt(weight)
    system = np.eye(len(node)) - 2 / np.pi * added * root * root[:, None]
    density = np.linalg.solve(system, root) / np.pi
    return 1 / (2 * np.pi * root @ density)


def relaxation_times(thickness, poisson_ratio, count=8, functions=400):
    """Return the slowest relaxation times (count,) for the wear coefficient 1 on the whole face."""
    s, lengths = wave_numbers(thickness, 2.0)
    order = np.arange(functions)
    weights = lengths * (kernel(s * thickness, poisson_ratio) - 1) / s**2
    bessel = jv(2 * order[:, None] + 1, s)
    total, lag = np.add.outer(order, order), np.subtract.outer(order, order)
    # int J_2m+1 J_2n+1 / s^2 ds (Weber and Schafheitlin)
    half_space = np.where(lag % 2, -1, 1) / (
        4 * np.pi * (total + 0.5) * (total + 1.5) * (0.25 - lag**2)
    )
    energies = 4 * np.pi * (half_space + (bessel * weights) @ bessel.T)
    root = np.sqrt((2 * order + 1) / np.pi)
    # the first function carries all of the force, which does not change
    return eigh((energies * root * root[:, None])[1:, 1:], eigvals_only=True)[::-1][:count]
