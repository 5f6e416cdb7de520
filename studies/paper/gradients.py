"""The gradient of the limiting profile against wear ratio and width ratio: Figs. 6 and 7.

Two materials alternate, so the steady pressure is ``p1`` on odd rings and ``p2 = p1 k1/k2`` on even
ones, and the squared gradient is a quadratic form in the two: three numbers for each punch and
average, whatever the wear ratio. Finite elements give the same three numbers from one condensation.
All gradients are over that of the homogeneous punch.

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
from scipy.sparse.linalg import splu

from ...mdr import direct
from ...meshes.compliance import Compliance
from ...meshes.radial import Array, alternating_edges, ring_areas
from ..methods.pipeline import compliance_method
from ..methods.sampler import AVERAGES, radial_weight
from ..problem.problem import Problem, Rings
from ..progress import Stages, progress

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


def gradients(grams: Array, ring_edges: Array, wear_ratios: Array) -> Array:
    """Return (2, M) normalised gradients, by both averages.

    Parameters
    ----------
    grams : (2, 2, 2) mean products of slopes by unit pressure on odd and on even rings
    """
    pressures = relative_pressures(wear_ratios)
    pressures = pressures / (ring_areas(ring_edges) @ odd_and_even(len(ring_edges) - 1) @ pressures)
    squares = np.einsum("im,aij,jm->am", pressures, grams, pressures)
    return np.asarray(np.sqrt(squares) * np.pi / homogeneous()[:, None])


def direct_gradients(ring_edges: Array, wear_ratios: Array) -> Array:
    """Return (2, M) normalised gradients of alternating rings by direct integration."""
    grams = np.array(direct.slope_gram(ring_edges, odd_and_even(len(ring_edges) - 1)))
    return gradients(grams, ring_edges, wear_ratios)


def many_rings(wear_ratios: Array, width_ratios: Array) -> Array:
    """Return (2, M) normalised gradients in the limit of many rings, for ratios that broadcast."""
    first = 1 / (1 + width_ratios)
    odd, even = relative_pressures(wear_ratios)
    contrast = (odd - even) / (first * odd + (1 - first) * even)
    return np.asarray(
        np.sqrt(1 + 4 * first * (1 - first) * contrast**2 / homogeneous()[:, None] ** 2)
    )


def compliance_grams(compliance: Compliance) -> Array:
    """Return the (2, 2, 2) `grams` of `gradients` from the compliance of any method.

    The displacement is the best approximation in the mean among the continuous functions of the
    pressure space.
    """
    space = compliance.space
    continuous = space.joined()
    pressures = space.ring_indicator() @ odd_and_even(len(space.ring_edges) - 1)
    mass = splu((continuous.T @ space.mass() @ continuous).tocsc())
    displacement = mass.solve(continuous.T @ (compliance.matrix @ pressures))
    radii, weights, local = space.quadrature
    slopes = space.on_elements(local, derivative=True) @ continuous @ displacement
    weights_of_averages = (weights * radial_weight(radii, average) for average in AVERAGES)
    return np.array([slopes.T @ (each.ravel()[:, None] * slopes) for each in weights_of_averages])


@cache
def fem_grams(problem: Problem, count: int, width_ratio: float) -> Array:
    """Return the `compliance_grams` of finite elements: one condensation serves both figures.

    Measured: gradients within 3e-4 for 64 rings, 1e-4 for fewer; slopes have logarithmic poles.
    """
    # any two wear coefficients do: the compliance knows only where the edges are
    rings = Rings.alternating(count, width_ratio, WEAR_RATIO_OF_WIDTHS)
    problem = replace(problem, rings=rings, rtol=1e-6)
    ready = compliance_method("fem").discretise(problem, Stages("fem"))
    return compliance_grams(ready.compliance)


def compute_gradients(figure: int, problem: Problem, counts: tuple[int, ...]) -> xarray.Dataset:
    """Return the data of Fig. 6 or 7.

    `direct` and `fem`, NaN where finite elements are left out, over (rings, average, ratio);
    `limit`, of many rings, over (average, ratio).
    """
    wear_ratios, width_ratios = figure_ratios(figure)
    by_direct = np.empty((len(counts), 2, len(wear_ratios)))
    by_fem = np.full_like(by_direct, np.nan)
    # every width ratio is a punch of its own, for all wear ratios
    punches = [np.arange(201)] if figure == 6 else np.arange(201)[:, None]
    for row, count in enumerate(progress(counts, f"Fig. {figure}")):
        for points in punches:
            width_ratio = float(width_ratios[points[0]])
            edges = alternating_edges(count, width_ratio)
            by_direct[row][:, points] = direct_gradients(edges, wear_ratios[points])
            points = points[points % 25 == 0]
            if len(points) and (figure == 6 or count <= 16):
                grams = fem_grams(problem, count, width_ratio)
                by_fem[row][:, points] = gradients(grams, edges, wear_ratios[points])
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
