"""Sampling of all quantities of a problem from a wear history. Non-dimensional.

Quantities take their values from the state of a punch (`problem/quantities.py`): `FullFace`
provides it in full contact, and `OnCells` on the cells of a contact that may change.
`SampledSteadyState` provides the steady state.
"""

from collections.abc import Callable, Set
from functools import cached_property, lru_cache, partial

import numpy as np

from .....meshes.pressure_space import PressureSpace
from .....meshes.radial import Array, Indices
from ...problem.face import radial_weight
from ...problem.norms import Results
from ...problem.profile import InitialProfile
from ...problem.quantities import HISTORIES, NOT_COMPARED, QUANTITIES, STEADY
from ...wear.contact_edges import worn_edges
from ...wear.flat_contact import SteadyState
from ...wear.history import History
from ...wear.slope_integrals import SlopeIntegrals, slope_integrals
from ...wear.worn_face import WornFace
from .functions import Functions

AVERAGES = ("line", "area")
# numbers of a field, or of the coefficients of a history, that are computed at once: at more times
# the intermediate results would fill the memory
NUMBERS_AT_ONCE = 2**20


@lru_cache(maxsize=8)
def _unworn_slopes(
    profile: InitialProfile, space: PressureSpace, average: str, inner_radius: float
) -> SlopeIntegrals:
    weight = partial(radial_weight, average=average, inner_radius=inner_radius)
    return slope_integrals(profile, space.breakpoints, weight)


class SampledState:
    """A punch at the T times of a history, with fields at R radii.

    Parameters
    ----------
    functions : evaluates coefficients on the space of the history
    history : the history
    radii : (R,) radii
    """

    def __init__(self, functions: Functions, history: History, radii: Array) -> None:
        self._functions, self._history, self._radii = functions, history, radii
        self._problem = functions.problem
        self.depth, self.even_wear = history.depth, history.even_wear
        self.standoff = self._problem.profile.standoff

    @cached_property
    def pressure(self) -> Array:
        """(T, R) contact pressure."""
        return self._functions.pressures(self._history, self._radii)

    @cached_property
    def ring_forces(self) -> Array:
        """(T, N) force on each ring."""
        return self._functions.ring_forces(self._history)

    @property
    def moment(self) -> Array:
        """(T,) integral of the radius times the pressure over the face."""
        return self._functions.moments(self._history)

    @property
    def worn_volumes(self) -> Array:
        """(T, N) worn volume of each ring."""
        return self._functions.worn_volumes(self._history)


class FullFace(SampledState):
    """A flat punch in full contact, whose worn depth is in the space of the pressures."""

    @cached_property
    def shape(self) -> Array:
        """(T, R) worn profile from the first touch, less the even wear."""
        return self._problem.profile(self._radii) + self._worn

    @property
    def displacement(self) -> Array:
        """(T, R) displacement of the half-space."""
        return self.depth[:, None] - self._worn

    @property
    def displacement_centre(self) -> Array:
        """(T,) displacement at the centre, or at the inner edge of a hollow punch."""
        worn = self._functions.at(self._functions.centre, self._history.shape)
        return self.depth - worn[:, 0]

    @property
    def displacement_max(self) -> Array:
        """(T,) greatest displacement under the punch."""
        uniform = self._functions.space.uniform
        return self._functions.greatest(self.depth[:, None] * uniform - self._history.shape)

    @property
    def rms_slope(self) -> Array:
        """(T,) root mean square slope of the face."""
        return self._functions.rms_slopes(self._history.shape)

    @property
    def contact(self) -> Array:
        """(T, R) 1 on the face, 0 in a hole."""
        on_face = (self._radii >= self._problem.inner_radius).astype(float)
        return np.broadcast_to(on_face, (len(self.depth), len(on_face)))

    @property
    def contact_edges(self) -> Array:
        """(T, 2) radius of the hole and of the rim."""
        return np.tile([self._problem.inner_radius, 1.0], (len(self.depth), 1))

    @cached_property
    def _worn(self) -> Array:
        """(T, R) worn depth less the even wear."""
        return self._functions.at(self._radii, self._history.shape)


