"""Histories of a flat punch for any wear coefficients on one discretisation, and their derivatives.

A compliance `A` knows nothing of wear. On pressures, whose mass matrix of weight k is ``K = sum_j
c_j K_j``, the history obeys ``A p' = d' b - K p`` with ``b . p = F``, and so for every c only a
Cholesky factor and one symmetric eigenproblem are new. Its derivative by ln c_j is exact, too: the
wear that a change of c_j adds at the time s presses as a unit force would from then on, so that by
reciprocity

    d d(T) / d ln c_j = int_0^T ds int c_j k_j(r) p(r, T - s) p(r, s) dA,

with the pressure p under the unit force and k_j the part of the wear coefficient that c_j brings.
At a fixed indentation d the force has this derivative, over -d. Pressures are sums of exponentials,
and the integral over s is a divided difference of them. Non-dimensional, in units of the problem.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.radial import Array, Indices, ring_of
from ...methods.spaces import choose_spaces
from ...problem.face import Rings
from ...problem.problem import Problem
from ...sizes.shared import covering
from ...wear.modes import BandedCholesky, Modes, every_mode

# times that a discretisation serves before the first and after the last of the data, as wear
# coefficients that are so much larger or smaller need it
SPAN = 30.0
# ratio of the wear coefficients of neighbouring rings that it serves at least
RATIO = 10.0
# part of d(t) below which a mode is left out of its derivatives
NEGLIGIBLE = 1e-7


@dataclass(frozen=True, eq=False)
class FlatHistories:
    """A discretised flat punch whose wear coefficients are free.

    Parameters
    ----------
    compliance : of the half-space
    parts : J arrays (2, N) of ring values of the pressure space: what each coefficient brings
    scene_rings : (N,) number of the ring of the scene that each ring of that space lies on; -1 of a
        hole
    """

    compliance: Compliance
    parts: tuple[Array, ...]
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
        """Return the discretisation that suits times, fields or only the indentation, and rtol.

        Parameters
        ----------
        problem : with the accuracy, and the wear coefficients to start from
        earliest, latest : times of the data after the start
        fields : whether profiles or volumes are wanted
        table_radii : (J,) of the table of wear coefficients, if wear is graded
        """
        wanted = {"indentation", "profile"} if fields else {"indentation"}
        when = np.array([earliest / SPAN, latest * SPAN])
        problem = replace(problem, times=when, steady=False, quantities=frozenset(wanted))
        shared: Problem = problem
        if problem.graded and table_radii is not None:
            rings = problem.graded
            parts = _hats(table_radii, rings)
        else:
            rings = problem.rings
            shared = covering(_with_contrasts(problem))
            parts = [np.tile(row, (2, 1)) for row in np.eye(len(rings.widths))]
        middles = (rings.ring_edges[1:] + rings.ring_edges[:-1]) / 2
        scene_rings = ring_of(problem.ring_edges, middles)
        if problem.inner_radius:
            scene_rings = np.append(-1, scene_rings)
            parts = [np.insert(part, 0, 0.0, axis=1) for part in parts]
        compliance = energy.compliance(choose_spaces(shared).fine)
        return cls(compliance, tuple(parts), scene_rings)

    @cached_property
    def masses(self) -> tuple[csr_matrix, ...]:
        """J mass matrices, of the weight that each coefficient brings."""
        return tuple(self.compliance.space.mass(part) for part in self.parts)

    @cached_property
    def volumes(self) -> Array:
        """(rings, J, size) worn volume of each ring of the scene by the integral of the pressure.

        Each coefficient times its part.
        """
        space, count = self.compliance.space, int(self.scene_rings.max()) + 1
        rows = [
            [space.uniform @ space.mass(part * (self.scene_rings == ring)) for part in self.parts]
            for ring in range(count)
        ]
        return np.array(rows)

    def shares(self, radii: Array) -> Array:
        """Return the part (J, R) of the wear coefficient at radii that each coefficient brings."""
        edges = self.compliance.space.ring_edges
        number = ring_of(edges, radii)
        along = (radii - edges[number]) / np.diff(edges)[number]
        return np.array(
            [part[0, number] + (part[1] - part[0])[number] * along for part in self.parts]
        )

    def solve(self, problem: Problem, coefficients: Array, earliest: float) -> "FlatHistory":
        """Return the history under the load of a problem, by coefficients (J,) in its unit.

        `earliest` is the first sliding distance that is asked for.
        """
        weighted = sum(c * mass for c, mass in zip(coefficients, self.masses, strict=True))
        mass = BandedCholesky(csr_matrix(weighted))
        energy = mass.forward(mass.forward(self.compliance.matrix).T)
        weights = mass.forward(self.compliance.space.weights)
        steady = weights / (weights @ weights)
        given = problem.indentation
        moments = energy @ steady if given is None else -given * weights
        modes = every_mode(
            energy,
            lambda: mass.forward(self.compliance.factor.T).T,
            weights if given is None else None,
            moments,
            earliest,
        )
        return FlatHistory(self, problem, coefficients, mass, energy, weights, steady, modes)


@dataclass(frozen=True, eq=False)
class FlatHistory:
    """The history of a flat punch for some wear coefficients, with exact derivatives.

    Vectors are in coordinates in which the mass matrix of weight k is one.

    Parameters
    ----------
    punch : its discretisation
    problem : whose load and units it has
    coefficients : (J,) over the unit of wear coefficients
    mass, energy, weights : factor of the mass matrix, compliance, and forces of each pressure
    steady : (n,) pressure that wear tends to under the force 1
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

    def states(self, times: Array) -> tuple[Array, Array, Array]:
        """Return pressures (T, n), indentations (T,) and forces (T,) at times."""
        state, modes = self.problem.loading.at(times), self.modes
        if self.problem.loading.varies:
            excited = modes.excite(modes.at_knots(self.problem.loading)[state.knot], state)
        else:
            excited = modes.amplitudes * np.exp(-state.distance[:, None] / modes.relaxation)
        pressures = excited @ self.modes.shapes.T
        if self.problem.indentation is not None:
            given = np.full(len(times), self.problem.indentation)
            return pressures, given, pressures @ self.weights
        pressures += np.outer(state.force, self.steady)
        rate = float(1 / (self.weights @ self.weights))
        # reciprocity with the steady pressures
        depth = rate * state.work + pressures @ (self.energy @ self.steady)
        return pressures, depth, state.force

    def pressure_integrals(self, pressures: Array, depths: Array) -> Array:
        """Return integrals (T, n) of the pressure over the sliding distance: K P = d b - A p."""
        return np.outer(depths, self.weights) - pressures @ self.energy

    def profiles(self, integrals: Array, radii: Array) -> Array:
        """Return worn heights (T, R) by integrals of the pressure (T, n)."""
        basis = self.punch.compliance.space.matrix(radii)
        wear = self.coefficients @ self.punch.shares(radii)
        return np.asarray((basis @ self.mass.backward(integrals.T)).T * wear)

    def worn_volumes(self, integrals: Array) -> Array:
        """Return worn volumes (T, rings) by integrals of the pressure (T, n)."""
        by_ring = np.einsum("j,rjn->rn", self.coefficients, self.punch.volumes)
        return np.asarray((by_ring @ self.mass.backward(integrals.T)).T)

    @cached_property
    def _parts(self) -> tuple[Array, Array]:
        """Rates (m+1,) and pressures (n, m+1) of exponentials that the history is a sum of."""
        shapes = self.modes.shapes * self.modes.amplitudes
        rates = 1 / self.modes.relaxation
        if self.problem.indentation is not None:
            return rates, shapes
        return np.append(0.0, rates), np.column_stack([self.steady, shapes])

    def _weighted(self, left: Array, right: Array) -> list[Array]:
        """Return J products (l, r) of pressures (n, l) and (n, r), by the mass of each part."""
        left, right = self.mass.backward(left), self.mass.backward(right)
        pairs = zip(self.coefficients, self.punch.masses, strict=True)
        return [c * (left.T @ (mass @ right)) for c, mass in pairs]

    def response_slopes(self, times: Array) -> Array:
        """Return the derivatives (T, J) of the indentation, or of the force if that responds."""
        rates, parts = self._parts
        size = self.modes.amplitudes**2 * self.modes.relaxation
        kept = np.flatnonzero(size > NEGLIGIBLE * size.sum())
        kept = kept if self.problem.indentation is not None else np.append(0, kept + 1)
        first, second = np.triu_indices(len(kept))
        kernel = divided_difference(rates[kept][first], rates[kept][second], times[:, None])
        twice = np.where(first == second, 1.0, 2.0)
        products = self._weighted(parts[:, kept], parts[:, kept])
        slopes = kernel @ np.array([product[first, second] * twice for product in products]).T
        return slopes if self.problem.indentation is None else -slopes / self.problem.indentation

    def integral_slopes(self, time: float) -> Array:
        """Return the derivatives (J, n) of what `pressure_integrals` returns, less ``dK P``.

        That is ``dd b - A dp``, by the pressure that a change of wear leaves: each mode decays from
        where it was excited.
        """
        rates, parts = self._parts
        decay = 1 / self.modes.relaxation
        kernel = divided_difference(decay[:, None], rates, time)
        slopes = []
        for product in self._weighted(self.modes.shapes, parts):
            excited = -decay * (product * kernel).sum(axis=1)
            pressure = self.modes.shapes @ excited
            slopes.append(-self.energy @ pressure)
        found = np.array(slopes)
        if self.problem.indentation is None:
            depth = self.response_slopes(np.array([time]))[0]
            found += np.outer(depth, self.weights)
        return found

    def worn_slopes(self, time: float, integral: Array, radii: Array | None) -> Array:
        """Return the derivatives (R, J) of worn heights at radii, or (rings, J) of worn volumes.

        Parameters
        ----------
        integral : (n,) of the pressure by then
        """
        punch, space = self.punch, self.punch.compliance.space
        pressure = self.mass.backward(integral)
        moved = [
            c * (mass @ pressure) for c, mass in zip(self.coefficients, punch.masses, strict=True)
        ]
        changes = self.integral_slopes(time) - self.mass.forward(np.array(moved).T).T
        changes = self.mass.backward(changes.T)
        if radii is None:
            by_ring = np.einsum("j,rjn->rn", self.coefficients, punch.volumes)
            own = np.einsum("j,rjn,n->rj", self.coefficients, punch.volumes, pressure)
            return np.asarray(by_ring @ changes + own)
        basis, shares = space.matrix(radii), punch.shares(radii)
        wear = self.coefficients @ shares
        own = (self.coefficients[:, None] * shares).T * (basis @ pressure)[:, None]
        return np.asarray(wear[:, None] * (basis @ changes) + own)


