"""What is known of a scene without any method: its steady state, energies."""

from functools import lru_cache
from typing import NamedTuple

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..problem.problem import Problem


class SteadyState(NamedTuple):
    """The steady state of Eqs. 21 to 27.

    Parameters
    ----------
    ring_pressures : (N,) of each ring of the scene
    merged_pressures : (M,) of each ring that wears otherwise than its neighbours
    wear_rate, greatest, slope : greatest displacement and root mean square slope
    pressure, displacement : (R,) over the face of the problem
    """

    ring_pressures: Array
    merged_pressures: Array
    wear_rate: float
    greatest: float
    slope: float
    pressure: Array
    displacement: Array


@lru_cache(maxsize=4)  # methods of a scene share it
def steady_state(problem: Problem) -> SteadyState:
    """Return the steady state of a problem in closed form."""
    edges, radii = problem.merged.ring_edges, problem.face.radii
    rings, merged = (direct.steady_pressures(*each) for each in (problem.rings, problem.merged))
    return SteadyState(
        rings,
        merged,
        float(problem.wear_coefficients[0] * rings[0]),
        direct.greatest_displacement(edges, merged),
        direct.rms_slope(edges, merged, problem.gradient_average),
        rings[ring_of(problem.ring_edges, radii)],
        direct.displacement(edges, merged, radii),
    )


def energy_of_rings(ring_edges: Array, pressures: Array) -> float:
    """Return ``int u p dA`` of a constant pressure on each ring, by the closed form of discs."""
    steps = direct.pressure_steps(pressures)
    return float(steps @ direct.disc_energies(ring_edges[1:]) @ steps)
