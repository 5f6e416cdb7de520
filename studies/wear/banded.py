"""Cholesky factors of matrices that couple neighbours only, such as masses on a radial mesh."""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded
from scipy.linalg.lapack import dtbtrs
from scipy.sparse import csr_matrix, tril

from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array


class BandedCholesky:
    """Lower factor `L` of a symmetric positive definite matrix ``L L^T`` with a narrow band.

    Raises
    ------
    SolverError
        if the matrix is not positive definite to roundoff
    """

    def __init__(self, matrix: csr_matrix) -> None:
        entries = tril(matrix, format="coo")
        below = entries.row - entries.col
        band = np.zeros((int(below.max(initial=0)) + 1, matrix.shape[0]))
        band[below, entries.col] = entries.data
        try:
            self._band = cholesky_banded(band, lower=True)
        except LinAlgError as error:
            raise SolverError(f"the radial mesh is too extreme for double precision: {error}") from error

    def forward(self, right: Array) -> Array:
        """``L^-1`` times a vector or the columns of a matrix."""
        return self._triangular(right, "N")

    def backward(self, right: Array) -> Array:
        """``L^-T`` times a vector or the columns of a matrix."""
        return self._triangular(right, "T")

    def solve(self, right: Array) -> Array:
        """The inverse of the matrix times a vector or the columns of a matrix."""
        return self.backward(self.forward(right))

    def _triangular(self, right: Array, trans: str) -> Array:
        columns = right.reshape(len(right), -1)
        solution, _ = dtbtrs(self._band, columns, uplo="L", trans=trans)
        return np.asarray(solution).reshape(right.shape)
