"""Which arrangement of two materials gives the largest and the smallest gradient, under a given share of each?

With the area share given, Eq. 26 gives the same two pressures whatever the arrangement; what is left to choose is where
the rings lie. Direct integration is cheap enough to be minimised over all of them.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.radial import Array
from ringwear.studies.paper.gradients import homogeneous, odd_and_even
from ringwear.studies.progress import Report
from scipy.optimize import minimize
from scipy.special import softmax

RINGS = (2, 3, 4, 5, 6)
QUICK_RINGS = (2, 3)
SLOW_SHARE = 0.5  # of the area
WEAR_RATIO = 100.0  # faster over slower
STARTS = 3
# of the area of a material: the thinnest ring, so that rings can vanish in effect but not in arithmetic
THINNEST = 1e-3
KINDS = tuple(itertools.product((True, False), (1.0, -1.0)))  # slower material in the centre or not; largest or smallest


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Rings that alternate, `slow_first` or not, and their normalised gradient by both averages.

    Parameters
    ----------
    shares : (N,) logarithm of each ring's share of its own material's area, up to a constant
    """

    shares: Array
    slow_first: bool
    line: float
    area: float

    @property
    def edges(self) -> Array:
        return ring_edges(self.shares, self.slow_first)


def gradient(edges: Array, slow_first: bool) -> Array:
    """(2,) normalised gradient of alternating rings of the two materials, by both averages."""
    rings = len(edges) - 1
    wear = odd_and_even(rings) @ ([1.0, WEAR_RATIO] if slow_first else [WEAR_RATIO, 1.0])
    grams = direct.slope_gram(edges, direct.steady_pressures(edges, wear)[:, None])
    return np.sqrt(np.ravel(grams)) * np.pi / homogeneous()


def ring_edges(shares: Array, slow_first: bool) -> Array:
    """Edges of rings by the logarithm of the share (up to a constant) that each has of its own material's area."""
    areas = np.empty(len(shares))
    for start, material in ((0, SLOW_SHARE), (1, 1 - SLOW_SHARE)) if slow_first else ((1, SLOW_SHARE), (0, 1 - SLOW_SHARE)):
        part = softmax(shares[start::2])
        areas[start::2] = material * (THINNEST + (1 - THINNEST * len(part)) * part)
    edges = np.sqrt(np.concatenate([[0.0], np.cumsum(areas)]))
    edges[-1] = 1.0
    return edges


def best(rings: int, slow_first: bool, sign: float, inner: Arrangement | None = None) -> Arrangement:
    """The arrangement of greatest (`sign` 1) or smallest (-1) gradient over the radius.

    Parameters
    ----------
    inner : the best arrangement of one ring less and the other order, to start from with a small ring in its centre
    """
    random = np.random.default_rng(0)
    starts = [np.zeros(rings), *random.normal(0, 1.5, (STARTS - 1, rings))]
    if inner is not None:
        starts.append(np.concatenate([inner.shares[1:2] - 3.0, inner.shares]))

    def cost(shares: Array) -> float:
        return -sign * float(gradient(ring_edges(shares, slow_first), slow_first)[0])

    # two rings are fixed by their shares of the area
    runs = [
        minimize(cost, start, method="L-BFGS-B", bounds=[(-10.0, 10.0)] * rings)
        for start in starts[: None if rings > 2 else 1]
    ]
    shares = min(runs, key=lambda run: run.fun).x
    line, area = gradient(ring_edges(shares, slow_first), slow_first)
    return Arrangement(shares, slow_first, float(line), float(area))


def table(rings: tuple[int, ...], report: Report) -> str:
    """The best arrangements as a table in Markdown."""
    lines = [
        "# Arrangements of largest and smallest gradient",
        "",
        f"Slower material on {100 * SLOW_SHARE:g} % of the area, wear coefficients in the ratio {WEAR_RATIO:g}; normalised",
        "RMS gradient of the limiting profile by direct integration, optimised as an average over the radius (`line`).",
        "Equal: all rings of one material have the same area. A ring that the optimum would rather be without keeps",
        f"{100 * THINNEST:g} % of its material.",
        "",
        "| rings | order from the centre | equal | largest | its ring edges | smallest | its ring edges |",
        "|---|---|---|---|---|---|---|",
    ]
    found: dict[tuple[bool, float], Arrangement] = {}
    for count in rings:
        report(f" direct  best arrangement of {count} rings ...")
        found = {(first, sign): best(count, first, sign, found.get((not first, sign))) for first, sign in KINDS}
        for slow_first in (True, False):
            equal = gradient(ring_edges(np.zeros(count), slow_first), slow_first)[0]
            cells = []
            for sign in (1.0, -1.0):
                one = found[slow_first, sign]
                edges = ", ".join(f"{edge:.3f}" for edge in one.edges[1:-1])
                cells.append(f"{one.line:.3f} (area: {one.area:.3f}) | {edges}")
            order = "slow, fast, ..." if slow_first else "fast, slow, ..."
            lines.append(f"| {count} | {order} | {equal:.3f} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
