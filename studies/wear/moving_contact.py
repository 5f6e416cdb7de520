"""Wear of a punch whose contact opens, closes and spreads.

Implicit steps with the inequality in each. Non-dimensional.

With H the time integral of the pressure, what has worn is ``k H``, and its moments are ``K H`` with
the mass matrix K of weight k. At every time

    g = A p + K H + m - d b >= 0,      p >= 0,      p . g = 0,      H' = p,      b . p = F, or d as
    given.

Two stages of a stiffly accurate diagonally implicit Runge-Kutta method of second order (Alexander,
SIAM J. Numer. Anal. 14 (1977) 1006), ``gamma = 1 - 1/sqrt(2)``: each is a contact problem with the
matrix ``A + gamma h K``. Weights add up, so that the worn volume is the force times time to
roundoff, whatever the steps; where the force varies, the first stage takes as much as makes it so.
Steps end where the load bends, and where it changes at a stop the punch is pressed anew. The error
of a step is that of its quadrature of the wear against the
parabola through the pressures at its start and its stages. Implicit Euler is the method of one
stage. Steps go by powers of the root of two, so that neighbouring ones share a matrix and its
factor.

Once all of the face carries, the rest is linear: ``A p' = d' b - K p``, and modes of the pencil
(A, K) give it exactly at any time, as those of a flat punch do (`full_contact.py`).
"""

from dataclasses import replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.loading import Loading
from ..sizes.marching import steps_between
from .full_contact import RunningIn
from .history import History, Steps
from .unilateral import Contact, Load, Mask, Press

# of Alexander's method: the part of a step that each of its two stages solves for
GAMMA = 1 - np.sqrt(0.5)
# greatest number of steps of a march
MOST_STEPS = 200_000


class _Moment(NamedTuple):
    """The punch at a time, with the integrals of pressure and force over the sliding distance."""

    time: float
    distance: float
    press: Press
    integral: Array
    work: float = 0.0


