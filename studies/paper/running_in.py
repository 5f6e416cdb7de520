"""Compute the running-in of the paper's five rings by every method, for Figs. 4 and 5.

Heights are measured from the least worn point: ``f - f_min = u_max - u``, which is Eq. 27 at every
time. The one-dimensional profile of Eq. 3, which in contact is ``g(x) = d - q(x)/E*``, is measured
from the same point. The normalisation is that of the paper: heights by ``d0 = F/(2 a E*)``,
pressures by ``p0 = F/(2 pi a^2)``, lengths by `a`.
"""

import numpy as np
import xarray
from scipy.interpolate import CubicSpline

from ...mdr import D0, line_density
from ...meshes import Array
from ..crosscheck import AVERAGES, Result, Scene, run
from .theory import STATE_PERCENTAGES, STATIONARY_FRACTION

# methods that compute histories
SOLVERS = ("mdr", "fem", "bem")


class FiveRings:
    """The paper's example of five rings, solved by every method.

    Parameters
    ----------
    scene : scene with the Poisson's ratio and the accuracy to use

    Attributes
    ----------
    scene : scene that is solved, with ``d0 = 1`` and ``p0 = 1/pi``
    stationary : time t_stat at which the paper's run ends, in the unit of the scene
    states : fields of Fig. 4 over (solver, time, radius), with times in t_stat
    history : RMS gradients of Fig. 5 over (average, solver, time), relative to the steady state;
        their times include those of the states
    """

    def __init__(self, scene: Scene) -> None:
        rtol = scene.accuracy.rtol
        self.scene = Scene.load("five_rings").changed(
            half_space__poisson_ratio=scene.half_space.poisson_ratio,
            accuracy__rtol=min(3e-6, rtol),
        )
        fractions = np.array([*STATE_PERCENTAGES[1:-1], 100 * STATIONARY_FRACTION]) / 100
        *state_times, self.stationary = times_of(self.scene, fractions).tolist()
        # at the last time, the steady state is reached to roundoff
        states = self.scene.changed(wear__times=[0.0, *state_times, 20.0])
        self.states = normalised(run(states, [*SOLVERS, "direct"]), self.stationary)
        # times are dense at the start, when the rim wears
        times = 1.25 * self.stationary * np.linspace(0, 1, 161) ** 2
        gradients = []
        for average in AVERAGES:
            with_gradient = self.scene.changed(
                accuracy__rtol=rtol,
                wear__times=np.union1d(times, state_times).tolist(),
                output__gradient_average=average,
                output__quantities=["rms_slope", "steady_rms_slope"],
            )
            slopes = run(with_gradient, SOLVERS).dataset
            gradients.append(slopes.rms_slope / slopes.steady_rms_slope)
        history = xarray.concat(gradients, xarray.Variable("average", list(AVERAGES)))
        self.history = history.assign_coords(time=history.time / self.stationary)


def times_of(scene: Scene, fractions: Array) -> Array:
    """Return the times at which the greatest displacement has completed fractions of its change.

    They are computed by MDR.
    """
    times = np.geomspace(1e-3, 5, 500)
    # times are computed more accurately than the states at these times
    accurate_scene = scene.changed(
        accuracy__rtol=1e-8,
        wear__times=times.tolist(),
        output__quantities=["displacement_max", "steady_displacement_max"],
    )
    completed = completed_fraction(run(accurate_scene, ["mdr"]).dataset)[0]
    # the remaining fraction decays exponentially at late times: interpolate in its logarithm
    return CubicSpline(-np.log1p(-completed), times)(-np.log1p(-fractions))


def completed_fraction(worn: xarray.Dataset) -> xarray.DataArray:
    """Return the completed fraction (solver, time) of the change of the greatest displacement."""
    return (worn.displacement_max - 1) / (worn.steady_displacement_max - 1)


def normalised(result: Result, stationary: float) -> xarray.Dataset:
    """Return the normalised fields of a run over (solver, time, radius), with times in t_stat.

    The variables `limiting_...` are the steady state by direct integration.

    Parameters
    ----------
    result : result of a run with `SOLVERS` and `direct`
    stationary : time t_stat in the unit of the scene
    """
    problem, dataset = result.scene.problem, result.dataset
    direct_dataset = dataset.sel(solver="direct", drop=True)
    dataset = dataset.sel(solver=list(SOLVERS))
    line_densities = []
    for name in SOLVERS:
        wear = result.solutions[name].wear
        assert wear is not None
        transform = line_density(wear.compliance.space, np.maximum(problem.radii, 1e-6))
        line_densities.append(wear.modal(problem.times).pressure @ transform.T / D0)
    displacement_max = dataset.displacement_max
    states = xarray.Dataset(
        {
            "f_over_d0": displacement_max - dataset.displacement,
            "g_over_d0": displacement_max - dataset.pressure.copy(data=np.array(line_densities)),
            "p_over_p0": dataset.pressure * np.pi,
            "least_wear_over_d0": dataset.indentation - displacement_max,
            "way": completed_fraction(dataset),
            "limiting_f_over_d0": direct_dataset.steady_profile,
            "limiting_p_over_p0": direct_dataset.steady_pressure * np.pi,
        }
    )
    return states.assign_coords(time=states.time / stationary)
