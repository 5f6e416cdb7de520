"""Wear a flat punch with any wear coefficients on one discretisation. Non-dimensional.

The compliance does not depend on wear: for other wear coefficients only the relaxation modes are
computed again (`RunningIn`).
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...mdr import energy
from ...meshes import Array, Compliance
from ..crosscheck import Problem, Rings, RunningIn, Sampler, choose_spaces, covering

# factor by which the discretisation covers earlier and later times than the data, so that it also
# suits wear coefficients that are larger or smaller by this factor
TIME_SPAN = 30.0
# least ratio of the wear coefficients of neighbouring rings that the discretisation covers
WEAR_RATIO = 10.0
# relative distance from the edges of a ring at which its wear coefficients are taken
INSIDE = 1e-9


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
    times = np.array([earliest / TIME_SPAN, latest * TIME_SPAN])
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
