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
from ..sizes.marching import steps_between
from .flat_contact import FittedPress, FlatStart, SteadyState, flat_start
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
    """Compute the wear of a flat punch from its start to its steady state, at any time.

    A `RunningIn` combines a `Compliance` and the wear coefficients of its rings. `flat` is the
    start, ``d(0) = F / (2 a E*)``; `steady` the end, where the wear rate ``k p`` is ``F / sum_i
    (A_i / k_i)``; `modal` the history in between, exact in time.

    >>> from ringwear.mdr import energy
    >>> from ringwear.meshes.pressure_space import PressureSpace
    >>> edges = np.array([0.0, 0.5, 1.0])  # areas pi / 4 and 3 pi / 4
    >>> space = PressureSpace(np.array([0.0, 0.5, 0.9, 0.99, 1.0]), np.full(4, 8), edges)
    >>> wear = RunningIn(energy.compliance(space), wear_coefficients=np.array([1.0, 3.0]))
    >>> round(wear.flat.indentation, 4), round(wear.steady.wear_rate * np.pi, 9)
    (0.5, 2.0)

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
        """The state that wear tends to: known without any march, its ring forces add up to one."""
        space, wear_coefficients = self.compliance.space, self.wear_coefficients
        if self.indentation is not None:
            nothing = np.zeros(space.size)
            return SteadyState(nothing, nothing, nothing, 0.0)
        if wear_coefficients.ndim == 2:
            # 1 / k is no polynomial: the pressure whose product with k is nearest to a constant
            pressure = self._to_pressures(self._weights)
        else:
            # a hole has no pressure
            pressure = space.ring_indicator() @ (1 / wear_coefficients[int(space.hollow) :])
        wear_rate = float(1 / (space.weights @ pressure))
        pressure = wear_rate * pressure
        moments = self.compliance.factor.T @ (self.compliance.factor @ pressure)
        displacement = self._to_profiles(self._reduce(moments))
        return SteadyState(pressure, displacement, moments, wear_rate)

    @cached_property
    def flat(self) -> FlatStart | FittedPress:
        """The unworn punch, pressed by the force 1 or to the indentation that is held fixed."""
        return flat_start(self.compliance, self.indentation)

    @cached_property
    def _by_rates(self) -> csr_matrix:
        """(size, n) pressures by the wear rate."""
        space = self.compliance.space
        if self.continuous:
            return space.joined(self.wear_coefficients)
        return diags(1 / space.at_vertices(self.wear_coefficients)).tocsr()

    @cached_property
    def _worn_by_rates(self) -> csr_matrix | Array:
        """(size, n) wear rates, and so worn profiles, by the same unknowns."""
        space = self.compliance.space
        if self.continuous and self.wear_coefficients.ndim == 2:
            # k p is of a degree more than p: its projection has the same volumes on rings
            worn = space.mass(self.wear_coefficients) @ self._by_rates
            return BandedCholesky(space.mass()).solve(worn.toarray())
        return space.joined() if self.continuous else diags(np.ones(space.size)).tocsr()

    @cached_property
    def _mass(self) -> BandedCholesky:
        """Factor `L` of the mass matrix of weight k.

        Orthonormal wear rates are `L^T` times the wear rates by unknowns of the space.
        """
        mass = self.compliance.space.mass(self.wear_coefficients)
        return BandedCholesky(self._by_rates.T @ mass @ self._by_rates)

    def _reduce(self, moments: Array) -> Array:
        """Return moments (n, ...) against orthonormal wear rates, of (size, ...) ones."""
        return self._mass.forward(self._by_rates.T @ moments)

    def _to_pressures(self, rates: Array) -> Array:
        """Return pressures (..., size) by orthonormal wear rates (..., n)."""
        return np.asarray(self._mass.backward(rates.T).T @ self._by_rates.T)

    def _to_profiles(self, rates: Array) -> Array:
        """Return what wears by them, (..., size)."""
        return np.asarray(self._mass.backward(rates.T).T @ self._worn_by_rates.T)

    @cached_property
    def _energy(self) -> Array:
        return self._reduce(self._reduce(self.compliance.matrix).T)

    @cached_property
    def _weights(self) -> Array:
        return self._reduce(self.compliance.space.weights)

    @property
    def _forceless(self) -> Array | None:
        """The weights of force, where modes carry none of it."""
        return self._weights if self.indentation is None else None

    @cached_property
    def _moments(self) -> Array:
        """(n,) by how much less the flat start displaces than the state that wear tends to."""
        pressed_in = (self.indentation or 0.0) * self.compliance.space.weights
        return self._reduce(self.steady.moments - pressed_in)

    @cached_property
    def modes(self) -> Modes:
        """Relaxation modes, slowest first, with what the flat start has of each.

        If there are many pressures and an earliest time, only the modes that the flat start excites
        are computed.

        Raises
        ------
        TooEarlyError
            if modes below roundoff are still felt at the earliest time, and there are too many
            pressures for singular values to keep them
        """
        pencil = self._forceless, self._moments, self.earliest
        # of so many pressures, modes that the flat start does not excite are left out
        if self.earliest and len(self._moments) > 700:
            try:
                return excited_modes(self._energy, *pencil)
            except TooEarlyError:
                # singular values would take hours
                if len(self._moments) > 2500:
                    raise
        return every_mode(self._energy, self._factor, *pencil)

    def _factor(self) -> Array:
        return self._reduce(self.compliance.factor.T).T

    @property
    def whole_change(self) -> float:
        """The change from the flat start to the steady state, of which modes tell what is left.

        It is that of the approach less steady wear, or ``d F(0)`` at a fixed indentation. A space
        that suits late times misses the fastest modes, but not their sum, which is known from both
        ends: ``p_s . A p_s - d(0)`` with the steady pressures p_s.
        """
        if self.indentation is not None:
            return self.indentation * float(
                self.flat.ring_forces(np.array([self.compliance.space.inner_radius, 1.0])).sum()
            )
        return float(self.steady.pressure @ self.steady.moments) - self.flat.indentation

    def time_until(self, part: float) -> float:
        """Return the time from which no more than this part of the whole change is left."""
        return self.modes.time_until(part * self.whole_change)

    @property
    def share_of_modes(self) -> float:
        """The share of the flat start that the modes have, by the squares of what they displace.

        1 if none is lost.
        """
        moments, weights = self._moments, self._weights
        whole = moments @ moments
        if self.indentation is None:
            whole -= (moments @ weights) ** 2 / (weights @ weights)
        return float(np.sum((self.modes.amplitudes * self.modes.relaxation) ** 2) / whole)

    @property
    def relaxation_times(self) -> Array:
        """(m,) slowest first."""
        return self.modes.relaxation[: self.modes.exact]

    @cached_property
    def slowest_times(self) -> Array:
        """(m,) the slowest of them, where no history is wanted."""
        return slowest_times(self._energy, self._forceless)

    def modal(self, times: Array) -> History:
        """Return the exact history from the flat start at any times from `earliest` on.

        None of the times depends on another.

        Raises
        ------
        SceneError
            if a time after the start is before `earliest`
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
        self, distances: Array, since: float, spent: float, unworn: Array, worn: Array, force: float
    ) -> History:
        """Return the exact history from where all of a shaped face carries, for as long as it does.

        Parameters
        ----------
        distances : (T,) array
            Sliding distances from `since` on.
        spent : float
            Integral of the force over the sliding distance by then.
        unworn, worn : (size,) arrays
            Moments of the unworn face, and of what had worn off at `since`.
        force : float
            On it; 1 at a fixed indentation.
        """
        modes, further = self.modes, distances - since
        moments = force * self._moments + self._reduce(unworn + worn)
        amplitudes = -(modes.shapes.T @ moments) / modes.relaxation
        excited = np.exp(-further[:, None] / modes.relaxation) * amplitudes
        forces = np.full(len(further), force)
        return self._relaxed(distances, excited, forces, spent + force * further, unworn)

    def _relaxed(
        self, distances: Array, excited: Array, forces: Array, work: Array, unworn: Array
    ) -> History:
        """Return the sum of the steady state of a force, or of no pressure, and of modes."""
        steady = self.steady
        rates = excited @ self.modes.shapes.T
        pressure = np.outer(forces, steady.pressure) + self._to_pressures(rates)
        if self.indentation is None:
            # reciprocity with the steady pressures, int p_s dA = 1: d = p_s . A p + int f p_s dA,
            # and what has worn, k p_s being one w, adds w int F dtau
            indentation = steady.wear_rate * work + pressure @ steady.moments
            indentation += np.sum(unworn * steady.pressure)
        else:
            indentation = self.indentation * forces
            forces = pressure @ self.compliance.space.weights
        # f = d - u: slopes of small elements would show the roundoff of a sum of what wore
        gap = np.outer(indentation, self._weights) - rates @ self._energy
        gap -= np.outer(forces, self._reduce(steady.moments)) + self._reduce(unworn)
        profile = self._to_profiles(gap)
        return History.in_full_contact(distances, pressure, profile, indentation, forces)

    def stability_limit(self) -> float:
        """Return the greatest stable step of the explicit march.

        It is twice the shortest relaxation time.
        """
        return float(2 * self.relaxation_times[-1])

    def history(self, times: Array, march: str = "modal", step: float | None = None) -> History:
        """Return the history by the named march.

        Euler's methods, of first order, take equal steps between times, under one load. A step of
        length h multiplies what is left of a mode by ``1 / (1 + h / T)`` if it is implicit, by ``1
        - h / T`` if it is explicit (Eqs. 14 to 17).

        Parameters
        ----------
        times : (T,) array
            Increasing.
        march : "modal", "implicit", which is always stable, or "explicit", up to `stability_limit`
        step : greatest length

        Raises
        ------
        SceneError
            if the explicit step is above the stability limit
        """
        if march == "modal" or step is None:
            return self.modal(times)
        limit = self.stability_limit()
        if march == "explicit" and step > limit:
            raise SceneError(
                f"the explicit march is unstable: its step is {step / limit:.3g} times the "
                "stability limit; give a smaller "
                "wear.step, march = 'modal' (exact in time, no step), or the method mdr-grid, "
                "whose grid is coarse"
            )
        counts = steps_between(times, step)
        lengths = np.diff(times, prepend=0.0) / np.maximum(counts, 1)
        ratios = lengths[:, None] / self.modes.relaxation
        factors = 1 / (1 + ratios) if march == "implicit" else 1 - ratios
        left = np.cumprod(factors ** counts[:, None], axis=0)
        return self._evolved(times, left * self.modes.amplitudes)
