"""The energy of line densities on layered ground, and the flat punch that follows from it.

With the line density q of the method of dimensionality reduction,
``int u p dA = (2/E1*) (|q|^2 + <q, K q>)`` on 0 < x < 1. The cosine transforms of
``b_j(x) = sqrt(4j + 1) P_2j(x)`` are spherical Bessel functions,
``(-1)^j sqrt(4j + 1) j_2j(s)``, so that

    <b_i, K b_j> = (2/pi) int (Phi(s) - 1) B_i(s) B_j(s) ds,   B_j(s) = int_0^1 b_j(x) cos(s x) dx.

I + K is symmetric and positive definite. A flat punch has ``(I + K) q = d0 E1*``, one equation for
each b_j.
"""

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import legvander

from .ground import Array, Ground, spectrum

# Size, relative to the largest coefficient, below which the last coefficients of the flat punch's
# line density are left out. For moduli that differ much they are noise.
NEGLIGIBLE_COEFFICIENT = 1e-9
# Number of polynomials: the least one, and a part times 1/sqrt(h). With them, stiffnesses and
# coefficients of flat punches are right to 1e-14 for h from 0.01 to 0.5, by twice the numbers.
LEAST_COUNT, EDGE_COUNT = 12, 12.0


def even_legendre(x: Array, count: int) -> Array:
    """Return the Legendre polynomials (n, count) of degrees 0, 2, 4, ... at x (n,)."""
    return legvander(x, 2 * count - 2)[:, ::2]


def spherical_bessel(s: Array, count: int) -> Array:
    """Return the spherical Bessel functions j_n(s) of orders n < count, (count, k), at s (k,) > 0.

    Notes
    -----
    Orders up to s are computed by the recurrence ``j_(n+1) = (2n + 1)/s j_n - j_(n-1)``, which is
    stable there. Higher orders, where the functions decay, are computed from their ratios by a
    continued fraction.
    """
    # the continued fraction starts at an order so high that the ratios do not depend on its start;
    # ratios at s > count are not used
    highest = 2 * count + 60
    ratios = np.zeros((count + 1, len(s)))
    ratio = np.zeros_like(s)
    for order in range(highest, 0, -1):
        with np.errstate(divide="ignore"):
            ratio = 1 / ((2 * order + 1) / s - ratio)
        if order <= count:
            ratios[order] = ratio
    out = np.empty((count, len(s)))
    out[0] = np.sin(s) / s
    for order in range(1, count):
        previous = np.cos(s) / s if order == 1 else out[order - 2]
        recurred = (2 * order - 1) / s * out[order - 1] - previous
        out[order] = np.where(order <= s, recurred, ratios[order] * out[order - 1])
    return out


@lru_cache(maxsize=128)
def line_energy(ground: Ground) -> Array:
    """Return the matrix I + K (J, J) on the first J functions ``sqrt(4j + 1) P_2j(x)``.

    They represent line densities that are smooth but for an edge layer at ``x = 1``, whose width is
    the thickness h of the first layer. Legendre polynomials are as fine as 1/J^2 there, so that J
    is proportional to 1/sqrt(h).
    """
    s, weights = spectrum(ground)
    count = LEAST_COUNT + int(EDGE_COUNT / np.sqrt(ground.first_thickness))
    signs = np.resize([1.0, -1.0], count)[:, None]
    scale = np.sqrt(4 * np.arange(count) + 1)[:, None]
    transforms = signs * scale * spherical_bessel(s, 2 * count)[::2]
    return np.eye(count) + (transforms * (2 / np.pi * weights)) @ transforms.T


@lru_cache(maxsize=128)
def flat_series(ground: Ground) -> tuple[float, ...]:
    """Return the coefficients (J,) of ``P_2j(t) / t`` in the pressure of a flat punch.

    Here ``t = sqrt(1 - r^2)``. The first coefficient is 1; only its term carries force.

    Notes
    -----
    ``P_2j(t) / t`` has the line density ``pi (-1)^j (2j - 1)!! / (2j)!! P_2j(x)``.
    """
    energy = line_energy(ground)
    number = np.arange(len(energy))
    density = np.linalg.solve(energy, np.eye(len(energy))[0]) * np.sqrt(4 * number + 1)
    ratios = np.cumprod(np.append(1.0, (1 - 2 * number[1:]) / (2 * number[1:])))
    count = np.flatnonzero(np.abs(density) > NEGLIGIBLE_COEFFICIENT * np.abs(density).max())[-1] + 1
    return tuple((density / ratios / density[0])[:count].tolist())


def relative_stiffness(ground: Ground) -> float:
    """Return ``F / (2 a E1* d0)`` of a flat punch, ``[(I + K)^-1]_00``."""
    energy = line_energy(ground)
    return float(np.linalg.solve(energy, np.eye(len(energy))[0])[0])


def uniform_energy(ground: Ground) -> float:
    """Return the energy of a uniform line density, over that on a homogeneous half-space.

    It is at least ``2 a E1* d0 / F`` of a flat punch, whose density has the least energy of all
    with its force.
    """
    s, added = spectrum(ground)
    return 1 + float(2 / np.pi * added @ np.sinc(s / np.pi) ** 2)