class OnCells(SampledState):
    """A punch whose contact opens, closes and spreads, on cells of its face."""

    @cached_property
    def _face(self) -> WornFace:
        return self._functions.worn_face(self._history)

    @cached_property
    def shape(self) -> Array:
        """(T, R) worn profile from the first touch, less the even wear."""
        return self._face.heights(self._functions.matrix(self._radii), self._radii)

    @property
    def displacement(self) -> Array:
        """(T, R) displacement of the half-space."""
        return self._displacement_at(self._radii, self.pressure)

    @property
    def displacement_centre(self) -> Array:
        """(T,) displacement at the centre, or at the inner edge of a hollow punch."""
        centre = self._functions.centre
        pressure = self._functions.pressures(self._history, centre)
        return self._displacement_at(centre, pressure)[:, 0]

    @property
    def displacement_max(self) -> Array:
        """(T,) greatest displacement under the punch."""
        return self._functions.greatest(self._face.displacement)

    @property
    def rms_slope(self) -> Array:
        """(T,) root mean square slope of the face; NaN if it is infinite."""
        problem, space = self._problem, self._functions.space
        average = problem.gradient_average, problem.inner_radius
        squares = self._face.mean_square_slopes(_unworn_slopes(problem.profile, space, *average))
        return np.sqrt(np.where(np.isfinite(squares), squares, np.nan))

    @property
    def contact(self) -> Array:
        """(T, R) 1 in contact, 0 outside."""
        return (self.pressure > 0).astype(float)

    @cached_property
    def contact_edges(self) -> Array:
        """(T, E) inner and outer radius of each part of the contact in turn; NaN beyond."""
        history = self._history
        parts = [
            worn_edges(self._functions.space, contact, worn)
            for contact, worn in zip(history.contact, history.shape, strict=True)
        ]
        if history.pressed is not None:
            fitted = [(part.inner, part.outer) for part in history.pressed.start.intervals]
            for row in np.flatnonzero(history.pressed.force):
                parts[row] = fitted
        edges = np.full((len(parts), 2 * max(map(len, parts), default=0)), np.nan)
        for time, of_time in enumerate(parts):
            edges[time, : 2 * len(of_time)] = np.ravel(of_time)
        return edges

    def _displacement_at(self, radii: Array, pressure: Array) -> Array:
        return self._face.displacements(self._functions.matrix(radii), radii, pressure > 0)


class SampledSteadyState:
    """The steady state under the last load, with fields at R radii.

    Parameters
    ----------
    functions : evaluates coefficients on the space of the state
    state : the steady state under the force 1
    radii : (R,) radii
    """

    def __init__(self, functions: Functions, state: SteadyState, radii: Array) -> None:
        self._functions, self._state, self._radii = functions, state, radii
        loading = functions.problem.loading
        self._force, self._speed = loading.forces[-1], loading.speeds[-1]

    @cached_property
    def _displaced(self) -> Array:
        return self._force * self._state.displacement[None]

    @property
    def pressure(self) -> Array:
        """(R,) contact pressure."""
        return self._force * self._functions.at(self._radii, self._state.pressure)

    @property
    def displacement(self) -> Array:
        """(R,) displacement of the half-space."""
        return self._functions.at(self._radii, self._displaced)[0]

    @cached_property
    def displacement_max(self) -> Array:
        """() greatest displacement under the punch."""
        return self._functions.greatest(self._displaced)[0]

    @property
    def rms_slope(self) -> Array:
        """() root mean square slope."""
        return self._functions.rms_slopes(self._displaced)[0]

    @property
    def wear_rate(self) -> Array:
        """() rate at which height is lost."""
        return self._force * self._speed * self._state.wear_rate


