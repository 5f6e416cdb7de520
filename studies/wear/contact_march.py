"""Wear of a punch whose contact opens, closes and spreads: implicit steps with the inequality in each. Non-dimensional.

With H the time integral of the pressure, what has worn is ``k H``, and its moments are ``K H`` with the mass matrix K of
weight k. At every time

    g = A p + K H + m - d b >= 0,      p >= 0,      p . g = 0,      H' = p,      b . p = F, or d as given.

Two stages of a stiffly accurate diagonally implicit Runge-Kutta method of second order (Alexander, SIAM J. Numer. Anal. 14
(1977) 1006), ``gamma = 1 - 1/sqrt(2)``: each is a contact problem with the matrix ``A + gamma h K``. Weights add up, so that
the worn volume is the force times time to roundoff, whatever the steps. The error of a step is that of its quadrature of
the wear against the parabola through the pressures at its start and its stages. Implicit Euler is the method of one stage.
Steps go by powers of the root of two, so that neighbouring ones share a matrix and its factor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import SceneError
from ringwear.meshes.radial import Array
from ringwear.studies.wear.unilateral import Contact, Load, Mask, Press

GAMMA = 1 - np.sqrt(0.5)
# weights of the parabola through the start and the two stages, less those of the method
_SECOND = 1 / (6 * GAMMA * (1 - GAMMA))
_THIRD = 0.5 - GAMMA * _SECOND
ERROR_WEIGHTS = (1 - _SECOND - _THIRD, _SECOND - (1 - GAMMA), _THIRD - GAMMA)
SAFETY, MOST_GROWTH = 0.8, 4.0
MOST_STEPS = 200_000
# of the first force at a fixed indentation: with less, nothing presses any more but roundoff
SPENT = 1e-12
# matrices kept with their factors
KEPT = 6


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """A march of T times: pressures, time integrals of the pressure and gaps (T, size), and what goes with them.

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

    def __init__(self, compliance: Compliance, wear_coefficients: Array, moments: Array, load: Load) -> None:
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
        """Steps of second order whose error in the worn depth is a part of the indentation.

        Parameters
        ----------
        times : (T,) increasing, each of which a step ends on
        tolerance : root mean square error of the worn depth that a step may add, over the indentation
        """
        return self._marched(times, tolerance, None)

    def implicit(self, times: Array, step: float) -> ContactHistory:
        """Implicit Euler in equal steps of at most `step` between output times."""
        return self._marched(times, 1.0, step)

    def _contact(self, dt: float) -> Contact:
        if dt not in self._contacts:
            if len(self._contacts) >= KEPT:
                del self._contacts[next(iter(self._contacts))]
            self._contacts[dt] = Contact(self.compliance.matrix + dt * self._dense_wear, self.weights)
        return self._contacts[dt]

    def _stage(self, dt: float, integral: Array, start: Mask) -> Press:
        press = self._contact(dt).press(self.moments + self.wear @ integral, self.load, start)
        self.iterations.append(press.iterations)
        return press

    def _marched(self, times: Array, tolerance: float, step: float | None) -> ContactHistory:
        last = float(times[-1])
        if step is not None and last / step > MOST_STEPS:
            raise SceneError(f"{last / step:.0f} steps are needed, more than {MOST_STEPS}: give a larger wear.step")
        now, integral, state = 0.0, np.zeros(len(self.weights)), self.start()
        steps = rejected = 0
        added, kept = 0.0, []
        least = SPENT * state.force if self.load.force is None else 0.0
        self.iterations.clear()
        wanted = _quantised(1e-6 * last) if last else 1.0
        for time in times:
            left = time - now if state.force > least else 0.0
            if step is not None and left > 0:
                wanted = left / np.ceil(left / step * (1 - 1e-12))
            while left > 1e-14 * time:
                dt = left if wanted >= left * (1 - 1e-9) else left / 2 if step is None and wanted > left / 2 else wanted
                if step is not None:
                    state = self._stage(dt, integral, state.contact)
                    integral, now, steps = integral + dt * state.pressure, now + dt, steps + 1
                else:
                    after, worn, error = self._two_stages(dt, integral, state)
                    relative = error / (tolerance * max(abs(after.indentation), 1e-300))
                    growth = min(MOST_GROWTH, SAFETY * max(relative, 1e-12) ** (-1 / 3))
                    if relative > 1:
                        rejected, wanted = rejected + 1, _quantised(dt * growth)
                        continue
                    state, integral, now, steps, added = after, worn, now + dt, steps + 1, added + error
                    # a step cut short by an output time says nothing against the longer ones
                    wanted = max(wanted, _quantised(dt * growth)) if dt < wanted else _quantised(dt * growth)
                if steps + rejected > MOST_STEPS:
                    raise SceneError(f"the march took more than {MOST_STEPS} steps to t = {now:.3g}: ask for a larger rtol")
                left = time - now if state.force > least else 0.0
            now = float(time)
            kept.append((state, integral))
        return ContactHistory(
            times,
            np.array([one.pressure for one, _ in kept]),
            np.array([worn for _, worn in kept]),
            np.array([one.gap for one, _ in kept]),
            np.array([one.contact for one, _ in kept]),
            np.array([one.indentation for one, _ in kept]),
            np.array([one.force for one, _ in kept]),
            steps,
            rejected,
            tuple(self.iterations),
            added,
        )

    def _two_stages(self, dt: float, integral: Array, state: Press) -> tuple[Press, Array, float]:
        """The state after a step, the integral of the pressure, and the error of the worn depth."""
        first = self._stage(GAMMA * dt, integral, state.contact)
        before = integral + (1 - GAMMA) * dt * first.pressure
        second = self._stage(GAMMA * dt, before, first.contact)
        start, middle, end = ERROR_WEIGHTS
        wrong = dt * (start * state.pressure + middle * first.pressure + end * second.pressure)
        return second, before + GAMMA * dt * second.pressure, float(np.sqrt(max(wrong @ (self._norm @ wrong), 0.0)))


def _quantised(step: float) -> float:
    """The power of the root of two at or below a step."""
    return float(2.0 ** (np.floor(2 * np.log2(step)) / 2))
