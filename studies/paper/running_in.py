"""The running-in of the paper's five rings by every method: Figs. 4 and 5.

Heights are counted from the least worn point, ``f - f_min = u_max - u``, which is Eq. 27 at every
time; so is the one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``.
Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``,
lengths by `a`.
"""

from dataclasses import dataclass, replace

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

COUNT, WEAR_RATIO = 5, 10.0
# of the way of the greatest displacement, by which Fig. 4 tells its states
PERCENTS = (0, 10, 30, 50, 70, 90, 100)
# part of the way at which the paper's run ends, t_stat: by its printed 27 % of the time for 70 %
STATIONARY = 0.984
# k2/k1 of the relaxation times
WEAR_RATIOS = 10.0 ** np.linspace(-4, 4, 33)


def discretise(name: str, problem: Problem) -> Compliance:
    """Return the compliance by a method that suits a problem."""
    return compliance_method(name).discretise(problem, Stages(name)).compliance


class Evolution:
    """The running-in of a punch on one compliance."""

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem, self.compliance = problem, compliance
        self.wear = RunningIn(compliance, problem.merged.wear_coefficients)
        self._samplers = [
            Sampler(replace(problem, gradient_average=average), compliance.space)
            for average in AVERAGES
        ]
        self._line_density = line_density(compliance.space, np.maximum(problem.radii, 1e-6))

    @property
    def end(self) -> float:
        """Time at which the steady state is reached to roundoff."""
        return 50 * float(self.wear.relaxation_times[0])

    def states(self, times: Array) -> xarray.Dataset:
        """Return the states at increasing times.

        `gradient` (average, time), RMS gradients (Eq. 18), and `ring_force` are over those of the
        steady state; `way` is the part of its way that the greatest displacement has made.
        """
        history = self.wear.history(np.append(times, self.end))
        sampled, by_area = (sampler.history(history) for sampler in self._samplers)
        greatest = sampled.displacement_max
        line_density = xarray.Variable(("time", "radius"), history.pressure @ self._line_density.T)
        gradient = np.stack([sampled.rms_slope, by_area.rms_slope])
        states = xarray.Dataset(
            {
                "f_over_d0": (greatest - sampled.displacement) / D0,
                "g_over_d0": (greatest - line_density) / D0,
                "p_over_p0": sampled.pressure / P0,
                "least_wear_over_d0": (sampled.indentation - greatest) / D0,
                "gradient": (("average", "time"), gradient / gradient[:, -1:]),
                "ring_force": sampled.ring_force / sampled.ring_force.values[-1],
                "way": (greatest - D0) / (greatest.values[-1] - D0),
            },
            {"average": list(AVERAGES)},
        )
        return states.isel(time=slice(len(times)))

    def time_of(self, way: float) -> float:
        """Return the time at which the greatest displacement has made a part of its way."""
        return float(
            brentq(
                lambda time: float(self.states(np.array([time])).way[0]) - way,
                0.0,
                self.end / 2,
                xtol=1e-14,
                rtol=1e-12,
            )
        )


@dataclass(frozen=True, eq=False)
class FiveRings:
    """The paper's example by every method.

    Parameters
    ----------
    problem : five rings on the half-space of the scene
    evolutions : by MDR, which gives the times, FEM and BEM
    stationary : t_stat
    states, history : of Figs. 4 and 5, over (solver, time), times in t_stat
    limiting : `f_over_d0` and `p_over_p0` of the steady state by direct integration
    """

    problem: Problem
    evolutions: dict[str, Evolution]
    stationary: float
    states: xarray.Dataset
    history: xarray.Dataset
    limiting: xarray.Dataset


def compute_five_rings(problem: Problem) -> FiveRings:
    """Return the paper's example on the half-space of a problem."""
    problem = replace(
        problem,
        rings=Rings.alternating(COUNT, 1.0, WEAR_RATIO),
        times=np.empty(0),
        output_radii=None,
        rtol=min(3e-6, problem.rtol),  # slopes are less accurate than the indentation
    )
    evolutions = {
        name: Evolution(problem, discretise(name, problem)) for name in ("mdr", "fem", "bem")
    }
    reference = evolutions["mdr"]
    stationary = reference.time_of(STATIONARY)

    def by_solver(times: Array) -> xarray.Dataset:
        states = [evolution.states(times) for evolution in evolutions.values()]
        joined = xarray.concat(states, xarray.Variable("solver", list(evolutions)))
        return joined.assign_coords(time=times / stationary)

    between = [reference.time_of(percent / 100) for percent in PERCENTS[1:-1]]
    states = by_solver(np.array([0.0, *between, reference.end]))
    # dense at the start, where the rim wears
    history = by_solver(1.25 * stationary * np.linspace(0, 1, 161) ** 3)
    pressures = direct.steady_pressures(*problem.rings)
    profile = direct.limiting_profile(problem.ring_edges, pressures, problem.radii)
    limiting = xarray.Dataset(
        {
            "f_over_d0": ("radius", profile / D0),
            "p_over_p0": ("radius", pressures[ring_of(problem.ring_edges, problem.radii)] / P0),
        },
        {"radius": problem.radii},
    )
    return FiveRings(problem, evolutions, stationary, states, history, limiting)


def compute_relaxation_times(problem: Problem, counts: tuple[int, ...]) -> xarray.DataArray:
    """Return (rings, wear_ratio) slowest relaxation times over ``a / (E* k_slow v0)``, by MDR."""
    slowest = np.empty((len(counts), len(WEAR_RATIOS)))
    for row, count in enumerate(progress(counts, "rings")):
        rings = Rings.alternating(count, 1.0, WEAR_RATIO)
        # measured: the slowest time to 1e-7
        compliance = discretise("mdr", replace(problem, rings=rings, times=np.empty(0), rtol=1e-3))
        for column, ratio in enumerate(WEAR_RATIOS):
            coefficients = Rings.alternating(count, 1.0, ratio).wear_coefficients
            wear = RunningIn(compliance, coefficients / coefficients.min())
            slowest[row, column] = wear.slowest_times[0]
    return xarray.DataArray(slowest, {"rings": list(counts), "wear_ratio": WEAR_RATIOS})
