"""The compliance on a pressure space: the common result of all discretisations of the half-space.

Non-dimensional: punch radius 1, plane strain modulus 1. The compliance does not depend on wear. It
depends on the radii of the ring edges, but not on the materials of the rings, so that one
condensation of the half-space can be used for every set of wear coefficients.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .errors import SolverError
from .ground.ground import HALF_SPACE, Ground
from .pressure_space import PressureSpace
from .radial import Array

ROWS_AT_ONCE = 1000
"""Number of rows of a factor that are multiplied with each other at a time."""


@dataclass(frozen=True, eq=False)
class Compliance:
    """Turn pressures into displacements: all that contact and wear need from a half-space.

    It is the matrix ``A_ij = int u[phi_i] phi_j dA``, where u[phi_i] is the displacement under the
    basis function phi_i of a `PressureSpace`. `matrix` returns A, and ``p @ A @ p`` is twice the
    elastic energy under the pressure p: 16/3 for the uniform pressure 1 on the whole disc.

    >>> from ringwear.mdr import energy
    >>> edges = np.array([0.0, 1.0])
    >>> compliance = energy.compliance(PressureSpace(edges, np.array([1]), edges))
    >>> one = compliance.space.uniform
    >>> round(float(one @ compliance.matrix @ one), 9)
    5.333333333

    A is symmetric and positive definite. The object stores its factor H, with ``A = H^T H``,
    instead of A, because the singular values of H have half the dynamic range (in decades) of the
    eigenvalues of A.

    Parameters
    ----------
    space : pressure space, `size` functions
    factor : (m, size) the factor `H`, m >= size; the displacement u is in units of (pressure x
        radius / plane strain modulus)
    ground : layers under the punch, which decide the pressure of a flat punch at the start
    """

    space: PressureSpace
    factor: Array
    ground: Ground = HALF_SPACE

    def __post_init__(self) -> None:
        """Check that the factor is finite.

        Raises
        ------
        SolverError
            if the factor has an infinite or undefined entry, because the half-space system was
            singular
        """
        if not np.isfinite(self.factor).all():
            raise SolverError(
                "the compliance has entries that are not finite: the half-space system was singular"
            )

    @cached_property
    def matrix(self) -> Array:
        """The compliance `A` (size, size) itself.

        A row of most factors belongs to a radius, and is zero for pressures on one side of it.
        Products of blocks of rows, without these pressures, take a third of the operations.
        """
        out = np.zeros((self.space.size,) * 2)
        for rows in np.array_split(self.factor, 1 + len(self.factor) // ROWS_AT_ONCE):
            used = np.flatnonzero(rows.any(axis=0))
            if len(used):
                span = slice(used[0], used[-1] + 1)
                out[span, span] += rows[:, span].T @ rows[:, span]
        return out

    def restricted(self, space: PressureSpace) -> "Compliance":
        """Return the compliance of the same half-space on a subspace of its pressure space."""
        return Compliance(space, self.factor @ self.space.embedding(space), self.ground)
