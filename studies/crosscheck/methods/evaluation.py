"""Evaluation of one compliance: the wear history on it, and all quantities that a problem wants.

`FullContact` evaluates flat punches under a force, which stay in full contact and are exact in
time. `moving_evaluation.MovingContact` marches any other contact. The error estimate compares a
fine and a coarser evaluation (`estimates.estimate_errors`); `Evaluation.estimate` multiplies their
difference by a factor.
"""

from abc import ABC, abstractmethod
from collections.abc import Set
from functools import cached_property
from typing import ClassVar

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array, Indices
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES, DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..sizes.ring_edges import amplified_roundoff, missing_layers, root_of_unresolved_wear
from ..wear.full_contact import RunningIn
from ..wear.history import History
from .error_factors import error_factor
from .sampling.answers import FlatRun, SteadyRun, answers_of
from .sampling.sampler import Sampler

# Indices of the first and of the last of the times.
ENDS = np.array([0, -1])


def near_in_time(times: Array, others: Array) -> tuple[Indices, Indices]:
    """Return the range (T,), (T,) of other times whose errors are like that at each time.

    The others (O,) increase. The range begins with the first index and ends before the second.
    """
    factor = error_factor("nearby times")
    first = np.searchsorted(others, times / factor, side="left")
    return first, np.searchsorted(others, times * factor, side="right")


def greatest_in_ranges(values: Array, first: Indices, last: Indices) -> Array:
    """Return the greatest of values (O,), none negative, in each of the ranges; 0 in an empty one.

    A range begins with `first` (T,) and ends before `last` (T,).
    """
    pairs = np.stack([first, np.maximum(first, last)], axis=1).ravel()
    greatest = np.maximum.reduceat(np.append(values, 0.0), pairs)[::2]
    return np.where(first < last, greatest, 0.0)


def _growing_errors(errors: Array) -> Array:
    """Return errors (m,) of relaxation times that do not fall from one to the next faster one.

    The next faster mode counts as well, but not one that is only reported for a mode that is
    compared with other methods: the discretisation may not resolve it.
    """
    with_next = np.append(errors[1:], errors[-1:])
    last = COMPARED_MODES - 1
    with_next[last : last + 1] = errors[last : last + 1]
    return np.maximum.accumulate(np.maximum(errors, with_next))


