"""Solve the stages of a step that couples contact and wear: each is a contact problem.

With H the integral of the pressure over the sliding distance, the worn depth is ``k H``, and its
moments are ``K H`` with the mass matrix K of weight k. At every time

    g = A p + K H + m - d b >= 0,      p >= 0,      p . g = 0,      H' = p,

and ``b . p = F``, or d is given.

A step is a stiffly accurate, diagonally implicit Runge-Kutta method of second order with two stages
(Alexander, SIAM J. Numer. Anal. 14 (1977) 1006), ``gamma = 1 - 1/sqrt(2)``. Each stage is a contact
problem with the matrix ``A + gamma h K``. The weights of the stages sum to 1, so the worn volume
equals the integral of the force over the distance to roundoff, for any steps. If the force varies,
the force of the first stage is chosen such that this holds. The error of a step is estimated as the
difference between its quadrature of the wear and the integral of the parabola through the pressures
at its start and its stages. The method with one stage is implicit Euler.
"""

from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import csr_matrix, diags

from ....meshes.radial import Array
from .history import Instant
from .step_control import StepError
from .unilateral import Contact, ContactSolution, Load, Mask
from .wearing_punch import WearingPunch

# diagonal coefficient of Alexander's method: implicit part of each stage, over the step
GAMMA = 1 - np.sqrt(0.5)
# number of contact problems stored with their factors; successive steps of equal length share one
STORED_CONTACTS = 6
# greatest gap of a face that conforms with the half-space without a force, over its weight:
# roundoff
CONFORMING = 1e-15
# greatest extrapolation of the contact, in log(distance) and over the previous step
MOST_EXTRAPOLATION = 1.5


