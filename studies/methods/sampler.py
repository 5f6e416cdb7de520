"""From coefficients on a pressure space to the quantities that are asked for, labelled. Non-dimensional."""

from functools import cached_property

import numpy as np
import xarray

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array
from ringwear.studies.methods.quantities import labelled
from ringwear.studies.problem.problem import Problem
from ringwear.studies.wear.archard import History, RunningIn

AVERAGES = ("line", "area")


def radial_weight(radii: Array, average: str) -> Array:
    """Weight of a radial average at radii: over the radius, or over the area."""
    return np.ones_like(radii) if average == "line" else 2 * radii


class Sampler:
    """Turns coefficients on a pressure space into the quantities of a problem."""

    def __init__(self, problem: Problem, space: PressureSpace) -> None:
        self.problem, self.space = problem, space
        self._at_radii = space.matrix(problem.radii)
        self._at_centre = space.matrix(np.zeros(1)).toarray()[0]
        # enough radii in each element that a cubic finds the greatest value between them
        within = (1 - np.cos(np.pi * np.arange(12) / 12)) / 2
        starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
        self._samples = np.append((starts + widths * within).ravel(), 1.0)
        self._everywhere = space.matrix(self._samples)
        self._slope_everywhere = space.matrix(self._samples, derivative=True)
        self._ring_forces = space.ring_forces(problem.ring_edges)
        self.slopes = space.slope_gram(radial_weight(space.quadrature[0], problem.gradient_average))

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
        # a constant has no slope, but one much greater than the rest would leave its roundoff
        profile = profile - profile[:, :1] * (self.space.order == 1)
        return np.sqrt(np.maximum(np.einsum("ti,ti->t", profile @ self.slopes, profile), 0.0))

    def history(self, history: History) -> dict[str, Array]:
        """The quantities that run over time."""
        pressure, profile, indentation = history.pressure, history.profile, history.indentation
        worn = (self._at_radii @ profile.T).T
        return {
            "pressure": (self._at_radii @ pressure.T).T,
            "profile": worn,
            "displacement": indentation[:, None] - worn,
            "indentation": indentation,
            "displacement_centre": indentation - profile @ self._at_centre,
            "displacement_max": indentation + self._greatest(-profile),
            "rms_slope": self._rms_slope(profile),
            "ring_force": pressure @ self._ring_forces.T,
        }

    def steady(self, wear: RunningIn) -> dict[str, Array]:
        """The quantities of the steady state."""
        state = wear.steady
        greatest = self._greatest(state.displacement[None])
        return {
            "steady_pressure": self._at_radii @ state.pressure,
            "steady_profile": np.maximum(greatest - self._at_radii @ state.displacement, 0.0),
            "steady_displacement_max": greatest[0],
            "steady_rms_slope": self._rms_slope(state.displacement[None])[0],
            "steady_wear_rate": np.asarray(state.wear_rate),
        }


class Evaluation:
    """One compliance worn and sampled: everything that a problem asks of it."""

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem = problem
        self.wear = RunningIn(compliance, problem.merged.wear_coefficients, problem.earliest)
        self.sampler = Sampler(problem, compliance.space)

    @cached_property
    def results(self) -> xarray.Dataset:
        """The quantities, labelled."""
        problem, values = self.problem, dict[str, Array]()
        if len(problem.times):
            values |= self.sampler.history(self.wear.history(problem.times, problem.march, problem.step))
            values["relaxation_time"] = self.wear.relaxation_times
        if problem.steady:
            values |= self.sampler.steady(self.wear)
        return labelled(values)