class Sampler(Functions):
    """Computes the quantities of a problem from coefficients on a pressure space.

    The parameters are those of `Functions`.
    """

    def _radii(self, on_face: bool) -> Array:
        return self.problem.face.radii if on_face else self.problem.radii

    def times_at_once(self, on_face: bool = False) -> int:
        """Return the number of times at which quantities are computed at once."""
        return max(1, NUMBERS_AT_ONCE // max(len(self._radii(on_face)), self.space.size))

    def history(self, history: History, on_face: bool = False) -> Results:
        """Return the quantities that depend on time.

        Parameters
        ----------
        history : history at T times
        on_face : whether fields are at the radii of the face of the punch, not at those of the
            output; then quantities that cannot be compared are left out
        """
        count = len(history.times)
        if count <= self.times_at_once(on_face):
            return self._at_once(history, on_face)
        return self.at_times(history.__getitem__, count, on_face)

    def at_times(
        self, history_at: Callable[[Indices], History], count: int, on_face: bool = False
    ) -> Results:
        """Return the quantities at many times, computed at some of them after the others.

        Parameters
        ----------
        history_at : returns the history at some of the times, given by their indices
        count : number of times
        on_face : as for `history`
        """
        results = Results()
        for rows in np.array_split(np.arange(count), -(-count // self.times_at_once(on_face))):
            for name, values in self.history(history_at(rows), on_face=on_face).items():
                results[name] = _with_rows(results.get(name), rows, values, count)
        return results

    def _at_once(self, history: History, on_face: bool) -> Results:
        """Return the quantities that depend on time, as `history` does."""
        problem = self.problem
        sampled = FullFace if problem.full_contact else OnCells
        state = sampled(self, history, self._radii(on_face))
        # the errors of other quantities are relative to these
        measures = ["normal_force", "indentation"]
        if self.maxima_from_fields and problem.wants("displacement_max"):
            measures.append("displacement")
        names = HISTORIES - NOT_COMPARED if on_face else HISTORIES
        results = self._wanted(names, state, *measures)
        # times at which pressures may be infinite
        pressed = history.distances == 0
        if history.pressed is not None:
            pressed = history.pressed.force > 0
        results |= {"time": history.times, "pressed": np.asarray(pressed)}
        if "profile" in results:
            results["shape"] = state.shape
        return results | {"depth": history.depth, "even_wear": history.even_wear}

    def steady(self, state: SteadyState, on_face: bool = False) -> Results:
        """Return the steady quantities, from the state of a unit force, under the final load."""
        measures = ["steady_displacement_max"]
        if self.maxima_from_fields:
            measures.append("steady_profile")
        sampled = SampledSteadyState(self, state, self._radii(on_face))
        return self._wanted(STEADY, sampled, *measures)

    @property
    def maxima_from_fields(self) -> bool:
        """Whether maxima are only as accurate as their fields.

        This is so for flat punches on spaces of degree 2 or less: differences between the maxima of
        two solutions often vanish there.
        """
        return self.problem.full_contact and self.space.top <= 2

    def _wanted(
        self, names: Set[str], state: SampledState | SampledSteadyState, *always: str
    ) -> Results:
        """Return the values of those quantities that the problem wants, or that are named last."""
        return {
            name: np.asarray(quantity.value(state))
            for name, quantity in QUANTITIES.items()
            if name in names and (name in always or self.problem.wants(name))
        }


def _with_rows(whole: Array | None, rows: Indices, values: Array, count: int) -> Array:
    """Return an array of `count` times with the values (len(rows), ...) at some of them.

    Times may have different numbers of values, such as edges of the contact; NaN fills the gaps.
    """
    if len(rows) == count:
        return values
    if whole is None:
        whole = np.full((count, *values.shape[1:]), np.nan, values.dtype)
    if values.ndim > 1 and (missing := values.shape[1] - whole.shape[1]) > 0:
        whole = np.pad(whole, ((0, 0), (0, missing)), constant_values=np.nan)
    if values.ndim == 1:
        whole[rows] = values
    else:
        whole[rows, : values.shape[1]] = values
    return whole
