"""The paper's claims beside our values: a table whose every number and verdict is computed."""

import time

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array, alternating_edges, ring_areas
from ..problem.problem import P0, Rings
from .gradients import WEAR_RATIO_OF_WIDTHS, Curves, direct_gradients, homogeneous, many_rings
from .running_in import (
    COUNT,
    CURVE,
    STATIONARY,
    WEAR_RATIO,
    WEAR_RATIOS,
    Evolution,
    FiveRings,
    States,
)

EXTREMES = np.array([0.0, np.inf])  # wear ratios that leave all force to the slower rings
# distance of a ring's mean pressure from its steady value at which its level counts as reached
SETTLED = 0.1
SAYS = "the paper says"
FIELDS = ("where", SAYS, "computed", "verdict", "why, or what to add", "uncertainty")
Row = dict[str, str]
VERDICTS = ("holds", "holds with a remark", "does not hold")


def claim(
    where: str,
    says: str,
    computed: str,
    holds: bool | np.bool,
    remark: str = "",
    uncertainty: str = "",
) -> Row:
    """A row: a sentence of the paper with a number or a trend in it, and what is computed for it.

    Parameters
    ----------
    remark : why it does not hold, or what has to be added
    """
    verdict = VERDICTS[1 if remark else 0] if holds else VERDICTS[2]
    return dict(zip(FIELDS, (where, says, computed, verdict, remark, uncertainty), strict=True))


def conclude(claims: list[Row]) -> list[str]:
    """How many claims have which verdict, and those that do not hold."""
    verdicts = [row["verdict"] for row in claims]
    refuted = [
        f"{VERDICTS[2]}: {row[SAYS]}: {row['computed']}"
        for row in claims
        if row["verdict"] == VERDICTS[2]
    ]
    return [f"claims: {', '.join(f'{verdicts.count(one)} {one}' for one in VERDICTS)}", *refuted]


def definitions() -> str:
    """Of the symbols in the table."""
    line, area = homogeneous()
    return (
        f"`p0 = F/(2 pi a^2)`, `d0 = F/(2 a E*)`; `t_stat` is the time to {100 * STATIONARY:g} % "
        "of the displacement "
        "difference; `line` is an average over the radius, `area` over the area, and gradients are "
        "`line` where nothing is "
        f"said. The homogeneous punch has the gradient g0 = {line:.8f} (line), {area:.8f} = 4/pi "
        "(area), times p/E*. "
        "Uncertainties of the running-in are the greatest difference by FEM, BEM, or MDR on a "
        "coarser space; gradients of "
        "limiting profiles (4.2) are by direct integration, to 1e-12."
    )


def listed(values: dict[int, float], form: str = ".3f") -> str:
    """Values by number of rings."""
    return ", ".join(f"{value:{form}} (N = {count})" for count, value in values.items())


def about_running_in(five: FiveRings, relaxation: dict[int, Array]) -> list[Row]:
    """What the paper says about the running-in (section 3.3, Figs.

    4 and 5) and its cost (section 5).
    """
    return [
        *_states(five),
        *_measured(five),
        *_ring_forces(five),
        *_duration(five, relaxation),
        _cost(five),
    ]


def _states(five: FiveRings) -> list[Row]:
    first, *others = five.states.values()
    profile = max(np.abs(other.profile - first.profile).max() for other in others)
    norm = np.linalg.norm(first.pressure[1:], axis=1)
    pressure = max(
        (np.linalg.norm((other.pressure - first.pressure)[1:], axis=1) / norm).max()
        for other in others
    )
    late = five.reference.states(five.stationary * np.array([1, 3, 10, np.inf]))
    at_end, later, last = np.abs(late.pressure[:3] / late.pressure[3] - 1).max(axis=1)
    slow, fast = late.pressure[3].max(), late.pressure[3].min()
    profiles = {name: states.profile[-1] for name, states in five.states.items()} | {
        "march to 10 t_stat": late.profile[2]
    }
    errors = {
        name: np.abs(values - five.limiting["profile"]).max() for name, values in profiles.items()
    }
    return [
        claim(
            "3.3, Fig. 4",
            "MDR and BEM match within a small tolerance",
            f"{', '.join(five.states).upper()}: profiles within {profile:.1e} d0, pressures after "
            "the start within "
            f"{pressure:.1e} (root mean square over the radius)",
            profile < 0.01 and pressure < 0.01,
            "at t = 0 the pressure is infinite at the rim, where no pointwise comparison means "
            "anything",
        ),
        claim(
            "3.3, Eq. 24",
            "the stress of the limiting profile is piecewise constant, p1 > p2",
            "pressures are within "
            f"{at_end:.1e} of constants at t_stat, {later:.1e} at 3 t_stat, {last:.0e} at 10 "
            "t_stat",
            later < 1e-3,
        ),
        claim("3.3", "slow rings: more than three times p0", f"{slow:.4f} p0", slow > 3),
        claim("3.3", "fast rings: less than half of p0", f"{fast:.4f} p0", fast < 0.5),
        claim(
            "5",
            "the same limiting profile can be computed by both methods",
            "from direct integration, over d0: "
            f"{', '.join(f'{name} {error:.0e}' for name, error in errors.items())}",
            max(errors.values()) < 1e-3,
        ),
    ]


