"""Figs. 4 and 5 of the paper, redrawn: the states of the running-in, and the gradient over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LightSource
from matplotlib.figure import Figure
from ringwear.meshes.radial import Array
from ringwear.studies.figures.run import STYLES, shade_rings
from ringwear.studies.paper.gradients import homogeneous
from ringwear.studies.paper.running_in import SHARES, STATIONARY, RunningIn, direct_state

DOTTED: dict[str, Any] = {"color": "0.35", "linewidth": 0.9, "linestyle": (0, (1, 2))}


def canvas(width: float, height: float) -> Figure:
    """A figure without a display."""
    figure = Figure(figsize=(width, height), layout="constrained", dpi=160)
    FigureCanvasAgg(figure)
    return figure


def method_style(method: str, points: int, order: int) -> dict[str, Any]:
    """Style of a method's curve; markers of different methods on different points."""
    style = dict(STYLES[method])
    if "marker" in style:
        every = max(1, points // 12)
        style["markevery"] = (order * every // 3, every)
    return style


def foot_legend(figure: Figure, axes: Any) -> None:
    """One legend for all panels, below them."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, fontsize=9)


def draw_states(found: RunningIn, path: Path) -> None:
    """Fig. 4: worn surface, profile, one-dimensional profile and pressure at seven states."""
    natural = found.reference.natural
    radii, columns = natural.radii, len(SHARES)
    figure = canvas(2.05 * columns, 9.4)
    grid = figure.add_gridspec(4, columns, height_ratios=[1.25, 1, 1, 1.15])
    reference = next(iter(found.states.values()))
    depth = float(reference.profile.max())
    limiting, steady_pressure = direct_state(natural)
    # the rim pressure is infinite at the start
    top = 1.3 * max(np.quantile(state.pressure[1:], 0.98) for state in found.states.values())
    rows: list[list[Any]] = [[], [], []]
    for column, share in enumerate(SHARES):
        _surface(figure.add_subplot(grid[0, column], projection="3d"), radii, reference.profile[column], depth)
        for row, panels in enumerate(rows):
            first = panels[0] if panels else None
            axes = figure.add_subplot(grid[row + 1, column], sharey=first)
            panels.append(axes)
            if first is not None:
                axes.tick_params(labelleft=False)
            shade_rings(axes, natural.edges, natural.wear)
        profile, line_profile, pressure = (panels[-1] for panels in rows)
        for order, (method, states) in enumerate(found.states.items()):
            style = method_style(method, len(radii), order) | {"label": method.upper()}
            profile.plot(radii, states.profile[column], **style)
            line_profile.plot(radii, states.line_profile[column], **style)
            pressure.plot(*_broken(radii, states.pressure[column], natural.edges), **style)
        for panel in (profile, line_profile):
            panel.axhline(0, **DOTTED)
        pressure.plot(radii, 1 / np.sqrt(1 - np.minimum(radii, 1 - 1e-9) ** 2), label="unworn", **DOTTED)
        if share == 1:
            style = dict(STYLES["direct"]) | {"markevery": 12, "label": "DIRECT (steady state only)"}
            profile.plot(radii, limiting, **style)
            pressure.plot(*_broken(radii, steady_pressure, natural.edges), **style)
        line_profile.set_xlabel("$x/a$", labelpad=1)
        pressure.set_xlabel("$r/a$")
        time = found.times[column] / found.stationary
        when = f"$t$ = {100 * time:.3g} % of $t_{{stat}}$" if np.isfinite(time) else r"$t \to \infty$"
        least = reference.least_wear[column]
        worn = f"$f_{{min}}$ = {least:.3g} $d_0$" if np.isfinite(least) else "steady state"
        figure.axes[4 * column].set_title(f"{100 * share:.0f} %\n{when}\n{worn}", fontsize=8.5, y=0.93)
    labels = ("profile $(f-f_{min})/d_0$", "1D profile $(g-f_{min})/d_0$", "pressure $p/p_0$")
    for panels, label in zip(rows, labels, strict=True):
        panels[0].set_ylabel(label)
    rows[2][0].set_ylim(0, top)
    rows[0][0].set_ylim(1.1 * depth, -0.15 * depth)
    # a worn rim carries no line density, so that g(a) = d
    rows[1][0].set_ylim(1.2, 1.2 * float(reference.line_profile.min()))
    foot_legend(figure, rows[2][-1])
    figure.suptitle(
        "Fig. 4: five rings, $k_2/k_1$ = 10, $h_2/h_1$ = 1, at shares of the displacement difference; "
        f"$t_{{stat}}$: {100 * STATIONARY:g} %; shaded rings wear faster",
        fontsize=10,
    )
    figure.savefig(path)


def _surface(axes: Any, radii: Array, profile: Array, depth: float) -> None:
    """The face of the punch turned up, heights drawn larger than they are."""
    angle = np.linspace(0, 2 * np.pi, 49)
    chosen = np.unique(np.append(np.arange(0, len(radii), 6), len(radii) - 1))
    r, height = np.append(radii[chosen], 1.0), -np.append(profile[chosen], profile[-1])
    x, y, z = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(height, np.ones_like(angle))
    light = LightSource(azdeg=300, altdeg=40)
    # bright where high, shaded by the slope in polar coordinates, which is what the eye reads
    tone = np.clip(1 + 0.75 * z / depth, 0, 1) * (0.75 + 0.25 * light.hillshade(z, vert_exag=30 / depth, dx=1, dy=1))
    axes.plot_surface(x, y, z, facecolors=np.repeat(tone[..., None], 3, axis=-1), rstride=1, cstride=1, linewidth=0,
                      antialiased=False, shade=False)  # fmt: skip
    axes.set_zlim(-depth, 0.25 * depth)
    axes.set_box_aspect((1, 1, 0.42), zoom=1.5)
    axes.view_init(elev=42, azim=-60)
    axes.set_axis_off()


def _broken(radii: Array, values: Array, edges: Array) -> tuple[Array, Array]:
    """The curve broken at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, edges[1:-1])
    return np.insert(radii, cuts, edges[1:-1]), np.insert(values, cuts, np.nan)


def draw_gradient_history(found: RunningIn, path: Path) -> None:
    """Fig. 5: RMS gradient over time, the states of Fig. 4 marked."""
    figure = canvas(10, 4)
    times = found.curve_times / found.stationary
    marked = found.times[np.isfinite(found.times)]
    at_states = found.reference.gradients(marked)
    panels = figure.subplots(1, 2)
    for axes, average, over in zip(panels, ("line", "area"), homogeneous(), strict=True):
        for order, (method, curves) in enumerate(found.curves.items()):
            axes.plot(times, curves[average], label=method.upper(), **method_style(method, len(times), order))
        axes.plot(marked / found.stationary, at_states[average], "D", color="black", markersize=6, markerfacecolor="white",
                  label="states of Fig. 4", zorder=5)  # fmt: skip
        for share, time, value in zip(SHARES, marked / found.stationary, at_states[average], strict=False):
            offset = (8, 3) if share == 0 else (7, -11)
            axes.annotate(f"{100 * share:.0f} %", (time, value), offset, textcoords="offset points", fontsize=8)
        axes.axhline(1, **DOTTED)
        axes.set_xlim(-0.02, times[-1])
        axes.set_ylim(-0.03, 1.09)
        axes.set_xlabel("time $t/t_{stat}$")
        axes.set_ylabel(r"RMS gradient $\nabla f/\nabla f_{stat}$")
        axes.set_title(f"average over the {'radius (line)' if average == 'line' else 'area'}", fontsize=9)
        stationary = float(found.reference.steady["steady_rms_slope" + ("_area" if average == "area" else "")][0])
        # force 1 makes the mean pressure 1/pi
        scale = stationary * np.pi / over
        second = axes.secondary_yaxis("right", functions=(lambda v, s=scale: v * s, lambda v, s=scale: v / s))
        second.set_ylabel(r"over the homogeneous punch, $\nabla f/\nabla f_0$")
    foot_legend(figure, panels[0])
    figure.suptitle("Fig. 5: gradient of the worn surface, five rings, $k_2/k_1$ = 10, $h_2/h_1$ = 1", fontsize=10)
    figure.savefig(path)
