"""Compute Archard wear in full contact for any compliance, by modes or in steps (Eqs. 12 to 17).

Non-dimensional. In full contact the pressure is affine in the profile. The wear rate ``k p`` is
continuous for every t > 0, and the history obeys ``A p' = d' b - K p``, ``b . p = F``, with the
mass matrix `K` of weight `k`. The deviation from the steady state decays in modes of the pencil (A,
K) on the pressures that carry no force; the eigenvalues are the relaxation times. At a fixed
indentation ``A p' = -K p``: the whole pressure decays, in modes of the pencil on all pressures.

No inequality is enforced, because a punch that starts flat never loses contact. This also holds
under a force that never falls, because each increase acts as another flat start. Under a force that
falls, it holds if the fall is slow enough for the wear
(`studies/crosscheck/wear/falling_force.py`). In the marches by steps, times are sliding distances.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.linalg.blas import dsymv
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from ....meshes.compliance import Compliance
from ....meshes.errors import SceneError
from ....meshes.pressure_space import BandedCholesky
from ....meshes.radial import Array
from ..problem.loading import Loading
from .flat_contact import FittedPress, FlatStart, SteadyState, flat_start
from .history import History
from .modes import (
    ACCURATE,
    DECAYED,
    Modes,
    TooEarlyError,
    every_mode,
    excited_modes,
    slowest_times,
)
from .step_control import steps_between

# relative difference of displacements at the start and in the steady state below which it is
# roundoff
SAME_STATE = 1e-7


@dataclass(frozen=True, eq=False)
class RunningIn:
    """Compute the wear of a flat punch from its start to its steady state, at any time.

    A `RunningIn` combines a `Compliance` and the wear coefficients of its rings. `flat` is the
    start with ``d(0) = F / (2 a E*)``. `steady` is the end with the wear rate ``k p = F / sum_i
    (A_i / k_i)``. `modal` returns the history in between, exact in time.

    >>> from ringwear.mdr import energy
    >>> from ringwear.meshes.pressure_space import PressureSpace
    >>> edges = np.array([0.0, 0.5, 1.0])  # areas pi / 4 and 3 pi / 4
    >>> space = PressureSpace(np.array([0.0, 0.5, 0.9, 0.99, 1.0]), np.full(4, 8), edges)
    >>> wear = RunningIn(energy.compliance(space), wear_coefficients=np.array([1.0, 3.0]))
    >>> round(wear.flat.indentation, 4), round(wear.steady.wear_rate * np.pi, 9)
    (0.5, 2.0)

    Parameters
    ----------
    compliance : Compliance
        Compliance of the half-space on a pressure space.
    wear_coefficients : (N,) or (2, N) array
        Wear coefficient of each ring of that space; or those at the inner and outer edge of each
        ring, linear between.
    earliest : float
        Positive sliding distance before which no history is computed, so that a problem with many
        unknowns needs only some of its modes. 0 means that all modes are computed.
    continuous : bool
        Whether the wear rate is continuous at ring edges, as after a flat start. If not, it may
        jump there, and the space has degree 1.
    indentation : float, optional
        Fixed indentation instead of the force 1. The pressure then decays to zero.
    loading : Loading
        Force and sliding speed over time, for `modal`.
    """

    compliance: Compliance
    wear_coefficients: Array
    earliest: float = 0.0
    continuous: bool = True
    indentation: float | None = None
    loading: Loading = field(default_factory=Loading)

    @cached_property
    def _at_edges(self) -> Array:
        """(2, N) wear coefficients at the inner and outer edge of each ring."""
        count = len(self.compliance.space.ring_edges) - 1
        return np.broadcast_to(self.wear_coefficients, (2, count))

    @property
    def _linear(self) -> bool:
        """Whether the wear coefficient varies on a ring."""
        inner, outer = self._at_edges
        return bool((inner != outer).any())

    @cached_property
    def steady(self) -> SteadyState:
        """The steady state of wear, computed without a march; its ring forces sum to 1."""
        space = self.compliance.space
        if self.indentation is not None:
            zero = np.zeros(space.size)
            return SteadyState(zero, zero, zero, 0.0)
        if self._linear:
            # 1 / k is not a polynomial: take the pressure whose product with k is nearest to a
            # constant
            pressure = self._pressures_from_rates(self._weights)
        else:
            pressure = space.ring_indicator() @ (1 / self._at_edges[0])
        wear_rate = float(1 / (space.weights @ pressure))
        pressure = wear_rate * pressure
        moments = self.compliance.factor.T @ (self.compliance.factor @ pressure)
        displacement = self._project_profiles(self._reduce(moments))
        return SteadyState(pressure, displacement, moments, wear_rate)

    @cached_property
    def flat(self) -> FlatStart | FittedPress:
        """The unworn punch, under the force 1 or at the fixed indentation."""
        return flat_start(self.compliance, self.indentation)

    @cached_property
    def _rates_to_pressures(self) -> csr_matrix:
        """(size, n) matrix from unknowns of the wear rate to pressures."""
        space = self.compliance.space
        if self.continuous:
            return space.joined(self.wear_coefficients)
        return diags(1 / space.at_vertices(self.wear_coefficients)).tocsr()

    @cached_property
    def _rates_to_profiles(self) -> csr_matrix:
        """(size, n) matrix from unknowns of the wear rate to coefficients of worn profiles."""
        space = self.compliance.space
        return space.joined() if self.continuous else diags(np.ones(space.size)).tocsr()

    @cached_property
    def _mass(self) -> BandedCholesky:
        """Cholesky factor `L` of the mass matrix of weight k on the unknowns of the wear rate.

        The orthonormal coordinates of a wear rate are `L^T` times its unknowns.
        """
        mass = self.compliance.space.mass(self.wear_coefficients)
        return BandedCholesky(self._rates_to_pressures.T @ mass @ self._rates_to_pressures)

    def _reduce(self, moments: Array) -> Array:
        """Return moments (n, ...) in orthonormal coordinates from (size, ...) ones."""
        return self._mass.forward(self._rates_to_pressures.T @ moments)

    def _pressures_from_rates(self, rates: Array) -> Array:
        """Return pressures (..., size) from wear rates in orthonormal coordinates (..., n)."""
        return self._mass.backward(rates.T).T @ self._rates_to_pressures.T

    @property
    def _continuous_mass(self) -> SuperLU:
        """Triangular factors of the mass matrix of continuous profiles against pressures, (n, n).

        The pressures are those whose product with the wear coefficient is continuous. The factors
        are made anew each time: they take little, and cannot be passed to another process.
        """
        space = self.compliance.space
        mass = self._rates_to_pressures.T @ space.mass() @ self._rates_to_profiles
        return splu(mass.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0)

    def _project_profiles(self, moments: Array) -> Array:
        """Return worn profiles (..., size) from their moments (..., n) in orthonormal coordinates.

        If k is constant on rings, the profile is k times a pressure of the space. If k is linear,
        it is the continuous function of the space with these moments: k times a polynomial would
        not contain constants, and its slope would be wrong by far where k is steep.
        """
        if self.continuous and self._linear:
            coefficients = self._continuous_mass.solve(self._mass.multiply(moments.T))
        else:
            coefficients = self._mass.backward(moments.T)
        return coefficients.T @ self._rates_to_profiles.T

    def _profiles_from_moments(self, moments: Array) -> Array:
        """Return worn profiles (T, size) from their moments (T, n) in orthonormal coordinates.

        Their mean depths are added as exact constants, whose slope is zero. Otherwise the slope of
        a face that has worn evenly would be roundoff divided by the smallest element.
        """
        uniform_rate = self._weights
        mean_depths = moments @ uniform_rate / (uniform_rate @ uniform_rate)
        varying = self._project_profiles(moments - np.outer(mean_depths, uniform_rate))
        return varying + np.outer(mean_depths, self.compliance.space.uniform)

    @cached_property
    def _energy(self) -> Array:
        return self._reduce(self._reduce(self.compliance.matrix).T)

    def _moments_of_rates(self, rates: Array) -> Array:
        """Return the moments (n,) of the displacement under wear rates (n,), both orthonormal.

        It is the product of `_energy` with the rates, without the time and memory that `_energy`
        takes.
        """
        pressure = self._pressures_from_rates(rates)
        # the matrix is symmetric, and its transpose is ordered as the routine needs it
        return self._reduce(dsymv(1.0, self.compliance.matrix.T, pressure))

    @cached_property
    def _weights(self) -> Array:
        return self._reduce(self.compliance.space.weights)

    @property
    def _force_weights(self) -> Array | None:
        """(n,) force of each orthonormal wear rate; None at a fixed indentation."""
        return self._weights if self.indentation is None else None

    @cached_property
    def _moments(self) -> Array:
        """(n,) moments of the displacement in the steady state, less those in the flat start.

        The displacement of the flat start is uniform. Under a force it is omitted, because it does
        no work on modes that carry no force.
        """
        start_moments = (self.indentation or 0.0) * self.compliance.space.weights
        return self._reduce(self.steady.moments - start_moments)

    @cached_property
    def modes(self) -> Modes:
        """Relaxation modes, slowest first, with their amplitudes in the flat start.

        If there are more than 700 unknowns and `earliest` is positive, only the modes that the flat
        start excites are computed.

        Raises
        ------
        TooEarlyError
            if modes below roundoff still contribute at the earliest distance, and there are too
            many unknowns to compute these modes by singular values
        """
        pencil = self._force_weights, self._moments, self.earliest
        # with so many unknowns, the modes that the flat start does not excite are omitted
        if self.earliest and len(self._moments) > 700:
            # singular values of larger matrices would take hours
            too_many = len(self._moments) > 2500
            try:
                return excited_modes(
                    self._moments_of_rates, *pencil, DECAYED if too_many else ACCURATE
                )
            except TooEarlyError:
                if too_many:
                    raise
        return every_mode(self._energy, self._factor, *pencil)

    def _factor(self) -> Array:
        return self._reduce(self.compliance.factor.T).T

    @property
    def total_change(self) -> float:
        """The change of d(t) minus the steady wear, from the flat start to the steady state.

        At a fixed indentation it is ``d F(0)``. A space chosen for late times does not resolve the
        fastest modes, so the sum over the modes is too small. The change is therefore computed from
        its two ends, ``p_s . A p_s - d(0)`` with the steady pressure p_s.
        """
        if self.indentation is not None:
            return self.indentation * float(
                self.flat.ring_forces(np.array([self.compliance.space.inner_radius, 1.0])).sum()
            )
        return float(self.steady.pressure @ self.steady.moments) - self.flat.indentation

    def time_until(self, fraction: float) -> float:
        """Return the time at which the remaining change falls to a fraction of `total_change`."""
        return self.modes.time_until(fraction * self.total_change)

    @property
    def resolved_fraction(self) -> float:
        """The fraction of the flat start that the modes contain, in squares of displacements.

        It is 1 if no mode is missing, or if the start is the steady state, which excites none.
        """
        excited, weights = self._moments, self._weights
        if self.indentation is None:
            excited = excited - (excited @ weights) / (weights @ weights) * weights
        if np.linalg.norm(excited) <= SAME_STATE * np.linalg.norm(self._moments):
            return 1.0
        contained = np.sum((self.modes.amplitudes * self.modes.relaxation) ** 2)
        return float(contained / (excited @ excited))

    @property
    def relaxation_times(self) -> Array:
        """(m,) relaxation times of the converged modes, slowest first."""
        return self.modes.relaxation[: self.modes.exact]

    @cached_property
    def slowest_times(self) -> Array:
        """(m,) slowest relaxation times, computed without the modes."""
        return slowest_times(self._energy, self._force_weights)

    def modal(self, times: Array) -> History:
        """Return the exact history from the flat start, at the start and at any times after it.

        The result at each time does not depend on the other times.

        Raises
        ------
        SceneError
            if the sliding distance at a time after the start is below `earliest`
        """
        state = self.loading.at(times)
        later = state.distance[state.distance > 0]
        if (later < self.earliest * (1 - 1e-12)).any():
            raise SceneError(
                f"the modes are computed for sliding distances from {self.earliest:.3g} on: give a "
                "smaller `earliest`, or later times"
            )
        return self.from_amplitudes(
            times, self.modes.excite(self._knot_amplitudes[state.knot], state)
        )

    def from_amplitudes(self, times: Array, amplitudes: Array) -> History:
        """Return the history at times (T,), given the amplitude of each mode (T, m) at these.

        A march in steps may have any amplitudes; those of the exact history are in `modal`.
        """
        state = self.loading.at(times)
        # force applied since the punch last slid: its k p still jumps at ring edges, so this part
        # of the pressure is that of the flat start instead of a sum of modes
        force_rise = self.loading.force_rise_at_rest(times)
        amplitudes = amplitudes - np.outer(force_rise, self.modes.amplitudes)
        zero, forces = np.zeros(self.compliance.space.size), state.force - force_rise
        even_wear = self.steady.wear_rate * state.work
        history = self.steady_plus_modes(times, state.distance, amplitudes, forces, even_wear, zero)
        history.shape[state.distance == 0] = 0.0
        return history.press(self.flat, force_rise)

    @cached_property
    def _knot_amplitudes(self) -> Array:
        return self.modes.at_knots(self.loading)

    def steady_plus_modes(
        self,
        times: Array,
        distances: Array,
        amplitudes: Array,
        forces: Array,
        even_wear: Array,
        unworn: Array,
    ) -> History:
        """Return the steady state under a force, or without pressure, plus a sum of modes.

        Parameters
        ----------
        times, distances : (T,) arrays
            Times, and sliding distances until then.
        amplitudes : (T, m) array
            Amplitude of each mode.
        forces : (T,) array
            Force. At a fixed indentation, factors of the indentation.
        even_wear : (T,) array
            Depth by which the whole face has worn at the steady rate; 0 at a fixed indentation.
        unworn : (size,) array
            Moments of the unworn face.
        """
        steady = self.steady
        varying = self._pressures_from_rates(amplitudes @ self.modes.shapes.T)
        pressure = np.outer(forces, steady.pressure) + varying
        if self.indentation is None:
            # reciprocity with the steady pressure p_s, int p_s dA = 1, gives d = p_s . A p + int f
            # p_s dA; the worn part of f contributes w int F dtau, because k p_s = w is constant,
            # and that is the even wear
            depth: Array = pressure @ steady.moments + np.sum(unworn * steady.pressure)
        else:
            depth = self.indentation * forces
            forces = pressure @ self.compliance.space.weights
        # the profile is f = d - u; the slope of a sum of worn depths has more roundoff on small
        # elements
        gap = np.outer(depth, self._weights) - self._reduce(self.compliance.matrix @ varying.T).T
        gap -= np.outer(forces, self._reduce(steady.moments)) + self._reduce(unworn)
        shape = self._profiles_from_moments(gap)
        uniform = self.compliance.space.uniform
        return History.in_full_contact(
            times, distances, pressure, shape, depth, forces, even_wear, uniform
        )

    def amplitudes_of_face(self, moments: Array) -> Array:
        """Return the amplitude of each mode (m,) in full contact that the shape of a face makes.

        `moments` (size,) are those of the face; the amplitudes do not depend on its height.
        """
        modes = self.modes
        return -(modes.shapes.T @ self._reduce(moments)) / modes.relaxation

    def pressures_of_modes(self, amplitudes: Array) -> Array:
        """Return the pressures (..., size) that are sums of modes with amplitudes (..., m)."""
        return self._pressures_from_rates(amplitudes @ self.modes.shapes.T)

    def stability_limit(self) -> float:
        """Return the greatest stable step of the explicit march.

        It is twice the shortest relaxation time.
        """
        return float(2 * self.relaxation_times[-1])

    def history(self, times: Array, march: str = "modal", step: float | None = None) -> History:
        """Return the history computed by the named march.

        Euler's methods have first order and take equal steps between the times, under a constant
        load. A step of length h multiplies the amplitude of a mode with relaxation time T by ``1 /
        (1 + h / T)`` if the march is implicit, and by ``1 - h / T`` if it is explicit (Eqs. 14 to
        17).

        Parameters
        ----------
        times : (T,) array
            Increasing times.
        march : str
            "modal"; "implicit", which is always stable; or "explicit", which is stable up to
            `stability_limit`.
        step : float, optional
            Greatest length of a step.

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
        decay_factors = np.cumprod(factors ** counts[:, None], axis=0)
        return self.from_amplitudes(times, decay_factors * self.modes.amplitudes)
