"""The consistent mass matrix of the contact line of a mesh."""

from collections.abc import Callable

import numpy as np

from ...meshes import Array, gauss


def contact_mass(radii: Array, degree: int, factor: Callable[[Array], Array]) -> Array:
    """Return the mass matrix (n, n) ``int c phi_i phi_j 2 pi r dr`` of shape functions phi.

    Parameters
    ----------
    radii : (n,) of the nodes from inside to outside, including those in the middles of sides
    degree : of the shape functions, 1 or 2
    factor : function c from radii to a factor
    """
    points, weights = gauss(4)
    functions = np.stack([(1 - points) / 2, (1 + points) / 2])
    if degree == 2:
        inner, outer = points * (points - 1) / 2, points * (points + 1) / 2
        functions = np.stack([inner, 1 - points**2, outer])
    matrix = np.zeros((len(radii), len(radii)))
    for first in range(0, len(radii) - degree, degree):
        nodes = slice(first, first + degree + 1)
        point_radii = radii[nodes] @ functions
        half = (radii[first + degree] - radii[first]) / 2
        areas = 2 * np.pi * point_radii * half * weights
        matrix[nodes, nodes] += functions * (areas * factor(point_radii)) @ functions.T
    return matrix
