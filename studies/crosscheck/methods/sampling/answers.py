"""The numbers of the answer: scalars, and numbers per ring, that summarise a run. Non-dimensional.

They are computed from each evaluation of a compliance, so that the difference of a fine and a
coarse evaluation estimates their error. Numbers that do not exist for a scene are left out; parts
that a method does not compute are NaN.

A displacement sensor on the holder of the punch shows its approach d(t), which becomes a straight
line once the punch has run in. Running-in times are defined by the part of ``d(t) - w t`` that is
still to come, with the steady wear rate w. It is a sum of decaying exponentials with positive
coefficients.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .....meshes.radial import Array
from ...problem.norms import Results
from ...problem.problem import Problem
from ...problem.quantities import ANSWER
from ...wear.flat_contact import FittedPress
from ...wear.full_contact import RunningIn
from ...wear.history import History
from .functions import Functions
from .sampler import OnCells

if TYPE_CHECKING:
    from ...wear.evolution import Evolution


class SteadyRun:
    """What a method knows that computes only the steady state.

    Parameters
    ----------
    problem : the problem
    steady : the steady quantities on the face, those that are wanted
    """

    def __init__(self, problem: Problem, steady: Results) -> None:
        self.problem, self.steady = problem, steady
        self.indentation_at_start = self.slowest_time = np.nan
        self.contact_radius_at_start = self.peak_at_start = self.time_to_full_contact = np.nan
        self.contact_radius_at_end = self.worn_depth_at_end = np.nan
        self.forces = np.full(2, np.nan)
        self.worn_volumes = self.force_shares_at_start = np.full(
            problem.wear_coefficients.shape, np.nan
        )
        # pressures of the start may be infinite, and have no closed form if the face is shaped
        self.pressures_at_start = np.full((2, len(self.worn_volumes)), np.nan)
        # the time after which a given part of the running-in remains
        self.time_until: Callable[[float], float] = lambda _: np.nan

    @property
    def pressures(self) -> Array:
        """(2, 2, N) least and greatest pressure, at the start and in the steady state, by ring."""
        steady = np.full(self.pressures_at_start.shape, np.nan)
        if "steady_pressure" in self.steady:
            steady = np.array(_steady_extremes(self.problem, self.steady))
        return np.stack([self.pressures_at_start, steady], axis=1)

    @property
    def force_shares(self) -> Array:
        """(2, N) share of the force at the start and in the steady state, by ring."""
        steady = np.full(self.force_shares_at_start.shape, np.nan)
        if "steady_pressure" in self.steady:
            face, pressure = self.problem.face, self.steady["steady_pressure"]
            final = self.problem.loading.forces[-1]
            steady = face.ring_sums(face.areas * pressure) / final
        return np.stack([self.force_shares_at_start, steady])

    @property
    def greatest_steady_displacement(self) -> float:
        """Greatest displacement in the steady state."""
        return float(self.steady.get("steady_displacement_max", np.nan))


class FlatRun(SteadyRun):
    """A flat punch in full contact.

    Parameters
    ----------
    problem : the problem
    wear : the running-in on a compliance
    steady : the steady quantities on the face, those that are wanted
    ends : the history at the first and at the last of the times
    """

    def __init__(self, problem: Problem, wear: RunningIn, steady: Results, ends: History) -> None:
        super().__init__(problem, steady)
        functions, flat = Functions(problem, wear.compliance.space), wear.flat
        self.indentation_at_start = flat.indentation + problem.profile.standoff
        self.slowest_time, self.time_until = wear.relaxation_times[0], wear.time_until
        self.worn_volumes = functions.worn_volumes(ends)[-1]
        self.forces = _forces(problem, functions.ring_forces(ends))
        self.contact_radius_at_start, self.time_to_full_contact = 1.0, 0.0
        self.pressures_at_start = np.array(flat.extremes_on(problem.ring_edges))
        on_rings = flat.ring_forces(problem.ring_edges)
        self.force_shares_at_start = on_rings / on_rings.sum()


class MarchedRun(SteadyRun):
    """A punch whose contact opens, closes or spreads.

    Parameters
    ----------
    problem : the problem
    evolution : the wear through the times
    start : the initial contact, if it is fitted to the edges of the contact
    ends : the history at the first and at the last of the times
    """

    def __init__(
        self, problem: Problem, evolution: "Evolution", start: FittedPress | None, ends: History
    ) -> None:
        super().__init__(problem, {})
        functions = Functions(problem, evolution.punch.space)
        ring_forces = functions.ring_forces(ends)
        self.time_until = evolution.time_until
        if not problem.reason_not_steady:
            self.slowest_time = evolution.punch.slowest_time
        self.worn_volumes = functions.worn_volumes(ends)[-1]
        self.forces = _forces(problem, ring_forces)
        if not problem.loading.varies:
            if not problem.as_wide_as_scar:
                self.time_to_full_contact = evolution.time_of_full_contact
            if problem.times[0] == 0:
                self.indentation_at_start = ends.indentation[0] + problem.profile.standoff
                if (total := ring_forces[0].sum()) > 0:
                    self.force_shares_at_start = ring_forces[0] / total
        if problem.as_wide_as_scar:
            edges = OnCells(functions, ends, functions.centre).contact_edges
            self.contact_radius_at_end = float(np.nanmax(edges[-1], initial=0.0))
            worn = functions.at(functions.centre, ends.shape)
            self.worn_depth_at_end = float(worn[-1, 0])
        if start is not None:
            self.contact_radius_at_start, self.peak_at_start = start.radius, _peak(start)


def answers_of(run: SteadyRun) -> Results:
    """Return the numbers of the answer without those that are NaN in all their parts."""
    problem = run.problem
    values = {
        name: np.array(quantity.value(run), dtype=float)
        for name, quantity in ANSWER.items()
        if quantity.remaining is None or name in problem.remaining_parts
    }
    return {name: value for name, value in values.items() if not np.isnan(value).all()}


def _forces(problem: Problem, ring_forces: Array) -> Array:
    """Return the force (2,) at the start, if that is the first time, and at the last time."""
    forces = ring_forces.sum(axis=1)
    return np.where([problem.times[0] == 0, True], forces, np.nan)


def _steady_extremes(problem: Problem, steady: Results) -> tuple[Array, Array]:
    """Return the smallest and the largest steady pressure (N,) on each ring of the scene.

    In the steady state k p is constant over the face, and k is linear between the edges of rings:
    the extremes are at these edges, where the face has no radii.
    """
    face, rings = problem.face, problem.graded or problem.rings
    rate = np.sum(face.weights * steady["steady_pressure"]) / np.sum(face.areas)
    at_ends = rate / rings.wear_coefficients
    first = np.searchsorted(rings.ring_edges, problem.ring_edges[:-1])
    least, greatest = (extreme.reduceat(at_ends, first, 1) for extreme in (np.minimum, np.maximum))
    return least.min(axis=0), greatest.max(axis=0)


def _peak(press: FittedPress) -> float:
    """Return the largest pressure of an initial contact; NaN if a corner makes it infinite."""
    corners = [
        not interval.outer_free or (interval.inner > 0 and not interval.inner_free)
        for interval in press.intervals
    ]
    if any(corners):
        return float("nan")
    radii = press.radius * np.sin(np.linspace(0, np.pi / 2, 2001))
    return float(press.pressure_at(radii).max())
