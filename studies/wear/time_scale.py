"""The time scale of running-in, before a run: the slowest relaxation time, by a coarse MDR.

The slowest mode is a long wave, for which a few elements in each ring are enough.
"""

from functools import lru_cache

import numpy as np

from ...mdr.transforms import line_density, panel_quadrature
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import graded_breakpoints
from ..problem.problem import Rings
from .modes import BandedCholesky, slowest_times

# with more rings it would take longer than many a run
MOST_RINGS = 64
# degree, size at the rim and ratio of neighbouring sizes: a few digits; and more, to check them
COARSE, FINE = (3, 1e-3, 0.3), (6, 1e-6, 0.2)


def slowest_relaxation_time(
    rings: Rings, fixed: bool, sizes: tuple[int, float, float] = COARSE
) -> float:
    """Return the slowest relaxation time, non-dimensional, to a few digits.

    Of pressures that carry no force, or of all at a fixed indentation. NaN for more than
    `MOST_RINGS`.
    """
    if len(rings.widths) > MOST_RINGS:
        return float("nan")
    return _slowest(tuple(rings.ring_edges), tuple(map(tuple, rings.ends)), fixed, sizes)


@lru_cache(maxsize=8)  # the anchors of every method ask for it
def _slowest(
    ring_edges: tuple[float, ...],
    wear_coefficients: tuple[tuple[float, ...], ...],
    fixed: bool,
    sizes: tuple[int, float, float],
) -> float:
    degree, rim, grading = sizes
    rings = Rings(np.array(ring_edges), np.array(wear_coefficients))
    breakpoints = graded_breakpoints(
        rings.ring_edges, 0.2 * rings.narrower, min(rim, 0.1 * rings.widths[-1]), grading
    )
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), rings.ring_edges)
    to_pressure = space.joined(rings.wear_coefficients)
    mass = to_pressure.T @ space.mass(rings.wear_coefficients) @ to_pressure
    positions, lengths = panel_quadrature(space)
    factor = np.sqrt(2 * lengths)[:, None] * (line_density(space, positions) @ to_pressure)
    weights = None if fixed else to_pressure.T @ space.weights
    return float(slowest_times(factor.T @ factor, BandedCholesky(mass), weights)[0])
