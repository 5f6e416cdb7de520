"""Whether the displacements on the contact see every pressure: the stability of a pair of spaces.

A pressure p is seen by the displacements v on the contact as ``sup_v (int v p dA)^2 / int v^2 dA``.
Its least ratio to ``int p^2 dA`` over all pressures is the square of an inf-sup constant on the
contact alone. It is of order one for stable pairs, falls as the square of the element size for
pairs with checkerboards, and is zero if a pressure displaces nothing at all. The compliance is then
singular, and what is computed with it is wrong without any sign of it.

The ratio takes no solution of the half-space: functions on the contact overlap with their
neighbours alone, so that it takes some milliseconds, a twentieth to a hundredth of what condensing
takes (tests/physics/test_operators.py). How far the energy of a pressure is from the exact one is
another question, which `ringwear study elements` answers.
"""

import numpy as np
from scipy.sparse import bmat, csr_matrix
from scipy.sparse.linalg import splu

from ..meshes.errors import SolverError
from ..meshes.radial import Array

SINGULAR = 1e-10
"""Ratio below which a pressure counts as unseen.

Roundoff leaves less than 1e-13 of zero; checkerboards of 1e5 facets keep more than 1e-10.
"""
ITERATIONS = 8
"""Of the inverse iteration; stable ratios are found to 30 per cent, small ones to all digits."""


def least_ratio(displacements: csr_matrix, pressures: csr_matrix, areas: Array) -> float:
    """Return how well the least visible pressure is seen by the displacements on the contact.

    Parameters
    ----------
    displacements : (q, m) values of the displacement functions at q points of the contact
    pressures : (q, n) values of the pressure functions there
    areas : (q,) weights of the points, which integrate products of the functions exactly

    Returns
    -------
    ratio : between 0 and 1, by inverse iteration and therefore no less than the exact one; 0 if the
        factorisation breaks down, or if there are more pressures than displacements
    """
    if pressures.shape[1] > displacements.shape[1]:
        return 0.0
    # functions of norm one: beside ring edges elements are smaller by ten orders of magnitude
    moved, pressed = (_normalised(each, areas) for each in (displacements, pressures))
    coupling, mass = moved.T @ pressed, pressed.T @ pressed
    count, size = coupling.shape
    blocks = [[moved.T @ moved, coupling], [coupling.T, None]]
    try:
        saddle_point = splu(bmat(blocks, format="csc"))
    except RuntimeError:  # SuperLU says that it is exactly singular
        return 0.0
    pressure, ratio = np.random.default_rng(0).normal(size=size), 0.0
    for _ in range(ITERATIONS):
        load = mass @ pressure
        unseen = -saddle_point.solve(np.pad(load, (count, 0)))[count:]
        seen = float(load @ unseen)
        if not (np.isfinite(seen) and seen > 0):
            return 0.0
        ratio = float(pressure @ load) / seen
        pressure = unseen / np.sqrt(unseen @ (mass @ unseen))
    return ratio


def _normalised(functions: csr_matrix, areas: Array) -> csr_matrix:
    """Return functions (q, n) times the roots of the areas, the sum of squares of each one."""
    columns = functions.indices
    values = functions.data * np.sqrt(np.repeat(areas, np.diff(functions.indptr)))
    norms = np.sqrt(np.bincount(columns, values**2, minlength=functions.shape[1]))
    return csr_matrix((values / norms[columns], columns, functions.indptr), functions.shape)


def refuse_singular(ratio: float, pressures: int, displacements: int) -> None:
    """Raise if a pressure displaces nothing.

    Parameters
    ----------
    ratio : of `least_ratio`
    pressures, displacements : how many functions there are on the contact

    Raises
    ------
    SolverError
        which names the remedy
    """
    if ratio < SINGULAR:
        raise SolverError(
            f"the pair of spaces is singular: some of the {pressures} contact pressures displace "
            f"nothing, because no one of the {displacements} displacements of the contact sees "
            "them; give pressures of a degree below that of the displacements, or continuous ones, "
            "or at least two facets to each ring (ringwear study elements compares pairs)"
        )
