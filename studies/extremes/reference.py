"""What must come out at any parameters, by means that no method uses: for judging results far from the usual ones.

Displacements and slopes of discs are taken in Carlson's symmetric integrals, where the methods use Legendre's, and
integrated on geometric meshes, where direct integration substitutes powers. Scales are exact fractions. Natural units:
punch radius 1, modulus 1, force 1. The rings alternate, so that two patterns of pressure make every steady state.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from ringwear.meshes.radial import Array, Indices
from ringwear.studies.problem.scene import Scene
from scipy.optimize import minimize_scalar
from scipy.special import elliprd, elliprf

RATIO, LAYERS, NODES = 0.15, 15, 14  # 1e-10 in the RMS slope
SAMPLES = 9


@dataclass(frozen=True, eq=False)
class Rings:
    """Alternating rings under unit pressure on the odd ones, or on the even ones.

    Parameters
    ----------
    edges : (N+1,) 0 to 1
    """

    edges: Array

    @cached_property
    def _steps(self) -> Array:
        """(N, 2) pressure of the disc that ends at each ring edge, by pattern."""
        count = len(self.edges) - 1
        patterns = np.stack([np.arange(count) % 2 == 0, np.arange(count) % 2 == 1], axis=1).astype(float)
        return -np.diff(patterns, axis=0, append=0.0)

    @cached_property
    def areas(self) -> Array:
        """(2,) area under each pattern."""
        each = np.pi * np.diff(self.edges) * (self.edges[1:] + self.edges[:-1])
        return np.array([each[0::2].sum(), each[1::2].sum()])

    def displacement(self, radii: Array, gaps: Array | None = None) -> Array:
        """(n, 2) displacement at radii by each pattern."""
        larger, square, complement = self._moduli(radii, gaps)
        inside = radii[:, None] <= self.edges[1:]
        first, second = elliprf(0.0, complement, 1.0), elliprd(0.0, complement, 1.0)
        # inside c E(m); outside r (E - (1 - m) K) = r m (K - RD / 3)
        values = np.where(inside, larger * (first - square / 3 * second), larger * square * (first - second / 3))
        return 4 / np.pi * values @ self._steps

    def slope(self, radii: Array, gaps: Array) -> Array:
        """(n, 2) slope at radii by each pattern; `gaps` (n, N) are the distances to the ring edges."""
        _, square, complement = self._moduli(radii, gaps)
        inside = radii[:, None] <= self.edges[1:]
        values = np.where(inside, np.sqrt(square), square) * elliprd(0.0, complement, 1.0) / 3
        return -4 / np.pi * values @ self._steps

    def _moduli(self, radii: Array, gaps: Array | None) -> tuple[Array, Array, Array]:
        r, c = radii[:, None], self.edges[1:]
        larger = np.maximum(r, c)
        ratio = np.minimum(r, c) / larger
        gap = np.abs(r - c) if gaps is None else gaps
        return larger, ratio**2, np.maximum(gap / larger * (1 + ratio), 1e-300)

    @cached_property
    def _grams(self) -> tuple[Array, Array, Array]:
        """(2, 2) mean products of slopes, over the radius and over the area, and energies ``int u_i p_j dA``."""
        radii, nearest, gaps, weights, ring = self._quadrature()
        line, area, energy = (np.zeros((2, 2)) for _ in range(3))
        rows = max(1, 2**18 // len(self.edges))
        pattern = np.stack([ring % 2 == 0, ring % 2 == 1], axis=1).astype(float)
        for start in range(0, len(radii), rows):
            part = slice(start, start + rows)
            r, near = radii[part], np.abs(radii[part, None] - self.edges[1:])
            edge, gap = nearest[part], gaps[part]
            own = np.flatnonzero(edge > 0)
            near[own, edge[own] - 1] = gap[own]
            slopes, weight = self.slope(r, near), weights[part, None]
            line += slopes.T @ (weight * slopes)
            area += slopes.T @ (2 * r[:, None] * weight * slopes)
            energy += self.displacement(r, near).T @ (2 * np.pi * r[:, None] * weight * pattern[part])
        return line, area, energy

    def _quadrature(self) -> tuple[Array, Indices, Array, Array, Indices]:
        """Radii, nearest edges, distances to them, weights and rings: geometric layers towards every edge."""
        node, weight = np.polynomial.legendre.leggauss(NODES)
        ends = np.append(RATIO ** np.arange(LAYERS + 1.0), 0.0)
        middle, half = (ends[:-1] + ends[1:]) / 2, (ends[:-1] - ends[1:]) / 2
        unit, unit_weight = (middle[:, None] + half[:, None] * node).ravel(), (half[:, None] * weight).ravel()
        count, width = len(self.edges) - 1, np.diff(self.edges)[:, None] / 2
        gap = np.concatenate([width * unit, width * unit], axis=1)
        radii = np.concatenate([self.edges[:-1, None] + width * unit, self.edges[1:, None] - width * unit], axis=1)
        weights = np.concatenate([width * unit_weight] * 2, axis=1)
        ring = np.repeat(np.arange(count), gap.shape[1])
        edge = (np.arange(count)[:, None] + np.repeat([0, 1], len(unit))).ravel()
        return radii.ravel(), edge, gap.ravel(), weights.ravel(), ring

    def pressures(self, wear: Array) -> Array:
        """(2,) steady pressure of each pattern, by the wear coefficients of the first two rings."""
        both = np.array([wear[0], wear[1] if len(wear) > 1 else wear[0]])
        return 1 / both / np.sum(self.areas / both)

    def rms_slope(self, wear: Array, average: str) -> float:
        """RMS slope of the limiting profile."""
        line, area, _ = self._grams
        p = self.pressures(wear)
        return float(np.sqrt(p @ (line if average == "line" else area) @ p))

    def greatest_displacement(self, wear: Array) -> float:
        """Greatest steady displacement: sampled in every ring, then polished at the best places."""
        p = self.pressures(wear)
        radii, sampled = self._sampled
        values = sampled @ p
        found = [float(values.max())]
        for best in np.argsort(values)[-3:]:
            bounds = radii[max(best - 1, 0)], radii[min(best + 1, len(radii) - 1)]
            polished = minimize_scalar(
                lambda r: -float((self.displacement(np.array([r])) @ p)[0]), bounds=bounds, method="bounded",
                options={"xatol": 1e-12},
            )  # fmt: skip
            found.append(-float(polished.fun))
        return max(found)

    @cached_property
    def _sampled(self) -> tuple[Array, Array]:
        width = np.diff(self.edges)[:, None]
        radii = np.append((self.edges[:-1, None] + width * np.linspace(0, 1, SAMPLES)[:-1]).ravel(), 1.0)
        return radii, self.displacement(radii)

    def late_indentation(self, wear: Array, times: Array) -> Array:
        """Indentation when only the steady state is left: ``w t + int u p dA``."""
        p = self.pressures(wear)
        rate = wear[0] * p[0]
        return np.asarray(rate * times + p @ self._grams[2] @ p)


def units(scene: Scene) -> dict[str, float]:
    """Units of displacement, slope, time and wear rate of a scene, by exact fractions.

    Raises
    ------
    OverflowError
        if one of them is no double
    """
    punch, load, solid = scene.punch, scene.load_, scene.half_space
    radius, poisson = Fraction(punch.radius), Fraction(solid.poisson_ratio)
    modulus = Fraction(solid.plane_strain_modulus or 0) or Fraction(solid.youngs_modulus or 0) / (1 - poisson**2)
    force = Fraction(load.normal_force or 0) or Fraction(load.mean_pressure or 0) * Fraction(np.pi) * radius**2
    displacement = force / radius / modulus
    time = radius / modulus / Fraction(max(punch.wear_coefficients)) / Fraction(load.sliding_speed)
    exact = {"displacement": displacement, "slope": displacement / radius, "time": time, "wear_rate": displacement / time}
    return {name: float(value) for name, value in exact.items()}
