"""Approximate a wear coefficient along the radius by many rings, which have closed forms."""

from typing import NamedTuple

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, unit_gauss
from .reading import Reading

# numbers of rings, for an extrapolation: the error is proportional to the inverse square of the
# number
FEW_RINGS, MANY_RINGS = 100, 200


class Extrapolated(NamedTuple):
    """Values that are extrapolated from two numbers of rings, and the change between the two.

    The change is much larger than the error of the value, so that it bounds the error.
    """

    value: Array
    change: Array

    @property
    def error(self) -> float:
        """Return a bound on the error of each value."""
        return float(np.abs(self.change).max())


def displace_by_many_rings(reading: Reading, radii: Array) -> tuple[Extrapolated, Extrapolated]:
    """Return the steady displacements (R,) at radii (R,), and the greatest steady displacement."""
    coarse, fine = (_displace_by_rings(reading, count, radii) for count in (FEW_RINGS, MANY_RINGS))
    displacement, greatest = (
        Extrapolated(last + (last - first) / 3, np.asarray(last - first))
        for first, last in zip(coarse, fine, strict=True)
    )
    return displacement, greatest


def _displace_by_rings(reading: Reading, count: int, at_radii: Array) -> tuple[Array, Array]:
    """Compute the steady displacements (R,) at radii (R,), and the greatest steady displacement.

    The steady pressure is replaced by its mean on each ring. The rings are `count` rings of
    `_even_edges`, divided at the ring edges of the scene and at the radii of its table.
    """
    kinks = np.array(reading.table["radii"]) / reading.units.length
    kinks = kinks[(kinks > reading.edges[0]) & (kinks < 1)]
    edges = np.union1d(_even_edges(reading, count), np.append(reading.edges, kinks))
    nodes, weights = unit_gauss(3)
    widths = np.diff(edges)[:, None]
    radii = edges[:-1, None] + widths * nodes
    pressures = 1 / (reading.inverse_wear.sum() * reading.wear_at(radii))
    means = np.sum(pressures * radii * weights * widths, axis=1) / (np.diff(edges**2) / 2)
    if reading.edges[0]:
        edges, means = np.append(0.0, edges), np.append(0.0, means)
    ground = reading.ground
    displacement = direct.displacement(edges, means, at_radii, ground)
    return displacement, direct.greatest_displacement(edges, means, ground)


def _even_edges(reading: Reading, count: int) -> Array:
    """Return the edges (count + 1,) of rings across which the wear coefficient k changes little.

    The width of a ring, in punch radii, plus the change of log k across it is the same for all
    rings. So k changes little in any of them, and no ring is much wider than the others.
    """
    even_radii = np.linspace(reading.edges[0], 1, 4001)
    radii = np.union1d(even_radii, reading.radii_of_even_wear())
    radii = radii[radii >= reading.edges[0]]
    changes = np.abs(np.diff(np.log(reading.wear_at(radii))))
    measure = np.append(0.0, np.cumsum(np.diff(radii) + changes))
    return np.interp(np.linspace(0, measure[-1], count + 1), measure, radii)
