"""The states that the slider of the page goes through.

Profiles and pressures from the start to the steady state.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...meshes.radial import Array, ring_of
from ..crosscheck.dataset import Result
from ..figures.scale import Scale
from ..methods.base import Solution
from ..methods.quantities import array
from ..methods.sampler import Sampler
from ..problem.problem import Problem

COUNT = 48
# radii of a slide, so that a page of hundreds of rings stays small
MOST_RADII = 1100
# part of the radius that the greatest difference of heights is drawn as, in 3-D
DRAWN_HEIGHT = 0.3


def slides(result: Result) -> dict[str, Any] | None:
    """What the script of the page draws, in the units of its axes.

    Nothing where no state is known over the radius.
    """
    problem = replace(result.scene.problem, output_radii=None)
    problem = replace(problem, output_radii=problem.radii[:: _every(problem)])
    found = _running_in(result, problem) or _as_given(result)
    if found is None:
        return None
    radii, labels, profiles, pressures = found
    scale, rings = Scale(result.scene), problem.rings
    profiles = profiles - profiles.min(axis=1, keepdims=True)
    deepest = float(profiles.max()) or 1.0
    # of heights over radii, as they are
    steepness = deepest * problem.units.displacement / problem.units.length
    order = np.log(rings.wear_coefficients)
    shade = (order - order.min()) / (np.ptp(order) or 1.0)
    return {
        "radii": _short(radii * scale.radius.factor),
        "edges": _short(rings.ring_edges * scale.radius.factor),
        "shade": _short(shade),
        "ring": ring_of(rings.ring_edges, radii).tolist(),
        "labels": labels,
        "profile": [_short(row * scale.height.factor) for row in profiles],
        "pressure": [_short(row * scale.pressure.factor) for row in pressures],
        "highest": 1.15 * float(np.quantile(pressures, 0.98)) * scale.pressure.factor,
        "deepest": deepest * scale.height.factor,
        "drawn": DRAWN_HEIGHT,
        "magnified": f"{DRAWN_HEIGHT / steepness:.3g}",
        "axes": {
            "radius": _plain(scale.radius.label("radius", "r")),
            "profile": _plain(scale.height.label("worn height less its least", "f")),
            "pressure": _plain(scale.pressure.label("pressure", "p")),
        },
    }


def _running_in(result: Result, problem: Problem) -> tuple[Array, list[str], Array, Array] | None:
    """Radii, labels, profiles and pressures of the first method that knows every time."""
    wears = {name: one for name, one in result.solutions.items() if one.wear is not None}
    if not len(problem.times) or not wears:
        return None
    solution = next(iter(wears.values()))
    assert solution.wear is not None
    times = slide_times(problem, solution)
    sampler, scale = Sampler(problem, solution.wear.compliance.space), Scale(result.scene)
    history = sampler.history(solution.wear.modal(times))
    left = solution.wear.left(times)
    labels = [
        f"{scale.when(time * problem.units.time)}, {100 * (1 - share):.3g} % run in"
        if time
        else f"{scale.when(0.0)}, unworn"
        for time, share in zip(times, left, strict=True)
    ]
    profiles, pressures = array(history, "profile"), array(history, "pressure")
    if problem.steady:
        steady = sampler.steady(solution.wear.steady)
        labels.append("steady state")
        profiles = np.vstack([profiles, array(steady, "steady_profile")])
        pressures = np.vstack([pressures, array(steady, "steady_pressure")])
    return problem.radii, labels, profiles, pressures


def slide_times(problem: Problem, solution: Solution) -> Array:
    """The start, then times in equal ratios until the last one asked for, or until the punch has
    run in.
    """
    assert solution.wear is not None
    done = solution.wear.time_to(0.995)
    first = problem.earliest or 1e-3 * done
    return np.concatenate(
        [[0.0], np.geomspace(first, max(float(problem.times[-1]), done, 2 * first), COUNT)]
    )


def _as_given(result: Result) -> tuple[Array, list[str], Array, Array] | None:
    """The times asked for, and the steady state, by the first method that gives most of it over
    more than a few radii.
    """
    scale, problem = Scale(result.scene), result.scene.problem
    known = [
        one.results
        for one in result.solutions.values()
        if {"profile", "steady_profile"} & set(one.results)
    ]
    if not known or len(problem.radii) <= 10:
        return None
    best = max(known, key=lambda one: ("profile" in one, "steady_profile" in one))
    shown = slice(None, None, _every(problem))
    labels, profiles, pressures = list[str](), list[Array](), list[Array]()
    if "profile" in best:
        times = array(best, "time")
        some = np.unique(np.linspace(0, len(times) - 1, min(len(times), COUNT)).round().astype(int))
        labels += [
            f"{scale.when(time * problem.units.time)}{'' if time else ', unworn'}"
            for time in times[some]
        ]
        profiles += list(array(best, "profile")[some][:, shown])
        pressures += list(array(best, "pressure")[some][:, shown])
    if "steady_profile" in best:
        labels.append("steady state")
        profiles.append(array(best, "steady_profile")[shown])
        pressures.append(array(best, "steady_pressure")[shown])
    return problem.radii[shown], labels, np.array(profiles), np.array(pressures)


def _every(problem: Problem) -> int:
    """Which of the radii a slide shows."""
    return -(-len(problem.radii) // MOST_RADII)


def _short(values: Array) -> list[float]:
    """Numbers to four digits, which a screen cannot tell from more."""
    return [float(f"{value:.4g}") for value in values]


def _plain(label: str) -> str:
    """A label without mathtext."""
    return label.replace("$", "").replace("_0", "₀")
