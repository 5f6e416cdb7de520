"""Describe the face of the punch before it wears: heights over the radius plus recesses of rings.

Non-dimensional: radii are in punch radii, heights in ``F / (a E*)``. A height is the depth of
missing material below the face plane. Where it is zero, the face lies in the face plane, whose
indentation is d. Heights may be any function of the radius; steps at ring edges are recesses.

If the least height is positive, it is subtracted before anything is computed and added to what is
reported. Steps, tolerances and norms therefore do not depend on it.

In contact problems, the face is represented by its moments with the functions of a pressure space.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander

from ....meshes.radial import Array, Indices, ring_of, unit_gauss
from .fields import Height

if TYPE_CHECKING:
    from ....meshes.pressure_space import PressureSpace

# search for kinks: number of windows in a ring, and points in each to which a cubic is fitted
WINDOWS, POINTS = 256, 7
# greatest number of kinks of a face, and of candidate windows in a ring; rough and wavy faces have
# more, and no kinks are reported for them
MOST_KINKS, MOST_PEAKS = 8, 32
# kinks that are closer to each other than this, in punch radii, count as one
NEAREST_KINKS = 1e-4
# residual of the cubic in half of a window, over that in the whole window; smaller ratios mean that
# the face is smooth
SMOOTH_RATIO = 0.1
# greatest number of halvings of a window, and its width after them, over the first width, below
# which it contains a kink
MOST_HALVINGS, KINK_WIDTH = 40, 1e-3
# distance from a radius at which slopes on both sides of it are computed, and the least jump of the
# slope, over the range of heights per punch radius, that counts as a crease
CREASE_STEP, LEAST_CREASE = 1e-5, 1e-2
# residuals of whole and of halved windows, over the range of heights in the ring, that are roundoff
ROUNDOFF_OF_WINDOWS, ROUNDOFF_OF_SMALL_WINDOWS = 1e-9, 1e-14


@dataclass(frozen=True, eq=False)
class InitialProfile:
    """Heights of the punch face before wear, measured from its point nearest to the half-space.

    Parameters
    ----------
    ring_edges : (N+1,) array
        Ring edges of the punch.
    recess : (N,) array
        Recess of each ring.
    heights : tuple of callables
        Functions of the radius that are added to the recesses.
    kinks : tuple of float
        Radii at which these functions are not smooth.
    standoff : float
        Distance of the nearest point from the face plane. The heights do not contain it.
    """

    ring_edges: Array
    recess: Array
    heights: tuple[Height, ...] = ()
    kinks: tuple[float, ...] = ()
    standoff: float = 0.0

    def __call__(self, radii: Array) -> Array:
        """Return the heights at radii; a ring edge belongs to the ring outside it."""
        return self.in_ring(radii, ring_of(self.ring_edges, radii))

    def in_ring(self, radii: Array, ring: Indices) -> Array:
        """Return the heights at radii in given rings, to which both of their edges belong."""
        total = np.asarray(self.recess[ring], dtype=float)
        for height in self.heights:
            total = total + height(radii)
        return np.asarray(np.broadcast_to(total, np.shape(radii)), dtype=float)

    @cached_property
    def creases(self) -> Array:
        """(K,) radii at which the slope of the face jumps, apart from ring edges.

        The axis is one of them if the face has a tip there, as a cone has. While the face is
        unworn, pressures and stresses are infinite at a crease in contact.
        """
        if not self.heights:
            return np.empty(0)
        inner, rim, reach = self.ring_edges[0], self.ring_edges[-1], 4 * CREASE_STEP
        kinks = np.array(self.kinks)
        kinks = kinks[(kinks > inner + reach) & (kinks < rim - reach)]
        outer_slopes, inner_slopes = (self._slopes_beside(kinks, side) for side in (1, -1))
        jumps = outer_slopes - inner_slopes
        if not inner:
            # the face is symmetric about the axis
            kinks = np.append(0.0, kinks)
            jumps = np.append(2 * self._slopes_beside(np.zeros(1), 1), jumps)
        least = LEAST_CREASE * float(np.ptp(self.sampled()[1]))
        return kinks[np.abs(jumps) > least]

    def _slopes_beside(self, radii: Array, side: int) -> Array:
        """Return the slopes at radii, extrapolated from the side outside (1) or inside (-1)."""
        ring, step = ring_of(self.ring_edges, radii), side * CREASE_STEP
        near, middle, far = (self.in_ring(radii + count * step, ring) for count in (1, 2, 4))
        return (2 * (middle - near) - (far - middle) / 2) / step

    @property
    def flat(self) -> bool:
        """Whether the face is a plane: the face plane, or one parallel to it."""
        return not (self.heights or self.recess.any())

    @property
    def steps(self) -> Array:
        """(N-1,) step of the height, outwards, at each ring edge between centre and rim."""
        return np.diff(self.recess)

    def sampled(self, *extra_radii: float) -> tuple[Array, Array]:
        """Return many radii in every ring, with edges, kinks and extra ones, and the heights."""
        fractions, kinks = np.linspace(0.0, 1.0, 501), np.array([*self.kinks, *extra_radii])
        parts = [
            np.union1d(a + (b - a) * fractions, kinks[(kinks > a) & (kinks < b)])
            for a, b in pairwise(self.ring_edges)
        ]
        heights = [self.in_ring(part, np.full(len(part), ring)) for ring, part in enumerate(parts)]
        return np.concatenate(parts), np.concatenate(heights)


FLAT = InitialProfile(np.array([0.0, 1.0]), np.zeros(1))


def moments(profile: InitialProfile, space: "PressureSpace", radius: float = 1.0) -> Array:
    """Return the moments (size,) ``int f phi_i dA`` of a profile f.

    The integrals are broken at kinks of the profile and at ring edges.

    Parameters
    ----------
    profile : InitialProfile
        Heights of the punch face.
    space : PressureSpace
        Space on the face, or on a smaller disc that is scaled to the unit disc.
    radius : float
        Radius of that disc. The integrals are over the unit disc.
    """
    points = _gauss_points(profile, space, radius)
    areas = 2 * np.pi * points.radii * points.weights
    return space.moments(points.element, points.local, areas * points.heights)


def unresolved_height(
    profile: InitialProfile, space: "PressureSpace", depth: float, radius: float = 1.0
) -> float:
    """Return the greatest difference between the face and its best polynomial on any element.

    The polynomials are least-squares fits, of one degree more than the pressure. The elements
    represent a face that is smooth in each. The indentations of two faces under the same force
    differ by at most the difference of the faces, so the result bounds the error of the
    indentation.

    Parameters
    ----------
    profile : InitialProfile
        Heights of the punch face.
    space : PressureSpace
        Space on the face, or on a smaller disc that is scaled to the unit disc.
    depth : float
        Elements on which all heights are greater than this indentation cannot touch and are
        ignored.
    radius : float
        Radius of that disc.
    """
    points, count = _gauss_points(profile, space, radius), len(space.degrees)
    degree = np.arange(space.top + 2)
    legendre = legvander(points.local, space.top + 1)
    # in the local coordinate, elements have length 2
    lengths = np.diff(space.breakpoints)[points.element, None]
    parts = np.einsum(
        "eq,eqj->ej", points.weights / lengths * points.heights, legendre * (2 * degree + 1)
    )
    fits = np.zeros((count, len(degree)))
    np.add.at(fits, points.element, parts)
    fits[degree > space.degrees[:, None] + 1] = 0
    missed = np.abs(points.heights - np.einsum("eqj,ej->eq", legendre, fits[points.element]))
    least = np.full(count, np.inf)
    np.minimum.at(least, points.element, points.heights.min(axis=1))
    touched = least[points.element] <= depth
    return float(missed.max(axis=1)[touched].max(initial=0.0))


class _GaussPoints(NamedTuple):
    """Q Gauss points in each of P pieces of elements.

    Parameters
    ----------
    element : (P,) array of int
        Index of the element of each piece.
    radii, local : (P, Q) arrays
        Radii, and coordinates from -1 to 1 within the element.
    weights : (P, Q) array
        Weights of ``dr``.
    heights : (P, Q) array
        Heights of the profile.
    """

    element: Indices
    radii: Array
    local: Array
    weights: Array
    heights: Array


def _gauss_points(profile: InitialProfile, space: "PressureSpace", radius: float) -> _GaussPoints:
    """Return Gauss points on the pieces between breakpoints, kinks and ring edges."""
    edges = np.concatenate([profile.ring_edges, profile.kinks]) / radius
    cuts = np.union1d(space.breakpoints, edges[(edges > 0) & (edges < 1)])
    # more points than polynomials of that degree need, because heights may be any function
    node, weight = unit_gauss(space.top + 8)
    width = np.diff(cuts)[:, None]
    element = np.searchsorted(space.breakpoints, cuts[:-1], side="right") - 1
    radii = cuts[:-1, None] + width * node
    start, size = space.breakpoints[element, None], np.diff(space.breakpoints)[element, None]
    # computed from coordinates within the element: radii have too few digits in small elements
    local = 2 * (cuts[:-1, None] - start + width * node) / size - 1
    ring = np.broadcast_to(
        ring_of(profile.ring_edges, radius * (cuts[:-1] + cuts[1:]) / 2)[:, None], radii.shape
    )
    heights = profile.in_ring(np.minimum(radius * radii, 1.0), ring)
    return _GaussPoints(element, radii, local, width * weight, heights)


def find_kinks(profile: InitialProfile) -> tuple[float, ...]:
    """Return the radii within rings at which the slope or the curvature of a face jumps.

    A window around a candidate is repeatedly halved; the half in which a cubic fits worse is kept.
    On a smooth face, each halving divides the residual of the cubic by 16. At a kink it divides the
    residual by 2 if the slope jumps, and by 4 if the curvature jumps.

    Returns
    -------
    tuple of float
        Increasing radii; empty if the face has more than `MOST_KINKS`, as rough faces do.
    """
    kinks = list[float]()
    for inner, outer in pairwise(profile.ring_edges):
        scale = float(np.ptp(profile(np.linspace(inner, outer, 99))))
        width = (outer - inner) / WINDOWS
        # successive windows overlap by half
        starts = inner + width * np.arange(0, WINDOWS - 1, 0.5)
        residuals = _cubic_residuals(profile, starts, width)
        local_maxima = (residuals >= np.roll(residuals, 1)) & (residuals > np.roll(residuals, -1))
        peaks = np.flatnonzero(local_maxima & (residuals > ROUNDOFF_OF_WINDOWS * scale))
        if len(peaks) > MOST_PEAKS:
            return ()
        for start in starts[peaks].tolist():
            kink = _kink_in(profile, start, width, ROUNDOFF_OF_SMALL_WINDOWS * scale)
            if kink is not None and inner < kink < outer:
                kinks.append(kink)
    kinks.sort()
    separate = [
        after for before, after in pairwise([-1.0, *kinks]) if after - before > NEAREST_KINKS
    ]
    return tuple(separate) if len(separate) <= MOST_KINKS else ()


def _kink_in(profile: InitialProfile, start: float, width: float, roundoff: float) -> float | None:
    """Return the radius of the kink in a window, or None if the face is smooth there.

    Parameters
    ----------
    start, width : float
        Inner end and width of the window.
    roundoff : float
        Residual below which the search ends.
    """
    size, last_residual = width, float(_cubic_residuals(profile, np.array([start]), width)[0])
    for _ in range(MOST_HALVINGS):
        halves = start + size * np.array([0.0, 0.25, 0.5])
        residuals = _cubic_residuals(profile, halves, size / 2)
        if residuals.max() < max(SMOOTH_RATIO * last_residual, roundoff):
            break
        size, last_residual = size / 2, float(residuals.max())
        start = float(halves[residuals.argmax()])
    return start + size / 2 if size < KINK_WIDTH * width else None


def _cubic_residuals(profile: InitialProfile, starts: Array, width: float) -> Array:
    """Return the greatest residuals (n,) of cubics fitted to a face in windows.

    The windows begin at `starts` (n,) and have the same width.
    """
    local = np.arange(POINTS) / (POINTS - 1)
    cubics = np.vander(local, 4)
    projection = np.eye(POINTS) - cubics @ np.linalg.pinv(cubics)
    heights = profile(starts[:, None] + width * local)
    return np.abs(heights @ projection).max(axis=1)
