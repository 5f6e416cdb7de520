"""The flat punch under the force 1, full (Eqs. 10 and 11) or hollow, on any ground."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import (
    legder,
    legint,
    legmulx,
    legroots,
    legsub,
    legtrim,
    legval,
    legvander,
)

from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.ground.line_energy import flat_series, relative_stiffness
from ..meshes.radial import Array
from .annulus import FlatAnnulus, flat_annulus

# Eqs. 10 and 11, non-dimensional: d0 = F / (2 a E*) and p0 = F / (2 pi a^2)
D0, P0 = 0.5, 1 / (2 * np.pi)
# imaginary part below which a root counts as real
REAL_ROOT_TOLERANCE = 1e-7
# size of a negative pressure that counts as roundoff, relative to `P0`
PRESSURE_ROUNDOFF = 1e-8


@dataclass(frozen=True, eq=False)
class DiscSeries:
    """A full flat punch as a series, ``p = sum_j c_j P_2j(t) / t`` with ``t = sqrt(1 - r^2)``.

    On a homogeneous half-space the first term is all of it (Eq. 11).

    Parameters
    ----------
    indentation : indentation of the punch under the force 1
    coefficients : (J,) coefficients of the series; only the first term carries force
    """

    indentation: float
    coefficients: Array

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressure at radii (R,) of the face, which is infinite at the rim."""
        functions, factor = disc_functions(1 - radii, len(self.coefficients))
        return functions @ self.coefficients * factor

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force (N,) on each ring between edges (N+1,)."""
        integral = legval(_root(ring_edges), legint(self._in_all_degrees))
        return -2 * np.pi * np.diff(integral)

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring between edges (N+1,)."""
        radii = np.union1d(ring_edges, self._stationary_radii)
        pressures = self.pressure_at(radii)
        inner, outer = (
            np.searchsorted(radii, ring_edges[:-1]),
            np.searchsorted(radii, ring_edges[1:]),
        )
        on_rings = [pressures[first : last + 1] for first, last in zip(inner, outer, strict=True)]
        return np.array([ring.min() for ring in on_rings]), np.array(
            [ring.max() for ring in on_rings]
        )

    @property
    def _in_all_degrees(self) -> Array:
        """(2 J,) Legendre coefficients of the series, with zeros at odd degrees."""
        series = np.zeros(2 * len(self.coefficients))
        series[::2] = self.coefficients
        return series

    @property
    def _stationary_radii(self) -> Array:
        """Radii inside the punch at which the pressure S(t) / t is stationary: t S' = S."""
        series = self._in_all_degrees
        roots = legroots(legtrim(legsub(legmulx(legder(series)), series)))
        t = roots.real[
            (np.abs(roots.imag) < REAL_ROOT_TOLERANCE) & (roots.real > 0) & (roots.real < 1)
        ]
        return np.sqrt((1 - t) * (1 + t))


FlatPunch = DiscSeries | FlatAnnulus
"""A flat punch under the force 1."""


def disc_functions(to_rim: Array, count: int) -> tuple[Array, Array]:
    """Return ``P_2j(t)`` (..., count) and ``1 / t`` (...) at given distances from the rim."""
    root = np.sqrt(to_rim * (2 - to_rim))
    with np.errstate(divide="ignore"):
        return np.asarray(legvander(root, 2 * count - 2)[..., ::2]), 1 / root


@lru_cache(maxsize=512)
def flat_disc(ground: Ground = HALF_SPACE) -> DiscSeries:
    """Return the full flat punch, computed from the energy of its line density."""
    return DiscSeries(D0 / relative_stiffness(ground), P0 * np.array(flat_series(ground)))


@lru_cache(maxsize=512)
def presses_everywhere(ground: Ground, inner_radius: float = 0.0) -> bool:
    """Return whether the pressure of a flat punch on layers is positive on the whole face.

    A stiff layer on soft ground bends like a plate: only the rim of a flat punch touches it.
    """
    least, _ = flat_punch_of(inner_radius, ground).extremes_on(np.array([inner_radius, 1.0]))
    return bool(least[0] > -PRESSURE_ROUNDOFF * P0)


def flat_punch_of(inner_radius: float, ground: Ground = HALF_SPACE) -> FlatPunch:
    """Return the flat punch with a given inner radius, which is 0 for a full punch."""
    if inner_radius:
        return flat_annulus(inner_radius, ground=ground)
    return flat_disc(ground)


def _root(radii: Array) -> Array:
    """Return ``sqrt(1 - r^2)`` without cancellation."""
    return np.sqrt((1 - radii) * (1 + radii))
