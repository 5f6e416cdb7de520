"""From coefficients on a pressure space to the quantities that are asked for, labelled.

Non-dimensional.
"""

from collections.abc import Callable, Iterator
from functools import cached_property, lru_cache

import numpy as np
import xarray
from scipy.sparse import csr_matrix

from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices
from ..problem.problem import Problem
from ..wear.archard import History, RunningIn
from ..wear.contact import SteadyState
from ..wear.shared_modes import SharedModes
from .quantities import FIELDS, HISTORIES, STEADY, array, labelled, radial_weight

AVERAGES = ("line", "area")
# times whose coefficients are held at once
AT_ONCE = 1024


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
    """Enough radii in each element that a cubic finds the greatest value between them to nine
    digits.
    """
    count = 3 * (space.top + 2)
    within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
    return np.append((starts + widths * within).ravel(), 1.0)


class Sampler:
    """Turns coefficients on a pressure space into the quantities of a problem."""

    def __init__(self, problem: Problem, space: PressureSpace) -> None:
        self.problem, self.space = problem, space
        self._samples = _samples(space)
        self._everywhere = _matrix(space, self._samples.tobytes())
        self._slope_everywhere = _matrix(space, self._samples.tobytes(), derivative=True)
        radii, weights, _ = space.quadrature
        self._slope_weights = (weights * radial_weight(radii, problem.gradient_average)).ravel()

    def _at(self, on_face: bool) -> csr_matrix:
        return _matrix(
            self.space, (self.problem.face.radii if on_face else self.problem.radii).tobytes()
        )

    def _greatest(self, functions: Array) -> Array:
        """(T,) greatest value over the punch of (T, size) functions.

        The top of a cubic between two samples.
        """
        samples, slopes = (
            (self._everywhere @ functions.T).T,
            (self._slope_everywhere @ functions.T).T,
        )
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

    def _rms_slope(self, profile: Array) -> Array:
        # by points, not by a Gram matrix, which would sum the square of a constant over a small
        # element to roundoff
        return np.sqrt(self._slope_weights @ (_slopes(self.space) @ profile.T) ** 2)

    def _pressure(self, history: History, at: csr_matrix, radii: Array) -> Array:
        """(T, R) pressures at radii.

        Those of the flat start by the functions that it was sought among.

        Under a flat punch none is negative: what polynomials have below zero beside an edge is an
        artefact of theirs.
        """
        pressure = np.maximum((at @ history.pressure.T).T, 0.0)
        if history.flat is not None:
            pressure[history.times == 0] = history.flat.pressure_at(radii)
        return pressure

    def _ring_forces(self, history: History) -> Array:
        """(T, N) force on each ring."""
        ring_edges = self.problem.ring_edges
        forces = history.pressure @ _ring_forces(self.space, ring_edges.tobytes()).T
        if history.flat is not None:
            forces[history.times == 0] = history.flat.ring_forces(ring_edges)
        return forces

    def history(self, history: History, on_face: bool = False) -> xarray.Dataset:
        """The quantities that run over time.

        Fields at the radii of the output, or on the face of the punch.
        """
        profile, indentation = history.profile, history.indentation
        at, radii = self._at(on_face), self.problem.face.radii if on_face else self.problem.radii
        values: dict[str, Callable[[], Array]] = {
            "pressure": lambda: self._pressure(history, at, radii),
            "profile": lambda: (at @ profile.T).T,
            "displacement": lambda: indentation[:, None] - (at @ profile.T).T,
            "indentation": lambda: indentation,
            "displacement_centre": lambda: (
                indentation - profile @ _matrix(self.space, np.zeros(1).tobytes()).toarray()[0]
            ),
            "displacement_max": lambda: indentation + self._greatest(-profile),
            "rms_slope": lambda: self._rms_slope(profile),
            "ring_force": lambda: self._ring_forces(history),
        }
        # by the indentation the errors of the others are measured
        return self._wanted(values, "indentation", history.times, on_face)

    def steady(self, state: SteadyState, on_face: bool = False) -> xarray.Dataset:
        """The quantities of the steady state."""
        at = self._at(on_face)
        greatest = self._greatest(state.displacement[None])
        values: dict[str, Callable[[], Array]] = {
            "steady_pressure": lambda: at @ state.pressure,
            "steady_profile": lambda: np.maximum(greatest - at @ state.displacement, 0.0),
            "steady_displacement_max": lambda: greatest[0],
            "steady_rms_slope": lambda: self._rms_slope(state.displacement[None])[0],
            "steady_wear_rate": lambda: np.asarray(state.wear_rate),
        }
        return self._wanted(values, "steady_displacement_max", None, on_face)

    def _wanted(
        self,
        values: dict[str, Callable[[], Array]],
        always: str,
        times: Array | None,
        on_face: bool,
    ) -> xarray.Dataset:
        found = {
            name: value()
            for name, value in values.items()
            if name == always or self.problem.wants(name)
        }
        return labelled(found, self.problem.face.radii if on_face else self.problem.radii, times)


