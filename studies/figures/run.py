"""Figures of a run that can go into a paper: drawn without a display, legible in grey.

Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``, lengths by `a`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from ringwear.meshes.radial import Array

if TYPE_CHECKING:
    from ringwear.studies.crosscheck.interior import Interior
    from ringwear.studies.crosscheck.run import Result

D0, P0 = 0.5, 1 / (2 * np.pi)  # of force 1, in natural units
STYLES: dict[str, dict[str, Any]] = {
    "mdr": {"color": "#1f4e79", "linestyle": "-", "linewidth": 2.2, "alpha": 0.55},
    "fem": {
        "color": "#c0392b",
        "linestyle": "--",
        "linewidth": 1.0,
        "marker": "o",
        "markersize": 3,
        "markerfacecolor": "none",
    },
    "direct": {"color": "black", "linestyle": ":", "linewidth": 1.4, "marker": "x", "markersize": 3.5},
    "bem": {"color": "#2e7d32", "linestyle": "-.", "linewidth": 1.0, "marker": "s", "markersize": 3},
}
MOST_STATES = 6


def draw_all(result: Result, out: Path) -> None:
    """Every figure that the run has something for."""
    if result.scene.wear.times:
        draw_states(result, out / "profiles_and_pressures.png")
        draw_history(result, out / "history.png")
    if result.scene.wear.steady:
        draw_steady(result, out / "steady_state.png")
    if result.operators:
        draw_operators(result, out / "operator_difference.png")
    if "fem" in result.models:
        half_space = result.models["fem"].half_space
        assert half_space is not None
        mesher = str(result.models["fem"].settings["mesher"])
        draw_mesh(half_space.solid.mesh, mesher, result.scene.natural.edges, out / "mesh.png")


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained", dpi=200)
    FigureCanvasAgg(figure)
    return figure


def _style(method: str, points: int) -> dict[str, Any]:
    style = dict(STYLES[method])
    if "marker" in style:
        style["markevery"] = max(1, points // 24)
    return style


def shade_rings(axes: Any, edges: Array, wear: Array) -> None:
    """Grey bands over the rings that wear fastest."""
    for inner, outer, fast in zip(edges[:-1], edges[1:], wear > np.sqrt(wear.min() * wear.max()), strict=True):
        if fast:
            axes.axvspan(inner, outer, color="0.9", linewidth=0, zorder=0)
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])


def _by_ring(radii: Array, values: Array, edges: Array) -> tuple[Array, Array]:
    """The curve broken at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, edges[1:-1])
    return np.insert(radii, cuts, edges[1:-1]), np.insert(values, cuts, np.nan)


def _states(times: Array) -> Array:
    """At most six of the times, spread evenly in number, the first and the last among them."""
    return np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_STATES)).round().astype(int))


def draw_states(result: Result, path: Path) -> None:
    """Profiles and pressures at several times, every method over the other (the paper's Fig. 4)."""
    natural = result.scene.natural
    methods = [name for name, outcome in result.outcomes.items() if outcome.profile.size]
    if not methods:
        return
    states = _states(natural.times)
    figure = _figure(2.3 * len(states), 4.6)
    panels = figure.subplots(2, len(states), sharex=True, sharey="row", squeeze=False)
    flat = P0 / np.sqrt(1 - np.minimum(natural.radii, 1 - 1e-9) ** 2) / P0
    tops = []
    for column, state in enumerate(states):
        upper, lower = panels[:, column]
        for method in methods:
            outcome = result.outcomes[method]
            style = _style(method, len(natural.radii))
            upper.plot(natural.radii, outcome.profile[state] / D0, label=method.upper(), **style)
            lower.plot(
                *_by_ring(natural.radii, outcome.pressure[state] / P0, natural.phases[0]), label=method.upper(), **style
            )
            tops.append(np.quantile(outcome.pressure[state] / P0, 0.97))
        lower.plot(natural.radii, flat, color="0.4", linewidth=0.8, linestyle=(0, (1, 2)), label="unworn")
        upper.set_title(f"$t$ = {natural.scene.wear.times[state]:.4g}", fontsize=9)
        lower.set_xlabel("$r/a$")
        for axes in (upper, lower):
            shade_rings(axes, natural.edges, natural.wear)
    panels[0, 0].set_ylabel("worn height $f/d_0$")
    panels[0, 0].invert_yaxis()
    panels[1, 0].set_ylabel("pressure $p/p_0$")
    panels[1, 0].set_ylim(0, 1.25 * max(tops))
    _legend(figure, panels[1, 0])
    figure.suptitle(_title(result, "profiles and pressures; shaded rings wear faster"), fontsize=10)
    figure.savefig(path)


