"""Recognise the sawtooth of a wear step that is longer than a mesh allows, in a table of pressures.

An update that is too long makes the pressure of a node jump up and down from row to row. Where
negative pressures are set to zero, the jumps saturate between zero and about twice the right
pressure, and the indentation remains right. The tables have consecutive updates. Non-dimensional.
"""

from dataclasses import dataclass

import numpy as np

from ...meshes import Array

ROWS = 10
"""Number of successive updates in which the pressure of a node has to alternate in a sawtooth."""
SMALL, STEADY_RATIO = 0.02, 0.97
"""Least size of jumps over the mean pressure, and least ratio of successive jumps: small ones must
not decay. Noise has the ratio 2/3."""
LARGE, LASTING_RATIO, LASTING_GROWTH = 0.1, 0.7, 0.85
"""The same for jumps that may be irregular but must last, and least size of the later ones over the
earlier ones."""
MODEL_ROWS = 40
"""Number of the last rows in which a sawtooth is sought, and to which models are compared."""
FEWEST_RADII = 3
"""Least number of radii of a table."""


@dataclass(frozen=True)
class Sawtooth:
    """Pressures that jump up and down from update to update.

    Parameters
    ----------
    size : of the jumps at the worst radius, over the mean pressure
    number : number of that radius
    step : mean step between the rows
    limit : the longest stable step of a mesh with nodes at the radii; NaN if none can be made
    element : element of that mesh
    """

    size: float
    number: int
    step: float
    limit: float = np.nan
    element: str = ""


def bends(values: Array, times: Array) -> Array:
    """Return half the distances (T - 2, ...) of values (T, ...) from lines through neighbours."""
    shares = (times[1:-1] - times[:-2]) / (times[2:] - times[:-2])
    shares = shares.reshape((-1,) + (1,) * (values.ndim - 1))
    return (values[1:-1] - (1 - shares) * values[:-2] - shares * values[2:]) / 2


def find(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the sawtooth in rows near the end of a table, without its limit; None without one.

    Far beyond the limit pressures are irregular, and some rows show it, but others do not.

    Parameters
    ----------
    times : (T,) increasing
    pressures : (T, R) pressures of nodes, from inside to outside
    mean : mean pressure
    """
    if pressures.shape[1] < FEWEST_RADII:
        return None
    ends = range(len(times), max(ROWS, len(times) - MODEL_ROWS) - 1, -ROWS // 2)
    windows = (slice(end - ROWS, end) for end in ends)
    found = (_in_rows(times[rows], pressures[rows], mean) for rows in windows)
    return next(filter(None, found), None)


def _in_rows(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the sawtooth in some rows, without its limit; None if there is none."""
    bent = bends(pressures, times)
    alternates = (bent[1:] * bent[:-1] < 0).all(axis=0)
    sizes = np.where(alternates, np.median(np.abs(bent), axis=0), 0.0) / mean
    number = int(sizes.argmax())
    near = bent[:, max(0, number - 1) : number + 2]
    squares, half = (near**2).sum(axis=1), len(near) // 2
    if not squares[:-1].sum() > 0 or not squares[:half].sum() > 0:
        return None
    ratio = -(near[1:] * near[:-1]).sum() / squares[:-1].sum()
    growth = np.sqrt(squares[-half:].sum() / squares[:half].sum())
    size = float(sizes[number])
    steady = size > SMALL and ratio > STEADY_RATIO
    lasting = size > LARGE and ratio > LASTING_RATIO and growth > LASTING_GROWTH
    if not (steady or lasting):
        return None
    return Sawtooth(size, number, float(np.diff(times).mean()))
