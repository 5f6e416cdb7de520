"""Finite elements condensed to a compliance, and the error of its flat start. Non-dimensional."""

import numpy as np
from skfem import Mesh

from ...fem.half_space import pressure_space
from ..crosscheck import (
    Array,
    AxisymmetricElasticity,
    Compliance,
    Ground,
    HalfSpace,
    flat_punch,
    press_flat,
)

Discretised = tuple[Compliance, int]
"""A compliance, and the number of unknowns from which it is condensed."""
FLAT = np.array([0.0, 1.0])
"""Ring edges of a punch of one ring."""


def condense(
    mesh: Mesh, ring_edges: Array, degree: int, poisson_ratio: float, poles: int
) -> Discretised:
    """Condense the finite-element half-space on a mesh to a compliance.

    Parameters
    ----------
    mesh : mesh of the half-space
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    degree : degree of the displacement
    poisson_ratio : Poisson's ratio of the half-space
    poles : number of poles of its far field
    """
    solid = AxisymmetricElasticity(mesh, degree, Ground.half_space(poisson_ratio))
    orders = tuple(range(0, 2 * poles, 2))
    half_space = HalfSpace(solid, pressure_space(solid, ring_edges), orders)
    return half_space.compliance(), half_space.unknowns


def flat_d0_error(compliance: Compliance) -> float:
    """Return the relative error of the indentation of a flat punch before wear.

    Its pressure is singular at the rim, and at the edge of a hole.
    """
    exact = flat_punch(compliance.space.inner_radius).indentation
    return press_flat(compliance).indentation / exact - 1
