"""Wear of a shaped punch in full contact from a state on, by relaxation modes.

Non-dimensional. While all of the face is in contact, the problem is linear, as for a flat punch
(`full_contact.py`), and the modes solve it exactly under any load. They are valid until a pressure
becomes negative.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....meshes.radial import Array
from ..problem.loading import Loading
from .history import History, Instant
from .unilateral import ContactSolution
from .wearing_punch import WearingPunch

# times at which pressures are checked: over the duration of each segment of the load, and how many
# between the fastest relaxation time and the end after the last of its knots
CHECKED = np.concatenate([np.geomspace(1e-4, 0.1, 12), np.linspace(0.15, 1.0, 12)])
CHECKED_AFTER_LAST_KNOT = 64
# rounds by which the first negative pressure is located, and times in each round
ROUNDS, TIMES_IN_ROUND = 3, 16


@dataclass(frozen=True, eq=False)
class Relaxing:
    """Full contact from a state on.

    Parameters
    ----------
    punch : WearingPunch
        The punch.
    start : Instant
        State at the beginning.
    last : float
        Last time that is wanted.
    """

    punch: WearingPunch
    start: Instant
    last: float

    @cached_property
    def _loading(self) -> Loading:
        """The load over the time since the start; its forces are not relative."""
        loading, start = self.punch.loading, self.start.time
        later = loading.times > start
        force, speed = (
            np.append(np.interp(start, loading.times, values), values[later])
            for values in (loading.forces, loading.speeds)
        )
        times = np.append(0.0, loading.times[later] - start)
        return Loading(times, force * (self.punch.load.force or 1.0), speed)

    @cached_property
    def _knot_amplitudes(self) -> Array:
        return self.punch.running_in.modes.at_knots(self._loading)

    @cached_property
    def _amplitudes_of_face(self) -> Array:
        """(m,) amplitude of each mode at the start that the shape of the face makes."""
        punch = self.punch
        worn = punch.space.mass(punch.wear_coefficients) @ self.start.integral
        return punch.running_in.amplitudes_of_face(punch.moments + worn)

    def _amplitudes(self, times: Array) -> Array:
        """Return the amplitude of each mode (T, m) at times (T,)."""
        modes, state = self.punch.running_in.modes, self._loading.at(times - self.start.time)
        decays = np.exp(-state.distance[:, None] / modes.relaxation)
        excited = modes.excite(self._knot_amplitudes[state.knot], state)
        return excited + decays * self._amplitudes_of_face

    def _least_pressures(self, times: Array) -> Array:
        """Return the least pressure (T,) at times (T,)."""
        running_in = self.punch.running_in
        force = self._loading.at(times - self.start.time).force
        of_modes = running_in.pressures_of_modes(self._amplitudes(times))
        return (np.outer(force, running_in.steady.pressure) + of_modes).min(axis=1)

    @cached_property
    def _checks(self) -> list[Array]:
        """Times after the start at which pressures are checked, for each segment of the load."""
        knots, start = self.punch.loading.times, self.start.time
        ends = np.append(knots[(knots > start) & (knots < self.last)], self.last)
        starts = np.append(start, ends[:-1])
        checks = [begin + (end - begin) * CHECKED for begin, end in zip(starts, ends, strict=True)]
        if starts[-1] >= knots[-1]:
            duration, speed = float(self.last - starts[-1]), float(self.punch.loading.speeds[-1])
            fastest = float(self.punch.running_in.relaxation_times[-1])
            first = min(fastest / speed, duration) if speed else duration
            checks[-1] = starts[-1] + np.geomspace(first, duration, CHECKED_AFTER_LAST_KNOT)
        return checks

    @cached_property
    def until(self) -> float:
        """The time until which no pressure is negative; at most the last one."""
        begin = self.start.time
        for times in self._checks:
            negative = np.flatnonzero(self._least_pressures(times) < 0)
            if not len(negative):
                begin = float(times[-1])
                continue
            for _ in range(ROUNDS):
                first = negative[0]
                begin = float(times[first - 1]) if first else begin
                times = np.linspace(begin, times[first], TIMES_IN_ROUND + 1)[1:]
                negative = np.append(
                    np.flatnonzero(self._least_pressures(times) < 0), TIMES_IN_ROUND - 1
                )
            return begin
        return begin

    @property
    def lasts(self) -> bool:
        """Whether contact stays full until the last time."""
        return self.until >= self.last

    @cached_property
    def times(self) -> Array:
        """Times within the piece at which pressures are not negative, the end among them."""
        times = np.concatenate(self._checks)
        return np.append(times[times < self.until], self.until)

    @cached_property
    def end(self) -> Instant:
        """The state at the end."""
        history = self.at(np.array([self.until]))
        state = self._loading.at(np.array([self.until - self.start.time]))
        work = self.start.work + float(state.work[0])
        press = ContactSolution(
            history.pressure[0],
            history.gap[0],
            float(history.indentation[0]),
            float(history.force[0]),
            history.contact[0],
            0,
        )
        integral = history.integral[0] + work * self.punch.running_in.steady.pressure
        return Instant(self.until, float(history.distances[0]), press, integral, work)

    def at(self, times: Array) -> History:
        """Return the history at times (T,) after the start; those after `until` need tension."""
        state, start = self._loading.at(times - self.start.time), self.start
        running_in, amplitudes = self.punch.running_in, self._amplitudes(times)
        history = running_in.steady_plus_modes(
            times,
            start.distance + state.distance,
            amplitudes,
            state.force,
            running_in.steady.wear_rate * (start.work + state.work),
            self.punch.moments,
        )
        # the integral of each amplitude a follows from its own equation, T a' = T F' a_flat - a;
        # worn depths over k would lose digits where k is small
        modes, first_force = running_in.modes, self._loading.forces[0]
        at_start = first_force * modes.amplitudes + self._amplitudes_of_face
        rises = np.outer(state.force - first_force, modes.amplitudes)
        integral = running_in.pressures_of_modes(modes.relaxation * (at_start + rises - amplitudes))
        integral += start.integral - start.work * running_in.steady.pressure
        return replace(history, integral=integral)
