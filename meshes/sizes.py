"""Size rules of the half-space meshes, evaluated before any mesh exists.

Lengths are in punch radii.

The size of a triangle is the least of ``rim_size + growth * d_rim``,
``ring_size + growth * d_edge`` and ``far_size * R``, where d_rim is the distance to the rim, d_edge
the distance to the nearest other ring edge or the centre, and R the truncation radius. This gives
well-shaped elements round every singular point, and their number grows only with the logarithm of
the smallest size. Quadrilaterals are arranged in patches of geometric layers round the ring edges
and the rim, with a few large ones between the patches.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .radial import Array, Indices, from_axis

# Function that estimates the amplitude of the highest polynomial degree on elements. Its arguments
# are the distance of the far end of each element from the nearest edge, half the width of the ring
# there, and the number of the edge.
Amplitude = Callable[[Array, Array, Indices], Array]

# tolerance at which the constants of sizes of triangles and of numbers of cells are stated
REFERENCE_RTOL = 1e-4
# largest size of the quadrilaterals between the patches, relative to the truncation radius
LARGEST_QUADRILATERAL = 0.4
# narrowest ring, in punch radii, that every mesher can distinguish from a single edge
NARROWEST_RING = 1e-12
# Lowest polynomial degree of the displacement next to a ring edge or the rim. The linear pressure
# that is combined with it is stable.
LOWEST_DISPLACEMENT_DEGREE = 3
# Truncation radius of quadrilaterals with Boussinesq's far field and of layers; and that of
# triangles and of meshes with a clamped outer boundary, in punch radii (`ringwear study
# truncation`).
NEAR_TRUNCATION, FAR_TRUNCATION = 2.5, 5.0
# default of the largest triangle size at the centre, in punch radii
CENTRE_SIZE = 0.25
# default of the largest triangle size, relative to the truncation radius: four triangles along each
# boundary
FAR_SIZE = 0.25
# Factor on the growth in a coarser mesh, which serves for error estimates. Its sizes at singular
# points are doubled.
COARSER_GROWTH = 1.5
# largest growth of a coarser mesh; a larger one would make triangles too flat
GREATEST_COARSER_GROWTH = 2.0
# Largest factor by which a patch is widened to meet its neighbour. A larger gap has room for a
# quadrilateral between the two patches, and a patch that is stretched further would be too flat
# (unit/meshes/test_half_space_mesh.py::test_meshes_cover_the_quarter_disc).
MAX_PATCH_STRETCH = 1.6
# excess over a whole number of layers that counts as roundoff and adds no layer
LAYER_COUNT_ROUNDOFF = 1e-9
# Size of the elements next to a patch, relative to the half-width of the patch. The sides of a
# patch meet the surface at 45 degrees, so their length is sqrt(2) times the half-width.
ADJACENT_SIZE_RATIO = 1.4
# number of distinct sizes per factor of 2; the mesher builds a separate size field for each
SIZES_PER_OCTAVE = 4
# Factor on the amplitude of the slope, relative to that of the pressure. The slope is needed only
# to the square root of the tolerance (physics/test_size_rules.py).
SLOPE_AMPLITUDE = 3
# Degrees that are added where the wear coefficient varies: relaxed degrees and finite elements have
# up to one less, and the coarser solution another one.
SPARE_POLE_DEGREES = 2
# Size ratio of neighbouring elements to which amplitudes where the wear coefficient varies belong:
# the largest one in use, with which they are largest.
POLE_GRADING = 0.25


@dataclass(frozen=True)
class SizeField:
    """The target element size as a function of position.

    Parameters
    ----------
    ring_edges : ring edges, from 0 or the radius of a hole to 1 (the rim)
    rim_size : size at the rim
    ring_size : size at the other ring edges, either one number or one for each edge
    growth : increase of the size per distance from the edges
    truncation : radius of the quarter disc, in punch radii
    centre_size : size at the centre of the punch; the area around it is small, but users look at
        the value there
    far_size : largest size, relative to the truncation radius; elements of low degree approximate
        the far field well only if their sides are short
    cells : function that returns the cell sizes on the contact at (n,) radii; triangles next to the
        contact are not larger than these
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
        """Return the target sizes (n,) at the points (n, 2)."""
        radius, depth = points.T
        size = np.full(len(points), self.largest)
        for edge, smallest in zip(from_axis(self.ring_edges), self.sizes, strict=True):
            size = np.minimum(size, smallest + self.growth * np.hypot(radius - edge, depth))
        if self.cells:
            contact_distance = np.hypot(depth, np.maximum(radius - 1, 0))
            size = np.minimum(
                size, self.cells(np.minimum(radius, 1)) + self.growth * contact_distance
            )
        return size

    def coarser(self) -> "SizeField":
        """Return the sizes of a coarser mesh, used to estimate the error on this one.

        The sizes at singular points are doubled, and the growth is multiplied by
        ``COARSER_GROWTH``. The error estimate is the difference between the solutions on the two
        meshes; it is tested by physics/test_estimates.py::test_random_scenes.
        """
        _, *rings, rim = (2 * self.sizes).tolist()
        growth = min(COARSER_GROWTH * self.growth, GREATEST_COARSER_GROWTH)
        return replace(self, rim_size=rim, ring_size=tuple(rings), growth=growth)

    @property
    def largest(self) -> float:
        """Largest size anywhere in the mesh."""
        return self.truncation * self.far_size

    @property
    def sizes(self) -> Array:
        """Sizes at the centre, at each ring edge and at the rim."""
        rings = np.broadcast_to(self.ring_size, len(from_axis(self.ring_edges)) - 2)
        return np.concatenate([[self.centre_size], rings, [self.rim_size]])


