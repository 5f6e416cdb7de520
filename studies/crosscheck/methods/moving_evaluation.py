"""Evaluation of a compliance on cells, for a punch whose contact opens, closes and spreads."""

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array, Indices
from ..problem.loading import Loading
from ..problem.norms import DEPTH, Results
from ..problem.problem import Problem
from ..problem.profile import moments, unresolved_height
from ..problem.quantities import ANSWER, DESCRIBED, ENERGIES
from ..wear.contact_edges import pressures_beside_edges, widths_at_edges
from ..wear.evolution import Evolution, evolve, evolve_in_equal_steps
from ..wear.first_contact import load_of
from ..wear.flat_contact import FittedPress
from ..wear.history import History, Pressed
from ..wear.wearing_punch import WearingPunch
from .error_factors import error_factor
from .evaluation import ENDS, Evaluation, greatest_in_ranges
from .sampling.answers import MarchedRun, answers_of

# Numbers of the answer whose error is that of a quantity at the first (0) or at the last (-1) time:
# the shares of the force have that of the forces. The fitted start has its own edges.
REPEATED = {
    name: number.at
    for name, number in ANSWER.items()
    if number.at and name != "contact_radius_start"
} | {"force_share": ("ring_force", 0)}
# Quantities that converge with second or higher order in the cells of a face under one load.
SECOND_ORDER = ENERGIES | {"ring_worn_volume"}
# Quantities at the start that the heights of the face alone determine.
OF_THE_FACE = frozenset({"profile", "rms_slope"})
# Quantities that decay during wear at a fixed indentation.
DECAYING = frozenset({"normal_force", "ring_force"})

# Error of slopes that a step in thin layers may add, over rtol. The worn depth alone would be right
# after a few steps, with slopes and pressures that are far off (physics/test_random_scenes.py::
# test_layers_where_the_rim_loses_contact_under_a_falling_force).
SLOPE_TOLERANCE = 0.6


# Places between a time and either end of the range of similar times, over its distance from that
# end, at which errors are estimated, too.
PLACES_NEAR = (0.4, 1.0)
# Parts of the running-in, over a given part, that remain at times whose errors are alike.
PARTS_NEAR = (0.7, 1.4)


def range_near(times: Array, loading: Loading) -> tuple[Array, Array]:
    """Return the range (T,), (T,) of times near each time in which errors are like its own.

    Under a constant load, it is from t / c to c t, with a factor c. If the load varies, times count
    from its last knot instead; and because a knot hardly changes what has worn by then, backwards
    from the knot before that.
    """
    factor, knots = error_factor("nearby times"), loading.times
    last = np.maximum(np.searchsorted(knots, times) - 1, 0)
    since, since_earlier = (times - knots[row] for row in (last, np.maximum(last - 1, 0)))
    return times - (1 - 1 / factor) * since_earlier, times + (factor - 1) * since


