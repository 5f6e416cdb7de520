"""What the paper says about the gradient against the width ratio, and about cost (Fig. 7, section 5), checked."""

from __future__ import annotations

import time

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.radial import alternating_edges, ring_areas
from ringwear.studies.paper.claims import Claim, told
from ringwear.studies.paper.gradients import (
    WIDTH_STUDY_RATIO,
    Curves,
    alternating_pressures,
    many_rings,
    odd_and_even,
    slower_rings_alone,
)
from ringwear.studies.paper.running_in import Evolution


def width_ratio_claims(wear: Curves, width: Curves, evolution: Evolution) -> list[Claim]:
    """All claims about Fig. 7 and about cost, in the paper's order.

    Parameters
    ----------
    wear, width : the data of Figs. 6 and 7
    evolution : the running-in by the reference method, for the comparison of cost
    """
    uncertainty = width.uncertainty()
    return [
        _same_at_equal_width(wear, width),
        _share(width),
        _suppressed(width, uncertainty),
        _towards_one(width, uncertainty),
        _thin_rings_steep(width, uncertainty),
        _thin_rings_alone(width, uncertainty),
        _no_convergence(width, uncertainty),
        _cost(evolution),
    ]


def _same_at_equal_width(wear: Curves, width: Curves) -> Claim:
    difference = max(abs(wear.at(n, WIDTH_STUDY_RATIO) / width.at(n, 1.0) - 1) for n in width.direct)
    return Claim(
        "4.2, Fig. 7",
        "at h2/h1 = 1 the values are those of Fig. 6",
        f"within {difference:.0e}",
        "roundoff",
        difference < 1e-10,
    )


def _share(width: Curves) -> Claim:
    shares = {}
    for n in width.direct:
        areas = [ring_areas(alternating_edges(n, ratio)) @ odd_and_even(n)[:, 1] / np.pi for ratio in width.direct[n][0]]
        shares[n] = areas[0], areas[-1], float(np.diff(areas).min())
    few = min(shares)
    return Claim(
        "4.2, Fig. 7",
        "the outer ring is of the slower material, and its share increases with h2/h1",
        f"slower material on {100 * shares[few][0]:.0f} to {100 * shares[few][1]:.0f} % of the area for N = {few}, "
        f"{100 * shares[max(shares)][0]:.0f} to {100 * shares[max(shares)][1]:.0f} % for N = {max(shares)}",
        "closed form",
        min(share[2] for share in shares.values()) > 0,
    )


def _suppressed(width: Curves, uncertainty: str) -> Claim:
    value = width.at(8, 10.0)
    return Claim(
        "4.2, Fig. 7",
        "N = 8, h2/h1 = 10: fast parts have almost no influence, the gradient is very close to homogeneous",
        f"{value:.3f} (line), {width.at(8, 10.0, 1):.3f} (area)",
        uncertainty,
        value < 1.2,
        f"{100 * (value - 1):.0f} % above the homogeneous punch; the profile is as close as the small figure shows",
    )


def _towards_one(width: Curves, uncertainty: str) -> Claim:
    values = {n: width.at(n, 10.0) for n in width.direct}
    ratios = np.array([10.0, 100.0, 1e4])
    limit = many_rings(np.array(WIDTH_STUDY_RATIO), ratios)[0]
    falling = all(bool(np.all(np.diff(curve[0]) < 0)) for _, curve in width.direct.values())
    return Claim(
        "4.2, Fig. 7",
        "in all cases the gradient converges to one as h2/h1 increases",
        f"at h2/h1 = 10: {told(values)}",
        uncertainty,
        falling and bool(limit[-1] - 1 < 1e-3),
        f"not yet at 10 for many rings, whose limit is {limit[0]:.3f} there, {limit[1]:.3f} at 100 and "
        f"{limit[2]:.5f} at 1e4",
    )


def _thin_rings_steep(width: Curves, uncertainty: str) -> Claim:
    values = {n: width.at(n, 0.1) for n in width.direct}
    return Claim(
        "4.2 and 5, Fig. 7",
        "with a small share of slower material (printed: increased) the gradient is significantly higher",
        f"at h2/h1 = 0.1: {told(values)}",
        uncertainty,
        min(values.values()) > 2,
        "print error, see below",
    )


def _thin_rings_alone(width: Curves, uncertainty: str) -> Claim:
    edges = alternating_edges(8, 0.1)
    alone = float(slower_rings_alone(edges, False)[0])
    value = width.at(8, 0.1)
    steady = alternating_pressures(edges, np.array([WIDTH_STUDY_RATIO]))[:, 0]
    carried = float(steady[1] * (ring_areas(edges) @ odd_and_even(8)[:, 1]))
    return Claim(
        "4.2, Fig. 7",
        "N = 8, h2/h1 = 0.1: equivalent to only the N/2 thin rings pressed into the half-space",
        f"the thin rings carry {100 * carried:.1f} % of the force; alone they would have a gradient of {alone:.3f} instead "
        f"of {value:.3f}",
        uncertainty,
        carried > 0.9 or abs(alone / value - 1) < 0.1,
        f"{100 * (alone / value - 1):.0f} % too high: what the wide rings carry is little, but not nothing",
    )


def _no_convergence(width: Curves, uncertainty: str) -> Claim:
    values = {n: width.at(n, 0.1) for n in width.direct}
    limits = many_rings(np.array(WIDTH_STUDY_RATIO), np.array([0.1]))[:, 0]
    rings = np.array(list(values))
    gaps = limits[0] - np.array(list(values.values()))
    order = np.log(gaps[-2] / gaps[-1]) / np.log(rings[-1] / rings[-2])
    return Claim(
        "4.2, Fig. 7",
        "at h2/h1 = 0.1 there is no convergence and the gradient increases with the number of rings",
        f"it does increase: {told(values)}",
        uncertainty,
        bool(np.all(np.diff(gaps) < 0)),
        f"convergence is slow, lately as N^-{order:.2f}, but it is there: the limit of many rings is {limits[0]:.3f} "
        "(line), "
        f"{limits[1]:.3f} (area), and the distance to it {told(dict(zip(values, gaps, strict=True)), '.2f')}; it is "
        "without bound only as h2/h1 and k2/k1 both go to zero",
    )


def _cost(evolution: Evolution) -> Claim:
    natural = evolution.natural
    start = time.perf_counter()
    direct.rms_slope(natural.edges, direct.steady_pressures(natural.edges, natural.wear))
    integration = time.perf_counter() - start
    fresh = Evolution(evolution.method, natural, evolution.compliance)
    start = time.perf_counter()
    fresh.gradients(np.array([1.0]))
    march = time.perf_counter() - start
    return Claim(
        "5",
        "direct integration is much faster than MDR for the limiting profile",
        f"{1e3 * integration:.1f} ms against {1e3 * march:.0f} ms for a marched one, on this machine",
        "one run",
        integration < march / 3,
        "the march by relaxation modes has no steps: the paper's, which has, is slower still",
    )
