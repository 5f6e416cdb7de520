"""The gradient of the limiting profile against wear ratio and width ratio: the data of Figs. 6 and 7.

Two materials alternate, so the steady pressure is ``p1`` on odd rings and ``p2 = p1 k1/k2`` on even ones, and the
squared gradient is a quadratic form in the two: three numbers for each punch and average, whatever the wear ratio.
Finite elements give the same three numbers from one condensation. All gradients are over that of the homogeneous punch.

Many rings are seen from far as a homogeneous punch and from near as strips of alternating pressure on a half-plane,
whose slope is ``2/E*`` times the Hilbert transform of the pressure and so has the mean square ``4 var(p)/E*^2``. With
width shares ``s1 + s2 = 1`` and the homogeneous gradient ``g0 p_mean/E*`` the limit of many rings is

    (gradient / homogeneous)^2 = 1 + (4/g0^2) s1 s2 ((p1 - p2) / (s1 p1 + s2 p2))^2.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.radial import Array, alternating_edges, ring_areas
from ringwear.studies.methods.fem import fem_model
from ringwear.studies.methods.radial import edge_weight
from ringwear.studies.paper.running_in import AVERAGES, WEAR_RATIO, paper_punch
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages, silent
from ringwear.studies.wear.banded import BandedCholesky

RINGS = (2, 4, 8, 16, 32, 64)
QUICK_RINGS = (2, 4, 8)
WEAR_RATIOS = np.array([float(f"{10 ** (i / 25 - 4):.12g}") for i in range(201)])
WIDTH_RATIOS = np.array([float(f"{10 ** (i / 100 - 1):.12g}") for i in range(201)])
WIDTH_STUDY_RATIO = 0.01  # k2/k1 of Fig. 7
QUADRATURE = 1e-12  # relative, of direct integration; measured against twice the nodes and held by a test
FEM_WEAR_RATIOS = WEAR_RATIOS[[0, 50, 75, 88, 112, 125, 150, 200]]
FEM_WIDTH_RATIOS = WIDTH_RATIOS[[0, 30, 70, 130, 170, 200]]
FEM_MOST_RINGS = 16  # at width ratios other than one
# measured: the gradient within 5e-4 for 2 to 64 rings of width ratio 0.1 to 10, where slopes have logarithmic poles
FEM_ACCURACY = {"accuracy__rtol": 1e-6, "accuracy__fem__degree": 3, "accuracy__fem__growth": 0.6}
FEM_RING_SIZE = 0.003  # at ring edges, of the narrowest ring


def odd_and_even(rings: int) -> Array:
    """(N, 2) pressures that are one on odd rings (from the centre: 1st, 3rd, ...), and one on even rings."""
    even = np.arange(rings) % 2
    return np.stack([1.0 - even, even], axis=1)


def alternating_pressures(edges: Array, wear_ratios: Array) -> Array:
    """(2, M) steady pressures of odd and even rings for ``k2/k1`` (Eqs. 24 and 26); force 1."""
    odd, even = ring_areas(edges) @ odd_and_even(len(edges) - 1)
    return np.stack([wear_ratios, np.ones_like(wear_ratios)]) / (odd * wear_ratios + even)


@cache
def homogeneous() -> Array:
    """(2,) RMS gradient of the homogeneous punch under unit mean pressure, over the radius and over the area."""
    return np.array([direct.rms_slope(np.array([0.0, 1.0]), np.ones(1), average) for average in AVERAGES])


def normalised(grams: Array, pressures: Array) -> Array:
    """(2, M) gradients over that of the homogeneous punch, by both averages.

    Parameters
    ----------
    grams : (2, m, m) mean products of slopes of m patterns, for each average
    pressures : (m, M) the amplitudes of the patterns; force 1
    """
    squares = np.einsum("im,aij,jm->am", pressures, grams, pressures)
    return np.sqrt(squares) * np.pi / homogeneous()[:, None]


def direct_gradients(edges: Array, wear_ratios: Array) -> Array:
    """(2, M) normalised gradients of alternating rings by direct integration, one pair of Gram matrices for all."""
    grams = np.array(direct.slope_gram(edges, odd_and_even(len(edges) - 1)))
    return normalised(grams, alternating_pressures(edges, wear_ratios))


def slower_rings_alone(edges: Array, odd: bool) -> Array:
    """(2,) normalised gradient where only the odd or the even rings carry anything: the limit of extreme wear ratios."""
    slow = odd_and_even(len(edges) - 1)[:, 0 if odd else 1]
    grams = np.array(direct.slope_gram(edges, slow[:, None]))
    return normalised(grams, np.array([[1 / (ring_areas(edges) @ slow)]]))[:, 0]


def many_rings(wear_ratios: Array, width_ratios: Array) -> Array:
    """(2, M) the limit of many rings, for ratios that broadcast; wear ratios may be zero or infinite."""
    first = 1 / (1 + np.asarray(width_ratios, dtype=float))
    wear_ratios = np.asarray(wear_ratios, dtype=float)
    with np.errstate(divide="ignore"):
        odd, even = np.minimum(wear_ratios, 1.0), np.minimum(1 / wear_ratios, 1.0)
    contrast = (odd - even) / (first * odd + (1 - first) * even)
    return np.sqrt(1 + 4 * first * (1 - first) * contrast**2 / homogeneous()[:, None] ** 2)


def compliance_grams(compliance: Compliance) -> Array:
    """(2, 2, 2) mean products of the slopes by odd and even rings, from any compliance with one ring for each phase.

    The displacement is the best approximation in the mean among the continuous functions of the pressure space.
    """
    space = compliance.space
    rings = len(space.edges) - 1
    patterns = space.ring_indicator() @ odd_and_even(rings)
    continuous = space.joined(np.ones(rings))
    moments = compliance.factor.T @ (compliance.factor @ patterns)
    mass = BandedCholesky(continuous.T @ space.mass(np.ones(rings)) @ continuous)
    displacement = continuous @ mass.solve(continuous.T @ moments)
    return np.array([displacement.T @ space.slope_gram(edge_weight(space, name)) @ displacement for name in AVERAGES])


@dataclass(frozen=True, eq=False)
class Curves:
    """Normalised gradients against a ratio: for each number of rings the ratios (M,) and gradients (2, M)."""

    direct: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    fem: dict[int, tuple[Array, Array]] = field(default_factory=dict)

    def rows(self) -> Iterable[tuple[int, float, str, float, float]]:
        """Rings, ratio, method, and gradient by both averages."""
        for method, curves in (("direct", self.direct), ("fem", self.fem)):
            for rings, (ratios, (line, area)) in curves.items():
                for row in zip(ratios, line, area, strict=True):
                    yield rings, float(row[0]), method, float(row[1]), float(row[2])

    def at(self, rings: int, ratio: float, average: int = 0) -> float:
        """The gradient by direct integration at one of the ratios of the curve."""
        ratios, values = self.direct[rings]
        return float(values[average, np.abs(np.log(ratios / ratio)).argmin()])

    def uncertainty(self) -> str:
        """The uncertainty of the curves, for a table."""
        return f"{QUADRATURE:.0e} (quadrature); FEM within {self.difference():.0e}"

    def difference(self) -> float:
        """Greatest relative difference of finite elements from direct integration."""
        return max(
            float(np.abs(values / self.direct[rings][1][:, np.searchsorted(self.direct[rings][0], ratios)] - 1).max())
            for rings, (ratios, values) in self.fem.items()
        )


class FemGrams:
    """Gram matrices by finite elements: one condensation for each punch, kept for both figures."""

    def __init__(self, scene: Scene, report: Report = silent) -> None:
        self._scene, self._report = scene.changed(**FEM_ACCURACY), report
        self._known: dict[tuple[int, float], tuple[Array, Array]] = {}

    def gradients(self, rings: int, width_ratio: float, wear_ratios: Array) -> Array:
        """(2, M) normalised gradients of alternating rings."""
        if (rings, width_ratio) not in self._known:
            self._report(f"    fem  {rings} rings, h2/h1 = {width_ratio:g} ...")
            # any two wear coefficients do: the compliance knows only where the edges are
            scene = paper_punch(self._scene, rings, width_ratio, WEAR_RATIO)
            narrowest = float(np.diff(scene.natural.edges).min())
            natural = scene.changed(accuracy__fem__ring_size=FEM_RING_SIZE * narrowest).natural
            model = fem_model(natural, Stages("fem"))
            self._known[rings, width_ratio] = natural.edges, compliance_grams(model.compliance)
        edges, grams = self._known[rings, width_ratio]
        return normalised(grams, alternating_pressures(edges, wear_ratios))


def wear_ratio_curves(fem: FemGrams, rings: tuple[int, ...] = RINGS, report: Report = silent) -> Curves:
    """Fig. 6: rings of equal width, against ``k2/k1``."""
    curves = Curves()
    for count in rings:
        report(f" direct  {count} rings against k2/k1 ...")
        curves.direct[count] = WEAR_RATIOS, direct_gradients(alternating_edges(count), WEAR_RATIOS)
        curves.fem[count] = FEM_WEAR_RATIOS, fem.gradients(count, 1.0, FEM_WEAR_RATIOS)
    return curves


def width_ratio_curves(fem: FemGrams, rings: tuple[int, ...] = RINGS, report: Report = silent) -> Curves:
    """Fig. 7: ``k2/k1 = 0.01``, against ``h2/h1``; every width ratio is a punch of its own."""
    curves = Curves()
    wear_ratio = np.array([WIDTH_STUDY_RATIO])
    for count in rings:
        report(f" direct  {count} rings against h2/h1 ...")

        def gradient(width_ratio: float, count: int = count) -> Array:
            edges = alternating_edges(count, width_ratio)
            steady = odd_and_even(count) @ alternating_pressures(edges, wear_ratio)
            return normalised(np.array(direct.slope_gram(edges, steady)), np.ones((1, 1)))[:, 0]

        # the special functions release the interpreter
        with ThreadPoolExecutor(min(4, os.cpu_count() or 1)) as pool:
            values = np.array(list(pool.map(gradient, WIDTH_RATIOS))).T
        curves.direct[count] = WIDTH_RATIOS, values
        chosen = FEM_WIDTH_RATIOS if count <= FEM_MOST_RINGS else np.empty(0)
        chosen = np.sort(np.append(chosen, 1.0))
        curves.fem[count] = chosen, np.stack([fem.gradients(count, float(w), wear_ratio)[:, 0] for w in chosen], axis=1)
    return curves
