"""Wear of a flat punch on grounds other than the half-space of the scene, roughly.

A layer on the half-space, and a half-space in plane strain: what another program may have modelled
instead. Pressures are constant on some 40 elements, displacements are taken at their middles, and
the history is exact in time. Non-dimensional: punch radius, plane strain modulus, force and ``a /
(E* k_max v0)`` are 1.

The layer is a closed form, which is quicker for one layer than the waves of `meshes/ground`; that
checks it (tests/unit/studies/test_grounds.py).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eig
from scipy.special import j0, j1

from ....mdr import direct
from ....meshes.radial import Array, gauss
from ...problem.face import Rings

# elements of a ring, at least, and of all rings together, at least
OF_A_RING, OF_ALL = 5, 40
# wave numbers times the thickness of a layer, beyond which the layer is all that is felt
THICKEST = 12.0
# Gauss points of wave numbers
WAVES = 200


def elements(ring_edges: Array) -> Array:
    """Return breakpoints (N+1,) from the first ring edge to the rim, dense beside every edge."""
    count = max(OF_A_RING, OF_ALL // (len(ring_edges) - 1))
    within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    inner, outer = ring_edges[:-1, None], ring_edges[1:, None]
    return np.append((inner + (outer - inner) * within).ravel(), 1.0)


def of_rings(breakpoints: Array) -> Array:
    """Return displacements (N, N) at middles of rings by unit pressures on each: Eq. 21."""
    middles = (breakpoints[1:] + breakpoints[:-1]) / 2
    discs = direct.disc_displacement(breakpoints, middles[:, None])
    return np.diff(discs, axis=1)


def of_strips(breakpoints: Array) -> Array:
    """Return displacements (N, N) in plane strain by unit pressures on strips on both sides.

    By a line force P it is ``-2 P / (pi E*) ln|x|``, and a constant that depends on the depth of
    the body (Johnson, Contact Mechanics, ch. 2).
    """
    middles = (breakpoints[1:] + breakpoints[:-1])[:, None] / 2

    def integral(distance: Array) -> Array:
        return distance * (np.log(np.abs(distance)) - 1)

    both = integral(middles - breakpoints) - integral(middles + breakpoints)
    return np.diff(2 / np.pi * both, axis=1)


def of_layer(breakpoints: Array, thickness: float, stiffness: float, ratio: float) -> Array:
    """Return by how much more (N, N) a half-space under a layer is displaced than one without.

    Parameters
    ----------
    thickness : of the layer, over the punch radius
    stiffness : shear modulus of the layer over that of the half-space
    ratio : Poisson's ratio of both

    Notes
    -----
    O'Sullivan and King, J. Tribol. 110 (1988) 235, for a layer that is bonded to the half-space,
    without friction: a wave of the pressure displaces its own half-space Phi times as much.
    """
    waves, weights = gauss(WAVES)
    # quadratic: most points at long waves
    depth, weights = THICKEST * (1 + waves) ** 2 / 4, weights * (1 + waves) / 2 * THICKEST
    kappa = (stiffness - 1) / (stiffness + 3 - 4 * ratio)
    of_ratios = 1 - 4 * (1 - ratio) / (1 + stiffness * (3 - 4 * ratio))
    twice, fourth = np.exp(-2 * depth), np.exp(-4 * depth)
    above = 1 + 4 * depth * kappa * twice - of_ratios * kappa * fourth
    below = 1 - (of_ratios + kappa + 4 * kappa * depth**2) * twice + of_ratios * kappa * fourth
    # of a homogeneous ground of the layer's modulus; what is left decays with the depth
    beyond = (above / below - 1) / stiffness
    number, weights = depth / thickness, weights / thickness
    middles = (breakpoints[1:] + breakpoints[:-1]) / 2
    discs = breakpoints * j1(number[:, None] * breakpoints) / number[:, None]
    more = 2 * (j0(np.outer(middles, number)) * (weights * beyond)) @ np.diff(discs, axis=1)
    return more + (1 / stiffness - 1) * of_rings(breakpoints)


@dataclass(frozen=True, eq=False)
class Ground:
    """What carries a flat punch, and the history of its wear under the force 1.

    Parameters
    ----------
    compliance : (N, N) displacement of each element by a unit pressure on each
    weights : (N,) force by unit pressures
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
        """Rates of decay (N,), shapes of pressure (N, N), and the start in them (N,).

        ``p' = -B (k p - d' 1)`` with the stiffness B, and no change of the force.
        """
        rigid = self._stiffness.sum(axis=1)
        whole = self.weights @ rigid
        start = rigid / whole
        steady = 1 / self.wear / (self.weights @ (1 / self.wear))
        falling = self._stiffness * self.wear
        falling = falling - np.outer(rigid, self.weights @ falling) / whole
        rates, shapes = eig(falling)
        amplitudes = np.linalg.solve(shapes, (start - steady).astype(complex))
        return np.maximum(rates.real, 0.0), shapes, amplitudes

    def history(self, times: Array) -> tuple[Array, Array, Array]:
        """Return pressures and worn heights (T, N), and the indentation (T,), at times."""
        rates, shapes, amplitudes = self._modes
        steady = 1 / self.wear / (self.weights @ (1 / self.wear))
        grown = np.outer(times, rates)
        left = np.exp(-grown) * amplitudes
        passed = np.where(grown > 1e-9, -np.expm1(-grown) / np.maximum(rates, 1e-300), 0.0)
        passed = np.where(grown > 1e-9, passed, times[:, None]) * amplitudes
        pressure = steady + (left @ shapes.T).real
        worn = self.wear * (np.outer(times, steady) + (passed @ shapes.T).real)
        rigid = self._stiffness.sum(axis=1)
        depth = (1 + worn @ (self.weights @ self._stiffness)) / (self.weights @ rigid)
        return pressure, worn, depth


def half_space(rings: Rings) -> Ground:
    """Return the half-space of the scene."""
    points = elements(rings.ring_edges)
    areas = np.pi * np.diff(points**2)
    return Ground(of_rings(points), areas, rings.at((points[1:] + points[:-1]) / 2))


def layered(rings: Rings, thickness: float, stiffness: float, ratio: float) -> Ground:
    """Return the half-space of the scene under a layer of another modulus."""
    ground, points = half_space(rings), elements(rings.ring_edges)
    more = of_layer(points, thickness, stiffness, ratio)
    return Ground(ground.compliance + more, ground.weights, ground.wear)


def plane_strain(rings: Rings) -> Ground:
    """Return a half-space in plane strain under the line force F / 2a, that is, the mean of 3D."""
    points = elements(rings.ring_edges)
    # so that the force 1 of a punch of unit radius is the line force 1/2
    widths = 4 * np.diff(points)
    return Ground(of_strips(points), widths, rings.at((points[1:] + points[:-1]) / 2))
