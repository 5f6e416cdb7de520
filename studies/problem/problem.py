"""A scene in natural units: punch radius, plane strain modulus, force and ``a / (E* k_max v0)`` are 1.

Everything is computed in these and scaled at the door only; the size of each unit in the scene's own is told here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from ringwear.meshes.radial import Array, alternating_edges

if TYPE_CHECKING:
    from ringwear.studies.problem.scene import Scene


@dataclass(frozen=True)
class NaturalScene:
    """A scene in natural units, and the size of each unit in the scene's own."""

    scene: Scene

    @cached_property
    def edges(self) -> Array:
        """(N+1,) ring edges from 0 to 1."""
        punch = self.scene.punch
        if punch.ring_edges is None:
            return alternating_edges(punch.rings or 1, punch.width_ratio)
        edges = np.array([0.0, *punch.ring_edges]) / punch.radius
        edges[-1] = 1.0
        return edges

    @cached_property
    def _coefficients(self) -> Array:
        count = len(self.edges) - 1
        given = np.array(self.scene.punch.wear_coefficients)
        return given if len(given) == count else given[np.arange(count) % 2]

    @cached_property
    def wear(self) -> Array:
        """(N,) wear coefficient of each ring over the greatest."""
        return self._coefficients / self._coefficients.max()

    @cached_property
    def phases(self) -> tuple[Array, Array]:
        """Ring edges and wear coefficients with neighbouring rings of equal wear made one: what has to be modelled."""
        kept = np.flatnonzero(np.diff(self.wear) != 0) + 1
        return self.edges[[0, *kept, -1]], self.wear[[0, *kept]]

    @cached_property
    def times(self) -> Array:
        return np.array(self.scene.wear.times) / self.time

    @property
    def earliest(self) -> float:
        """The first time after the start; 0 without any."""
        return float(min(self.times[self.times > 0], default=0.0))

    @cached_property
    def step(self) -> float | None:
        return None if self.scene.wear.step is None else self.scene.wear.step / self.time

    @cached_property
    def radii(self) -> Array:
        """Radii of the output: the user's, or a grid that crowds at every ring edge without touching it."""
        if self.scene.output.radii is not None:
            return np.array(self.scene.output.radii) / self.scene.punch.radius
        count = max(8, 320 // (len(self.edges) - 1))
        within = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
        inner, outer = self.edges[:-1, None], self.edges[1:, None]
        return np.concatenate([[0.0], (inner + (outer - inner) * within).ravel()])

    @property
    def length(self) -> float:
        return self.scene.punch.radius

    @property
    def force(self) -> float:
        load = self.scene.load_
        return load.normal_force or (load.mean_pressure or 0.0) * np.pi * self.length**2

    @property
    def modulus(self) -> float:
        solid = self.scene.half_space
        return solid.plane_strain_modulus or (solid.youngs_modulus or 0.0) / (1 - solid.poisson_ratio**2)

    @property
    def pressure(self) -> float:
        """Unit of pressure, F / a^2."""
        return self.force / self.length / self.length

    @property
    def displacement(self) -> float:
        """Unit of displacement and of worn height, F / (a E*)."""
        return self.force / self.length / self.modulus

    @property
    def time(self) -> float:
        """Unit of time, a / (E* k_max v0)."""
        return self.length / self.modulus / float(self._coefficients.max()) / self.scene.load_.sliding_speed

    @property
    def wear_rate(self) -> float:
        """Unit of the wear rate df/dt."""
        return self.displacement / self.time