class Evaluation(ABC):
    """The wear history on one compliance, and the quantities sampled from it."""

    wear: RunningIn | None = None
    # Quantities that are displacements at one place. Their differences cross zero now and then, so
    # that their error is at least a part of the error of the whole field.
    point_values: ClassVar[Set[str]] = frozenset()

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem, self.compliance = problem, compliance
        self.sampler = Sampler(problem, compliance.space, compliance)

    @property
    @abstractmethod
    def history(self) -> History:
        """The history at the requested times, by the requested march."""

    def history_at(self, rows: Indices) -> History:
        """Return the history at some of the requested times, given by their indices."""
        return self.history[rows]

    @property
    @abstractmethod
    def exact_in_time(self) -> History:
        """The history at the requested times, as accurate in time as the tolerance requires."""

    @property
    @abstractmethod
    def estimate_times(self) -> Array:
        """The times at which the error is estimated by the difference to a coarser evaluation."""

    @abstractmethod
    def results_for_estimate(self, times: Array) -> Results:
        """Return the quantities on the face of the punch that the error estimate compares."""

    @abstractmethod
    def safety_factor(self, name: str) -> float:
        """Return the factor on the difference of a quantity to a coarser evaluation."""

    @abstractmethod
    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity: factor times difference to a coarser evaluation.

        The estimate at each requested time is the largest near that time, because differences cross
        zero now and then and are meaningless there.

        Parameters
        ----------
        name : name of the quantity
        difference : relative difference, at `estimate_times` if the quantity depends on time
        """

    @property
    @abstractmethod
    def answers(self) -> Results:
        """The numbers of the answer, by the requested march."""

    @property
    @abstractmethod
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, as accurate in time as the tolerance requires."""

    @abstractmethod
    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error estimate of a number of the answer.

        Parameters
        ----------
        name : name of the number
        difference : its relative difference to a coarser evaluation
        errors : error estimates of the quantities at the requested times
        """

    def times_near(self, remaining_part: float) -> Array:
        """Return the times at which about a part of the running-in remains, whose errors are alike.

        There are none if such times cannot agree by chance.
        """
        return np.empty(0)

    @cached_property
    def results(self) -> Results:
        """The quantities at the requested times and radii."""
        results, count = self._time_independent(on_face=False), len(self.problem.times)
        return results | self.sampler.at_times(self.history_at, count) if count else results

    @cached_property
    def compared(self) -> Results:
        """The quantities at the times `problem.compared_rows`, on the face of the punch.

        These are compared with other methods.
        """
        results = self._time_independent_on_face
        if len(self.problem.times):
            results = results | self.sampler.history(
                self.history_at(self.problem.compared_rows), on_face=True
            )
        return results

    @cached_property
    def _time_independent_on_face(self) -> Results:
        return self._time_independent(on_face=True)

    def _time_independent(self, on_face: bool) -> Results:
        """Return the quantities that do not depend on time."""
        return {}


class FullContact(Evaluation):
    """A flat punch in full contact, by its relaxation modes or in the requested time steps.

    Parameters
    ----------
    problem, compliance : the compliance on a space that suits singular pressures at ring edges and
        rim
    safety : factor on the difference to a coarser evaluation
    smallest : smallest element size at a ring edge that the method can use, in punch radii
    slope_roundoff : relative roundoff of RMS slopes where wear has smoothed the whole face
    least_error : least relative error of every quantity, beyond the roundoff of sums
    same_elements : whether the coarser evaluation has the same elements, of a lower degree
    """

    point_values = frozenset({"displacement_centre", "displacement_max"})

    def __init__(
        self,
        problem: Problem,
        compliance: Compliance,
        safety: float = error_factor("flat punch"),
        smallest: float = 0.0,
        slope_roundoff: float = 0.0,
        least_error: float = 0.0,
        same_elements: bool = False,
    ) -> None:
        super().__init__(problem, compliance)
        self._slope_roundoff, self._least_error = slope_roundoff, least_error
        self._same_elements = same_elements
        wear_factor = error_factor("wear along the radius") if problem.merged.linear else 1.0
        self.safety, self.smallest, self._wear_factor = wear_factor * safety, smallest, wear_factor
        wear_coefficients = problem.merged.wear_coefficients
        self.wear: RunningIn = RunningIn(
            compliance,
            wear_coefficients,
            problem.shortest_decay if problem.march == "modal" else 0.0,
            indentation=problem.indentation,
            loading=problem.loading,
        )

    @cached_property
    def history(self) -> History:
        """The history at the requested times, by the requested march and step."""
        problem = self.problem
        return self.wear.history(problem.times, problem.march, problem.step)

    def history_at(self, rows: Indices) -> History:
        """Return the history at some of the requested times, given by their indices."""
        if self.problem.march == "modal" and len(self.problem.times) > self.sampler.times_at_once():
            # the coefficients at all times would fill the memory
            return self.wear.modal(self.problem.times[rows])
        return self.history[rows]

    @property
    def exact_in_time(self) -> History:
        """The history at the requested times, by relaxation modes, which are exact in time."""
        return self.wear.modal(self.problem.times)

    @property
    def estimate_times(self) -> Array:
        """The requested times, and some near them."""
        return self.problem.estimate_times

    def results_for_estimate(self, times: Array) -> Results:
        """Return the quantities on the face at some times, and those that do not depend on time.

        The history is that of the relaxation modes.
        """
        results = self._time_independent_on_face
        if len(times):
            results = results | self.sampler.history(self.wear.modal(times), on_face=True)
        return results

    def _time_independent(self, on_face: bool) -> Results:
        problem, results = self.problem, Results()
        # relaxation times need no history if the scene asks for them alone
        marched = len(problem.times) > 0
        if problem.wants("relaxation_time") and (marched or problem.quantities is not None):
            times = self.wear.relaxation_times if marched else self.wear.slowest_times
            results["relaxation_time"] = times
        if problem.steady:
            results |= self.sampler.steady(self.wear.steady, on_face=on_face)
        return results

    @cached_property
    def answers(self) -> Results:
        """The numbers of the answer, by the requested march and step."""
        return self._answers(self.history_at(ENDS) if len(self.problem.times) else None)

    @property
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, by relaxation modes, which are exact in time."""
        times = self.problem.times
        return self._answers(self.wear.modal(times[ENDS]) if len(times) else None)

    def _answers(self, ends: History | None) -> Results:
        """Return the answer from the history at the first and at the last time."""
        steady = self._time_independent_on_face
        if ends is None:
            return answers_of(SteadyRun(self.problem, steady))
        return answers_of(FlatRun(self.problem, self.wear, steady, ends))

    def safety_factor(self, name: str) -> float:
        """Return the factor on differences to a coarser evaluation, the same for every quantity."""
        return self.safety

    @cached_property
    def _missing_layers(self) -> Array:
        return missing_layers(self.problem, self.smallest)

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity: factor times difference to a coarser evaluation.

        - The factor is `safety_factor`, or, for fields by a lower degree on the same elements,
          that of `_factor_on_same_elements`.
        - Quantities that depend on thin layers at ring edges get the same difference once more for
          each layer that the mesh lacks, if the march is by modes and the coarser mesh lacks one
          layer more.
        - At each requested time, the error is the largest at nearby times, because differences
          cross zero now and then. For the same reason, the error of a relaxation time is at least
          that of any slower one.
        - The error is at least the floor of the quantity.
        """
        if self._same_elements:
            error = self._factor_on_same_elements(name) * difference
        else:
            error = self.safety_factor(name) * difference
        if name == "relaxation_time":
            error = _growing_errors(error)
        lacks_layers = name in LAYER_QUANTITIES and not self._same_elements
        if lacks_layers and self.problem.march == "modal":
            # the coarser mesh lacks one layer more than this one, and each layer makes about the
            # same difference
            error = error * (1 + self._missing_layers)
        if DESCRIBED[name].over_time:
            near = near_in_time(self.problem.times, self.problem.estimate_times)
            error = greatest_in_ranges(error, *near)
        return np.maximum(error, self._floor(name))

    def _factor_on_same_elements(self, name: str) -> Array | float:
        """Return the factor on a difference to a degree less: one number, or one for each time.

        If the elements resolve the layers that wear has made, fields converge with the degree, and
        the difference is mostly the error of the lower degree. If not, both degrees miss the same
        part of the layers.
        """
        resolved = self._wear_factor * error_factor("resolved fields on triangles")
        if not DESCRIBED[name].over_time:
            return resolved
        if name in ENERGIES:
            return self.safety
        thin = self.safety
        if name == "pressure":
            thin = self._wear_factor * error_factor("pressures of thinner layers than triangles")
        return np.where(self._missing_layers <= 1, resolved, thin)

    def estimate_answer(self, name: str, difference: Array, errors: Results) -> Array:
        """Return the error estimate of a number of the answer.

        It is the difference times the safety factor, but at least the floor of that number.
        """
        return np.maximum(self.safety_factor(name) * difference, self._floor_of_answer(name))

    def _floor_of_answer(self, name: str) -> float:
        """Return the smallest error that is reported for a number of the answer."""
        floor = self._floor_by_chance(name)
        if name in ("indentation_start", "force_start"):
            return max(floor, self._start_error_at_rim)
        if name in ("pressure_min", "pressure_max"):
            # the element at the rim changes the coefficients of all other functions of the start
            return max(floor, error_factor("pressure at the rim") * self._rim_size)
        if name in self.problem.remaining_parts:
            return max(floor, self._time_error_by_start(self.problem.remaining_parts[name]))
        return floor

    def _time_error_by_start(self, remaining_part: float) -> float:
        """Return the error of a running-in time (`time_to_90`, ...) that the flat start causes.

        The whole change during running-in begins with the flat start, whose error comes from the
        element at the rim. The part that is left has the same absolute error, and the time has that
        error over its rate of decay.
        """
        total_change, time = self.wear.total_change, self.wear.time_until(remaining_part)
        if not (total_change > 0 and time > 0):
            return 0.0
        start = total_change if self.problem.indentation is not None else self.wear.flat.indentation
        relative_step = 1e-3
        left_before, left_after = self.wear.modes.remaining_change(
            time * np.array([1 - relative_step, 1 + relative_step])
        )
        decay = np.log(left_before / left_after) / (2 * relative_step)
        return float(self._start_error_at_rim * start / total_change / decay)

    def _floor_by_chance(self, name: str) -> float:
        """Return the difference below which two solutions may agree by chance.

        It is at least the roundoff of sums over all elements.
        """
        part_of_rtol = error_factor("floor of energies" if name in ENERGIES else "floor")
        elements = len(self.compliance.space.degrees)
        by_chance = max(self._wear_factor * self.problem.rtol * part_of_rtol, 1e-14 * elements)
        return max(by_chance, self._least_error)

    @property
    def _rim_size(self) -> float:
        """Width of the element at the rim, or of the element at the hole if that is wider.

        The pressure is infinite at both.
        """
        return max(self._sizes_at_rim_and_hole)

    @property
    def _sizes_at_rim_and_hole(self) -> tuple[float, float]:
        """Width of the element at the rim, and of the element at the hole (0 without a hole)."""
        space = self.compliance.space
        return float(space.widths[-1]), float(space.widths[0]) if space.inner_radius else 0.0

    @property
    def _rim_force_roundoff(self) -> float:
        """Error of the force, over the force, by roundoff in the width of the element at the rim.

        The force on that element is proportional to the root of its width. There is no such error
        if the space stores the low parts of radii.
        """
        if self.compliance.space.low_parts is not None:
            return 0.0
        return float(np.finfo(float).eps / np.sqrt(self._rim_size))

    @property
    def _start_error_at_rim(self) -> float:
        """Error of the indentation of the flat start that the element at the rim causes.

        Measured: 0.06 to 0.11 of the width of that element.
        """
        at_rim = error_factor("stiffness at the rim") * self._rim_size
        roundoff = error_factor("roundoff of the force at the rim") * self._rim_force_roundoff
        return at_rim + roundoff

    @property
    def _error_of_depth_at_rim(self) -> Array:
        """Error (T,) of the worn depth while wear has not smoothed a whole element at the rim."""
        at_rim, at_hole = self._sizes_at_rim_and_hole
        return error_factor("worn depth at the rim") * np.maximum(
            root_of_unresolved_wear(self.problem, at_rim),
            root_of_unresolved_wear(self.problem, at_hole, at_hole=True),
        )

    def _floor(self, name: str) -> Array | float:
        """Return the smallest error that is reported for a quantity."""
        floor, rim_size, roundoff = (
            self._floor_by_chance(name),
            self._rim_size,
            self._rim_force_roundoff,
        )
        at_start = {
            "indentation": self._start_error_at_rim,
            "normal_force": self._start_error_at_rim,
            # the element at the rim changes the coefficients of all other functions
            "pressure": error_factor("pressure at the rim") * rim_size + roundoff,
            "ring_force": roundoff,
        }
        if name in ("profile", "displacement"):
            return np.maximum(floor, self._error_of_depth_at_rim)
        if name == "rms_slope":
            return np.maximum(floor, self._slope_roundoff * amplified_roundoff(self.problem))
        if name not in at_start:
            return floor
        pressed = self.problem.loading.force_rise_at_rest(self.problem.times) > 0
        return np.where(pressed, max(at_start[name], floor), floor)
