"""Direct integration in closed form.

Displacement, limiting profile and slope of ring-wise constant pressures.

A ring is a difference of two discs, and a uniformly loaded disc of radius c has (moduli, not
parameters)

    u = (4 p c / (pi E*)) E(r/c)                                    inside
    u = (4 p r / (pi E*)) [E(c/r) - (1 - c^2/r^2) K(c/r)]           outside
    du/dr = (4 p / (pi E*)) (E - K)(r/c) c/r inside, (E - K)(c/r) outside,

so Eq. 21 needs no quadrature in the steady state (Eq. 24). Slopes have logarithmic poles at ring
edges; their squares are integrated by a substitution that removes them (Eq. 18). Non-dimensional:
punch radius 1, modulus 1.

Eq. 25 of the paper integrates over the angle twice, beside its factor 2 pi; Eq. 26 is right.
"""

import numpy as np
from scipy.special import ellipe, ellipkm1

from ..meshes.radial import Array, ring_areas, unit_gauss

# measured: 4e-14 in the RMS gradient for rings of any width ratio from 0.1 to 10
EDGE_NODES = 24
PANEL_NODES, PANEL_RATIO = 18, 0.15
EDGE_POWER = 7
AT_ONCE = 2**16  # pairs of a radius and a disc evaluated together, few enough to stay in the cache

SMALL_MODULUS = (
    0.04  # square of r/c below which K - E is summed as a series, where the difference would cancel
)
SERIES_TERMS = 11


def ring_kernel(radius: Array, ring: Array) -> Array:
    """Eq.

    19: displacement at `radius` by a unit force on a thin ring, ``2 K(k) / (pi^2 (r + r_ring))``.
    """
    # by the complement of the parameter: no digits are lost as the radii meet
    complement = ((radius - ring) / (radius + ring)) ** 2
    return 2 * ellipkm1(complement) / (np.pi**2 * (radius + ring))


def steady_pressures(ring_edges: Array, wear_coefficients: Array, force: float = 1.0) -> Array:
    """Eqs. 24 and 26 for any rings: ``p_j = F / (k_j sum_i A_i / k_i)``."""
    return force / (wear_coefficients * np.sum(ring_areas(ring_edges) / wear_coefficients))


def disc_displacement(disc: Array, radius: Array) -> Array:
    """Displacement at `radius` by unit pressure on a disc; the arguments broadcast."""
    inside = radius <= disc
    ratio = np.where(inside, radius, disc) / np.where(inside, disc, radius)
    square = ratio**2
    e = ellipe(square)
    # (1 - m) K(m) tends to zero at the edge, where K itself is infinite
    complement = (1 - ratio) * (1 + ratio)
    outside = e - complement * ellipkm1(np.maximum(complement, np.finfo(float).tiny))
    return 4 / np.pi * np.where(inside, disc * e, radius * outside)


def disc_energies(discs: Array) -> Array:
    """(N, N) ``int u_a p_b dA`` of unit pressures on discs of radii a and b.

    The energy of one in the field of the other.
    """
    outer, inner = np.maximum(discs[:, None], discs), np.minimum(discs[:, None], discs)
    square = (inner / outer) ** 2
    complement = (outer - inner) * (outer + inner)
    # (a^2 - b^2) K tends to zero as the discs become one, where K itself is infinite
    second = complement * ellipkm1(np.maximum(complement / outer**2, np.finfo(float).tiny))
    return 8 / 3 * outer * ((outer**2 + inner**2) * ellipe(square) - second)


def disc_slope(disc: Array, radius: Array, gap: Array) -> Array:
    """Slope ``du/dr`` by unit pressure on a disc.

    `gap` is ``|radius - disc|``, given so that it may be tiny.
    """
    larger = np.maximum(radius, disc)
    ratio = np.minimum(radius, disc) / larger
    difference = _complete_difference(ratio**2, gap / larger * (1 + ratio))
    # inside, the formula divides by the ratio; at the axis the slope is zero
    divisor = np.where((radius <= disc) & (ratio > 0), ratio, 1.0)
    return -4 / np.pi * difference / divisor


