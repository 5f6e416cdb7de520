"""Sampling of all quantities of a problem from a wear history. Non-dimensional."""

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
from scipy.sparse import csr_matrix

from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices, ring_areas
from ..contact.edges import worn_edges
from ..contact.slope_integrals import SlopeIntegrals, slope_integrals
from ..contact.worn_face import WornFace
from ..problem.problem import Problem
from ..problem.profile import InitialProfile
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..wear.flat_contact import SteadyState
from ..wear.history import History
from .norms import Results, radial_weight

AVERAGES = ("line", "area")
# numbers of a field, or of the coefficients of a history, that are computed at once: at more times
# the intermediate results would fill the memory
NUMBERS_AT_ONCE = 2**20
Values = dict[str, Callable[[], Array]]


# cached, because problems on the same space are sampled at the same radii
@lru_cache(maxsize=32)
def _matrix(space: PressureSpace, radii: bytes, derivative: bool = False) -> csr_matrix:
    return space.matrix(np.frombuffer(radii), derivative)


@lru_cache(maxsize=8)
def _ring_forces(space: PressureSpace, ring_edges: bytes) -> Array:
    return space.ring_forces(np.frombuffer(ring_edges))


@lru_cache(maxsize=8)
def _slopes(space: PressureSpace) -> csr_matrix:
    return space.on_elements(space.quadrature[2], derivative=True)


@lru_cache(maxsize=8)
def _unworn_slopes(
    profile: InitialProfile, space: PressureSpace, average: str, inner_radius: float
) -> SlopeIntegrals:
    weight = partial(radial_weight, average=average, inner_radius=inner_radius)
    return slope_integrals(profile, space.breakpoints, weight)


@lru_cache(maxsize=8)
def _samples(space: PressureSpace) -> Array:
    """Return the radii at which functions of a space are sampled to find their maximum.

    There are enough in each element that a cubic between two of them has the maximum to nine
    digits.
    """
    count = 3 * (space.top + 2)
    within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
    return np.append((starts + widths * within).ravel(), 1.0)