class MovingContact(Evaluation):
    """A punch whose contact opens, closes and spreads, marched through the requested times.

    Parameters
    ----------
    problem, compliance : the compliance on linear pressures over cells
    start : the initial contact of the unworn face, on a pressure space fitted to its edges
    step_length : factor on the lengths of steps in time
    in_layers : whether the contact covers the face from the start, so that steps in time must also
        resolve the slopes of the thin layers that wear makes at ring edges and at the rim

    Attributes
    ----------
    evolution : the wear in time, in the requested steps or in adaptive ones
    """

    # The edges of the contact move, and seldom to the same place in a cell of both meshes.
    safety = error_factor("moving contact")

    def __init__(
        self,
        problem: Problem,
        compliance: Compliance,
        start: FittedPress | None = None,
        step_length: float = 1.0,
        in_layers: bool = False,
    ) -> None:
        super().__init__(problem, compliance)
        self.start, self.in_layers, self.step_length = start, in_layers, step_length
        # Error that each step may add to the worn depth: a part of the tolerance. Above 1e-3 the
        # tolerance has no effect: cells get no coarser either, and longer steps would save nothing
        # but be too few to estimate their error.
        rtol = min(problem.step_rtol or problem.rtol, 1e-3)
        varies = np.ptp(problem.loading.forces) or problem.indentation is not None
        # measured: the tolerance is relative to the indentation, but the worn depth is small while
        # a force rises from zero, and at a given indentation the force becomes small
        depth_rtol = 0.2 * rtol if varies else rtol
        self._tolerance = 0.025 * depth_rtol
        self._slope_tolerance = SLOPE_TOLERANCE * rtol if in_layers else np.inf
        self._allowed_errors = np.array(
            [error_factor("depth of a step") * depth_rtol, error_factor("slope of a step") * rtol]
        )
        self._punch = WearingPunch(
            compliance,
            problem.merged.wear_coefficients,
            moments(problem.profile, compliance.space),
            load_of(problem),
            problem.loading,
        )
        self.evolution = (
            self._adaptive
            if problem.step is None
            else evolve_in_equal_steps(self._punch, problem.times, problem.step)
        )

        # the estimate and the results ask for the same times, each of which is a contact problem
        self._history_at = lru_cache(maxsize=1)(
            lambda times: self._with_fitted_start(self.evolution.at(np.frombuffer(times)))
        )

    @cached_property
    def _adaptive(self) -> Evolution:
        last = float(self.problem.times[-1])
        tolerances = self._tolerance, self._slope_tolerance
        return evolve(self._punch, last, *tolerances, self.step_length)

    @property
    def exact_in_time(self) -> History:
        """The history at the requested times, in adaptive steps that suit the tolerance."""
        return self._with_fitted_start(self._adaptive.at(self.problem.times))

    @cached_property
    def history(self) -> History:
        """The history at the requested times, in the requested steps or in adaptive ones."""
        times = self.estimate_times
        recorded = self._history_at(times.tobytes())
        return recorded[np.flatnonzero(np.isin(times, self.problem.times))]

    def _with_fitted_start(self, history: History) -> History:
        # a punch that does not press yet has the indentation of the first touch
        unloaded = (history.distances == 0) & (history.force == 0)
        history = replace(history, depth=np.where(unloaded, 0.0, history.depth))
        if self.start is None:
            return history
        at_start = (history.distances == 0) & (history.force == history.force[0])
        depth = np.where(at_start, self.start.indentation, history.depth)
        pressed = Pressed(
            self.start,
            np.where(at_start, self.start.force, 0.0),
            np.where(at_start[:, None], 0.0, history.pressure),
        )
        return replace(history, depth=depth, pressed=pressed)

    @cached_property
    def estimate_times(self) -> Array:
        """The requested times, and ends of steps near each of those that are compared."""
        problem, known = self.problem, self.evolution.times
        times = problem.times[problem.compared_rows]
        earliest, latest = range_near(times, problem.loading)
        wanted = np.concatenate(
            [times - part * (times - earliest) for part in PLACES_NEAR]
            + [times + part * (latest - times) for part in PLACES_NEAR]
        )
        known = known[(known > 0) & (known < problem.times[-1])]
        nearest = known[np.abs(known - wanted[:, None]).argmin(axis=1)] if len(known) else known
        return np.union1d(problem.times, nearest)

    def results_for_estimate(self, times: Array) -> Results:
        """Return the quantities on the face of the punch at some times."""
        return self.sampler.history(self._history_at(times.tobytes()), on_face=True)

    @cached_property
    def answers(self) -> Results:
        """The numbers of the answer, by the requested march and step."""
        return self._answers(self.evolution)

    @property
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, in adaptive steps that suit the tolerance."""
        return self._answers(self._adaptive)

    def _answers(self, evolution: Evolution) -> Results:
        ends = self._with_fitted_start(evolution.at(self.problem.times[ENDS]))
        return answers_of(MarchedRun(self.problem, evolution, self.start, ends))

    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error estimate of a number of the answer.

        A number that is a quantity at the first or at the last time has the error of that quantity.
        The error of any other is its difference to a coarser evaluation times its factor, but at
        least a floor.
        """
        if name in REPEATED:
            quantity, row = REPEATED[name]
            if quantity in errors:
                return np.broadcast_to(errors[quantity][row], difference.shape)
        floors = {
            "contact_radius_start": error_factor("edge of a fitted start"),
            "pressure_peak_start": error_factor("fitted start"),
        }
        floor = floors.get(name, error_factor("floor of moving contact") * self.problem.rtol)
        # the last node begins to carry in different time steps of the two marches
        time_factor = (
            error_factor("time to full contact") if name == "time_to_full_contact" else 1.0
        )
        error = np.maximum(time_factor * self.safety_factor(name) * difference, floor)
        return self._excess_of_steps * error

    def times_near(self, remaining_part: float) -> Array:
        """Return the times at which about a part of the running-in remains, whose errors are alike.

        The difference of such a time to a coarser evaluation may cross zero.
        """
        return np.array([self.evolution.time_until(f * remaining_part) for f in PARTS_NEAR])

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity: factor times difference to a coarser evaluation.

        - The factor is `safety_factor`.
        - At each requested time, the error is the largest at nearby times of the march, because
          differences cross zero now and then. A start that is fitted to the edges of the contact is
          left out of this.
        - The error is at least the floor of the quantity.
        - Steps that err by more than they may multiply the error.
        """
        times = self.estimate_times
        error = self.safety_factor(name) * difference
        later = (times > 0) | self._starts_on_cells
        nearby = greatest_in_ranges(np.where(later, error, 0.0), *self._nearby)
        error = np.where(later, nearby, error)
        error = np.maximum(error[np.isin(times, self.problem.times)], self._floor(name))
        error = self._excess_of_steps * error
        if name == "rms_slope":
            # an infinite slope has no value, and no error either
            return np.where(np.isnan(self.results[name]), np.nan, error)
        return error

    @property
    def _excess_of_steps(self) -> float:
        """Greatest error that a step added over the error that it may add; at least 1.

        The errors of steps that are far too long have no order, so that two marches may agree by
        chance.
        """
        excess = self.evolution.statistics.greatest_errors / self._allowed_errors
        return max(1.0, float(excess.max()))

    @cached_property
    def _nearby(self) -> tuple[Indices, Indices]:
        """Ranges (T,), (T,) of the estimate's times near each of them, with similar errors."""
        times = self.estimate_times
        earliest, latest = range_near(times, self.problem.loading)
        return np.searchsorted(times, earliest), np.searchsorted(times, latest, side="right")

    @property
    def _starts_on_cells(self) -> bool:
        """Whether there is a contact at the time 0 that is not fitted to its edges."""
        return self.start is None and self.problem.loading.forces[0] > 0

    def safety_factor(self, name: str) -> float:
        """Return the factor on the difference of a quantity to a coarser evaluation.

        It is larger for forces that decay at a given indentation, and smaller for energies and
        volumes under one load.
        """
        if self._decays(name):
            # at a given indentation, forces grow at most with the square of the depth, and their
            # errors stay while the forces decay
            return error_factor("decaying force") * self.safety
        # under one load, energies and volumes converge at least at second order in the cells, so
        # that the difference is three times the error
        if name in SECOND_ORDER and not self.problem.loading.varies:
            return error_factor("moving contact, energies and volumes")
        return self.safety

    def _decays(self, name: str) -> bool:
        return self.problem.indentation is not None and name in DECAYING

    def _floor(self, name: str) -> Array:
        """Return the smallest error (T,) that is reported for a quantity at the requested times."""
        later = self.problem.times > 0
        if self._starts_on_cells and name != "profile":
            later = np.ones_like(later)
        # At the start nothing has worn: slopes of the unworn face are differences of heights, and
        # edges are located to a few times the tolerance of their search. Later, edges of the
        # contact make agreement by chance more likely.
        kind_of_start = {
            "rms_slope": "slope of a fitted start",
            "contact_radius": "edge of a fitted start",
        }
        at_start = error_factor(kind_of_start.get(name, "fitted start"))
        if self.start is not None and name not in OF_THE_FACE:
            unresolved = self.start.unresolved_height / self.start.indentation
            at_start = max(at_start, error_factor("kinks inside elements") * unresolved)
        floor = error_factor("floor of moving contact") * self.problem.rtol
        floors = np.where(later, floor, at_start)
        if name in ("profile", "displacement"):
            # Linear functions lose this part of the bend of a field. If an edge stays in the same
            # cell of both meshes, their difference does not show that. In random punches whose face
            # the cells resolve, no penetration is above 0.23 of the bend.
            lost_bend = error_factor("lost bend") * self._lost_bends * self._inverse_depth
            floors = np.maximum(floors, np.where(later | (name != "profile"), lost_bend, 0.0))
        if name == "pressure":
            # linear pressures miss this part where the pressure vanishes as a root, or jumps; both
            # meshes miss the same if they have the edge at the same place of a cell
            missed = error_factor("pressure at free edges") * pressures_beside_edges(
                self.compliance.space,
                self.history.contact,
                self.history.pressure,
                self.problem.merged.wear_coefficients,
            )
            return np.maximum(floors, np.where(later, missed, 0.0))
        if name == "contact_radius":
            # the difference does not show the error if both meshes have the edge in the same cell
            widths = widths_at_edges(self.compliance.space, self.history.contact)
            at_edges = later & ~self.evolution.settled(self.problem.times)
            return np.maximum(floors, np.where(at_edges, widths, 0.0))
        if self._decays(name):
            return error_factor("decaying force") * np.maximum(floors, self._unresolved_height)
        is_height = DESCRIBED[name].norm is DEPTH
        # the unworn face is given, and a start that is fitted to the edges integrates all of it
        exact_start = name == "profile" or (name == "indentation" and self.start is not None)
        by_cells = is_height & (later | (not exact_start))
        return np.where(by_cells, np.maximum(floors, self._unresolved_height), floors)

    @cached_property
    def _unresolved_height(self) -> Array:
        """(T,) largest difference of the face from what cells resolve, over the depth."""
        depth, space = float(self.history.depth.max()), self.compliance.space
        return unresolved_height(self.problem.profile, space, depth) * self._inverse_depth

    @property
    def _inverse_depth(self) -> Array:
        """(T,) inverse of the indentation less the even wear.

        It is 0 if that is zero, because nothing is promised then.
        """
        depth = self.history.depth
        return np.divide(1.0, depth, out=np.zeros(len(depth)), where=depth > 0)

    @cached_property
    def _lost_bends(self) -> Array:
        """(T,) largest bend of the worn face or the displacement that linear functions lose."""
        return self.sampler.worn_face(self.history).unresolved_bending

    @property
    def settings(self) -> dict[str, int]:
        """Size of the march, for the summary."""
        space = self.compliance.space
        settings = {
            "cells": len(space.degrees),
            "pressures": space.size,
            "steps": self.evolution.statistics.taken,
        }
        if self.start is not None:
            settings["start_pressures"] = len(self.start.pressure)
        return settings

    def notes(self) -> list[str]:
        """Return a note for the user if the cells are too coarse for the face."""
        unresolved, cells = float(self._unresolved_height.max()), len(self.compliance.space.degrees)
        if unresolved <= self.problem.rtol:
            return []
        return [
            f"the face is finer than the {cells} cells resolve: its heights differ from those on "
            f"the cells by up to {unresolved:.1e} of the indentation; a smaller rtol makes more "
            "cells"
        ]
