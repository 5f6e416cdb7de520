"""The running-in of the paper's five rings by every method: Figs. 4 and 5.

Heights are counted from the least worn point, ``f - f_min = u_max - u``, which is Eq. 27 at every
time; so is the one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``.
Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``,
lengths by `a`.
"""

from dataclasses import replace

import numpy as np
import xarray
from scipy.optimize import brentq

from ...mdr import direct
from ...mdr.transforms import line_density
from ...meshes.compliance import Compliance
from ...meshes.radial import Array, ring_of
from ..methods.pipeline import compliance_method
from ..methods.sampler import AVERAGES, Sampler
from ..problem.problem import D0, P0, Problem, Rings
from ..progress import Stages, progress
from ..wear.full_contact import RunningIn

# of the way of the greatest displacement, by which Fig. 4 tells its states
PERCENTS = (0, 10, 30, 50, 70, 90, 100)
# part of the way at which the paper's run ends, t_stat: by its printed 27 % of the time for 70 %
STATIONARY = 0.984


def discretise(name: str, problem: Problem) -> Compliance:
    """Return the compliance by a method that suits a problem."""
    return compliance_method(name).discretise(problem, Stages(name)).compliance


class Evolution:
    """The running-in of a punch on one compliance."""

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.wear = RunningIn(compliance, problem.merged.wear_coefficients)
        # the time at which the steady state is reached to roundoff
        self.end = 50 * float(self.wear.relaxation_times[0])
        self._samplers = [
            Sampler(replace(problem, gradient_average=average), compliance.space)
            for average in AVERAGES
        ]
        self._radii = problem.radii
        self._line_density = line_density(compliance.space, np.maximum(problem.radii, 1e-6))

    def states(self, times: Array) -> xarray.Dataset:
        """Return the states at increasing times.

        `gradient` (average, time), RMS gradients (Eq. 18), and `ring_force` are over those of the
        steady state; `way` is the part of its way that the greatest displacement has made.
        """
        history = self.wear.history(np.append(times, self.end))
        sampled, by_area = (sampler.history(history) for sampler in self._samplers)
        greatest, forces = sampled["displacement_max"], sampled["ring_force"]
        line_density = history.pressure @ self._line_density.T
        gradient = np.stack([sampled["rms_slope"], by_area["rms_slope"]])
        field = ("time", "radius")
        states = xarray.Dataset(
            {
                "f_over_d0": (field, (greatest[:, None] - sampled["displacement"]) / D0),
                "g_over_d0": (field, (greatest[:, None] - line_density) / D0),
                "p_over_p0": (field, sampled["pressure"] / P0),
                "least_wear_over_d0": ("time", (sampled["indentation"] - greatest) / D0),
                "gradient": (("average", "time"), gradient / gradient[:, -1:]),
                "ring_force": (("time", "ring"), forces / forces[-1]),
                "way": ("time", (greatest - D0) / (greatest[-1] - D0)),
            },
            {"average": list(AVERAGES), "radius": self._radii},
        )
        return states.isel(time=slice(len(times)))

    def time_of(self, way: float) -> float:
        """Return the time at which the greatest displacement has made a part of its way."""

        def way_left(time: float) -> float:
            return way - float(self.states(np.array([time])).way[0])

        return float(brentq(way_left, 0.0, self.end / 2, xtol=1e-14, rtol=1e-12))


class FiveRings:
    """The paper's example by every method, on the half-space of a problem.

    Parameters
    ----------
    problem : of which the half-space and the accuracy are taken

    Attributes
    ----------
    evolutions : by MDR, which gives the times, FEM and BEM
    stationary : t_stat
    states, history : of Figs. 4 and 5, over (solver, time), times in t_stat
    limiting : `f_over_d0` and `p_over_p0` of the steady state by direct integration
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem = replace(
            problem,
            rings=Rings.alternating(5, 1.0, 10.0),
            times=np.empty(0),
            output_radii=None,
            rtol=min(3e-6, problem.rtol),  # slopes are less accurate than the indentation
        )
        self.evolutions = {
            name: Evolution(problem, discretise(name, problem)) for name in ("mdr", "fem", "bem")
        }
        reference = self.evolutions["mdr"]
        self.stationary = reference.time_of(STATIONARY)
        between = [reference.time_of(percent / 100) for percent in PERCENTS[1:-1]]
        self.states = self._by_solver(np.array([0.0, *between, reference.end]))
        # dense at the start, where the rim wears
        self.history = self._by_solver(1.25 * self.stationary * np.linspace(0, 1, 161) ** 3)
        edges, radii = problem.ring_edges, problem.radii
        pressures = direct.steady_pressures(*problem.rings)
        fields = {
            "f_over_d0": direct.limiting_profile(edges, pressures, radii) / D0,
            "p_over_p0": pressures[ring_of(edges, radii)] / P0,
        }
        self.limiting = xarray.Dataset(
            {name: ("radius", values) for name, values in fields.items()}, {"radius": radii}
        )

    def _by_solver(self, times: Array) -> xarray.Dataset:
        states = [evolution.states(times) for evolution in self.evolutions.values()]
        joined = xarray.concat(states, xarray.Variable("solver", list(self.evolutions)))
        return joined.assign_coords(time=times / self.stationary)


def compute_relaxation_times(problem: Problem, counts: tuple[int, ...]) -> xarray.DataArray:
    """Return (rings, wear_ratio) slowest relaxation times over ``a / (E* k_slow v0)``, by MDR."""
    ratios = 10.0 ** np.linspace(-4, 4, 33)
    slowest = []
    for count in progress(counts, "rings"):
        rings = Rings.alternating(count, 1.0, 10.0)
        # measured: the slowest time to 1e-7
        compliance = discretise("mdr", replace(problem, rings=rings, times=np.empty(0), rtol=1e-3))
        for ratio in ratios:
            coefficients = Rings.alternating(count, 1.0, ratio).wear_coefficients
            wear = RunningIn(compliance, coefficients / coefficients.min())
            slowest.append(wear.slowest_times[0])
    times = np.reshape(slowest, (len(counts), len(ratios)))
    return xarray.DataArray(times, {"rings": list(counts), "wear_ratio": ratios})
