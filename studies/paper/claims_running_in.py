"""What the paper says about the running-in (section 3.3, Figs. 4 and 5), checked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.radial import Array
from ringwear.studies.figures.run import D0, P0
from ringwear.studies.paper.claims import Claim
from ringwear.studies.paper.relaxation import WEAR_RATIOS, Spectrum
from ringwear.studies.paper.running_in import RINGS, STATIONARY, WEAR_RATIO, Evolution, RunningIn, direct_state
from scipy.optimize import brentq

SETTLED = 0.1  # relative distance of a ring's force from its steady value at which its stress level counts as reached


def running_in_claims(found: RunningIn, spectrum: Spectrum) -> list[Claim]:
    """All claims about the running-in, in the paper's order."""
    return [
        _methods_match(found),
        _wear_everywhere(found),
        _piecewise_constant(found),
        *_stress_levels(found),
        _edge_first(found),
        _fast_rings_first(found),
        _load_moves(found),
        _fast_settle_first(found),
        _slowest_coefficient(found, spectrum),
        _slowing_down(found),
        _time_of_seventy(found),
        _gradient_first(found),
        _same_limit(found),
    ]


def _spread(found: RunningIn, quantity: Callable[[Evolution], float]) -> tuple[float, str]:
    """A quantity by the reference method, and its greatest difference by a coarser space or another method."""
    value = quantity(found.reference)
    others = [found.coarser, *list(found.evolutions.values())[1:]]
    return value, f"{max(abs(quantity(other) - value) for other in others):.0e} ({_names(found)}, and a coarser MDR)"


def _names(found: RunningIn) -> str:
    return ", ".join(name.upper() for name in found.states)


def _methods_match(found: RunningIn) -> Claim:
    first, *others = found.states.values()
    profile = max(float(np.abs(other.profile - first.profile).max()) for other in others)
    scale = np.linalg.norm(first.pressure, axis=1)
    pressure = max(float((np.linalg.norm(o.pressure - first.pressure, axis=1) / scale)[1:].max()) for o in others)
    whose = "" if "bem" in found.states else "; finite elements take the place of the paper's boundary elements"
    return Claim(
        "3.3, Fig. 4",
        "MDR and BEM match within a small tolerance",
        f"{_names(found)}: profiles within {profile:.1e} d0, pressures after the start within {pressure:.1e} (root mean "
        "square over the radius)",
        "this is the uncertainty",
        profile < 0.01 and pressure < 0.01,
        f"at t = 0 the pressure is infinite at the rim, where no pointwise comparison means anything{whose}",
    )


def _wear_everywhere(found: RunningIn) -> Claim:
    lowest, uncertainty = _spread(found, lambda evolution: float(evolution.states(found.times).pressure.min()))
    return Claim(
        "3.3",
        "wear occurs on all parts of the cylinder",
        f"p is at least {lowest:.3f} p0 in all states",
        uncertainty,
        lowest > 0,
    )


def _piecewise_constant(found: RunningIn) -> Claim:
    late = 3 * found.stationary
    states = found.reference.states(np.array([late, np.inf]))
    left = float(np.abs(states.pressure[0] / states.pressure[1] - 1).max())
    at_end = found.reference.states(np.array([found.stationary, np.inf]))
    before = float(np.abs(at_end.pressure[0] / at_end.pressure[1] - 1).max())
    return Claim(
        "3.3, Eq. 24",
        "the stress of the limiting profile is piecewise constant, p1 > p2",
        f"pressures are within {before:.1e} of constants at t_stat and within {left:.1e} at 3 t_stat",
        "the march knows nothing of Eq. 24",
        left < 1e-3,
    )


def _stress_levels(found: RunningIn) -> list[Claim]:
    edges, wear = found.reference.natural.phases
    pressures = direct.steady_pressures(edges, wear) / P0
    slow, fast = float(pressures.max()), float(pressures.min())
    marched = found.reference.states(np.array([10 * found.stationary])).pressure[0]
    error = f"closed form; the march ends within {max(abs(marched.max() - slow), abs(marched.min() - fast)):.0e}"
    return [
        Claim("3.3", "slow rings: more than three times p0", f"{slow:.4f} p0", error, slow > 3),
        Claim("3.3", "fast rings: less than half of p0", f"{fast:.4f} p0", error, fast < 0.5),
    ]


