"""What states of the paper are told by, and gradients of limiting profiles in closed form.

All gradients are over that of the homogeneous punch. Many rings are seen from far as such a punch
and from near as strips of alternating pressure on a half-plane, whose slope is ``2/E*`` times the
Hilbert transform of the pressure and so has the mean square ``4 var(p)/E*^2``. With width fractions
``s1 + s2 = 1`` and the homogeneous gradient ``g0 p_mean/E*`` the limit of many rings is

    (gradient / homogeneous)^2 = 1 + (4/g0^2) s1 s2 ((p1 - p2) / (s1 p1 + s2 p2))^2.
"""

from functools import cache

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array
from ..sampling.sampler import AVERAGES

# of the way of the greatest displacement, by which Fig. 4 tells its states
PERCENTS = (0, 10, 30, 50, 70, 90, 100)
# part of the way at which the paper's run ends, t_stat: by its printed 27 % of the time for 70 %
STATIONARY = 0.984
# k2/k1 of Fig. 7, whose width ratio varies
WEAR_RATIO_OF_WIDTHS = 0.01


@cache
def homogeneous() -> Array:
    """Return the (2,) RMS gradients of the homogeneous punch under unit mean pressure."""
    edges, pressure = np.array([0.0, 1.0]), np.ones(1)
    return np.array([direct.rms_slope(edges, pressure, average) for average in AVERAGES])


def many_rings(wear_ratios: Array | float, width_ratios: Array | float) -> Array:
    """Return (2, M) normalised gradients in the limit of many rings, for ratios that broadcast."""
    first = 1 / (1 + width_ratios)
    contrast = (wear_ratios - 1) / (first * wear_ratios + 1 - first)
    return np.asarray(
        np.sqrt(1 + 4 * first * (1 - first) * contrast**2 / homogeneous()[:, None] ** 2)
    )
