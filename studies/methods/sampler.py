"""From the history of a punch to the quantities that are asked for. Non-dimensional."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..wear.contact_edges import worn_edges
from ..wear.flat_contact import SteadyState
from ..wear.history import History, Start
from ..wear.moments import moments
from .norms import Results, radial_weight

AVERAGES = ("line", "area")
Values = dict[str, Callable[[], Array]]


# problems on one space differ in wear and load, not in where they are sampled
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
def _samples(space: PressureSpace) -> Array:
    """Return enough radii in each element that a cubic finds the greatest value between them to
    nine digits.
    """
    count = 3 * (space.top + 2)
    within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
    return np.append((starts + widths * within).ravel(), 1.0)


class Sampler:
    """Turns coefficients on a pressure space into the quantities of a problem."""

    def __init__(self, problem: Problem, space: PressureSpace) -> None:
        self.problem, self.space = problem, space
        self._samples = _samples(self.space)
        self._everywhere = _matrix(self.space, self._samples.tobytes())
        self._slope_everywhere = _matrix(self.space, self._samples.tobytes(), derivative=True)
        radii, weights, _ = self.space.quadrature
        self._slope_weights = (weights * radial_weight(radii, problem.gradient_average)).ravel()

    def _radii(self, on_face: bool) -> Array:
        return self.problem.face.radii if on_face else self.problem.radii

    def _greatest(self, functions: Array) -> Array:
        """Return the greatest value over the punch of each of (T, size) functions.

        It is the top of a cubic between two samples.
        """
        samples = (self._everywhere @ functions.T).T
        slopes = (self._slope_everywhere @ functions.T).T
        row = np.arange(len(samples))
        best = samples.argmax(axis=1)
        left = np.clip(np.where(slopes[row, best] > 0, best, best - 1), 0, samples.shape[1] - 2)
        width = self._samples[left + 1] - self._samples[left]
        start, rise = samples[row, left], samples[row, left + 1] - samples[row, left]
        first, last = width * slopes[row, left], width * slopes[row, left + 1]
        # start + first t + b t^2 + c t^3 with the end's value and slope; its top where the slope
        # changes sign
        b, c = 3 * rise - 2 * first - last, first + last - 2 * rise
        inside = (first > 0) & (last < 0)
        root = np.sqrt(np.where(inside, b * b - 3 * c * first, 1.0))
        top = np.divide(first, root - b, out=np.zeros(len(row)), where=inside)
        return np.maximum(samples[row, best], start + top * (first + top * (b + top * c)))

    @cached_property
    def _unworn_slopes(self) -> Array:
        return self.problem.profile.slope(self.space.quadrature[0].ravel())

    def _rms_slope(self, worn: Array, unworn: Array | float) -> Array:
        # by points, not by a Gram matrix, which would sum the square of a constant over a small
        # element to roundoff
        slopes = (_slopes(self.space) @ worn.T).T + unworn
        return np.sqrt(slopes**2 @ self._slope_weights)

    def _pressure(self, history: History, radii: Array) -> Array:
        """Return pressures (T, R) at radii, those of the start by functions of its own.

        None is negative: what polynomials have below zero beside an edge is an artefact of theirs.
        """
        at = _matrix(self.space, radii.tobytes())

        def sample(pressures: Array) -> Array:
            return np.maximum((at @ pressures.T).T, 0.0)

        return self._of_pressures(history, sample, lambda start: start.pressure_at(radii))

    @staticmethod
    def _of_pressures(
        history: History, take: Callable[[Array], Array], of: Callable[[Start], Array]
    ) -> Array:
        """Return values (T, ...) of pressures, with those that have functions of their own."""
        if (pressed := history.pressed) is None:
            return take(history.pressure)
        values, rows = take(pressed.rest), pressed.force > 0
        # at a rim they need not be finite
        values[rows] += np.outer(pressed.force[rows] / pressed.start.force, of(pressed.start))
        return values

    def ring_forces(self, history: History) -> Array:
        """Return the force (T, N) on each ring."""
        ring_edges = self.problem.ring_edges
        on_rings = _ring_forces(self.space, ring_edges.tobytes()).T
        return self._of_pressures(
            history,
            lambda pressures: np.asarray(pressures @ on_rings),
            lambda start: start.ring_forces(ring_edges),
        )

    def worn_volumes(self, history: History) -> Array:
        """Return what has worn off each ring (T, N)."""
        if self.problem.full_contact:
            on_rings = _ring_forces(self.space, self.problem.ring_edges.tobytes())
            return np.asarray(history.profile @ on_rings.T)
        # k times the time integral of the pressure, which alone is in the space
        rings, space = self.problem.merged, self.space
        integral = history.profile / space.at_vertices(rings.wear_coefficients)
        worn = integral @ (space.mass(rings.wear_coefficients) @ space.ring_indicator())
        first = np.searchsorted(rings.ring_edges, self.problem.ring_edges[:-1])
        return np.asarray(np.add.reduceat(worn, first, axis=1))

    def _carries(self, history: History, radii: Array) -> Array:
        """Return whether the punch touches (T, R) at radii."""
        carries = _matrix(self.space, radii.tobytes()) @ history.pressure.T > 0
        if history.pressed is not None:
            parts = history.pressed.start.intervals
            within = [(radii >= part.inner) & (radii <= part.outer) for part in parts]
            carries[:, history.pressed.force > 0] = np.any(within, axis=0)[:, None]
        return np.asarray(carries.T)

    def displaced(self, history: History) -> Array:
        """Return coefficients (T, size) of the displacement of the half-space, u = d - f + gap.

        The gap, and the unworn face, are known by their moments against the pressures.
        """
        uniform = self.space.uniform
        displaced = history.indentation[:, None] * uniform - history.profile
        if self.problem.full_contact:
            return displaced
        return displaced + self._mass.solve((history.gap - self._unworn).T).T

    @cached_property
    def _mass(self) -> Any:
        return splu(self.space.mass().tocsc())

    @cached_property
    def _unworn(self) -> Array:
        return moments(self.problem.profile, self.space)

    def history(self, history: History, on_face: bool = False) -> Results:
        """Return the quantities that run over time.

        Parameters
        ----------
        history : of T times
        on_face : fields on the face of the punch, not at the radii of the output; only what can be
            compared
        """
        problem, radii = self.problem, self._radii(on_face)
        at, profile = _matrix(self.space, radii.tobytes()), problem.profile
        standoff = profile.standoff
        displaced = self.displaced(history)
        heights = profile(radii) + (at @ history.profile.T).T

        def displacement() -> Array:
            touching = history.indentation[:, None] - heights
            if problem.full_contact:
                return touching
            return np.where(self._carries(history, radii), touching, (at @ displaced.T).T)

        def at_centre() -> Array:
            centre = (_matrix(self.space, np.zeros(1).tobytes()) @ displaced.T)[0]
            pressed = history.pressed
            if pressed is not None and pressed.start.intervals[0].inner == 0:
                unworn = profile(np.zeros(1))[0]
                started = (pressed.force > 0) & (history.distances == 0)
                centre = np.where(started, history.indentation - unworn, centre)
            return np.asarray(centre)

        unworn = 0.0 if problem.full_contact else self._unworn_slopes
        values: Values = {
            "pressure": lambda: self._pressure(history, radii),
            "profile": lambda: heights + standoff,
            "displacement": displacement,
            "indentation": lambda: history.indentation + standoff,
            "displacement_centre": at_centre,
            "displacement_max": lambda: self._greatest(displaced),
            "rms_slope": lambda: self._rms_slope(history.profile, unworn),
            "ring_force": lambda: self.ring_forces(history),
        }
        if problem.indentation is not None or not problem.full_contact:
            values["normal_force"] = lambda: self.ring_forces(history).sum(axis=1)
            values["ring_worn_volume"] = lambda: self.worn_volumes(history)
        elif problem.loading.varies:
            values["normal_force"] = lambda: history.force
        if not problem.full_contact:
            values |= self._of_contact(history, radii, on_face)
        # by these the errors of the others are measured
        measures = ["indentation", "normal_force"]
        if self.by_fields and problem.wants("displacement_max"):
            measures.append("displacement")
        # where pressures may be infinite
        pressed = history.distances == 0
        if history.pressed is not None:
            pressed = history.pressed.force > 0
        wanted = self._wanted(values, *measures)
        return wanted | {"time": history.distances, "pressed": pressed}

    def _of_contact(self, history: History, radii: Array, on_face: bool) -> Values:
        """Return what is of interest only where contact opens, closes and spreads."""
        edges = [
            worn_edges(self.space, contact, worn)
            for contact, worn in zip(history.contact, history.profile, strict=True)
        ]
        if history.pressed is not None:
            fitted = [(part.inner, part.outer) for part in history.pressed.start.intervals]
            for row in np.flatnonzero(history.pressed.force):
                edges[row] = fitted
        values: Values = {
            "contact_radius": lambda: np.array([parts[-1][1] if parts else 0.0 for parts in edges]),
        }
        if not on_face:
            values["contact"] = lambda: self._carries(history, radii).astype(float)
            values["contact_edge"] = lambda: _padded(edges)
        return values

    def steady(self, state: SteadyState, on_face: bool = False) -> Results:
        """Return the quantities of the steady state."""
        radii = self._radii(on_face)
        at = _matrix(self.space, radii.tobytes())
        greatest = self._greatest(state.displacement[None])
        values: Values = {
            "steady_pressure": lambda: at @ state.pressure,
            "steady_profile": lambda: np.maximum(greatest - at @ state.displacement, 0.0),
            "steady_displacement_max": lambda: greatest[0],
            "steady_rms_slope": lambda: self._rms_slope(state.displacement[None], 0.0)[0],
            "steady_wear_rate": lambda: np.asarray(state.wear_rate),
        }
        measures = ["steady_displacement_max"]
        if self.by_fields:
            measures.append("steady_profile")
        return self._wanted(values, *measures)

    @property
    def by_fields(self) -> bool:
        """Whether greatest values are known no better than their fields: of low degree, their
        differences often vanish.
        """
        return self.problem.full_contact and self.space.top <= 2

    def _wanted(self, values: Values, *always: str) -> Results:
        return {
            name: value()
            for name, value in values.items()
            if name in always or self.problem.wants(name)
        }


def _padded(edges: list[list[tuple[float, float]]]) -> Array:
    """Return inner and outer radius of every part of the contact in turn (T, E), nan where there
    are no more.
    """
    out = np.full((len(edges), 2 * max(map(len, edges), default=0)), np.nan)
    for row, parts in zip(out, edges, strict=True):
        row[: 2 * len(parts)] = np.ravel(parts)
    return out