def _measured(five: FiveRings) -> list[Row]:
    """What every method measures alike, so that their differences are the uncertainty."""
    problem = five.reference.problem
    middles, fast = (
        (problem.ring_edges[1:] + problem.ring_edges[:-1]) / 2,
        problem.wear_coefficients == 1,
    )

    def measures(states: States) -> Array:
        worn = states.profile[1] + states.least_wear[1]
        at_middles, at_rim = np.interp(middles, problem.radii, worn), worn[-1]
        lead = at_middles[fast].min() / at_middles[~fast].max()
        return np.array(
            [states.pressure.min(), at_rim / at_middles[-1], lead, *100 * states.gradients[4]]
        )

    first, *others = (
        measures(states) for states in (*five.states.values(), five.coarser.states(five.times))
    )
    lowest, rim, lead, line, area = first
    spread = [f"{difference:.0e}" for difference in np.abs(np.array(others) - first).max(axis=0)]
    return [
        claim(
            "3.3",
            "wear occurs on all parts of the cylinder",
            f"p is at least {lowest:.3f} p0 in all states",
            lowest > 0,
            uncertainty=spread[0],
        ),
        claim(
            "3.3",
            "the profile changes very quickly close to the edge",
            f"in the 10 % state the rim has worn {rim:.2f} times as much as the middle of its ring",
            rim > 2,
            uncertainty=spread[1],
        ),
        claim(
            "3.3",
            "it changes quicker in regions of higher wear coefficient",
            "in the 10 % state the middles of fast "
            f"rings have worn at least {lead:.2f} times as much as those of slow ones",
            lead > 1,
            uncertainty=spread[2],
        ),
        claim(
            "3.3, Fig. 5",
            "this behaviour (70 % of the change in 27 % of the time) is also observed in the "
            "gradient",
            f"in the 70 % state the gradient has reached {line:.1f} % (line) or {area:.1f} % "
            "(area) of its end",
            min(line, area) > 70,
            uncertainty=spread[3],
        ),
    ]


def _ring_forces(five: FiveRings) -> list[Row]:
    ring_edges, coefficients = five.reference.problem.rings
    steady, fast = direct.steady_pressures(ring_edges, coefficients), coefficients == 1
    forces = 100 * five.states["mdr"].ring_force
    carried = forces[:, fast] @ (steady * ring_areas(ring_edges))[fast]
    times = 200 * np.linspace(0, 1, 2001) ** 3
    change = np.abs(five.reference.states(five.stationary * times / 100).ring_force - 1) * steady

    def settled(scale: Array | float, name: str) -> tuple[bool, str]:
        """Whether fast rings settle in less than half of the time of slow rings, and both times."""
        moving = change / scale > SETTLED
        first, second = (
            times[np.flatnonzero(moving[:, rings].any(axis=1))[-1] + 1] for rings in (fast, ~fast)
        )
        text = (
            f"within {SETTLED:g} of {name} fast rings stay after {first:.1f} %, slow rings after "
            f"{second:.1f} % of t_stat"
        )
        return first < 0.5 * second, text

    (faster, absolute), (_, relative) = settled(P0, "p0"), settled(steady, "their own end")
    return [
        claim(
            "3.3",
            "stress falls in fast regions and rises in those that first wear little",
            f"fast rings carry {carried[0]:.1f} % of the force at the start, {carried[1]:.1f} % in "
            "the 10 % state and "
            f"{carried[-1]:.1f} % in the end; the centre ring {forces[0, 0]:.0f} %, "
            f"{forces[1, 0]:.0f} % and 100 % of its "
            "final force",
            carried[1] < carried[0] and (np.diff(forces[:, 0]) > 0).all(),
            f"fast rings fall below their final share ({carried.min():.1f} % at the least) before "
            "they settle",
        ),
        claim(
            "3.3",
            "the constant stress level of fast rings is reached significantly faster",
            absolute,
            faster,
            f"in absolute stress, as Fig. 4 shows it; in relative terms much less so: {relative}, "
            "because their level "
            "follows that of the slow rings to the end",
            "0.1 % of t_stat (sampling)",
        ),
    ]


