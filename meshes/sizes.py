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

# estimated amplitude of the highest polynomial degree on elements, by the distances of their far
# ends from the nearest edge, the half width of the ring there, and the number of the edge
Amplitude = Callable[[Array, Array, Indices], Array]

# greatest quadrilaterals between the patches, over the truncation
LARGEST = 0.4
# rings, in a, that any mesher can tell from an edge
NARROWEST = 1e-12
# least degree that the displacement may fall to towards a ring edge or the rim: it goes with a
# stable linear pressure
LOWEST = 3
# greatest size of triangles at the centre by default, in a
CENTRE_SIZE = 0.25
# greatest size of triangles by default, over the truncation: four along each boundary
FAR_SIZE = 0.25
# times by which the growth of a coarser mesh is greater; sizes at singular points are doubled
COARSER_GROWTH = 1.5
# greatest growth of a coarser mesh, beyond which its triangles would be too flat
GREATEST_COARSER_GROWTH = 2.0
# times by which a patch may be widened to meet its neighbour: beyond, there is room for a
# quadrilateral between them, and so wide a patch would be flat
# (unit/meshes/test_half_space_mesh.py::test_it_is_the_quarter_disc)
MOST_STRETCH = 1.6
# layers that a size may exceed a whole number of layers by, so that roundoff adds none
ROUNDOFF_OF_LAYERS = 1e-9
# size of the elements beside a patch over its half-width: the sides of its outline, which meet the
# surface at 45 degrees, are as long as the root of 2 over the half-width
BESIDE_PATCHES = 1.4
# distinct sizes in an octave: a mesher makes a size field of each
SIZES_PER_OCTAVE = 4
# amplitude of the slope over that of the pressure, of which the root of the tolerance is enough
# (physics/test_size_rules.py)
SLOPE_AMPLITUDE = 3


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
    centre_size: float = CENTRE_SIZE
    far_size: float = FAR_SIZE
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
        """Return the sizes of a mesh whose difference shows what this one errs by.

        Twice the sizes at singular points, and ``COARSER_GROWTH`` times the growth. Shown by
        physics/test_estimates.py::test_random_scenes.
        """
        _, *rings, rim = (2 * self.sizes).tolist()
        growth = min(COARSER_GROWTH * self.growth, GREATEST_COARSER_GROWTH)
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
    """Return the half-widths (N, 2) of the patch at each ring edge but the centre.

    The first column holds the half-widths inwards, the second those outwards.

    Notes
    -----
    Half the width of the narrower ring beside the edge. Neighbours are widened to meet in the
    middle of the ring between them if ``MOST_STRETCH`` is enough for that. Shown by
    unit/meshes/test_half_space_mesh.py::test_it_is_the_quarter_disc.
    """
    rings = np.diff(ring_edges)
    half = np.minimum(rings, np.append(rings[1:], np.inf)) / 2
    widths = np.stack([half, half], axis=1)
    stretch = rings[1:] / (half[:-1] + half[1:])
    stretch[stretch > MOST_STRETCH] = 1.0
    widths[:-1, 1] *= stretch
    widths[1:, 0] *= stretch
    return widths


def patch_layers(widths: Array, sizes: Array, factor: float) -> Indices:
    """Return the number of layers (N,) that each patch needs.

    With so many layers its innermost elements are no larger than the size given for the patch:
    ``ln(size / half-width) / ln(factor)``, rounded up. Shown by
    unit/meshes/test_half_space_mesh.py::test_layers_shrink_to_the_wanted_size.
    """
    layers = np.log(sizes / widths.max(axis=1)) / np.log(factor)
    return np.maximum(1, np.ceil(layers - ROUNDOFF_OF_LAYERS)).astype(np.int64)


def degree_reductions(
    half_widths: Array,
    layer_counts: Indices,
    grading: float,
    amplitude: Amplitude,
    lacking_degrees: int = 0,
) -> list[Indices]:
    """Return by how much the polynomial degree may be lowered in each layer of each patch.

    Where the amplitude of high degrees is small, lower degrees reach the same error. If elements
    cannot have the degree that is wanted where the amplitude is greatest, all those that can have
    the degree wanted of them keep it, so that a finer tolerance never asks for lower degrees.

    Parameters
    ----------
    half_widths : (N, 2) half-widths of the patch at each ring edge but the centre, inwards and
        outwards
    layer_counts : (N,) layers of each patch
    grading : ratio of the sizes of neighbouring layers
    amplitude : of the highest degree on an element
    lacking_degrees : by how many degrees the highest one that elements have falls short of the one
        that the amplitude asks for

    Returns
    -------
    list of (layers + 1,) int arrays
        Outermost layer first; the last number belongs to the elements in the middle of the patch.

    Notes
    -----
    ``ln(A_greatest / A) / ln rho`` with the amplitude A on a layer and ``ln rho =
    convergence(grading)``. Shown by unit/meshes/test_half_space_mesh.py::test_degrees_fall_inwards.
    """
    reach = half_widths.max(axis=1)
    amplitudes = [
        amplitude(width * grading ** np.arange(count + 1.0), width, np.full(count + 1, number))
        for number, (width, count) in enumerate(zip(reach, layer_counts, strict=True))
    ]
    greatest = np.max(np.concatenate(amplitudes))
    return [
        np.maximum(degree_reduction(greatest / of_patch, grading) - lacking_degrees, 0)
        for of_patch in amplitudes
    ]


