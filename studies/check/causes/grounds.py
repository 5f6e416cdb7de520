"""Approximate wear of a flat punch on grounds other than the half-space of the scene.

The grounds are a layer on the half-space and a half-space in plane strain: what another program may
have modelled instead. Pressures are constant on about 40 elements, displacements are taken at the
middles of the elements, and the history is exact in time. Non-dimensional: punch radius, plane
strain modulus, force and ``a / (E* k_max v0)`` are 1.

The layer uses a closed form, which is faster for one layer than `meshes/ground`. The two are
compared in tests/unit/studies/check/test_grounds.py.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eig
from scipy.special import j0, j1

from ....mdr import direct
from ....meshes import Array, gauss
from ...crosscheck import Rings

# least number of elements on a ring, and about the least number on all rings together
MIN_RING_ELEMENTS, MIN_ELEMENTS = 5, 40
# greatest wave number times the thickness of the layer; shorter waves do not reach below the layer
MAX_WAVE_NUMBER = 12.0
# number of Gauss points over the wave numbers
WAVE_POINTS = 200


def elements(ring_edges: Array) -> Array:
    """Return breakpoints (N+1,) from the first ring edge to the rim, dense beside every edge."""
    count = max(MIN_RING_ELEMENTS, MIN_ELEMENTS // (len(ring_edges) - 1))
    fractions = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    inner, outer = ring_edges[:-1, None], ring_edges[1:, None]
    return np.append((inner + (outer - inner) * fractions).ravel(), 1.0)


def ring_compliance(breakpoints: Array) -> Array:
    """Return the displacements (N, N) at the middles of elements by unit pressures on each: Eq. 21.

    The elements are rings on a homogeneous half-space.
    """
    middles = (breakpoints[1:] + breakpoints[:-1]) / 2
    discs = direct.disc_displacement(breakpoints, middles[:, None])
    return np.diff(discs, axis=1)


def strip_compliance(breakpoints: Array) -> Array:
    """Return the displacements (N, N) in plane strain by unit pressures on pairs of strips.

    Each element is a strip on both sides of the middle plane. A line force P causes the
    displacement ``-2 P / (pi E*) ln|x|``, plus a constant that depends on the depth of the body and
    is left out (Johnson, Contact Mechanics, ch. 2).
    """
    middles = (breakpoints[1:] + breakpoints[:-1])[:, None] / 2

    def integral(distance: Array) -> Array:
        return distance * (np.log(np.abs(distance)) - 1)

    both_sides = integral(middles - breakpoints) - integral(middles + breakpoints)
    return np.diff(2 / np.pi * both_sides, axis=1)


def layer_compliance_change(
    breakpoints: Array, thickness: float, stiffness: float, ratio: float
) -> Array:
    """Return the change (N, N) of the compliance of a half-space if a layer is put on it.

    Parameters
    ----------
    thickness : of the layer, over the punch radius
    stiffness : shear modulus of the layer over that of the half-space
    ratio : Poisson's ratio of both

    Notes
    -----
    O'Sullivan and King, J. Tribol. 110 (1988) 235, for a layer that is bonded to the half-space,
    without friction: a pressure wave on the layer displaces the surface Phi times as much as on a
    half-space of the layer's material.
    """
    waves, weights = gauss(WAVE_POINTS)
    # wave number times thickness, quadratic in the Gauss points: most points are at long waves
    depth, weights = (
        MAX_WAVE_NUMBER * (1 + waves) ** 2 / 4,
        weights * (1 + waves) / 2 * MAX_WAVE_NUMBER,
    )
    kappa = (stiffness - 1) / (stiffness + 3 - 4 * ratio)
    ratio_term = 1 - 4 * (1 - ratio) / (1 + stiffness * (3 - 4 * ratio))
    exp_2, exp_4 = np.exp(-2 * depth), np.exp(-4 * depth)
    numerator = 1 + 4 * depth * kappa * exp_2 - ratio_term * kappa * exp_4
    denominator = (
        1 - (ratio_term + kappa + 4 * kappa * depth**2) * exp_2 + ratio_term * kappa * exp_4
    )
    # Phi - 1 over the stiffness: the difference to a half-space of the layer's modulus, which
    # decays with the wave number
    difference = (numerator / denominator - 1) / stiffness
    number, weights = depth / thickness, weights / thickness
    middles = (breakpoints[1:] + breakpoints[:-1]) / 2
    discs = breakpoints * j1(number[:, None] * breakpoints) / number[:, None]
    change = 2 * (j0(np.outer(middles, number)) * (weights * difference)) @ np.diff(discs, axis=1)
    return change + (1 / stiffness - 1) * ring_compliance(breakpoints)


@dataclass(frozen=True, eq=False)
class Ground:
    """A discretised ground under a flat punch, with the history of wear under the force 1.

    Parameters
    ----------
    compliance : (N, N) displacement of each element by a unit pressure on each
    weights : (N,) forces of unit pressures
    wear : (N,) wear coefficients
    """

    compliance: Array
    weights: Array
    wear: Array

    @cached_property
    def _stiffness(self) -> Array:
        return np.asarray(np.linalg.inv(self.compliance), dtype=float)

    @cached_property
    def _modes(self) -> tuple[Array, Array, Array]:
        """Rates of decay (N,), shapes of pressure (N, N), and amplitudes at the start (N,).

        They solve ``p' = -B (k p - d' 1)`` with the stiffness B, at a constant force.
        """
        rigid = self._stiffness.sum(axis=1)
        rigid_force = self.weights @ rigid
        start = rigid / rigid_force
        steady = 1 / self.wear / (self.weights @ (1 / self.wear))
        decay = self._stiffness * self.wear
        decay = decay - np.outer(rigid, self.weights @ decay) / rigid_force
        rates, shapes = eig(decay)
        amplitudes = np.linalg.solve(shapes, (start - steady).astype(complex))
        return np.maximum(rates.real, 0.0), shapes, amplitudes

    def history(self, times: Array) -> tuple[Array, Array, Array]:
        """Return pressures (T, N), worn heights (T, N) and indentations (T,) at times (T,)."""
        rates, shapes, amplitudes = self._modes
        steady = 1 / self.wear / (self.weights @ (1 / self.wear))
        exponent = np.outer(times, rates)
        decayed = np.exp(-exponent) * amplitudes
        # integrals of the decaying modes over time
        integral = np.where(exponent > 1e-9, -np.expm1(-exponent) / np.maximum(rates, 1e-300), 0.0)
        integral = np.where(exponent > 1e-9, integral, times[:, None]) * amplitudes
        pressure = steady + (decayed @ shapes.T).real
        worn = self.wear * (np.outer(times, steady) + (integral @ shapes.T).real)
        rigid = self._stiffness.sum(axis=1)
        depth = (1 + worn @ (self.weights @ self._stiffness)) / (self.weights @ rigid)
        return pressure, worn, depth


def half_space(rings: Rings) -> Ground:
    """Return the half-space of the scene."""
    points = elements(rings.ring_edges)
    areas = np.pi * np.diff(points**2)
    return Ground(ring_compliance(points), areas, rings.at((points[1:] + points[:-1]) / 2))


def layered(rings: Rings, thickness: float, stiffness: float, ratio: float) -> Ground:
    """Return the half-space of the scene with a layer on it: `layer_compliance_change`."""
    ground, points = half_space(rings), elements(rings.ring_edges)
    change = layer_compliance_change(points, thickness, stiffness, ratio)
    return Ground(ground.compliance + change, ground.weights, ground.wear)


def plane_strain(rings: Rings) -> Ground:
    """Return a half-space in plane strain under the line force F / 2a: F over the diameter."""
    points = elements(rings.ring_edges)
    # the force 1 of a punch of unit radius then is the line force 1/2
    widths = 4 * np.diff(points)
    return Ground(strip_compliance(points), widths, rings.at((points[1:] + points[:-1]) / 2))
