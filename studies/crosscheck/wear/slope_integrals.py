"""Integrate the slope of an unworn face, and its square, over the cells of a mesh.

The slope may be infinite at a ring edge or at a kink of the face, as at the rim of a ball whose
radius is that of the punch. Its mean square is then finite only if the slope grows slowly enough.
Differences of heights over cells would give a finite number that depends on the cells.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....meshes.radial import Array, Indices, ring_of, unit_gauss
from ..problem.profile import InitialProfile
from .unilateral import Mask

# Gauss points of a part of a cell; with them, the integral of 1/x over a part that is as wide as
# its distance from the singular point is right to nine digits
POINTS = 6
# Distance from a singular point, in punch radii, below which integrals use the power law that the
# slope follows there. Closer to it, radii have too few digits.
NEAREST = 1e-12
# ratio of the distances between which the power law is fitted
POWER_LAW_REACH = 32.0
# A slope is taken to be infinite at a point if it grows by more than MOST_GROWTH from FAR times the
# width of the smooth part there to FIRST times NEAREST.
FAR, FIRST, MOST_GROWTH = 1e-3, 4.0, 1.05
# Least power of the distance from a singular point with which an integrand may grow there; with -1,
# the integral is infinite, and the rest is the accuracy of the fitted power.
LEAST_POWER = -1 + 1e-3
# step of the differences that give slopes, relative to the distance from the nearest singular
# point, and greatest step, in punch radii
STEP, MOST_STEP = 1e-2, 1e-5


class SlopeIntegrals(NamedTuple):
    """Integrals over each of E cells, with the weight w of an average over the face.

    Parameters
    ----------
    weight : (E,) array
        ``int w dr``.
    slope : (E,) array
        ``int w f' dr`` of the unworn face f.
    square : (E,) array
        ``int w f'^2 dr``; infinite if that is not finite.
    """

    weight: Array
    slope: Array
    square: Array


def slope_integrals(
    profile: InitialProfile, breakpoints: Array, weight: Callable[[Array], Array]
) -> SlopeIntegrals:
    """Return integrals of the slope of an unworn face over cells.

    Steps at ring edges do not count. Towards points at which the slope is infinite, the parts of
    cells over which Gauss's rule integrates become smaller by factors of two.

    Parameters
    ----------
    profile : InitialProfile
        Unworn face.
    breakpoints : (E+1,) array
        Boundaries of the cells of the face.
    weight : callable
        Returns the weight of radii, which is smooth.
    """
    parts = _SmoothParts(profile)
    infinite = parts.sides_with_infinite_slope()
    graded = [
        end + inwards * NEAREST * 2.0 ** np.arange(np.ceil(np.log2(width / 2 / NEAREST)))
        for end, inwards, width in zip(
            parts.ends[infinite], parts.inwards[infinite], parts.side_widths[infinite], strict=True
        )
    ]
    inside = breakpoints[(breakpoints > parts.edges[0]) & (breakpoints < 1)]
    cuts = np.unique(np.concatenate([parts.edges, inside, *graded]))
    node, gauss_weight = unit_gauss(POINTS)
    radii = cuts[:-1, None] + np.diff(cuts)[:, None] * node
    lengths = np.diff(cuts)[:, None] * gauss_weight * weight(radii)
    slopes = parts.slopes(radii)
    # the parts next to a singular point are integrated by their power law instead
    part_starts = np.searchsorted(cuts, parts.edges)
    beside = np.where(parts.inwards > 0, part_starts[parts.edge], part_starts[parts.edge] - 1)
    slopes[beside[infinite]] = 0.0
    cell = np.searchsorted(breakpoints, cuts[:-1], side="right") - 1
    integrals = np.zeros((3, len(breakpoints) - 1))
    for power, total in enumerate(integrals):
        np.add.at(total, cell, (lengths * slopes**power).sum(axis=1))
    for side in np.flatnonzero(infinite).tolist():
        for power in (1, 2):
            integrals[power, cell[beside[side]]] += parts.integral_at_end(side, power, weight)
    return SlopeIntegrals(*integrals)


class _SmoothParts:
    """The parts of a face between its ring edges and kinks, and the two sides of each part.

    Attributes
    ----------
    edges : (P+1,) array
        Edges of the parts.
    edge, inwards : (2 P,) arrays
        Index of the edge of each side, and the direction of the part from there, 1 or -1.
    ends, side_widths : (2 P,) arrays
        Radius of that edge, and width of the part.
    """

    def __init__(self, profile: InitialProfile) -> None:
        self.profile = profile
        kinks = np.array(profile.kinks)
        first = profile.ring_edges[0]
        self.edges = np.union1d(profile.ring_edges, kinks[(kinks > first) & (kinks < 1)])
        count = len(self.edges) - 1
        self.edge = np.append(np.arange(count), np.arange(1, count + 1))
        self.inwards = np.repeat([1.0, -1.0], count)
        self.ends, self.side_widths = self.edges[self.edge], np.tile(np.diff(self.edges), 2)

    def slopes(self, radii: Array) -> Array:
        """Return slopes at radii inside the parts; arrays of any shape."""
        number = np.clip(
            np.searchsorted(self.edges, radii, side="right") - 1, 0, len(self.edges) - 2
        )
        inner, outer = self.edges[number], self.edges[number + 1]
        ring = ring_of(self.profile.ring_edges, (inner + outer) / 2)
        step = np.minimum(STEP * np.minimum(radii - inner, outer - radii), MOST_STEP)
        narrow, wide = (self._difference(radii, factor * step, ring) for factor in (1.0, 2.0))
        return (4 * narrow - wide) / 3

    def _difference(self, radii: Array, step: Array, ring: Indices) -> Array:
        """Return the central differences of the heights, over the rounded distances of radii."""
        low, high = radii - step, radii + step
        rise = self.profile.in_ring(high, ring) - self.profile.in_ring(low, ring)
        return np.divide(rise, high - low, out=np.zeros_like(rise), where=high > low)

    def sides_with_infinite_slope(self) -> Mask:
        """Return at which sides (2 P,) the slope grows towards the end."""
        far = FAR * self.side_widths
        near = np.full(len(far), FIRST * NEAREST)
        slopes = [
            np.abs(self.slopes(self.ends + self.inwards * distance)) for distance in (near, far)
        ]
        return (far > POWER_LAW_REACH * near) & (slopes[0] > MOST_GROWTH * slopes[1])

    def integral_at_end(self, side: int, power: int, weight: Callable[[Array], Array]) -> float:
        """Return the integral of a power of the slope, within NEAREST of the end of a side.

        The integrand follows a power of the distance; the integral is infinite if that power is
        below LEAST_POWER.
        """
        distances = NEAREST * np.array([1.0, POWER_LAW_REACH])
        radii = self.ends[side] + self.inwards[side] * distances
        near, far = weight(radii) * self.slopes(radii) ** power
        if not near * far > 0:
            return 0.0
        exponent = float(np.log(far / near) / np.log(POWER_LAW_REACH))
        if exponent < LEAST_POWER:
            return float(np.inf)
        return float(near * NEAREST / (1 + exponent))