def adjacent_sizes(widths: Array) -> Array:
    """Return the size (N,) of the elements next to each patch, in powers of a fourth root of 2.

    ``BESIDE_PATCHES`` times the half-width of the patch. A mesher gets few distinct values, because
    each makes a size field of its own.
    """
    octaves = np.log2(BESIDE_PATCHES * widths.mean(axis=1))
    return np.asarray(2.0 ** (np.round(SIZES_PER_OCTAVE * octaves) / SIZES_PER_OCTAVE))


@dataclass(frozen=True, eq=False)
class EdgeAmplitude:
    """Estimate the amplitude of the highest polynomial degree of an element near a ring edge.

    It is relative to the rest of the solution, and has to become smaller than the tolerance. Wear
    smooths the pressure beside an edge over a length that grows in time with the wear of the
    material there. Between the worn lengths of both sides, the pressure at the edge of the slower
    ring is as singular as at the rim. The worn profile keeps a term ``x log x`` there, and its
    slope, whose square is integrated, a term ``log x``.

    Parameters
    ----------
    tolerance : relative accuracy wanted
    worn_length_slow : (N,) length over which wear has smoothed the pressure by the first time after
        the start, on the side of each edge that wears slower, for each edge but the centre;
        infinite if no history is wanted
    ratio : (N,) of the worn length on the other side to it, at least 1
    time_ratio : last time over the first
    kinks : (N,) how strong the kink of the wear coefficient is at each edge, 1 where it has a step
    narrower_width : (N,) width of the narrower ring beside each edge; left out if not given
    """

    tolerance: float
    worn_length_slow: Array
    ratio: Array
    time_ratio: float = 1.0
    kinks: Array | None = None
    narrower_width: Array | None = None

    @property
    def worn_length_fast(self) -> Array:
        """(N,) worn length by the first time on the side that wears faster."""
        return self.worn_length_slow * self.ratio

    def __call__(self, distance: Array, half_width: Array, edge: Indices) -> Array:
        """Return the amplitude on elements.

        Parameters
        ----------
        distance : (n,) of the far end of each element from its nearest edge
        half_width : (n,) half the width of the ring that the element is on
        edge : (n,) number of that edge; the last is the rim
        """
        at_rim = edge == len(self.worn_length_slow) - 1
        slow, fast, ratio = (
            part[edge] for part in (self.worn_length_slow, self.worn_length_fast, self.ratio)
        )
        with np.errstate(divide="ignore"):
            edge_factor = np.minimum(1.0, distance / slow)
            slope_factor = np.minimum(1.0, distance / np.minimum(slow, half_width))
        # At this distance the edge is most singular when the slower side has been worn so far: then
        # the faster side is worn over a multiple of it.
        worn_length = np.maximum(
            distance, np.minimum(np.maximum(fast, distance * ratio), fast * self.time_ratio)
        )
        far_factor = np.sqrt(np.minimum(1.0, worn_length / half_width))
        if self.narrower_width is not None:
            # a narrow ring changes the pressure beside it over a few times its own width
            width = self.narrower_width[edge]
            of_narrow = np.sqrt(np.minimum(1.0, 2 * worn_length / width))
            far_factor = np.maximum(far_factor, np.minimum(1.0, width / distance) * of_narrow)
        far_factor = np.where(at_rim, 1.0, far_factor)
        kink = 1.0 if self.kinks is None else self.kinks[edge]
        of_pressure = kink * far_factor * edge_factor**1.5
        of_slope = np.maximum(far_factor**2 * slope_factor, distance / half_width)
        # the square of the slope counts, so that its amplitude may be the root of the tolerance
        of_slope = SLOPE_AMPLITUDE * np.sqrt(self.tolerance * of_slope) * kink
        return np.asarray(np.maximum(np.maximum(of_pressure, of_slope), distance))


def convergence(grading: float) -> float:
    """Return the logarithm of the factor by which one more degree lowers the error.

    A polynomial of degree p on an element one element away from a singularity errs by ``rho^-p``
    with ``rho = (1 + sqrt(grading)) / (1 - sqrt(grading))`` (Bernstein's ellipse), where elements
    are smaller by `grading` than their neighbours (Trefethen, Approximation theory and
    approximation practice, ch. 8). Shown by
    physics/test_orders.py::test_indentation_on_quadrilaterals_by_the_degree.
    """
    return float(np.log((1 + grading**0.5) / (1 - grading**0.5)))


def degree_reduction(smaller: Array, grading: float) -> Indices:
    """Return by how much degrees may be lowered where the amplitude is so many times smaller."""
    return np.asarray(np.log(smaller) / convergence(grading), dtype=np.int64)
