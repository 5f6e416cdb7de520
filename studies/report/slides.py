"""The states that the slider of the page goes through.

Profiles and pressures from the start to the steady state.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array, ring_of
from ..crosscheck.dataset import Result
from ..figures.scale import Scale, shown_times
from ..methods.quantities import array
from ..methods.sampler import Sampler

COUNT = 48


def slides(result: Result) -> dict[str, Any] | None:
    """Return what the script of the page draws, in the units of its axes.

    Nothing where no state is known over the radius.
    """
    scale, rings = Scale(result.scene), result.scene.problem.rings
    radii, labels, profiles, pressures, steady = _at_any_time(result) or _as_computed(result)
    if steady is not None:
        labels = [*labels, "steady state"]
        profiles = np.vstack([profiles, array(steady, "steady_profile")])
        pressures = np.vstack([pressures, array(steady, "steady_pressure")])
    if not labels or len(radii) <= 10:
        return None
    # so that a page of hundreds of rings stays small
    step = -(-len(radii) // 1100)
    radii, pressures, heights = radii[::step], pressures[:, ::step], profiles[:, ::step]
    heights = heights - heights.min(axis=1, keepdims=True)
    deepest = float(heights.max()) or 1.0
    # part of the radius that the greatest difference of heights is drawn as, in 3-D
    drawn = 0.3
    order = np.log(rings.wear_coefficients)
    return {
        "radii": _short(radii * scale.radius.factor),
        "edges": _short(rings.ring_edges * scale.radius.factor),
        "shade": _short((order - order.min()) / (np.ptp(order) or 1.0)),
        "ring": ring_of(rings.ring_edges, radii).tolist(),
        "labels": labels,
        "profile": _short(heights * scale.height.factor),
        "pressure": _short(pressures * scale.pressure.factor),
        "highest": 1.15 * float(np.quantile(pressures, 0.98)) * scale.pressure.factor,
        "deepest": deepest * scale.height.factor,
        "drawn": drawn,
        "magnified": f"{drawn * scale.radius.stored / scale.height.stored / deepest:.3g}",
        "axes": {
            name: label.replace("$", "").replace("_0", "₀")
            for name, label in (
                ("radius", scale.radius.label("radius", "r")),
                ("profile", scale.height.label("worn height less its least", "f")),
                ("pressure", scale.pressure.label("pressure", "p")),
            )
        },
    }


States = tuple[Array, list[str], Array, Array, xarray.Dataset | None]
"""Radii, labels of the times, profiles and pressures (times, radii), and the steady state."""


def _at_any_time(result: Result) -> States | None:
    """Sample the first method that knows every time: at the start, then at times in equal ratios
    until the last one asked for, or until the punch has run in.
    """
    problem, scale = replace(result.scene.problem, output_radii=None), Scale(result.scene)
    wears = [solution.wear for solution in result.solutions.values() if solution.wear is not None]
    if not wears or not len(problem.times):
        return None
    done = wears[0].time_to(0.995)
    first = problem.earliest or 1e-3 * done
    last = max(float(problem.times[-1]), done, 2 * first)
    times = np.array([0.0, *np.geomspace(first, last, COUNT)])
    sampler = Sampler(problem, wears[0].compliance.space)
    history = sampler.history(wears[0].modal(times))
    labels = [
        f"{scale.when(time * scale.time.stored)}, {100 * (1 - left):.3g} % run in"
        for time, left in zip(times, wears[0].left(times), strict=True)
    ]
    steady = sampler.steady(wears[0].steady) if problem.steady else None
    return problem.radii, labels, array(history, "profile"), array(history, "pressure"), steady


def _as_computed(result: Result) -> States:
    """Take some of the times asked for, and the steady state, by the first method that gives most
    of it.
    """
    problem, when = result.scene.problem, Scale(result.scene).when
    results = max(
        (solution.results for solution in result.solutions.values()),
        key=lambda results: ("profile" in results, "steady_profile" in results),
    )
    steady = results if "steady_profile" in results else None
    if "profile" not in results:
        none = np.empty((0, len(problem.radii)))
        return problem.radii, [], none, none, steady
    states = shown_times(problem, COUNT)
    labels = [when(result.scene.wear.times[state]) for state in states]
    profiles, pressures = (array(results, name)[states] for name in ("profile", "pressure"))
    return problem.radii, labels, profiles, pressures, steady


def _short(values: Array) -> Any:
    """Return numbers to four digits, which a screen cannot tell from more."""
    return [_short(row) if np.ndim(row) else float(f"{row:.4g}") for row in values]
