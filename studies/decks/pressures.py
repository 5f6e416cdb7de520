"""Compute pressures from the forces on the contact nodes."""

from collections.abc import Callable

import numpy as np

from ...meshes import Array
from ..wear_step.contact_line import contact_mass


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
    matrix = contact_mass(radii, 2 if quadratic else 1, lambda points: 1 / wear(points))
    return np.linalg.solve(matrix, forces) / wear(radii)
