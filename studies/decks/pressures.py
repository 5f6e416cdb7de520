"""Compute pressures from the forces on the contact nodes."""

from collections.abc import Callable

import numpy as np

from ...meshes import Array, gauss


def pressures_of(
    radii: Array, forces: Array, quadratic: bool, wear: Callable[[Array], Array]
) -> Array:
    """Return pressures (k,) at the nodes, from the consistent mass matrix of the contact line.

    The force on a node is ``int N p 2 pi r dr`` with its shape function N. After the start, ``wear
    * p`` is continuous across ring edges, because the face is; it is expanded in the shape
    functions of the elements.

    Parameters
    ----------
    radii : (k,) of the nodes from inside to outside, including those in the middles of sides
    forces : (k,) on the nodes, for the whole circumference
    quadratic : whether elements have nodes in the middles of their sides
    wear : function from radii to wear coefficients; where it is NaN, such as at ring edges where
        the coefficients jump, pressures are NaN
    """
    step = 2 if quadratic else 1
    points, weights = gauss(4)
    shape_functions = np.stack([(1 - points) / 2, (1 + points) / 2])
    if quadratic:
        inner, outer = points * (points - 1) / 2, points * (points + 1) / 2
        shape_functions = np.stack([inner, 1 - points**2, outer])
    matrix = np.zeros((len(radii), len(radii)))
    for first in range(0, len(radii) - 1, step):
        nodes = np.arange(first, first + step + 1)
        point_radii = radii[nodes] @ shape_functions
        half_length = (radii[nodes[-1]] - radii[first]) / 2
        areas = 2 * np.pi * point_radii * weights * half_length
        weighted = shape_functions * (areas / wear(point_radii))
        matrix[np.ix_(nodes, nodes)] += weighted @ shape_functions.T
    return np.asarray(np.linalg.solve(matrix, forces) / wear(radii))
