"""The running-in of the paper's five rings by every method (Figs.

4 and 5), and how long that of any rings takes.

Heights are counted from the least worn point, ``f - f_min = u_max - u``, which is Eq. 27 at every
time; so is the one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``.
Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``,
lengths by `a`.

Many rings, seen from far, wear as one material whose coefficient is the mean of ``1/k`` over the
width, inverted (Eq. 26 on the scale of a ring): their slowest relaxation time is that of a
homogeneous punch, times this mean.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from ...mdr.transforms import line_density
from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..methods.base import method
from ..methods.pipeline import compliance_method
from ..methods.quantities import array, values
from ..methods.sampler import AVERAGES, Sampler
from ..problem.problem import D0, P0, Problem, Rings
from ..progress import Stages, progress
from ..wear.full_contact import History, RunningIn

METHODS = ("mdr", "fem", "bem")  # the first gives the times
COUNT, WEAR_RATIO = 5, 10.0
SHARES = (
    0.0,
    0.1,
    0.3,
    0.5,
    0.7,
    0.9,
    1.0,
)  # of the displacement difference, which Fig. 4 monitors
STATIONARY = 0.984  # its fraction at which the paper's run ends, t_stat
CURVE = (
    1.25 * np.linspace(0, 1, 161) ** 3
)  # times of Fig. 5 in t_stat: dense at the start, where the rim wears
RTOL = 3e-6  # or the scene's, where that is smaller: slopes are less accurate than the indentation
# of the relaxation times
COUNTS, QUICK_COUNTS = (2, 4, 5, 8, 16), (2, 5)
WEAR_RATIOS = 10.0 ** np.linspace(-4, 4, 33)
MODES = 5
SPECTRUM_RTOL = 1e-3  # measured: the slowest to 1e-7, the fifth to 3e-5


@dataclass(frozen=True, eq=False)
class States:
    """A punch at several times, the first axis of every array; heights over d0, pressures over p0.

    Parameters
    ----------
    least_wear : worn height of the least worn point
    profile, line_profile, pressure : at the radii of the problem; f and g are counted from the
        least worn point
    gradients : (T, 2) RMS gradient (Eq. 18) over the stationary one, by both averages
    ring_force : force on each ring over that in the steady state
    """

    least_wear: Array
    profile: Array
    line_profile: Array
    pressure: Array
    gradients: Array
    ring_force: Array


class Evolution:
    """The running-in of a punch on one compliance."""

    def __init__(self, problem: Problem, compliance: Compliance) -> None:
        self.problem, self.compliance = problem, compliance
        self.wear = RunningIn(compliance, problem.merged.wear_coefficients)
        self._samplers = [
            Sampler(replace(problem, gradient_average=name), compliance.space) for name in AVERAGES
        ]
        self._line_density = line_density(compliance.space, np.maximum(problem.radii, 1e-6))

    def _history(self, times: Array) -> History:
        """The history at the finite times and, last, the steady state, its profile counted from
        zero indentation.
        """
        finite, steady = self.wear.history(times[np.isfinite(times)]), self.wear.steady
        return History(
            np.append(finite.times, np.inf),
            np.vstack([finite.pressure, steady.pressure]),
            np.vstack([finite.profile, -steady.displacement]),
            np.append(finite.indentation, 0.0),
        )

    def states(self, times: Array) -> States:
        """States at increasing times; the last may be infinite, the steady state."""
        history = self._history(times)
        line, area = (values(sampler.history(history)) for sampler in self._samplers)
        greatest, rows = line["displacement_max"][:, None], slice(len(times))
        gradients = np.stack([line["rms_slope"], area["rms_slope"]], axis=1)
        least_wear = np.where(
            np.isfinite(history.times), history.indentation - greatest[:, 0], np.inf
        )
        return States(
            least_wear[rows] / D0,
            (greatest - line["displacement"])[rows] / D0,
            (greatest - history.pressure @ self._line_density.T)[rows] / D0,
            line["pressure"][rows] / P0,
            (gradients / gradients[-1])[rows],
            (line["ring_force"] / line["ring_force"][-1])[rows],
        )

    def share(self, times: Array) -> Array:
        """Displacement difference ``u_max - d0`` over that of the steady state."""
        difference = (
            values(self._samplers[0].history(self._history(times)))["displacement_max"] - D0
        )
        return (difference / difference[-1])[: len(times)]

    def time_of(self, share: float) -> float:
        """Non-dimensional time at which the displacement difference has reached a fraction of its
        steady value.
        """
        # the slowest mode alone would need this long; the others only make it faster
        latest = self.wear.relaxation_times[0] * (5 - 2 * np.log(1 - share))
        return float(
            brentq(
                lambda time: self.share(np.array([time]))[0] - share,
                0.0,
                latest,
                xtol=1e-14,
                rtol=1e-12,
            )
        )


@dataclass(frozen=True, eq=False)
class FiveRings:
    """The paper's example by every method.

    Parameters
    ----------
    reference, coarser : by MDR, which gives the times; and on a coarser space
    stationary, times : t_stat, and times of the states of Fig. 4
    states, curves : by method, of Figs. 4 and 5
    limiting : profile and pressure of the steady state by direct integration
    """

    reference: Evolution
    coarser: Evolution
    stationary: float
    times: Array
    states: dict[str, States]
    curves: dict[str, States]
    limiting: dict[str, Array]


def five_rings(problem: Problem) -> FiveRings:
    """The paper's example on the half-space of a problem."""
    rings = Rings.alternating(COUNT, 1.0, WEAR_RATIO)
    problem = replace(
        problem, rings=rings, times=np.empty(0), output_radii=None, rtol=min(RTOL, problem.rtol)
    )
    ready = {
        name: compliance_method(name).discretised(problem, Stages(name), name == "mdr")
        for name in METHODS
    }
    evolutions = {name: Evolution(problem, one.compliance) for name, one in ready.items()}
    reference = evolutions["mdr"]
    stationary = reference.time_of(STATIONARY)
    times = np.array([0.0, *(reference.time_of(share) for share in SHARES[1:-1]), np.inf])
    steady = method("direct").solve(problem, Stages("direct")).results
    return FiveRings(
        reference,
        Evolution(problem, ready["mdr"].compliance.coarser()),
        stationary,
        times,
        {name: evolution.states(times) for name, evolution in evolutions.items()},
        {name: evolution.states(stationary * CURVE) for name, evolution in evolutions.items()},
        {
            "profile": array(steady, "steady_profile") / D0,
            "pressure": array(steady, "steady_pressure") / P0,
        },
    )