class ContactMarch:
    """A punch on a compliance of piecewise linear pressures, ready to wear.

    Parameters
    ----------
    compliance : Compliance
        On a space of degree 1.
    wear_coefficients : (N,) or (2, N) array
        Of the rings of that space; or at the inner and outer edge of each, linear between.
    moments : (size,) array
        Of the initial profile.
    load : Load
        Greatest force, or indentation.
    loading : Loading, optional
        Part of that force, and the sliding speed, over time.

    Attributes
    ----------
    times, watched : of the last march, the times asked for and some between, and the history then
    """

    times: Array
    watched: History

    def __init__(
        self,
        compliance: Compliance,
        wear_coefficients: Array,
        moments: Array,
        load: Load,
        loading: Loading | None = None,
    ) -> None:
        self.compliance, self.wear_coefficients = compliance, wear_coefficients
        self.moments, self.load, self.loading = moments, load, loading or Loading()
        space = compliance.space
        self.weights = space.weights
        self.wear = space.mass(wear_coefficients)
        # a norm of worn depths: their root mean square over the face
        self._norm = space.mass(wear_coefficients**2) / np.pi
        dense = self.wear.toarray()
        # contact problems of stages, with their factors, by their lengths: neighbours share one
        self._contact = lru_cache(maxsize=6)(
            lambda dt: Contact(compliance.matrix + dt * dense, space.weights)
        )
        self._iterations: list[int] = []
        # of the last march: at the start, and after each step; since when contact is full, and the
        # history from then on
        self._moments: list[_Moment] = []
        self._since: _Moment | None = None
        self._later: History | None = None

    def adaptive(self, times: Array, tolerance: float) -> History:
        """March in steps of second order that suit a tolerance, until contact is full.

        Parameters
        ----------
        times : (T,) array
            Increasing; a step ends on each.
        tolerance : float
            Root mean square error of the worn depth that a step may add, over the indentation.
        """
        before = now = self._begin()
        # at a fixed indentation, with less force nothing presses any more but roundoff
        spent = 1e-12 * now.press.force if self.load.force is None else 0.0
        # at the times asked for, and after some steps between, for estimates of errors
        states, loading, deepest = list[_Moment](), self.loading, 1e-300
        taken = rejected = 0
        events = np.union1d(times, loading.times[loading.times < times[-1]])
        distances = loading.at(events).distance
        step = _quantised(1e-6 * float(distances[-1])) if distances[-1] else 1.0
        for event, until in zip(events, distances, strict=True):
            knot = max(int(np.searchsorted(loading.times, event)) - 1, 0)
            load, work = self._at(float(event))
            while (left := until - now.distance) > 1e-14 * until:
                if max(now.press.force, load.force or 0.0) <= spent:
                    break
                if knot == len(loading.times) - 1 and now.press.contact.all():
                    later = times[times >= event]
                    if (relaxed := self._relaxing(now, later)) is not None:
                        history = self._history(states, Steps(taken, rejected))
                        self.times = np.append([state.time for state in states], later)
                        self.watched = history.then(relaxed[: len(later)])
                        self._since, self._later = now, relaxed[len(later) :]
                        return self._at_times(times)
                dt = _shortened(step, left)
                time = loading.time_at(now.distance + dt, knot) if dt < left else float(event)
                middle, after, error = self._two_stages(dt, time, before, now)
                deepest = max(deepest, abs(after.press.indentation))
                relative = error / (tolerance * deepest)
                longer = _quantised(dt * min(4.0, 0.8 * max(relative, 1e-12) ** (-1 / 3)))
                if relative > 1:
                    rejected, step = rejected + 1, longer
                else:
                    before, now = middle, after
                    self._moments.append(now)
                    taken += 1
                    further = not states or time > 2 * states[-1].time
                    # where loads vary, late times have as much to show as early ones
                    if dt < left and (further or (loading.varies and taken % 12 == 0)):
                        states.append(now)
                    # a step cut short by an output time says nothing against the longer ones
                    step = max(step, longer) if dt < step else longer
                if taken + rejected > MOST_STEPS:
                    raise SceneError(
                        f"the march took more than {MOST_STEPS} steps to a sliding distance of "
                        f"{now.distance:.3g}: give a larger rtol"
                    )
            if load.force is not None and now.press.force != load.force:
                press = self._contact(0.0).press(self.moments + self.wear @ now.integral, load)
                before = now = now._replace(press=press)
            now = now._replace(time=float(event), distance=float(until), work=work)
            if event > self._moments[-1].time:
                self._moments.append(now)
            if event in times:
                states.append(now)
        self.times = np.array([state.time for state in states])
        self.watched = self._history(states, Steps(taken, rejected))
        return self._at_times(times)

    def _at_times(self, times: Array) -> History:
        """Return the last march at the times asked for."""
        return self.watched[np.flatnonzero(np.isin(self.times, times))]

    def _at(self, time: float) -> tuple[Load, float]:
        """Return the load at a time, and the integral of the force over the distance until then.

        An indentation stays.
        """
        state, force = self.loading.at(np.array([time])), self.load.force
        load = self.load if force is None else Load(float(state.force[0] * force))
        return load, (force or 1.0) * float(state.work[0])

    def implicit(self, times: Array, step: float) -> History:
        """March by implicit Euler in equal steps of at most `step` between output times."""
        counts = steps_between(times, step).astype(int)
        if counts.sum() > MOST_STEPS:
            raise SceneError(
                f"{counts.sum()} steps are needed, more than {MOST_STEPS}: give a larger wear.step"
            )
        before = now = self._begin()
        states = []
        for time, count, length in zip(times, counts, np.diff(times, prepend=0.0), strict=True):
            dt = length / max(count, 1)
            for _ in range(count):
                after = self._stage(dt, now.distance + dt, now.integral, self.load, before, now)
                before, now = now, after
            now = now._replace(distance=float(time))
            states.append(now)
        self.times, self.watched = times, self._history(states, Steps(int(counts.sum())))
        return self.watched

    def _begin(self) -> _Moment:
        """Return the unworn punch, pressed on, and forget the last march."""
        press = self._contact(0.0).press(self.moments, self._at(0.0)[0])
        start = _Moment(0.0, 0.0, press, np.zeros(len(self.weights)))
        self._iterations, self._moments, self._since, self._later = [], [start], None, None
        return start

    @property
    def between(self) -> History:
        """The last march at its steps, and in full contact after them, at times for distances."""
        history = self._history(self._moments, Steps())
        history = replace(history, distances=np.array([moment.time for moment in self._moments]))
        return history if self._later is None else history.then(self._later)

    def _history(self, moments: list[_Moment], steps: Steps) -> History:
        presses = [moment.press for moment in moments]
        integrals = np.reshape([moment.integral for moment in moments], (-1, len(self.weights)))
        return History(
            np.array([moment.distance for moment in moments]),
            np.reshape([press.pressure for press in presses], integrals.shape),
            integrals * self.compliance.space.at_vertices(self.wear_coefficients),
            np.array([press.indentation for press in presses]),
            np.array([press.force for press in presses]),
            np.reshape([press.gap for press in presses], integrals.shape),
            np.reshape([press.contact for press in presses], integrals.shape).astype(bool),
            steps=replace(steps, iterations=tuple(self._iterations)),
        )

    def _stage(
        self, dt: float, distance: float, integral: Array, load: Load, before: _Moment, now: _Moment
    ) -> _Moment:
        """Return the state at a distance, from the integral without its own part of length `dt`."""
        press = self._contact(dt).press(
            self.moments + self.wear @ integral, load, _predicted(before, now, distance)
        )
        self._iterations.append(press.iterations)
        return _Moment(np.nan, distance, press, integral + dt * press.pressure)

    def _two_stages(
        self, dt: float, time: float, before: _Moment, now: _Moment
    ) -> tuple[_Moment, _Moment, float]:
        """Return the stage within a step, the state after it, and the error of the worn depth."""
        load, work = self._at(time)
        first, part = load, GAMMA * dt
        if load.force is not None and load.force != now.press.force:
            # what both stages wear is the integral of the force
            rest = work - now.work - part * load.force
            first = Load(max(rest / (dt - part), 0.0))
        middle = self._stage(part, now.distance + part, now.integral, first, before, now)
        integral = now.integral + (dt - part) * middle.press.pressure
        after = self._stage(part, now.distance + dt, integral, load, now, middle)
        after = after._replace(time=time, work=work)
        pressures = np.array([moment.press.pressure for moment in (now, middle, after)])
        # weights of the parabola through the start and the two stages, less those of the method
        second = 1 / (6 * GAMMA * (1 - GAMMA))
        third = 0.5 - GAMMA * second
        weights = np.array([1 - second - third, second - (1 - GAMMA), third - GAMMA])
        wrong = dt * weights @ pressures
        return middle, after, float(np.sqrt(max(wrong @ (self._norm @ wrong), 0.0)))

    @cached_property
    def _full(self) -> RunningIn:
        depth = self.load.indentation
        return RunningIn(
            self.compliance, self.wear_coefficients, continuous=False, indentation=depth
        )

    def _relaxed(self, since: _Moment, times: Array) -> History:
        """Return the history at times from full contact on, if it stays so."""
        force = 1.0 if self.load.force is None else since.press.force
        distances, worn = self.loading.at(times).distance, self.wear @ since.integral
        return self._full.from_full_contact(
            distances, since.distance, since.work, self.moments, worn, force
        )

    def _relaxing(self, now: _Moment, times: Array) -> History | None:
        """Return the history at times if contact stays full from now on; None otherwise.

        After these times the history has 64 instants between now and the last time. There, it holds
        the instants themselves in place of their sliding distances.
        """
        slowed, after = float(self.loading.speeds[-1]), times - now.time
        fastest = float(self._full.relaxation_times[-1]) / slowed
        # contact is full while no pressure is negative
        between = now.time + np.geomspace(min(fastest, after[0]), after[-1], 64)
        relaxed = self._relaxed(now, np.append(times, between))
        if relaxed.pressure.min() < 0:
            return None
        distances = np.append(relaxed.distances[: len(times)], between)
        return replace(relaxed, distances=distances)

    @property
    def path(self) -> Array:
        """(S, 4) time, indentation, force, and area of contact over that of the face.

        At the start, and after each step of the last march.
        """
        rows = []
        for moment in self._moments:
            press = moment.press
            area = self.weights[press.contact].sum() / self.weights.sum()
            rows.append((moment.time, press.indentation, press.force, area))
        return np.array(rows)

    @property
    def time_of_full_contact(self) -> float:
        """When all of the face began to carry for good in the last march; NaN if it never did.

        Steps end before and after; the area of contact grows in a straight line in between.
        """
        if self._since is None:
            return np.nan
        times, _, _, areas = self.path.T
        partial = np.flatnonzero(areas < 1 - 1e-12)
        if len(partial) < 2 or partial[-1] + 1 == len(times):
            return self._since.time
        last = partial[-1]
        growth = (areas[last] - areas[last - 1]) / (times[last] - times[last - 1])
        ahead = (1 - areas[last]) / growth if growth > 0 else np.inf
        return float(min(times[last] + ahead, times[last + 1]))

    @property
    def slowest_time(self) -> float:
        """The slowest relaxation time of the full face."""
        return float(self._full.slowest_times[0])

    def left(self, times: Array | None = None) -> tuple[Array, Array]:
        """Return times (T,), and how far the punch is from where wear tends to by each.

        By the approach less steady wear, which may cross that, or by the force at a fixed
        indentation. It is told at the steps of the last march, or at times after it found the
        contact full.
        """
        force, steady = self.load.force, self._full.steady
        if times is None:
            times, depth, carried, _ = self.path.T
        else:
            assert self._since is not None
            history = self._relaxed(self._since, times)
            depth, carried = history.indentation, history.force
        if force is None:
            return times, carried
        limit = steady.pressure @ (force * steady.moments + self.moments)
        return times, depth - force * steady.wear_rate * times - limit


def _predicted(before: _Moment, now: _Moment, distance: float) -> Mask:
    """Return which nodes will carry if pressures and gaps go on as they went."""
    ahead = 0.0
    if now.distance > before.distance > 0:
        # edges of the contact slow down, even in the logarithm of distance
        further = np.log(distance / now.distance)
        ahead = min(further / np.log(now.distance / before.distance), 1.5)
    pressure = now.press.pressure + ahead * (now.press.pressure - before.press.pressure)
    gap = now.press.gap + ahead * (now.press.gap - before.press.gap)
    return np.where(now.press.contact, pressure > 0, gap < 0)


def _shortened(step: float, left: float) -> float:
    """Return a step that ends on an output time or leaves at least half of the way to it."""
    if step >= left * (1 - 1e-9):
        return left
    return min(step, left / 2)


def _quantised(step: float) -> float:
    """Return the power of the root of two at or below a step."""
    return float(2.0 ** (np.floor(2 * np.log2(step)) / 2))
