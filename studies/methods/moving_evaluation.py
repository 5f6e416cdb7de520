"""A compliance on cells, worn and sampled: a punch whose contact opens, closes and spreads."""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..contact.march import ContactMarch
from ..contact.marched import Marched
from ..contact.moments import moments, unresolved_height
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED
from ..sampling.answers import moving_answers
from ..sampling.norms import Results
from ..wear.flat_contact import FittedPress
from ..wear.history import History, Pressed
from .error_factors import error_factor
from .evaluation import ENDS, Evaluation
from .spaces import load_of

# numbers of the answer that are a quantity at the first or at the last of the times
REPORTED_AT = {
    "indentation_start": ("indentation", 0),
    "force_start": ("normal_force", 0),
    "force_share": ("ring_force", 0),
    "force_end": ("normal_force", -1),
    "worn_volume": ("ring_worn_volume", -1),
}


class MovingContact(Evaluation):
    """A punch whose contact opens, closes and spreads, marched through the times asked for.

    Parameters
    ----------
    problem, compliance : on linear pressures over cells
    start : a press of the unworn face that is fitted to the edges of the contact
    step_tolerance_factor : how many times larger the error of a step in time may be

    Attributes
    ----------
    marched : the march, in the steps asked for or in adaptive ones
    """

    # edges move, and seldom to the same place in a cell
    safety = error_factor("moving contact")

    def __init__(
        self,
        problem: Problem,
        compliance: Compliance,
        start: FittedPress | None = None,
        step_tolerance_factor: float = 1.0,
    ) -> None:
        super().__init__(problem, compliance)
        self.start = start
        # of the accuracy asked for, that each step may add to the worn depth: cells do not get
        # coarser than 1e-3 asks for, and steps, too few to tell their error by, would save nothing
        self._tolerance = 0.05 * step_tolerance_factor * min(problem.rtol, 1e-3)
        if np.ptp(problem.loading.forces):
            # measured: while a force rises from zero, little has worn for how deep the punch is
            self._tolerance *= 0.02
        self._march = ContactMarch(
            compliance,
            problem.merged.wear_coefficients,
            moments(problem.profile, compliance.space),
            load_of(problem),
            problem.loading,
        )
        self.marched = (
            self._marched_adaptively
            if problem.step is None
            else self._march.implicit(problem.times, problem.step)
        )

    @cached_property
    def _marched_adaptively(self) -> Marched:
        return self._march.adaptive(self.problem.times, self._tolerance)

    @cached_property
    def exact_in_time(self) -> History:
        """The history at the times asked for, in steps that suit the accuracy asked for."""
        return self._started(self._marched_adaptively.history)

    @cached_property
    def history(self) -> History:
        """The history at the times asked for, in the steps asked for or in adaptive ones."""
        return self._started(self.marched.history)

    def _started(self, history: History) -> History:
        # what does not press yet just touches
        resting = (history.distances == 0) & (history.force == 0)
        history = replace(history, indentation=np.where(resting, 0.0, history.indentation))
        if self.start is None:
            return history
        started = (history.distances == 0) & (history.force == history.force[0])
        indentation = np.where(started, self.start.indentation, history.indentation)
        pressed = Pressed(
            self.start,
            np.where(started, self.start.force, 0.0),
            np.where(started[:, None], 0.0, history.pressure),
        )
        return replace(history, indentation=indentation, pressed=pressed)

    @property
    def estimate_times(self) -> Array:
        """The times that the march watches: those asked for, and some between."""
        return self.marched.estimate_times

    def for_estimate(self, times: Array) -> Results:
        """Return the quantities on the face of the punch at some of the times that are watched."""
        rows = np.flatnonzero(np.isin(self.marched.estimate_times, times))
        return self.sampler.history(
            self._started(self.marched.estimate_history[rows]), on_face=True
        )

    @cached_property
    def answers(self) -> Results:
        """The numbers of the answer, by the march and the step asked for."""
        return moving_answers(self.problem, self.marched, self.start, self.history[ENDS])

    @property
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, in steps that suit the accuracy asked for."""
        ends = self.exact_in_time[ENDS]
        return moving_answers(self.problem, self._marched_adaptively, self.start, ends)

    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error of a number of the answer by its difference to a coarser evaluation.

        A number that is a quantity at the first or the last time has the error of that quantity.
        The error of any other is its difference times its safety factor, or a floor if that is
        greater.
        """
        if name in REPORTED_AT:
            quantity, row = REPORTED_AT[name]
            if quantity in errors:
                return np.broadcast_to(errors[quantity][row], difference.shape)
        least = {"contact_radius_start": 5e-8, "pressure_peak_start": 1e-12}
        floor = least.get(name, error_factor("floor of moving contact") * self.problem.rtol)
        # the step in which the last node begins to carry is another in both marches
        step = error_factor("time to full contact") if name == "time_to_full_contact" else 1.0
        return np.maximum(step * self.safety_of(name) * difference, floor)

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error of a quantity by its differences to a coarser evaluation.

        The differences are multiplied by the safety factor of the quantity. At each time asked for,
        the error is the greatest among seven neighbouring times of the march, because differences
        cross zero now and then; a start that is fitted to the edges of the contact keeps its own.
        No error is below the least error of the quantity.
        """
        times = self.estimate_times
        error = self.safety_of(name) * difference
        later = (times > 0) | self._starts_on_cells
        if later.any():
            among = np.pad(error[later], 3)
            error[later] = sliding_window_view(among, 7).max(axis=1)
        return np.maximum(error[np.isin(times, self.problem.times)], self._least_error(name))

    @property
    def _starts_on_cells(self) -> bool:
        """Whether what presses at the time 0 is not fitted to the edges of its contact."""
        return self.start is None and self.problem.loading.forces[0] > 0

    def safety_of(self, name: str) -> float:
        """Return what the difference of a quantity to a coarser evaluation is multiplied by.

        The factor is larger for forces that decay at a given indentation, and another for energies
        and volumes under one load.
        """
        if self._decays(name):
            # forces at a given indentation go as no more than the square of the depth, and their
            # errors stay while they decay
            return error_factor("decaying force") * self.safety
        # under one load energies and volumes are of second order and more in the cells, which makes
        # a difference three times the error
        if name in self.problem.load_regime.second_order:
            return error_factor("moving contact, energies and volumes")
        return self.safety

    def _decays(self, name: str) -> bool:
        return name in self.problem.load_regime.decaying

    def _least_error(self, name: str) -> Array:
        """Return what a quantity is not known better than, at the times asked for."""
        later = self.problem.times > 0
        if self._starts_on_cells and name != "profile":
            later = np.ones_like(later)
        # slopes of the unworn face are differences of heights; edges are sought to a few times
        # their tolerance; at the start nothing has worn; and edges of the contact leave more to
        # chance
        at_start = {"rms_slope": 1e-8, "contact_radius": 5e-8}.get(name, 1e-12)
        floor = error_factor("floor of moving contact") * self.problem.rtol
        least = np.where(later, floor, at_start)
        if name in ("profile", "displacement"):
            # cells lose this of the bend of fields: where an edge stays in a cell of both meshes,
            # their difference says nothing of it. Of punches drawn at random none penetrates by
            # more than .23 of it where cells hold the face
            lost = error_factor("lost bend") * self._lost_bends * self._per_depth
            least = np.maximum(least, np.where(later | (name != "profile"), lost, 0.0))
        if name == "contact_radius":
            # where both meshes have an edge in the same cell, their difference says nothing of it
            return np.maximum(least, np.where(later, self._cells_at_edge, 0.0))
        if self._decays(name):
            return error_factor("decaying force") * np.maximum(least, self._unresolved)
        heights = DESCRIBED[name].norm == "indentation"
        # the unworn face is given, and a press that is fitted to its edges integrates all of it
        exact = name == "profile" or (name == "indentation" and self.start is not None)
        by_cells = heights & (later | (not exact))
        return np.where(by_cells, np.maximum(least, self._unresolved), least)

    @cached_property
    def _unresolved(self) -> Array:
        """(T,) by how much heights differ from what cells hold, over the indentation."""
        depth, space = float(self.history.indentation.max()), self.compliance.space
        return unresolved_height(self.problem.profile, space, depth) * self._per_depth

    @property
    def _per_depth(self) -> Array:
        """(T,) the inverse of the indentation, of which nothing is promised while that is zero."""
        depth = self.history.indentation
        return np.divide(1.0, depth, out=np.zeros(len(depth)), where=depth > 0)

    @cached_property
    def _lost_bends(self) -> Array:
        """(T,) greatest bend of the worn face, or of the displacement, that cells lose."""
        return self.sampler.worn_face(self.history).unresolved_bending

    @cached_property
    def _cells_at_edge(self) -> Array:
        """(T,) size of the cell that the outermost edge of the contact lies in."""
        breakpoints = self.compliance.space.breakpoints
        radii = self.results["contact_radius"]
        cell = np.clip(np.searchsorted(breakpoints, radii), 1, len(breakpoints) - 1)
        return np.asarray(np.diff(breakpoints)[cell - 1])

    @property
    def settings(self) -> dict[str, int]:
        """How large the march was, for the summary."""
        space = self.compliance.space
        settings = {
            "cells": len(space.degrees),
            "pressures": space.size,
            "steps": self.history.steps.taken,
        }
        if self.start is not None:
            settings["start_pressures"] = len(self.start.pressure)
        return settings

    def notes(self) -> list[str]:
        """Say what the user should know of the cells."""
        missed, cells = float(self._unresolved.max()), len(self.compliance.space.degrees)
        if missed <= self.problem.rtol:
            return []
        return [
            f"the face is finer than the {cells} cells resolve: heights differ from what they hold "
            f"by up to {missed:.1e} of the indentation; a smaller rtol makes more cells"
        ]
