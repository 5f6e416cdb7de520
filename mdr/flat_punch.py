"""The flat punch of the force 1 in closed form, full (Eqs. 10 and 11) or hollow."""

from typing import Protocol

import numpy as np

from ..meshes.radial import Array
from .annulus import flat_annulus

# Eqs. 10 and 11, non-dimensional: d0 = F / (2 a E*) and p0 = F / (2 pi a^2)
D0, P0 = 0.5, 1 / (2 * np.pi)


class FlatPunch(Protocol):
    """A flat punch under the force 1."""

    @property
    def indentation(self) -> float:
        """The indentation."""

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressure at radii (R,) of the face."""

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force (N,) on each ring between edges (N+1,)."""

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring."""


class FlatDisc:
    """The full flat punch, ``p = p0 / sqrt(1 - r^2/a^2)``."""

    indentation = D0

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressure at radii (R,) of the face; infinite at the rim."""
        with np.errstate(divide="ignore"):
            return np.asarray(P0 / _root(radii))

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force (N,) on each ring between edges (N+1,)."""
        return -np.diff(_root(ring_edges))

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring: those at its edges."""
        at_edges = self.pressure_at(ring_edges)
        return at_edges[:-1], at_edges[1:]


def flat_punch(inner_radius: float) -> FlatPunch:
    """Return the flat punch with a hole of an inner radius, or without one where that is 0."""
    return flat_annulus(inner_radius) if inner_radius else FlatDisc()


def _root(radii: Array) -> Array:
    """Return ``sqrt(1 - r^2)`` without cancellation."""
    return np.asarray(np.sqrt((1 - radii) * (1 + radii)))