def patch_widths(ring_edges: Array) -> Array:
    """Return the half-widths (N, 2) of the patch at each ring edge except the centre.

    The first column holds the half-widths towards the axis, the second those away from it.

    Notes
    -----
    The half-width is half the width of the narrower of the two rings that meet at the edge. Two
    neighbouring patches that leave a gap in the ring between them are widened to meet in its
    middle, if a stretch by at most ``MAX_PATCH_STRETCH`` is enough for both. No patch reaches
    beyond the middle of a ring, because the degree that the modes of a ring require
    (`studies/crosscheck/sizes/degrees.py`) is that of elements within half of the ring. Tested by
    unit/meshes/test_half_space_mesh.py::test_meshes_cover_the_quarter_disc and
    physics/test_hollow.py::test_relaxation_times_beside_a_narrow_hole.
    """
    rings = np.diff(from_axis(ring_edges))
    half = np.minimum(rings, np.append(rings[1:], np.inf)) / 2
    widths = np.stack([half, half], axis=1)
    middle = rings[1:] / 2
    meet = middle <= MAX_PATCH_STRETCH * np.minimum(half[:-1], half[1:])
    widths[:-1, 1] = np.where(meet, middle, half[:-1])
    widths[1:, 0] = np.where(meet, middle, half[1:])
    return widths


def patch_layers(widths: Array, sizes: Array, factor: float) -> Indices:
    """Return the number of layers (N,) of each patch.

    It is the smallest number for which the innermost elements of the patch are not larger than its
    size in `sizes`: ``ln(size / half-width) / ln(factor)``, rounded up. Tested by
    unit/meshes/test_half_space_mesh.py::test_layers_shrink_to_the_wanted_size.
    """
    layers = np.log(sizes / widths.max(axis=1)) / np.log(factor)
    return np.maximum(1, np.ceil(layers - LAYER_COUNT_ROUNDOFF)).astype(np.int64)


def degree_reductions(
    half_widths: Array,
    layer_counts: Indices,
    grading: float,
    amplitude: Amplitude,
    lacking_degrees: int = 0,
) -> list[Indices]:
    """Return by how much the polynomial degree may be lowered in each layer of each patch.

    If the amplitude of high degrees is small on an element, a lower degree reaches the same error
    there. If the mesh cannot provide the highest degree that the amplitude requires, only the
    elements whose required degree is lower than the available one are reduced. A tighter tolerance
    therefore never leads to lower degrees.

    Parameters
    ----------
    half_widths : (N, 2) half-widths of the patch at each ring edge except the centre, towards the
        axis and away from it
    layer_counts : (N,) number of layers of each patch
    grading : ratio of the sizes of neighbouring layers
    amplitude : estimate of the amplitude of the highest degree on an element
    lacking_degrees : difference between the highest degree that the amplitude requires and the
        highest degree available

    Returns
    -------
    list of (layers + 1,) int arrays
        Outermost layer first; the last number belongs to the elements in the middle of the patch.

    Notes
    -----
    Tested by unit/meshes/test_half_space_mesh.py::test_degrees_fall_inwards.
    """
    largest_half_widths = half_widths.max(axis=1)
    amplitudes = [
        amplitude(width * grading ** np.arange(count + 1.0), width, np.full(count + 1, number))
        for number, (width, count) in enumerate(zip(largest_half_widths, layer_counts, strict=True))
    ]
    greatest = float(np.max(np.concatenate(amplitudes)))
    return [
        degree_reduction(patch_amplitudes, greatest, grading, lacking_degrees)
        for patch_amplitudes in amplitudes
    ]


