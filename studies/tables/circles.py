"""Means over circles of values that a code or an instrument has on a grid."""

import numpy as np
import pandas as pd

from ...meshes import Array

# greatest number of circles of equal radius; points of more are put together in rings
MOST_CIRCLES = 500
# radii are equal up to this part of the greatest
ROUNDOFF = 1e-9


def on_circles(x: Array, y: Array, values: Array) -> tuple[Array, Array, float]:
    """Return the radii of circles (R,), the mean of values on each (R,), and their spread.

    The spread is the greatest difference of two values on one circle. If the points of a grid lie
    on more than `MOST_CIRCLES` circles, those of neighbouring circles are put together; they have
    their mean radius.

    Parameters
    ----------
    x, y, values : (n,) coordinates of points, and the value at each
    """
    radii = np.hypot(x, y)
    greatest = float(radii.max()) or 1.0
    rings = np.round(radii / greatest / ROUNDOFF)
    if len(np.unique(rings)) > MOST_CIRCLES:
        rings = np.round(radii / greatest * MOST_CIRCLES)
    circles = pd.DataFrame({"radius": radii, "value": values}).groupby(rings)
    means, spreads = circles.mean(), circles["value"].max() - circles["value"].min()
    return means["radius"].to_numpy(), means["value"].to_numpy(), float(spreads.max())
