"""Evaluation of one compliance: the wear history on it, and all quantities that a problem wants.

`FullContact` evaluates flat punches under a force, which stay in full contact and are exact in
time. `moving_evaluation.MovingContact` marches any other contact. The error estimate compares a
fine and a coarser evaluation (`estimates.estimate_errors`). One rule holds for both kinds of
contact (`Evaluation.estimate`): a factor times the greatest difference at similar times, at least a
floor. Where two solutions miss the same, the difference does not show it; the floors of such
quantities are in `Evaluation.floors`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Set
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array, Indices
from ..problem.loading import Loading
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES, DESCRIBED, ENERGIES
from ..sizes.ring_edges import amplified_roundoff, missing_layers
from ..wear.full_contact import RunningIn
from ..wear.history import History
from .error_factors import error_factor
from .sampling.answers import FlatRun, SteadyRun, answers_of
from .sampling.sampler import Sampler

# Indices of the first and of the last of the times.
ENDS = np.array([0, -1])


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
    # factor on the difference to a coarser evaluation
    safety: float
    # Floors of quantities in which two evaluations may miss the same: functions of an evaluation
    # that return one number, or one for each requested time.
    floors: ClassVar[Mapping[str, Callable[[Any], Array]]] = {}
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

    @cached_property
    def similar_times(self) -> tuple[Indices, Indices]:
        """Ranges (T,), (T,) of `estimate_times` at which errors are like that at each time."""
        earliest, latest = range_near(self.problem.times, self.problem.loading)
        times = self.estimate_times
        return np.searchsorted(times, earliest), np.searchsorted(times, latest, side="right")

    @abstractmethod
    def least_error(self, name: str) -> Array | float:
        """Return the least error of a quantity, because two solutions may agree by chance."""

    def factor(self, name: str) -> float:
        """Return the factor on the difference of a quantity to a coarser evaluation."""
        return self.safety

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity: factor times difference to a coarser evaluation.

        The estimate at each requested time is the largest near that time, because differences cross
        zero now and then and are meaningless there. It is at least the floor of the quantity.

        Parameters
        ----------
        name : name of the quantity, or of a number of the answer
        difference : relative difference, at `estimate_times` if the quantity depends on time
        """
        error = self.factor(name) * difference
        if DESCRIBED[name].over_time:
            error = greatest_in_ranges(error, *self.similar_times)
        error = np.maximum(error, self.least_error(name))
        return np.maximum(error, self.floors[name](self)) if name in self.floors else error

    @property
    @abstractmethod
    def answers(self) -> Results:
        """The numbers of the answer, by the requested march."""

    @property
    @abstractmethod
    def answers_exact_in_time(self) -> Results:
        """The numbers of the answer, as accurate in time as the tolerance requires."""

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
    ) -> None:
        super().__init__(problem, compliance)
        self._slope_roundoff, self._least_error = slope_roundoff, least_error
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

    def estimate(self, name: str, difference: Array) -> Array:
        """Return the error estimate of a quantity: factor times difference to a coarser evaluation.

        The difference of a relaxation time is at least that of any slower one, because differences
        cross zero. That of a quantity that depends on thin layers at ring edges counts twice for
        each layer that the mesh lacks, because both meshes lack it, and at least once.
        """
        if name == "relaxation_time":
            difference = _growing_errors(difference)
        if DESCRIBED[name].in_thin_layers:
            missing = missing_layers(self.problem, self.smallest)
            difference = difference * np.maximum(1.0, 2 * missing)
        return super().estimate(name, difference)

    def least_error(self, name: str) -> float:
        """Return a part of the tolerance, but at least the roundoff of sums over all elements."""
        part_of_rtol = error_factor("floor of energies" if name in ENERGIES else "floor")
        elements = len(self.compliance.space.degrees)
        by_chance = max(self._wear_factor * self.problem.rtol * part_of_rtol, 1e-14 * elements)
        if name in self.problem.remaining_parts:
            by_chance = max(
                by_chance, self._time_error_by_start(self.problem.remaining_parts[name])
            )
        return max(by_chance, self._least_error)

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
        return float(
            self._error_at_rim(error_factor("stiffness at the rim")) * start / total_change / decay
        )

    def _error_at_rim(self, per_width: float) -> float:
        """Return the error of a flat start that is caused by the element at the rim or at the hole.

        The pressure of the start is infinite at both.
        """
        space = self.compliance.space
        size = max(space.widths[-1], space.widths[0] if space.inner_radius else 0.0)
        return per_width * float(size)

    def _error_of_start(self, per_width: float) -> Array:
        """Return the same error (T,) while the punch has not slid since it was pressed on."""
        pressed = self.problem.loading.force_rise_at_rest(self.problem.times) > 0
        return np.where(pressed, self._error_at_rim(per_width), 0.0)

    def _worn_depth_at_rim(self) -> Array:
        """Return the error (T,) of the worn depth while one element at the rim contains the wear.

        The pressure of the flat start is infinite at the rim and at a hole, in proportion to
        1 / sqrt(distance). Wear by a length L limits it within L of the edge, so that the worn
        depth there is proportional to sqrt(L). An element that is much larger than L has a depth
        proportional to L instead, which is far smaller; a coarser mesh has that error, too.
        """
        space, rings = self.compliance.space, self.problem.rings
        wear = np.array([rings.wear_coefficients[-1, -1], rings.wear_coefficients[0, 0]])
        sizes = np.array([space.widths[-1], space.widths[0] if space.inner_radius else 0.0])
        worn = self.problem.distances[:, None] * wear
        share = np.where(worn < sizes, worn, 0.0).max(axis=1) / (1 - space.inner_radius)
        return error_factor("worn depth at the rim") * np.sqrt(share)

    def _roundoff_of_slopes(self) -> Array:
        """Return the error (T,) of RMS slopes by roundoff in thin layers."""
        return self._slope_roundoff * amplified_roundoff(self.problem)

    floors: ClassVar = {
        "profile": _worn_depth_at_rim,
        "displacement": _worn_depth_at_rim,
        "rms_slope": _roundoff_of_slopes,
        "pressure": lambda each: each._error_of_start(error_factor("pressure at the rim")),
        **dict.fromkeys(
            ("indentation", "normal_force"),
            lambda each: each._error_of_start(error_factor("stiffness at the rim")),
        ),
        **dict.fromkeys(
            ("indentation_start", "force_start"),
            lambda each: each._error_at_rim(error_factor("stiffness at the rim")),
        ),
        **dict.fromkeys(
            ("pressure_min", "pressure_max"),
            lambda each: each._error_at_rim(error_factor("pressure at the rim")),
        ),
    }
