"""Approximate a wear coefficient along the radius by many rings, which have closed forms."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ....mdr import direct
from ....meshes.radial import Array, unit_gauss
from .reading import Reading

# number of rings, before they are divided where k has a kink; they are halved for an extrapolation,
# because the error is proportional to the square of their widths
RINGS = 100
# bound on the displacement that a step of the pressure between two rings adds at a single radius,
# over the step times the width of the narrower ring: twice the largest one in random scenes with
# narrow dips of k
BUMP_OF_STEP = 0.03


class Extrapolated(NamedTuple):
    """Values that are extrapolated from rings and halved rings, and the change between the two.

    The change is much larger than the error of the value, so that it bounds the error of means.
    At a single radius, a step of the pressure between two rings adds a bump.
    """

    value: Array
    change: Array
    bump: float

    @property
    def error(self) -> float:
        """Return a bound on the error of each value."""
        return float(np.abs(self.change).max()) + self.bump


def displace_by_many_rings(reading: Reading, radii: Array) -> Extrapolated:
    """Return the steady displacements (R,) at radii (R,)."""
    return _displace_at(reading, radii.tobytes())


# for a reading, which all methods share, there are radii of the output and radii of the face
@lru_cache(maxsize=2)
def _displace_at(reading: Reading, radii: bytes) -> Extrapolated:
    places = np.frombuffer(radii)

    def displace(edges: Array, pressures: Array) -> Array:
        return direct.displacement(edges, pressures, places, reading.ground)

    return _extrapolated(reading, displace)


@lru_cache(maxsize=1)
def greatest_by_many_rings(reading: Reading) -> Extrapolated:
    """Return the greatest steady displacement."""

    def greatest(edges: Array, pressures: Array) -> Array:
        return direct.greatest_displacement(edges, pressures, reading.ground)

    return _extrapolated(reading, greatest)


def _extrapolated(reading: Reading, compute: Callable[[Array, Array], Array]) -> Extrapolated:
    """Extrapolate what a function computes from the edges and pressures of rings."""
    coarse, fine = _rings_of(reading)
    first, last = (compute(rings.edges, rings.pressures) for rings in (coarse, fine))
    return Extrapolated(last + (last - first) / 3, last - first, BUMP_OF_STEP * coarse.step)


class _Rings(NamedTuple):
    """Edges (n+1,), pressures (n,), and the greatest step of the pressure between two rings.

    The step is multiplied by the width of the narrower ring.
    """

    edges: Array
    pressures: Array
    step: float


@lru_cache(maxsize=1)
def _rings_of(reading: Reading) -> tuple[_Rings, _Rings]:
    """Return the rings that replace the wear coefficient, and the same rings halved."""
    few = _even_edges(reading, RINGS)
    many = np.sort(np.concatenate([few, (few[1:] + few[:-1]) / 2]))
    return _mean_pressures(reading, few), _mean_pressures(reading, many)


def _mean_pressures(reading: Reading, edges: Array) -> _Rings:
    """Return rings between edges (n+1,), with the mean of the steady pressure on each."""
    nodes, weights = unit_gauss(3)
    widths = np.diff(edges)[:, None]
    radii = edges[:-1, None] + widths * nodes
    pressures = 1 / (reading.inverse_wear.sum() * reading.wear_at(radii))
    means = np.sum(pressures * radii * weights * widths, axis=1) / (np.diff(edges**2) / 2)
    narrower = np.minimum(widths[1:, 0], widths[:-1, 0])
    step = float(np.max(np.abs(np.diff(means)) * narrower, initial=0.0))
    return _Rings(edges, means, step)


def _even_edges(reading: Reading, count: int) -> Array:
    """Return the edges of rings across which the wear coefficient k changes little.

    The width of a ring, in punch radii, plus the change of log k across it is the same for `count`
    rings. So k changes little in any of them, and no ring is much wider than the others. They are
    divided at the ring edges of the scene and at the radii of its table.
    """
    even_radii = np.linspace(reading.edges[0], 1, 4001)
    radii = np.union1d(even_radii, reading.radii_of_even_wear())
    radii = radii[radii >= reading.edges[0]]
    changes = np.abs(np.diff(np.log(reading.wear_at(radii))))
    measure = np.append(0.0, np.cumsum(np.diff(radii) + changes))
    even = np.interp(np.linspace(0, measure[-1], count + 1), measure, radii)
    kinks = np.array(reading.table["radii"]) / reading.units.length
    kinks = kinks[(kinks > reading.edges[0]) & (kinks < 1)]
    return np.union1d(even, np.append(reading.edges, kinks))