def _complete_difference(square: Array, complement: Array) -> Array:
    """``K - E`` of the modulus squared `square`, whose `complement` to one is given so that it may
    be tiny.
    """
    with np.errstate(divide="ignore"):
        difference = np.asarray(ellipkm1(complement) - ellipe(square))
    small = square < SMALL_MODULUS
    difference[small] = np.polynomial.polynomial.polyval(square[small], _SERIES)
    return difference


def _difference_series() -> Array:
    """Coefficients of ``K - E`` in powers of the squared modulus.

    ``pi/2 [(2n-1)!!/(2n)!!]^2 2n/(2n-1)``.
    """
    n = np.arange(1, SERIES_TERMS + 1)
    return np.concatenate([[0.0], np.pi / 2 * np.cumprod(1 - 0.5 / n) ** 2 * n / (n - 0.5)])


_SERIES = _difference_series()


def displacement(ring_edges: Array, pressures: Array, radii: Array) -> Array:
    """Eq.

    21: displacement at `radii` by a constant pressure on each ring; (R,) or (R, M) by (N,) or (N,
    M) pressures.
    """
    steps, radii = pressure_steps(pressures), np.asarray(radii, dtype=float)[:, None]
    parts = np.array_split(radii, 1 + radii.size * len(steps) // AT_ONCE)
    return np.concatenate([disc_displacement(ring_edges[1:], part) @ steps for part in parts])


def slope(ring_edges: Array, pressures: Array, radii: Array) -> Array:
    """Slope ``du/dr`` at `radii` off the ring edges.

    The slope of the limiting profile is its negative.
    """
    radii = np.asarray(radii, dtype=float)[:, None]
    return disc_slope(ring_edges[1:], radii, np.abs(radii - ring_edges[1:])) @ pressure_steps(
        pressures
    )


def pressure_steps(pressures: Array) -> Array:
    """Pressures of the discs, one for each ring edge but the centre, whose sum is constant on
    rings.

    (N, ...) in, (N, ...) out.
    """
    outside = np.zeros_like(pressures[:1])
    return -np.diff(np.concatenate([pressures, outside]), axis=0)


def greatest_displacements(ring_edges: Array, pressures: Array) -> Array:
    """(M,) greatest displacement under the punch, ``u_max`` of Eq.

    27, to roundoff, by (N, M) pressures on its rings.
    """
    steps, each = pressure_steps(pressures), np.arange(pressures.shape[1])
    within = np.linspace(0, 1, 33)[:, None]
    radii = np.append((ring_edges[:-1] + np.diff(ring_edges) * within[:-1]).T.ravel(), 1.0)
    values = displacement(ring_edges, pressures, radii)
    radii = np.broadcast_to(radii[:, None], values.shape)
    for _ in range(2):
        # again between the neighbours of the greatest, sixteen times closer
        best = values.argmax(axis=0)
        low, high = (
            radii[np.maximum(best - 1, 0), each],
            radii[np.minimum(best + 1, len(radii) - 1), each],
        )
        radii = low + (high - low) * within
        values = np.einsum("rmn,nm->rm", disc_displacement(ring_edges[1:], radii[..., None]), steps)
    # and the top of the parabola through the last three
    best = np.clip(values.argmax(axis=0), 1, len(values) - 2)
    before, middle, after = values[best - 1, each], values[best, each], values[best + 1, each]
    rise, bend = after - before, 2 * middle - before - after
    above = np.divide(rise**2, 8 * bend, out=np.zeros(len(each)), where=np.abs(rise) < 2 * bend)
    return np.maximum(values.max(axis=0), middle + above)


def greatest_displacement(ring_edges: Array, pressures: Array) -> float:
    """`greatest_displacements` of one set of (N,) pressures."""
    return float(greatest_displacements(ring_edges, pressures[:, None])[0])


def limiting_profile(ring_edges: Array, pressures: Array, radii: Array) -> Array:
    """Eq. 27: ``f_stat = u_max - u``, zero where the punch has worn least."""
    return greatest_displacement(ring_edges, pressures) - displacement(ring_edges, pressures, radii)


def slope_gram(ring_edges: Array, patterns: Array) -> tuple[Array, Array]:
    """Mean products of the slopes of several ring-wise constant pressures.

    For `line` and `area` averages.

    Parameters
    ----------
    ring_edges : (N+1,) ring edges, 0 to 1
    patterns : (N, m) pressures

    Returns
    -------
    (m, m) matrices: ``p.T @ gram @ p`` is the squared RMS gradient (Eq. 18) of the pressure
    ``patterns @ p``, as an average over the radius and over the area.
    """
    radii, gaps, weights, edge = _edge_quadrature(ring_edges)
    steps = pressure_steps(patterns)
    line, area = (np.zeros((patterns.shape[1],) * 2) for _ in range(2))
    rows = max(1, AT_ONCE // len(steps))
    for start in range(0, len(radii), rows):
        part = slice(start, start + rows)
        r = radii[part, None]
        gap = np.abs(r - ring_edges[1:])
        row = np.arange(len(gap))
        own = edge[part] > 0
        gap[row[own], edge[part][own] - 1] = gaps[part][own]
        slopes = disc_slope(ring_edges[1:], r, gap) @ steps
        line += slopes.T @ (weights[part, None] * slopes)
        area += slopes.T @ (2 * r * weights[part, None] * slopes)
    return line, area


def _edge_quadrature(ring_edges: Array) -> tuple[Array, Array, Array, Array]:
    """Radii, distances to the nearest edge, weights and number of that edge, for log poles at every
    edge.

    Each ring is cut in the middle, and each half graded down to its neighbours' widths: a narrow,
    highly loaded ring is felt beside it over many times its width.
    """
    power_node, power_weight = unit_gauss(EDGE_NODES)
    power_gap, power_weight = (
        power_node**EDGE_POWER,
        EDGE_POWER * power_node ** (EDGE_POWER - 1) * power_weight,
    )
    node, weight = unit_gauss(PANEL_NODES)
    widths = np.diff(ring_edges)
    beside = np.concatenate([[np.inf], widths, [np.inf]])
    # halves of rings at their inner edge, then at their outer edge
    half = np.tile(widths / 2, 2)
    edge = np.concatenate([np.arange(len(widths)), np.arange(len(widths)) + 1])
    side = np.repeat([1.0, -1.0], len(widths))
    smallest = np.minimum(half, np.tile(np.minimum(beside[:-2], beside[2:]), 2))
    layers = np.maximum(0, np.ceil(np.log(smallest / half) / np.log(PANEL_RATIO) - 1e-9)).astype(
        np.int64
    )
    innermost = half * PANEL_RATIO**layers
    owner = np.repeat(np.arange(len(half)), layers)
    layer = np.arange(len(owner)) - np.repeat(np.cumsum(layers) - layers, layers)
    outer = half[owner] * PANEL_RATIO**layer
    panel = outer * (1 - PANEL_RATIO)
    gaps = np.concatenate(
        [np.outer(innermost, power_gap).ravel(), (outer - panel * (1 - node)[:, None]).T.ravel()]
    )
    weights = np.concatenate(
        [np.outer(innermost, power_weight).ravel(), np.outer(panel, weight).ravel()]
    )
    owners = np.concatenate(
        [np.repeat(np.arange(len(half)), EDGE_NODES), np.repeat(owner, PANEL_NODES)]
    )
    return ring_edges[edge[owners]] + side[owners] * gaps, gaps, weights, edge[owners]


def rms_slopes(ring_edges: Array, pressures: Array, average: str = "line") -> Array:
    """(M,) Eq.

    18 for the limiting profiles of (N, M) pressures; `average` is `line` (over the radius) or
    `area`.
    """
    # rings whose pressures keep one proportion throughout, such as those of one material, are one
    # pattern
    _, first, kind = np.unique(pressures, axis=0, return_index=True, return_inverse=True)
    if len(first) < pressures.shape[1]:
        patterns, parts = (
            np.asarray(kind.ravel()[:, None] == np.arange(len(first)), dtype=float),
            pressures[first],
        )
    else:
        patterns, parts = pressures, np.eye(pressures.shape[1])
    line, area = slope_gram(ring_edges, patterns)
    return np.asarray(
        np.sqrt(np.einsum("im,ij,jm->m", parts, {"line": line, "area": area}[average], parts))
    )


def rms_slope(ring_edges: Array, pressures: Array, average: str = "line") -> float:
    """`rms_slopes` of one set of (N,) pressures."""
    return float(rms_slopes(ring_edges, pressures[:, None], average)[0])
