"""The time scale of running-in, known before a run: the slowest relaxation time, by a coarse MDR.

Deviations from the steady state decay in modes of the pencil ``A x = tau K x`` on the wear rates
that carry no force, with the compliance `A` and the mass `K` of weight `k`
(`studies/wear/archard.py`). The slowest is a long wave, for which a few elements in each ring are
enough.
"""

import numpy as np
from scipy.linalg import eigh, qr

from ...mdr.transforms import line_density, panel_quadrature
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import graded_breakpoints
from .problem import Rings

# degree, size at the rim and ratio of neighbouring sizes: a few digits; and a check of them, of
# more
COARSE, FINE = (3, 1e-3, 0.3), (6, 1e-6, 0.2)
# with more rings it would take longer than many a run
MOST_RINGS = 64


def slowest_relaxation_time(rings: Rings, sizes: tuple[int, float, float] = COARSE) -> float:
    """The slowest relaxation time, non-dimensional, to a few digits.

    NaN for more than `MOST_RINGS`.
    """
    degree, rim, grading = sizes
    rings = rings.merged()
    if len(rings.wear_coefficients) > MOST_RINGS:
        return float("nan")
    breakpoints = graded_breakpoints(
        rings.ring_edges, 0.2 * rings.narrower, min(rim, 0.1 * rings.widths[-1]), grading
    )
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), rings.ring_edges)
    worn = space.joined(rings.wear_coefficients)
    positions, weights = panel_quadrature(space)
    factor = np.sqrt(2 * weights)[:, None] * (line_density(space, positions) @ worn)
    mass = (worn.T @ space.mass(rings.wear_coefficients) @ worn).toarray()
    # an orthonormal basis of the wear rates that carry no force
    free = qr((worn.T @ space.weights)[:, None])[0][:, 1:]
    last = free.shape[1] - 1
    (slowest,) = eigh(
        (factor @ free).T @ (factor @ free),
        free.T @ mass @ free,
        eigvals_only=True,
        subset_by_index=[last, last],
    )
    return float(slowest)
