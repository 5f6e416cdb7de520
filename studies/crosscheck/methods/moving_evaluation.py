"""Evaluation of a compliance on cells, for a punch whose contact opens, closes and spreads."""

from dataclasses import replace
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.profile import moments, unresolved_height
from ..problem.quantities import DESCRIBED, ENERGIES
from ..wear.contact_edges import pressures_beside_edges, widths_at_edges
from ..wear.evolution import Evolution, evolve, evolve_in_equal_steps
from ..wear.first_contact import load_of
from ..wear.flat_contact import FittedPress
from ..wear.history import History, UnwornPart
from ..wear.unilateral import Mask
from ..wear.wearing_punch import WearingPunch
from .error_factors import error_factor
from .evaluation import ENDS, Evaluation, range_near
from .sampling.answers import MarchedRun, answers_of

# Quantities that converge with second or higher order in the cells of a face under one force.
SECOND_ORDER = ENERGIES | {"ring_worn_volume"}
# Places between a time and either end of the range of similar times, over its distance from that
# end, at which errors are estimated, too.
PLACES_NEAR = (0.4, 1.0)
# Parts of the running-in, over a given part, that remain at times whose errors are alike.
PARTS_NEAR = (0.7, 1.4)


class MovingContact(Evaluation):
    """A punch whose contact opens, closes and spreads, marched through the requested times.

    Parameters
    ----------
    problem, compliance : the compliance on linear pressures over cells
    start : the initial contact of the unworn face, on a pressure space fitted to its edges
    step_length : factor on the lengths of steps in time
    in_layers : whether the contact covers the face from the start, so that steps in time must also
        resolve the slopes of the thin layers that wear makes at ring edges and at the rim
    evolution : the wear in time, in the requested steps or in adaptive ones, if it is known
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
        evolution: Evolution | None = None,
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
        # The worn depth alone would be right after a few steps in thin layers, with slopes and
        # pressures that are far off (physics/test_random_scenes.py::
        # test_layers_where_the_rim_loses_contact_under_a_falling_force).
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
        self.evolution = evolution or (
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
        last, (depth, slope) = float(self.problem.times[-1]), self._allowed_errors.tolist()
        slope = slope if self.in_layers else np.inf
        return evolve(self._punch, last, depth, slope, self.step_length)

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
        pressed = UnwornPart(
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

    def times_near(self, remaining_part: float) -> Array:
        """Return the times at which about a part of the running-in remains, whose errors are alike.

        The difference of such a time to a coarser evaluation may cross zero.
        """
        return np.array([self.evolution.time_until(f * remaining_part) for f in PARTS_NEAR])

    def factor(self, name: str) -> float:
        """Return the factor on the difference of a quantity, smaller if that is of second order."""
        one_force = self.problem.indentation is None and not self.problem.loading.varies
        if one_force and name in SECOND_ORDER:
            return error_factor("moving contact, energies and volumes")
        return self.safety

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity, times the excess of the errors of steps."""
        return self._excess_of_steps * super().estimate(name, difference)

    @property
    def _excess_of_steps(self) -> float:
        """Greatest error that a step added over the error that it may add; at least 1.

        The errors of steps that are far too long have no order, so that two marches may agree by
        chance.
        """
        excess = self.evolution.statistics.greatest_errors / self._allowed_errors
        return max(1.0, float(excess.max()))

    def least_error(self, name: str) -> Array | float:
        """Return a part of the tolerance, but at least what cells do not resolve of the face.

        The indentations of two faces under one force differ by at most the difference of the faces.
        At the start, elements that are fitted to the edges of the contact replace the cells.
        """
        least = error_factor("floor of moving contact") * self.problem.rtol
        if not DESCRIBED[name].over_time:
            return least
        floors = np.maximum(least, self._unresolved)
        if self.start is None:
            return floors
        by_kinks = error_factor("kinks inside elements") * self.start.unresolved_height
        at_start = np.maximum(error_factor("fitted start"), by_kinks * self._inverse_depth)
        return np.where(self._fitted, at_start, floors)

    @property
    def _fitted(self) -> Mask:
        """Whether each of the times (T,) is the start of a contact that is fitted to its edges."""
        return (self.problem.times == 0) & (self.start is not None)

    @cached_property
    def _unresolved(self) -> Array:
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

    def _lost_bend(self) -> Array:
        """Return the bend (T,) of the worn face and the displacement that linear functions lose.

        If an edge stays in the same cell of both meshes, their difference does not show it. In
        random punches whose face the cells resolve, no penetration is above 0.23 of the bend.
        """
        bending = self.sampler.worn_face(self.history).unresolved_bending
        return error_factor("lost bend") * bending * self._inverse_depth

    def _lost_bend_of_worn_face(self) -> Array:
        """Return the same (T,) for the face, which is exact at the start."""
        return np.where(self.problem.times > 0, self._lost_bend(), 0.0)

    def _pressure_at_free_edges(self) -> Array:
        """Return the pressure (T,) that a line misses where it vanishes as a root, or jumps.

        Both meshes miss the same if they have the edge at the same place of a cell.
        """
        beside = pressures_beside_edges(
            self.compliance.space,
            self.history.contact,
            self.history.pressure,
            self.problem.merged.wear_coefficients,
        )
        return error_factor("pressure at free edges") * beside

    def _cell_at_edge(self) -> Array:
        """Return the width (T,) of the cell in which the outermost edge lies, until it has settled.

        Both meshes may have the edge in the same cell.
        """
        widths = widths_at_edges(self.compliance.space, self.history.contact)
        widths = np.where(self.evolution.settled(self.problem.times), 0.0, widths)
        return np.where(self._fitted, error_factor("edge of a fitted start"), widths)

    def _error_of_slopes_at_start(self) -> Array:
        """Return the error (T,) of slopes of the unworn face; NaN where a slope is infinite."""
        at_start = np.where(self._fitted, error_factor("edge of a fitted start"), 0.0)
        return at_start + 0.0 * self.results["rms_slope"]

    floors: ClassVar = {
        "profile": _lost_bend_of_worn_face,
        "displacement": _lost_bend,
        # also at a fitted start, because cells represent the face outside the contact
        **dict.fromkeys(("displacement_centre", "displacement_max"), lambda each: each._unresolved),
        "pressure": _pressure_at_free_edges,
        "contact_radius": _cell_at_edge,
        "contact_radius_end": lambda each: each._cell_at_edge()[-1],
        "rms_slope": _error_of_slopes_at_start,
    }

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
        unresolved, cells = float(self._unresolved.max()), len(self.compliance.space.degrees)
        if unresolved <= self.problem.rtol:
            return []
        return [
            f"the face is finer than the {cells} cells resolve: its heights differ from those on "
            f"the cells by up to {unresolved:.1e} of the indentation; a smaller rtol makes more "
            "cells"
        ]