class ContactStages:
    """The contact problems of the stages of a step of any length.

    Parameters
    ----------
    punch : WearingPunch
        Punch with its compliance, wear coefficients, unworn face and load.
    """

    def __init__(self, punch: WearingPunch) -> None:
        self.punch = punch
        space = punch.space
        self.weights = space.weights
        self.wear = space.mass(punch.wear_coefficients)
        # matrix of the norm of worn depths k H: their mean square over the face
        self._norm = space.mass(punch.wear_coefficients**2) / np.pi
        dense, matrix = self.wear.toarray(), punch.compliance.matrix
        self._contact = lru_cache(maxsize=STORED_CONTACTS)(
            lambda dt: Contact(matrix + dt * dense, space.weights)
        )

    def __reduce__(self) -> tuple[object, ...]:
        """Leave out the stored contact problems when another process returns a solution."""
        return ContactStages, (self.punch,)

    @cached_property
    def _slopes(self) -> csr_matrix:
        """(E, size) slopes of a function in each cell, times the root of its part of the width."""
        space = self.punch.space
        parts = space.widths / (1 - space.inner_radius)
        return (diags(np.sqrt(parts)) @ space.on_elements(np.zeros(1), derivative=True)).tocsr()

    @cached_property
    def _slopes_of_wear(self) -> csr_matrix:
        """(E, size) the same slopes of the worn depth k H, from the integral H."""
        depths = diags(self.punch.space.at_vertices(self.punch.wear_coefficients))
        return (self._slopes @ depths).tocsr()

    @cached_property
    def _unworn_slopes(self) -> Array:
        """(E,) the same slopes of the unworn face."""
        return self._slopes @ self.punch.space.projected(self.punch.moments)

    def at(self, time: float) -> tuple[Load, float]:
        """Return the load at a time, and the integral of the force over the distance until then.

        A given indentation is constant.
        """
        punch = self.punch
        state, force = punch.loading.at(np.array([time])), punch.load.force
        load = punch.load if force is None else Load(float(state.force[0] * force))
        return load, (force or 1.0) * float(state.work[0])

    def distance(self, time: float) -> float:
        """Return the sliding distance until a time."""
        return float(self.punch.loading.at(np.array([time])).distance[0])

    def press_unworn(self) -> Instant:
        """Return the state of the unworn punch at the time 0."""
        press = self._contact(0.0).press(self.punch.moments, self.at(0.0)[0])
        return Instant(0.0, 0.0, press, np.zeros(len(self.weights)))

    def press_worn(self, integral: Array, load: Load) -> ContactSolution:
        """Return the contact of the worn punch under a load.

        `integral` (size,) is the integral H of the pressure over the sliding distance.
        """
        return self._contact(0.0).press(self.punch.moments + self.wear @ integral, load)

    def distance_to_wear(self, press: ContactSolution) -> float:
        """Return the sliding distance in which a punch wears by its indentation, on average."""
        worn = float((self.wear @ press.pressure).sum()) / np.pi
        return press.indentation / worn if worn > 0 else np.inf

    def rest(self, current: Instant, time: float) -> Instant:
        """Return the state at a later time until which nothing wears."""
        load, work = self.at(time)
        press = current.press
        if load.force is not None and press.force != load.force:
            press = self.press_worn(current.integral, load)
        return Instant(time, self.distance(time), press, current.integral, work)

    def is_full(self, current: Instant) -> bool:
        """Return whether all of the face is in contact, or would be under any small force."""
        press = current.press
        if press.force or self.punch.load.force is None:
            return bool(press.contact.all())
        return bool((press.gap <= CONFORMING * self.weights).all())

    def solve_stage(
        self, dt: float, distance: float, integral: Array, load: Load, guess: Mask
    ) -> Instant:
        """Solve one implicit stage and return the state at its distance.

        Parameters
        ----------
        dt : float
            Sliding distance for which the pressure of this stage acts.
        distance : float
            Sliding distance of the stage.
        integral : (size,) array
            Integral of the pressure without the contribution of this stage.
        load : Load
            Load at the stage.
        guess : (size,) array of bool
            First guess of the contact.
        """
        moments = self.punch.moments + self.wear @ integral
        press = self._contact(dt).press(moments, load, guess)
        return Instant(np.nan, distance, press, integral + dt * press.pressure)

    def solve_implicit_step(self, dt: float, previous: Instant, current: Instant) -> Instant:
        """Return the state after a step of implicit Euler under a constant load."""
        distance = current.distance + dt
        guess = _predict_contact(previous, current, distance)
        return self.solve_stage(dt, distance, current.integral, self.punch.load, guess)

    def solve_two_stages(
        self, dt: float, time: float, previous: Instant, current: Instant
    ) -> tuple[Instant, Instant]:
        """Return the first stage of a step, and the state after it.

        Parameters
        ----------
        dt : float
            Sliding distance of the step.
        time : float
            Time at its end.
        previous, current : Instant
            An earlier state, from which the contact is predicted, and the state at the beginning.
        """
        load, work = self.at(time)
        distance = current.distance + dt
        first_load, stage_distance = load, GAMMA * dt
        if load.force is not None and load.force != current.press.force:
            # choose the force of the first stage such that both wear by the integral of the force
            stage_work = work - current.work - stage_distance * load.force
            first_load = Load(max(stage_work / (dt - stage_distance), 0.0))
        middle_distance = current.distance + stage_distance
        middle = self.solve_stage(
            stage_distance,
            middle_distance,
            current.integral,
            first_load,
            _predict_contact(previous, current, middle_distance),
        )
        integral = current.integral + (dt - stage_distance) * middle.press.pressure
        guess = _predict_contact(current, middle, distance)
        following = self.solve_stage(stage_distance, distance, integral, load, guess)
        return middle, following._replace(time=time, work=work)

    def error_of_step(
        self,
        dt: float,
        current: Instant,
        middle: Instant,
        following: Instant,
        with_slopes: bool = False,
    ) -> StepError:
        """Return the error of a step of length `dt` from its start, its first stage and its end.

        Without slopes, those of the error are zero.
        """
        pressures = np.array([instant.press.pressure for instant in (current, middle, following)])
        # weights of the integral of the parabola, minus those of the method
        second = 1 / (6 * GAMMA * (1 - GAMMA))
        third = 0.5 - GAMMA * second
        weights = np.array([1 - second - third, second - (1 - GAMMA), third - GAMMA])
        defect = self._damped(dt * weights @ pressures, GAMMA * dt, following.press)
        depth = float(np.sqrt(max(defect @ (self._norm @ defect), 0.0)))
        if not with_slopes:
            return StepError(depth)
        slopes_after = self._unworn_slopes + self._slopes_of_wear @ following.integral
        # a node that comes into contact during the step has a kink in time, which no shorter step
        # resolves, and the wear that follows corrects: the worn depth judges the cells there
        came = following.press.contact & ~(current.press.contact & middle.press.contact)
        slopes = self._cells_within(~came) * (self._slopes_of_wear @ defect)
        return StepError(depth, float(np.linalg.norm(slopes)), float(np.linalg.norm(slopes_after)))

    def _damped(self, defect: Array, dt: float, press: ContactSolution) -> Array:
        """Return an error of H less the part that the next stage of length `dt` removes.

        It is ``(1 + dt A^-1 K)^-1`` times the error, on the contact: where the pressure follows the
        wear within a step, such as beside an edge of the contact, an error does not remain.
        """
        if not (press.contact.any() and press.force):
            return defect
        change = self._contact(dt).respond(
            dt * (self.wear @ defect), self.punch.load, press.contact
        )
        return defect - change

    def _cells_within(self, nodes: Mask) -> Mask:
        """Return the cells (E,) all of whose nodes are among some nodes (size,)."""
        # the last entry stands for the functions that a cell does not have
        return np.asarray(np.append(nodes, True)[self.punch.space.dofs].all(axis=1))


def _predict_contact(previous: Instant, current: Instant, distance: float) -> Mask:
    """Return the nodes (size,) in contact, by extrapolation of pressures and gaps."""
    factor = 0.0
    if current.distance > previous.distance > 0:
        # edges of the contact become slower, even as functions of log(distance): limit the factor
        log_ratio = np.log(distance / current.distance)
        factor = min(log_ratio / np.log(current.distance / previous.distance), MOST_EXTRAPOLATION)
    pressure = current.press.pressure + factor * (current.press.pressure - previous.press.pressure)
    gap = current.press.gap + factor * (current.press.gap - previous.press.gap)
    return np.where(current.press.contact, pressure > 0, gap < 0)
