"""A compliance, worn and sampled: everything that a problem asks of it.

Flat punches under a force keep full contact, and are exact in time; any other contact is marched.
"""

from abc import ABC, abstractmethod
from collections.abc import Set
from functools import cached_property
from math import inf, prod
from typing import ClassVar

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..sampling.answers import flat_answers
from ..sampling.norms import Results
from ..sampling.sampler import Sampler
from ..sizes.defaults import missing_layers
from ..wear.full_contact import RunningIn
from ..wear.history import History
from .error_factors import error_factor

# the first and the last of the times
ENDS = np.array([0, -1])


class Evaluation(ABC):
    """One compliance, worn and sampled."""

    wear: RunningIn | None = None
    # greatest number of times whose fields are sampled at once
    times_at_once: float = inf
    # numbers that are values of the displacement at one place, whose differences cross zero now and
    # then: their errors are at least a part of that of the field
    taken_from_field: ClassVar[Set[str]] = frozenset()

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem, self.compliance = problem, compliance
        self.sampler = Sampler(problem, compliance.space, compliance)

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
    def estimate_times(self) -> Array:
        """The times at which errors are estimated by the difference to a coarser evaluation."""

    @abstractmethod
    def for_estimate(self, times: Array) -> Results:
        """Return the quantities that errors are estimated by, on the face of the punch."""

    @abstractmethod
    def safety_of(self, name: str) -> float:
        """Return what the difference of a quantity to a coarser evaluation is multiplied by."""

    @abstractmethod
    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error of a quantity by its differences to a coarser evaluation.

        At the times asked for: the greatest near each, for differences cross zero now and then in
        time, where they say nothing.
        """

    @property
    @abstractmethod
    def answers(self) -> Results:
        """The numbers of the answer."""

    @property
    @abstractmethod
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, to the accuracy asked for in time."""

    @abstractmethod
    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error of a number of the answer by its difference to a coarser evaluation.

        `errors` are those of the quantities at the times asked for.
        """

    @cached_property
    def results(self) -> Results:
        """The quantities at the times and radii asked for."""
        results, count = self._timeless(on_face=False), len(self.problem.times)
        pieces = 1 + int(count // self.times_at_once)
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
        """The quantities at the times that are checked, on the face of the punch.

        They are what is compared with another method.
        """
        results = self._timeless_on_face
        if len(self.problem.times):
            results = results | self.sampler.history(
                self.history[self.problem.checked], on_face=True
            )
        return results

    @cached_property
    def _timeless_on_face(self) -> Results:
        return self._timeless(on_face=True)

    def _timeless(self, on_face: bool) -> Results:
        """Return the quantities of no time."""
        return {}


class FullContact(Evaluation):
    """A flat punch, by its relaxation modes or in the steps that are asked for.

    Parameters
    ----------
    problem, compliance : on a space that suits singular pressures at ring edges and rim
    safety : what differences to a coarser one are multiplied by
    smallest : least size of the elements that the method can have beside a ring edge
    """

    # fields of a hundred thousand times at once would fill the memory; a march has few
    times_at_once = 1024
    taken_from_field = frozenset({"displacement_centre", "displacement_max"})

    def __init__(
        self,
        problem: Problem,
        compliance: Compliance,
        safety: float = error_factor("flat punch"),
        smallest: float = 0.0,
    ) -> None:
        super().__init__(problem, compliance)
        graded = prod(map(error_factor, problem.wear_regime.error_factors))
        self.safety, self.smallest, self._graded = graded * safety, smallest, graded
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
        """The history at the times asked for, by the march and the step asked for."""
        problem = self.problem
        return self.wear.history(problem.times, problem.march, problem.step)

    @property
    def exact_in_time(self) -> History:
        """The history at the times asked for, by relaxation modes: exact in time."""
        return self.wear.modal(self.problem.times)

    @property
    def estimate_times(self) -> Array:
        """The times asked for, and some near them."""
        return self.problem.estimate_times

    def for_estimate(self, times: Array) -> Results:
        """Return the quantities on the face of the punch at times, and those of no time.

        The history is that of the modes.
        """
        results = self._timeless_on_face
        if len(times):
            results = results | self.sampler.history(self.wear.modal(times), on_face=True)
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

    @cached_property
    def answers(self) -> Results:
        """The numbers of the answer, by the march and the step asked for."""
        return self._answers(self.history[ENDS] if len(self.problem.times) else None)

    @property
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, by relaxation modes: exact in time."""
        times = self.problem.times
        return self._answers(self.wear.modal(times[ENDS]) if len(times) else None)

    def _answers(self, ends: History | None) -> Results:
        """Return the answer by the history at the first and the last time."""
        return flat_answers(self.problem, self.wear, self._timeless_on_face, ends)

    def safety_of(self, name: str) -> float:
        """Return what differences to a coarser evaluation are multiplied by, for every quantity."""
        return self.safety

    @cached_property
    def _missing_layers(self) -> Array:
        return missing_layers(self.problem, self.smallest)

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error of a quantity by its differences to a coarser evaluation.

        The differences are multiplied by the safety factor. Quantities that are felt in thin layers
        beside ring edges err by as much again for each layer that the mesh lacks, if the march is
        by modes. At each time asked for, the error is the greatest at nearby times, because
        differences cross zero now and then. No error is below the least error of the quantity.
        """
        error = self.safety_of(name) * difference
        if name in LAYER_QUANTITIES and self.problem.march == "modal":
            # the coarser one lacks one layer more, and each of them makes about the same difference
            error = error * (1 + self._missing_layers)
        if DESCRIBED[name].dims[:1] == ("time",):
            grid, times = self.problem.estimate_times, self.problem.times[:, None]
            factor = error_factor("nearby times")
            near = (grid >= times / factor) & (grid <= times * factor)
            error = np.where(near, error, 0.0).max(axis=1)
        return np.maximum(error, self._least_error(name))

    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error of a number of the answer by its difference to a coarser evaluation.

        It is the difference times the safety factor, or the least error of that number if it is
        greater.
        """
        return np.maximum(self.safety_of(name) * difference, self._least_error_of_answer(name))

    def _least_error_of_answer(self, name: str) -> float:
        """Return what a number of the answer is not known better than."""
        chance = self._chance(name)
        if name in ("indentation_start", "force_start"):
            return max(chance, self._stiffness_at_rim)
        if name in ("pressure_min", "pressure_max"):
            # the element at the rim moves the other functions that the start is sought among
            return max(chance, error_factor("pressure at the rim") * self._rim_size)
        if name in self.problem.load_regime.remaining_fractions:
            return max(
                chance, self._unknown_time(self.problem.load_regime.remaining_fractions[name])
            )
        return chance

    def _unknown_time(self, part: float) -> float:
        """Return by how much a time at which a part of the running-in is left errs with the start.

        The whole change begins with the flat start, which errs because of the element at the rim.
        The part that is left errs by as much, and the time by that over its rate of decay.
        """
        whole, time = self.wear.total_change, self.wear.time_until(part)
        if not (whole > 0 and time > 0):
            return 0.0
        start = whole if self.problem.indentation is not None else self.wear.flat.indentation
        nearby = 1e-3
        before, after = self.wear.modes.remaining_change(time * np.array([1 - nearby, 1 + nearby]))
        decay = np.log(before / after) / (2 * nearby)
        return float(self._stiffness_at_rim * start / whole / decay)

    def _chance(self, name: str) -> float:
        """Return by how much two computations may agree by chance, of sums over the elements."""
        part = error_factor("floor of energies" if name in ENERGIES else "floor")
        elements = len(self.compliance.space.degrees)
        return max(self._graded * self.problem.rtol * part, 1e-14 * elements)

    @property
    def _rim_size(self) -> float:
        """Width of the element at the rim, or of that at a hole, if it is wider.

        At both pressures are infinite.
        """
        space = self.compliance.space
        carrying = space.widths[space.degrees > 0]
        return float(max(carrying[-1], carrying[0] if space.hollow else 0.0))

    @property
    def _unknown_rim_force(self) -> float:
        """Part of the force that roundoff in the width of the element at the rim leaves unknown.

        That element carries the root of its width, which is known where low parts of radii are.
        """
        if self.compliance.space.low_parts is not None:
            return 0.0
        return float(np.finfo(float).eps / np.sqrt(self._rim_size))

    @property
    def _stiffness_at_rim(self) -> float:
        """By how much the flat start errs because of the element at the rim.

        Measured: .06 to .11 of its size.
        """
        at_rim = error_factor("stiffness at the rim") * self._rim_size
        return at_rim + 0.1 * self._unknown_rim_force

    def _least_error(self, name: str) -> Array | float:
        """Return what a quantity is not known better than."""
        least, size, unknown = self._chance(name), self._rim_size, self._unknown_rim_force
        at_start = {
            "indentation": self._stiffness_at_rim,
            "normal_force": self._stiffness_at_rim,
            # it moves the other functions that the start is sought among
            "pressure": error_factor("pressure at the rim") * size + unknown,
            "ring_force": unknown,
        }
        if name not in at_start:
            return least
        pressed = self.problem.loading.force_rise_at_rest(self.problem.times) > 0
        return np.where(pressed, max(at_start[name], least), least)
