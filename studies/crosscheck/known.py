"""What is known of a scene without any method.

Its natural units, its steady state, energies. In closed form.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..problem.problem import Problem, Units
from ..problem.scene import Scene


def natural_units(scene: Scene) -> Units:
    """Return the sizes of the natural units by the numbers of the scene.

    Not those that results are scaled by: what was scaled wrongly shows.
    """
    load, length = scene.load_, scene.punch.radius
    if load.indentation is not None:
        return scene.problem.units
    force = load.normal_force or (load.mean_pressure or 0.0) * np.pi * length**2
    solid = scene.half_space
    modulus = solid.plane_strain_modulus
    modulus = modulus or (solid.youngs_modulus or 0.0) / (1 - solid.poisson_ratio**2)
    rings = scene.punch.rings or len(scene.punch.ring_edges or [])
    greatest = max(scene.punch.coefficients[:rings])
    time = length / (modulus * greatest * load.sliding_speed)
    return Units(length, modulus, force, time, greatest)


@dataclass(frozen=True, eq=False)
class KnownSteadyState:
    """The steady state of Eqs. 21 to 27; fields are over the face of the problem."""

    problem: Problem

    @cached_property
    def merged_pressures(self) -> Array:
        """Pressure of each ring that wears otherwise than its neighbours."""
        return direct.steady_pressures(*self.problem.merged)

    @cached_property
    def ring_pressures(self) -> Array:
        """(N,) pressure of each ring of the scene."""
        return direct.steady_pressures(*self.problem.rings)

    @property
    def wear_rate(self) -> float:
        return float(self.problem.wear_coefficients[0] * self.ring_pressures[0])

    @cached_property
    def greatest(self) -> float:
        """Greatest displacement."""
        return direct.greatest_displacement(self.problem.merged.ring_edges, self.merged_pressures)

    @cached_property
    def slope(self) -> float:
        """Root mean square slope."""
        rings = self.problem.merged
        return direct.rms_slope(
            rings.ring_edges, self.merged_pressures, self.problem.gradient_average
        )

    @cached_property
    def pressure(self) -> Array:
        """(R,) over the face."""
        return self.ring_pressures[ring_of(self.problem.ring_edges, self.problem.face.radii)]

    @cached_property
    def displacement(self) -> Array:
        """(R,) over the face."""
        edges = self.problem.merged.ring_edges
        return direct.displacement(edges, self.merged_pressures, self.problem.face.radii)


@lru_cache(maxsize=4)  # methods of a scene share it
def steady_state(problem: Problem) -> KnownSteadyState:
    """Return the steady state of a problem in closed form."""
    return KnownSteadyState(problem)


def energy_of_rings(ring_edges: Array, pressures: Array) -> float:
    """Return ``int u p dA`` of a constant pressure on each ring, by the closed form of discs."""
    steps = direct.pressure_steps(pressures)
    return float(steps @ direct.disc_energies(ring_edges[1:]) @ steps)
