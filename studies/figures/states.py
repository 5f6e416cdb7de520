"""Profiles and pressures over the radius.

At several times (the paper's Fig. 4), and in the steady state.

Profiles are shown less their least wear, which the figure names: most of what has worn is the same
everywhere.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck.dataset import Result
from ..problem.problem import P0
from .scale import MANY, Scale, shown_times
from .style import FAINT, PAGE, complete, hide_inner_ticks, new_panels


def draw_states(result: Result) -> Figure:
    """Draw profiles and pressures at several times, every method over the other."""
    scale, many = Scale(result.scene), has_many_rings(result)
    states = shown_times(scale.problem, 3 if many else 6)
    radii = result.coordinates["radius"]
    if many:
        figure, panels = new_panels(PAGE, 0.7 + 2.5 * len(states), 2 * len(states), sharex=True)
        pairs = panels.reshape(-1, 2)
    else:
        width = 0.6 + 1.1 * max(len(states), 3)
        figure, panels = new_panels(width, 4.0, 2, len(states), sharex=True)
        pairs = panels.T
    high = []
    for state, (upper, lower) in zip(states, pairs, strict=True):
        upper.sharey(pairs[0, 0])
        lower.sharey(pairs[0, 1])
        profiles, pressures = (result.by_method(name, state) for name in ("profile", "pressure"))
        worn = float(min(heights.min() for heights in profiles.values()))
        profiles = {method: heights - worn for method, heights in profiles.items()}
        scale.plot_radial(upper, "profile", radii, profiles)
        scale.plot_radial(lower, "pressure", radii, pressures)
        # pressures are infinite here and there
        high += [np.quantile(values[np.isfinite(values)], 0.97) for values in pressures.values()]
        _draw_unworn(upper, lower, scale)
        when = scale.when(float(result.coordinates["time"][state]))
        less = f" − {scale.worn(worn)}" if worn else ""
        upper.set_title((": " if many else "\n").join([when, f"Δf = f{less}"]))
        hide_inner_ticks(upper)
        hide_inner_ticks(lower)
    # worn down: what is missing below
    pairs[0, 0].invert_yaxis()
    pairs[0, 1].set_ylim(0, 2 * scale.shown("pressure", np.median(high)))
    gaps = {"down": 0.3} if many else {"across": 0.24}
    return _complete(figure, result, "profiles and pressures", pairs[0], scale, **gaps)


def draw_steady(result: Result) -> Figure:
    """Draw limiting profile and steady pressure, every method over the other."""
    scale, rows = Scale(result.scene), 2 if has_many_rings(result) else 1
    figure, panels = new_panels(PAGE, 1.3 + 1.5 * rows, rows, 3 - rows, sharex=True)
    upper, lower = panels.flat
    for axes, name in ((upper, "steady_profile"), (lower, "steady_pressure")):
        scale.plot_radial(axes, name, result.coordinates["radius"], result.by_method(name))
    upper.invert_yaxis()
    lower.set_ylim(bottom=0)
    upper.label_outer()
    return _complete(figure, result, "steady state", [upper], scale, across=0.56)


def has_many_rings(result: Result) -> bool:
    return len(result.scene.problem.wear_coefficients) > MANY


def _draw_unworn(upper: Any, lower: Any, scale: Scale) -> None:
    """Draw the face before wear, less its least height; of a flat punch, the pressure."""
    problem, look = scale.problem, FAINT | {"label": "unworn punch"}
    length, height = problem.units.length, problem.units.displacement
    if problem.full_contact:
        radii = np.linspace(0, 1, 400)[:-1]
        pressure = P0 * problem.units.pressure / np.sqrt(1 - radii**2)
        axes, name, values = lower, "pressure", pressure
    else:
        radii = problem.radii
        heights = problem.profile(radii)
        axes, name, values = upper, "profile", (heights - heights.min()) * height
    axes.plot(scale.shown("radius", radii * length), scale.shown(name, values), **look)


def _complete(
    figure: Figure, result: Result, what: str, axes: Any, scale: Scale, **gaps: float
) -> Figure:
    """Say what is shaded, where anything is, and what the axes are over."""
    shaded = "shaded: rings that wear faster" if np.ptp(scale.problem.wear_coefficients) else ""
    note = "; ".join(filter(None, (shaded, scale.note)))
    return complete(figure, (result.scene.title, what), axes, note, **gaps)