def _duration(five: FiveRings, relaxation: dict[int, Array]) -> list[Row]:
    slowest = np.array([values[:, 0] for values in relaxation.values()])
    in_fast = slowest / np.maximum(WEAR_RATIOS, 1 / WEAR_RATIOS)
    factors = [values.max() / values.min() for values in (slowest, in_fast)]
    finer = (
        five.reference.wear.relaxation_times[0] / WEAR_RATIO
    )  # in units of the slower coefficient
    error = abs(relaxation[COUNT][WEAR_RATIOS == WEAR_RATIO, 0] / finer - 1)[0]
    times = five.stationary * CURVE[1:]
    rates = np.diff(five.reference.share(times)) / np.diff(times)
    early, late = np.interp(five.times[[1, 5]], (times[1:] + times[:-1]) / 2, rates)
    seventy, coarser = (
        100 * one.time_of(0.7) / one.time_of(STATIONARY) for one in (five.reference, five.coarser)
    )
    least, ended, most = 100 * five.reference.share(five.times[4] / np.array([0.275, 0.27, 0.265]))
    return [
        claim(
            "3.3",
            "the time to the limiting profile is mostly dependent on the lowest wear coefficient",
            "over eight "
            f"decades of k2/k1 and {min(relaxation)} to {max(relaxation)} rings the slowest "
            "relaxation time is "
            f"{slowest.min():.3f} to {slowest.max():.3f} a/(E* k_slow v0), a factor of "
            f"{factors[0]:.1f}; in units of the "
            f"faster coefficient it would be a factor of {factors[1]:.0e}",
            factors[0] < 4,
            f"it is longest, {slowest.max():.4f}, for one material",
            f"{error:.0e} (five rings, against a finer space)",
        ),
        claim(
            "3.3",
            "the profile change slows down as the stress differences get smaller",
            "the displacement grows "
            f"{early / late:.0f} times as fast at 10 % as at 90 %, and ever slower",
            (np.diff(rates) < 0).all(),
        ),
        claim(
            "3.3",
            "for 70 % of the displacement difference only 27 % of the time is needed",
            f"{seventy:.2f} % of the time to {100 * STATIONARY:g} % of the difference",
            abs(seventy - 27) < 0.5,
            "the limit is reached at no finite time; by the printed 27 % the paper's run ended at "
            f"{ended:.2f} % ({least:.2f} to {most:.2f} % by the rounding)",
            f"{abs(coarser - seventy):.0e} (coarser MDR)",
        ),
    ]


def _cost(five: FiveRings) -> Row:
    problem, start = five.reference.problem, time.perf_counter()
    direct.rms_slope(problem.ring_edges, direct.steady_pressures(*problem.rings))
    integrated = time.perf_counter()
    Evolution(problem, five.reference.compliance).states(np.ones(1))
    integration, march = integrated - start, time.perf_counter() - integrated
    return claim(
        "5",
        "direct integration is much faster than MDR for the limiting profile",
        f"{1e3 * integration:.1f} ms against {1e3 * march:.0f} ms for a marched one, here and now",
        integration < march / 3,
        "the march by relaxation modes has no steps: the paper's, which has, is slower still",
    )


def about_gradients(wear: Curves, width: Curves, many: tuple[int, ...]) -> list[Row]:
    """All claims about Figs. 6 (`wear`) and 7 (`width`); `many` rings are held against
    their limit.
    """
    return [
        *_symmetry_and_limit(wear, many),
        *_plateaus(wear),
        *_order(wear),
        *_slow_area(wear, width),
        *_thin_rings(width),
    ]


