"""The face of the punch: its rings, and many radii.

Norms of fields, and what follows from fields there. Non-dimensional.

Between its breakpoints the face has as many Gauss points as a polynomial of degree seven. Values at
them can so be interpolated and differentiated; the last coefficients of the polynomial say how far
that is to be trusted. At the rim, and at a hole, the points follow the root of the distance, in
which pressures of a flat punch are smooth.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, legval, legvander

from ...meshes.radial import Array, Indices, alternating_edges, gauss, ring_of, values_on_rings

POINTS = 8


class Rings(NamedTuple):
    """Rings of a punch: (N+1,) edges up to 1, and (N,) wear coefficients over the greatest.

    Where wear is graded, (2, N) at the inner and outer edge of each ring, linear between. The edges
    begin at 0, or at the hole of a hollow punch. What is modelled begins at 0: there a hole is a
    first ring that wears infinitely fast, so that it never carries in the steady state, and has no
    pressures at any time.
    """

    ring_edges: Array
    wear_coefficients: Array

    @classmethod
    def alternating(cls, count: int, width_ratio: float, wear_ratio: float) -> "Rings":
        """Return rings of two materials in turn from the centre, by ``h2/h1`` and ``k2/k1``."""
        coefficients = np.where(np.arange(count) % 2, wear_ratio, 1.0)
        return cls(alternating_edges(count, width_ratio), coefficients / coefficients.max())

    @classmethod
    def graded(cls, radii: Array, values: Array, ring_edges: Array) -> "Rings":
        """Return rings in which a table of wear coefficients is linear, and at most doubles.

        Parameters
        ----------
        radii : (M,) not decreasing, two equal ones at a step
        values : (M,) wear coefficients there, those of the ends beyond
        ring_edges : (N+1,) other edges
        """
        more, first = np.setdiff1d(ring_edges, radii), ring_edges[0]
        while True:
            places = np.searchsorted(radii, more)
            values = np.insert(values, places, np.interp(more, radii, values))
            radii = np.insert(radii, places, more)
            # anything narrower is a step
            wide = np.diff(radii) > 1e-9
            # on the axis it is a cone, beside which pressures are a logarithm
            steep = np.abs(np.diff(np.log2(values))) > np.where(radii[:-1] > 0, 1.0, 0.1)
            more = (radii[:-1] + np.diff(radii) / 2)[wide & steep]
            if not len(more):
                break
        # a hole is no part of the punch
        wide &= radii[:-1] >= first
        linear = np.stack([values[:-1], values[1:]])[:, wide]
        edges = np.array([first, *radii[:-1][wide][1:], 1.0])
        return cls(edges, linear if np.ptp(linear, axis=0).any() else linear[0])

    @property
    def ends(self) -> Array:
        """(2, N) wear coefficient at the inner and outer edge of each ring."""
        return np.broadcast_to(self.wear_coefficients, (2, len(self.widths)))

    @property
    def linear(self) -> bool:
        """Whether wear is graded."""
        return self.wear_coefficients.ndim == 2

    @property
    def hollow(self) -> bool:
        """Whether the first ring stands for a hole."""
        return bool(np.isinf(self.ends[0, 0]))

    def with_hole(self) -> "Rings":
        """Return the rings from the axis on, the hole first if there is one."""
        if self.ring_edges[0] == 0:
            return self
        wear = np.insert(self.wear_coefficients, 0, np.inf, axis=-1)
        return Rings(np.append(0.0, self.ring_edges), wear)

    @property
    def smooth(self) -> Array:
        """(N,) whether wear is continuous at each edge but the centre, if it is graded."""
        inner, outer = self.ends
        return np.append((outer[:-1] == inner[1:]) & self.linear, False)

    @property
    def kinks(self) -> Array:
        """(N,) how strong the kink of the wear coefficient is at each edge but the centre.

        Where wear is continuous it is the root of the change of its slope over the narrower ring
        beside the edge, over the coefficient there, and 1 at the most; elsewhere it is 1.
        """
        inner, outer = self.ends
        # a hole has no slope
        slopes = np.where(np.isinf(inner), 0.0, outer - np.where(np.isinf(inner), 0.0, inner))
        slopes = np.where(np.isinf(inner), 0.0, slopes / self.widths)
        changes = np.abs(np.diff(slopes)) * self.narrower / outer[:-1]
        # the estimate of the error sees a part of it only where layers grow with the root
        strengths = np.sqrt(np.minimum(np.append(changes, 1.0), 1.0))
        return np.where(self.smooth, strengths, 1.0)

    @property
    def widths(self) -> Array:
        """(N,) width of each ring."""
        return np.diff(self.ring_edges)

    @property
    def narrower(self) -> Array:
        """(N-1,) width of the narrower ring beside each edge between centre and rim."""
        return np.minimum(self.widths[:-1], self.widths[1:])

    def at(self, radii: Array) -> Array:
        """Wear coefficient at each radius."""
        return values_on_rings(*self, radii, ring_of(self.ring_edges, radii))

    def merged(self) -> "Rings":
        """Return the rings with neighbours of equal wear as one: what has to be modelled."""
        if self.linear:
            return self
        changes = np.flatnonzero(np.diff(self.wear_coefficients) != 0) + 1
        return Rings(self.ring_edges[[0, *changes, -1]], self.wear_coefficients[[0, *changes]])


@dataclass(frozen=True, eq=False)
class Face:
    """Radii that fields are compared at.

    Parameters
    ----------
    breakpoints : (n+1,) from 0, or from the hole, to 1, ring edges among them
    ring_edges : (N+1,) of the rings
    wear_at : wear coefficients by radii
    standoff : what displacements and heights are measured beyond: the indentation at the first
        touch
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
        """(R,) radii, increasing."""
        inner, size = self.breakpoints[:-1, None], np.diff(self.breakpoints)[:, None]
        radii = inner + size * (1 + self._local) / 2
        radii[-1] = 1 - size[-1] * ((1 - self._local) / 2) ** 2
        if self.inner_radius:
            radii[0] = inner[0] + size[0] * ((1 + self._local) / 2) ** 2
        return np.asarray(radii.ravel())

    @cached_property
    def lengths(self) -> Array:
        """(R,) the part ``dr`` of the radius that each stands for."""
        size = np.diff(self.breakpoints)[:, None]
        lengths = size * gauss(POINTS)[1] / 2
        lengths[-1] *= 1 - self._local
        if self.inner_radius:
            lengths[0] *= 1 + self._local
        return np.asarray(lengths.ravel())

    @cached_property
    def areas(self) -> Array:
        """(R,) the part ``dA`` of the face that each stands for."""
        return 2 * np.pi * self.radii * self.lengths

    @property
    def blunting(self) -> Array:
        """(R,) factors that make the square of a flat punch's pressure finite at its edges."""
        of_rim = (1 - self.radii) * (1 + self.radii)
        if not self.inner_radius:
            return np.asarray(of_rim)
        return np.asarray(of_rim * (self.radii - self.inner_radius) / self.radii)

    @cached_property
    def ring(self) -> Indices:
        """(R,) number of the ring that each is on."""
        return ring_of(self.ring_edges, self.radii)

    @cached_property
    def wear(self) -> Array:
        """(R,) wear coefficient of each."""
        return self.wear_at(self.radii)

    @cached_property
    def weights(self) -> Array:
        """(R,) ``k dA``: what norms of pressures are taken by."""
        return self.wear * self.areas

    def ring_sums(self, values: Array) -> Array:
        """Return the sum (T, N) over each ring of (T, R) values."""
        starts = np.flatnonzero(np.diff(self.ring, prepend=-1))
        return np.asarray(np.add.reduceat(values, starts, axis=-1))

    def _coefficients(self, values: Array) -> Array:
        """Return Legendre coefficients (POINTS, ..., n) of (..., R) values in each element."""
        inverse = np.linalg.inv(legvander(self._local, POINTS - 1))
        by_element = values.reshape(*values.shape[:-1], -1, POINTS)
        return np.moveaxis(by_element @ inverse.T, -1, 0)

    def interpolate(self, values: Array, radii: Array) -> tuple[Array, Array]:
        """Return (T, M) values at radii (M,) off the rim, and estimates (T, M) of their errors.

        The values are interpolated from `values` (T, R). An estimate is the sum of the absolute
        values of the last two Legendre coefficients in the element.
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
            apart = np.maximum(radii[at_hole] - self.inner_radius, 0.0)
            local[at_hole] = 2 * np.sqrt(apart / size[at_hole]) - 1
        coefficients = self._coefficients(values)[..., element]
        values = np.einsum("j...m,mj->...m", coefficients, legvander(local, POINTS - 1))
        return values, np.abs(coefficients[-2:]).sum(axis=0)

    def slopes(self, values: Array) -> tuple[Array, Array]:
        """Return (T, R) derivatives along the radius of (T, R) values, and less accurate ones.

        The second ones leave out the last two Legendre coefficients of each element.
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

    def integral_doubt(self, parts: Array) -> Array:
        """Return estimates (T,) of the errors of integrals that are sums of parts over the radii.

        `parts` (T, R) are the parts, one for each radius. Gauss's rule is exact up to twice the
        degree. If Legendre coefficients fall at a constant rate, the coefficient of that degree is
        the square of the last one over the greatest one.
        """
        weights = np.tile(gauss(POINTS)[1], len(self.breakpoints) - 1)
        coefficients = np.abs(self._coefficients(parts / weights))
        greatest = np.maximum(coefficients.max(axis=0), np.finfo(float).tiny)
        return np.asarray((coefficients[-2:].sum(axis=0) ** 2 / greatest).sum(axis=-1))


@dataclass(frozen=True, eq=False)
class SampledFace(Face):
    """The face at radii that somebody gives, its breakpoints.

    Each stands for the area from half-way to its neighbours, as in the rule of trapezoids.

    Parameters
    ----------
    hole : radius of the hole; 0 if there is none. The given radii may begin beyond it
    """

    hole: float = 0.0

    @property
    def inner_radius(self) -> float:
        """The radius of the hole; 0 if there is none."""
        return self.hole

    @cached_property
    def radii(self) -> Array:
        """(R,) radii that are given, increasing."""
        return self.breakpoints

    @cached_property
    def areas(self) -> Array:
        """(R,) area of the face that each radius stands for."""
        inner, outer = self.radii[:-1], self.radii[1:]
        between = np.concatenate([self.radii[:1], (inner + outer) / 2, self.radii[-1:]])
        return np.pi * np.diff(between**2) if len(inner) else np.ones(1)
