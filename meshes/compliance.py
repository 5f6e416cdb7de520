"""The one object that every method hands up: a compliance on the pressure space.

Non-dimensional: punch radius 1, plane strain modulus 1. The compliance knows nothing of wear: it
depends on where the ring edges are, not on what the rings are made of, so that one condensation
serves every set of wear coefficients.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .errors import SolverError
from .pressure_space import PressureSpace
from .radial import Array


@dataclass(frozen=True, eq=False)
class Compliance:
    """Turn pressures into displacements: all that contact and wear need of a half-space.

    It is the matrix ``A_ij = int u[phi_i] phi_j dA``, where u[phi_i] is the displacement under the
    basis function phi_i of a `PressureSpace`. `matrix` returns A, and ``p @ A @ p`` is twice the
    elastic energy under the pressure p: 16/3 for the pressure one on the whole disc.

    >>> from ringwear.mdr import energy
    >>> edges = np.array([0.0, 1.0])
    >>> compliance = energy.compliance(PressureSpace(edges, np.array([1]), edges))
    >>> one = compliance.space.uniform
    >>> round(float(one @ compliance.matrix @ one), 9)
    5.333333333

    A is symmetric and positive definite. Its factor H, ``A = H^T H``, is kept in its place: the
    singular values of H have half the dynamic range of the eigenvalues of A.

    Parameters
    ----------
    space : pressure space, `size` functions
    factor : (m, size) the factor `H`, m >= size; `u` in units of (pressure x radius / plane strain
        modulus)
    flat_series : coefficients of ``P_2j(t) / t``, ``t = sqrt(1 - r^2)``, in the pressure of a full
        flat punch, the first of them 1: there are more of them on layered ground
    """

    space: PressureSpace
    factor: Array
    flat_series: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        """Check that the factor is finite.

        Raises
        ------
        SolverError
            if it is not, because the half-space system was singular
        """
        if not np.isfinite(self.factor).all():
            raise SolverError(
                "the compliance holds values that are not finite: the half-space system was "
                "singular"
            )

    @cached_property
    def matrix(self) -> Array:
        """(size, size) the compliance `A` itself."""
        out = np.zeros((self.space.size,) * 2)
        # rows and columns both run along the radius, and every method's factor is zero on one side:
        # a third of the work
        for rows in np.split(self.factor, range(512, len(self.factor), 512)):
            used = np.flatnonzero(rows.any(axis=0))
            if len(used):
                span = slice(used[0], used[-1] + 1)
                out[span, span] += rows[:, span].T @ rows[:, span]
        return out

    def restricted(self, space: PressureSpace) -> "Compliance":
        """Return the compliance of the same half-space on a space within its own."""
        factor = (self.space.embedding(space).T @ self.factor.T).T
        return RestrictedCompliance(space, factor, self.flat_series, whole=self)


@dataclass(frozen=True, eq=False)
class RestrictedCompliance(Compliance):
    """A compliance on a space within that of another, whose matrix it takes.

    Parameters
    ----------
    space, factor, flat_series : as of any compliance
    whole : the other
    """

    whole: Compliance = field(kw_only=True)

    @cached_property
    def matrix(self) -> Array:
        """(size, size) the compliance `A` itself, without a product of factors."""
        embedding = self.whole.space.embedding(self.space)
        return np.asarray(embedding.T @ (embedding.T @ self.whole.matrix).T)