def _symmetry_and_limit(wear: Curves, many: tuple[int, ...]) -> list[Row]:
    more = {count: direct_gradients(alternating_edges(count), wear.ratios)[0] for count in many}
    curves = {count: values[0] for count, values in wear.direct.items()} | {
        many[-1]: more[many[-1]]
    }
    skew = {
        count: 100 * np.abs(values / values[::-1] - 1).max() for count, values in curves.items()
    }
    line, area = many_rings(EXTREMES, np.ones(1))[:, 0]
    distance = {
        count: 100 * np.abs(values[[0, -1]] / line - 1).max() for count, values in more.items()
    }
    at_hundred = wear.at(100.0)
    nearest = min(at_hundred, key=lambda count: abs(at_hundred[count] - 2.4))
    return [
        claim(
            "4.2, Fig. 6",
            "for h2/h1 = 1 the plots are symmetrical for large numbers of rings",
            f"greatest difference between k2/k1 and k1/k2: {listed(skew, '.2g')}, in percent",
            (np.diff(list(skew.values())) < 0).all() and skew[many[-1]] < 5,
            "symmetric in the limit only, sqrt(1 + (4/g0^2) ((k2 - k1)/(k2 + k1))^2); the "
            "difference falls as "
            f"N^-{falling(skew):.2f}",
        ),
        claim(
            "4.2, Fig. 6",
            "the limiting value for large numbers of rings is about 2.4",
            f"{line:.4f} (line), {area:.4f} (area) = sqrt(1 + 4/g0^2)",
            abs(line - 2.4) < 0.05,
            f"about 2.4 is what {nearest} rings give at k2/k1 = 100, where the gradient is "
            f"{listed(at_hundred)}; the "
            "limit is approached from above at k2/k1 > 1 and from below at k2/k1 < 1; distance at "
            "1e4 and 1e-4: "
            f"{listed(distance, '.2g')}, in percent",
        ),
    ]


def falling(values: dict[int, float]) -> float:
    """Power of the number of rings by which the last two of the values fall."""
    (few, before), (most, last) = list(values.items())[-2:]
    return float(np.log(before / last) / np.log(most / few))


def _plateaus(wear: Curves) -> list[Row]:
    left = []
    for start, end in ((100.0, 1e4), (0.01, 1e-4)):
        values = np.array(
            [
                [list(wear.at(ratio, average).values()) for average in (0, 1)]
                for ratio in (start, end)
            ]
        )
        left.append(100 * np.abs(values[1] / values[0] - 1).max())
    alone = {
        count: direct_gradients(alternating_edges(count), EXTREMES)[0] for count in wear.direct
    }
    apart = max(
        np.abs(values[0, [0, -1]] / alone[count] - 1).max() for count, values in wear.direct.items()
    )
    decades = np.log10(wear.ratios)
    middle = np.abs(decades) <= 2
    changes = [np.abs(np.gradient(values[0], decades)) for values in wear.direct.values()]
    within = min(
        np.trapezoid(one[middle], decades[middle]) / np.trapezoid(one, decades) for one in changes
    )
    steepest = [10 ** abs(decades[one.argmax()]) for one in changes]
    return [
        claim(
            "4.2, Fig. 6",
            "the gradients converge to different values for k2/k1 > 100 and < 0.01",
            f"from 100 to 1e4 they change by at most {left[0]:.1f} %, from 0.01 to 1e-4 by at "
            f"most {left[1]:.1f} %",
            max(left) < 5,
            "what is left at 100 is in proportion to the smaller ratio",
        ),
        claim(
            "4.2, Fig. 6",
            "for very large or small ratios the problem is equivalent to single rings of slower "
            "material",
            f"at 1e4 and 1e-4 the gradient is within {apart:.0e} of that of the slower rings alone",
            apart < 1e-2,
        ),
        claim(
            "4.2 and 5",
            "the gradient is very susceptible for 0.01 < k2/k1 < 100, most of all below a factor "
            "of 10",
            f"{100 * within:.0f} % or more of all change lies between 0.01 and 100; the curves are "
            "steepest at a factor "
            f"of {min(steepest):.1f} to {max(steepest):.1f}",
            within > 0.9 and max(steepest) < 10,
        ),
    ]


def _order(wear: Curves) -> list[Row]:
    slow_outside, fast_outside = wear.at(0.01)[4], wear.at(100.0)[4]
    quotient = {count: value / wear.at(0.01)[count] for count, value in wear.at(100.0).items()}
    lowest = {
        count: values[0].min()
        for count, values in wear.direct.items()
        if values[0].min() < 1 - 1e-6
    }
    below = wear.ratios[wear.direct[2][0] < 1 - 1e-6]
    return [
        claim(
            "4.2 and 5",
            "for very few rings the plots are asymmetrical and depend on the order of the "
            "materials",
            f"gradient at k2/k1 = 100 over that at 0.01: {listed(quotient, '.2f')}",
            quotient[2] > 1.5,
        ),
        claim(
            "4.2, Fig. 6",
            "N = 4: with the slower material outside the gradient is much smaller",
            f"{slow_outside:.3f} against {fast_outside:.3f} (line), {wear.at(0.01, 1)[4]:.3f} "
            "against "
            f"{wear.at(100.0, 1)[4]:.3f} (area)",
            slow_outside < 0.75 * fast_outside,
        ),
        claim(
            "4.2, Fig. 6",
            "for two rings some ratios give a slightly lower gradient than a homogeneous cylinder",
            f"lowest {lowest[2]:.4f} at k2/k1 = {wear.ratios[wear.direct[2][0].argmin()]:.2f}; "
            "below one from "
            f"{below[0]:.2f} to {below[-1]:.2f}",
            2 in lowest,
            f"not for two rings only, but ever less: {listed(lowest, '.4f')}",
        ),
    ]


