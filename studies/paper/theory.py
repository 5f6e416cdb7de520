"""Define the states of the paper, and compute gradients of limiting profiles in closed form.

All gradients are normalised by that of the homogeneous punch. On the scale of the punch, many rings
act like the homogeneous punch. On the scale of a ring, they act like strips of alternating pressure
on a half-plane, whose slope is ``2/E*`` times the Hilbert transform of the pressure and therefore
has the mean square ``4 var(p)/E*^2``. With width fractions ``s1 + s2 = 1`` and the homogeneous
gradient ``g0 p_mean/E*``, the limit of many rings is

    (gradient / homogeneous)^2 = 1 + (4/g0^2) s1 s2 ((p1 - p2) / (s1 p1 + s2 p2))^2.
"""

from functools import cache

import numpy as np

from ...mdr import direct
from ...meshes import Array
from ..crosscheck import AVERAGES

# states of Fig. 4: percentages of the total change of the greatest displacement
STATE_PERCENTAGES = (0, 10, 30, 50, 70, 90, 100)
# fraction of this change at which the paper's run ends (t_stat); it follows from the printed 27 %
# of the time for 70 % of the change
STATIONARY_FRACTION = 0.984
# k2/k1 of Fig. 7, in which the width ratio varies
FIG7_WEAR_RATIO = 0.01


@cache
def homogeneous() -> Array:
    """Return RMS gradients (2,) of the homogeneous punch, line and area, for mean pressure 1."""
    edges, pressure = np.array([0.0, 1.0]), np.ones(1)
    return np.array([direct.rms_slope(edges, pressure, average) for average in AVERAGES])


def many_rings(wear_ratios: Array | float, width_ratios: Array | float) -> Array:
    """Return the normalised gradients (2, M), line and area, in the limit of many rings.

    Parameters
    ----------
    wear_ratios, width_ratios : ratios k2/k1 and h2/h1, of shapes that broadcast to (M,)
    """
    # fraction of the width that belongs to the first material, s1
    fraction = 1 / (1 + width_ratios)
    contrast = (wear_ratios - 1) / (fraction * wear_ratios + 1 - fraction)
    return np.sqrt(1 + 4 * fraction * (1 - fraction) * contrast**2 / homogeneous()[:, None] ** 2)