def relaxation_times(problem: Problem, counts: tuple[int, ...]) -> dict[int, Array]:
    """(M, modes) times in units of ``a / (E* k_slow v0)``, slowest first, over `WEAR_RATIOS` for
    each number of rings.

    By MDR: one compliance for each number of rings, one eigenproblem for each wear ratio.
    """
    times = {}
    for count in progress(counts, "rings"):
        punch = replace(
            problem,
            rings=Rings.alternating(count, 1.0, WEAR_RATIO),
            times=np.empty(0),
            rtol=SPECTRUM_RTOL,
        )
        compliance = (
            compliance_method("mdr").discretised(punch, Stages("mdr"), coarser=False).compliance
        )
        by_ratio = (Rings.alternating(count, 1.0, ratio).wear_coefficients for ratio in WEAR_RATIOS)
        wears = [
            RunningIn(compliance, coefficients / coefficients.min()) for coefficients in by_ratio
        ]
        times[count] = np.array([wear.relaxation_times[:MODES] for wear in wears])
    return times


def many_ring_times(homogeneous: float) -> Array:
    """(M,) slowest relaxation time in the limit of many rings of equal width, from that of the
    homogeneous punch.
    """
    return homogeneous * (np.minimum(1, WEAR_RATIOS) + np.minimum(1, 1 / WEAR_RATIOS)) / 2
