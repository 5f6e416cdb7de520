"""Eliminate the inside of the half-space: a sparse Cholesky factorisation whose trailing block is what is wanted.

With the kept unknowns ordered last, the trailing block `L` of the factor satisfies ``L L^T = `` Schur complement of
the inside: one factorisation, no solve per kept unknown. CHOLMOD (from `kvxopt`, an optional extra) is used where it
is installed, SuperLU (from scipy) everywhere else.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, tril
from scipy.sparse.linalg import splu

from meshes.errors import SolverError
from meshes.radial import Array, Indices

SYMMETRIC: dict[str, Any] = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}


def solver() -> str:
    """Name of the sparse factorisation in use."""
    return "cholmod" if importlib.util.find_spec("kvxopt") else "superlu"


def fill_reducing_order(graph: csc_matrix, name: str = "") -> Indices:
    """(n,) order in which to eliminate the vertices of a symmetric graph (any positive values, full diagonal)."""
    if (name or solver()) == "cholmod":
        from kvxopt import amd

        return np.array(amd.order(_lower(graph))).ravel()
    laplacian = graph * -1.0
    laplacian.setdiag(np.asarray(graph.sum(axis=0)).ravel() + 1)
    return np.argsort(splu(laplacian.tocsc(), permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).perm_c)


def trailing_factor(matrix: csc_matrix, inside: int, name: str = "") -> Array:
    """(k, k) lower Cholesky factor of the Schur complement of the first `inside` unknowns.

    Parameters
    ----------
    matrix : symmetric positive definite; unknowns to eliminate first, in the order of elimination
    inside : how many to eliminate
    name : `cholmod` or `superlu`; default the best one installed

    Raises
    ------
    SolverError
        if the matrix is not positive definite
    """
    try:
        factor = {"cholmod": _cholmod, "superlu": _superlu}[name or solver()](matrix, inside)
    except (ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
        raise SolverError(f"the stiffness of the half-space could not be factorised: {error}") from error
    if not np.isfinite(factor).all():
        raise SolverError("the stiffness of the half-space is singular: its factor is not finite")
    return factor


def _check_pivots(pivots: Array) -> None:
    if not (pivots > 0).all():
        raise SolverError("the stiffness of the half-space is not positive definite")


def _lower(matrix: csc_matrix) -> Any:
    """Lower triangle as CHOLMOD's kind of matrix."""
    import kvxopt

    entries = tril(matrix, format="coo")
    return kvxopt.spmatrix(entries.data, entries.row.astype(np.int64), entries.col.astype(np.int64), entries.shape)


def _cholmod(matrix: csc_matrix, inside: int) -> Array:
    import kvxopt
    from kvxopt import cholmod

    size = matrix.shape[0]
    lower = _lower(matrix)
    # the order is ours, down to the last unknown: CHOLMOD must not improve on it
    ours = {"supernodal": 2, "postorder": False, "nmethods": 1}
    before = dict(cholmod.options)
    cholmod.options.update(ours)
    try:
        factor = cholmod.symbolic(lower, p=kvxopt.matrix(list(range(size)), (size, 1), "i"))
        cholmod.numeric(lower, factor)
        pointers, rows, values = (np.array(part).ravel() for part in cholmod.getfactor(factor).CCS)
    finally:
        cholmod.options.clear()
        cholmod.options.update(before)
    # a factorisation that met a pivot that is not positive stops without a word
    _check_pivots(values[pointers[:-1]])
    first = pointers[inside]
    trailing = csc_matrix((values[first:], rows[first:] - inside, pointers[inside:] - first), shape=(size - inside,) * 2)
    return np.asarray(trailing.toarray())


def _superlu(matrix: csc_matrix, inside: int) -> Array:
    factor = splu(matrix, permc_spec="NATURAL", **SYMMETRIC)
    natural = np.arange(matrix.shape[0])
    if not (np.array_equal(factor.perm_r, natural) and np.array_equal(factor.perm_c, natural)):
        raise SolverError("the stiffness of the half-space needed pivoting: it is not positive definite")
    _check_pivots(factor.U.diagonal())
    schur = (factor.L[inside:, inside:] @ factor.U[inside:, inside:]).toarray()
    return np.linalg.cholesky((schur + schur.T) / 2)
