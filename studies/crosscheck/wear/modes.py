"""Compute the relaxation modes of a wearing punch: all, or those excited by the flat start.

Non-dimensional. The modes are eigenvectors of the compliance `A` on the wear rates that carry no
force, in coordinates that are orthonormal in the mass matrix of weight `k`. The matrices of small
problems are diagonalised completely. Large ones are projected on the Krylov space of the flat start
(Lanczos), which contains every mode that contributes to the history and hardly any other. With
hundreds of rings it is many times smaller than the pressure space.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, eigh_tridiagonal, svd
from scipy.sparse.linalg import eigsh
from scipy.special import dawsn, erfcx

from ....meshes.errors import SolverError
from ....meshes.radial import Array, unit_gauss
from ..problem.loading import Loading, State

# relative error of the history and of the slowest relaxation times by the Krylov projection
KRYLOV_TOLERANCE = 1e-13
# First time over the roundoff of relaxation times from which modes below roundoff have decayed, and
# from which the others are accurate (physics/test_random_scenes.py)
DECAYED, ACCURATE = 40.0, 1e6
# part of a vector that is left once it is orthogonal to others except for roundoff
ENOUGH_IS_LEFT = 0.7
# exponent of a decay from which on its mean is computed in closed form where the speed varies, and
# number of Gauss points below it, which give all digits there
LEAST_EXPONENT, POINTS_OF_LITTLE_DECAY = 0.1, 8
# greatest number of relaxation times in results
SHOWN_RELAXATION_TIMES = 20


class TooEarlyError(SolverError):
    """The earliest time is so small that modes with much roundoff still contribute."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Relaxation modes, slowest first.

    Parameters
    ----------
    relaxation : (m,) array
        Relaxation times.
    shapes : (n, m) array
        Orthonormal wear rates of the modes, by columns.
    amplitudes : (m,) array
        Amplitude of each mode in the flat start under the force 1.
    exact : int
        Number of modes, from the slowest on, that have converged to modes of the punch. Each of the
        others approximates a group of faster modes.
    """

    relaxation: Array
    shapes: Array
    amplitudes: Array
    exact: int

    def remaining_change(self, times: Array) -> Array:
        """Return the remaining change (T,) from the flat start to the steady state.

        The change is that of ``d(t) - w t`` with the steady wear rate w, or of ``d F(t)`` at a
        fixed indentation. It is a sum of decaying exponentials with positive coefficients.
        """
        return np.exp(-times[:, None] / self.relaxation) @ (self.amplitudes**2 * self.relaxation)

    def time_until(self, remaining: float) -> float:
        """Return the time at which the remaining change falls to a value; NaN if it begins below.

        There is only one such time, because the remaining change decreases monotonically.
        """
        total = float(self.remaining_change(np.zeros(1))[0])
        if not 0 < remaining < total:
            return float("nan")
        # the logarithm of a sum of decaying exponentials is convex, so Newton's method increases
        # monotonically from 0 to the solution and never exceeds it
        coefficients, time, step = self.amplitudes**2 * self.relaxation, 0.0, np.inf
        while step > 1e-14 * time:
            terms = coefficients * np.exp(-time / self.relaxation)
            rate = float((terms / self.relaxation).sum() / terms.sum())
            step = float(np.log(terms.sum() / remaining)) / rate
            time += step
        return time

    def excite(self, knot_amplitudes: Array | float, state: State) -> Array:
        """Return the amplitude of each mode (T, m) at states of a load.

        Every increment dF of the force adds ``amplitudes dF``, which decays afterwards (Duhamel's
        integral).

        Parameters
        ----------
        knot_amplitudes : (T, m) array
            Amplitudes at the last knot before each state.
        state : State
            T states of the load.
        """
        exponents = state.slid[:, None] / self.relaxation
        amplitudes = knot_amplitudes * np.exp(-exponents)
        rises = np.flatnonzero(state.rise)
        mean_decays = mean_decay(exponents[rises], state.bend[rises])
        amplitudes[rises] += self.amplitudes * state.rise[rises, None] * mean_decays
        return amplitudes

    def at_knots(self, loading: Loading) -> Array:
        """Return the amplitude of each mode (K, m) at the knots of a loading."""
        segments = loading.segments
        initial = loading.forces[0] * self.amplitudes
        amplitudes = np.vstack([initial, self.excite(0.0, segments)])
        for knot, slid in enumerate(segments.slid):
            amplitudes[knot + 1] += np.exp(-slid / self.relaxation) * amplitudes[knot]
        return amplitudes


def mean_decay(exponent: Array, bend: Array) -> Array:
    """Return the mean of ``exp(-(tau_1 - tau) / T)`` over an interval of time.

    The sliding speed is linear in the interval; tau is the sliding distance, tau_1 that at the end
    of the interval, and T a relaxation time.

    Parameters
    ----------
    exponent : (T, m) array
        Sliding distance in each of T intervals, over each of m relaxation times.
    bend : (T,) array
        Increase of the speed in the interval, over twice its mean.

    Returns
    -------
    (T, m) array

    Notes
    -----
    With u the remaining fraction of the interval, ``tau_1 - tau = distance u (1 + bend (1 - u))``.
    The mean is the integral over u from 0 to 1. It is ``(1 - exp(-exponent)) / exponent`` at a
    constant speed, and otherwise a difference of Dawson functions or scaled error functions (Gauss
    points for small exponents, for which that difference cancels).
    """
    mean, constant = np.ones_like(exponent), bend == 0
    decayed = exponent[constant]
    mean[constant] = np.divide(
        -np.expm1(-decayed), decayed, out=np.ones_like(decayed), where=decayed > 0
    )
    bends, small = np.broadcast_to(bend[:, None], exponent.shape), exponent < LEAST_EXPONENT
    for selected, formula in (
        ((bends != 0) & small, _mean_of_little_decay),
        ((bends > 0) & ~small, _mean_at_rising_speed),
        ((bends < 0) & ~small, _mean_at_falling_speed),
    ):
        if selected.any():
            mean[selected] = formula(exponent[selected], bends[selected])
    return mean


def _mean_of_little_decay(exponent: Array, bend: Array) -> Array:
    points, weights = unit_gauss(POINTS_OF_LITTLE_DECAY)
    paths = points * (1 + bend[:, None] * (1 - points))
    return np.exp(-exponent[:, None] * paths) @ weights


def _mean_at_rising_speed(exponent: Array, bend: Array) -> Array:
    # exponent (u (1 + bend) - bend u^2) = end^2 - (end - root u)^2
    root, end = np.sqrt(exponent * bend), (1 + bend) * np.sqrt(exponent / bend) / 2
    return (dawsn(end) - np.exp(-exponent) * dawsn(end - root)) / root


def _mean_at_falling_speed(exponent: Array, bend: Array) -> Array:
    # exponent (u (1 + bend) - bend u^2) = (start + root u)^2 - start^2
    root, start = np.sqrt(-exponent * bend), (1 + bend) * np.sqrt(-exponent / bend) / 2
    difference = erfcx(start) - np.exp(-exponent) * erfcx(start + root)
    return np.sqrt(np.pi) / 2 * difference / root


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
    energy : (n, n) array
        Compliance `A` in orthonormal wear rates.
    factor : callable
        Returns the (m, n) factor H, ``A = H^T H``. It is needed if modes that have much roundoff as
        eigenvectors of `A` still contribute at `earliest`. The singular vectors of `H` preserve
        these modes, in ten times the computing time.
    weights : (n,) array or None
        Force that each wear rate carries; the modes then carry no force. None if modes may carry
        force.
    moments : (n,) array
        Moments of the displacement in the steady state, less those in the flat start.
    earliest : float
        First sliding distance at which the modes are evaluated.
    """
    axis = _reflection_axis(weights)
    try:
        relaxation, shapes = eigh(
            _forceless_compliance(energy, axis), driver="evd", check_finite=False
        )
        above_roundoff = _modes_above_roundoff(relaxation, earliest, ACCURATE)
        relaxation, shapes = relaxation[above_roundoff][::-1], shapes[:, above_roundoff][:, ::-1]
    except TooEarlyError:
        mode_factor = factor()
        if axis is not None:
            mode_factor = (mode_factor - 2 * np.outer(mode_factor @ axis, axis))[:, 1:]
        _, singular, right = svd(mode_factor, full_matrices=False, check_finite=False)
        relaxation, shapes = singular**2, right.T
    if axis is not None:
        shapes = np.concatenate([np.zeros((1, len(relaxation))), shapes])
        shapes -= 2 * np.outer(axis, axis @ shapes)
    return _with_amplitudes(relaxation, shapes, moments, len(relaxation))


