"""Closed forms by direct integration for pressures that are constant on each ring.

They give the displacement, the limiting profile and the slope.

A ring is a difference of two discs, and a uniformly loaded disc of radius c has (the arguments of E
and K are moduli, not parameters)

    u = (4 p c / (pi E*)) E(r/c)                                    inside
    u = (4 p r / (pi E*)) [E(c/r) - (1 - c^2/r^2) K(c/r)]           outside
    du/dr = (4 p / (pi E*)) (E - K)(r/c) c/r inside, (E - K)(c/r) outside,

so Eq. 21 needs no quadrature in the steady state (Eq. 24). Slopes have logarithmic singularities at
ring edges; their squares are integrated by a substitution that removes them (Eq. 18).
Non-dimensional: punch radius 1, modulus 1.

Eq. 25 of the paper integrates over the angle twice, in addition to its factor 2 pi; Eq. 26 is
correct.
"""

from typing import Any

import numpy as np
from scipy.special import ellipe, ellipkm1, elliprd

from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import (
    Array,
    from_axis,
    ring_areas,
    unit_gauss,
)
from .layers import added_displacement, added_slope

# number of (radius, disc) pairs that are evaluated together, small enough for the cache
PAIRS_PER_BLOCK = 2**16
# number of Gauss points in each element, for slopes
POINTS = 24
# Radii on each cell of a ring, and bisections, in the search for the greatest displacement. Cells
# are no wider than the first layer is thick.
SAMPLES_PER_CELL, BISECTIONS = 33, 30


def steady_pressures(ring_edges: Array, wear_coefficients: Array) -> Array:
    """Return the steady pressures (N,) of Eqs. 24 and 26 for any rings under the force 1.

    The pressure on ring j is ``p_j = F / (k_j sum_i A_i / k_i)`` with the force F, the wear
    coefficients k and the ring areas A.
    """
    return 1 / (wear_coefficients * np.sum(ring_areas(ring_edges) / wear_coefficients))


def disc_displacement(disc: Array, radius: Array) -> Array:
    """Return the displacement at `radius` under unit pressure on a disc; arguments broadcast."""
    ratio = np.minimum(radius, disc) / np.maximum(radius, disc)
    elliptic_e = ellipe(ratio**2)
    # (1 - m) K(m) tends to zero at the edge, where K itself is infinite
    complement = (1 - ratio) * (1 + ratio)
    outside_factor = elliptic_e - complement * ellipkm1(
        np.maximum(complement, np.finfo(float).tiny)
    )
    return 4 / np.pi * np.where(radius <= disc, disc * elliptic_e, radius * outside_factor)


def disc_slope(disc: Array, radius: Array, gap: Array | None = None) -> Array:
    """Return the slope ``du/dr`` at `radius` under unit pressure on a disc; arguments broadcast.

    Parameters
    ----------
    disc : radii of the discs
    radius : radii at which the slope is evaluated
    gap : ``|radius - disc|``, to be given if the difference of the two has too few digits

    Notes
    -----
    ``K - E = m/3 R_D(0, 1 - m, 1)`` with the parameter m: Carlson's integral has no cancellation at
    small m. On the edge of the disc, where the slope is infinite, a large number is returned.
    """
    larger = np.maximum(radius, disc)
    ratio = np.minimum(radius, disc) / larger
    gap = np.abs(radius - disc) if gap is None else gap
    complement = np.maximum(gap / larger * (1 + ratio), 1e-32)
    # inside the disc, K - E is divided by the ratio
    scale = np.where(radius <= disc, ratio, ratio**2)
    return -4 / (3 * np.pi) * scale * elliprd(0.0, complement, 1.0)


