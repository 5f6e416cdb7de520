"""Draw Figs. 4 to 7 of the paper anew."""

from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure

from ...mdr import D0, direct
from ..crosscheck import Rings
from ..figures.style import (
    FAINT,
    LINES,
    broken_at,
    legend_of,
    method_curve,
    new_figure,
    set_linear,
    shade_rings,
)
from .theory import FIG7_WEAR_RATIO, STATE_PERCENTAGES, STATIONARY_FRACTION

AVERAGES = ("average over the radius (line)", "average over the area")
FIVE_RINGS = "five rings, $k_2/k_1$ = 10, $h_2/h_1$ = 1"


def draw_states(states: xarray.Dataset) -> Figure:
    """Draw Fig. 4: profile, one-dimensional profile and pressure in seven states."""
    rings, radii = Rings.alternating(5, 1.0, 10.0), states.radius.values
    figure = new_figure(1.5 * len(STATE_PERCENTAGES), 6.2)
    panels = figure.subplots(3, len(STATE_PERCENTAGES), sharex=True, sharey="row")
    fields = {
        "f_over_d0": "profile $(f-f_{min})/d_0$",
        "g_over_d0": "1D profile $(g-f_{min})/d_0$",
        "p_over_p0": "pressure $p/p_0$",
    }
    for state, percent in enumerate(STATE_PERCENTAGES):
        least_wear = float(states.least_wear_over_d0[0, state])
        time_label = f"$t$ = {float(states.time[state]):.1%} of $t_{{stat}}$"
        wear_label = f"$f_{{min}}$ = {least_wear:.3g} $d_0$"
        title = (
            f"{percent} %\n{time_label}\n{wear_label}" if percent < 100 else "100 %\nsteady state\n"
        )
        panels[0, state].set_title(title, fontsize=8.5)
        panels[2, state].plot(radii, 1 / np.sqrt(1 - radii**2), label="unworn", **FAINT)
        panels[2, state].set_xlabel("$r/a$, $x/a$")
        for field, axes in zip(fields, panels[:, state], strict=True):
            state_values = states[field].isel(time=state)
            curves = {
                solver: state_values.sel(solver=solver).values for solver in states.solver.values
            }
            if percent == 100 and field != "g_over_d0":
                curves["direct"] = states[f"limiting_{field}"].values
            for order, (solver, values) in enumerate(curves.items()):
                # markers of different methods are at different points
                look = method_curve(solver, len(radii)) | {"markevery": (9 * order, 28)}
                axes.plot(*broken_at(rings.ring_edges, radii, values), **look)
            shade_rings(axes, rings.ring_edges, rings.wear_coefficients[0])
    for axes, label in zip(panels[:, 0], fields.values(), strict=True):
        axes.set_ylabel(label)
        set_linear(axes, "y", most=4)
    panels[0, 0].invert_yaxis()
    # at a worn rim the line density is zero, so that g(a) = d; at the start the pressure at the rim
    # is infinite: limit the axes
    panels[1, 0].set_ylim(1.2, 1.2 * float(states.g_over_d0.min()))
    panels[2, 0].set_ylim(0, 1.3 * np.quantile(states.p_over_p0[:, 1:], 0.98))
    legend_of(figure, panels[2, -1:])
    figure.suptitle(
        f"Fig. 4: {FIVE_RINGS}, by the displacement difference relative to the steady state; "
        f"$t_{{stat}}$: {STATIONARY_FRACTION:.1%}; shaded rings wear faster",
        fontsize=10,
    )
    return figure


def draw_history(states: xarray.Dataset, history: xarray.DataArray) -> Figure:
    """Draw Fig. 5: RMS gradient over time, with marks at the states of Fig. 4."""
    figure = new_figure(10, 4)
    panels = figure.subplots(1, 2, sharey=True)
    times = history.time.values
    for average, axes in enumerate(panels):
        gradient = history.isel(average=average)
        for order, solver in enumerate(history.solver.values):
            look = method_curve(solver, len(times)) | {"markevery": (4 * order, 12)}
            axes.plot(times, gradient.sel(solver=solver), **look)
        marks = gradient.sel(solver="mdr", time=states.time[:-1])
        mark_look = {"markerfacecolor": "white", "zorder": 5, "label": "states of Fig. 4"}
        axes.plot(marks.time, marks, "kD", **mark_look)
        for percent, *position in zip(
            STATE_PERCENTAGES, marks.time.values, marks.values, strict=False
        ):
            label_position = {"xytext": (8, -9), "textcoords": "offset points", "fontsize": 8}
            axes.annotate(f"{percent} %", position, **label_position)
        axes.axhline(1, **FAINT)
        axes.set(xlabel="time $t/t_{stat}$", title=AVERAGES[average])
    panels[0].set(ylim=(-0.09, 1.09), ylabel=r"RMS gradient $\nabla f/\nabla f_{stat}$")
    legend_of(figure, panels[:1])
    figure.suptitle(f"Fig. 5: gradient of the worn surface, {FIVE_RINGS}", fontsize=10)
    return figure


def draw_gradients(number: int, curves: xarray.Dataset) -> Figure:
    """Draw Fig. 6 or 7: gradient over a ratio, and limiting profiles of two punches."""
    ratios, fem = curves.ratio.values, method_curve("fem") | {"linestyle": "none"}
    if number == 6:
        ratio, constant = "wear ratio $k_2/k_1$", "$h_2/h_1$ = 1"
        punches = {value: Rings.alternating(4, 1.0, value) for value in (0.01, 100.0)}
    else:
        ratio, constant = "width ratio $h_2/h_1$", "$k_2/k_1$ = 0.01"
        punches = {value: Rings.alternating(8, value, FIG7_WEAR_RATIO) for value in (0.1, 10.0)}
    figure = new_figure(10, 4.4)
    panels: Any = figure.subplot_mosaic("012\n013", width_ratios=[3, 3, 1.3])
    for average, title in enumerate(AVERAGES):
        axes, gradient = panels[str(average)], curves.isel(gradient_average=average)
        limit = {"color": "0.65", "linewidth": 2.6, "label": r"$N \to \infty$"}
        axes.plot(ratios, gradient.limit, **limit)
        for count, line in zip(curves.rings.values, LINES, strict=False):
            look = {"color": "black", "linestyle": line, "label": f"$N$ = {count}"}
            axes.plot(ratios, gradient.direct.sel(rings=count), **look)
        axes.plot(ratios, gradient.fem, **fem)
        axes.axhline(1, **FAINT)
        axes.set(xscale="log", xlim=ratios[[0, -1]], xlabel=ratio, title=title)
        axes.set_ylabel(r"RMS gradient $\nabla f/\nabla f_0$")
    radii = np.linspace(0, 1, 600)
    for panel, (value, rings) in zip("23", punches.items(), strict=True):
        axes = panels[panel]
        edges, (wear_coefficients, _) = rings
        pressures = direct.steady_pressures(edges, wear_coefficients)
        profile = direct.limiting_profile(edges, pressures, radii)
        axes.plot(radii, profile / D0, color="black")
        shade_rings(axes, edges, wear_coefficients)
        axes.invert_yaxis()
        axes.set_ylabel("$f_{stat}/d_0$")
        count, symbol = len(rings.widths), ratio.split()[-1]
        axes.set_title(f"$N$ = {count}, {symbol} = {value:g}", fontsize=9)
    legend_of(figure, [panels["0"]])
    figure.suptitle(
        f"Fig. {number}: RMS gradient of the limiting profile over the {ratio}, {constant}",
        fontsize=10,
    )
    return figure