def slowest_times(energy: Array, weights: Array | None) -> Array:
    """Return at most `SHOWN_RELAXATION_TIMES` relaxation times (m,), the slowest ones.

    The parameters are those of `every_mode`.
    """
    forceless = _forceless_compliance(energy, _reflection_axis(weights))
    size = len(forceless)
    if size <= 4 * SHOWN_RELAXATION_TIMES:
        return eigh(forceless, eigvals_only=True)[::-1][:SHOWN_RELAXATION_TIMES]
    # by default ARPACK starts from a random vector
    count, start = SHOWN_RELAXATION_TIMES, np.ones(size)
    times = eigsh(forceless, count, which="LA", v0=start, return_eigenvectors=False)
    return np.sort(times)[::-1]


def _reflection_axis(weights: Array | None) -> Array | None:
    """Return the unit normal (n,) of the reflection that maps the steady state to the first axis.

    All other axes then carry no force. The result is None if modes may carry force.
    """
    if weights is None:
        return None
    axis = weights / np.linalg.norm(weights)
    axis[0] += np.copysign(1.0, axis[0])
    return axis / np.linalg.norm(axis)


def _forceless_compliance(energy: Array, axis: Array | None) -> Array:
    """Return the compliance on the wear rates that carry no force, after the reflection.

    It is (n-1, n-1). If `axis` is None, it is the compliance on all wear rates (n, n).
    """
    if axis is None:
        return energy.copy()
    image = energy @ axis
    image -= (axis @ image) * axis
    reflected = energy - 2 * (np.outer(axis, image) + np.outer(image, axis))
    return reflected[1:, 1:]


