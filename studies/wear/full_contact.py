"""Archard's wear on any compliance, by modes or in steps (Eqs. 12 to 17). Non-dimensional.

In full contact the pressure is affine in the profile, and with the wear rate ``k p`` continuous
(which it is for every t > 0) the history obeys ``A p' = d' b - K p``, ``b . p = F``, with the mass
matrix `K` of weight `k`. Its deviation from the steady state decays in modes of the pencil (A, K)
on the pressures that carry no force, whose eigenvalues are the relaxation times. At a fixed
indentation ``A p' = -K p``: all pressures decay, in modes of the pencil on all of them. A flat
start never loses contact, so no inequality is enforced. Nor does a force that never falls, whose
rises are so many flat starts. Times of marches in steps are sliding distances.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix, diags

from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.loading import Loading
from ..problem.marching import Advance, take_steps
from .flat_contact import FlatPress, FlatStart, SteadyState, flat_start, steady_state
from .history import History
from .modes import (
    BandedCholesky,
    Modes,
    TooEarlyError,
    every_mode,
    excited_modes,
    slowest_times,
)


@dataclass(frozen=True, eq=False)
class RunningIn:
    """A punch from its flat start to its steady state: condensed once, evaluated at any time.

    Parameters
    ----------
    compliance : of the half-space
    wear_coefficients : (N,) of the rings of its pressure space; or (2, N) at the inner and outer
        edge of each, linear between
    earliest : sliding distance > 0 before which no history is wanted, so that a large punch needs
        few of its modes; 0: all of them
    continuous : whether the wear rate is, as it is from a flat start on; else it may jump at ring
        edges, on a space of degree 1
    indentation : held fixed in place of the force 1, so that wear tends to no pressure at all
    loading : of `modal`, its force never falls
    """

    compliance: Compliance
    wear_coefficients: Array
    earliest: float = 0.0
    continuous: bool = True
    indentation: float | None = None
    loading: Loading = field(default_factory=Loading)

    @cached_property
    def steady(self) -> SteadyState:
        """The state that wear tends to."""
        if self.indentation is not None:
            nothing = np.zeros(self.compliance.space.size)
            return SteadyState(nothing, nothing, nothing, 0.0)
        if self.wear_coefficients.ndim == 2:
            # 1 / k is no polynomial: the pressure whose product with k is nearest to a constant
            pressure = self._to_pressure @ self._mass_factor.solve(self._weights)
        else:
            pressure = self.compliance.space.ring_indicator() @ (1 / self.wear_coefficients)
        return steady_state(self.compliance, pressure, self._displacement)

    def _displacement(self, moments: Array) -> Array:
        """Return the coefficients of a displacement by its moments against each pressure."""
        return np.asarray(
            self._to_profile @ self._mass_factor.solve(self._to_pressure.T @ moments.T)
        ).T

    @cached_property
    def flat(self) -> FlatStart | FlatPress:
        start = flat_start(self.compliance)
        return (
            start if self.indentation is None else start.times(self.indentation / start.indentation)
        )

    @cached_property
    def _to_pressure(self) -> csr_matrix:
        """(size, n) pressures by the wear rate."""
        space = self.compliance.space
        if self.continuous:
            return space.joined(self.wear_coefficients)
        return diags(1 / space.at_vertices(self.wear_coefficients)).tocsr()

    @cached_property
    def _to_profile(self) -> csr_matrix | Array:
        """(size, n) wear rates, and so worn profiles, by the same unknowns."""
        space = self.compliance.space
        if self.continuous and self.wear_coefficients.ndim == 2:
            # k p is of a degree more than p: its projection has the same volumes on rings
            worn = space.mass(self.wear_coefficients) @ self._to_pressure
            return BandedCholesky(space.mass()).solve(worn.toarray())
        return space.joined() if self.continuous else diags(np.ones(space.size)).tocsr()

    def _factor(self) -> Array:
        return self.compliance.factor @ self._to_pressure

    @cached_property
    def _energy(self) -> Array:
        return np.asarray(self._to_pressure.T @ self.compliance.matrix @ self._to_pressure)

    @cached_property
    def _mass(self) -> csr_matrix:
        return (
            self._to_pressure.T
            @ self.compliance.space.mass(self.wear_coefficients)
            @ self._to_pressure
        )

    @cached_property
    def _mass_factor(self) -> BandedCholesky:
        return BandedCholesky(self._mass)

    @cached_property
    def _weights(self) -> Array:
        return self._to_pressure.T @ self.compliance.space.weights

    @property
    def _forceless(self) -> Array | None:
        """The weights of force, where modes carry none of it."""
        return self._weights if self.indentation is None else None

    @cached_property
    def _moments(self) -> Array:
        """(n,) by how much less the flat start displaces than the state that wear tends to."""
        return self._to_pressure.T @ self.steady.moments - (self.indentation or 0.0) * self._weights

    @property
    def gentle(self) -> bool:
        """Whether eigenvalues will do.

        What relaxes before the first time is not felt, and need not be known.
        """
        # smallest element, or first time, above which eigenvalues are as good as singular values,
        # at a quarter of the time (measured: no digit of indentation, relaxation time or slope
        # differs from rtol 1e-3 to 1e-9). Below it the stiff modes would be lost to roundoff of the
        # slowest
        gentlest = 1e-10
        return (
            max(float(np.diff(self.compliance.space.breakpoints).min()), self.earliest) > gentlest
        )

    @cached_property
    def modes(self) -> Modes:
        moments = self._moments
        # singular values would take minutes
        large = len(moments) > 700
        gentle = large or self.gentle
        if self.earliest and large:
            try:
                return excited_modes(
                    self._energy, self._mass_factor, self._forceless, moments, self.earliest
                )
            except TooEarlyError:
                # and hours; up to this they are taken where a history begins too early
                if len(moments) > 2500:
                    raise
                gentle = False
        return every_mode(
            self._energy, self._factor, self._mass_factor, self._forceless, moments, gentle
        )

    @property
    def share_of_modes(self) -> float:
        """The share of the flat start that the modes have, by the squares of what they displace.

        1 if none is lost.
        """
        moments = self._mass_factor.forward(self._moments)
        whole = moments @ moments
        if self._forceless is not None:
            steady = self._mass_factor.forward(self._forceless)
            whole -= (moments @ steady) ** 2 / (steady @ steady)
        return float(np.sum((self.modes.amplitudes * self.modes.relaxation) ** 2) / whole)

    @property
    def relaxation_times(self) -> Array:
        """(m,) slowest first."""
        return self.modes.relaxation[: self.modes.exact]

    @cached_property
    def slowest_times(self) -> Array:
        """(m,) the slowest of them, where no history is wanted."""
        return slowest_times(self._energy, self._mass_factor, self._forceless)

    def modal(self, times: Array) -> History:
        """Return the exact history from the flat start at any times from `earliest` on, none of
        which depends on another.
        """
        state, modes = self.loading.at(times), self.modes
        later = state.distance[state.distance > 0]
        if (later < self.earliest * (1 - 1e-12)).any():
            raise SceneError(
                f"prepared for distances from {self.earliest:.3g} on: give all of them"
            )
        # where the pressure, not the wear rate, is continuous: a flat press of its own
        pressed = self.loading.pressed(times)
        excited = modes.excite(self._at_knots[state.knot], state)
        excited -= np.outer(pressed, modes.amplitudes)
        flat, forces = np.zeros(self.compliance.space.size), state.force - pressed
        history = self._relaxed(state.distance, excited, forces, state.work, flat)
        history.profile[state.distance == 0] = 0.0
        return history.press(self.flat, pressed)

    @cached_property
    def _at_knots(self) -> Array:
        return self.modes.at_knots(self.loading)

    def from_full_contact(
        self, distances: Array, since: float, spent: float, unworn: Array, worn: Array
    ) -> History:
        """Return the exact history from where all of a shaped face carries, for as long as it does.

        Parameters
        ----------
        distances : (T,) array
            Sliding distances from `since` on, under the force 1.
        spent : float
            Integral of the force over the sliding distance by then.
        unworn, worn : (size,) arrays
            Moments of the unworn face, and of what had worn off at `since`.
        """
        modes, further = self.modes, distances - since
        moments = self._moments + self._to_pressure.T @ (unworn + worn)
        amplitudes = -(modes.shapes.T @ moments) / modes.relaxation
        excited = np.exp(-further[:, None] / modes.relaxation) * amplitudes
        return self._relaxed(distances, excited, np.ones(len(further)), spent + further, unworn)

    def _relaxed(
        self, distances: Array, excited: Array, forces: Array, work: Array, unworn: Array
    ) -> History:
        """Return the sum of the steady state of a force, or of no pressure, and of modes."""
        steady = self.steady
        rates = excited @ self.modes.shapes.T
        pressure = np.outer(forces, steady.pressure) + rates @ self._to_pressure.T
        if self.indentation is None:
            # reciprocity with the steady pressures, int p_s dA = 1: d = p_s . A p + int f p_s dA,
            # and what has worn, k p_s being one w, adds w int F dtau
            indentation = steady.wear_rate * work + pressure @ steady.moments
            indentation += np.sum(unworn * steady.pressure)
        else:
            indentation = self.indentation * forces
            forces = pressure @ self.compliance.space.weights
        # f = d - u: slopes of small elements would show the roundoff of a sum of what wore
        gap = np.outer(indentation, self._weights) - (
            (np.outer(forces, steady.moments) + unworn) @ self._to_pressure + rates @ self._energy
        )
        profile = self._mass_factor.solve(gap.T).T @ self._to_profile.T
        return History.in_full_contact(distances, pressure, profile, indentation, forces)

    @cached_property
    def _start(self) -> Array:
        """Unknowns of the flat start in the space of t > 0: the best approximation in energy."""
        solution = cho_solve(cho_factor(self._energy), self._weights)
        return solution * (self.indentation or 1 / (self._weights @ solution))

    def _loaded(self, state: Array, by_weights: Array) -> Array:
        """Return a state pressed on until it carries the force 1, if that is the load."""
        if self.indentation is not None:
            return state
        return state + by_weights * (1 - self._weights @ state) / (self._weights @ by_weights)

    def stability_limit(self) -> float:
        """Greatest stable step of the explicit march, twice the shortest relaxation time."""
        whole = replace(self, earliest=0.0) if self.earliest else self
        return float(2 * whole.relaxation_times[-1])

    def implicit(self, times: Array, step: float) -> History:
        """Implicit Euler, equal steps of at most `step` between output times: stable, first
        order.
        """
        energy, mass = self._energy, self._mass.toarray()

        def advance_by(dt: float) -> Advance:
            factor = cho_factor(energy + dt * mass)
            by_weights = cho_solve(factor, self._weights)
            return lambda state: self._loaded(cho_solve(factor, energy @ state), by_weights)

        return self._marched(times, step, advance_by, 1)

    def explicit(self, times: Array, step: float) -> History:
        """Explicit Euler (Eqs. 14 to 17), of first order, stable up to `stability_limit`.

        Raises
        ------
        SceneError
            if the step is above the stability limit
        """
        limit = self.stability_limit()
        if step > limit:
            raise SceneError(
                f"the explicit march is unstable: its step is {step / limit:.3g} times the "
                "stability limit; give a smaller "
                "wear.step, march = 'modal' (exact in time, no step), or the method mdr-grid, "
                "whose grid is coarse"
            )
        energy = cho_factor(self._energy)
        by_weights = cho_solve(energy, self._weights)
        rate = -cho_solve(energy, self._mass.toarray())
        if self.indentation is None:
            rate -= np.outer(by_weights, self._weights @ rate) / (self._weights @ by_weights)

        def advance_by(dt: float) -> Advance:
            return lambda state: state + dt * (rate @ state)

        return self._marched(times, step, advance_by, 0)

    def _marched(
        self, times: Array, step: float, advance_by: Callable[[float], Advance], wearing: int
    ) -> History:
        states, profiles = take_steps(times, step, advance_by, wearing, self._start)
        pressure, profile = states @ self._to_pressure.T, profiles @ self._to_profile.T
        indentation = np.full(len(times), self.indentation or 0.0)
        if self.indentation is None:
            # force balance against the steady pressures: d F = p_s . A p + int f p_s dA
            indentation = pressure @ self.steady.moments
            indentation += profiles @ (self._weights * self.steady.wear_rate)
        begun = (times > 0).astype(float)
        pressure, indentation = begun[:, None] * pressure, begun * indentation
        forces = pressure @ self.compliance.space.weights
        history = History.in_full_contact(times, pressure, profile, indentation, forces)
        return history.press(self.flat, 1 - begun)

    def history(self, times: Array, march: str = "modal", step: float | None = None) -> History:
        """The history by the named march."""
        if march == "modal" or step is None:
            return self.modal(times)
        return {"implicit": self.implicit, "explicit": self.explicit}[march](times, step)