def _legend(figure: Figure, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, fontsize=9)


def _title(result: Result, what: str) -> str:
    return f"{result.scene.title}: {what}" if result.scene.title else what


def draw_history(result: Result, path: Path) -> None:
    """Displacement and RMS gradient over time (the paper's Fig. 5), with the difference FEM - MDR below."""
    natural = result.scene.natural
    methods = [name for name, outcome in result.outcomes.items() if outcome.indentation.size]
    if not methods:
        return
    pair = [name for name in ("fem", "mdr") if name in methods]
    rows = 2 if len(pair) == 2 else 1
    figure = _figure(9, 3.2 + 2.0 * (rows - 1))
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False, height_ratios=[3, 1.6][:rows])
    times = np.array(natural.scene.wear.times)
    quantities = (
        ("displacement_max", D0, "greatest displacement $u_{z,max}/d_0$"),
        ("rms_slope", D0, r"RMS gradient $\nabla f\,a/d_0$"),
    )
    for column, (name, unit, label) in enumerate(quantities):
        axes = panels[0, column]
        for method in methods:
            style = _style(method, 24) | ({"marker": "."} if method == "mdr" else {})
            axes.plot(times, getattr(result.outcomes[method], name) / unit, label=method.upper(), **style)
        steady = [o for o in result.outcomes.values() if o.steady_displacement_max.size]
        if steady:
            level = getattr(steady[0], f"steady_{name}")[0] / unit
            axes.axhline(level, color="0.4", linewidth=0.8, linestyle=(0, (1, 2)), label="steady state")
        axes.set_ylabel(label)
        _time_axis(axes, times)
        if rows == 2:
            difference = getattr(result.outcomes["fem"], name) - getattr(result.outcomes["mdr"], name)
            below = panels[1, column]
            below.axhline(0, color="0.4", linewidth=0.8)
            below.plot(times, difference / unit, color="black", marker="o", markersize=3, linewidth=1)
            below.set_ylabel("FEM − MDR")
            below.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
        panels[-1, column].set_xlabel("time $t$" + (f" ({natural.scene.units})" if natural.scene.units else ""))
    _legend(figure, panels[0, 0])
    figure.suptitle(_title(result, "displacement and gradient over time"), fontsize=10)
    figure.savefig(path)


def _time_axis(axes: Any, times: Array) -> None:
    """Logarithmic over several decades, with room for zero."""
    positive = times[times > 0]
    if len(positive) > 2 and positive[-1] / positive[0] > 50:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.4)
    axes.set_xlim(0, times[-1] * 1.05 if times[-1] > 0 else 1)


def draw_steady(result: Result, path: Path) -> None:
    """Limiting profile and steady pressure, every method over the other."""
    natural = result.scene.natural
    figure = _figure(9, 3.6)
    left, right = figure.subplots(1, 2)
    for method, outcome in result.outcomes.items():
        style = _style(method, len(natural.radii))
        left.plot(natural.radii, outcome.steady_profile / D0, label=method.upper(), **style)
        pressure = _by_ring(natural.radii, outcome.steady_pressure / P0, natural.phases[0])
        right.plot(*pressure, label=method.upper(), **style)
    left.invert_yaxis()
    left.set_ylabel("limiting profile $f_{stat}/d_0$")
    right.set_ylabel("steady pressure $p/p_0$")
    right.set_ylim(bottom=0)
    for axes in (left, right):
        axes.set_xlabel("$r/a$")
        shade_rings(axes, natural.edges, natural.wear)
    _legend(figure, left)
    figure.suptitle(_title(result, "steady state; shaded rings wear faster"), fontsize=10)
    figure.savefig(path)