def _worn(evolution: Evolution, time: float, radii: Array) -> Array:
    """Worn height f/d0 at some radii."""
    states = evolution.states(np.array([time]))
    return np.interp(radii, evolution.natural.radii, states.profile[0] + states.least_wear[0])


def _edge_first(found: RunningIn) -> Claim:
    def excess(evolution: Evolution) -> float:
        edges = evolution.natural.edges
        rim, middle = _worn(evolution, found.times[1], np.array([1.0, (edges[-2] + edges[-1]) / 2]))
        return float(rim / middle)

    value, uncertainty = _spread(found, excess)
    return Claim(
        "3.3",
        "the profile changes very quickly close to the edge",
        f"in the 10 % state the rim has worn {value:.2f} times as much as the middle of its ring",
        uncertainty,
        value > 2,
    )


def _fast_rings_first(found: RunningIn) -> Claim:
    def lead(evolution: Evolution) -> float:
        natural = evolution.natural
        at_middles = _worn(evolution, found.times[1], (natural.edges[1:] + natural.edges[:-1]) / 2)
        fast = natural.wear == natural.wear.max()
        return float(at_middles[fast].min() / at_middles[~fast].max())

    value, uncertainty = _spread(found, lead)
    return Claim(
        "3.3",
        "it changes quicker in regions of higher wear coefficient",
        f"in the 10 % state the middles of fast rings have worn at least {value:.2f} times as much as those of slow ones",
        uncertainty,
        value > 1,
    )


def _load_moves(found: RunningIn) -> Claim:
    finite = found.times[np.isfinite(found.times)]
    forces = found.reference.ring_forces(finite)
    natural = found.reference.natural
    fast = natural.wear == natural.wear.max()
    steady = direct.steady_pressures(*natural.phases) * np.diff(natural.edges**2) * np.pi
    share = forces[:, fast] @ steady[fast]
    centre = forces[:, 0]
    return Claim(
        "3.3",
        "stress falls in fast regions and rises in those that first wear little",
        f"fast rings carry {100 * share[0]:.1f} % of the force at the start, {100 * share[1]:.1f} % in the 10 % state and "
        f"{100 * steady[fast].sum():.1f} % in the end; the centre ring {100 * centre[0]:.0f} %, {100 * centre[1]:.0f} % and "
        "100 % of its final force",
        "read off Fig. 4",
        bool(share[1] < share[0]) and bool(np.all(np.diff(centre) > 0)),
        f"fast rings fall below their final share ({100 * share.min():.1f} % at the least) before they settle"
        if share.min() < 0.99 * steady[fast].sum()
        else "",
    )


def _settling(evolution: Evolution, rings: Array, latest: float, over: Array) -> float:
    """First time after which the mean stresses of the rings stay within `SETTLED` of their end, in units of `over`."""
    times = latest * np.linspace(0, 1, 2001) ** 3
    distance = np.abs(evolution.ring_forces(times) - 1) * direct.steady_pressures(*evolution.natural.phases) / over
    return float(times[np.flatnonzero((distance[:, rings] > SETTLED).any(axis=1))[-1] + 1])


def _fast_settle_first(found: RunningIn) -> Claim:
    natural = found.reference.natural
    fast = natural.wear == natural.wear.max()
    steady = direct.steady_pressures(*natural.phases)
    told, ratios = [], []
    for over, unit in ((np.full_like(steady, P0), "p0"), (steady, "their own end")):
        times = [
            100 * _settling(found.reference, rings, 2 * found.stationary, over) / found.stationary for rings in (fast, ~fast)
        ]
        ratios.append(times[0] / times[1])
        told.append(
            f"within {SETTLED:g} of {unit} fast rings stay after {times[0]:.1f} %, slow rings after {times[1]:.1f} % "
            "of t_stat"
        )
    return Claim(
        "3.3",
        "the constant stress level of fast rings is reached significantly faster",
        told[0],
        "0.1 % of t_stat (sampling)",
        ratios[0] < 0.5,
        f"in absolute stress, as Fig. 4 shows it; in relative terms much less so: {told[1]}, because their level follows "
        "that of the slow rings to the end"
        if ratios[1] > 0.5
        else "",
    )


