"""Archard's wear on any compliance, by modes or in steps (Eqs. 12 to 17). Non-dimensional.

In full contact the pressure is affine in the profile, and with the wear rate ``k p`` continuous
(which it is for every t > 0) the history obeys ``A p' = d' b - K p``, ``b . p = F``, with the mass
matrix `K` of weight `k`. Its deviation from the steady state decays in modes of the pencil (A, K)
on the pressures that carry no force, whose eigenvalues are the relaxation times. At a fixed
indentation ``A p' = -K p``: all pressures decay, in modes of the pencil on all of them. A flat
start never loses contact, so no inequality is enforced. Nor does a force that never falls, whose
rises are so many flat starts. Times of marches in steps are sliding distances.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, diags

from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.loading import Loading
from ..problem.marching import steps_between
from .flat_contact import FlatPress, FlatStart, SteadyState, flat_start, steady_state
from .history import History
from .modes import (
    BandedCholesky,
    Modes,
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

    @cached_property
    def modes(self) -> Modes:
        # of so many pressures, modes that the flat start does not excite are left out
        large = self.earliest and len(self._moments) > 700
        return (excited_modes if large else every_mode)(
            self._energy, self._mass_factor, self._forceless, self._moments, self.earliest
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
        state = self.loading.at(times)
        later = state.distance[state.distance > 0]
        if (later < self.earliest * (1 - 1e-12)).any():
            raise SceneError(
                f"prepared for distances from {self.earliest:.3g} on: give all of them"
            )
        return self._evolved(times, self.modes.excite(self._at_knots[state.knot], state))

    def _evolved(self, times: Array, excited: Array) -> History:
        """Return the history at times by what there is of each mode (T, m) then."""
        state = self.loading.at(times)
        # where the pressure, not the wear rate, is continuous: a flat press of its own
        pressed = self.loading.pressed(times)
        excited = excited - np.outer(pressed, self.modes.amplitudes)
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

    def stability_limit(self) -> float:
        """Greatest stable step of the explicit march, twice the shortest relaxation time."""
        return float(2 * self.relaxation_times[-1])

    def in_steps(self, times: Array, march: str, step: float) -> History:
        """Return the history by Euler's method, of first order, in equal steps between times.

        A step of length h multiplies what is left of a mode by ``1 / (1 + h / T)`` if it is
        implicit, by ``1 - h / T`` if it is explicit (Eqs. 14 to 17).

        Parameters
        ----------
        times : (T,) array
            Increasing, under one load.
        march : "implicit", which is always stable, or "explicit", up to `stability_limit`
        step : greatest length

        Raises
        ------
        SceneError
            if the explicit step is above the stability limit
        """
        counts = steps_between(times, step)
        limit = self.stability_limit()
        if march == "explicit" and step > limit:
            raise SceneError(
                f"the explicit march is unstable: its step is {step / limit:.3g} times the "
                "stability limit; give a smaller "
                "wear.step, march = 'modal' (exact in time, no step), or the method mdr-grid, "
                "whose grid is coarse"
            )
        lengths = np.diff(times, prepend=0.0) / np.maximum(counts, 1)
        ratios = lengths[:, None] / self.modes.relaxation
        factors = 1 / (1 + ratios) if march == "implicit" else 1 - ratios
        left = np.cumprod(factors ** counts[:, None], axis=0)
        return self._evolved(times, left * self.modes.amplitudes)

    def history(self, times: Array, march: str = "modal", step: float | None = None) -> History:
        """The history by the named march."""
        if march == "modal" or step is None:
            return self.modal(times)
        return self.in_steps(times, march, step)