def excited_modes(
    energy: Callable[[Array], Array],
    weights: Array | None,
    moments: Array,
    earliest: float,
    accurate: float = ACCURATE,
) -> Modes:
    """Return the modes that the flat start excites, by the Lanczos method.

    Modes below roundoff are omitted. They have decayed at `earliest`.

    The parameters are those of `every_mode`, but `energy` returns the product (n,) of the
    compliance `A` with a vector (n,); `earliest` is positive, and over the roundoff of relaxation
    times at least `accurate`.

    Raises
    ------
    TooEarlyError
        if `earliest` is smaller
    """
    size = len(moments)
    # rows take memory only once they are filled; the first row is the steady state
    basis = np.empty((size + 1, size))
    basis[0] = 0.0 if weights is None else weights / np.linalg.norm(weights)
    size -= weights is not None
    diagonal, off_diagonal = np.empty(size), np.empty(size)
    image, next_check = moments - basis[0] * (basis[0] @ moments), min(40, size)
    for k in range(size):
        vector = basis[k + 1] = image / np.linalg.norm(image)
        image = energy(vector)
        diagonal[k] = vector @ image
        # the large parts first: without roundoff, there are no others
        image -= diagonal[k] * vector + (basis[0] @ image) * basis[0]
        if k:
            image -= off_diagonal[k - 1] * basis[k]
        off_diagonal[k] = np.linalg.norm(image)
        for _ in range(2):
            before = off_diagonal[k]
            image -= (basis[: k + 2] @ image) @ basis[: k + 2]
            off_diagonal[k] = np.linalg.norm(image)
            # one pass is enough unless it has removed a visible part, whose roundoff would grow
            if off_diagonal[k] > ENOUGH_IS_LEFT * before:
                break
        # the residual is roundoff: the Krylov space contains all modes that the flat start excites
        exhausted = off_diagonal[k] <= 100 * np.finfo(float).eps * diagonal[0] or k + 1 == size
        if exhausted or k + 1 == next_check:
            relaxation, ritz_vectors = eigh_tridiagonal(diagonal[: k + 1], off_diagonal[:k])
            residuals = np.abs(off_diagonal[k] * ritz_vectors[-1])
            if exhausted or _krylov_space_suffices(
                relaxation, ritz_vectors, residuals, earliest, accurate
            ):
                break
            next_check = min(int(1.2 * next_check), size)
    above_roundoff = _modes_above_roundoff(relaxation, earliest, accurate)
    relaxation, ritz_vectors, residuals = (
        relaxation[above_roundoff][::-1],
        ritz_vectors[:, above_roundoff][:, ::-1],
        residuals[above_roundoff][::-1],
    )
    exact = int(np.argmin(np.append(residuals <= np.sqrt(KRYLOV_TOLERANCE) * relaxation, False)))
    return _with_amplitudes(
        relaxation, basis[1 : len(ritz_vectors) + 1].T @ ritz_vectors, moments, max(exact, 1)
    )


