"""The energy of line densities on layered ground, and the flat punch that follows from it.

With the line density q of the method of dimensionality reduction, ``int u p dA = (2/E1*) (|q|^2 +
<q, K q>)`` on 0 < x < 1. The cosine transforms of ``b_j(x) = sqrt(4j + 1) P_2j(x)`` are spherical
Bessel functions, so that

    <b_i, K b_j> = (2/pi) int (Phi(s) - 1) B_i(s) B_j(s) ds,   B_j(s) = int_0^1 b_j(x) cos(s x) dx.

Beyond the wave numbers at which Phi - 1 is roundoff, K is zero: I + K is a small symmetric positive
definite matrix. A flat punch has ``(I + K) q = d0 E1*``, one equation for each b_j.
"""

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import legvander

from ..meshes.radial import Array, unit_gauss
from .ground import Ground
from .kernel import relative_compliance, wave_numbers

# what the series of the flat punch leaves out, over its largest coefficient: beyond, there is noise
# of moduli that differ much
NEGLIGIBLE = 1e-9


def even_legendre(x: Array, count: int) -> Array:
    """Return the Legendre polynomials (n, count) of degrees 0, 2, 4, ... at x (n,)."""
    return np.asarray(legvander(x, 2 * count - 2)[:, ::2])


@lru_cache(maxsize=8)
def line_energy(ground: Ground) -> Array:
    """Return I + K (J, J) on ``sqrt(4j + 1) P_2j(x)``, j < J: beyond, it is the identity."""
    s, weights = wave_numbers(ground, reach=2.0)
    # spherical Bessel functions of an order beyond the argument are next to nothing
    count = int(s[-1] / 2 + 4 * s[-1] ** (1 / 3)) + 12
    node, weight = unit_gauss(2 * count + 20)
    basis = even_legendre(node, count) * np.sqrt(4 * np.arange(count) + 1)
    transforms = (basis * weight[:, None]).T @ np.cos(np.outer(node, s))
    added = (2 / np.pi) * (relative_compliance(ground, s) - 1) * weights
    return np.asarray(np.eye(count) + (transforms * added) @ transforms.T)


@lru_cache(maxsize=8)
def line_energy_modes(ground: Ground) -> tuple[Array, Array]:
    """Return the eigenvalues (J,) of I + K and its eigenvectors (J, J) on the same functions."""
    values, vectors = np.linalg.eigh(line_energy(ground))
    return values, vectors


@lru_cache(maxsize=8)
def flat_series(ground: Ground) -> tuple[float, ...]:
    """Return the coefficients (J,) of ``P_2j(t) / t`` in the pressure of a flat punch.

    The first is 1, which alone carries force; ``t = sqrt(1 - r^2)``.

    Notes
    -----
    ``P_2j(t) / t`` has the line density ``pi (-1)^j (2j - 1)!! / (2j)!! P_2j(x)``.
    """
    energy = line_energy(ground)
    number = np.arange(len(energy))
    density = np.linalg.solve(energy, np.eye(len(energy))[0]) * np.sqrt(4 * number + 1)
    ratios = np.cumprod(np.append(1.0, (1 - 2 * number[1:]) / (2 * number[1:])))
    enough = np.flatnonzero(np.abs(density) > NEGLIGIBLE * np.abs(density).max())[-1] + 1
    return tuple((density / ratios / density[0])[:enough].tolist())


def relative_stiffness(ground: Ground) -> float:
    """Return ``F / (2 a E1* d0)`` of a flat punch, ``[(I + K)^-1]_00``."""
    energy = line_energy(ground)
    return float(np.linalg.solve(energy, np.eye(len(energy))[0])[0])
