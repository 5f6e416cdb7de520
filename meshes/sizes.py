"""Element sizes of the half-space, known before any mesh is: lengths in punch radii.

Triangles have the size ``min(rim_size + growth * d_rim, ring_size + growth * d_edge, far_size * R)`` with the distances to
the rim and to the nearest other ring edge (or the centre), and the truncation radius R: well-shaped elements round every
singular point, in numbers that grow only with the logarithm of the smallest size. Quadrilaterals come in patches of
geometric layers round ring edges and rim, and in few large ones between.
"""

from dataclasses import dataclass

import numpy as np

from ringwear.meshes.radial import Array, Indices

# greatest quadrilaterals between the patches, over the truncation
LARGEST = 0.4
# least degree that the displacement may fall to towards a ring edge or the rim: it goes with a stable linear pressure
LOWEST = 3


@dataclass(frozen=True)
class SizeField:
    """The wanted element size as a function of position.

    Parameters
    ----------
    ring_edges : ring edges, 0 first and 1 (the rim) last
    rim_size : size at the rim
    ring_size : size at the other ring edges: one for all of them, or one for each
    growth : growth of the size with the distance from them
    truncation : radius of the quarter disc, in punch radii
    centre_size : size at the centre of the punch, where little area stands behind the value that people look at
    far_size : greatest size, over the truncation: elements of low degree follow the far field only along short sides
    """

    ring_edges: tuple[float, ...]
    rim_size: float
    ring_size: float | tuple[float, ...]
    growth: float
    truncation: float
    centre_size: float = 0.25
    far_size: float = 0.25

    def __call__(self, points: Array) -> Array:
        """(n,) sizes at (n, 2) points."""
        size = np.full(len(points), self.largest)
        for edge, smallest in zip(self.ring_edges, (self.centre_size, *self.ring_sizes, self.rim_size), strict=True):
            size = np.minimum(size, smallest + self.growth * np.hypot(points[:, 0] - edge, points[:, 1]))
        return size

    @property
    def largest(self) -> float:
        """Greatest size anywhere."""
        return self.truncation * self.far_size

    @property
    def ring_sizes(self) -> tuple[float, ...]:
        """Size at each ring edge between the centre and the rim."""
        return tuple(np.broadcast_to(self.ring_size, len(self.ring_edges) - 2).tolist())


def patch_widths(ring_edges: Array) -> Array:
    """(N, 2) half-widths of the patch at each edge but the centre, towards the axis and away from it."""
    rings = np.diff(ring_edges)
    half = np.minimum(rings, np.append(rings[1:], np.inf)) / 2
    widths = np.stack([half, half], axis=1)
    # neighbours are widened to meet in the middle of the ring between them, where a little is enough
    stretch = rings[1:] / (half[:-1] + half[1:])
    stretch[stretch > 1.6] = 1.0
    widths[:-1, 1] *= stretch
    widths[1:, 0] *= stretch
    return widths


def patch_layers(widths: Array, sizes: Array, factor: float) -> Indices:
    """(N,) layers that each patch needs for innermost elements no larger than its size."""
    return np.maximum(1, np.ceil(np.log(sizes / widths.max(axis=1)) / np.log(factor) - 1e-9)).astype(np.int64)


def falls(layers: Indices) -> list[Indices]:
    """For each patch (layers + 1,) how much lower the degree may be in each layer and, last, in the middle."""
    # there is ever less energy to lose; the rim's singularity is stronger
    rates = np.append(np.ones(len(layers) - 1), 0.6)
    return [(rate * np.arange(count + 1)).astype(np.int64) for rate, count in zip(rates, layers, strict=True)]


def beside(widths: Array) -> Array:
    """(N,) size of the elements beside each patch, in few distinct values, which is what a mesher digests."""
    return np.asarray(2.0 ** (np.round(4 * np.log2(1.4 * widths.mean(axis=1))) / 4))
