"""Stability of a pair of spaces: whether contact displacements can detect every pressure.

The displacements v on the contact respond to a pressure p by ``sup_v (int v p dA)^2 / int v^2 dA``.
The smallest ratio of this number to ``int p^2 dA`` over all pressures is the square of an inf-sup
constant on the contact alone. It is of order 1 for stable pairs, falls as the square of the element
size for pairs with checkerboard pressures, and is zero if a pressure displaces nothing at all. The
compliance is then singular, and results computed with it are wrong without any warning.

The ratio needs no solution of the half-space. Functions on the contact overlap only with their
neighbours, so that it takes some milliseconds, a twentieth to a hundredth of the time of the
condensation (tests/physics/test_operators.py). It does not show how far the energy of a pressure is
from the exact one; `ringwear study refinement --mesh` does.
"""

import numpy as np
from scipy.sparse import bmat, csr_matrix
from scipy.sparse.linalg import splu

from ..meshes.errors import SolverError
from ..meshes.radial import Array

SINGULAR = 1e-10
"""Ratio below which a pressure counts as displacing nothing.

A ratio that should be zero is below 1e-13 because of roundoff; that of checkerboard pressures on
1e5 facets is above 1e-10.
"""
ITERATIONS = 8
"""Number of inverse iterations.

It gives the ratios of stable pairs to 30 per cent, and small ratios to all digits.
"""


def least_ratio(displacements: csr_matrix, pressures: csr_matrix, areas: Array) -> float:
    """Return the smallest stability ratio of a pressure with the displacements on the contact.

    Parameters
    ----------
    displacements : (q, m) values of the displacement functions at q points of the contact
    pressures : (q, n) values of the pressure functions there
    areas : (q,) weights of the points, which integrate products of the functions exactly

    Returns
    -------
    ratio : between 0 and 1. It is computed by inverse iteration and therefore not smaller than the
        exact one. It is 0 if the factorisation breaks down, or if there are more pressures than
        displacements
    """
    if pressures.shape[1] > displacements.shape[1]:
        return 0.0
    # functions are scaled to norm 1, because elements beside ring edges are smaller by ten orders
    # of magnitude
    displacement_basis, pressure_basis = (
        _normalised(functions, areas) for functions in (displacements, pressures)
    )
    coupling, mass = displacement_basis.T @ pressure_basis, pressure_basis.T @ pressure_basis
    count, size = coupling.shape
    blocks = [[displacement_basis.T @ displacement_basis, coupling], [coupling.T, None]]
    try:
        saddle_point = splu(bmat(blocks, format="csc"))
    except RuntimeError:  # SuperLU reports an exactly singular matrix
        return 0.0
    pressure, ratio = np.random.default_rng(0).normal(size=size), 0.0
    for _ in range(ITERATIONS):
        load = mass @ pressure
        response = -saddle_point.solve(np.pad(load, (count, 0)))[count:]
        response_energy = float(load @ response)
        if not (np.isfinite(response_energy) and response_energy > 0):
            return 0.0
        ratio = float(pressure @ load) / response_energy
        pressure = response / np.sqrt(response @ (mass @ response))
    return ratio


def _normalised(functions: csr_matrix, areas: Array) -> csr_matrix:
    """Return functions (q, n) times the square roots of the areas, scaled to norm 1."""
    columns = functions.indices
    values = functions.data * np.sqrt(np.repeat(areas, np.diff(functions.indptr)))
    norms = np.sqrt(np.bincount(columns, values**2, minlength=functions.shape[1]))
    return csr_matrix((values / norms[columns], columns, functions.indptr), functions.shape)


def refuse_singular(ratio: float, pressures: int, displacements: int) -> None:
    """Raise an error if a pressure displaces nothing.

    Parameters
    ----------
    ratio : result of `least_ratio`
    pressures, displacements : number of pressure and displacement functions on the contact

    Raises
    ------
    SolverError
        if the ratio is below `SINGULAR`; the message names the remedy
    """
    if ratio < SINGULAR:
        raise SolverError(
            f"the pair of spaces is singular: some of the {pressures} contact pressures displace "
            f"nothing, because they do no work on any of the {displacements} displacements of the "
            "contact; use pressures of a degree below that of the displacements, or continuous "
            "pressures, or at least two facets on each ring"
        )
