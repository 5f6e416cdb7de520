"""What the punch looks like before it wears.

Heights over the radius, recesses by ring, or sums of them. Non-dimensional.

A height is material that is missing: where it is zero the face plane is, whose indentation is d.
Heights may be any function of the radius; steps at ring edges are the recesses. Lengths are in
punch radii, heights in ``F / (a E*)``.

A face may stand off its plane everywhere. That distance is taken off before anything is computed,
and added to what is reported, so that no step, tolerance or norm depends on it.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...meshes.radial import Array, Indices, ring_of
from .fields import Height


@dataclass(frozen=True, eq=False)
class InitialProfile:
    """Heights of the punch face before wear, above where it is nearest to the half-space.

    Parameters
    ----------
    ring_edges : (N+1,) of the punch
    recess : (N,) height of each ring
    heights : functions of the radius that are added to it
    kinks : radii at which these are not smooth
    standoff : distance of the nearest point from the face plane, which the heights do not contain
    """

    ring_edges: Array
    recess: Array
    heights: tuple[Height, ...] = ()
    kinks: tuple[float, ...] = ()
    standoff: float = 0.0

    def __call__(self, radii: Array) -> Array:
        """Heights at radii; an edge belongs to the ring outside it."""
        return self.in_ring(radii, ring_of(self.ring_edges, radii))

    def in_ring(self, radii: Array, ring: Indices) -> Array:
        """Heights at radii of given rings: at their edges, too."""
        total = np.asarray(self.recess[ring], dtype=float)
        for height in self.heights:
            total = total + height(radii)
        return np.asarray(np.broadcast_to(total, np.shape(radii)), dtype=float)

    def slope(self, radii: Array) -> Array:
        """Slope within rings, by central differences: steps at ring edges are no slope."""
        ring, step = ring_of(self.ring_edges, radii), 1e-5
        low = np.maximum(radii - step, self.ring_edges[ring])
        high = np.minimum(radii + step, self.ring_edges[ring + 1])
        rise = self.in_ring(high, ring) - self.in_ring(low, ring)
        return np.divide(rise, high - low, out=np.zeros_like(rise), where=high > low)

    @property
    def flat(self) -> bool:
        """Whether it is the face plane itself."""
        return not (self.heights or self.recess.any() or self.standoff)

    @property
    def steps(self) -> Array:
        """(N-1,) step of the height at each ring edge between centre and rim, outwards."""
        return np.diff(self.recess)

    def sampled(self, *more: float) -> tuple[Array, Array]:
        """Radii, many in every ring, its edges and kinks and `more`, and heights there."""
        within, kinks = np.linspace(0.0, 1.0, 501), np.array([*self.kinks, *more])
        parts = [
            np.union1d(a + (b - a) * within, kinks[(kinks > a) & (kinks < b)])
            for a, b in pairwise(self.ring_edges)
        ]
        heights = [self.in_ring(part, np.full(len(part), ring)) for ring, part in enumerate(parts)]
        return np.concatenate(parts), np.concatenate(heights)


FLAT = InitialProfile(np.array([0.0, 1.0]), np.zeros(1))
