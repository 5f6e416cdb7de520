"""Approximate wear of a flat punch in plane strain: what a program may have modelled by mistake.

Pressures are constant on about 40 strips on both sides of the middle plane, displacements are taken
at the middles of the strips, and the history is exact in time. Non-dimensional, in the units of the
axisymmetric problem; the line force is F / 2a.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eig

from ...meshes import Array
from ..crosscheck import Problem

# least number of strips on a ring, and about the least number on all rings together
MIN_RING_STRIPS, MIN_STRIPS = 5, 40


@dataclass(frozen=True, eq=False)
class Strips:
    """A flat punch on a half-space in plane strain, under a constant force.

    Parameters
    ----------
    edges : (N+1,) edges of the strips, from 0 to 1
    wear : (N,) wear coefficients
    """

    edges: Array
    wear: Array

    @classmethod
    def of(cls, problem: Problem) -> "Strips":
        """Return the strips of a problem, narrow beside every ring edge."""
        rings = problem.graded or problem.rings
        inner, outer = rings.ring_edges[:-1, None], rings.ring_edges[1:, None]
        count = max(MIN_RING_STRIPS, MIN_STRIPS // len(inner))
        fractions = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
        edges = np.append((inner + (outer - inner) * fractions).ravel(), 1.0)
        return cls(edges, rings.at((edges[1:] + edges[:-1]) / 2))

    @cached_property
    def _weights(self) -> Array:
        """(N,) forces of unit pressures: the line force 1/2 on both sides is the force 1."""
        return 4 * np.diff(self.edges)

    @cached_property
    def _stiffness(self) -> Array:
        """(N, N) pressures by unit displacements of the middles.

        A line force P causes the displacement ``-2 P / (pi E*) ln|x|``, plus a constant that
        depends on the depth of the body and is left out (Johnson, Contact Mechanics, ch. 2).
        """
        middles = (self.edges[1:] + self.edges[:-1])[:, None] / 2

        def integral(distance: Array) -> Array:
            return distance * (np.log(np.abs(distance)) - 1)

        both_sides = integral(middles - self.edges) - integral(middles + self.edges)
        return np.linalg.inv(np.diff(2 / np.pi * both_sides, axis=1))

    @cached_property
    def _modes(self) -> tuple[Array, Array, Array, Array]:
        """Rates of decay (N,), shapes (N, N) of pressures, amplitudes (N,), steady pressures (N,).

        They solve ``p' = -B (k p - d' 1)`` with the stiffness B, at a constant force.
        """
        rigid = self._stiffness.sum(axis=1)
        rigid_force = self._weights @ rigid
        steady = 1 / self.wear / (self._weights @ (1 / self.wear))
        decay = self._stiffness * self.wear
        decay = decay - np.outer(rigid, self._weights @ decay) / rigid_force
        rates, shapes = eig(decay)
        amplitudes = np.linalg.solve(shapes, (rigid / rigid_force - steady).astype(complex))
        return np.maximum(rates.real, 0.0), shapes, amplitudes, steady

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ()
    ) -> dict[str, Array]:
        """Return quantities by name, as `modes.FlatHistory.sample` does; steps have no effect."""
        rates, shapes, amplitudes, steady = self._modes
        exponent = np.outer(times, rates)
        decayed = np.exp(-exponent) * amplitudes
        # integrals of the decaying modes over time
        integral = np.where(exponent > 1e-9, -np.expm1(-exponent) / np.maximum(rates, 1e-300), 0.0)
        integral = np.where(exponent > 1e-9, integral, times[:, None]) * amplitudes
        pressure = steady + (decayed @ shapes.T).real
        worn = self.wear * (np.outer(times, steady) + (integral @ shapes.T).real)
        rigid = self._stiffness.sum(axis=1)
        depth = (1 + worn @ (self._weights @ self._stiffness)) / (self._weights @ rigid)
        at = np.clip(np.searchsorted(self.edges, radii) - 1, 0, len(self.wear) - 1)
        return {
            "pressure": pressure[:, at],
            "profile": worn[:, at],
            "displacement": depth[:, None] - worn[:, at],
            "indentation": depth,
            "normal_force": np.ones(len(depth)),
        }
