"""The stages of a step in which contact and wear are coupled: an inequality each.

With H the time integral of the pressure, what has worn is ``k H``, and its moments are ``K H`` with
the mass matrix K of weight k. At every time

    g = A p + K H + m - d b >= 0,      p >= 0,      p . g = 0,      H' = p,      b . p = F, or d as
    given.

Two stages of a stiffly accurate diagonally implicit Runge-Kutta method of second order (Alexander,
SIAM J. Numer. Anal. 14 (1977) 1006), ``gamma = 1 - 1/sqrt(2)``: each is a contact problem with the
matrix ``A + gamma h K``. Weights add up, so that the worn volume is the force times time to
roundoff, whatever the steps; where the force varies, the first stage takes as much as makes it so.
The error of a step is that of its quadrature of the wear against the parabola through the pressures
at its start and its stages. Implicit Euler is the method of one stage.
"""

from functools import lru_cache

import numpy as np

from ...meshes.radial import Array
from ..wear.history import Moment
from ..wear.unilateral import Contact, Load, Mask, Press
from .full_face import FullFace

# of Alexander's method: the part of a step that each of its two stages solves for
GAMMA = 1 - np.sqrt(0.5)
# contact problems of stages that are kept with their factors: neighbouring steps share one
KEPT_CONTACTS = 6
# how far ahead contact is predicted, over the step before, in the logarithm of distance
FARTHEST_AHEAD = 1.5


class ContactStages:
    """The contact problems of a punch that wears, ready to be solved for any length of a step.

    Parameters
    ----------
    face : of the punch, with its compliance, wear coefficients, profile and load
    """

    def __init__(self, face: FullFace) -> None:
        self.face = face
        space = face.compliance.space
        self.weights = space.weights
        self.wear = space.mass(face.wear_coefficients)
        # a norm of worn depths: their root mean square over the face
        self._norm = space.mass(face.wear_coefficients**2) / np.pi
        dense, matrix = self.wear.toarray(), face.compliance.matrix
        self._contact = lru_cache(maxsize=KEPT_CONTACTS)(
            lambda dt: Contact(matrix + dt * dense, space.weights)
        )

    def at(self, time: float) -> tuple[Load, float]:
        """Return the load at a time, and the integral of the force over the distance until then.

        An indentation stays.
        """
        face = self.face
        state, force = face.loading.at(np.array([time])), face.load.force
        load = face.load if force is None else Load(float(state.force[0] * force))
        return load, (force or 1.0) * float(state.work[0])

    def unworn(self) -> Moment:
        """Return the unworn punch, pressed on."""
        press = self._contact(0.0).press(self.face.moments, self.at(0.0)[0])
        return Moment(0.0, 0.0, press, np.zeros(len(self.weights)))

    def pressed(self, integral: Array, load: Load) -> Press:
        """Return the worn punch under a load, at an integral of the pressure over distance."""
        return self._contact(0.0).press(self.face.moments + self.wear @ integral, load)

    def stage(
        self, dt: float, distance: float, integral: Array, load: Load, before: Moment, now: Moment
    ) -> Moment:
        """Return the state at a distance, from the integral without its own part of length `dt`."""
        press = self._contact(dt).press(
            self.face.moments + self.wear @ integral, load, _predicted(before, now, distance)
        )
        return Moment(np.nan, distance, press, integral + dt * press.pressure)

    def two_stages(
        self, dt: float, time: float, before: Moment, now: Moment
    ) -> tuple[Moment, Moment, float]:
        """Return the stage within a step, the state after it, and the error of the worn depth.

        Parameters
        ----------
        dt : sliding distance of the step
        time : at its end
        before, now : the moments before the last step, and before this one
        """
        load, work = self.at(time)
        first, part = load, GAMMA * dt
        if load.force is not None and load.force != now.press.force:
            # what both stages wear is the integral of the force
            rest = work - now.work - part * load.force
            first = Load(max(rest / (dt - part), 0.0))
        middle = self.stage(part, now.distance + part, now.integral, first, before, now)
        integral = now.integral + (dt - part) * middle.press.pressure
        after = self.stage(part, now.distance + dt, integral, load, now, middle)
        after = after._replace(time=time, work=work)
        pressures = np.array([moment.press.pressure for moment in (now, middle, after)])
        # weights of the parabola through the start and the two stages, less those of the method
        second = 1 / (6 * GAMMA * (1 - GAMMA))
        third = 0.5 - GAMMA * second
        weights = np.array([1 - second - third, second - (1 - GAMMA), third - GAMMA])
        wrong = dt * weights @ pressures
        return middle, after, float(np.sqrt(max(wrong @ (self._norm @ wrong), 0.0)))


def _predicted(before: Moment, now: Moment, distance: float) -> Mask:
    """Return which nodes will carry if pressures and gaps go on as they went."""
    ahead = 0.0
    if now.distance > before.distance > 0:
        # edges of the contact slow down, even in the logarithm of distance
        further = np.log(distance / now.distance)
        ahead = min(further / np.log(now.distance / before.distance), FARTHEST_AHEAD)
    pressure = now.press.pressure + ahead * (now.press.pressure - before.press.pressure)
    gap = now.press.gap + ahead * (now.press.gap - before.press.gap)
    return np.where(now.press.contact, pressure > 0, gap < 0)