def _krylov_space_suffices(
    relaxation: Array, ritz_vectors: Array, residuals: Array, earliest: float, accurate: float
) -> bool:
    """Return whether the Krylov space resolves the history and the slowest relaxation times.

    The history has converged if its last five Krylov coefficients at `earliest` are negligible.

    Parameters
    ----------
    relaxation : (k,) array
        Eigenvalues of the projected compliance, ascending.
    ritz_vectors : (k, k) array
        Its eigenvectors, by columns.
    residuals : (k,) array
        Residual norms of the eigenpairs.
    earliest : float
        First sliding distance of the history.
    accurate : float
        As for `excited_modes`.
    """
    above_roundoff = _modes_above_roundoff(relaxation, earliest, accurate)
    coefficients = ritz_vectors[:, above_roundoff] @ (
        ritz_vectors[0, above_roundoff]
        * np.exp(-earliest / relaxation[above_roundoff])
        / relaxation[above_roundoff]
    )
    history_converged = np.abs(coefficients[-5:]).max() <= KRYLOV_TOLERANCE * np.linalg.norm(
        coefficients
    )
    return bool(history_converged and (residuals[-5:] <= KRYLOV_TOLERANCE * relaxation[-1]).all())


def _modes_above_roundoff(relaxation: Array, earliest: float, accurate: float) -> slice:
    """Return the slice of the modes above roundoff; `relaxation` is ascending.

    Raises
    ------
    TooEarlyError
        if the earliest sliding distance is below `accurate` times the roundoff
    """
    roundoff = len(relaxation) * np.finfo(float).eps * relaxation[-1]
    count_below = int(np.searchsorted(relaxation, roundoff))
    if count_below and earliest < accurate * roundoff:
        raise TooEarlyError(
            f"the first of wear.times after the start is {earliest / relaxation[-1]:.1e} of the "
            "slowest relaxation time, "
            "too early for double precision with so many rings; leave out the earliest times"
        )
    return slice(count_below, None)


def _with_amplitudes(relaxation: Array, shapes: Array, moments: Array, exact: int) -> Modes:
    """Return the modes with their amplitudes in the flat start; the slowest comes first.

    The parameters are those of `Modes`, and `moments` (n,) are those of `every_mode`.
    """
    return Modes(relaxation, shapes, -(shapes.T @ moments) / relaxation, exact)
