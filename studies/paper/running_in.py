"""The running-in of the paper's five rings by every method: the data of Figs. 4 and 5.

Heights are counted from the least worn point, ``f - f_min = u_max - u``, which is Eq. 27 at every time; so is the
one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``. Normalised as in the paper: heights by
``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``, lengths by `a`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from ringwear.mdr import direct
from ringwear.mdr.transforms import line_density
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.radial import Array, ring_areas
from ringwear.studies.figures.run import D0, P0
from ringwear.studies.methods.model import Model
from ringwear.studies.methods.outcome import Sampler
from ringwear.studies.methods.radial import MODELS
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages
from ringwear.studies.wear.archard import Wear
from scipy.optimize import brentq

METHODS = ("mdr", "fem", "bem")  # the first gives the times of the states; those that are not installed are left out
WEAR_RATIO, RINGS = 10.0, 5
SHARES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
STATIONARY = 0.984  # share of the displacement difference at which the paper's run ends, t_stat
LATEST = 1.25  # of Fig. 5, in t_stat
RTOL = 3e-6  # or the scene's, where that is smaller: slopes are less accurate than the indentation
AVERAGES = ("line", "area")


def paper_punch(scene: Scene, rings: int = RINGS, width_ratio: float = 1.0, wear_ratio: float = WEAR_RATIO) -> Scene:
    """A punch of the paper, its steady state only, on the half-space and at the accuracy of `scene`."""
    slow = min(scene.punch.wear_coefficients)
    punch = {"radius": scene.punch.radius, "rings": rings, "width_ratio": float(width_ratio)}
    return scene.changed(punch=punch | {"wear_coefficients": [slow, slow * float(wear_ratio)]}, wear={}, output={})


@dataclass(frozen=True, eq=False)
class States:
    """Sampled states of one method: the first axis runs over the states.

    Parameters
    ----------
    method : its name
    share : (S,) displacement difference over that of the steady state
    least_wear : (S,) worn height of the least worn point over d0; infinite in the steady state
    profile, line_profile : (S, R) f/d0 and g/d0, counted from the least worn point
    pressure : (S, R) p/p0
    """

    method: str
    share: Array
    least_wear: Array
    profile: Array
    line_profile: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class Evolution:
    """The running-in of a punch by one method, on one compliance."""

    method: str
    natural: NaturalScene
    compliance: Compliance

    @cached_property
    def wear(self) -> Wear:
        return Wear(self.compliance, self.natural.phases[1])

    @cached_property
    def _samplers(self) -> dict[str, Sampler]:
        scenes = {name: self.natural.scene.changed(output__gradient_average=name) for name in AVERAGES}
        return {name: Sampler(scene.natural, self.compliance.space) for name, scene in scenes.items()}

    def _sampled(self, times: Array, average: str = "line") -> dict[str, Array]:
        return self._samplers[average].history(self.wear.history(times))

    @cached_property
    def steady(self) -> dict[str, Array]:
        """The steady state, as in `Sampler.steady`; also `steady_rms_slope_area`."""
        parts = {name: self._samplers[name].steady(self.wear) for name in AVERAGES}
        return parts["line"] | {"steady_rms_slope_area": parts["area"]["steady_rms_slope"]}

    def share(self, times: Array) -> Array:
        """Displacement difference ``(u_max(t) - d0) / (u_max_stat - d0)`` that Fig. 4 monitors."""
        return (self._sampled(times)["displacement_max"] - D0) / (self.steady["steady_displacement_max"] - D0)

    def time_of(self, share: float) -> float:
        """Time, in natural units, at which the displacement difference has reached a share of its steady value."""
        if share in (0.0, 1.0):
            return 0.0 if share == 0 else np.inf
        # the slowest mode alone would need this long; the others only make it faster
        latest = self.wear.relaxation_times[0] * (5 - 2 * np.log(1 - share))
        return float(brentq(lambda time: self.share(np.array([time]))[0] - share, 0.0, latest, xtol=1e-14, rtol=1e-12))

    def states(self, times: Array) -> States:
        """States at times in natural units, infinity for the steady state."""
        finite = np.isfinite(times)
        history = self.wear.history(times[finite])
        sampled = self._samplers["line"].history(history)
        greatest = sampled["displacement_max"][:, None]
        radii = self.natural.radii
        density = line_density(self.compliance.space, np.maximum(radii, 1e-6))
        rows = {
            "profile": greatest - sampled["displacement"],
            "line_profile": greatest - history.pressure @ density.T,
            "pressure": sampled["pressure"],
        }
        steady_greatest = self.steady["steady_displacement_max"]
        last = {
            "profile": self.steady["steady_profile"],
            "line_profile": steady_greatest - density @ self.wear.steady.pressure,
            "pressure": self.steady["steady_pressure"],
        }
        units = {"profile": D0, "line_profile": D0, "pressure": P0}
        fields = {name: np.empty((len(times), len(radii))) for name in rows}
        for name, field in fields.items():
            field[finite], field[~finite] = rows[name] / units[name], last[name] / units[name]
        share, least = np.ones(len(times)), np.full(len(times), np.inf)
        share[finite] = (greatest[:, 0] - D0) / (steady_greatest - D0)
        least[finite] = (sampled["indentation"] - greatest[:, 0]) / D0
        return States(self.method, share, least, **fields)

    def gradients(self, times: Array) -> dict[str, Array]:
        """RMS gradient (Eq. 18) over the stationary one at times in natural units, for each average."""
        stationary = {"line": self.steady["steady_rms_slope"], "area": self.steady["steady_rms_slope_area"]}
        return {name: self._sampled(times, name)["rms_slope"] / stationary[name] for name in AVERAGES}

    def ring_forces(self, times: Array) -> Array:
        """(T, N) force on each ring over its force in the steady state, at times in natural units."""
        edges, wear = self.natural.phases
        return self._sampled(times)["ring_force"] / (direct.steady_pressures(edges, wear) * ring_areas(edges))


@dataclass(frozen=True, eq=False)
class RunningIn:
    """The paper's example by every method.

    Parameters
    ----------
    evolutions : by method, the first giving the times
    models : what the methods were made of
    times : (S,) of the states, in natural units
    stationary : t_stat, in natural units
    """

    evolutions: dict[str, Evolution]
    models: dict[str, Model]
    times: Array
    stationary: float

    @property
    def reference(self) -> Evolution:
        return next(iter(self.evolutions.values()))

    @cached_property
    def states(self) -> dict[str, States]:
        return {name: evolution.states(self.times) for name, evolution in self.evolutions.items()}

    @cached_property
    def curve_times(self) -> Array:
        """Times of Fig. 5: dense at the start, where the rim wears."""
        return self.stationary * LATEST * np.linspace(0, 1, 161) ** 3

    @cached_property
    def curves(self) -> dict[str, dict[str, Array]]:
        return {name: evolution.gradients(self.curve_times) for name, evolution in self.evolutions.items()}

    @cached_property
    def coarser(self) -> Evolution:
        """The reference method on a coarser space: what its uncertainty is told from."""
        twin = self.models[self.reference.method].twins[0]
        return Evolution(self.reference.method, self.reference.natural, twin.coarser)


def running_in(scene: Scene, report: Report) -> RunningIn:
    """Condense the paper's example by every method, and find the times of its states."""
    natural = paper_punch(scene.changed(accuracy__rtol=min(RTOL, scene.accuracy.rtol))).natural
    models = {name: MODELS[name](natural, Stages(name, report)) for name in METHODS if name in MODELS}
    evolutions = {name: Evolution(name, natural, model.compliance) for name, model in models.items()}
    reference = next(iter(evolutions.values()))
    times = np.array([reference.time_of(share) for share in SHARES])
    return RunningIn(evolutions, models, times, reference.time_of(STATIONARY))


def direct_state(natural: NaturalScene) -> tuple[Array, Array]:
    """Limiting profile f/d0 and pressure p/p0 by direct integration at the radii of the scene (Eqs. 24 to 27)."""
    edges, wear = natural.phases
    pressures = direct.steady_pressures(edges, wear)
    ring = np.clip(np.searchsorted(edges, natural.radii, side="right") - 1, 0, len(wear) - 1)
    return direct.limiting_profile(edges, pressures, natural.radii) / D0, pressures[ring] / P0
