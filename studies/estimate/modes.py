"""Solve a flat punch by modes, for any wear coefficients on one discretisation, with derivatives.

The compliance `A` does not depend on wear. With the mass matrix ``K = sum_j c_j K_j`` of the
pressures, weighted by the wear coefficient, the history obeys ``A p' = d' b - K p`` with ``b . p =
F``. For each new c, only a Cholesky factor and one symmetric eigenproblem are computed. The
derivative by ln c_j is exact, too: the wear that a change of c_j adds at the time s acts like a
unit force from then on, so that by reciprocity

    d d(T) / d ln c_j = int_0^T ds int c_j k_j(r) p(r, T - s) p(r, s) dA,

with the pressure p under the unit force, and with the shape k_j(r) whose multiple c_j k_j is the
contribution of c_j to the wear coefficient. At a fixed indentation d, the force has this
derivative, divided by -d. Pressures are sums of exponentials, and the integral over s is a divided
difference of these. Non-dimensional, in the units of the problem.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import csr_matrix

from ...mdr import energy
from ...meshes import Array, BandedCholesky, Compliance, Indices, PressureSpace, ring_of
from ..crosscheck import (
    Modes,
    Problem,
    Rings,
    choose_spaces,
    covering,
    every_mode,
    flat_start,
)

# factor by which the discretisation covers earlier and later times than the data, so that it also
# suits wear coefficients that are larger or smaller by this factor
TIME_SPAN = 30.0
# least ratio of the wear coefficients of neighbouring rings that the discretisation covers
WEAR_RATIO = 10.0
# modes that contribute less than this part to d(t) are left out of its derivatives
NEGLIGIBLE = 1e-7
ALL = ("pressure", "profile", "displacement", "indentation", "normal_force", "worn_volume")


@lru_cache(maxsize=512)
def _basis(space: PressureSpace, radii: bytes) -> csr_matrix:
    return space.matrix(np.frombuffer(radii))


@dataclass(frozen=True, eq=False)
class FlatHistories:
    """A discretised flat punch whose J wear coefficients are free.

    Parameters
    ----------
    compliance : of the half-space
    wear_shapes : J arrays (2, N): the shape k_j of each coefficient at both ends of the N rings of
        the pressure space
    scene_rings : (N,) index of the scene's ring in which each ring of that space lies
    """

    compliance: Compliance
    wear_shapes: tuple[Array, ...]
    scene_rings: Indices

    @classmethod
    def discretise(
        cls,
        problem: Problem,
        earliest: float,
        latest: float,
        fields: bool,
        table_radii: Array | None = None,
    ) -> "FlatHistories":
        """Return the discretisation for the times of the data and the `rtol` of a problem.

        Parameters
        ----------
        problem : with `rtol`, and with the wear coefficients of the scene
        earliest, latest : first and last time of the data after the start
        fields : whether profiles or volumes are predicted, not only the indentation
        table_radii : (J,) radii of the table of wear coefficients, if wear is graded
        """
        quantities = {"indentation", "profile"} if fields else {"indentation"}
        times = np.array([earliest / TIME_SPAN, latest * TIME_SPAN])
        problem = replace(problem, times=times, steady=False, quantities=frozenset(quantities))
        if problem.graded and table_radii is not None:
            rings = problem.graded
            covered: Problem = replace(problem, graded=_with_unequal_knots(rings))
            wear_shapes = _hats(table_radii, rings)
        else:
            rings = problem.rings
            covered = covering(_with_contrasts(problem))
            wear_shapes = [np.tile(row, (2, 1)) for row in np.eye(len(rings.widths))]
        middles = (rings.ring_edges[1:] + rings.ring_edges[:-1]) / 2
        scene_rings = ring_of(problem.ring_edges, middles)
        compliance = energy.compliance(choose_spaces(covered).fine, covered.ground)
        return cls(compliance, tuple(wear_shapes), scene_rings)

    @cached_property
    def masses(self) -> tuple[csr_matrix, ...]:
        """J mass matrices K_j, with the weight k_j."""
        return tuple(self.compliance.space.mass(shape) for shape in self.wear_shapes)

    @cached_property
    def volumes(self) -> Array:
        """(rings, J, size) worn volumes by ring of the scene, wear coefficient and basis function.

        For wear coefficients c, and coefficients P of the pressure integrated over the sliding
        distance, the volumes of the rings are ``sum_j c_j volumes[:, j] @ P``.
        """
        space, count = self.compliance.space, int(self.scene_rings.max()) + 1
        rows = [
            [
                space.uniform @ space.mass(shape * (self.scene_rings == ring))
                for shape in self.wear_shapes
            ]
            for ring in range(count)
        ]
        return np.array(rows)

    def basis(self, radii: Array) -> csr_matrix:
        """Return the matrix (R, size) from coefficients to values at radii (R,)."""
        return _basis(self.compliance.space, radii.tobytes())

    def wear_shapes_at(self, radii: Array) -> Array:
        """Return the shapes k_j (J, R) at radii (R,)."""
        edges = self.compliance.space.ring_edges
        number = ring_of(edges, radii)
        fraction = (radii - edges[number]) / np.diff(edges)[number]
        return np.array(
            [
                shape[0, number] + (shape[1] - shape[0])[number] * fraction
                for shape in self.wear_shapes
            ]
        )

    def solve(
        self, problem: Problem, coefficients: Array, earliest: float, machine: float = 0.0
    ) -> "FlatHistory":
        """Return the history under the load of a problem.

        Parameters
        ----------
        coefficients : (J,) wear coefficients, over their unit in the problem
        earliest : first sliding distance at which the history is evaluated
        machine : compliance of the machine. If the indentation is prescribed, that of the punch and
            the machine together is, which adds ``machine b b^T`` to A. Under a force it only adds
            to the reading, and has no effect here
        """
        weighted = sum(c * mass for c, mass in zip(coefficients, self.masses, strict=True))
        mass = BandedCholesky(csr_matrix(weighted))
        energy = mass.forward(mass.forward(self.compliance.matrix).T)
        weights = mass.forward(self.compliance.space.weights)
        if problem.indentation is not None:
            energy = energy + machine * np.outer(weights, weights)
        steady = weights / (weights @ weights)
        indentation = problem.indentation
        moments = energy @ steady if indentation is None else -indentation * weights
        modes = every_mode(
            energy,
            lambda: mass.forward(self.compliance.factor.T).T,
            weights if indentation is None else None,
            moments,
            earliest,
        )
        return FlatHistory(self, problem, coefficients, mass, energy, weights, steady, modes)


@dataclass(frozen=True, eq=False)
class FlatHistory:
    """The history of a flat punch for given wear coefficients, with exact derivatives.

    Vectors of length n are in coordinates in which the mass matrix of weight k is the identity.

    Parameters
    ----------
    punch : its discretisation
    problem : whose load and units are used
    coefficients : (J,) wear coefficients, over their unit in the problem
    mass : Cholesky factor of the mass matrix of weight k
    energy : (n, n) compliance
    weights : (n,) force of each pressure function
    steady : (n,) steady pressure under the force 1
    modes : relaxation modes
    """

    punch: FlatHistories
    problem: Problem
    coefficients: Array
    mass: BandedCholesky
    energy: Array
    weights: Array
    steady: Array
    modes: Modes

    def states(self, times: Array, step: float = 0.0) -> tuple[Array, Array, Array]:
        """Return pressures (T, n), indentations (T,) and forces (T,) at times (T,).

        Under a constant load they may have the errors of steps of first order, of which one ends at
        each of the times. An implicit step h divides the amplitude of a mode with relaxation time T
        by ``1 + h / T``; between times that are closer than h, the step is their distance. Explicit
        steps (h < 0) have about the opposite error, also where they would be unstable.
        """
        state, modes = self.problem.loading.at(times), self.modes
        if self.problem.loading.varies:
            excited = modes.excite(modes.at_knots(self.problem.loading)[state.knot], state)
        else:
            decay = np.exp(-state.distance[:, None] / modes.relaxation)
            if step:
                parts = np.diff(state.distance, prepend=0.0)[:, None]
                steps = np.clip(parts, 1e-300, abs(step))
                implicit = np.cumsum(parts * np.log1p(steps / modes.relaxation) / steps, axis=0)
                decay += np.sign(step) * (np.exp(-implicit) - decay)
            excited = modes.amplitudes * decay
        pressures = excited @ self.modes.shapes.T
        if self.problem.indentation is not None:
            indentations = np.full(len(times), self.problem.indentation)
            return pressures, indentations, pressures @ self.weights
        pressures += np.outer(state.force, self.steady)
        rate = float(1 / (self.weights @ self.weights))
        # by reciprocity with the steady pressures
        depth = rate * state.work + pressures @ (self.energy @ self.steady)
        return pressures, depth, state.force

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ALL
    ) -> dict[str, Array]:
        """Return quantities by name: fields (T, R), numbers (T,), and volumes of rings (T, rings).

        Parameters
        ----------
        times, radii : (T,) and (R,)
        step : of first order, as in `states`
        names : of the quantities that are wanted
        """
        pressures, depths, forces = self.states(times, step)
        results = {"indentation": depths, "normal_force": forces}
        unworn = self.problem.loading.at(times).distance == 0
        if {"profile", "displacement", "worn_volume"} & {*names}:
            integrals = self.pressure_integrals(pressures, depths)
            # what is not worn yet is exactly 0, not roundoff
            integrals[unworn] = 0.0
            if "worn_volume" in names:
                results["worn_volume"] = self.worn_volumes(integrals)
            results["profile"] = self.profiles(integrals, radii)
            results["displacement"] = depths[:, None] - results["profile"]
        if "pressure" in names:
            basis = self.punch.basis(radii)
            results["pressure"] = np.asarray((basis @ self.mass.backward(pressures.T)).T)
            if unworn.any():
                # infinite at the rim, so that the space does not contain it
                start = flat_start(self.punch.compliance)
                results["pressure"][unworn] = np.outer(forces[unworn], start.pressure_at(radii))
        return results

    def pressure_integrals(self, pressures: Array, depths: Array) -> Array:
        """Return integrals P (T, n) of the pressure over the sliding distance: K P = d b - A p."""
        return np.outer(depths, self.weights) - pressures @ self.energy

    def profiles(self, integrals: Array, radii: Array) -> Array:
        """Return worn heights (T, R) from integrals of the pressure (T, n), at radii (R,)."""
        basis = self.punch.basis(radii)
        wear = self.coefficients @ self.punch.wear_shapes_at(radii)
        return (basis @ self.mass.backward(integrals.T)).T * wear

    def worn_volumes(self, integrals: Array) -> Array:
        """Return worn volumes (T, rings) from integrals of the pressure (T, n)."""
        by_ring = np.einsum("j,rjn->rn", self.coefficients, self.punch.volumes)
        return (by_ring @ self.mass.backward(integrals.T)).T

    @cached_property
    def _exponentials(self) -> tuple[Array, Array]:
        """Rates (e,) and pressures (n, e) of the exponentials whose sum is the history.

        Under a force, the first one is the steady pressure, with the rate 0.
        """
        shapes = self.modes.shapes * self.modes.amplitudes
        rates = 1 / self.modes.relaxation
        if self.problem.indentation is not None:
            return rates, shapes
        return np.append(0.0, rates), np.column_stack([self.steady, shapes])

    def _weighted_products(self, left: Array, right: Array) -> list[Array]:
        """Return J products (l, r) of pressures (n, l) and (n, r), by the matrices c_j K_j."""
        left, right = self.mass.backward(left), self.mass.backward(right)
        pairs = zip(self.coefficients, self.punch.masses, strict=True)
        return [c * (left.T @ (mass @ right)) for c, mass in pairs]

    def response_slopes(self, times: Array) -> Array:
        """Return the derivatives (T, J) of the response by the logarithms of the coefficients.

        The response is the indentation, or the force if the indentation is prescribed.
        """
        rates, pressures = self._exponentials
        contributions = self.modes.amplitudes**2 * self.modes.relaxation
        used = np.flatnonzero(contributions > NEGLIGIBLE * contributions.sum())
        used = used if self.problem.indentation is not None else np.append(0, used + 1)
        first, second = np.triu_indices(len(used))
        kernel = divided_difference(rates[used][first], rates[used][second], times[:, None])
        multiplicity = np.where(first == second, 1.0, 2.0)
        products = self._weighted_products(pressures[:, used], pressures[:, used])
        slopes = (
            kernel @ np.array([product[first, second] * multiplicity for product in products]).T
        )
        return slopes if self.problem.indentation is None else -slopes / self.problem.indentation

    def integral_slopes(self, time: float) -> Array:
        """Return the derivatives (J, n) of K P = d b - A p by the logarithms of the coefficients.

        That is ``dd b - A dp``, with the change dp of the pressure that a change of wear causes;
        each mode of it decays from the time at which it is excited.
        """
        rates, pressures = self._exponentials
        decay = 1 / self.modes.relaxation
        kernel = divided_difference(decay[:, None], rates, time)
        slopes = []
        for product in self._weighted_products(self.modes.shapes, pressures):
            excited = -decay * (product * kernel).sum(axis=1)
            pressure = self.modes.shapes @ excited
            slopes.append(-self.energy @ pressure)
        result = np.array(slopes)
        if self.problem.indentation is None:
            depth = self.response_slopes(np.array([time]))[0]
            result += np.outer(depth, self.weights)
        return result

    def worn_slopes(self, time: float, integral: Array, radii: Array | None) -> Array:
        """Return the derivatives of worn heights or volumes by the logarithms of the coefficients.

        Parameters
        ----------
        integral : (n,) integral of the pressure up to the time
        radii : (R,) of worn heights; None for the volumes of the rings

        Returns
        -------
        (R, J) array of worn heights, or (rings, J) array of worn volumes
        """
        punch = self.punch
        pressure = self.mass.backward(integral)
        mass_changes = [
            c * (mass @ pressure) for c, mass in zip(self.coefficients, punch.masses, strict=True)
        ]
        changes: Array = self.integral_slopes(time) - self.mass.forward(np.array(mass_changes).T).T
        changes = self.mass.backward(changes.T)
        if radii is None:
            by_ring = np.einsum("j,rjn->rn", self.coefficients, punch.volumes)
            direct = np.einsum("j,rjn,n->rj", self.coefficients, punch.volumes, pressure)
            return by_ring @ changes + direct
        basis, shapes = punch.basis(radii), punch.wear_shapes_at(radii)
        wear = self.coefficients @ shapes
        direct = (self.coefficients[:, None] * shapes).T * (basis @ pressure)[:, None]
        return wear[:, None] * (basis @ changes) + direct


def divided_difference(first: Array, second: Array, time: Array | float) -> Array:
    """Return ``int_0^t exp(-a (t - s)) exp(-b s) ds`` for rates a and b, which broadcast."""
    difference = np.abs(first - second)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(difference * time > 1e-12, -np.expm1(-difference * time) / difference, time)
    return np.exp(-np.minimum(first, second) * time) * mean


def _with_contrasts(problem: Problem) -> list[Problem]:
    """Return the problem, and two problems whose rings wear alternately more and less.

    A discretisation that suits all three covers any contrast of neighbouring rings. Neighbours with
    equal coefficients are made slightly unequal, because their coefficients may differ in a fit.
    """
    odd = np.arange(len(problem.rings.widths)) % 2
    wear = problem.wear_coefficients * np.where(odd, 1.0, 1 + 1e-9)
    contrasts = wear, 1 + (WEAR_RATIO - 1) * odd, WEAR_RATIO - (WEAR_RATIO - 1) * odd
    return [
        replace(problem, rings=Rings.constant(problem.ring_edges, np.asarray(each, dtype=float)))
        for each in contrasts
    ]


def _with_unequal_knots(rings: Rings) -> Rings:
    """Return rings whose wear coefficients at neighbouring edges differ slightly.

    None of them are merged then: the coefficients may differ in a fit.
    """
    factors = np.where(np.arange(len(rings.ring_edges)) % 2, 1.0, 1 + 1e-9)
    factors_at_edges = np.stack([factors[:-1], factors[1:]])
    return rings._replace(wear_coefficients=rings.wear_coefficients * factors_at_edges)


def _hats(radii: Array, rings: Rings) -> list[Array]:
    """Return the shapes k_j, J arrays (2, N), of the values of a table at radii (J,).

    A table is linear between its radii and constant beyond them; it jumps where two radii are
    equal.
    """
    inner, outer = rings.ring_edges[:-1], rings.ring_edges[1:]
    middles, wear_shapes = (inner + outer) / 2, np.zeros((len(radii), 2, len(inner)))
    for ring, middle in enumerate(middles):
        right = int(np.searchsorted(radii, middle))
        if 0 < right < len(radii):
            ends = np.array([inner[ring], outer[ring]])
            fraction = (ends - radii[right - 1]) / (radii[right] - radii[right - 1])
            wear_shapes[right - 1, :, ring], wear_shapes[right, :, ring] = 1 - fraction, fraction
        else:
            wear_shapes[min(right, len(radii) - 1), :, ring] = 1.0
    return list(wear_shapes)
