"""The running-in of the paper's five rings by every method: Figs. 4 and 5.

Heights are counted from the least worn point, ``f - f_min = u_max - u``, which is Eq. 27 at every
time; so is the one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``.
Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``,
lengths by `a`.
"""

import numpy as np
import xarray
from scipy.interpolate import CubicSpline

from ...mdr.flat_punch import D0
from ...mdr.transforms import line_density
from ...meshes.radial import Array
from ..outcome.outcome import Outcome
from ..outcome.run import run
from ..sampling.sampler import AVERAGES
from ..scene.scene import Scene
from .theory import PERCENTS, STATIONARY

# methods that know histories
SOLVERS = ("mdr", "fem", "bem")


class FiveRings:
    """The paper's example by every method.

    Parameters
    ----------
    scene : of which Poisson's ratio and the accuracy are taken

    Attributes
    ----------
    scene : what is run, with ``d0 = 1`` and ``p0 = 1/pi``
    stationary : t_stat
    states : of Fig. 4, over (solver, time, radius), times in t_stat
    history : of Fig. 5, over (average, solver, time): RMS gradients over those of the steady state,
        also at the times of the states
    """

    def __init__(self, scene: Scene) -> None:
        rtol = scene.accuracy.rtol
        self.scene = Scene.load("five_rings").changed(
            half_space__poisson_ratio=scene.half_space.poisson_ratio,
            accuracy__rtol=min(3e-6, rtol),
        )
        ways = np.array([*PERCENTS[1:-1], 100 * STATIONARY]) / 100
        *between, self.stationary = times_of(self.scene, ways).tolist()
        # at last the steady state is reached to roundoff
        states = self.scene.changed(wear__times=[0.0, *between, 20.0])
        self.states = normalised(run(states, [*SOLVERS, "direct"]), self.stationary)
        # dense at the start, where the rim wears
        dense = 1.25 * self.stationary * np.linspace(0, 1, 161) ** 2
        gradients = []
        for average in AVERAGES:
            watched = self.scene.changed(
                accuracy__rtol=rtol,
                wear__times=np.union1d(dense, between).tolist(),
                output__gradient_average=average,
                output__quantities=["rms_slope", "steady_rms_slope"],
            )
            slopes = run(watched, SOLVERS).dataset
            gradients.append(slopes.rms_slope / slopes.steady_rms_slope)
        history = xarray.concat(gradients, xarray.Variable("average", list(AVERAGES)))
        self.history = history.assign_coords(time=history.time / self.stationary)


def times_of(scene: Scene, ways: Array) -> Array:
    """Return the times at which the greatest displacement has made parts of its way, by MDR."""
    times = np.geomspace(1e-3, 5, 500)
    # states are less accurate than the times that they are told by
    exact = scene.changed(
        accuracy__rtol=1e-8,
        wear__times=times.tolist(),
        output__quantities=["displacement_max", "steady_displacement_max"],
    )
    way = way_of(run(exact, ["mdr"]).dataset)[0]
    # what is left falls as an exponential in the end
    return CubicSpline(-np.log1p(-way), times)(-np.log1p(-ways))


def way_of(worn: xarray.Dataset) -> xarray.DataArray:
    """Return the part of its way (solver, time) that the greatest displacement has made."""
    return (worn.displacement_max - 1) / (worn.steady_displacement_max - 1)


def normalised(result: Outcome, stationary: float) -> xarray.Dataset:
    """Return the fields of a run over (solver, time, radius), with times in t_stat (`stationary`).

    The variables `limiting_...` are those of the steady state by direct integration.
    """
    problem, worn = result.scene.problem, result.dataset
    exact, worn = worn.sel(solver="direct", drop=True), worn.sel(solver=list(SOLVERS))
    line_densities = []
    for name in SOLVERS:
        wear = result.solutions[name].wear
        assert wear is not None
        positions = line_density(wear.compliance.space, np.maximum(problem.radii, 1e-6))
        line_densities.append(wear.modal(problem.times).pressure @ positions.T / D0)
    greatest = worn.displacement_max
    states = xarray.Dataset(
        {
            "f_over_d0": greatest - worn.displacement,
            "g_over_d0": greatest - worn.pressure.copy(data=np.array(line_densities)),
            "p_over_p0": worn.pressure * np.pi,
            "least_wear_over_d0": worn.indentation - greatest,
            "way": way_of(worn),
            "limiting_f_over_d0": exact.steady_profile,
            "limiting_p_over_p0": exact.steady_pressure * np.pi,
        }
    )
    return states.assign_coords(time=states.time / stationary)