class Evaluation:
    """One compliance worn and sampled: everything that a problem asks of it. Labelled."""

    def __init__(
        self, problem: Problem, compliance: Compliance, shared: SharedModes | None = None
    ) -> None:
        self.problem = problem
        self.wear = RunningIn(
            compliance, problem.merged.wear_coefficients, problem.earliest, shared
        )
        self.sampler = Sampler(problem, compliance.space)

    @cached_property
    def marched(self) -> History:
        """At the times asked for, in the steps asked for."""
        return self.wear.history(self.problem.times, self.problem.march, self.problem.step)

    def _history(self, which: Indices) -> History:
        """At some of the times asked for, by the march asked for."""
        return (
            self.wear.modal(self.problem.times[which])
            if self.problem.march == "modal"
            else self.marched[which]
        )

    @cached_property
    def results(self) -> xarray.Dataset:
        """At the times and radii asked for."""
        every = np.arange(len(self.problem.times))
        # coefficients of a hundred thousand times would fill the memory
        return self._of(
            self._history(which) for which in np.array_split(every, 1 + len(every) // AT_ONCE)
        )

    @cached_property
    def checked(self) -> xarray.Dataset:
        """At the times that are checked, on the face of the punch.

        What is compared with another method.
        """
        if self.problem.quantities is not None and not self.problem.quantities & FIELDS:
            return (
                self.results.isel(time=self.problem.checked)
                if "time" in self.results.dims
                else self.results
            )
        return self._of((self._history(which) for which in (self.problem.checked,)), on_face=True)

    @cached_property
    def for_estimate(self) -> xarray.Dataset:
        """At the times that errors are estimated at, on the face of the punch, exact in time."""
        return self._of(
            (self.wear.modal(times) for times in (self.problem.estimate_times,)), on_face=True
        )

    def _of(self, pieces: Iterator[History], on_face: bool = False) -> xarray.Dataset:
        problem, parts = self.problem, []
        if marched := bool(len(problem.times)) and any(map(problem.wants, HISTORIES)):
            parts.append(_joined([self.sampler.history(piece, on_face) for piece in pieces]))
        # by itself, a relaxation time needs no history
        if problem.wants("relaxation_time") and (
            len(problem.times) or problem.quantities is not None
        ):
            times = self.wear.relaxation_times if marched else self.wear.slowest_times
            parts.append(xarray.Dataset({"relaxation_time": ("mode", times)}))
        if problem.steady and any(map(problem.wants, STEADY)):
            parts.append(self.sampler.steady(self.wear.steady, on_face))
        return xarray.merge(parts)


def _joined(parts: list[xarray.Dataset]) -> xarray.Dataset:
    """Datasets of successive times as one, without holding all of it twice."""
    if len(parts) == 1:
        return parts[0]
    times, radii = (
        np.concatenate([array(part, "time") for part in parts]),
        array(parts[0], "radius"),
    )
    found = {}
    for name in map(str, list(parts[0].data_vars)):
        found[name] = np.concatenate([array(part, name) for part in parts])
        parts = [part.drop_vars(name) for part in parts]
    return labelled(found, radii, times)
