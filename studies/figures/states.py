"""Profiles and pressures over the radius.

At several times (the paper's Fig. 4), and in the steady state.

Profiles are shown less what has worn off everywhere, which the figure names: it may be most of it.
"""

import numpy as np
from matplotlib.figure import Figure

from ..outcome.outcome import Outcome
from .scale import Scale, high_pressure, least_wear, panel_tops, shown_times
from .style import FAINT, PAGE, RED, complete, new_panels


def draw_states(result: Outcome) -> Figure:
    """Draw profiles and pressures at several times, every method over the other.

    Of a punch that is not flat, the neighbourhood of the contact is shown.
    """
    scale, problem = Scale(result.scene), result.scene.problem
    states = shown_times(problem.times, 2 if scale.many_rings else 5)
    radii, length = result.coordinates["radius"], problem.units.length
    figure, panels = new_panels(PAGE, 4.0, 2, len(states))
    unworn = problem.profile(problem.radii) * problem.units.displacement
    deep, high = [], []
    for state, (upper, lower) in zip(states, panels.T, strict=True):
        profiles, pressures = (result.by_method(name, state) for name in ("profile", "pressure"))
        worn = float(min(least_wear(problem, heights) for heights in profiles.values()))
        profiles = {method: heights - worn for method, heights in profiles.items()}
        scale.plot_radial(upper, "profile", radii, profiles)
        scale.plot_radial(lower, "pressure", radii, pressures)
        faces = (
            scale.shown("profile", unworn),
            scale.shown("profile", next(iter(profiles.values()))),
        )
        places = scale.shown("radius", radii)
        upper.plot(places, faces[0], **FAINT, label="unworn punch")
        upper.fill_between(places, *faces, color=RED, alpha=0.15, linewidth=0, label="worn off")
        touching = np.array([values > 0 for values in pressures.values()]).any(axis=0)
        reach = min(1.25 * radii[touching].max(initial=0.0), length) or length
        near = radii <= reach
        deep.append(max(np.fmax.reduce(heights[near]) for heights in [*profiles.values(), unworn]))
        high.append(max(high_pressure(values) for values in pressures.values()))
        upper.set_xlim(0, scale.shown("radius", reach))
        lower.set_xlim(upper.get_xlim())
        less = ""
        if worn > 1e-6 * problem.units.displacement:
            less = f" − {scale.names.write(worn, 'displacement', 2)}"
        upper.set_title(f"{scale.when(result.coordinates['time'][state])}\nΔf = f{less}")
        upper.xaxis.set_visible(False)
    for row, name, heights in zip(panels, ("profile", "pressure"), (deep, high), strict=True):
        tops = scale.shown(name, panel_tops(heights))
        for axes, top in zip(row, tops, strict=True):
            # worn down: what is missing below
            axes.set_ylim((1.08 * top, -0.06 * top) if name == "profile" else (0, 1.25 * top))
            axes.yaxis.set_major_formatter("{x:g}")
            if not np.ptp(tops):
                axes.label_outer()
            if axes is not row[0]:
                axes.set_ylabel("")
    titles = result.scene.title, "profiles and pressures"
    return complete(figure, titles, panels[:, 0], _shaded(scale), across=0.4)


def draw_steady(result: Outcome) -> Figure:
    """Draw limiting profile and steady pressure, every method over the other."""
    scale, names = Scale(result.scene), ("steady_profile", "steady_pressure")
    figure, panels = new_panels(PAGE, 2.8, columns=2)
    for axes, name in zip(panels[0], names, strict=True):
        scale.plot_radial(axes, name, result.coordinates["radius"], result.by_method(name))
    panels[0, 0].invert_yaxis()
    panels[0, 1].set_ylim(bottom=0)
    return complete(figure, (result.scene.title, "steady state"), panels[0, :1], _shaded(scale))


def _shaded(scale: Scale) -> str:
    """Say what is shaded, where anything is."""
    return "shaded: rings that wear faster" if np.ptp(scale.problem.wear_coefficients) else ""
