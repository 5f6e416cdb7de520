"""Relaxation modes of a wearing punch.

All of them, or those that its flat start excites. Non-dimensional.

They are eigenvectors of the compliance `A` on the wear rates that carry no force, in coordinates
that are orthonormal in the mass matrix of weight `k`. Small problems are diagonalised whole. Large
ones are projected on the Krylov space of the flat start (Lanczos), which holds every mode that
carries the history and hardly any other: with hundreds of rings it is many times smaller than the
pressure space.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded, eigh, eigh_tridiagonal, svd
from scipy.linalg.blas import dsymv
from scipy.linalg.lapack import dtbtrs
from scipy.sparse import csr_matrix, tril
from scipy.sparse.linalg import eigsh

from ...meshes.errors import SolverError
from ...meshes.radial import Array, unit_gauss
from ..problem.loading import Loading, State

# share of the history, and of the slowest relaxation times, that the Krylov space may leave out
NEGLIGIBLE = 1e-13
# relaxation times that are shown
SHOWN = 20


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
            raise SolverError(
                f"the radial mesh is too extreme for double precision: {error}"
            ) from error

    def forward(self, right: Array, trans: str = "N") -> Array:
        """Return ``L^-1`` times a vector or the columns of a matrix."""
        if not right.size:
            # LAPACK's wrapper writes where it should not
            return right
        columns = right.reshape(len(right), -1)
        solution, _ = dtbtrs(self._band, columns, uplo="L", trans=trans)
        return np.asarray(solution).reshape(right.shape)

    def backward(self, right: Array) -> Array:
        """Return ``L^-T`` times a vector or the columns of a matrix."""
        return self.forward(right, "T")

    def solve(self, right: Array) -> Array:
        """Return the inverse of the matrix times a vector or the columns of a matrix."""
        return self.backward(self.forward(right))


class TooEarlyError(SolverError):
    """Modes below roundoff are still felt."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Relaxation modes, slowest first.

    Parameters
    ----------
    relaxation : (m,) times
    shapes : (n, m) wear rates, orthonormal
    amplitudes : (m,) share of each in the flat start
    exact : how many, from the slowest on, are modes of the punch; the others stand for all that
        relax as fast
    """

    relaxation: Array
    shapes: Array
    amplitudes: Array
    exact: int

    def left(self, times: Array) -> Array:
        """Return what is left (T,) of the change from the flat start to the steady state.

        It is that of the approach ``d(t) - w t``, or ``d F(t)`` at a fixed indentation: a sum of
        decaying exponentials whose coefficients are all positive.
        """
        return np.asarray(
            np.exp(-times[:, None] / self.relaxation) @ (self.amplitudes**2 * self.relaxation)
        )

    def time_until(self, left: float) -> float:
        """Return the time from which no more than this is left; NaN if there never was more.

        There is one such time, because what is left falls all the time.
        """
        whole = float(self.left(np.zeros(1))[0])
        if not 0 < left < whole:
            return float("nan")
        # the logarithm of a sum of decaying exponentials is convex, so that Newton's method rises
        # from 0 to the time and never goes beyond it
        coefficients, time, step = self.amplitudes**2 * self.relaxation, 0.0, np.inf
        while step > 1e-14 * time:
            terms = coefficients * np.exp(-time / self.relaxation)
            rate = float((terms / self.relaxation).sum() / terms.sum())
            step = float(np.log(terms.sum() / left)) / rate
            time += step
        return time

    def excite(self, before: Array | float, state: State) -> Array:
        """Return what there is of each mode (T, m) at states of a load.

        Every rise dF of the force excites ``amplitudes dF`` more, which decays from then on
        (Duhamel).

        Parameters
        ----------
        before : (T, m), what there was at the last knots
        """
        decayed = state.slid[:, None] / self.relaxation
        after = before * np.exp(-decayed)
        rises = np.flatnonzero(state.rise)
        left = mean_decay(decayed[rises], state.bend[rises])
        after[rises] += self.amplitudes * state.rise[rises, None] * left
        return np.asarray(after)

    def at_knots(self, loading: Loading) -> Array:
        """Return what there is of each mode (K, m) at the knots of a loading."""
        segments = loading.segments
        first = loading.forces[0] * self.amplitudes
        excited = np.vstack([first, self.excite(0.0, segments)])
        for knot, slid in enumerate(segments.slid):
            excited[knot + 1] += np.exp(-slid / self.relaxation) * excited[knot]
        return excited


def mean_decay(decayed: Array, bend: Array) -> Array:
    """Return the mean over a time of ``exp(-(tau_1 - tau) / T)``, with the speed linear in it.

    Parameters
    ----------
    decayed : (T, m) array
        The sliding distance in that time, over T.
    bend : (T,) array
        Rise of the speed over twice its mean.

    Notes
    -----
    With u the part of the time that is left, ``tau_1 - tau = distance u (1 + bend (1 - u))``. Gauss
    points lie where that is felt: 48 give all digits of what has not decayed to roundoff.
    """
    bend, roundoff = bend[:, None], 40.0
    # from there on, by each of the two terms of u (1 + bend) - bend u^2 alone
    with np.errstate(divide="ignore"):
        linear = roundoff / (decayed * np.clip(1 + bend, 0.0, 1.0))
        square = np.sqrt(roundoff / (decayed * np.maximum(-bend, 0.0)))
    reach = np.minimum(np.minimum(linear, square), 1.0)
    mean = np.zeros_like(decayed)
    for point, weight in zip(*unit_gauss(48), strict=True):
        left = reach * point
        mean += weight * reach * np.exp(-decayed * left * (1 + bend * (1 - left)))
    return mean


def every_mode(
    energy: Array,
    factor: Callable[[], Array],
    weights: Array | None,
    moments: Array,
    earliest: float,
) -> Modes:
    """Return all modes above roundoff.

    Parameters
    ----------
    energy : (n, n) compliance `A` of orthonormal wear rates
    factor : yields its (m, n) factor, ``A = H^T H``: where eigenvalues of `A` lose modes to
        roundoff that are felt, singular values of `H` keep them, for four times the time
    weights : (n,) force that each wear rate carries, if modes are to carry none; None if they may
    moments : (n,) by how much less the flat start displaces than the state that wear tends to
    earliest : time from which on they are felt
    """
    axis = _axis(weights)
    try:
        relaxation, shapes = eigh(_forceless(energy, axis), driver="evd", check_finite=False)
        significant = _significant(relaxation, earliest)
        relaxation, shapes = relaxation[significant][::-1], shapes[:, significant][:, ::-1]
    except TooEarlyError:
        of_modes = factor()
        if axis is not None:
            of_modes = (of_modes - 2 * np.outer(of_modes @ axis, axis))[:, 1:]
        _, singular, right = svd(of_modes, full_matrices=False, check_finite=False)
        relaxation, shapes = singular**2, right.T
    if axis is not None:
        shapes = np.concatenate([np.zeros((1, len(relaxation))), shapes])
        shapes -= 2 * np.outer(axis, axis @ shapes)
    return modes_of(relaxation, shapes, moments, len(relaxation))


def slowest_times(energy: Array, weights: Array | None) -> Array:
    """Return the `SHOWN` slowest relaxation times (m,), all of them if there are fewer.

    Parameters as for `every_mode`.
    """
    forceless = _forceless(energy, _axis(weights))
    size = len(forceless)
    if size <= 4 * SHOWN:
        return np.asarray(eigh(forceless, eigvals_only=True)[::-1][:SHOWN])
    # a start of its own would be drawn at random
    return np.asarray(
        np.sort(eigsh(forceless, SHOWN, which="LA", v0=np.ones(size), return_eigenvectors=False))[
            ::-1
        ]
    )


def _axis(weights: Array | None) -> Array | None:
    """Return the axis of the reflection that maps the steady state to the first axis.

    All other axes then carry no force. The result is None if modes may carry force.
    """
    if weights is None:
        return None
    axis = weights / np.linalg.norm(weights)
    axis[0] += np.copysign(1.0, axis[0])
    return np.asarray(axis / np.linalg.norm(axis))


def _forceless(energy: Array, axis: Array | None) -> Array:
    """Return the compliance on the wear rates that carry no force.

    After the reflection it is (n-1, n-1). Without a reflection it is the compliance on all wear
    rates (n, n).
    """
    if axis is None:
        return energy.copy()
    image = energy @ axis
    image -= (axis @ image) * axis
    reflected = energy - 2 * (np.outer(axis, image) + np.outer(image, axis))
    return np.asarray(reflected[1:, 1:])


def excited_modes(energy: Array, weights: Array | None, moments: Array, earliest: float) -> Modes:
    """Return the modes that the flat start excites.

    Modes that are below roundoff at `earliest` and later are left out.

    Parameters as for `every_mode`; `earliest` is above 0.
    """
    energy, size = np.asfortranarray(energy), len(moments)
    # rows are touched, and so take memory, only as they are filled; the first is the steady state
    basis = np.empty((size + 1, size))
    basis[0] = 0.0 if weights is None else weights / np.linalg.norm(weights)
    size -= weights is not None
    diagonal, remaining = np.empty(size), np.empty(size)
    image, look = moments - basis[0] * (basis[0] @ moments), min(40, size)
    for k in range(size):
        vector = basis[k + 1] = image / np.linalg.norm(image)
        image = dsymv(1.0, energy, vector)
        diagonal[k] = vector @ image
        # twice, or roundoff of the first time would grow
        for _ in range(2):
            image -= (basis[: k + 2] @ image) @ basis[: k + 2]
        remaining[k] = np.linalg.norm(image)
        # below the roundoff of the image, nothing is left that the flat start excites
        ended = remaining[k] <= 100 * np.finfo(float).eps * diagonal[0] or k + 1 == size
        if ended or k + 1 == look:
            relaxation, within = eigh_tridiagonal(diagonal[: k + 1], remaining[:k])
            lost = np.abs(remaining[k] * within[-1])
            if ended or _carried(relaxation, within, lost, earliest):
                break
            look = min(int(1.2 * look), size)
    significant = _significant(relaxation, earliest)
    relaxation, within, lost = (
        relaxation[significant][::-1],
        within[:, significant][:, ::-1],
        lost[significant][::-1],
    )
    exact = int(np.argmin(np.append(lost <= np.sqrt(NEGLIGIBLE) * relaxation, False)))
    return modes_of(relaxation, basis[1 : len(within) + 1].T @ within, moments, max(exact, 1))


def _carried(relaxation: Array, within: Array, lost: Array, earliest: float) -> bool:
    """Return whether a Krylov space carries the history and the slowest relaxation times.

    The history is the one from `earliest` on.
    """
    significant = _significant(relaxation, earliest)
    left = within[:, significant] @ (
        within[0, significant]
        * np.exp(-earliest / relaxation[significant])
        / relaxation[significant]
    )
    history = np.abs(left[-5:]).max() <= NEGLIGIBLE * np.linalg.norm(left)
    return bool(history and (lost[-5:] <= NEGLIGIBLE * relaxation[-1]).all())


def _significant(relaxation: Array, earliest: float) -> slice:
    """Return the modes, fastest first, that are above roundoff.

    Raises
    ------
    TooEarlyError
        if those below it are still felt at the earliest time
    """
    roundoff = len(relaxation) * np.finfo(float).eps * relaxation[-1]
    below = int(np.searchsorted(relaxation, roundoff))
    if below and earliest < 40 * roundoff:
        raise TooEarlyError(
            f"the first of wear.times after the start is {earliest / relaxation[-1]:.1e} of the "
            "slowest relaxation time, "
            "too early for double precision with so many rings; leave the earliest out"
        )
    return slice(below, None)


def modes_of(relaxation: Array, shapes: Array, moments: Array, exact: int) -> Modes:
    """Return the modes, slowest first, with what the flat start has of each.

    (n,) `moments` as for `every_mode`.
    """
    return Modes(relaxation, shapes, -(shapes.T @ moments) / relaxation, exact)
