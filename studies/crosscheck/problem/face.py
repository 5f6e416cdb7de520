"""Define the rings of a punch, and the radii of its face at which fields are compared.

Non-dimensional. Each element between two breakpoints of the face has `POINTS` Gauss points. Values
at these are interpolated and differentiated by a polynomial of degree ``POINTS - 1``, whose last
Legendre coefficients estimate the error. In the elements at the rim and at a hole, the variable is
the square root of the distance from that edge, in which pressures of a flat punch are smooth.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, legval, legvander

from ....meshes.radial import (
    Array,
    Indices,
    alternating_edges,
    from_axis,
    gauss,
    ring_of,
    values_on_rings,
)

# Gauss points in each element of a face
POINTS = 8
# narrowest interval of a table of wear coefficients, in punch radii; narrower ones count as steps
NARROWEST_INTERVAL = 1e-9


def radial_weight(radii: Array, average: str, inner_radius: float) -> Array:
    """Return the weight of an average over the face at some of its radii.

    The average is over the radius (`line`) or over the area (`area`) of a face from `inner_radius`
    to 1.
    """
    if average == "line":
        return np.full(radii.shape, 1 / (1 - inner_radius))
    return 2 * radii / ((1 - inner_radius) * (1 + inner_radius))


class Rings(NamedTuple):
    """Rings of a punch.

    Values at edges are given for each of the M edges except the centre; the rim is the last.

    Parameters
    ----------
    ring_edges : (N+1,) array
        Edges from 0, or from the hole of a hollow punch, up to the rim at 1.
    wear_coefficients : (2, N) array
        Wear coefficients at the inner and outer edge of each ring, over the greatest one; linear
        between.
    """

    ring_edges: Array
    wear_coefficients: Array

    @classmethod
    def constant(cls, ring_edges: Array, wear_coefficients: Array) -> "Rings":
        """Return rings with one wear coefficient each, given as (N,)."""
        return cls(ring_edges, np.tile(wear_coefficients, (2, 1)))

    @classmethod
    def alternating(cls, count: int, width_ratio: float, wear_ratio: float) -> "Rings":
        """Return rings of two materials that alternate from the centre.

        The ratios are ``h2/h1`` of the widths and ``k2/k1`` of the wear coefficients.
        """
        coefficients = np.where(np.arange(count) % 2, wear_ratio, 1.0)
        return cls.constant(
            alternating_edges(count, width_ratio), coefficients / coefficients.max()
        )

    @classmethod
    def graded(cls, radii: Array, values: Array, ring_edges: Array) -> "Rings":
        """Return rings on which a table of wear coefficients is linear and at most doubles.

        Parameters
        ----------
        radii : (M,) array
            Radii that do not decrease; two equal ones are a step.
        values : (M,) array
            Wear coefficients at these radii, constant beyond the ends.
        ring_edges : (N+1,) array
            Ring edges of the scene, which are edges of the result, too.
        """
        new_edges, inner_edge = np.setdiff1d(ring_edges, radii), ring_edges[0]
        while True:
            places = np.searchsorted(radii, new_edges)
            values = np.insert(values, places, np.interp(new_edges, radii, values))
            radii = np.insert(radii, places, new_edges)
            widths = np.diff(radii)
            # narrower intervals count as steps
            wide_enough = widths > NARROWEST_INTERVAL
            steep = np.abs(np.diff(np.log2(values))) > 1
            halves_are_wide_enough = widths > 2 * NARROWEST_INTERVAL
            new_edges = (radii[:-1] + widths / 2)[halves_are_wide_enough & steep]
            if not len(new_edges):
                break
        # omit what lies in the hole
        wide_enough &= radii[:-1] >= inner_edge
        edges = np.array([inner_edge, *radii[:-1][wide_enough][1:], 1.0])
        return cls(edges, np.stack([values[:-1], values[1:]])[:, wide_enough])

    @property
    def linear(self) -> bool:
        """Whether the wear coefficient varies on a ring."""
        inner, outer = self.wear_coefficients
        return bool((inner != outer).any())

    @property
    def from_axis(self) -> Array:
        """(M+1,) edges from the axis on: 0, the radius of a hole, and the other ring edges."""
        return from_axis(self.ring_edges)

    def _at_edges(self, at_hole: float, at_outer_edges: Array) -> Array:
        """Return the values (M,) at edges, from those at the outer edges of rings (N,).

        `at_hole` is the value at the edge of a hole, if there is one.
        """
        return np.append(at_hole, at_outer_edges)[-np.count_nonzero(self.ring_edges) :]

    @property
    def smooth(self) -> Array:
        """(M,) whether graded wear is continuous at each edge except the centre."""
        inner, outer = self.wear_coefficients
        inside_rim = (outer[:-1] == inner[1:]) & self.linear
        return self._at_edges(False, np.append(inside_rim, False))

    @property
    def kinks(self) -> Array:
        """(M,) strength of the kink of the wear coefficient at each edge except the centre.

        At edges where the coefficient k is continuous, it is ``sqrt(|change of slope| * width /
        k)`` with the width of the narrower adjacent ring, and at most 1. At steps it is 1.
        """
        inner, outer = self.wear_coefficients
        slopes = (outer - inner) / self.widths
        narrower = np.minimum(self.widths[:-1], self.widths[1:])
        changes = np.abs(np.diff(slopes)) * narrower / outer[:-1]
        # square root: with layers chosen from it, the error estimate detects part of the effect
        strengths = self._at_edges(1.0, np.sqrt(np.minimum(np.append(changes, 1.0), 1.0)))
        return np.where(self.smooth, strengths, 1.0)

    @property
    def cone_at_axis(self) -> bool:
        """Whether graded wear has a slope at the axis, so that pressures have a conical point."""
        inner, outer = self.wear_coefficients[:, 0]
        return bool(self.ring_edges[0] == 0 and inner != outer)

    @property
    def wear_gradients(self) -> Array:
        """(M,) greatest ``|dk/dr| / k`` on the rings beside each edge but the centre.

        The steady pressure is proportional to 1 / k. If k is linear, 1 / k has a pole at the
        distance ``1 / gradient`` from the end of the ring with the smaller k.
        """
        inner, outer = self.wear_coefficients
        gradients = np.abs(outer - inner) / np.minimum(inner, outer) / self.widths
        beside = np.maximum(gradients, np.append(gradients[1:], 0.0))
        return self._at_edges(gradients[0], beside)

    @property
    def widths(self) -> Array:
        """(N,) width of each ring."""
        return np.diff(self.ring_edges)

    @property
    def narrower(self) -> Array:
        """(M-1,) width of the narrower ring, or hole, beside each edge between centre and rim."""
        widths = np.diff(self.from_axis)
        return np.minimum(widths[:-1], widths[1:])

    @property
    def widths_at_edges(self) -> Array:
        """(M,) `narrower`, and the width of the last ring at the rim."""
        return np.append(self.narrower, self.widths[-1])

    @property
    def wear_at_edges(self) -> tuple[Array, Array]:
        """Wear coefficients (M,) on the slower and on the faster side of each edge but the centre.

        The rim has one side only. In a hole, wear is infinitely fast.
        """
        inner, wear = self.wear_coefficients
        outside = np.append(inner[1:], wear[-1])
        slower, faster = np.minimum(wear, outside), np.maximum(wear, outside)
        return self._at_edges(inner[0], slower), self._at_edges(np.inf, faster)

    def at(self, radii: Array) -> Array:
        """Return the wear coefficient at each radius."""
        return values_on_rings(*self, radii, ring_of(self.ring_edges, radii))

    def merged(self) -> "Rings":
        """Return rings in which neighbours of equal, constant wear coefficients are merged."""
        inner, outer = self.wear_coefficients
        constant = inner == outer
        changes = ~(constant[:-1] & constant[1:]) | (outer[:-1] != inner[1:])
        first, last = np.append(True, changes), np.append(changes, True)
        edges = self.ring_edges[np.append(True, last)]
        return Rings(edges, np.stack([inner[first], outer[last]]))


@dataclass(frozen=True, eq=False)
class Face:
    """Radii at which fields are compared, with the weights of their norms.

    Parameters
    ----------
    breakpoints : (n+1,) array
        Ends of elements, from 0 or from the hole to 1; ring edges are among them.
    ring_edges : (N+1,) array
        Edges of the rings.
    wear_at : callable
        Returns wear coefficients at radii.
    standoff : float
        Indentation at the first touch. Displacements and heights are measured from there.
    """

    breakpoints: Array
    ring_edges: Array
    wear_at: Callable[[Array], Array]
    standoff: float = 0.0

    @cached_property
    def _local(self) -> Array:
        return gauss(POINTS)[0]

    @property
    def inner_radius(self) -> float:
        """The radius of the hole; 0 if there is none."""
        return float(self.breakpoints[0])

    @cached_property
    def radii(self) -> Array:
        """(R,) radii of the Gauss points, increasing."""
        inner, size = self.breakpoints[:-1, None], np.diff(self.breakpoints)[:, None]
        radii = inner + size * (1 + self._local) / 2
        radii[-1] = 1 - size[-1] * ((1 - self._local) / 2) ** 2
        if self.inner_radius:
            radii[0] = inner[0] + size[0] * ((1 + self._local) / 2) ** 2
        return radii.ravel()

    @cached_property
    def lengths(self) -> Array:
        """(R,) quadrature weights ``dr``."""
        size = np.diff(self.breakpoints)[:, None]
        lengths = size * gauss(POINTS)[1] / 2
        lengths[-1] *= 1 - self._local
        if self.inner_radius:
            lengths[0] *= 1 + self._local
        return lengths.ravel()

    @cached_property
    def areas(self) -> Array:
        """(R,) quadrature weights ``dA = 2 pi r dr``."""
        return 2 * np.pi * self.radii * self.lengths

    @property
    def edge_weights(self) -> Array:
        """(R,) factors ``1 - r^2``, times ``1 - b / r`` if there is a hole of radius b.

        With them, the square of the pressure of a flat punch is integrable.
        """
        rim_factor = (1 - self.radii) * (1 + self.radii)
        if not self.inner_radius:
            return rim_factor
        return rim_factor * (self.radii - self.inner_radius) / self.radii

    @cached_property
    def ring(self) -> Indices:
        """(R,) index of the ring of each radius."""
        return ring_of(self.ring_edges, self.radii)

    @cached_property
    def wear(self) -> Array:
        """(R,) wear coefficient at each radius."""
        return self.wear_at(self.radii)

    @cached_property
    def weights(self) -> Array:
        """(R,) weights ``k dA`` of norms of pressures."""
        return self.wear * self.areas

    def ring_sums(self, values: Array) -> Array:
        """Return the sums (T, N) of values (T, R) over each ring."""
        starts = np.flatnonzero(np.diff(self.ring, prepend=-1))
        return np.add.reduceat(values, starts, axis=-1)

    def _coefficients(self, values: Array) -> Array:
        """Return Legendre coefficients (POINTS, ..., n) of values (..., R) in each element."""
        inverse = np.linalg.inv(legvander(self._local, POINTS - 1))
        by_element = values.reshape(*values.shape[:-1], len(self.radii) // POINTS, POINTS)
        return np.moveaxis(by_element @ inverse.T, -1, 0)

    def interpolate(self, values: Array, radii: Array) -> tuple[Array, Array]:
        """Interpolate `values` (T, R) to radii (M,), and estimate the errors.

        The radii may not lie on the rim.

        Returns
        -------
        (T, M) array
            Interpolated values.
        (T, M) array
            Error estimates: sums of the absolute values of the last two Legendre coefficients in
            the element.
        """
        element = np.clip(
            np.searchsorted(self.breakpoints, radii, side="right") - 1, 0, len(self.breakpoints) - 2
        )
        size = np.diff(self.breakpoints)[element]
        local = 2 * (radii - self.breakpoints[element]) / size - 1
        at_rim = element == len(self.breakpoints) - 2
        local[at_rim] = 1 - 2 * np.sqrt((1 - radii[at_rim]) / size[at_rim])
        if self.inner_radius:
            at_hole = element == 0
            distance = np.maximum(radii[at_hole] - self.inner_radius, 0.0)
            local[at_hole] = 2 * np.sqrt(distance / size[at_hole]) - 1
        coefficients = self._coefficients(values)[..., element]
        values = np.einsum("j...m,mj->...m", coefficients, legvander(local, POINTS - 1))
        return values, np.abs(coefficients[-2:]).sum(axis=0)

    def slopes(self, values: Array) -> tuple[Array, Array]:
        """Return radial derivatives (T, R) of values (T, R), and less accurate ones (T, R).

        The second array omits the last two Legendre coefficients of each element. The difference
        of both estimates the error.
        """
        coefficients = self._coefficients(values)
        rates = 2 / np.repeat(np.diff(self.breakpoints), POINTS)
        # r = 1 - size (1 - s)^2 / 4 in the element at the rim
        rates[-POINTS:] /= 1 - self._local
        if self.inner_radius:
            rates[:POINTS] /= 1 + self._local
        slopes = []
        for count in (POINTS, POINTS - 2):
            parts = legval(self._local, legder(coefficients[:count]))
            slopes.append(parts.reshape(values.shape) * rates)
        return slopes[0], slopes[1]

    def integral_error(self, parts: Array) -> Array:
        """Return error estimates (T,) of integrals that are sums of `parts` (T, R) over the radii.

        Gauss quadrature is exact up to twice the degree of the polynomial. If Legendre coefficients
        decay geometrically, the coefficient of twice the degree is about the square of the last
        coefficient, divided by the greatest one.
        """
        weights = np.tile(gauss(POINTS)[1], len(self.breakpoints) - 1)
        coefficients = np.abs(self._coefficients(parts / weights))
        greatest = np.maximum(coefficients.max(axis=0), np.finfo(float).tiny)
        return (coefficients[-2:].sum(axis=0) ** 2 / greatest).sum(axis=-1)


@dataclass(frozen=True, eq=False)
class SampledFace(Face):
    """The face at given radii, which are its breakpoints.

    The area of each radius reaches half-way to its neighbours, as in the trapezoidal rule.

    Parameters
    ----------
    hole : float
        Radius of the hole; 0 if there is none. The given radii may begin outside of it.
    """

    hole: float = 0.0

    @property
    def inner_radius(self) -> float:
        """The radius of the hole; 0 if there is none."""
        return self.hole

    @cached_property
    def radii(self) -> Array:
        """(R,) given radii, increasing."""
        return self.breakpoints

    @cached_property
    def areas(self) -> Array:
        """(R,) area of the face assigned to each radius."""
        inner, outer = self.radii[:-1], self.radii[1:]
        between = np.concatenate([self.radii[:1], (inner + outer) / 2, self.radii[-1:]])
        return np.pi * np.diff(between**2) if len(inner) else np.ones(1)