def displacement(
    ring_edges: Array, pressures: Array, radii: Array, ground: Ground = HALF_SPACE
) -> Array:
    """Return the displacement under a constant pressure on each ring: Eq. 21.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    pressures : (N,) or (N, M)
    radii : (R,)
    ground : layers, which add a Hankel integral

    Returns
    -------
    (R,) or (R, M)
    """
    discs, steps = pressure_steps(ring_edges, pressures)
    radii = np.asarray(radii, dtype=float)
    blocks = np.array_split(radii[:, None], 1 + radii.size * len(steps) // PAIRS_PER_BLOCK)
    values = np.concatenate([disc_displacement(discs, block) @ steps for block in blocks])
    return values + added_displacement(ring_edges, steps, radii, ground)


def pressure_steps(ring_edges: Array, pressures: Array) -> tuple[Array, Array]:
    """Return discs, and pressures on them, that add up to a constant pressure on each ring.

    There is one disc for each ring edge except the centre. Ring pressures (N, ...) give radii of
    discs (M,) and disc pressures (M, ...).
    """
    no_pressure = np.zeros_like(pressures[:1])
    steps = -np.diff(np.concatenate([no_pressure, pressures, no_pressure]), axis=0)
    return ring_edges[ring_edges > 0], steps[ring_edges > 0]


def greatest_displacement(ring_edges: Array, pressures: Array, ground: Ground = HALF_SPACE) -> Any:
    """Return the greatest displacement under the punch, ``u_max`` of Eq. 27.

    For ring pressures (N,) it is a number; for pressures (N, M) of M states it is (M,).
    """
    states = pressures.reshape(len(pressures), -1)
    linear = np.ones(len(ring_edges) - 1, dtype=np.int64)
    whole = PressureSpace(ring_edges, linear, ring_edges)
    cells = whole.no_wider(ground.first_thickness).breakpoints
    radii = np.unique(np.linspace(cells[:-1], cells[1:], SAMPLES_PER_CELL))
    values = displacement(ring_edges, states, radii, ground)
    (discs, steps), best = pressure_steps(ring_edges, states), values.argmax(axis=0)
    low, high = radii[np.maximum(best - 1, 0)], radii[np.minimum(best + 1, len(radii) - 1)]
    # the slope changes its sign between the neighbours of the greatest value: bisect
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        slopes = disc_slope(discs, middle[:, None]) @ steps
        slopes += added_slope(ring_edges, steps, middle, ground)
        # each state at its own radius
        rises = slopes.diagonal() > 0
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
    top = displacement(ring_edges, states, low, ground).diagonal()
    greatest = np.maximum(values.max(axis=0), top)
    return greatest.reshape(pressures.shape[1:])[()]


def limiting_profile(ring_edges: Array, pressures: Array, radii: Array) -> Array:
    """Return the limiting profile of Eq. 27, ``f_stat = u_max - u``.

    It is zero at the point that has worn least.
    """
    return greatest_displacement(ring_edges, pressures) - displacement(ring_edges, pressures, radii)


def slopes_everywhere(
    ring_edges: Array, pressures: Array, ground: Ground = HALF_SPACE
) -> tuple[Array, Array, Array]:
    """Return a quadrature on the face, and the slopes of the displacement at its points.

    The radii and weights of the quadrature are (R,) each. The slopes under a constant pressure on
    each ring are (R,) for pressures (N,), or (R, M) for pressures (N, M).

    Notes
    -----
    Each ring is divided in the middle, and each half is graded down to the width of its neighbour,
    because a narrow, highly loaded ring affects the slope over many times its width. The seventh
    power of the Gauss points smooths the logarithms at ring edges. The relative error of RMS
    gradients is 4e-14 for width ratios from 0.1 to 10.
    """
    widths, factor = np.diff(from_axis(ring_edges)), 0.15
    sizes = np.minimum(widths, np.append(widths[1:], np.inf)) * factor**0.5
    graded = PressureSpace.graded(ring_edges, sizes, factor, 1, axis_size=1.0)
    breakpoints = graded.no_wider(2 * ground.first_thickness).breakpoints
    left, right, width = breakpoints[:-1], breakpoints[1:], np.diff(breakpoints)[:, None]
    from_left, node, weight = np.isin(left, ring_edges), *unit_gauss(POINTS)
    at_edge = (from_left | np.isin(right, ring_edges))[:, None]
    start, offsets = np.where(from_left, left, right), width * np.where(at_edge, node**7, node)
    offsets[~from_left] *= -1
    radii = start[:, None] + offsets
    weights = width * np.where(at_edge, 7 * node**6, 1.0) * weight
    discs, steps = pressure_steps(ring_edges, pressures)
    slopes = []
    for block in np.array_split(
        np.arange(len(start)), 1 + radii.size * len(steps) // PAIRS_PER_BLOCK
    ):
        # near an edge the radii have too few digits, so that distances are not computed as their
        # differences
        gaps = np.abs((start[block, None] - discs)[:, None] + offsets[block, :, None])
        slopes.append(disc_slope(discs, radii[block, :, None], gaps) @ steps)
    values = np.concatenate(slopes).reshape(-1, *steps.shape[1:])
    values += added_slope(ring_edges, steps, radii.ravel(), ground)
    return radii.ravel(), weights.ravel(), values


def rms_slope(
    ring_edges: Array,
    pressures: Array,
    average: str = "line",
    ground: Ground = HALF_SPACE,
) -> Any:
    """Return the RMS gradients of the limiting profiles of (N,) or (N, M) pressures: Eq. 18.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    pressures : (N,) or (N, M) pressure on each ring
    average : `line` (over the radius) or `area`
    ground : layers
    """
    radii, weights, slopes = slopes_everywhere(ring_edges, pressures, ground)
    inner_radius = ring_edges[0]
    weights = weights / (1 - inner_radius)
    if average == "area":
        weights = 2 * radii * weights / (1 + inner_radius)
    return np.sqrt(weights @ slopes**2)