def adjacent_sizes(widths: Array) -> Array:
    """Return the size (N,) of the elements next to each patch.

    It is ``ADJACENT_SIZE_RATIO`` times the half-width of the patch, rounded to a power of the
    fourth root of 2. The rounding leaves few distinct values; the mesher builds a separate size
    field for each.
    """
    return rounded_to_octaves(ADJACENT_SIZE_RATIO * widths.mean(axis=1))


def rounded_to_octaves(sizes: Array) -> Array:
    """Return sizes (N,) rounded to `SIZES_PER_OCTAVE` values in each octave.

    A mesher makes a size field of each distinct size.
    """
    octaves = np.log2(sizes)
    return 2.0 ** (np.round(SIZES_PER_OCTAVE * octaves) / SIZES_PER_OCTAVE)


@dataclass(frozen=True, eq=False)
class EdgeAmplitude:
    """Estimate the amplitude of the highest polynomial degree of an element near a ring edge.

    The amplitude is relative to the rest of the solution; the polynomial degree is sufficient if it
    reduces the amplitude below the tolerance. Wear smooths the pressure beside an edge over a
    length that grows with time and with the wear coefficient of the material on that side. At
    distances between the worn lengths of the slower and the faster side, the pressure at the edge
    of the slower ring is as singular as at the rim. The worn profile has a term ``x log x`` there.
    Its slope, whose square is integrated, has a term ``log x``.

    Parameters
    ----------
    tolerance : required relative accuracy
    worn_length_slow : (N,) length over which wear has smoothed the pressure by the first time after
        the start, on the slower side of each edge except the centre; infinite if only the steady
        state is computed
    ratio : (N,) worn length on the faster side over the worn length on the slower side, at least 1
    time_ratio : last time over the first time
    kinks : (N,) relative strength of the kink of the wear coefficient at each edge; 1 for a step,
        and the default is 1 for all edges
    narrower_width : (N,) width of the narrower ring at each edge; without it, the influence of
        narrow rings on their neighbours is not included
    wear_gradients : (N,) greatest ``|dk/dr| / k`` of the wear coefficient beside each edge;
        without it, wear coefficients are constant on rings
    """

    tolerance: float
    worn_length_slow: Array
    ratio: Array
    time_ratio: float = 1.0
    kinks: Array | None = None
    narrower_width: Array | None = None
    wear_gradients: Array | None = None

    @property
    def worn_length_fast(self) -> Array:
        """(N,) worn length at the first time on the side that wears faster."""
        return self.worn_length_slow * self.ratio

    def __call__(self, distance: Array, half_width: Array, edge: Indices) -> Array:
        """Return the amplitude (n,) on elements.

        Parameters
        ----------
        distance : (n,) distance of the far end of each element from its nearest edge
        half_width : (n,) half the width of the ring that the element is on
        edge : (n,) number of the nearest edge; the highest number is the rim
        """
        at_rim = edge == len(self.worn_length_slow) - 1
        slow, fast, ratio = (
            values[edge] for values in (self.worn_length_slow, self.worn_length_fast, self.ratio)
        )
        with np.errstate(divide="ignore"):
            edge_factor = np.minimum(1.0, distance / slow)
            slope_factor = np.minimum(1.0, distance / np.minimum(slow, half_width))
        # At a distance d the solution is most singular when wear has smoothed a length d on the
        # slower side. The worn length on the faster side is then d * ratio, limited to its values
        # at the first and the last time.
        worn_length = np.maximum(
            distance, np.minimum(np.maximum(fast, distance * ratio), fast * self.time_ratio)
        )
        far_factor = np.sqrt(np.minimum(1.0, worn_length / half_width))
        if self.narrower_width is not None:
            # a narrow ring changes the pressure of its neighbours over a few times its own width
            width = self.narrower_width[edge]
            narrow_factor = np.sqrt(np.minimum(1.0, 2 * worn_length / width))
            far_factor = np.maximum(far_factor, np.minimum(1.0, width / distance) * narrow_factor)
        far_factor = np.where(at_rim, 1.0, far_factor)
        kink = 1.0 if self.kinks is None else self.kinks[edge]
        pressure_amplitude = kink * far_factor * edge_factor**1.5
        slope_amplitude = np.maximum(far_factor**2 * slope_factor, distance / half_width)
        # The squared slope is integrated, so the slope may err by sqrt(tolerance). Its amplitude is
        # scaled so that it can be compared with the tolerance, too.
        slope_amplitude = SLOPE_AMPLITUDE * np.sqrt(self.tolerance * slope_amplitude) * kink
        amplitude = np.maximum(np.maximum(pressure_amplitude, slope_amplitude), distance)
        if self.wear_gradients is not None:
            # wear coefficients at most double on a ring
            rise = np.minimum(self.wear_gradients[edge] * distance, 1.0)
            amplitude = np.maximum(amplitude, pole_amplitude(rise, self.tolerance))
        return amplitude


