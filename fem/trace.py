"""Displacements on the contact line, as piecewise polynomials, whatever functions the elements have there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from meshes.pressure_space import PressureSpace, shape_slopes, shapes
from meshes.radial import Array, Indices


@dataclass(frozen=True, eq=False)
class Trace:
    """The displacement functions on the contact facets.

    Parameters
    ----------
    breakpoints : (n+1,) ends of the facets, 0 to 1
    numbers : (n, w) number along the radius of each local function; `size` where a facet has none
    modes : (w, w) local functions as combinations of hats and bubbles: columns of coefficients
    samples : (w,) local coordinates, from -1 to 1, of the points at which displacements are told
    size : number of functions
    """

    breakpoints: Array
    numbers: Indices
    modes: Array
    samples: Array
    size: int

    @classmethod
    def nodal(cls, breakpoints: Array, degree: int) -> Trace:
        """Lagrange functions of equispaced nodes."""
        samples = np.linspace(-1, 1, degree + 1)
        numbers = degree * np.arange(len(breakpoints) - 1)[:, None] + np.arange(degree + 1)
        modes = np.asarray(np.linalg.inv(shapes(samples, degree)), dtype=np.float64)
        return cls(breakpoints, numbers, modes, samples, int(numbers.max()) + 1)

    @classmethod
    def hierarchical(cls, breakpoints: Array, degrees: Indices) -> Trace:
        """Hats and bubbles, of a degree (n,) for each facet."""
        space = PressureSpace(breakpoints, degrees, breakpoints[[0, -1]])
        samples = -np.cos(np.pi * np.arange(space.top + 1) / space.top)
        return cls(breakpoints, space.dofs, np.eye(space.top + 1), samples, space.size)

    @property
    def _top(self) -> int:
        return len(self.samples) - 1

    def coupling(self, space: PressureSpace) -> Array:
        """(size, space.size) ``int v_i phi_j dA`` with the pressures on the same breakpoints."""
        local, weight = leggauss(self._top + space.top)
        half = np.diff(self.breakpoints)[:, None] / 2
        area = 2 * np.pi * (self.breakpoints[:-1, None] + half * (1 + local)) * half * weight
        displacements = shapes(local, self._top) @ self.modes
        blocks = np.einsum("eq,qi,qj->eij", area, displacements, shapes(local, space.top), optimize=True)
        out = np.zeros((self.size + 1, space.size + 1))
        np.add.at(out, (self.numbers[:, :, None], space.dofs[:, None, :]), blocks)
        return out[:-1, :-1]

    def sampled(self, displacement: Array) -> tuple[Array, Array]:
        """Radii of the samples of all facets, shared ends once, and displacements there, by those (size,) of functions."""
        half = np.diff(self.breakpoints)[:, None] / 2
        radii = self.breakpoints[:-1, None] + half * (1 + self.samples)
        local = np.append(displacement, 0.0)[self.numbers]
        values = local @ (shapes(self.samples, self._top) @ self.modes).T
        return np.append(radii[:, :-1], self.breakpoints[-1]), np.append(values[:, :-1], values[-1, -1])

    def slope(self, sampled: Array) -> tuple[Array, Array, Array]:
        """Radii, weights of dr and slopes (n, q) of a displacement given at the samples."""
        local, weight = leggauss(self._top + 1)
        half = np.diff(self.breakpoints)[:, None] / 2
        rows = self._top * np.arange(len(half))[:, None] + np.arange(self._top + 1)
        modes = np.linalg.inv(shapes(self.samples, self._top))
        slopes = sampled[rows] @ (shape_slopes(local, self._top) @ modes).T / half
        return self.breakpoints[:-1, None] + half * (1 + local), half * weight, slopes
