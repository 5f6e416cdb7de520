"""The gradient of the limiting profile against wear ratio and width ratio.

The data of Figs. 6 and 7.

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

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from ...mdr import direct
from ...meshes.compliance import Compliance
from ...meshes.radial import Array, alternating_edges, ring_areas
from ..methods.pipeline import compliance_method
from ..methods.sampler import AVERAGES, radial_weight
from ..problem.problem import Problem, Rings
from ..progress import Stages, progress
from ..wear.modes import BandedCholesky

RINGS = (2, 4, 8, 16, 32, 64)
QUICK_RINGS = (2, 4, 8)
WEAR_RATIOS = 10.0 ** np.linspace(-4, 4, 201)
WIDTH_RATIOS = 10.0 ** np.linspace(-1, 1, 201)
WEAR_RATIO_OF_WIDTHS = 0.01  # k2/k1 of Fig. 7
# k2/k1 and h2/h1 of each point of Figs. 6 and 7, and the points that finite elements compute, too
POINTS = {
    6: (WEAR_RATIOS, np.ones_like(WEAR_RATIOS), (0, 50, 75, 88, 112, 125, 150, 200)),
    7: (
        np.full_like(WIDTH_RATIOS, WEAR_RATIO_OF_WIDTHS),
        WIDTH_RATIOS,
        (0, 30, 70, 100, 130, 170, 200),
    ),
}
FEM_MOST_RINGS = 16  # of more rings they compute equal widths only
# measured: the gradient within 3e-4 for 64 rings, 1e-4 for fewer; slopes have logarithmic poles
FEM_RTOL = 1e-6


def odd_and_even(count: int) -> Array:
    """(N, 2) patterns that are one on odd rings (from the centre.

    1st, 3rd, ...), and one on even rings.
    """
    even = np.arange(count) % 2
    return np.stack([1.0 - even, even], axis=1)


def relative_pressures(wear_ratios: Array) -> Array:
    """(2, M) steady pressures of odd and even rings over the greater of them (Eq.

    24); ratios from zero to infinity.
    """
    with np.errstate(divide="ignore"):
        return np.stack([np.minimum(wear_ratios, 1.0), np.minimum(1 / wear_ratios, 1.0)])


@cache
def homogeneous() -> Array:
    """(2,) RMS gradient of the homogeneous punch under unit mean pressure, over the radius and over
    the area.
    """
    return np.array(
        [direct.rms_slope(np.array([0.0, 1.0]), np.ones(1), average) for average in AVERAGES]
    )


def gradients(grams: Array, ring_edges: Array, wear_ratios: Array) -> Array:
    """(2, M) normalised gradients by both averages, from the (2, 2, 2) mean products of slopes by
    odd and even rings.
    """
    pressures = relative_pressures(wear_ratios)
    pressures = pressures / (ring_areas(ring_edges) @ odd_and_even(len(ring_edges) - 1) @ pressures)
    squares = np.einsum("im,aij,jm->am", pressures, grams, pressures)
    return np.asarray(np.sqrt(squares) * np.pi / homogeneous()[:, None])


def direct_gradients(ring_edges: Array, wear_ratios: Array) -> Array:
    """(2, M) normalised gradients of alternating rings by direct integration."""
    grams = np.array(direct.slope_gram(ring_edges, odd_and_even(len(ring_edges) - 1)))
    return gradients(grams, ring_edges, wear_ratios)


def many_rings(wear_ratios: Array, width_ratios: Array) -> Array:
    """(2, M) normalised gradients in the limit of many rings, for ratios that broadcast."""
    first = 1 / (1 + width_ratios)
    odd, even = relative_pressures(wear_ratios)
    contrast = (odd - even) / (first * odd + (1 - first) * even)
    return np.asarray(
        np.sqrt(1 + 4 * first * (1 - first) * contrast**2 / homogeneous()[:, None] ** 2)
    )


def compliance_grams(compliance: Compliance) -> Array:
    """(2, 2, 2) mean products of slopes by odd and even rings, for both averages, from the
    compliance of any method.

    The displacement is the best approximation in the mean among the continuous functions of the
    pressure space.
    """
    space = compliance.space
    count = len(space.ring_edges) - 1
    continuous = space.joined()
    moments = compliance.factor.T @ (
        compliance.factor @ space.ring_indicator() @ odd_and_even(count)
    )
    mass = BandedCholesky(continuous.T @ space.mass() @ continuous)
    displacement = continuous @ mass.solve(continuous.T @ moments)
    radii, weights, local = space.quadrature
    slopes = space.on_elements(local, derivative=True) @ displacement
    own = ((weights * radial_weight(radii, name)).ravel()[:, None] * slopes for name in AVERAGES)
    return np.array([slopes.T @ weighted for weighted in own])


@cache
def fem_grams(problem: Problem, count: int, width_ratio: float) -> Array:
    """(2, 2, 2) `compliance_grams` of finite elements: one condensation, kept for both figures."""
    # any two wear coefficients do: the compliance knows only where the edges are
    punch = replace(
        problem, rings=Rings.alternating(count, width_ratio, WEAR_RATIO_OF_WIDTHS), rtol=FEM_RTOL
    )
    return compliance_grams(
        compliance_method("fem").discretised(punch, Stages("fem"), coarser=False).compliance
    )


@dataclass(frozen=True, eq=False)
class Curves:
    """Normalised gradients (2, M) along a figure's ratio, by both averages.

    Parameters
    ----------
    wear_ratios, width_ratios : (M,) of which one is constant
    limit : of many rings
    direct : by direct integration, for each number of rings
    fem : by finite elements, NaN at the ratios that they leave out
    """

    wear_ratios: Array
    width_ratios: Array
    limit: Array
    direct: dict[int, Array] = field(default_factory=dict)
    fem: dict[int, Array] = field(default_factory=dict)

    @property
    def ratios(self) -> Array:
        """The ratio that varies."""
        return self.wear_ratios if np.ptp(self.wear_ratios) else self.width_ratios

    def at(self, ratio: float, average: int = 0) -> dict[int, float]:
        """The gradient by direct integration at one of the ratios, by number of rings."""
        nearest = np.abs(np.log(self.ratios / ratio)).argmin()
        return {count: float(values[average, nearest]) for count, values in self.direct.items()}

    @property
    def difference(self) -> float:
        """Greatest relative difference of finite elements from direct integration."""
        return max(
            float(np.nanmax(np.abs(values / self.direct[count] - 1)))
            for count, values in self.fem.items()
        )


def curves(figure: int, problem: Problem, counts: tuple[int, ...]) -> Curves:
    """The data of Fig. 6 or 7; every width ratio is a punch of its own, for all wear ratios."""
    wear_ratios, width_ratios, by_fem = POINTS[figure]
    result = Curves(wear_ratios, width_ratios, many_rings(wear_ratios, width_ratios))
    for count in progress(counts, f"Fig. {figure}"):
        result.direct[count], result.fem[count] = np.full((2, *result.limit.shape), np.nan)
        for width_ratio in np.unique(width_ratios):
            ring_edges, here = (
                alternating_edges(count, width_ratio),
                np.flatnonzero(width_ratios == width_ratio),
            )
            result.direct[count][:, here] = direct_gradients(ring_edges, wear_ratios[here])
            here = np.intersect1d(here, by_fem)
            if len(here) and (width_ratio == 1 or count <= FEM_MOST_RINGS):
                grams = fem_grams(problem, count, float(width_ratio))
                result.fem[count][:, here] = gradients(grams, ring_edges, wear_ratios[here])
    return result