def pole_amplitude(rise: Array, tolerance: float) -> Array:
    """Return the amplitude (n,) of 1 / k on elements along which k is linear.

    Pressures tend to this function, and small areas where k is least have the greatest slopes and
    pressures. The error is therefore relative to the pressure on the element.

    Parameters
    ----------
    rise : (n,) change of k along each element over the least k on it
    tolerance : required relative accuracy

    Notes
    -----
    With x = 1 + 2 / rise the pole is at the distance x from the middle of the element, whose
    half-width is 1. A polynomial of degree p has the relative error ``r^-p / (x + 1)`` with ``r = x
    + sqrt(x^2 - 1)``. SPARE_POLE_DEGREES are added to the degree at which this is the tolerance.
    Amplitudes belong to the error ``rho^-p`` beside a singular point (`convergence`), with rho of
    POLE_GRADING: the amplitude is such that both need the same degree. Shown by
    physics/test_graded.py.
    """
    x = 1 + 2 / np.maximum(rise, np.finfo(float).eps)
    rate = np.log(x + np.sqrt((x - 1) * (x + 1)))
    digits = -np.log((x + 1) * tolerance)
    degree = np.where(digits > 0, digits / rate + SPARE_POLE_DEGREES, 0.0)
    return tolerance * np.exp(degree * convergence(POLE_GRADING))


def convergence(grading: float) -> float:
    """Return ``ln rho``, the logarithm of the factor by which one more degree reduces the error.

    Parameters
    ----------
    grading : ratio q of the sizes of neighbouring elements

    Notes
    -----
    In layers that shrink by q, an element reaches from q to 1 times the distance of its far end
    from the singular point. That point is ``x = (1 + q) / (1 - q)`` half-widths from its middle, so
    that the pressure is analytic in the Bernstein ellipse with ``rho = x + sqrt(x^2 - 1) = (1 +
    sqrt(q)) / (1 - sqrt(q))``, and the error of a polynomial of degree p is proportional to
    ``rho^-p`` (Trefethen, Approximation theory and approximation practice, ch. 8). Tested by
    unit/studies/study/test_ways.py::test_indentation_on_quadrilaterals_by_the_degree.
    """
    return float(np.log((1 + grading**0.5) / (1 - grading**0.5)))


def required_degree(amplitude_over_error: Array | float, grading: float) -> Array:
    """Return the degree p, not rounded, with which an element has a wanted error: ``A rho^-p``.

    Parameters
    ----------
    amplitude_over_error : amplitude A of high degrees on the element (`EdgeAmplitude`) over the
        wanted error
    grading : ratio of the sizes of neighbouring elements, from which `convergence` is ``ln rho``
    """
    return np.log(amplitude_over_error) / convergence(grading)


def degree_reduction(
    amplitude: Array, greatest: float, grading: float, lacking_degrees: int = 0
) -> Indices:
    """Return by how much the degree may be lowered where the amplitude of high degrees is smaller.

    Parameters
    ----------
    amplitude : amplitude on each element
    greatest : largest amplitude on all elements
    grading : ratio of the sizes of neighbouring elements
    lacking_degrees : difference between the degree that the largest amplitude requires and the
        highest one available: elements that require no more than the latter keep their degree
    """
    reduction = required_degree(greatest / amplitude, grading).astype(np.int64)
    return np.maximum(reduction - lacking_degrees, 0)
