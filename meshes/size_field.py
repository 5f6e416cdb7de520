"""Element sizes of the triangulated half-space, graded to the rim and the ring edges. Lengths in punch radii.

The size is ``min(rim_size + growth * d_rim, ring_size + growth * d_edge, far_size * R)`` with the distances to the rim and
to the nearest other ring edge (or the centre), and the truncation radius R: well-shaped elements round every singular
point, in numbers that grow only with the logarithm of the smallest size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from ringwear.meshes.radial import Array


@dataclass(frozen=True)
class SizeField:
    """The wanted element size as a function of position.

    Parameters
    ----------
    edges : ring edges, 0 first and 1 (the rim) last
    rim_size : size at the rim
    ring_size : size at the other ring edges: one for all of them, or one for each
    growth : growth of the size with the distance from them
    truncation : radius of the quarter disc, in punch radii
    centre_size : size at the centre of the punch, where little area stands behind the value that people look at
    far_size : greatest size, over the truncation: elements of low degree follow the far field only along short sides
    """

    edges: tuple[float, ...]
    rim_size: float
    ring_size: float | tuple[float, ...]
    growth: float
    truncation: float
    centre_size: float = 0.25
    far_size: float = 0.25

    def __call__(self, points: Array) -> Array:
        """(n,) sizes at (n, 2) points."""
        size = np.minimum(self.largest, self.rim_size + self.growth * np.hypot(points[:, 0] - 1, points[:, 1]))
        for edge, smallest in zip(self.edges[:-1], (self.centre_size, *self.ring_sizes), strict=True):
            size = np.minimum(size, smallest + self.growth * np.hypot(points[:, 0] - edge, points[:, 1]))
        return size

    @property
    def largest(self) -> float:
        """Greatest size anywhere."""
        return self.truncation * self.far_size

    @property
    def ring_sizes(self) -> tuple[float, ...]:
        """Size at each ring edge between the centre and the rim."""
        count = len(self.edges) - 2
        return self.ring_size if isinstance(self.ring_size, tuple) else (self.ring_size,) * count
