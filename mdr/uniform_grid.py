"""The algorithm of the paper, as a baseline: MDR on a uniform grid, with explicit time steps.

It implements Eqs. 3, 7 and 14 to 17. Springs and profile points coincide at ``i/n`` (Fig. 2). The
pressure at the rim is infinite at the start, so it is evaluated half a cell inside the rim. The
method is of first order in the grid and in the step, and stable only for small steps.
Non-dimensional, force 1.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..meshes.errors import SceneError
from ..meshes.radial import Array, ring_of
from .transforms import pressure_transform, profile_transform


@dataclass(frozen=True, eq=False)
class UniformGrid:
    """The uniform grid of `count` springs for rings with given edges and wear coefficients."""

    ring_edges: Array
    wear_coefficients: Array
    count: int

    @cached_property
    def radii(self) -> Array:
        """(count+1,) positions of the springs and radii of the profile."""
        return np.arange(self.count + 1) / self.count

    @cached_property
    def coefficients(self) -> Array:
        """(count+1,) wear coefficient at each radius."""
        return self.wear_coefficients[ring_of(self.ring_edges, self.radii)]

    @cached_property
    def _transforms(self) -> tuple[Array, Array, Array]:
        """Eq. 3 at the springs, the trapezoidal rule of Eq. 16, and Eq. 7."""
        profile = np.zeros((self.count + 1, self.count + 1))
        profile[0, 0] = 1.0
        profile[1:] = profile_transform(self.radii, self.radii[1:])
        rule = np.full(self.count + 1, 1 / self.count)
        rule[[0, -1]] /= 2
        inside = np.append(self.radii[1:-1], 1 - 0.5 / self.count)
        pressure = pressure_transform(self.radii, inside)
        return profile, rule, np.concatenate([pressure[:1], pressure])

    def contact(self, profile: Array) -> tuple[Array, float]:
        """Return pressure (count+1,) and indentation of a worn profile: Eqs. 3, 17, 6 and 7."""
        to_springs, rule, to_pressure = self._transforms
        springs = to_springs @ profile
        indentation = 0.5 + float(rule @ springs)
        return to_pressure @ (indentation - springs), indentation

    def stability_limit(self) -> float:
        """Return the greatest stable step.

        A pattern of wavelength 2/n has the relaxation time ``2 / (pi n k)``, and Euler's method is
        stable up to twice that.
        """
        return 4 / (np.pi * self.count * float(self.coefficients.max()))

    def march(self, times: Array, step: float) -> tuple[Array, Array, Array]:
        """March by explicit steps, and return pressures, profiles and indentations at `times`.

        The pressures and profiles are (T, count+1), the indentations (T,). No step is longer than
        `step`.

        Raises
        ------
        SceneError
            if the solution diverges because the step exceeds the stability limit
        """
        profile, current_time = np.zeros(self.count + 1), 0.0
        pressure, indentation = self.contact(profile)
        states = []
        for time in times:
            count = int(np.ceil((time - current_time) / step * (1 - 1e-12)))
            with np.errstate(over="ignore", invalid="ignore"):
                for _ in range(count):
                    profile = profile + (time - current_time) / count * self.coefficients * pressure
                    pressure, indentation = self.contact(profile)
            if not np.abs(pressure).max() < 1e6:
                raise SceneError(
                    "the solution on the uniform grid diverged: its step is "
                    f"{step / self.stability_limit():.3g} times the "
                    "stability limit; give a smaller wear.step, or leave it out for half the limit"
                )
            current_time = time
            states.append((pressure, profile, indentation))
        pressures, profiles, indentations = map(np.array, zip(*states, strict=True))
        return pressures, profiles, indentations
