"""Pressures by the forces on the nodes of the contact."""

from collections.abc import Callable

import numpy as np

from ...meshes.radial import Array, gauss


def pressures_of(
    radii: Array, forces: Array, quadratic: bool, wear: Callable[[Array], Array]
) -> Array:
    """Return pressures (k,) at nodes, by the consistent mass matrix of the contact line.

    A nodal force is ``int N p 2 pi r dr``. Once there is wear, ``wear * p`` is continuous across
    ring edges, because the face is, and it has the functions of the elements.

    Parameters
    ----------
    radii : (k,) of the nodes from inside to outside, those in the middles of sides included
    forces : (k,) on the nodes, on the whole circumference
    quadratic : whether elements have nodes in the middles of their sides
    wear : wear coefficients by radii; at a ring edge, where they jump, pressures are NaN
    """
    step = 2 if quadratic else 1
    points, weights = gauss(4)
    functions = np.stack([(1 - points) / 2, (1 + points) / 2])
    if quadratic:
        inner, outer = points * (points - 1) / 2, points * (points + 1) / 2
        functions = np.stack([inner, 1 - points**2, outer])
    matrix = np.zeros((len(radii), len(radii)))
    for first in range(0, len(radii) - 1, step):
        nodes = np.arange(first, first + step + 1)
        places = radii[nodes] @ functions
        half = (radii[nodes[-1]] - radii[first]) / 2
        areas = 2 * np.pi * places * weights * half
        matrix[np.ix_(nodes, nodes)] += (functions * (areas / wear(places))) @ functions.T
    return np.asarray(np.linalg.solve(matrix, forces) / wear(radii))
