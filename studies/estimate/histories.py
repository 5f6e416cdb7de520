"""Histories without units that are sampled at any times and radii: modes, marches and strips.

- `FlatHistory`: a flat punch with any wear coefficients on one discretisation. The compliance does
  not depend on wear: for other wear coefficients only the relaxation modes are computed again
  (`RunningIn`).
- `March`: a punch whose contact opens, closes or spreads, by one march that is interpolated. Under
  a constant load, it is computed in the unit of time in which the first wear coefficient is 1.
- `Strips`: approximate wear of a flat punch in plane strain, which a program may have modelled by
  mistake. Pressures are constant on about 40 strips on both sides of the middle plane,
  displacements are taken at the middles of the strips, and the history is exact in time. Units are
  those of the axisymmetric problem; the line force is F / 2a.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, make_smoothing_spline

from ...mdr import energy
from ...meshes import Array, Compliance
from ..crosscheck import MovingContact, Problem, Rings, RunningIn, Sampler, choose_spaces, covering

# factor by which the discretisation covers earlier and later times than the data, so that it also
# suits wear coefficients that are larger or smaller by this factor
COVERED_SPAN = 30.0
# least ratio of the wear coefficients of neighbouring rings that the discretisation covers
WEAR_RATIO = 10.0
# relative distance from the edges of a ring at which its wear coefficients are taken
INSIDE = 1e-9
# number of times per decade at which a march is sampled, and factor by which it begins before and
# ends after the times that are needed
TIMES_PER_DECADE, TIME_SPAN = 12, 4.0
# relative difference of two times below which they are the same
ROUNDOFF = 1e-9
# number of radii, besides those of the data, between which fields are linear
RADII = 100
# name of the width of the cell at the edge of the contact, among the results
CELL = "contact_cell"
# quantities that are known to a part of a cell
EDGES = ("contact_radius", "scar_diameter")
# a function of time
Curve: TypeAlias = Callable[[Array], Array]
# least number of strips on a ring, and about the least number on all rings together
MIN_RING_STRIPS, MIN_STRIPS = 5, 40
# rates of decay below this part of the largest one are zero: the even wear
ZERO_RATE = 1e-7


def discretise(problem: Problem, earliest: float, latest: float, fields: bool) -> Compliance:
    """Return the compliance for the times of the data and the `rtol` of a problem.

    Neighbours with equal wear coefficients are made slightly unequal, so that they are not merged:
    their coefficients may differ in a fit.

    Parameters
    ----------
    problem : with `rtol`, and with the wear coefficients of the scene
    earliest, latest : first and last time of the data after the start
    fields : whether profiles or volumes are predicted, not only the indentation
    """
    quantities = {"indentation", "profile"} if fields else {"indentation"}
    times = np.array([earliest / COVERED_SPAN, latest * COVERED_SPAN])
    problem = replace(problem, times=times, steady=False, quantities=frozenset(quantities))
    rings = problem.graded or problem.rings
    odd = np.arange(len(rings.ring_edges)) % 2
    unequal = np.where(odd, 1.0, 1 + 1e-9)
    if problem.graded:
        at_edges = rings.wear_coefficients * np.stack([unequal[:-1], unequal[1:]])
        covered = replace(problem, graded=rings._replace(wear_coefficients=at_edges))
    else:
        # a discretisation that suits these three covers any contrast of neighbouring rings
        contrasts = (
            problem.wear_coefficients * unequal[:-1],
            1 + (WEAR_RATIO - 1) * odd[:-1],
            WEAR_RATIO - (WEAR_RATIO - 1) * odd[:-1],
        )
        covered = covering(
            [replace(problem, rings=Rings.constant(rings.ring_edges, each)) for each in contrasts]
        )
    return energy.compliance(choose_spaces(covered).fine, covered.ground)


def with_uniform(compliance: Compliance, added: float) -> Compliance:
    """Return a compliance plus a displacement per force that is equal everywhere.

    ``A + c b b^T`` has the factor ``(1 + g y y^T / y.y) H`` with ``H^T y = b`` and ``(1 + g)^2 = 1
    + c y.y``, where y.y is the force of a flat punch per indentation.
    """
    weights = compliance.space.weights
    unit = np.linalg.lstsq(compliance.factor.T, weights, rcond=None)[0]
    stiffness = unit @ unit
    growth = np.sqrt(1 + added * stiffness) - 1
    factor = compliance.factor + growth / stiffness * np.outer(unit, weights)
    return replace(compliance, factor=factor)


@dataclass(frozen=True, eq=False)
class FlatHistory:
    """The history of a flat punch at any times and radii.

    Parameters
    ----------
    problem : with the wear coefficients and the load
    compliance : of the half-space
    earliest : first sliding distance at which it is evaluated
    """

    problem: Problem
    compliance: Compliance
    earliest: float

    @cached_property
    def _wear(self) -> RunningIn:
        problem, edges = self.problem, self.compliance.space.ring_edges
        rings, inside = problem.graded or problem.rings, INSIDE * np.diff(edges)
        return RunningIn(
            self.compliance,
            np.stack([rings.at(edges[:-1] + inside), rings.at(edges[1:] - inside)]),
            self.earliest,
            indentation=problem.indentation,
            loading=problem.loading,
        )

    def sample(
        self, times: Array, radii: Array, step: float, names: Collection[str]
    ) -> dict[str, Array]:
        """Return quantities by name: fields (T, R), numbers (T,), and volumes of rings (T, rings).

        Under a constant load they may have the errors of steps of first order, of which one ends at
        each of the times. An implicit step h divides the amplitude of a mode with relaxation time T
        by ``1 + h / T``; between times that are closer than h, the step is their distance. Explicit
        steps have about the opposite error, also where they would be unstable.

        Parameters
        ----------
        times, radii : (T,) and (R,)
        step : length of the steps, implicit if positive and explicit if negative; 0 for none
        names : of the quantities
        """
        wear, loading, state = self._wear, self.problem.loading, self.problem.loading.at(times)
        modes = wear.modes
        amplitudes = modes.excite(modes.at_knots(loading)[state.knot], state)
        if step and not loading.varies:
            parts = np.diff(times, prepend=0.0)[:, None]
            steps = np.clip(parts, 1e-300, abs(step))
            implicit = np.cumsum(parts * np.log1p(steps / modes.relaxation) / steps, axis=0)
            error = np.exp(-implicit) * modes.amplitudes - amplitudes
            amplitudes += np.sign(step) * error
        history = wear.from_amplitudes(times, amplitudes)
        wanted = frozenset({"ring_worn_volume", *names})
        problem = replace(self.problem, times=times, output_radii=radii, quantities=wanted)
        results = Sampler(problem, self.compliance.space).history(history)
        return results | {"worn_volume": results["ring_worn_volume"]}


@dataclass(frozen=True, eq=False)
class March:
    """A march, interpolated in time and along the radius.

    Parameters
    ----------
    clock : unit of its times, in non-dimensional times of the problem
    earliest, latest : range of the times after 0 at which it can be evaluated
    radii : (R,) increasing, at which fields are sampled
    results : (T, R), (T,) or (T, rings) by quantity
    times : (T,)
    smooth : whether the history is smooth in the fourth root of time: under a constant load the
        contact radius grows approximately with this root from a contact at a point
    """

    clock: float
    earliest: float
    latest: float
    radii: Array
    results: dict[str, Array]
    times: Array
    smooth: bool

    @classmethod
    def compute(
        cls, problem: Problem, clock: float, earliest: float, latest: float, radii: Array
    ) -> "March":
        """Return the march of a problem.

        Parameters
        ----------
        problem : at whose tolerance it is computed
        clock : unit of the times, in non-dimensional times of the problem
        earliest, latest : first and last time after the start that are needed
        radii : at which fields are needed exactly
        """
        earliest, latest = earliest / TIME_SPAN, latest * TIME_SPAN
        decades = np.log10(latest / earliest)
        times = np.geomspace(earliest, latest, int(np.ceil(TIMES_PER_DECADE * decades)) + 2)
        if problem.loading.varies:
            knots = problem.loading.times[1:] / clock
            own = np.union1d(knots, problem.times / clock)
            times = np.union1d(times, own[(own > earliest) & (own < latest)])
            # times that differ only by the roundoff of units are one time
            times = times[np.diff(times, prepend=0.0) > ROUNDOFF * times]
        times = np.append(0.0, times)
        even = np.linspace(problem.inner_radius, 1.0, RADII + 2)[1:-1]
        radii = np.union1d(even, radii[(radii >= problem.inner_radius) & (radii <= 1)])
        # for other parameters, contact may be lost
        problem = replace(
            problem,
            times=times * clock,
            steady=False,
            quantities=None,
            keeps_contact=False,
            output_radii=radii,
        )
        compliance = energy.compliance(choose_spaces(problem).fine, problem.ground)
        history = MovingContact(problem, compliance).history
        results = Sampler(problem, compliance.space, compliance).history(history)
        forces = np.asarray(history.force, dtype=float)
        results["normal_force"], results["worn_volume"] = forces, results["ring_worn_volume"]
        # a scar does not become smaller under a force that falls
        radius = results["contact_radius"]
        results["scar_diameter"] = 2 * np.maximum.accumulate(radius)
        cells = compliance.space.breakpoints
        last = np.clip(np.searchsorted(cells, radius), 1, len(cells) - 1)
        results[CELL] = np.diff(cells)[last - 1]
        return cls(clock, earliest, latest, radii, results, times, not problem.loading.varies)

    @cached_property
    def _curves(self) -> dict[str, Curve]:
        return {}

    def _curve(self, name: str) -> Curve:
        if name not in self._curves:
            values = self.results[name]
            if self.smooth and name != "pressure":
                roots = self.times**0.25
                if name in EDGES:
                    # an edge of the contact is located to a part of a cell
                    spline = make_smoothing_spline(roots, values)
                else:
                    spline = CubicSpline(roots, values, axis=0)
                self._curves[name] = lambda times: np.asarray(spline(times**0.25))
            else:
                # without overshooting where the load has a kink, or contact begins
                self._curves[name] = PchipInterpolator(self.times, values, axis=0)
        return self._curves[name]

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ()
    ) -> dict[str, Array]:
        """Return quantities by name, as `FlatHistory.sample` does; steps have no effect."""
        results, own_times = {}, np.minimum(times / self.clock, self.latest)
        for name in names:
            values = self._curve(name)(own_times)
            if name in ("pressure", "profile", "displacement"):
                values = np.array([np.interp(radii, self.radii, row) for row in values])
            results[name] = values
        return results


@dataclass(frozen=True, eq=False)
class Strips:
    """A flat punch on a half-space in plane strain, under a constant force.

    Parameters
    ----------
    edges : (N+1,) edges of the strips, from 0 to 1
    wear : (N,) wear coefficients
    """

    edges: Array
    wear: Array

    @classmethod
    def of(cls, problem: Problem) -> "Strips":
        """Return the strips of a problem, narrow beside every ring edge."""
        rings = problem.graded or problem.rings
        inner, outer = rings.ring_edges[:-1, None], rings.ring_edges[1:, None]
        count = max(MIN_RING_STRIPS, MIN_STRIPS // len(inner))
        fractions = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
        edges = np.append((inner + (outer - inner) * fractions).ravel(), 1.0)
        return cls(edges, rings.at((edges[1:] + edges[:-1]) / 2))

    @cached_property
    def _weights(self) -> Array:
        """(N,) forces of unit pressures: the line force 1/2 on both sides is the force 1."""
        return 4 * np.diff(self.edges)

    @cached_property
    def _stiffness(self) -> Array:
        """(N, N) pressures by unit displacements of the middles.

        A line force P causes the displacement ``-2 P / (pi E*) ln|x|``, plus a constant that
        depends on the depth of the body and is left out (Johnson, Contact Mechanics, ch. 2).
        """
        middles = (self.edges[1:] + self.edges[:-1])[:, None] / 2

        def integral(distance: Array) -> Array:
            return distance * (np.log(np.abs(distance)) - 1)

        both_sides = integral(middles - self.edges) - integral(middles + self.edges)
        return np.linalg.inv(np.diff(2 / np.pi * both_sides, axis=1))

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ()
    ) -> dict[str, Array]:
        """Return quantities by name, as `FlatHistory.sample` does; steps have no effect."""
        forces = self._weights @ self._stiffness
        worn = worn_at_nodes(self._stiffness, forces, self.wear, times)
        at = np.clip(np.searchsorted(self.edges, radii) - 1, 0, len(self.wear) - 1)
        return {
            "pressure": worn.pressures[:, at],
            "profile": worn.profiles[:, at],
            "displacement": worn.indentations[:, None] - worn.profiles[:, at],
            "indentation": worn.indentations,
            "normal_force": np.ones(len(times)),
        }


class Worn(NamedTuple):
    """Contain the wear of a flat face at T times: arrays (T, n), and the indentations (T,)."""

    profiles: Array
    pressures: Array
    indentations: Array


def worn_at_nodes(
    stiffness: Array, forces: Array, wear: Array, times: Array, by_force: bool = True
) -> Worn:
    """Return the exact wear ``f' = k p`` of a flat face in full contact, at n nodes or strips.

    Parameters
    ----------
    stiffness : (n, n) pressures for displacements of the nodes
    forces : (n,) total force for a displacement of each node
    wear : (n,) wear coefficients k
    times : (T,)
    by_force : whether the force is 1 at all times, and not the indentation
    """
    relief, start = stiffness, stiffness.sum(axis=1)
    if by_force:
        start = start / forces.sum()
        relief = stiffness - np.outer(start, forces)
    # p = start - relief f
    rates, shapes = np.linalg.eig(wear[:, None] * relief)
    parts = shapes * np.linalg.solve(shapes, (wear * start).astype(complex))
    decays, elapsed = np.abs(rates) > ZERO_RATE * np.abs(rates).max(), times[:, None]
    rest = np.where(decays, rates, 1.0)
    grown = np.where(decays, -np.expm1(-rest * elapsed) / rest, elapsed)
    profiles = np.asarray((grown @ parts.T).real)
    depths = (1 + profiles @ forces) / forces.sum() if by_force else np.ones(len(times))
    return Worn(profiles, start - profiles @ relief.T, depths)
