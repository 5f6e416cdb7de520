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

# windows in a ring that kinks are sought in, and points of each that a cubic is fitted to
WINDOWS, POINTS = 256, 7
# kinks of a face, and peaks of a ring that may be kinks: rough and wavy faces have more
MOST_KINKS, MOST_PEAKS = 8, 32
# kinks nearer to each other than this, in punch radii, are one
NEAREST_KINKS = 1e-4
# part of what a cubic misses in a window that it misses in half of it: less on smooth faces
SMOOTH = 0.1
# halvings of a window, and by how much it has to become smaller until it is a kink
MOST_HALVINGS, FOUND = 40, 1e-3
# of a whole window and of a small one, over the range of heights in a ring: less is roundoff
ROUNDOFF_OF_WINDOWS, ROUNDOFF = 1e-9, 1e-14


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
        """Return the heights at radii of given rings: at their edges, too."""
        total = np.asarray(self.recess[ring], dtype=float)
        for height in self.heights:
            total = total + height(radii)
        return np.asarray(np.broadcast_to(total, np.shape(radii)), dtype=float)

    def slope(self, radii: Array) -> Array:
        """Return the slope within rings by central differences; steps at edges are no slope."""
        ring, step = ring_of(self.ring_edges, radii), 1e-5
        low = np.maximum(radii - step, self.ring_edges[ring])
        high = np.minimum(radii + step, self.ring_edges[ring + 1])
        rise = self.in_ring(high, ring) - self.in_ring(low, ring)
        return np.divide(rise, high - low, out=np.zeros_like(rise), where=high > low)

    @property
    def flat(self) -> bool:
        """Whether it is a plane: the face plane itself, or one that stands off it everywhere."""
        return not (self.heights or self.recess.any())

    @property
    def steps(self) -> Array:
        """(N-1,) step of the height at each ring edge between centre and rim, outwards."""
        return np.diff(self.recess)

    def sampled(self, *more: float) -> tuple[Array, Array]:
        """Return radii, many in every ring, its edges and kinks and `more`, and heights there."""
        within, kinks = np.linspace(0.0, 1.0, 501), np.array([*self.kinks, *more])
        parts = [
            np.union1d(a + (b - a) * within, kinks[(kinks > a) & (kinks < b)])
            for a, b in pairwise(self.ring_edges)
        ]
        heights = [self.in_ring(part, np.full(len(part), ring)) for ring, part in enumerate(parts)]
        return np.concatenate(parts), np.concatenate(heights)


def find_kinks(profile: InitialProfile) -> tuple[float, ...]:
    """Return the radii within rings at which the slope of a face, or its bend, jumps.

    A window about a kink is halved again and again, always towards the half that a cubic fits
    worse. On a smooth face the cubic of half a window misses a sixteenth of what it missed; at a
    kink it misses half if the slope jumps, and a quarter if the bend does.

    Returns
    -------
    tuple of float
        Increasing. None of a face with more than `MOST_KINKS`, such as a rough one.
    """
    kinks = list[float]()
    for inner, outer in pairwise(profile.ring_edges):
        scale = float(np.ptp(profile(np.linspace(inner, outer, 99))))
        width = (outer - inner) / WINDOWS
        # each window overlaps the next by half
        starts = inner + width * np.arange(0, WINDOWS - 1, 0.5)
        misses = _miss_of_cubics(profile, starts, width)
        highest = (misses >= np.roll(misses, 1)) & (misses > np.roll(misses, -1))
        peaks = np.flatnonzero(highest & (misses > ROUNDOFF_OF_WINDOWS * scale))
        if len(peaks) > MOST_PEAKS:
            return ()
        for start in starts[peaks].tolist():
            kink = _kink_in(profile, start, width, ROUNDOFF * scale)
            if kink is not None and inner < kink < outer:
                kinks.append(kink)
    kinks.sort()
    apart = [after for before, after in pairwise([-1.0, *kinks]) if after - before > NEAREST_KINKS]
    return tuple(apart) if len(apart) <= MOST_KINKS else ()


def _kink_in(profile: InitialProfile, start: float, width: float, roundoff: float) -> float | None:
    """Return the radius of the kink in a window, or None if the face is smooth there."""
    size, missed = width, float(_miss_of_cubics(profile, np.array([start]), width)[0])
    for _ in range(MOST_HALVINGS):
        halves = start + size * np.array([0.0, 0.25, 0.5])
        misses = _miss_of_cubics(profile, halves, size / 2)
        if misses.max() < max(SMOOTH * missed, roundoff):
            break
        size, missed = size / 2, float(misses.max())
        start = float(halves[misses.argmax()])
    return start + size / 2 if size < FOUND * width else None


def _miss_of_cubics(profile: InitialProfile, starts: Array, width: float) -> Array:
    """Return by how much cubics miss a face (n,) in windows of a width from starts (n,) on."""
    local = np.arange(POINTS) / (POINTS - 1)
    cubics = np.vander(local, 4)
    missing = np.eye(POINTS) - cubics @ np.linalg.pinv(cubics)
    heights = profile(starts[:, None] + width * local)
    return np.asarray(np.abs(heights @ missing).max(axis=1))


FLAT = InitialProfile(np.array([0.0, 1.0]), np.zeros(1))
