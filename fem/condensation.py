"""Eliminate the unknowns inside the half-space by one sparse Cholesky factorisation.

The retained unknowns are ordered last. The trailing block `L` of the Cholesky factor then satisfies
``L L^T = `` Schur complement of the unknowns inside. This takes one factorisation and no solve per
retained unknown. CHOLMOD (from `kvxopt`, an optional extra) is used if it is installed and can be
loaded, otherwise SuperLU (from scipy).
"""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, tril
from scipy.sparse.linalg import SuperLU, splu

from ..meshes.errors import SolverError
from ..meshes.radial import Array, Indices

if TYPE_CHECKING:
    from kvxopt import spmatrix

SYMMETRIC: dict[str, object] = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}


def solver() -> str:
    """Name the sparse factorisation in use, `cholmod` or `superlu`."""
    return "cholmod" if importlib.util.find_spec("kvxopt") and not unloadable() else "superlu"


def unloadable() -> str:
    """Return why CHOLMOD is installed but cannot be used, with the remedy; empty otherwise."""
    if importlib.util.find_spec("kvxopt") is None:
        return ""
    try:
        from kvxopt import amd, cholmod  # noqa: F401
    # a binary that does not suit this Python or numpy fails in many ways
    except Exception as error:
        return (
            "factorised by SuperLU, which takes 1.5 to 2 times the time of CHOLMOD: kvxopt is "
            f"installed but cannot be loaded ({error}); install it again, or uninstall it"
        )
    return ""


def fill_reducing_order(groups: Indices) -> Indices:
    """Return an order (n,) in which to eliminate the vertices of a graph.

    Parameters
    ----------
    groups : (p, m) the p vertices of each of m groups, numbered from 0 to n - 1; the vertices of a
        group are neighbours of each other
    """
    neighbour_pairs = groups[np.array(np.tril_indices(len(groups)))]
    places = neighbour_pairs.max(axis=0).ravel(), neighbour_pairs.min(axis=0).ravel()
    lower = coo_matrix((np.ones(len(places[0])), places), shape=(groups.max() + 1,) * 2)
    if solver() == "cholmod":
        from kvxopt import amd

        return np.array(amd.order(cholmod_matrix(lower))).ravel()
    laplacian = symmetric(lower) * -1.0
    laplacian.setdiag(1 - np.asarray(laplacian.sum(axis=0)).ravel())
    return np.argsort(splu(laplacian, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).perm_c)


def symmetric(lower: coo_matrix) -> csc_matrix:
    """Return the symmetric matrix with a given lower triangle; duplicate entries are summed."""
    summed = lower.tocsc()
    return (summed + tril(summed, -1).T).tocsc()


def cholmod_matrix(lower: coo_matrix) -> "spmatrix":
    """Return a lower triangle in CHOLMOD's matrix format; duplicate entries are summed."""
    import kvxopt

    # convert the arrays one after the other, so that fewer copies exist at a time
    rows, columns = (kvxopt.matrix(indices.astype(np.int64)) for indices in (lower.row, lower.col))
    return kvxopt.spmatrix(kvxopt.matrix(lower.data), rows, columns, lower.shape)


class Factor:
    """The Cholesky factor of a symmetric positive definite matrix.

    Its methods raise a `SolverError` if the matrix is not positive definite.

    Parameters
    ----------
    lower : lower triangle (n, n) of the matrix, whose duplicate entries are summed; the unknowns
        are in the order of elimination
    """

    def __init__(self, lower: coo_matrix) -> None:
        self.lower = lower

    def trailing(self, eliminated: int) -> Array:
        """Return the factor of the Schur complement that remains after an elimination.

        It is lower triangular (k, k), where k is the number of unknowns that remain when the first
        `eliminated` unknowns are eliminated.
        """
        with _factorising():
            if solver() != "cholmod":
                factor, pivots = self._superlu
                # For a symmetric matrix U = D L^T, so that the Cholesky factor is L with its
                # columns scaled by sqrt(D). No matrix product is needed.
                trailing = factor.L[eliminated:, eliminated:].toarray()
                return trailing * np.sqrt(pivots[eliminated:])
            import kvxopt
            from kvxopt import cholmod

            trailing = cholmod.getfactor(self._cholmod())[eliminated:, eliminated:]
            # without a copy, which takes seconds for a large matrix
            return np.asarray(kvxopt.matrix(trailing))

    def solve(self, right: Array) -> Array:
        """Return the solutions (n, k) of the system for right-hand sides (n, k)."""
        with _factorising():
            if solver() != "cholmod":
                return self._superlu[0].solve(right)
            import kvxopt
            from kvxopt import cholmod

            solution = kvxopt.matrix(right)
            cholmod.solve(self._cholmod(), solution)
            return np.array(solution)

    @cached_property
    def _superlu(self) -> tuple[SuperLU, Array]:
        """SuperLU's factor, and its pivots."""
        factor = splu(symmetric(self.lower), permc_spec="NATURAL", **SYMMETRIC)
        pivoted = np.any(np.array([factor.perm_r, factor.perm_c]) != np.arange(len(factor.perm_r)))
        pivots = factor.U.diagonal()
        if pivoted or not (pivots > 0).all():
            raise ArithmeticError("it is not positive definite")
        return factor, pivots

    @cached_property
    def _matrix(self) -> "spmatrix":
        return cholmod_matrix(self.lower)

    def _cholmod(self) -> Any:
        """Return CHOLMOD's factor, which is lost when its numbers are read."""
        import kvxopt
        from kvxopt import cholmod

        saved_options = dict(cholmod.options)
        # the unknowns are already in the order of elimination, which CHOLMOD must not change
        cholmod.options.update({"supernodal": 2, "postorder": False, "nmethods": 1})
        try:
            order = kvxopt.matrix(np.arange(self.lower.shape[0]))
            factor = cholmod.symbolic(self._matrix, p=order)
            cholmod.numeric(self._matrix, factor)
            # CHOLMOD stops without an error at a pivot that is not positive
            if not (np.array(cholmod.diag(factor)) > 0).all():
                raise ArithmeticError("it is not positive definite")
        finally:
            cholmod.options.clear()
            cholmod.options.update(saved_options)
        return factor


@contextmanager
def _factorising() -> Iterator[None]:
    """Raise the errors of the solvers as a `SolverError`."""
    try:
        yield
    except (ArithmeticError, RuntimeError, ValueError, np.linalg.LinAlgError) as error:
        raise SolverError(
            f"the stiffness of the half-space could not be factorised: {error}"
        ) from error
