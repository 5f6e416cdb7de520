"""Approximate wear of a flat punch in plane strain: what a program may have modelled by mistake.

Pressures are constant on about 40 strips on both sides of the middle plane, displacements are taken
at the middles of the strips, and the history is exact in time. Non-dimensional, in the units of the
axisymmetric problem; the line force is F / 2a.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...meshes import Array
from ..crosscheck import Problem

# least number of strips on a ring, and about the least number on all rings together
MIN_RING_STRIPS, MIN_STRIPS = 5, 40
# rates of decay below this part of the largest one are zero: the even wear
ZERO_RATE = 1e-7


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

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ()
    ) -> dict[str, Array]:
        """Return quantities by name, as `modes.FlatHistory.sample` does; steps have no effect."""
        forces = self._weights @ self._stiffness
        worn = worn_at_nodes(self._stiffness, forces, self.wear, times)
        at = np.clip(np.searchsorted(self.edges, radii) - 1, 0, len(self.wear) - 1)
        return {
            "pressure": worn.pressures[:, at],
            "profile": worn.profiles[:, at],
            "displacement": worn.indentations[:, None] - worn.profiles[:, at],
            "indentation": worn.indentations,
            "normal_force": np.ones(len(times)),
        }


class Worn(NamedTuple):
    """Contain the wear of a flat face at T times: arrays (T, n), and the indentations (T,)."""

    profiles: Array
    pressures: Array
    indentations: Array


def worn_at_nodes(
    stiffness: Array, forces: Array, wear: Array, times: Array, by_force: bool = True
) -> Worn:
    """Return the exact wear ``f' = k p`` of a flat face in full contact, at n nodes or strips.

    Parameters
    ----------
    stiffness : (n, n) pressures for displacements of the nodes
    forces : (n,) total force for a displacement of each node
    wear : (n,) wear coefficients k
    times : (T,)
    by_force : whether the force is 1 at all times, and not the indentation
    """
    relief, start = stiffness, stiffness.sum(axis=1)
    if by_force:
        start = start / forces.sum()
        relief = stiffness - np.outer(start, forces)
    # p = start - relief f
    rates, shapes = np.linalg.eig(wear[:, None] * relief)
    parts = shapes * np.linalg.solve(shapes, (wear * start).astype(complex))
    decays, elapsed = np.abs(rates) > ZERO_RATE * np.abs(rates).max(), times[:, None]
    rest = np.where(decays, rates, 1.0)
    grown = np.where(decays, -np.expm1(-rest * elapsed) / rest, elapsed)
    profiles = np.asarray((grown @ parts.T).real)
    depths = (1 + profiles @ forces) / forces.sum() if by_force else np.ones(len(times))
    return Worn(profiles, start - profiles @ relief.T, depths)
