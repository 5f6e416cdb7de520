"""The steady state at any parameters, by means that no method uses. Non-dimensional.

Displacements of discs are taken in Carlson's symmetric integrals, where direct integration uses
Legendre's; slopes of discs, in Carlson's as there, are integrated on geometric meshes, where direct
integration substitutes powers.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import minimize_scalar
from scipy.special import elliprd, elliprf

from ...meshes.radial import Array


@dataclass(frozen=True, eq=False)
class SteadyRings:
    """Rings that alternate, so that two patterns make every steady state: unit pressure on the odd
    ones, or the even ones.

    Parameters
    ----------
    ring_edges : (N+1,) 0 to 1
    """

    ring_edges: Array

    @cached_property
    def _patterns(self) -> Array:
        """(N, 2) pressure on each ring."""
        return np.eye(2)[np.arange(len(self.ring_edges) - 1) % 2]

    def pressures(self, wear_coefficients: Array) -> Array:
        """Return the steady pressure (2,) of each pattern by wear coefficients of the rings."""
        inner, outer = self.ring_edges[:-1], self.ring_edges[1:]
        areas = np.pi * (outer - inner) * (outer + inner) @ self._patterns
        two = np.resize(wear_coefficients, 2)
        return np.asarray(1 / two / np.sum(areas / two))

    def fields(self, radii: Array, distances: Array | None = None) -> tuple[Array, Array]:
        """Return displacements and slopes (n, 2) of the patterns at radii (n,).

        `distances` (n, N) to the ring edges, if differences of radii lose digits.
        """
        r, c = radii[:, None], self.ring_edges[1:]
        larger, inside = np.maximum(r, c), r <= c
        ratio = np.minimum(r, c) / larger
        distances = np.abs(r - c) if distances is None else distances
        complement, square = np.maximum(distances / larger * (1 + ratio), 1e-300), ratio**2
        first, second = elliprf(0.0, complement, 1.0), elliprd(0.0, complement, 1.0) / 3
        # inside c E(m); outside r (E - (1 - m) K) = r m (K - RD / 3)
        displacements = larger * np.where(
            inside, first - square * second, square * (first - second)
        )
        slopes = -np.where(inside, ratio, square) * second
        # a disc ends at each ring edge, under the step of pressure there
        discs = -4 / np.pi * np.diff(self._patterns, axis=0, append=0.0)
        return displacements @ discs, slopes @ discs

    @cached_property
    def grams(self) -> tuple[Array, Array]:
        """(2, 2) mean products of slopes over the radius, and energies ``int u_i p_j dA``.

        Layers towards every edge.
        """
        node, weight = leggauss(14)  # with these layers 1e-10 in the RMS slope
        ends = np.append(0.15 ** np.arange(16.0), 0.0)[:, None]
        middle, half = (ends[:-1] + ends[1:]) / 2, (ends[:-1] - ends[1:]) / 2
        unit, unit_weight = (middle + half * node).ravel(), (half * weight).ravel()
        slope_gram, energy = np.zeros((2, 2)), np.zeros((2, 2))
        for ring, width in enumerate(np.diff(self.ring_edges) / 2):
            for edge, away in ((ring, width), (ring + 1, -width)):
                radii, weights = self.ring_edges[edge] + away * unit, width * unit_weight
                distances = np.abs(radii[:, None] - self.ring_edges[1:])
                if edge:
                    distances[:, edge - 1] = width * unit
                displacements, slopes = self.fields(radii, distances)
                slope_gram += slopes.T @ (weights[:, None] * slopes)
                energy[:, ring % 2] += (2 * np.pi * radii * weights) @ displacements
        return slope_gram, energy

    def greatest_displacement(self, pressures: Array) -> float:
        """Return the greatest steady displacement.

        Sampled at four places in every ring, then polished at the best places.
        """

        def negative(radius: float) -> float:
            return -float(self.fields(np.array([radius]))[0][0] @ pressures)

        inner, widths = self.ring_edges[:-1, None], np.diff(self.ring_edges)[:, None]
        radii = np.append(inner + widths * np.arange(4) / 4, 1.0)
        values = self.fields(radii)[0] @ pressures
        greatest = values.max()
        for best in np.argsort(values)[-3:]:
            ends = radii[[max(best - 1, 0), min(best + 1, len(radii) - 1)]]
            options = {"xatol": 1e-12}
            top = minimize_scalar(negative, bounds=ends, method="bounded", options=options)
            greatest = max(greatest, -top.fun)
        return float(greatest)