def _slowest_coefficient(found: RunningIn, spectrum: Spectrum) -> Claim:
    finer = found.reference.wear.relaxation_times[0] / WEAR_RATIO  # in units of the slower coefficient
    error = abs(spectrum.times[RINGS][np.abs(WEAR_RATIOS - WEAR_RATIO).argmin(), 0] / finer - 1)
    slowest = np.array([times[:, 0] for times in spectrum.times.values()])
    in_fast = slowest / np.maximum(WEAR_RATIOS, 1 / WEAR_RATIOS)
    return Claim(
        "3.3",
        "the time to the limiting profile is mostly dependent on the lowest wear coefficient",
        f"over eight decades of k2/k1 and {min(spectrum.times)} to {max(spectrum.times)} rings the slowest relaxation time "
        f"is {slowest.min():.3f} to {slowest.max():.3f} a/(E* k_slow v0), a factor of {slowest.max() / slowest.min():.1f}; "
        f"in units of the faster coefficient it would be a factor of {in_fast.max() / in_fast.min():.0e}",
        f"{error:.0e} (five rings, against a finer space)",
        slowest.max() < 4 * slowest.min(),
        f"it is longest, {spectrum.homogeneous:.4f}, for one material",
    )


def _slowing_down(found: RunningIn) -> Claim:
    times = found.curve_times[1:]
    rates = np.diff(found.reference.share(times)) / np.diff(times)
    states = found.times[[1, 5]]
    at_states = np.interp(states, (times[1:] + times[:-1]) / 2, rates)
    return Claim(
        "3.3",
        "the profile change slows down as the stress differences get smaller",
        f"the displacement grows {at_states[0] / at_states[1]:.0f} times as fast at 10 % as at 90 %, and ever slower "
        "in between"
        if np.all(np.diff(rates) < 0)
        else "the rate is not monotonic",
        "read off Fig. 5",
        bool(np.all(np.diff(rates) < 0)),
    )


def _time_of_seventy(found: RunningIn) -> Claim:
    seventy = {id(e): e.time_of(0.7) for e in (found.coarser, *found.evolutions.values())}
    share, uncertainty = _spread(found, lambda evolution: 100 * seventy[id(evolution)] / evolution.time_of(STATIONARY))
    early = seventy[id(found.reference)]

    def end(printed: float) -> float:
        return 100 * float(brentq(lambda level: early / found.reference.time_of(level) - printed, 0.9, 0.9999, xtol=1e-6))

    return Claim(
        "3.3",
        "for 70 % of the displacement difference only 27 % of the time is needed",
        f"{share:.2f} % of the time to {100 * STATIONARY:g} % of the displacement difference",
        uncertainty,
        abs(share - 27) < 0.5,
        "the limit is reached at no finite time; the printed 27 % tells where the paper's run ended: at "
        f"{end(0.27):.2f} % ({end(0.275):.2f} to {end(0.265):.2f} % by the rounding)",
    )


def _gradient_first(found: RunningIn) -> Claim:
    at_seventy = found.reference.gradients(found.times[4:5])
    line, area = (100 * float(at_seventy[name][0]) for name in ("line", "area"))
    _, uncertainty = _spread(found, lambda evolution: 100 * float(evolution.gradients(found.times[4:5])["line"][0]))
    return Claim(
        "3.3, Fig. 5",
        "this behaviour is also observed in the gradient",
        f"in the 70 % state the gradient has reached {line:.1f} % (line) or {area:.1f} % (area) of its stationary value",
        uncertainty,
        min(line, area) > 70,
    )


def _same_limit(found: RunningIn) -> Claim:
    profile, _ = direct_state(found.reference.natural)
    last = {name: float(np.abs(states.profile[-1] - profile).max()) for name, states in found.states.items()}
    late = found.reference.states(np.array([10 * found.stationary]))
    marched = float(np.abs(late.profile[0] - profile).max())
    told = ", ".join(f"{name.upper()} {value:.0e}" for name, value in last.items())
    return Claim(
        "5",
        "the same limiting profile can be computed by both methods",
        f"greatest difference from direct integration over d0: {told}; the march after 10 t_stat {marched:.0e}",
        f"this is the uncertainty; d0 itself is {D0:g} F/(a E*)",
        max(*last.values(), marched) < 1e-3,
    )
