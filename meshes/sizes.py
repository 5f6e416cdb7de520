"""Element sizes of the half-space, known before any mesh is: lengths in punch radii.

Triangles have the size ``min(rim_size + growth * d_rim, ring_size + growth * d_edge, far_size *
R)`` with the distances to the rim and to the nearest other ring edge (or the centre), and the
truncation radius R: well-shaped elements round every singular point, in numbers that grow only with
the logarithm of the smallest size. Quadrilaterals come in patches of geometric layers round ring
edges and rim, and in few large ones between.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .radial import Array, Indices

# what stands behind the highest degree of elements, by their distance from the nearest edge, the
# half width of the ring there, and the number of the edge
Behind = Callable[[Array, Array, Indices], Array]

# greatest quadrilaterals between the patches, over the truncation
LARGEST = 0.4
# rings, in a, that any mesher can tell from an edge
NARROWEST = 1e-12
# least degree that the displacement may fall to towards a ring edge or the rim: it goes with a
# stable linear pressure
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
    centre_size : size at the centre of the punch, where little area stands behind the value that
        people look at
    far_size : greatest size, over the truncation: elements of low degree follow the far field only
        along short sides
    cells : sizes on the contact by (n,) radii, which those of the triangles beside it do not exceed
    """

    ring_edges: tuple[float, ...]
    rim_size: float
    ring_size: float | tuple[float, ...]
    growth: float
    truncation: float
    centre_size: float = 0.25
    far_size: float = 0.25
    cells: Callable[[Array], Array] | None = None

    def __call__(self, points: Array) -> Array:
        """(n,) sizes at (n, 2) points."""
        radius, depth = points.T
        size = np.full(len(points), self.largest)
        for edge, smallest in zip(self.ring_edges, self.sizes, strict=True):
            size = np.minimum(size, smallest + self.growth * np.hypot(radius - edge, depth))
        if self.cells:
            away = np.hypot(depth, np.maximum(radius - 1, 0))
            size = np.minimum(size, self.cells(np.minimum(radius, 1)) + self.growth * away)
        return size

    def coarser(self) -> "SizeField":
        """Return the sizes of a mesh whose difference shows what this one errs by."""
        _, *rings, rim = (2 * self.sizes).tolist()
        growth = min(1.5 * self.growth, 2.0)
        return replace(self, rim_size=rim, ring_size=tuple(rings), growth=growth)

    @property
    def largest(self) -> float:
        """Greatest size anywhere."""
        return self.truncation * self.far_size

    @property
    def sizes(self) -> Array:
        """Size at the centre, at each ring edge and at the rim."""
        rings = np.broadcast_to(self.ring_size, len(self.ring_edges) - 2)
        return np.concatenate([[self.centre_size], rings, [self.rim_size]])


def patch_widths(ring_edges: Array) -> Array:
    """Return the half-widths (N, 2), inwards and outwards, of the patch at each edge but the
    centre.
    """
    rings = np.diff(ring_edges)
    half = np.minimum(rings, np.append(rings[1:], np.inf)) / 2
    widths = np.stack([half, half], axis=1)
    # neighbours are widened to meet in the middle of the ring between them, where a little is
    # enough
    stretch = rings[1:] / (half[:-1] + half[1:])
    stretch[stretch > 1.6] = 1.0
    widths[:-1, 1] *= stretch
    widths[1:, 0] *= stretch
    return widths


def patch_layers(widths: Array, sizes: Array, factor: float) -> Indices:
    """Return the number of layers (N,) that each patch needs for innermost elements no larger than
    its size.
    """
    return np.maximum(
        1, np.ceil(np.log(sizes / widths.max(axis=1)) / np.log(factor) - 1e-9)
    ).astype(np.int64)


def falls(widths: Array, layers: Indices, factor: float, sharpness: Behind) -> list[Indices]:
    """Return by how much the degree may be lowered in each layer of each patch, the middle last."""
    half = widths.max(axis=1)
    behind = [
        sharpness(reach * factor ** np.arange(count + 1.0), reach, np.full(count + 1, number))
        for number, (reach, count) in enumerate(zip(half, layers, strict=True))
    ]
    greatest = np.max(np.concatenate(behind))
    return [spared_degrees(greatest / in_layers, factor) for in_layers in behind]


def beside(widths: Array) -> Array:
    """Return the size (N,) of the elements beside each patch, in the few distinct values a mesher
    digests.
    """
    return np.asarray(2.0 ** (np.round(4 * np.log2(1.4 * widths.mean(axis=1))) / 4))


@dataclass(frozen=True, eq=False)
class Sharpness:
    """How much stands behind the highest degree of an element near a ring edge, over the rest.

    It has to become smaller than the accuracy. Wear blunts the pressure beside an edge over a
    length that grows in time, on each side as its material wears: between the two lengths the edge
    of the slower ring is sharp, as the rim is. At a distance it is sharpest when the slower side
    has just been blunted so far. The worn profile keeps ``x log x`` there, and its slope, whose
    square counts, ``log x``.

    Parameters
    ----------
    accuracy : wanted
    slow : (N,) length that wear has blunted at the first time after the start, beside each edge but
        the centre, on the side that wears slower; infinite if no history is wanted
    ratio : (N,) of the length on the other side to it, at least 1
    span : last time over the first
    kinks : (N,) how strong the kink of the wear coefficient is at each edge, 1 where it has a step
    narrower : (N,) width of the narrower ring beside each edge; not felt if not given
    """

    accuracy: float
    slow: Array
    ratio: Array
    span: float = 1.0
    kinks: Array | None = None
    narrower: Array | None = None

    @property
    def fast(self) -> Array:
        """(N,) length that wear has blunted at the first time on the side that wears faster."""
        return self.slow * self.ratio

    def __call__(self, distance: Array, half: Array, edge: Indices) -> Array:
        """By the distance of an element's far end from an edge, the ring's half width, the edge."""
        at_rim, slow = edge == len(self.slow) - 1, self.slow[edge]
        with np.errstate(divide="ignore"):
            sharp = np.minimum(1.0, distance / slow)
            within = np.minimum(1.0, distance / np.minimum(slow, half))
        fast, ratio = self.fast[edge], self.ratio[edge]
        blunted = np.maximum(
            distance, np.minimum(np.maximum(fast, distance * ratio), fast * self.span)
        )
        whole = np.sqrt(np.minimum(1.0, blunted / half))
        if self.narrower is not None:
            # a narrow ring is felt beside it over a few times its own width
            width = self.narrower[edge]
            of_narrow = np.sqrt(np.minimum(1.0, 2 * blunted / width))
            whole = np.maximum(whole, np.minimum(1.0, width / distance) * of_narrow)
        whole = np.where(at_rim, 1.0, whole)
        kink = 1.0 if self.kinks is None else self.kinks[edge]
        pressure = kink * whole * sharp**1.5
        slope = 3 * np.sqrt(self.accuracy * np.maximum(whole**2 * within, distance / half)) * kink
        return np.asarray(np.maximum(np.maximum(pressure, slope), distance))


def convergence(ratio: float) -> float:
    """Return the logarithm of what a degree gains where elements are smaller by `ratio` than their
    neighbours.

    A polynomial on an element one element away from a singularity converges with the ellipse
    through it (Bernstein).
    """
    return float(np.log((1 + ratio**0.5) / (1 - ratio**0.5)))


def spared_degrees(less: Array, ratio: float) -> Indices:
    """Return by how much degrees may be lowered where the amplitude is so many times smaller."""
    return np.asarray(np.log(less) / convergence(ratio), dtype=np.int64)