def draw_operators(result: Result, path: Path) -> None:
    """Relative difference of two methods against the wavelength of the pressure."""
    natural = result.scene.natural
    figure = _figure(6.5, 4.2)
    axes = figure.subplots()
    for row, marker in zip(result.operators, "ox^s", strict=False):
        name = f"{row.methods[0].upper()} against {row.methods[1].upper()}"
        shown = np.maximum(row.differences, 1e-16)
        axes.loglog(row.wavelengths / natural.length, shown, marker, markersize=3, markerfacecolor="none", label=name)
        axes.axhline(row.rings, linewidth=0.8, color="0.4", linestyle="--")
        axes.text(
            0.99, row.rings, "all steady states ", ha="right", va="bottom", fontsize=8, transform=axes.get_yaxis_transform()
        )
    widths = np.diff(natural.edges)
    axes.axvline(2 * widths.min(), linewidth=0.8, color="0.4", linestyle=":")
    axes.text(2 * widths.min(), 0.01, " two rings", fontsize=8, transform=axes.get_xaxis_transform())
    axes.set_xlabel("wavelength of the pressure over $a$")
    axes.set_ylabel(r"relative difference of energy $|\lambda - 1|$")
    axes.legend(frameon=False, fontsize=9)
    figure.suptitle(_title(result, "the methods as operators"), fontsize=10)
    figure.savefig(path)


def draw_stress(result: Result, fields: Interior, path: Path) -> None:
    """Von Mises stress under the rings, at every state whose inside was recovered."""
    natural = result.scene.natural
    shown = range(len(fields.labels))
    figure = _figure(4.4 * len(shown) + 0.8, 4.6)
    panels = figure.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    r, z = fields.points
    beneath = (r < 1.3) & (z > 0.04) & (z < 1.0)
    levels = MaxNLocator(18).tick_values(0, 1.2 * float(fields.von_mises[:, beneath].max() / P0))
    for state, axes in zip(shown, panels, strict=True):
        values = fields.von_mises[state] / P0
        filled = axes.tricontourf(r, z, fields.triangles.T, values, levels, cmap="viridis", extend="max")
        axes.plot([0, 1], [-0.02, -0.02], color="#c0392b", linewidth=2.5)
        axes.plot(natural.edges[1:-1], np.full(len(natural.edges) - 2, -0.045), "v", color="#c0392b", markersize=3)
        axes.set(xlim=(0, 1.3), ylim=(1.0, -0.08), aspect="equal", xlabel="$r/a$")
        axes.set_title("steady state" if fields.labels[state] == "steady" else f"${fields.labels[state]}$", fontsize=9)
    panels[0].set_ylabel("depth $z/a$")
    figure.colorbar(filled, ax=panels, label="von Mises stress over $p_0$", shrink=0.9)
    figure.suptitle(_title(result, "von Mises stress under the rings"), fontsize=10)
    figure.savefig(path)


def draw_mesh(mesh: Any, mesher: str, edges: Array, path: Path) -> None:
    """The whole mesh, the mesh under the punch, and the mesh at the rim."""
    figure = _figure(11, 3.9)
    panels = figure.subplots(1, 3)
    from ringwear.meshes.half_space import contact_radii, truncation

    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    mesh_panel(panels[0], mesh, (0, truncation(mesh)), "whole", "$r/a$")
    mesh_panel(panels[1], mesh, (0, 1.15), "under the punch", "$r/a$")
    panels[1].plot(edges[1:-1], np.full(len(edges) - 2, -0.035), "v", color="#c0392b", markersize=3)
    mesh_panel(panels[2], mesh, (-rim, rim), "at the rim", "$(r-a)/a$", centre=1.0)
    panels[0].set_ylabel("depth $z/a$")
    figure.suptitle(f"half-space mesh by {mesher}; the punch is red, ring edges are marked", fontsize=10)
    figure.savefig(path)


def mesh_panel(axes: Any, mesh: Any, view: tuple[float, float], name: str, label: str, centre: float = 0.0) -> None:
    """The elements in a square view of the surface from `view[0]` to `view[1]`, radii counted from `centre`."""
    low, high = view
    depth = high - low
    corners = mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]
    inside = (corners[:, :, 0].max(axis=1) >= low) & (corners[:, :, 0].min(axis=1) <= high)
    shown = corners[inside & (corners[:, :, 1].min(axis=1) <= depth)]
    width = 0.35 if len(shown) < 3000 else 0.15
    axes.add_collection(PolyCollection(shown, facecolors="none", edgecolors="black", linewidths=width))
    axes.plot([low, min(high, 1 - centre)], [-0.015 * depth] * 2, color="#c0392b", linewidth=2.5)
    axes.set_xlim(low, high)
    axes.set_ylim(depth, -0.06 * depth)
    axes.set_aspect("equal")
    axes.set_title(f"{name}: {len(shown)} elements", fontsize=9)
    power = int(np.floor(np.log10(depth))) if depth < 0.1 else 0
    unit = rf" in $10^{{{power}}}$" if power else ""
    axes.set_xlabel(label + unit)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
