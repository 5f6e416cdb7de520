"""Eliminate the inside of the half-space.

A sparse Cholesky factorisation whose trailing block is what is wanted.

With the kept unknowns ordered last, the trailing block `L` of the factor satisfies ``L L^T = ``
Schur complement of the inside: one factorisation, no solve per kept unknown. CHOLMOD (from
`kvxopt`, an optional extra) is used where it is installed, SuperLU (from scipy) everywhere else.
"""

import importlib.util
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, tril
from scipy.sparse.linalg import splu

from ..meshes.errors import SolverError
from ..meshes.radial import Array, Indices

if TYPE_CHECKING:
    from kvxopt import spmatrix

SYMMETRIC: dict[str, object] = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}


def solver() -> str:
    """Name of the sparse factorisation in use."""
    return "cholmod" if importlib.util.find_spec("kvxopt") else "superlu"


def fill_reducing_order(groups: Indices) -> Indices:
    """Return an order (n,) in which to eliminate the vertices of a graph.

    Parameters
    ----------
    groups : (p, m) the p vertices of each of m groups, numbered from 0 to n - 1; those of one group
        are neighbours
    name : `cholmod` or `superlu`; default the best one installed
    """
    pairs = groups[np.array(np.tril_indices(len(groups)))]
    places = pairs.max(axis=0).ravel(), pairs.min(axis=0).ravel()
    lower = coo_matrix((np.ones(len(places[0])), places), shape=(groups.max() + 1,) * 2)
    if solver() == "cholmod":
        from kvxopt import amd

        return np.array(amd.order(cholmod_matrix(lower))).ravel()
    laplacian = symmetric(lower) * -1.0
    laplacian.setdiag(1 - np.asarray(laplacian.sum(axis=0)).ravel())
    return np.argsort(splu(laplacian, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).perm_c)


def symmetric(lower: coo_matrix) -> csc_matrix:
    """Return the symmetric matrix of a lower triangle, entries at one place summed."""
    summed = lower.tocsc()
    return (summed + tril(summed, -1).T).tocsc()


def cholmod_matrix(lower: coo_matrix) -> "spmatrix":
    """Return a lower triangle as CHOLMOD's kind of matrix, entries at one place summed."""
    import kvxopt

    # converted one by one: fewer copies at a time
    rows, columns = (kvxopt.matrix(indices.astype(np.int64)) for indices in (lower.row, lower.col))
    return kvxopt.spmatrix(kvxopt.matrix(lower.data), rows, columns, lower.shape)


def trailing_factor(lower: coo_matrix, inside: int) -> Array:
    """Return the Cholesky factor of the Schur complement that eliminating unknowns leaves.

    The factor is lower triangular (k, k), with k the number of unknowns that remain when the first
    `inside` are eliminated.

    Parameters
    ----------
    lower : lower triangle of a symmetric positive definite matrix; unknowns to eliminate first, in
        the order of elimination; entries at one place are summed
    inside : how many to eliminate

    Raises
    ------
    SolverError
        if the matrix is not positive definite
    """
    try:
        return (_cholmod if solver() == "cholmod" else _superlu)(lower, inside)
    except (ArithmeticError, RuntimeError, ValueError, np.linalg.LinAlgError) as error:
        raise SolverError(
            f"the stiffness of the half-space could not be factorised: {error}"
        ) from error


def _cholmod(lower: coo_matrix, inside: int) -> Array:
    import kvxopt
    from kvxopt import cholmod

    matrix = cholmod_matrix(lower)
    before = dict(cholmod.options)
    # the order is ours, down to the last unknown: CHOLMOD must not improve on it
    cholmod.options.update({"supernodal": 2, "postorder": False, "nmethods": 1})
    try:
        factor = cholmod.symbolic(matrix, p=kvxopt.matrix(np.arange(lower.shape[0])))
        cholmod.numeric(matrix, factor)
        # a factorisation that met a pivot that is not positive stops without a word
        if not (np.array(cholmod.diag(factor)) > 0).all():
            raise ArithmeticError("it is not positive definite")
        # all of the factor is many times as large as what is wanted of it: one copy, and room for
        # it
        del matrix
        trailing = cholmod.getfactor(factor)[inside:, inside:]
    finally:
        cholmod.options.clear()
        cholmod.options.update(before)
    return np.array(kvxopt.matrix(trailing))


def _superlu(lower: coo_matrix, inside: int) -> Array:
    factor = splu(symmetric(lower), permc_spec="NATURAL", **SYMMETRIC)
    pivoted = np.any(np.array([factor.perm_r, factor.perm_c]) != np.arange(lower.shape[0]))
    pivots = factor.U.diagonal()
    if pivoted or not (pivots > 0).all():
        raise ArithmeticError("it is not positive definite")
    # of a symmetric matrix U = D L^T: Cholesky's factor is L with its columns scaled, without any
    # product of the two
    return factor.L[inside:, inside:].toarray() * np.sqrt(pivots[inside:])
