"""Profiles and pressures over the radius.

At several times (the paper's Fig. 4), and in the steady state.

Profiles are shown less what has worn off everywhere, which the figure names: it may be most of it.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..problem.problem import P0
from .scale import MANY, Scale, high_pressure, least_wear, panel_tops, shown_times
from .style import FAINT, PAGE, RED, complete, hide_inner_ticks, new_panels


def draw_states(result: Result) -> Figure:
    """Draw profiles and pressures at several times, every method over the other.

    Of a punch that is not flat, the neighbourhood of the contact is shown.
    """
    scale, many = Scale(result.scene), has_many_rings(result)
    problem, shaped = scale.problem, not scale.problem.full_contact
    states = shown_times(problem.times, 3 if many else 5 if shaped else 6)
    radii = result.coordinates["radius"]
    if many:
        figure, panels = new_panels(PAGE, 0.7 + 2.5 * len(states), 2 * len(states))
        pairs = panels.reshape(-1, 2)
    else:
        width = min(PAGE, 0.6 + (1.32 if shaped else 1.1) * max(len(states), 3))
        figure, panels = new_panels(width, 4.0, 2, len(states))
        pairs = panels.T
    deep, high = [], []
    for state, (upper, lower) in zip(states, pairs, strict=True):
        profiles, pressures = (result.by_method(name, state) for name in ("profile", "pressure"))
        worn = float(min(least_wear(problem, heights) for heights in profiles.values()))
        profiles = {method: heights - worn for method, heights in profiles.items()}
        scale.plot_radial(upper, "profile", radii, profiles)
        scale.plot_radial(lower, "pressure", radii, pressures)
        unworn = _draw_unworn(upper, lower, scale, next(iter(profiles.values())))
        touching = np.array([values > 0 for values in pressures.values()]).any(axis=0)
        length = problem.units.length
        reach = min(1.25 * radii[touching].max(initial=0.0), length) or length
        near = radii <= reach
        deep += [max(np.fmax.reduce(heights[near]) for heights in [*profiles.values(), unworn])]
        high += [max(high_pressure(values) for values in pressures.values())]
        upper.set_xlim(0, scale.shown("radius", reach))
        lower.set_xlim(upper.get_xlim())
        when = scale.when(float(result.coordinates["time"][state]))
        less = f" − {scale.worn(worn)}" if worn > 1e-6 * problem.units.displacement else ""
        upper.set_title((": " if many else "\n").join([when, f"Δf = f{less}"]))
    differ = False
    for name, row, heights in (("profile", pairs[:, 0], deep), ("pressure", pairs[:, 1], high)):
        tops = scale.shown(name, panel_tops(heights))
        for axes, top in zip(row, tops, strict=True):
            # worn down: what is missing below
            axes.set_ylim((1.08 * top, -0.06 * top) if name == "profile" else (0, 1.25 * top))
            axes.yaxis.set_major_formatter("{x:g}")
            hide_inner_ticks(axes, values_differ=len(set(tops)) > 1)
        differ |= len(set(tops)) > 1
    gaps = {"down": 0.3} if many else {"across": 0.42 if differ else 0.24}
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


def _draw_unworn(upper: Any, lower: Any, scale: Scale, worn: Array) -> Array:
    """Draw the face before wear, and what (R,) heights have lost of it; of a flat punch the
    pressure, too. Return the unworn heights (R,).
    """
    problem, look = scale.problem, FAINT | {"label": "unworn punch"}
    radii = scale.shown("radius", problem.radii * problem.units.length)
    unworn = problem.profile(problem.radii) * problem.units.displacement
    if problem.full_contact:
        inside = np.linspace(0, 1, 400)[:-1]
        pressure = P0 * problem.units.pressure / np.sqrt(1 - inside**2)
        places = scale.shown("radius", inside * problem.units.length)
        lower.plot(places, scale.shown("pressure", pressure), **look)
    else:
        faces = scale.shown("profile", unworn), scale.shown("profile", worn)
        upper.plot(radii, faces[0], **look)
        upper.fill_between(radii, *faces, color=RED, alpha=0.15, linewidth=0, label="worn off")
    return unworn


def _complete(
    figure: Figure, result: Result, what: str, axes: Any, scale: Scale, **gaps: float
) -> Figure:
    """Say what is shaded, where anything is, and what the axes are over."""
    shaded = "shaded: rings that wear faster" if np.ptp(scale.problem.wear_coefficients) else ""
    note = "; ".join(filter(None, (shaded, scale.note)))
    return complete(figure, (result.scene.title, what), axes, note, **gaps)
