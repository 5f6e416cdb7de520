"""From coefficients on a pressure space to the quantities that are asked for, labelled. Non-dimensional."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import xarray

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array
from ringwear.studies.methods.quantities import labelled, radial_weight
from ringwear.studies.problem.problem import Problem
from ringwear.studies.wear.archard import History, RunningIn
from ringwear.studies.wear.contact import SteadyState

AVERAGES = ("line", "area")


class Sampler:
    """Turns coefficients on a pressure space into the quantities of a problem."""

    def __init__(self, problem: Problem, space: PressureSpace) -> None:
        self.problem, self.space = problem, space
        self._at_radii, self._on_face = space.matrix(problem.radii), space.matrix(problem.face.radii)
        self._at_centre = space.matrix(np.zeros(1)).toarray()[0]
        # enough radii in each element that a cubic finds the greatest value between them to nine digits
        count = 3 * (space.top + 2)
        within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
        starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
        self._samples = np.append((starts + widths * within).ravel(), 1.0)
        self._everywhere = space.matrix(self._samples)
        self._slope_everywhere = space.matrix(self._samples, derivative=True)
        self._ring_forces = space.ring_forces(problem.ring_edges)
        radii, weights, local = space.quadrature
        self._slopes = space.on_elements(local, derivative=True)
        self._slope_weights = (weights * radial_weight(radii, problem.gradient_average)).ravel()

    def _greatest(self, functions: Array) -> Array:
        """(T,) greatest value over the punch of (T, size) functions: the top of a cubic between two samples."""
        samples, slopes = (self._everywhere @ functions.T).T, (self._slope_everywhere @ functions.T).T
        row = np.arange(len(samples))
        best = samples.argmax(axis=1)
        left = np.clip(np.where(slopes[row, best] > 0, best, best - 1), 0, samples.shape[1] - 2)
        width = self._samples[left + 1] - self._samples[left]
        start, rise = samples[row, left], samples[row, left + 1] - samples[row, left]
        first, last = width * slopes[row, left], width * slopes[row, left + 1]
        # start + first t + b t^2 + c t^3 with the end's value and slope; its top where the slope changes sign
        b, c = 3 * rise - 2 * first - last, first + last - 2 * rise
        inside = (first > 0) & (last < 0)
        root = np.sqrt(np.where(inside, b * b - 3 * c * first, 1.0))
        top = np.divide(first, root - b, out=np.zeros(len(row)), where=inside)
        return np.maximum(samples[row, best], start + top * (first + top * (b + top * c)))

    def _rms_slope(self, profile: Array) -> Array:
        # by points, not by a Gram matrix, which would sum the square of a constant over a small element to roundoff
        return np.sqrt(self._slope_weights @ (self._slopes @ profile.T) ** 2)

    def history(self, history: History, on_face: bool = False) -> xarray.Dataset:
        """The quantities that run over time; fields at the radii of the output, or on the face of the punch."""
        pressure, profile, indentation = history.pressure, history.profile, history.indentation
        at = self._on_face if on_face else self._at_radii
        worn = (at @ profile.T).T
        values = {
            "pressure": (at @ pressure.T).T,
            "profile": worn,
            "displacement": indentation[:, None] - worn,
            "indentation": indentation,
            "displacement_centre": indentation - profile @ self._at_centre,
            "displacement_max": indentation + self._greatest(-profile),
            "rms_slope": self._rms_slope(profile),
            "ring_force": pressure @ self._ring_forces.T,
        }
        return labelled(values, self._radii(on_face), history.times)

    def steady(self, state: SteadyState, on_face: bool = False) -> xarray.Dataset:
        """The quantities of the steady state."""
        at = self._on_face if on_face else self._at_radii
        greatest = self._greatest(state.displacement[None])
        values = {
            "steady_pressure": at @ state.pressure,
            "steady_profile": np.maximum(greatest - at @ state.displacement, 0.0),
            "steady_displacement_max": greatest[0],
            "steady_rms_slope": self._rms_slope(state.displacement[None])[0],
            "steady_wear_rate": np.asarray(state.wear_rate),
        }
        return labelled(values, self._radii(on_face))

    def _radii(self, on_face: bool) -> Array:
        return self.problem.face.radii if on_face else self.problem.radii


class Evaluation:
    """One compliance worn and sampled: everything that a problem asks of it. Labelled."""

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem = problem
        self.wear = RunningIn(compliance, problem.merged.wear_coefficients, problem.earliest)
        self.sampler = Sampler(problem, compliance.space)

    @cached_property
    def history(self) -> History:
        """At the times asked for, by the march asked for."""
        return self.wear.history(self.problem.times, self.problem.march, self.problem.step)

    @cached_property
    def results(self) -> xarray.Dataset:
        """At the times and radii asked for."""
        return self._of(lambda: self.history)

    @cached_property
    def checked(self) -> xarray.Dataset:
        """At the times that are checked, on the face of the punch: what is compared with another method."""
        return self._of(lambda: self.history[self.problem.checked], on_face=True)

    @cached_property
    def for_estimate(self) -> xarray.Dataset:
        """At the times that errors are estimated at, on the face of the punch, exact in time."""
        return self._of(lambda: self.wear.modal(self.problem.estimate_times), on_face=True)

    def _of(self, history: Callable[[], History], on_face: bool = False) -> xarray.Dataset:
        parts = []
        if len(self.problem.times):
            parts.append(self.sampler.history(history(), on_face))
            parts.append(xarray.Dataset({"relaxation_time": ("mode", self.wear.relaxation_times)}))
        if self.problem.steady:
            parts.append(self.sampler.steady(self.wear.steady, on_face))
        return xarray.merge(parts)
