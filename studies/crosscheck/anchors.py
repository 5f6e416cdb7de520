"""What no method can move: closed forms and balances that each is held to, so that a fault that all share shows too.

Each costs a few dot products. A flat start indents by ``F / (2 a E*)``. Ring forces add up to `F`. What is worn is what
pressure has worn, ``int f/k dA = F v0 t``, and work is what it should be, ``d F = int u p dA + int f p dA``. The energy of
discs under constant pressure is closed form, and so is that of steady and of uniform pressures; the steady wear rate is
that of Eq. 24.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray

from ringwear.mdr import direct
from ringwear.meshes.radial import Array
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import array
from ringwear.studies.problem.problem import D0, Problem
from ringwear.studies.wear.archard import RunningIn

# of sums and of closed forms to roundoff, where the accuracy asked for has no say
EXACT = 1e-9


@dataclass(frozen=True)
class Anchor:
    """A closed form or a balance that a method is held to: relative difference and what is tolerated."""

    name: str
    method: str
    difference: float
    tolerance: float

    @property
    def holds(self) -> bool:
        return bool(self.difference <= self.tolerance)


def anchors(problem: Problem, name: str, solution: Solution) -> list[Anchor]:
    """Hold a method to all that applies to what it gives."""
    found: list[Anchor] = []
    if len(problem.times) and "indentation" in solution.checked:
        found += _of_history(problem, name, solution)
    if "steady_wear_rate" in solution.checked:
        rings = problem.merged
        known = rings.wear_coefficients[0] * direct.steady_pressures(*rings)[0]
        rate = float(array(solution.checked, "steady_wear_rate"))
        found.append(Anchor("steady wear rate of Eq. 24", name, abs(rate / known - 1), EXACT))
    if solution.wear is not None and problem.profile is None:
        found += _of_compliance(problem, name, solution.wear, solution)
    return found


def _of_history(problem: Problem, name: str, solution: Solution) -> Iterator[Anchor]:
    checked, times = solution.checked, problem.times[problem.checked]
    stated = {one: np.maximum(solution.checked_error(problem, one), problem.rtol) for one in ("indentation", "profile")}
    indentation = array(checked, "indentation")
    if times[0] == 0 and problem.profile is None:
        yield Anchor("flat start, d = F / (2 a E*)", name, abs(indentation[0] / D0 - 1), float(stated["indentation"][0]))
    forces = array(checked, "ring_force").sum(axis=1)
    if problem.profile is not None:
        yield from _of_profile(problem, name, checked)
        return
    of_forces = solution.checked_error(problem, "ring_force")
    yield _worst("ring forces add up to F", name, np.abs(forces - 1), np.maximum(of_forces, EXACT))
    radii, weights = problem.face[:2]
    by_wear = weights / problem.merged.at(radii) ** 2
    later = times > 0
    if later.any():
        worn = array(checked, "profile")[later] @ by_wear
        wrong = np.abs(worn / times[later] - 1)
        # the profile is promised relative to the indentation
        tolerated = (stated["profile"] * indentation)[later] * by_wear.sum() / times[later]
        yield _worst("worn volume over k, F v0 t", name, wrong, np.maximum(tolerated, problem.rtol))


def _of_profile(problem: Problem, name: str, checked: xarray.Dataset) -> Iterator[Anchor]:
    """What holds while contact opens, closes and spreads."""
    forces, times = array(checked, "ring_force").sum(axis=1), array(checked, "time")
    if problem.indentation is None:
        yield _worst("ring forces add up to F", name, np.abs(forces - 1), np.full(len(forces), EXACT))
        worn = array(checked, "ring_worn_volume")[times > 0] @ (1 / problem.wear_coefficients)
        wrong = np.abs(worn / times[times > 0] - 1)
        if len(wrong):
            yield _worst("worn volume over k, F v0 t", name, wrong, np.full(len(wrong), EXACT))


def _of_compliance(problem: Problem, name: str, wear: RunningIn, solution: Solution) -> Iterator[Anchor]:
    # the accuracy asked for, or what the method itself says of its energies
    tolerated, space = max(problem.rtol, solution.error_estimate, EXACT), wear.compliance.space
    edges = problem.merged.ring_edges
    if len(problem.times):
        history = wear.modal(problem.times[problem.checked])
        work = np.sum((history.pressure @ wear.compliance.factor.T) ** 2, axis=1)
        work += np.einsum("ti,ti->t", history.pressure @ space.mass(), history.profile)
        balance = np.abs(work / history.indentation - 1)
        # the flat start is sought among other pressures than what is worn, and knows its indentation to its own error
        own = np.maximum(solution.checked_error(problem, "indentation"), EXACT)
        yield _worst("energy, d F = int (u + f) p dA", name, balance, own)
    steady = direct.steady_pressures(*problem.merged)
    for what, pressures, own in (
        ("steady pressures", steady, wear.steady.pressure),
        ("uniform pressure", np.ones_like(steady), np.where(space.order == 1, 1.0, 0.0)),
    ):
        energy = float(np.sum((wear.compliance.factor @ own) ** 2))
        known = energy_of_rings(edges, pressures)
        yield Anchor(f"energy of {what} in closed form", name, abs(energy / known - 1), tolerated)


def energy_of_rings(ring_edges: Array, pressures: Array) -> float:
    """``int u p dA`` of a constant pressure on each ring, by the closed form of discs."""
    steps = direct.pressure_steps(pressures)
    return float(steps @ direct.disc_energies(ring_edges[1:]) @ steps)


def _worst(what: str, name: str, difference: Array, tolerance: Array) -> Anchor:
    """The time at which the difference is the greatest part of what is tolerated."""
    worst = int(np.argmax(difference / tolerance))
    return Anchor(what, name, float(difference[worst]), float(tolerance[worst]))
