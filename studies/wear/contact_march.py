"""Wear of a punch whose contact opens, closes and spreads.

Implicit steps with the inequality in each. Non-dimensional.

With H the time integral of the pressure, what has worn is ``k H``, and its moments are ``K H`` with
the mass matrix K of weight k. At every time

    g = A p + K H + m - d b >= 0,      p >= 0,      p . g = 0,      H' = p,      b . p = F, or d as
    given.

Two stages of a stiffly accurate diagonally implicit Runge-Kutta method of second order (Alexander,
SIAM J. Numer. Anal. 14 (1977) 1006), ``gamma = 1 - 1/sqrt(2)``: each is a contact problem with the
matrix ``A + gamma h K``. Weights add up, so that the worn volume is the force times time to
roundoff, whatever the steps. The error of a step is that of its quadrature of the wear against the
parabola through the pressures at its start and its stages. Implicit Euler is the method of one
stage. Steps go by powers of the root of two, so that neighbouring ones share a matrix and its
factor.

Once all of the face carries, under a force, the rest is linear: ``A p' = d' b - K p``, and modes of
the pencil (A, K) on the pressures that carry no force give it exactly at any time, as those of a
flat punch do (`archard.py`).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.marching import steps_between
from .modes import BandedCholesky, Modes, every_mode
from .unilateral import Contact, Load, Mask, Press

GAMMA = 1 - np.sqrt(0.5)
# weights of the parabola through the start and the two stages, less those of the method
_SECOND = 1 / (6 * GAMMA * (1 - GAMMA))
_THIRD = 0.5 - GAMMA * _SECOND
ERROR_WEIGHTS = np.array([1 - _SECOND - _THIRD, _SECOND - (1 - GAMMA), _THIRD - GAMMA])
SAFETY, MOST_GROWTH = 0.8, 4.0
MOST_STEPS = 200_000
# of the first force at a fixed indentation: with less, nothing presses any more but roundoff
SPENT = 1e-12
# matrices kept with their factors
KEPT = 6
# times the last step for which signs are extrapolated: edges of the contact slow down, even in the
# logarithm of time
AHEAD = 1.5
# at the pressures of a contact that stays, beside the times asked for
LOOKS = 64


class _Moment(NamedTuple):
    time: float
    press: Press
    integral: Array


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """A march of T times.

    Pressures, time integrals of the pressure and gaps (T, size), and what goes with them.

    Parameters
    ----------
    times : (T,)
    pressure, integral, gap : (T, size) coefficients, coefficients, and moments
    contact : (T, size) which nodes carry
    indentation, force : (T,)
    steps, rejected : of the march
    iterations : of every stage: active sets that were tried
    time_error : of the wear by the quadrature in time, in the norm of the march, all steps added up
    """

    times: Array
    pressure: Array
    integral: Array
    gap: Array
    contact: NDArray[np.bool_]
    indentation: Array
    force: Array
    steps: int
    rejected: int
    iterations: tuple[int, ...]
    time_error: float


class ContactMarch:
    """A punch on a compliance of piecewise linear pressures, ready to wear.

    Parameters
    ----------
    compliance : on a space of degree 1
    wear_coefficients : (N,) of the rings of that space
    moments : (size,) of the initial profile
    load : force or indentation
    """

    def __init__(
        self, compliance: Compliance, wear_coefficients: Array, moments: Array, load: Load
    ) -> None:
        self.compliance, self.moments, self.load = compliance, moments, load
        space = compliance.space
        self.weights = space.weights
        self.wear = space.mass(wear_coefficients)
        # a norm of worn depths: their root mean square over the face
        self._norm = space.mass(wear_coefficients**2) / np.pi
        self._dense_wear = self.wear.toarray()
        self._contacts: dict[float, Contact] = {}
        self.iterations: list[int] = []

    def start(self) -> Press:
        """The unworn punch."""
        return Contact(self.compliance.matrix, self.weights).press(self.moments, self.load)

    def adaptive(self, times: Array, tolerance: float) -> ContactHistory:
        """Steps of second order whose error in the worn depth is a part of the indentation, until
        contact is full.

        Parameters
        ----------
        times : (T,) increasing, each of which a step ends on
        tolerance : root mean square error of the worn depth that a step may add, over the
            indentation
        """
        before = now = self._begin()
        least = SPENT * now.press.force if self.load.force is None else 0.0
        kept, rest = list[_Moment](), list[_Moment]()
        rejected, errors = 0, list[float]()
        wanted = _quantised(1e-6 * float(times[-1])) if times[-1] else 1.0
        for number, time in enumerate(times):
            while (left := time - now.time) > 1e-14 * time and now.press.force > least:
                if rest := self._relaxing(now, times[number:]):
                    break
                dt = (
                    left
                    if wanted >= left * (1 - 1e-9)
                    else left / 2
                    if wanted > left / 2
                    else wanted
                )
                middle, after, error = self._two_stages(dt, before, now)
                relative = error / (tolerance * max(abs(after.press.indentation), 1e-300))
                growth = min(MOST_GROWTH, SAFETY * max(relative, 1e-12) ** (-1 / 3))
                if relative > 1:
                    rejected, wanted = rejected + 1, _quantised(dt * growth)
                else:
                    before, now = middle, after
                    errors.append(error)
                    # a step cut short by an output time says nothing against the longer ones
                    wanted = (
                        max(wanted, _quantised(dt * growth))
                        if dt < wanted
                        else _quantised(dt * growth)
                    )
                if len(errors) + rejected > MOST_STEPS:
                    raise SceneError(
                        f"the march took more than {MOST_STEPS} steps to t = {now.time:.3g}: give "
                        "a larger rtol"
                    )
            if rest:
                break
            now = now._replace(time=float(time))
            kept.append(now)
        return self._history(times, kept + rest, len(errors), rejected, sum(errors))

    def implicit(self, times: Array, step: float) -> ContactHistory:
        """Implicit Euler in equal steps of at most `step` between output times."""
        steps = steps_between(times, step)
        if steps.sum() > MOST_STEPS:
            raise SceneError(
                f"{steps.sum():.0f} steps are needed, more than {MOST_STEPS}: give a larger "
                "wear.step"
            )
        before = now = self._begin()
        kept = []
        for time, count, left in zip(
            times, steps.astype(int), np.diff(times, prepend=0.0), strict=True
        ):
            for _ in range(count):
                before, now = (
                    now,
                    self._stage(left / count, now.time + left / count, now.integral, before, now),
                )
            now = now._replace(time=float(time))
            kept.append(now)
        return self._history(times, kept, int(steps.sum()), 0, 0.0)

    def _begin(self) -> _Moment:
        self.iterations.clear()
        return _Moment(0.0, self.start(), np.zeros(len(self.weights)))

    def _history(
        self, times: Array, kept: list[_Moment], steps: int, rejected: int, error: float
    ) -> ContactHistory:
        presses = [one.press for one in kept]
        return ContactHistory(
            times,
            np.array([one.pressure for one in presses]),
            np.array([one.integral for one in kept]),
            np.array([one.gap for one in presses]),
            np.array([one.contact for one in presses]),
            np.array([one.indentation for one in presses]),
            np.array([one.force for one in presses]),
            steps,
            rejected,
            tuple(self.iterations),
            error,
        )

    def _contact(self, dt: float) -> Contact:
        if dt not in self._contacts:
            if len(self._contacts) >= KEPT:
                del self._contacts[next(iter(self._contacts))]
            self._contacts[dt] = Contact(
                self.compliance.matrix + dt * self._dense_wear, self.weights
            )
        return self._contacts[dt]

    def _stage(
        self, dt: float, time: float, integral: Array, before: _Moment, now: _Moment
    ) -> _Moment:
        """The state at a time, from the integral without its own part of length `dt`."""
        press = self._contact(dt).press(
            self.moments + self.wear @ integral, self.load, _predicted(before, now, time)
        )
        self.iterations.append(press.iterations)
        return _Moment(time, press, integral + dt * press.pressure)

    def _two_stages(
        self, dt: float, before: _Moment, now: _Moment
    ) -> tuple[_Moment, _Moment, float]:
        """The stage within a step, the state after it, and the error of the worn depth."""
        middle = self._stage(GAMMA * dt, now.time + GAMMA * dt, now.integral, before, now)
        part = now.integral + (1 - GAMMA) * dt * middle.press.pressure
        after = self._stage(GAMMA * dt, now.time + dt, part, now, middle)
        pressures = np.array([one.press.pressure for one in (now, middle, after)])
        wrong = dt * ERROR_WEIGHTS @ pressures
        return middle, after, float(np.sqrt(max(wrong @ (self._norm @ wrong), 0.0)))

    @cached_property
    def _mass(self) -> BandedCholesky:
        return BandedCholesky(self.wear)

    @cached_property
    def _steady(self) -> Array:
        """(size,) the pressure that wear tends to: all of the face wears by the same."""
        shape = self._mass.solve(self.weights)
        return np.asarray(shape * (self.load.force or 1.0) / (self.weights @ shape))

    @cached_property
    def _modes(self) -> Modes:
        matrix, factor = self.compliance.matrix, self.compliance.factor
        return every_mode(
            matrix, lambda: factor, self._mass, self.weights, matrix @ self._steady, gentle=True
        )

    def _relaxing(self, now: _Moment, times: Array) -> list[_Moment]:
        """The states to come if contact stays full from now on, exact in time; else none."""
        force = self.load.force
        if force is None or not now.press.contact.all():
            return []
        relaxation, shapes = self._modes.relaxation, self._modes.shapes
        shares = shapes.T @ (self.wear @ (now.press.pressure - self._steady))
        after = times - now.time
        between = np.geomspace(min(relaxation[-1], after[0]), after[-1], LOOKS)
        left = np.exp(-np.concatenate([after, between])[:, None] / relaxation) * shares
        pressures = self._steady + left @ shapes.T
        if pressures.min() < 0:
            return []
        pressures = pressures[: len(times)]
        # what has worn, by the gap that is none: a sum over the modes would have their roundoff
        displaced = pressures @ self.compliance.matrix + self.moments
        rate = (self.wear @ self._steady).sum() / self.weights.sum()
        depths = displaced @ self._steady / force + rate * times
        worn = self._mass.solve((np.outer(depths, self.weights) - displaced).T).T
        gaps = displaced + worn @ self.wear - np.outer(depths, self.weights)
        states = zip(times, pressures, gaps, depths, worn, strict=True)
        return [
            _Moment(time, Press(pressure, gap, float(depth), force, now.press.contact, 0), integral)
            for time, pressure, gap, depth, integral in states
        ]


def _predicted(before: _Moment, now: _Moment, time: float) -> Mask:
    """Which nodes will carry if pressures and gaps go on as they went, in the logarithm of time, no
    further than `AHEAD`.
    """
    ahead = 0.0
    if now.time > before.time > 0:
        ahead = min(np.log(time / now.time) / np.log(now.time / before.time), AHEAD)
    pressure = now.press.pressure + ahead * (now.press.pressure - before.press.pressure)
    gap = now.press.gap + ahead * (now.press.gap - before.press.gap)
    return np.where(now.press.contact, pressure > 0, gap < 0)


def _quantised(step: float) -> float:
    """The power of the root of two at or below a step."""
    return float(2.0 ** (np.floor(2 * np.log2(step)) / 2))
