"""A compliance, worn and sampled: everything that a problem asks of it.

Flat punches under a force keep full contact, and are exact in time; any other contact is marched.
"""

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..problem.quantities import CHANCE, CHANCE_OF_ENERGIES, ENERGIES, QUANTITIES
from ..wear.flat_contact import FittedPress
from ..wear.full_contact import RunningIn
from ..wear.history import History, Pressed
from ..wear.moments import moments, unresolved_height
from ..wear.moving_contact import ContactMarch
from .norms import Results
from .sampler import Sampler
from .spaces import load_of


class Evaluation(ABC):
    """One compliance, worn and sampled."""

    wear: RunningIn | None = None

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem, self.compliance = problem, compliance
        self.sampler = Sampler(problem, compliance.space)

    @property
    @abstractmethod
    def history(self) -> History:
        """The history at the times asked for, by the march asked for."""

    @property
    @abstractmethod
    def exact_in_time(self) -> History:
        """The history at the times asked for, to the accuracy asked for in time."""

    @property
    @abstractmethod
    def for_estimate(self) -> Results:
        """The quantities that errors are estimated by, on the face of the punch."""

    @abstractmethod
    def safety_of(self, name: str) -> float:
        """Return what the difference of a quantity to a coarser evaluation is multiplied by."""

    @abstractmethod
    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error of a quantity by its differences to a coarser evaluation.

        At the times asked for: the greatest near each, for differences cross zero now and then in
        time, where they say nothing.
        """

    @cached_property
    def results(self) -> Results:
        """The quantities at the times and radii asked for."""
        results, count = self._timeless(on_face=False), len(self.problem.times)
        # fields of a hundred thousand times at once would fill the memory; a march has few
        pieces = 1 + count // 1024 if self.problem.full_contact else 1
        sampled = [
            self.sampler.history(self.history[piece])
            for piece in np.array_split(np.arange(count), pieces)
            if len(piece)
        ]
        for name in sampled[0] if sampled else ():
            results[name] = np.concatenate([values[name] for values in sampled])
        return results

    @cached_property
    def checked(self) -> Results:
        """The quantities at the times that are checked, on the face of the punch: what is compared
        with another method.
        """
        results = self._timeless(on_face=True)
        if len(self.problem.times):
            results |= self.sampler.history(self.history[self.problem.checked], on_face=True)
        return results

    def _timeless(self, on_face: bool) -> Results:
        """Return the quantities of no time."""
        return {}


class FullContact(Evaluation):
    """A flat punch, by its relaxation modes or in the steps that are asked for.

    Parameters
    ----------
    problem, compliance : on a space that suits singular pressures at ring edges and rim
    safety : what differences to a coarser one are multiplied by
    """

    def __init__(self, problem: Problem, compliance: Compliance, safety: float = 1.5) -> None:
        super().__init__(problem, compliance)
        self.safety = safety
        wear_coefficients = problem.merged.wear_coefficients
        self.wear: RunningIn = RunningIn(
            compliance,
            wear_coefficients,
            problem.earliest if problem.march == "modal" else 0.0,
            indentation=problem.indentation,
            loading=problem.loading,
        )

    @cached_property
    def history(self) -> History:
        problem = self.problem
        return self.wear.history(problem.times, problem.march, problem.step)

    @property
    def exact_in_time(self) -> History:
        return self.wear.modal(self.problem.times)

    @cached_property
    def for_estimate(self) -> Results:
        results, times = self._timeless(on_face=True), self.problem.estimate_times
        if len(times):
            results |= self.sampler.history(self.wear.modal(times), on_face=True)
        return results

    def _timeless(self, on_face: bool) -> Results:
        problem, results = self.problem, Results()
        # by itself, a relaxation time needs no history
        marched = len(problem.times) > 0
        if problem.wants("relaxation_time") and (marched or problem.quantities is not None):
            times = self.wear.relaxation_times if marched else self.wear.slowest_times
            results["relaxation_time"] = times
        if problem.steady:
            results |= self.sampler.steady(self.wear.steady, on_face=on_face)
        return results

    def safety_of(self, name: str) -> float:
        return self.safety

    def estimate(self, name: str, difference: Array) -> Array:
        error = self.safety_of(name) * difference
        if QUANTITIES[name].dims[:1] == ("time",):
            grid, times, factor = self.problem.estimate_times, self.problem.times[:, None], 2.5
            near = (grid >= times / factor) & (grid <= times * factor)
            error = np.where(near, error, 0.0).max(axis=1)
        return np.maximum(error, self._least_error(name))

    def _least_error(self, name: str) -> Array | float:
        """Return what a quantity is not known better than."""
        breakpoints = self.compliance.space.breakpoints
        chance = self.problem.rtol * (CHANCE_OF_ENERGIES if name in ENERGIES else CHANCE)
        # of the numbers of elements
        least = max(chance, 1e-14 * len(breakpoints))
        size = float(np.diff(breakpoints)[-1])
        # the width of the element at the rim is known to roundoff, with the force that it carries,
        # the root of its width
        unknown = float(np.finfo(float).eps / np.sqrt(size))
        # measured: the element at the rim costs the flat start .06 to .11 of its size
        stiffness = 0.2 * size + 0.1 * unknown
        at_start = {
            "indentation": stiffness,
            "normal_force": stiffness,
            # it moves the other functions that the start is sought among
            "pressure": 3.0 * size + unknown,
            "ring_force": unknown,
        }
        if name not in at_start:
            return least
        pressed = self.problem.loading.pressed(self.problem.times) > 0
        return np.where(pressed, max(at_start[name], least), least)


class MovingContact(Evaluation):
    """A punch whose contact opens, closes and spreads.

    Parameters
    ----------
    problem, compliance : on linear pressures over cells
    start : a press of the unworn face that is fitted to the edges of the contact
    looser : how many times larger the error of a step in time may be
    """

    # edges move, and seldom to the same place in a cell
    safety = 2.5

    def __init__(
        self,
        problem: Problem,
        compliance: Compliance,
        start: FittedPress | None = None,
        looser: float = 1.0,
    ) -> None:
        super().__init__(problem, compliance)
        self.start, self.looser = start, looser
        # of the accuracy asked for, that each step may add to the worn depth: cells do not get
        # coarser than 1e-3 asks for, and steps, too few to tell their error by, would save nothing
        self._tolerance = 0.05 * looser * min(problem.rtol, 1e-3)
        if np.ptp(problem.loading.forces):
            # measured: while a force rises from zero, little has worn for how deep the punch is
            self._tolerance *= 0.02

    @cached_property
    def march(self) -> ContactMarch:
        """The punch on its compliance."""
        problem, compliance = self.problem, self.compliance
        of_profile = moments(problem.profile, compliance.space)
        wear_coefficients, load = problem.merged.wear_coefficients, load_of(problem)
        return ContactMarch(compliance, wear_coefficients, of_profile, load, problem.loading)

    @cached_property
    def exact_in_time(self) -> History:
        return self._started(self.march.adaptive(self.problem.times, self._tolerance))

    @cached_property
    def history(self) -> History:
        if self.problem.step is None:
            return self.exact_in_time
        return self._started(self.march.implicit(self.problem.times, self.problem.step))

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

    @cached_property
    def for_estimate(self) -> Results:
        # the coarser one is asked for all of the times that are watched
        watched = self._started(self.march.watched) if self.looser == 1 else self.history
        return self.sampler.history(watched, on_face=True)

    def estimate(self, name: str, difference: Array) -> Array:
        times = self.march.times
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
        if self._decays(name):
            # forces at a given indentation go as no more than the square of the depth, and their
            # errors stay while they decay
            return 2 * self.safety
        # under one load energies and volumes are of second order and more in the cells, which makes
        # a difference three times the error
        converges = name in (*ENERGIES, "ring_worn_volume") and not self.problem.loading.varies
        return 1.5 if converges else self.safety

    def _decays(self, name: str) -> bool:
        return self.problem.indentation is not None and name in ("normal_force", "ring_force")

    def _least_error(self, name: str) -> Array:
        """Return what a quantity is not known better than, at the times asked for."""
        later = self.problem.times > 0
        if self._starts_on_cells and name != "profile":
            later = np.ones_like(later)
        # slopes of the unworn face are differences of heights; edges are sought to a few times
        # their tolerance; at the start nothing has worn; and edges of the contact leave more to
        # chance
        at_start = {"rms_slope": 1e-8, "contact_radius": 5e-8}.get(name, 1e-12)
        least = np.where(later, 2 * CHANCE * self.problem.rtol, at_start)
        if name in ("profile", "displacement"):
            # cells lose this of the bend of fields: where an edge stays in a cell of both meshes,
            # their difference says nothing of it. Of punches drawn at random none penetrates by
            # more than .23 of it where cells hold the face
            lost = 0.25 * self._bends * self._per_depth
            least = np.maximum(least, np.where(later | (name != "profile"), lost, 0.0))
        if self._decays(name):
            # of a force in the end, when little of what was pressed in still overlaps, nothing is
            # known but that it is small
            force, full = self.history.force, self.history.contact.all(axis=1)
            first = np.where(full, force, force.max())
            decayed = first / np.maximum(force, np.finfo(float).tiny)
            return 2 * np.maximum(least, np.minimum(self._unresolved * decayed, 5.0))
        heights = QUANTITIES[name].norm == "indentation"
        # the unworn face is given, and a press that is fitted to its edges integrates all of it
        exact = name == "profile" or (name == "indentation" and self.start is not None)
        felt = heights & (later | (not exact))
        return np.where(felt, np.maximum(least, self._unresolved), least)

    @cached_property
    def _unresolved(self) -> Array:
        """(T,) by how much heights of the face differ from what cells hold, over the
        indentation.
        """
        depth, space = float(self.history.indentation.max()), self.compliance.space
        return unresolved_height(self.problem.profile, space, depth) * self._per_depth

    @property
    def _per_depth(self) -> Array:
        """(T,) the inverse of the indentation, of which nothing is promised while that is zero."""
        depth = self.history.indentation
        return np.divide(1.0, depth, out=np.zeros(len(depth)), where=depth > 0)

    @cached_property
    def _bends(self) -> Array:
        """(T,) greatest change of a slope from a cell to the next, times the wider of them, of the
        worn depth and of the displacement.
        """
        history, space = self.history, self.compliance.space
        width = np.diff(space.breakpoints)
        wider = np.where(np.diff(space.ring) == 0, np.maximum(width[1:], width[:-1]), 0.0)
        greatest = np.zeros(len(history.distances))
        for field in (history.profile, self.sampler.displaced(history)):
            slope = (field[:, space.dofs[:, 1]] - field[:, space.dofs[:, 0]]) / width
            # at the axis the next cell is the same on the other side
            change = np.abs(np.diff(slope, axis=1, prepend=-slope[:, :1]))
            greatest = np.maximum(greatest, (change * np.append(width[0], wider)).max(axis=1))
        return greatest

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