class Sampler:
    """Computes the quantities of a problem from coefficients on a pressure space.

    Parameters
    ----------
    problem, space : the problem, and the space of the coefficients
    compliance : compliance on that space; needed for fields of a contact that moves
    """

    def __init__(
        self, problem: Problem, space: PressureSpace, compliance: Compliance | None = None
    ) -> None:
        self.problem, self.space, self.compliance = problem, space, compliance

    def _radii(self, on_face: bool) -> Array:
        return self.problem.face.radii if on_face else self.problem.radii

    def _at(self, radii: Array, functions: Array, derivative: bool = False) -> Array:
        """Return values (T, R), or slopes, at radii (R,) by coefficients (T, size)."""
        return np.asarray((_matrix(self.space, radii.tobytes(), derivative) @ functions.T).T)

    def on_face(self, functions: Array) -> Array:
        """Return values (T, R) at the radii of the face by coefficients (T, size)."""
        return self._at(self.problem.face.radii, functions)

    def _greatest(self, functions: Array) -> Array:
        """Return the maximum (T,) over the punch of functions with coefficients (T, size).

        It is the maximum of the cubic between two samples that has their values and slopes.
        """
        radii, row = _samples(self.space), np.arange(len(functions))
        samples, slopes = self._at(radii, functions), self._at(radii, functions, derivative=True)
        best = samples.argmax(axis=1)
        left = np.clip(np.where(slopes[row, best] > 0, best, best - 1), 0, samples.shape[1] - 2)
        width = radii[left + 1] - radii[left]
        start, rise = samples[row, left], samples[row, left + 1] - samples[row, left]
        first, last = width * slopes[row, left], width * slopes[row, left + 1]
        # start + first t + b t^2 + c t^3, with the value and slope of the right sample at t = 1;
        # its maximum is at t = top if the slope changes sign
        b, c = 3 * rise - 2 * first - last, first + last - 2 * rise
        inside = (first > 0) & (last < 0)
        root = np.sqrt(np.where(inside, b * b - 3 * c * first, 1.0))
        top = np.divide(first, root - b, out=np.zeros(len(row)), where=inside)
        return np.maximum(samples[row, best], start + top * (first + top * (b + top * c)))

    def _rms_slope(self, slopes: Array) -> Array:
        """Return the root mean square (T,) of slopes (T, E Q) at Q points in each of E elements."""
        radii, lengths, _ = self.space.quadrature
        average = self.problem.gradient_average, self.problem.inner_radius
        weights = lengths * radial_weight(radii, *average)
        # not by a Gram matrix: it would sum the square of a constant over a small element, which
        # leaves only roundoff
        return np.asarray(np.sqrt(slopes**2 @ weights.ravel()))

    def pressures(self, history: History, radii: Array) -> Array:
        """Return pressures (T, R) at radii.

        The start is sampled in its own space, if it has one. Negative values of polynomials next to
        an edge are artefacts, and are replaced by zero.
        """
        if (pressed := history.pressed) is None:
            return np.maximum(self._at(radii, history.pressure), 0.0)
        pressures, rows = np.maximum(self._at(radii, pressed.rest), 0.0), pressed.force > 0
        # pressures of the start may be infinite at the rim
        scale = pressed.force[rows] / pressed.start.force
        pressures[rows] += np.outer(scale, pressed.start.pressure_at(radii))
        return pressures

    def ring_forces(self, history: History) -> Array:
        """Return the force (T, N) on each ring."""
        ring_edges = self.problem.ring_edges
        on_rings = _ring_forces(self.space, ring_edges.tobytes()).T
        if (pressed := history.pressed) is None:
            return np.asarray(history.pressure @ on_rings)
        scale = pressed.force / pressed.start.force
        return pressed.rest @ on_rings + np.outer(scale, pressed.start.ring_forces(ring_edges))

    def worn_volumes(self, history: History) -> Array:
        """Return the volume worn off each ring (T, N)."""
        return WORN_VOLUMES[self.problem.contact](self, history)

    def worn_volumes_of_full_face(self, history: History) -> Array:
        """Return the volume worn off each ring (T, N), from the profile, which is in the space."""
        on_rings = _ring_forces(self.space, self.problem.ring_edges.tobytes())
        return np.asarray(history.shape @ on_rings.T) + self._even_volumes(history)

    def _even_volumes(self, history: History) -> Array:
        """Return the volume (T, N) that the even wear has worn off each ring."""
        return np.outer(history.even_wear, ring_areas(self.problem.ring_edges))

    def worn_volumes_on_cells(self, history: History) -> Array:
        """Return the volume worn off each ring (T, N), from the time integral of the pressure."""
        # the worn profile is k times the time integral of the pressure; only the latter is in the
        # space
        rings, space = self.problem.merged, self.space
        integral = history.shape / space.at_vertices(rings.wear_coefficients)
        volumes = integral @ (space.mass(rings.wear_coefficients) @ space.ring_indicator())
        first = np.searchsorted(rings.ring_edges, self.problem.ring_edges[:-1]) - space.hollow
        return np.asarray(np.add.reduceat(volumes, first, axis=1)) + self._even_volumes(history)

    def worn_face(self, history: History) -> WornFace:
        """Return the worn face of a punch whose contact moves.

        Raises
        ------
        ValueError
            if there is no compliance
        """
        if self.compliance is None:
            raise ValueError("fields of a contact that moves need the compliance")
        return WornFace(self.problem.profile, self.compliance, history)

    @property
    def _centre(self) -> Array:
        """(1,) radius of the centre, 0; for a hollow punch, the inner edge of its face."""
        return self.problem.ring_edges[:1]

    def fields_of_full_face(self, history: History, radii: Array) -> Values:
        """Return functions that compute the profile, displacement and slope in full contact."""
        centre = self._centre
        worn, depth = history.shape, history.depth[:, None]
        displaced = depth * self.space.uniform - worn
        return {
            "shape": lambda: self.problem.profile(radii) + self._at(radii, worn),
            "displacement": lambda: depth - self._at(radii, worn),
            "displacement_centre": lambda: (depth - self._at(centre, worn))[:, 0],
            "displacement_max": lambda: self._greatest(displaced),
            "rms_slope": lambda: self._rms_slope((_slopes(self.space) @ worn.T).T),
        }

    def fields_on_cells(self, history: History, radii: Array) -> Values:
        """Return functions that compute the profile, displacement and slope on cells."""
        centre, face = self._centre, self.worn_face(history)

        def displacements(places: Array) -> Array:
            carries = self.pressures(history, places) > 0
            return face.displacements(_matrix(self.space, places.tobytes()), places, carries)

        def rms_slopes() -> Array:
            average = self.problem.gradient_average, self.problem.inner_radius
            squares = face.mean_square_slopes(
                _unworn_slopes(self.problem.profile, self.space, *average)
            )
            # no value where the mean square is infinite
            return np.sqrt(np.where(np.isfinite(squares), squares, np.nan))

        return {
            "shape": lambda: face.heights(_matrix(self.space, radii.tobytes()), radii),
            "displacement": lambda: displacements(radii),
            "displacement_centre": lambda: displacements(centre)[:, 0],
            "displacement_max": lambda: self._greatest(face.displacement),
            "rms_slope": rms_slopes,
        }

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
        count = len(history.distances)
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
        problem, radii, pressed = self.problem, self._radii(on_face), history.pressed
        values: Values = {
            "pressure": lambda: self.pressures(history, radii),
            "ring_force": lambda: self.ring_forces(history),
        }
        values |= FIELDS[problem.contact](self, history, radii)
        missing = problem.quantities_missing
        if "ring_worn_volume" not in missing:
            values["normal_force"] = lambda: self.ring_forces(history).sum(axis=1)
            values["ring_worn_volume"] = lambda: self.worn_volumes(history)
        elif "normal_force" not in missing:
            values["normal_force"] = lambda: history.force
        if "contact_radius" not in missing:
            edges = self._edges(history)
            values["contact_radius"] = lambda: np.nanmax(edges, axis=1, initial=0.0)
            if not on_face:
                values["contact"] = lambda: (self.pressures(history, radii) > 0).astype(float)
                values["contact_edge"] = lambda: edges
        # the errors of other quantities are relative to these
        measures = ["normal_force"]
        if self.maxima_from_fields and problem.wants("displacement_max"):
            measures.append("displacement")
        # times at which pressures may be infinite
        may_be_infinite = history.distances == 0 if pressed is None else pressed.force > 0
        if problem.wants("profile"):
            measures.append("shape")
        wanted = self._wanted(values, *measures)
        standoff, even_wear = problem.profile.standoff, history.even_wear
        if "shape" in wanted:
            wanted["profile"] = wanted["shape"] + even_wear[:, None] + standoff
        return wanted | {
            "indentation": history.indentation + standoff,
            "time": history.distances,
            "pressed": np.asarray(may_be_infinite),
            "depth": history.depth,
            "even_wear": even_wear,
        }

    def _edges(self, history: History) -> Array:
        """Return the inner and the outer radius of every part of the contact in turn (T, E).

        Entries beyond the last part at a time are NaN.
        """
        if self.problem.full_contact:
            return np.tile([self.problem.inner_radius, 1.0], (len(history.distances), 1))
        contact_parts = [
            worn_edges(self.space, contact, worn)
            for contact, worn in zip(history.contact, history.shape, strict=True)
        ]
        if history.pressed is not None:
            fitted = [(part.inner, part.outer) for part in history.pressed.start.intervals]
            for row in np.flatnonzero(history.pressed.force):
                contact_parts[row] = fitted
        edges = np.full((len(contact_parts), 2 * max(map(len, contact_parts), default=0)), np.nan)
        for time, of_time in enumerate(contact_parts):
            edges[time, : 2 * len(of_time)] = np.ravel(of_time)
        return edges

    def steady(self, state: SteadyState, on_face: bool = False) -> Results:
        """Return the steady quantities, from the state of a unit force, under the final load."""
        force, speed = self.problem.loading.forces[-1], self.problem.loading.speeds[-1]
        radii, displaced = self._radii(on_face), force * state.displacement[None]
        greatest = self._greatest(displaced)
        values: Values = {
            "steady_pressure": lambda: force * self._at(radii, state.pressure),
            "steady_profile": lambda: np.maximum(greatest - self._at(radii, displaced)[0], 0),
            "steady_displacement_max": lambda: greatest[0],
            "steady_rms_slope": lambda: self._rms_slope((_slopes(self.space) @ displaced.T).T)[0],
            "steady_wear_rate": lambda: np.asarray(force * speed * state.wear_rate),
        }
        measures = ["steady_displacement_max"]
        if self.maxima_from_fields:
            measures.append("steady_profile")
        return self._wanted(values, *measures)

    @property
    def maxima_from_fields(self) -> bool:
        """Whether maxima are only as accurate as their fields.

        This is so for flat punches on spaces of degree 2 or less: differences between the maxima of
        two solutions often vanish there.
        """
        return self.problem.full_contact and self.space.top <= 2

    def _wanted(self, values: Values, *always: str) -> Results:
        return {
            name: value()
            for name, value in values.items()
            if name in always or self.problem.wants(name)
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


# functions that sample the face, by the contact of the problem
WORN_VOLUMES = {
    FULL_CONTACT: Sampler.worn_volumes_of_full_face,
    MOVING_CONTACT: Sampler.worn_volumes_on_cells,
}
FIELDS = {
    FULL_CONTACT: Sampler.fields_of_full_face,
    MOVING_CONTACT: Sampler.fields_on_cells,
}
