"""The gradient of the limiting profile against wear ratio and width ratio: Figs. 6 and 7.

Two materials alternate, so the steady pressure is ``p1`` on odd rings and ``p2 = p1 k1/k2`` on even
ones, and the squared gradient is a quadratic form in the two: three numbers for each punch and
average, whatever the wear ratio. Finite elements need one condensation. All gradients are over that
of the homogeneous punch.

Many rings are seen from far as a homogeneous punch and from near as strips of alternating pressure
on a half-plane, whose slope is ``2/E*`` times the Hilbert transform of the pressure and so has the
mean square ``4 var(p)/E*^2``. With width fractions ``s1 + s2 = 1`` and the homogeneous gradient
``g0 p_mean/E*`` the limit of many rings is

    (gradient / homogeneous)^2 = 1 + (4/g0^2) s1 s2 ((p1 - p2) / (s1 p1 + s2 p2))^2.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import xarray

from ...mdr import direct
from ...meshes.compliance import Compliance
from ...meshes.radial import Array, alternating_edges, ring_areas
from ..methods.pipeline import compliance_method
from ..methods.sampler import AVERAGES, Sampler
from ..problem.problem import Problem, Rings
from ..progress import Stages, progress
from ..wear.full_contact import RunningIn

# k2/k1 of Fig. 7, whose width ratio varies
WEAR_RATIO_OF_WIDTHS = 0.01


def figure_ratios(figure: int) -> tuple[Array, Array]:
    """Return (201,) k2/k1 and h2/h1 of the points of Fig. 6 or 7."""
    ratios = np.linspace(-1, 1, 201)
    constant = np.ones(201)
    if figure == 6:
        return 10.0 ** (4 * ratios), constant
    return WEAR_RATIO_OF_WIDTHS * constant, 10.0**ratios


def odd_and_even(count: int) -> Array:
    """Return (N, 2) patterns: 1 on odd rings (1st, 3rd, ... from the centre), and on even ones."""
    even = np.arange(count) % 2
    return np.stack([1.0 - even, even], axis=1)


def relative_pressures(wear_ratios: Array) -> Array:
    """Return (2, M) steady pressures of odd and even rings over the greater of them (Eq. 24).

    Wear ratios may be zero and infinite.
    """
    with np.errstate(divide="ignore"):
        return np.stack([np.minimum(wear_ratios, 1.0), np.minimum(1 / wear_ratios, 1.0)])


@cache
def homogeneous() -> Array:
    """Return the (2,) RMS gradients of the homogeneous punch under unit mean pressure."""
    edges, pressure = np.array([0.0, 1.0]), np.ones(1)
    return np.array([direct.rms_slope(edges, pressure, average) for average in AVERAGES])


def direct_gradients(ring_edges: Array, wear_ratios: Array) -> Array:
    """Return (2, M) normalised gradients of alternating rings by direct integration."""
    patterns = odd_and_even(len(ring_edges) - 1)
    pressures = relative_pressures(wear_ratios)
    pressures = pressures / (ring_areas(ring_edges) @ patterns @ pressures)
    radii, line, slopes = direct.slopes_everywhere(ring_edges, patterns)
    # products of the slopes, averaged over the radius and over the area
    grams = np.array([slopes.T @ (mean[:, None] * slopes) for mean in (line, 2 * radii * line)])
    squares = np.einsum("im,aij,jm->am", pressures, grams, pressures)
    return np.asarray(np.sqrt(squares) * np.pi / homogeneous()[:, None])


def many_rings(wear_ratios: Array, width_ratios: Array) -> Array:
    """Return (2, M) normalised gradients in the limit of many rings, for ratios that broadcast."""
    first = 1 / (1 + width_ratios)
    odd, even = relative_pressures(wear_ratios)
    contrast = (odd - even) / (first * odd + (1 - first) * even)
    return np.asarray(
        np.sqrt(1 + 4 * first * (1 - first) * contrast**2 / homogeneous()[:, None] ** 2)
    )


@cache
def condense(problem: Problem, count: int, width_ratio: float) -> Compliance:
    """Return the compliance of finite elements: one condensation serves all wear ratios.

    Measured: gradients within 3e-4 for 64 rings, 1e-4 for fewer; slopes have logarithmic poles.
    """
    # any two wear coefficients do: the compliance knows only where the edges are
    rings = Rings.alternating(count, width_ratio, WEAR_RATIO_OF_WIDTHS)
    problem = replace(problem, rings=rings, rtol=1e-6)
    return compliance_method("fem").discretise(problem, Stages("fem")).compliance


def compliance_gradients(problem: Problem, compliance: Compliance, wear_ratios: Array) -> Array:
    """Return (2, M) normalised gradients of alternating rings on the compliance of any method."""
    count = len(compliance.space.ring_edges) - 1
    steady = [
        RunningIn(compliance, np.where(np.arange(count) % 2, ratio, 1.0)).steady
        for ratio in wear_ratios
    ]
    slopes = []
    for average in AVERAGES:
        slope_alone = replace(
            problem, gradient_average=average, quantities=frozenset(["steady_rms_slope"])
        )
        sampler = Sampler(slope_alone, compliance.space)
        slopes.append([float(sampler.steady(state)["steady_rms_slope"]) for state in steady])
    return np.array(slopes) * np.pi / homogeneous()[:, None]


def compute_gradients(figure: int, problem: Problem, counts: tuple[int, ...]) -> xarray.Dataset:
    """Return the data of Fig. 6 or 7.

    `direct` and `fem`, NaN where finite elements are left out, over (rings, average, ratio);
    `limit`, of many rings, over (average, ratio).
    """
    wear_ratios, width_ratios = figure_ratios(figure)
    by_direct = np.empty((len(counts), 2, len(wear_ratios)))
    by_fem = np.full_like(by_direct, np.nan)
    for row, count in enumerate(progress(counts, f"Fig. {figure}")):
        for width_ratio in np.unique(width_ratios):
            points = np.flatnonzero(width_ratios == width_ratio)
            edges = alternating_edges(count, width_ratio)
            by_direct[row][:, points] = direct_gradients(edges, wear_ratios[points])
            points = points[points % 25 == 0]
            if len(points) and (figure == 6 or count <= 16):
                compliance = condense(problem, count, float(width_ratio))
                ratios = wear_ratios[points]
                by_fem[row][:, points] = compliance_gradients(problem, compliance, ratios)
    over_rings = ("rings", "average", "ratio")
    return xarray.Dataset(
        {
            "direct": (over_rings, by_direct),
            "fem": (over_rings, by_fem),
            "limit": (over_rings[1:], many_rings(wear_ratios, width_ratios)),
        },
        {
            "rings": list(counts),
            "average": list(AVERAGES),
            "ratio": wear_ratios if figure == 6 else width_ratios,
        },
    )
