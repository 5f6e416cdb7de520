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
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, diags

from ....meshes.radial import Array
from .full_face import FullFace
from .history import Instant
from .modes import BandedCholesky
from .unilateral import Contact, Load, Mask, Press

# diagonal coefficient of Alexander's method: implicit part of each stage, over the step
GAMMA = 1 - np.sqrt(0.5)
# number of contact problems stored with their factors; successive steps of equal length share one
STORED_CONTACTS = 6
# greatest extrapolation of the contact, in log(distance) and over the previous step
MOST_EXTRAPOLATION = 1.5


class StepError(NamedTuple):
    """The error that a step adds to the worn depth, as root mean squares.

    Parameters
    ----------
    depth : error of the worn depth, over the face
    slope : error of the slope of the worn depth, along the radius
    slope_after : slope of the face after the step, along the radius
    """

    depth: float
    slope: float = 0.0
    slope_after: float = 0.0


class ContactStages:
    """The contact problems of the stages of a step of any length.

    Parameters
    ----------
    face : FullFace
        Face of the punch with its compliance, wear coefficients, profile and load.
    """

    def __init__(self, face: FullFace) -> None:
        self.face = face
        space = face.compliance.space
        self.weights = space.weights
        self.wear = space.mass(face.wear_coefficients)
        # matrix of the norm of worn depths k H: their mean square over the face
        self._norm = space.mass(face.wear_coefficients**2) / np.pi
        dense, matrix = self.wear.toarray(), face.compliance.matrix
        self._contact = lru_cache(maxsize=STORED_CONTACTS)(
            lambda dt: Contact(matrix + dt * dense, space.weights)
        )

    @cached_property
    def _slopes(self) -> csr_matrix:
        """(E, size) slopes of a function in each cell, times the root of its part of the width."""
        space = self.face.compliance.space
        parts = space.widths / (1 - space.inner_radius)
        return (diags(np.sqrt(parts)) @ space.on_elements(np.zeros(1), derivative=True)).tocsr()

    @cached_property
    def _slopes_of_wear(self) -> csr_matrix:
        """(E, size) the same slopes of the worn depth k H, from the integral H."""
        depths = diags(self.face.compliance.space.at_vertices(self.face.wear_coefficients))
        return (self._slopes @ depths).tocsr()

    @cached_property
    def _unworn_slopes(self) -> Array:
        """(E,) the same slopes of the unworn face."""
        mass = BandedCholesky(self.face.compliance.space.mass())
        return np.asarray(self._slopes @ mass.solve(self.face.moments))

    def at(self, time: float) -> tuple[Load, float]:
        """Return the load at a time, and the integral of the force over the distance until then.

        A given indentation is constant.
        """
        face = self.face
        state, force = face.loading.at(np.array([time])), face.load.force
        load = face.load if force is None else Load(float(state.force[0] * force))
        return load, (force or 1.0) * float(state.work[0])

    def press_unworn(self) -> Instant:
        """Return the state of the unworn punch at the time 0."""
        press = self._contact(0.0).press(self.face.moments, self.at(0.0)[0])
        return Instant(0.0, 0.0, press, np.zeros(len(self.weights)))

    def press_worn(self, integral: Array, load: Load) -> Press:
        """Return the contact of the worn punch under a load.

        `integral` (size,) is the integral H of the pressure over the sliding distance.
        """
        return self._contact(0.0).press(self.face.moments + self.wear @ integral, load)

    def solve_stage(
        self,
        dt: float,
        distance: float,
        integral: Array,
        load: Load,
        previous: Instant,
        current: Instant,
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
        previous, current : Instant
            Two earlier states, from which the contact is predicted.
        """
        press = self._contact(dt).press(
            self.face.moments + self.wear @ integral,
            load,
            _predict_contact(previous, current, distance),
        )
        return Instant(np.nan, distance, press, integral + dt * press.pressure)

    def solve_two_stages(
        self,
        dt: float,
        time: float,
        previous: Instant,
        current: Instant,
        with_slopes: bool = False,
    ) -> tuple[Instant, Instant, StepError]:
        """Return the first stage of a step, the state after it, and the error of the step.

        Parameters
        ----------
        dt : float
            Sliding distance of the step.
        time : float
            Time at its end.
        previous, current : Instant
            An earlier state, and the state at the beginning of the step.
        with_slopes : bool
            Whether the error includes that of the slope; if not, slopes are zero.
        """
        load, work = self.at(time)
        first_load, stage_distance = load, GAMMA * dt
        if load.force is not None and load.force != current.press.force:
            # choose the force of the first stage such that both wear by the integral of the force
            stage_work = work - current.work - stage_distance * load.force
            first_load = Load(max(stage_work / (dt - stage_distance), 0.0))
        middle = self.solve_stage(
            stage_distance,
            current.distance + stage_distance,
            current.integral,
            first_load,
            previous,
            current,
        )
        integral = current.integral + (dt - stage_distance) * middle.press.pressure
        following = self.solve_stage(
            stage_distance, current.distance + dt, integral, load, current, middle
        )
        following = following._replace(time=time, work=work)
        pressures = np.array([instant.press.pressure for instant in (current, middle, following)])
        # weights of the integral of the parabola, minus those of the method
        second = 1 / (6 * GAMMA * (1 - GAMMA))
        third = 0.5 - GAMMA * second
        weights = np.array([1 - second - third, second - (1 - GAMMA), third - GAMMA])
        defect = dt * weights @ pressures
        depth = float(np.sqrt(max(defect @ (self._norm @ defect), 0.0)))
        if not with_slopes:
            return middle, following, StepError(depth)
        slopes_after = self._unworn_slopes + self._slopes_of_wear @ following.integral
        # a node that comes into contact or leaves it during the step has a kink in time, which no
        # shorter step resolves: the worn depth judges the cells there
        in_contact = [instant.press.contact for instant in (current, middle, following)]
        slopes = self._cells_within(np.all(in_contact, axis=0)) * (self._slopes_of_wear @ defect)
        slope, slope_after = (float(np.linalg.norm(each)) for each in (slopes, slopes_after))
        return middle, following, StepError(depth, slope, slope_after)

    def _cells_within(self, nodes: Mask) -> Mask:
        """Return the cells (E,) all of whose nodes are among some nodes (size,)."""
        # the last entry stands for the functions that a cell does not have
        return np.asarray(np.append(nodes, True)[self.face.compliance.space.dofs].all(axis=1))


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