def divided_difference(first: Array, second: Array, time: Array | float) -> Array:
    """Return ``int_0^t exp(-a (t - s)) exp(-b s) ds`` for rates a and b, which broadcast."""
    apart = np.abs(first - second)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(apart * time > 1e-12, -np.expm1(-apart * time) / apart, time)
    return np.asarray(np.exp(-np.minimum(first, second) * time) * mean)


def _with_contrasts(problem: Problem) -> list[Problem]:
    """Return the problem, and two in which rings wear in turn more and less.

    A discretisation that suits all of them serves any contrast of neighbours. Equal neighbours are
    told apart, because they may differ in a fit.
    """
    odd = np.arange(len(problem.rings.widths)) % 2
    wear = problem.wear_coefficients * np.where(odd, 1.0, 1 + 1e-9)
    contrasts = wear, 1 + (RATIO - 1) * odd, RATIO - (RATIO - 1) * odd
    return [
        replace(problem, rings=Rings(problem.ring_edges, np.asarray(each, dtype=float)))
        for each in contrasts
    ]


def _hats(radii: Array, rings: Rings) -> list[Array]:
    """Return the parts (2, N) of rings that the values of a table at radii (J,) bring.

    A table is linear between its radii and constant beyond them; where two are equal it jumps.
    """
    inner, outer = rings.ring_edges[:-1], rings.ring_edges[1:]
    middles, parts = (inner + outer) / 2, np.zeros((len(radii), 2, len(inner)))
    for ring, middle in enumerate(middles):
        after = int(np.searchsorted(radii, middle))
        if 0 < after < len(radii):
            ends = np.array([inner[ring], outer[ring]])
            share = (ends - radii[after - 1]) / (radii[after] - radii[after - 1])
            parts[after - 1, :, ring], parts[after, :, ring] = 1 - share, share
        else:
            parts[min(after, len(radii) - 1), :, ring] = 1.0
    return list(parts)