def _slow_area(wear: Curves, width: Curves) -> list[Row]:
    thick = width.at(10.0)
    difference = max(
        abs(wear.at(WEAR_RATIO_OF_WIDTHS)[count] / value - 1)
        for count, value in width.at(1.0).items()
    )
    slow = {}
    for count in thick:
        punches = (alternating_edges(count, ratio) for ratio in width.ratios)
        slow[count] = np.array(
            [100 * ring_areas(ring_edges)[1::2].sum() / np.pi for ring_edges in punches]
        )
    limit = many_rings(np.array([WEAR_RATIO_OF_WIDTHS]), np.array([10.0, 100.0, 1e4]))[0]
    to_one = (
        all((np.diff(values[0]) < 0).all() for values in width.direct.values())
        and limit[-1] - 1 < 1e-3
    )
    return [
        claim(
            "4.2, Fig. 7",
            "at h2/h1 = 1 the values are those of Fig. 6",
            f"within {difference:.0e}",
            difference < 1e-10,
        ),
        claim(
            "4.2, Fig. 7",
            "the outer ring is of the slower material, and its share increases with h2/h1",
            f"{', '.join(f'{v[0]:.0f} to {v[-1]:.0f} % (N = {n})' for n, v in slow.items())} of "
            "the area",
            all((np.diff(one) > 0).all() for one in slow.values()),
        ),
        claim(
            "4.2, Fig. 7",
            "N = 8, h2/h1 = 10: fast parts have almost no influence, gradient very close to "
            "homogeneous",
            f"{thick[8]:.3f} (line), {width.at(10.0, 1)[8]:.3f} (area)",
            thick[8] < 1.2,
            f"{100 * (thick[8] - 1):.0f} % above the homogeneous punch; the profile is as close "
            "as the small panel shows",
        ),
        claim(
            "4.2, Fig. 7",
            "in all cases the gradient converges to one as h2/h1 increases",
            f"at h2/h1 = 10: {listed(thick)}",
            to_one,
            f"not yet at 10 for many rings, whose limit is {limit[0]:.3f} "
            f"there, {limit[1]:.3f} at 100 and {limit[2]:.5f} at 1e4",
        ),
    ]


def _thin_rings(width: Curves) -> list[Row]:
    values, rings = width.at(0.1), Rings.alternating(8, 0.1, WEAR_RATIO_OF_WIDTHS)
    alone = direct_gradients(rings.ring_edges, EXTREMES)[0, 0]
    carried = (direct.steady_pressures(*rings) * ring_areas(rings.ring_edges))[1::2].sum()
    line, area = width.limit[:, 0]
    gaps = {count: float(line - value) for count, value in values.items()}
    return [
        claim(
            "4.2 and 5, Fig. 7",
            "with a small share of slower material (printed: increased) the gradient is much "
            "higher",
            f"at h2/h1 = 0.1: {listed(values)}",
            min(values.values()) > 2,
            "print error",
        ),
        claim(
            "4.2, Fig. 7",
            "N = 8, h2/h1 = 0.1: equivalent to only the N/2 thin rings pressed into the half-space",
            f"the thin rings carry {100 * carried:.1f} % of the force; alone they would have a "
            f"gradient of {alone:.3f} "
            f"instead of {values[8]:.3f}",
            carried > 0.9 or abs(alone / values[8] - 1) < 0.1,
            f"{100 * (alone / values[8] - 1):.0f} % too high: what the wide rings carry is "
            "little, but not nothing",
        ),
        claim(
            "4.2, Fig. 7",
            "at h2/h1 = 0.1 there is no convergence and the gradient increases with the number of "
            "rings",
            f"it does increase: {listed(values)}",
            (np.diff(list(values.values())) > 0).all(),
            f"convergence is slow, lately as N^-{falling(gaps):.2f}, but it is there: the limit of "
            "many rings is "
            f"{line:.3f} (line), {area:.3f} (area), and the distance to it {listed(gaps, '.2f')}; "
            "it is without bound "
            "only as h2/h1 and k2/k1 both go to zero",
        ),
    ]
