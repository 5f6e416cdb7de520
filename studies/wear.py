"""Archard's wear on any compliance: exact in time by modes, or marched in steps (Eqs. 12 to 17). Natural units.

In full contact the pressure is affine in the profile, and with the wear rate ``k p`` continuous (which it is for
every t > 0) the history obeys ``A p' = d' b - K p``, ``b . p = F``, with the mass matrix `K` of weight `k`. Its
deviation from the steady state decays in modes of the pencil (A, K) on the pressures that carry no force, whose
eigenvalues are the relaxation times. A flat start never loses contact, so no inequality is enforced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh, solve_triangular, svd

from meshes.compliance import Compliance
from meshes.errors import SceneError, SolverError
from meshes.radial import Array

from .contact import SteadyState, flat_start, steady_state

MOST_STEPS = 2_000_000
# smallest element above which eigenvalues are as good as singular values, at a quarter of the time (measured: no
# digit of indentation, relaxation time or slope differs from rtol 1e-3 to 1e-9). Below it the stiff modes would be lost
# to roundoff of the slowest
GENTLEST = 1e-10
# beyond this size singular values would take minutes; the modes that eigenvalues lose die away at once
LARGE = 700

# (state, step, how many) -> (state, wear of each unknown in between)
Advance = Callable[[Array, float, int], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class History:
    """Pressures and profiles (T, size) as coefficients on the pressure space, and indentations (T,)."""

    times: Array
    pressure: Array
    profile: Array
    indentation: Array


def _squared_singular(factor: Array, gentle: bool) -> tuple[Array, Array]:
    """Squared singular values, greatest first, and right singular vectors of a tall matrix."""
    if gentle or factor.shape[1] > LARGE:
        values, vectors = eigh(factor.T @ factor, driver="evd", overwrite_a=True, check_finite=False)
        return values[::-1], vectors[:, ::-1]
    _, singular, right = svd(factor, full_matrices=False, check_finite=False)
    return singular**2, right.T


@dataclass(frozen=True, eq=False)
class Wear:
    """A punch from its flat start to its steady state: condensed once, evaluated at any time.

    Parameters
    ----------
    compliance : of the half-space
    wear_coefficients : (N,) of the rings of its pressure space
    """

    compliance: Compliance
    wear_coefficients: Array

    @cached_property
    def steady(self) -> SteadyState:
        return steady_state(self.compliance, self.wear_coefficients)

    @cached_property
    def _to_pressure(self) -> Array:
        """(size, n) pressures by the wear rate."""
        return self.compliance.space.joined(self.wear_coefficients)

    @cached_property
    def _to_profile(self) -> Array:
        """(size, n) wear rates, and so worn profiles, by the same unknowns."""
        return self.compliance.space.joined(np.ones_like(self.wear_coefficients))

    @cached_property
    def _factor(self) -> Array:
        return self.compliance.factor @ self._to_pressure

    @cached_property
    def _mass(self) -> Array:
        return self._to_pressure.T @ self.compliance.space.mass(self.wear_coefficients) @ self._to_pressure

    @cached_property
    def _weights(self) -> Array:
        return self._to_pressure.T @ self.compliance.space.weights

    @cached_property
    def _modes(self) -> tuple[Array, Array, Array]:
        """Relaxation times (m,), slowest first, shapes (n, m) and their amplitudes at the flat start (m,)."""
        try:
            lower = np.linalg.cholesky(self._mass)
        except np.linalg.LinAlgError as error:
            raise SolverError(f"the radial mesh is too extreme for double precision: {error}") from error
        scaled = solve_triangular(lower, self._factor.T, lower=True).T
        # a reflection that maps the steady state to the first axis: the other axes carry no force
        axis = solve_triangular(lower, self._weights, lower=True)
        axis /= np.linalg.norm(axis)
        axis[0] += np.copysign(1.0, axis[0])
        axis /= np.linalg.norm(axis)
        reflected = scaled - 2 * np.outer(scaled @ axis, axis)
        gentle = float(np.diff(self.compliance.space.breakpoints).min()) > GENTLEST
        relaxation, within = _squared_singular(reflected[:, 1:], gentle)
        if not relaxation[-1] > 0:
            raise SolverError("the compliance is singular: the multipliers are unstable on this mesh")
        shapes = np.concatenate([np.zeros((1, len(relaxation))), within])
        shapes -= 2 * np.outer(axis, axis @ shapes)
        images = scaled @ shapes
        amplitudes = -(images.T @ (self.compliance.factor @ self.steady.pressure)) / relaxation
        return relaxation, solve_triangular(lower, shapes, lower=True, trans="T"), amplitudes

    @property
    def relaxation_times(self) -> Array:
        """(m,) slowest first."""
        return self._modes[0]

    def modal(self, times: Array) -> History:
        """The exact history at any times, none of which depends on another."""
        relaxation, shapes, amplitudes = self._modes
        decay = times[:, None] / relaxation
        left = (np.exp(-decay) * amplitudes) @ shapes.T
        worn = (-np.expm1(-decay) * relaxation * amplitudes) @ shapes.T
        rate = self.steady.wear_rate
        pressure = self.steady.pressure + left @ self._to_pressure.T
        # the constant wear rate has coefficient one on every hat
        profile = worn @ self._to_profile.T + np.outer(rate * times, self._constant)
        steady_line = self.compliance.factor @ self.steady.pressure
        indentation = rate * times + (pressure @ self.compliance.factor.T) @ steady_line
        return self._from_flat(History(times, pressure, profile, indentation))

    @cached_property
    def _constant(self) -> Array:
        return (self.compliance.space.order == 1).astype(float)

    def _from_flat(self, history: History) -> History:
        """At t = 0 the pressure, not the wear rate, is continuous: put the flat start in its own space."""
        start = np.flatnonzero(history.times == 0)
        if len(start):
            flat = flat_start(self.compliance)
            history.pressure[start] = flat.pressure
            history.indentation[start] = flat.indentation
        return history

    @cached_property
    def _start(self) -> Array:
        """Unknowns of the flat start in the space of t > 0: the best approximation in energy."""
        solution = cho_solve(cho_factor(self._factor.T @ self._factor), self._weights)
        return solution / (self._weights @ solution)

    def stability_limit(self) -> float:
        """Greatest stable step of the explicit march, twice the shortest relaxation time."""
        return float(2 * self.relaxation_times[-1])

    def implicit(self, times: Array, step: float) -> History:
        """Implicit Euler, equal steps of at most `step` between output times: stable, first order."""

        def advance(state: Array, dt: float, count: int) -> tuple[Array, Array]:
            factor = cho_factor(energy + dt * self._mass)
            by_weights = cho_solve(factor, self._weights)
            worn = np.zeros_like(state)
            for _ in range(count):
                trial = cho_solve(factor, energy @ state)
                state = trial + by_weights * (1 - self._weights @ trial) / (self._weights @ by_weights)
                worn += dt * state
            return state, worn

        energy = self._factor.T @ self._factor
        return self._marched(times, step, advance)

    def explicit(self, times: Array, step: float) -> History:
        """Explicit Euler (Eqs. 14 to 17 on this compliance): first order, stable up to `stability_limit`.

        Raises
        ------
        SceneError
            if the step is above the stability limit
        """
        limit = self.stability_limit()
        if step > limit:
            raise SceneError(f"the explicit march is unstable: its step is {step / limit:.3g} times the stability limit; "
                             "give a smaller wear.step, or march = 'modal' (exact in time, no step)")  # fmt: skip
        energy = cho_factor(self._factor.T @ self._factor)
        by_weights = cho_solve(energy, self._weights)
        rate = -cho_solve(energy, self._mass)
        rate -= np.outer(by_weights, self._weights @ rate) / (self._weights @ by_weights)

        def advance(state: Array, dt: float, count: int) -> tuple[Array, Array]:
            worn = np.zeros_like(state)
            for _ in range(count):
                worn += dt * state
                state = state + dt * (rate @ state)
            return state, worn

        return self._marched(times, step, advance)

    def _marched(self, times: Array, step: float, advance: Advance) -> History:
        steps = np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12)).astype(np.int64)
        if steps.sum() > MOST_STEPS:
            raise SceneError(f"{steps.sum()} steps are needed to the last time, more than {MOST_STEPS}: "
                             "give a larger wear.step, or march = 'modal'")  # fmt: skip
        state, worn, now = self._start, np.zeros_like(self._start), 0.0
        states, profiles = [], []
        for time, count in zip(times, steps, strict=True):
            if count:
                state, more = advance(state, (time - now) / count, int(count))
                worn, now = worn + more, time
            states.append(state)
            profiles.append(worn)
        pressure, profile = np.array(states) @ self._to_pressure.T, np.array(profiles) @ self._to_profile.T
        # force balance against the steady pressures: d F = p_s . A p + int f p_s dA
        steady = self.steady
        indentation = (pressure @ self.compliance.factor.T) @ (self.compliance.factor @ steady.pressure)
        indentation += np.array(profiles) @ (self._weights * steady.wear_rate)
        return self._from_flat(History(times, pressure, profile, indentation))

    def history(self, times: Array, march: str = "modal", step: float | None = None) -> History:
        """The history by the named march."""
        if march == "modal" or step is None:
            return self.modal(times)
        return {"implicit": self.implicit, "explicit": self.explicit}[march](times, step)
