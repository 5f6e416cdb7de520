"""What the paper says about the gradient against the wear ratio (section 4.2, Fig. 6), checked."""

from __future__ import annotations

import numpy as np
from ringwear.meshes.radial import Array, alternating_edges
from ringwear.studies.paper.claims import Claim, told
from ringwear.studies.paper.gradients import Curves, direct_gradients, many_rings, slower_rings_alone

MANY = (256, 512, 1024)


def wear_ratio_claims(wear: Curves, many: tuple[int, ...] = MANY) -> list[Claim]:
    """All claims about Fig. 6, in the paper's order.

    Parameters
    ----------
    wear : the data of Fig. 6
    many : numbers of rings at which the limit of many rings is checked
    """
    uncertainty = wear.uncertainty()
    return [
        _symmetry(wear, uncertainty, many[-1]),
        _convergence(wear, uncertainty),
        _single_rings(wear, uncertainty),
        _limit(wear, many),
        _susceptible(wear, uncertainty),
        _order_matters(wear, uncertainty),
        _slow_outside(wear, uncertainty),
        _below_homogeneous(wear, uncertainty),
    ]


def _symmetry(wear: Curves, uncertainty: str, many: int) -> Claim:
    def skewness(values: Array) -> float:
        return float(np.abs(values[0] / values[0, ::-1] - 1).max())

    skew = {rings: skewness(values) for rings, (_, values) in wear.direct.items()}
    ratios = next(iter(wear.direct.values()))[0]
    skew[many] = skewness(direct_gradients(alternating_edges(many), ratios))
    most = max(wear.direct)
    order = np.log(skew[most] / skew[many]) / np.log(many / most)
    falling = bool(np.all(np.diff(list(skew.values())) < 0))
    return Claim(
        "4.2, Fig. 6",
        "for h2/h1 = 1 the plots are symmetrical for large numbers of rings",
        f"greatest difference between k2/k1 and k1/k2: {told({n: 100 * v for n, v in skew.items()}, '.2g')}, in percent",
        uncertainty,
        falling and skew[many] < 0.05,
        f"symmetric in the limit only, sqrt(1 + (4/g0^2) ((k2 - k1)/(k2 + k1))^2); the difference falls as N^-{order:.2f}",
    )


def _convergence(wear: Curves, uncertainty: str) -> Claim:
    left = {
        ratio: max(abs(wear.at(n, end, a) / wear.at(n, ratio, a) - 1) for n in wear.direct for a in (0, 1))
        for ratio, end in ((100.0, 1e4), (0.01, 1e-4))
    }
    worst = max(left.values())
    return Claim(
        "4.2, Fig. 6",
        "the gradients converge to different values for k2/k1 > 100 and < 0.01",
        f"from 100 to 1e4 they change by at most {100 * left[100.0]:.1f} %, from 0.01 to 1e-4 by at most "
        f"{100 * left[0.01]:.1f} %",
        uncertainty,
        worst < 0.05,
        "what is left at 100 is in proportion to the smaller ratio" if worst > 0.01 else "",
    )


def _single_rings(wear: Curves, uncertainty: str) -> Claim:
    left = max(
        abs(wear.at(n, ratio) / slower_rings_alone(alternating_edges(n), ratio > 1)[0] - 1)
        for n in wear.direct
        for ratio in (1e-4, 1e4)
    )
    return Claim(
        "4.2, Fig. 6",
        "for very large or small ratios the problem is equivalent to single rings of the slower material",
        f"at 1e4 and 1e-4 the gradient is within {left:.0e} of that of the slower rings alone",
        uncertainty,
        left < 1e-2,
    )


def _limit(wear: Curves, many: tuple[int, ...]) -> Claim:
    line, area = (float(value) for value in many_rings(np.array([np.inf]), np.array(1.0))[:, 0])
    at_hundred = {n: wear.at(n, 100.0) for n in wear.direct}
    nearest = min(at_hundred, key=lambda n: abs(at_hundred[n] - 2.4))
    distance = {
        n: float(np.abs(direct_gradients(alternating_edges(n), np.array([1e-4, 1e4]))[0] / line - 1).max()) for n in many
    }
    return Claim(
        "4.2, Fig. 6",
        "the limiting value for large numbers of rings is about 2.4",
        f"{line:.4f} (line), {area:.4f} (area) = sqrt(1 + 4/g0^2)",
        f"closed form; distance of N rings at 1e4 and 1e-4: {told({n: 100 * v for n, v in distance.items()}, '.2g')}, "
        "in percent",
        abs(line - 2.4) < 0.05,
        f"about 2.4 is what {nearest} rings give at k2/k1 = 100, where the gradient is {told(at_hundred)}; the limit is "
        "approached from above at k2/k1 > 1 and from below at k2/k1 < 1",
    )


def _susceptible(wear: Curves, uncertainty: str) -> Claim:
    within, steepest = [], []
    for ratios, values in wear.direct.values():
        change = np.abs(np.gradient(values[0], np.log10(ratios)))
        total = np.trapezoid(change, np.log10(ratios))
        middle = np.abs(np.log10(ratios)) <= 2
        within.append(float(np.trapezoid(change[middle], np.log10(ratios[middle])) / total))
        steepest.append(float(10 ** abs(np.log10(ratios[change.argmax()]))))
    return Claim(
        "4.2 and 5",
        "the gradient is very susceptible for 0.01 < k2/k1 < 100, most of all below a factor of 10",
        f"{100 * min(within):.0f} % or more of all change lies between 0.01 and 100; the curves are steepest at a factor "
        f"of {min(steepest):.1f} to {max(steepest):.1f}",
        uncertainty,
        min(within) > 0.9 and max(steepest) < 10,
    )


def _order_matters(wear: Curves, uncertainty: str) -> Claim:
    quotient = {n: wear.at(n, 100.0) / wear.at(n, 0.01) for n in wear.direct}
    few = min(quotient)
    return Claim(
        "4.2 and 5",
        "for very few rings the plots are asymmetrical and depend on the order of the materials",
        f"gradient at k2/k1 = 100 over that at 0.01: {told(quotient, '.2f')}",
        uncertainty,
        quotient[few] > 1.5,
    )


def _slow_outside(wear: Curves, uncertainty: str) -> Claim:
    fast_outside, slow_outside = wear.at(4, 100.0), wear.at(4, 0.01)
    return Claim(
        "4.2, Fig. 6",
        "N = 4: with the slower material outside the gradient is much smaller",
        f"{slow_outside:.3f} against {fast_outside:.3f} (line), {wear.at(4, 0.01, 1):.3f} against "
        f"{wear.at(4, 100.0, 1):.3f} "
        "(area)",
        uncertainty,
        slow_outside < 0.75 * fast_outside,
    )


def _below_homogeneous(wear: Curves, uncertainty: str) -> Claim:
    lowest = {n: float(values[0].min()) for n, (_, values) in wear.direct.items() if values[0].min() < 1 - 1e-6}
    few = min(wear.direct)
    ratios, values = wear.direct[few]
    below = ratios[values[0] < 1 - 1e-6]
    return Claim(
        "4.2, Fig. 6",
        "for two rings some ratios give a slightly lower gradient than a homogeneous cylinder",
        f"lowest {values[0].min():.4f} at k2/k1 = {ratios[values[0].argmin()]:.2f}; below one from {below[0]:.2f} to "
        f"{below[-1]:.2f}",
        uncertainty,
        few in lowest,
        f"not for two rings only, but ever less: {told(lowest, '.4f')}" if len(lowest) > 1 else "",
    )
