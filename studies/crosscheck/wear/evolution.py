"""Evolve a punch whose contact opens, closes and spreads, and give its state at any time.

Non-dimensional. The integral H of the pressure over the sliding distance is the only state: the
contact is a function of H and the load, and the pressure is the derivative of H. A history has
three kinds of pieces. While the punch neither slides nor presses, H does not change (`Resting`).
While all of the face is in contact, the problem is linear, and relaxation modes solve it exactly
under any load (`relaxing.py`). Otherwise, steps couple contact and wear (`stages.py`), and their
lengths follow a tolerance (`step_control.py`). Steps end at the knots of the load, and nowhere
else: each piece gives the state at any of its times.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....meshes.errors import SceneError
from ....meshes.radial import Array
from .full_contact import RunningIn
from .history import History, Instant
from .relaxing import Relaxing
from .stages import CONFORMING, ContactStages
from .step_control import MOST_STEPS, StepControl, steps_between
from .unilateral import Mask
from .wearing_punch import WearingPunch

# at a fixed indentation, a force below this fraction of the first force is roundoff
NEGLIGIBLE_FORCE = 1e-12
# a remaining distance below this fraction of the total distance is roundoff
ROUNDOFF = 1e-14
# time, over that of tension, after which a contact that is still full may be continued by modes
RETRY_AFTER = 2.0
# time in full contact, over the slowest relaxation time, after which what edges of the contact have
# left in the shape of the face has decayed to less than 1e-10
SETTLED = 24.0
# Times of running-in are located on the logarithm of (part that is left / part wanted); this is the
# smallest value of that ratio.
SMALLEST_RATIO = 1e-3
# part of a step to which the greatest change of running-in is located
PLACE_OF_MAXIMUM = 1e-3
# relative accuracy to which times of running-in are located
ROOT = 1e-7


@dataclass(frozen=True, eq=False)
class Resting:
    """The punch at rest, or without a force: nothing wears."""

    stages: ContactStages
    start: Instant
    end: Instant

    @property
    def times(self) -> Array:
        """The end."""
        return np.array([self.end.time])

    def at(self, times: Array) -> History:
        """Return the history at some of its times."""
        return _history([self.stages.rest(self.start, float(time)) for time in times], self.stages)


class Step(NamedTuple):
    """One step: the states at its ends."""

    start: Instant
    end: Instant


@dataclass(frozen=True, eq=False)
class Stepping:
    """Successive steps, of two stages or of implicit Euler."""

    stages: ContactStages
    steps: Sequence[Step]
    implicit: bool = False

    @property
    def end(self) -> Instant:
        """The state after the last step."""
        return self.steps[-1].end

    @cached_property
    def times(self) -> Array:
        """The end of each step."""
        return np.array([step.end.time for step in self.steps])

    def at(self, times: Array) -> History:
        """Return the history at some of its times; those inside a step are ends of shorter ones."""
        rows = np.searchsorted(self.times, times)
        instants = [
            self._within(self.steps[row], float(time))
            for row, time in zip(rows, times, strict=True)
        ]
        return _history(instants, self.stages)

    def _within(self, step: Step, time: float) -> Instant:
        start, end = step
        dt = self.stages.distance(time) - start.distance
        if time == end.time or dt <= 0:
            return (end if dt > 0 else start)._replace(time=time)
        if self.implicit:
            return self.stages.solve_implicit_step(dt, start, start)._replace(time=time)
        _, following = self.stages.solve_two_stages(dt, time, start, start)
        return following


Piece = Resting | Stepping | Relaxing
"""A part of a history between two times, with the state `at` any of its times."""


class Statistics(NamedTuple):
    """How an evolution was computed.

    Parameters
    ----------
    taken, rejected : int
        Numbers of accepted and of rejected steps.
    iterations : tuple of int
        Number of active sets tried in each stage.
    greatest_errors : (2,) array, optional
        Greatest errors that an accepted step added to the worn depth and to its slope, relative as
        the tolerances of `evolve` are. Zero for steps that follow no tolerance.
    """

    taken: int
    rejected: int
    iterations: tuple[int, ...]
    greatest_errors: Array = np.zeros(2)


@dataclass(frozen=True, eq=False)
class Evolution:
    """A punch that wears from the time 0 on, at any time.

    Parameters
    ----------
    stages : ContactStages
        The contact problems of the punch.
    first : Instant
        State at the time 0.
    pieces : sequence of Piece
        The pieces of its history.
    statistics : Statistics
        Numbers of steps and of active sets.
    """

    stages: ContactStages
    first: Instant
    pieces: Sequence[Piece]
    statistics: Statistics

    @property
    def punch(self) -> WearingPunch:
        """The punch."""
        return self.stages.punch

    def at(self, times: Array) -> History:
        """Return the history at increasing times (T,).

        Times may be later than the last one if contact is full in the end.
        """
        ends, pieces = np.array([piece.end.time for piece in self.pieces]), [*self.pieces]
        if (times > self._end.time).any() and self._later is not None:
            pieces.append(self._later)
        rows = np.minimum(np.searchsorted(ends, times), len(pieces) - 1)
        rows = np.where(times <= 0, -1, rows)
        parts = [
            pieces[row].at(times[rows == row])
            if row >= 0
            else _history([self.first] * int(np.count_nonzero(rows < 0)), self.stages)
            for row in np.unique(rows).tolist()
        ]
        if not parts:
            return _history([], self.stages)
        return History.joined(parts)

    @cached_property
    def times(self) -> Array:
        """The start, the end of each step, and times in full contact."""
        return np.concatenate([[0.0], *(piece.times for piece in self.pieces)])

    @cached_property
    def path(self) -> Array:
        """(S, 4) time, indentation, force, and contact area over that of the face, at `times`."""
        history, weights = self.at(self.times), self.stages.weights
        areas = 1 - ~history.contact @ weights / weights.sum()
        return np.column_stack([self.times, history.indentation, history.force, areas])

    @property
    def always_full(self) -> bool:
        """Whether all of the face is in contact at every step, once it presses."""
        return all(
            step.end.press.contact.all()
            for piece in self.pieces
            if isinstance(piece, Stepping)
            for step in piece.steps
        )

    @property
    def _end(self) -> Instant:
        """The state at the end."""
        return self.pieces[-1].end if self.pieces else self.first

    @cached_property
    def _later(self) -> Relaxing | None:
        """Full contact after the end, by modes, if contact is full then and stays full."""
        if self.pieces and isinstance(last := self.pieces[-1], Relaxing):
            return last
        end = self._end
        if not self.stages.is_full(end):
            return None
        later = Relaxing(self.punch, end, end.time + SETTLED * self.punch.slowest_time)
        return later if later.lasts else None

    @property
    def running_in(self) -> RunningIn | None:
        """The relaxation modes, if the history contains them."""
        modal = any(isinstance(piece, Relaxing) for piece in self.pieces)
        return self.punch.running_in if modal else None

    @cached_property
    def time_of_full_contact(self) -> float:
        """The time from which all of the face stays in contact; NaN if it is not in the end."""
        states = [self.first]
        for piece in self.pieces:
            states += (
                [step.end for step in piece.steps] if isinstance(piece, Stepping) else [piece.end]
            )
        full_at = np.nan
        for state in reversed(states):
            if not self.stages.is_full(state):
                break
            full_at = state.time
        if not full_at > 0:
            return full_at
        from scipy.optimize import brentq  # few runs need it

        def least_pressure_or_gap(time: float) -> float:
            history = self.at(np.array([time]))
            gaps = np.where(history.contact, 0.0, history.gap) / self.stages.weights
            gap = float(gaps.max())
            return -gap if gap > CONFORMING else max(float(history.pressure.min()), 0.0)

        ends = state.time, full_at
        return float(brentq(least_pressure_or_gap, *ends, xtol=ROOT * full_at, rtol=ROOT))

    def settled(self, times: Array) -> Mask:
        """Return at which times (T,) nothing is left of what edges of the contact did to the face.

        The whole face has then been in contact for `SETTLED` times its slowest relaxation time,
        under a constant load.
        """
        since = np.inf if self.punch.loading.varies else self.time_of_full_contact
        return times > since + SETTLED * self.punch.slowest_time

    def remaining(self, times: Array) -> Array:
        """Return the remaining change to the steady state (T,), under a constant load.

        Under a force it is ``d(t) - w t`` minus its limit, with the steady wear rate w; it may
        change its sign. At a fixed indentation it is the force.
        """
        history = self.at(times)
        # in full contact the even wear is left out already
        even_wear = np.where(history.even_wear > 0, 0.0, self.punch.even_wear(history.distances))
        return self.punch.remainder(history.depth - even_wear, history.force)

    def time_until(self, fraction: float) -> float:
        """Return the time from which at most a fraction of the greatest change remains.

        It is NaN if contact does not become full, or if that time is later than the evolution.
        """
        if np.isnan(self.time_of_full_contact) and self.punch.load.force is not None:
            # before full contact, the change that remains may cross zero more than once
            return np.nan
        times, remaining, greatest = self._changes
        last = int(np.flatnonzero(remaining > fraction * greatest)[-1])
        if last + 1 == len(times):
            return np.nan
        from scipy.optimize import brentq  # few runs need it

        before, after = float(times[last]), float(times[last + 1])
        known = {before: float(remaining[last]), after: float(remaining[last + 1])}

        def logarithm(time: float) -> float:
            remains = known[time] if time in known else self._remains(time)
            return float(np.log(max(remains / greatest / fraction, SMALLEST_RATIO)))

        return float(brentq(logarithm, before, after, xtol=ROOT * after, rtol=ROOT))

    def _remains(self, time: float) -> float:
        return abs(float(self.remaining(np.array([time]))[0]))

    @cached_property
    def _changes(self) -> tuple[Array, Array, float]:
        """Times (S,), the change that remains at each (S,), and the greatest at any time."""
        times = self.times
        if self._later is not None:
            # the change decays at least as fast as the slowest mode
            later = self.punch.slowest_time * np.geomspace(1e-3, 20, 400)
            times = np.append(times, times[-1] + later)
        remaining = np.abs(self.remaining(times))
        row = int(remaining.argmax())
        greatest = float(remaining[row])
        if 0 < row < len(times) - 1:
            from scipy.optimize import minimize_scalar  # few runs need it

            before, after = times[row - 1], times[row + 1]
            found = minimize_scalar(
                lambda time: -self._remains(time),
                bounds=(before, after),
                method="bounded",
                options={"xatol": PLACE_OF_MAXIMUM * (after - before)},
            )
            greatest = max(greatest, -float(found.fun))
        return times, remaining, greatest


def evolve(
    punch: WearingPunch,
    last: float,
    tolerance: float,
    slope_tolerance: float = np.inf,
    length: float = 1.0,
) -> Evolution:
    """Wear a punch until a time, in steps of second order that follow a tolerance.

    Parameters
    ----------
    punch : WearingPunch
        The punch.
    last : float
        Time until which it wears.
    tolerance : float
        Root mean square error of the worn depth that a step may add, over the greatest indentation
        so far.
    slope_tolerance : float
        Root mean square error of the slope of the face that a step may add, over that slope. It
        matters for the thin layers that wear makes at ring edges and at the rim.
    length : float
        Factor on the lengths of steps, for a march that is compared with one without it.

    Raises
    ------
    SceneError
        if there are too many steps
    """
    stages, loading, load = ContactStages(punch), punch.loading, punch.load
    first = previous = current = stages.press_unworn()
    negligible_force = NEGLIGIBLE_FORCE * current.press.force if load.force is None else 0.0
    distance = min(stages.distance(last), stages.distance_to_wear(first.press))
    control = StepControl(tolerance, distance, slope_tolerance, length)
    pieces, steps, iterations = list[Piece](), list[Step](), list[int]()
    # whether full contact may be continued by modes. After tension, it may again once contact has
    # been lost, or if it is still full at a later time
    try_modes, tension_at = True, np.inf
    # the next end of a segment of the load
    event = -np.inf

    def end_steps() -> None:
        if steps:
            pieces.append(Stepping(stages, tuple(steps)))
            steps.clear()

    while current.time < last:
        if current.time >= event:
            knot = int(np.searchsorted(loading.times, current.time, side="right")) - 1
            event = min(float(np.append(loading.times, np.inf)[knot + 1]), last)
            event_load, event_distance = stages.at(event)[0], stages.distance(event)
        remaining = event_distance - current.distance
        if try_modes and stages.is_full(current):
            relaxing = Relaxing(punch, current, last)
            slid = stages.distance(relaxing.until) - current.distance
            try_modes, tension_at = False, relaxing.until
            if relaxing.lasts or slid > control.step:
                end_steps()
                pieces.append(relaxing)
                previous = current = relaxing.end
                continue
        at_rest = remaining <= ROUNDOFF * event_distance
        if at_rest or max(current.press.force, event_load.force or 0.0) <= negligible_force:
            end_steps()
            pieces.append(Resting(stages, current, stages.rest(current, event)))
            previous = current = pieces[-1].end
            try_modes = True
            continue
        dt = control.next_towards(remaining)
        time = loading.time_at(current.distance + dt, knot) if dt < remaining else event
        middle, following = stages.solve_two_stages(dt, time, previous, current)
        error = stages.error_of_step(
            dt, current, middle, following, with_slopes=np.isfinite(slope_tolerance)
        )
        iterations += (middle.press.iterations, following.press.iterations)
        if control.accepts(dt, error, following.press.indentation):
            steps.append(Step(current, following))
            previous, current = middle, following
            passed = current.time > RETRY_AFTER * tension_at
            try_modes = try_modes or passed or not current.press.contact.all()
        if control.taken + control.rejected > MOST_STEPS:
            raise SceneError(
                f"the march took more than {MOST_STEPS} steps to a sliding distance of "
                f"{current.distance:.3g}: give a larger rtol"
            )
    end_steps()
    counts = control.taken, control.rejected, tuple(iterations)
    statistics = Statistics(*counts, control.greatest_errors)
    return Evolution(stages, first, tuple(pieces), statistics)


def evolve_in_equal_steps(punch: WearingPunch, times: Array, step: float) -> Evolution:
    """Wear a punch under a constant load by implicit Euler, in equal steps between some times.

    Parameters
    ----------
    punch : WearingPunch
        The punch.
    times : (T,) array
        Increasing times; a step ends on each.
    step : float
        Greatest length of a step.

    Raises
    ------
    SceneError
        if there are too many steps
    """
    counts = steps_between(times, step).astype(int)
    if counts.sum() > MOST_STEPS:
        raise SceneError(
            f"{counts.sum()} steps are needed, more than {MOST_STEPS}: give a larger wear.step"
        )
    stages, steps = ContactStages(punch), list[Step]()
    first = previous = current = stages.press_unworn()
    for time, count, length in zip(times, counts, np.diff(times, prepend=0.0), strict=True):
        for number in range(count):
            following = stages.solve_implicit_step(length / count, previous, current)
            end = time - (count - 1 - number) * (length / count)
            following = following._replace(time=float(end), distance=float(end))
            steps.append(Step(current, following))
            previous, current = current, following
    iterations = tuple(step.end.press.iterations for step in steps)
    pieces = (Stepping(stages, tuple(steps), implicit=True),) if steps else ()
    return Evolution(stages, first, pieces, Statistics(len(steps), 0, iterations))


def _history(instants: Sequence[Instant], stages: ContactStages) -> History:
    """Return the history at some instants."""
    punch, space = stages.punch, stages.punch.space
    integrals = np.reshape([instant.integral for instant in instants], (-1, space.size))
    presses = [instant.press for instant in instants]
    return History(
        np.array([instant.time for instant in instants]),
        np.array([instant.distance for instant in instants]),
        np.reshape([press.pressure for press in presses], integrals.shape),
        integrals * space.at_vertices(punch.wear_coefficients),
        np.array([press.indentation for press in presses]),
        np.array([press.force for press in presses]),
        np.reshape([press.gap for press in presses], integrals.shape),
        np.reshape([press.contact for press in presses], integrals.shape).astype(bool),
        integrals,
        np.zeros(len(presses)),
        space.uniform,
    )
