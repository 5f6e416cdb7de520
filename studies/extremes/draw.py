"""The figure of the panels: errors relative to the promised accuracy, and the naive solver."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import (
    FixedFormatter,
    FixedLocator,
    LogLocator,
    MaxNLocator,
    NullLocator,
    StrMethodFormatter,
)

from ..crosscheck import Array
from ..figures.style import PAGE, RED, Look
from .panels import NAIVE, Panel
from .verdicts import MEANINGS, in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST_DRAWN_ERROR, GREATEST_DRAWN_ERROR = 1e-4, 1e5
"""Ends of the axis of errors relative to the promised accuracy.

Smaller errors are drawn at the lower end, greater ones as triangles at the upper end.
"""
COLUMNS = 4
"""Number of panels in a row."""
LOOKS: dict[str, tuple[str, str, str]] = {
    "mdr": ("#1f4e79", "o", "MDR"),
    "bem": ("#2e7d32", "s", "BEM"),
    "fem": (RED, "D", "FEM"),
    "fem, clamped": ("#e09a00", "^", "FEM, clamped boundary"),
    "mdr, implicit": ("#6fa8dc", "v", "MDR, implicit Euler"),
    "mdr, explicit": ("#8e44ad", "<", "MDR, explicit Euler"),
    NAIVE: ("0.45", "X", "naive finite elements"),
}
"""Colour, marker and label of each method."""
VERDICT_MARKERS: dict[str, Look] = {
    "degraded": {"marker": "o", "markersize": 7, "markeredgecolor": "black"},
    "wrong": {"marker": "x", "markersize": 8, "markeredgecolor": "black"},
    "refused": {"marker": "_", "markersize": 8, "markeredgecolor": "0.3"},
    "crashed": {"marker": "*", "markersize": 9, "markeredgecolor": "black"},
}
"""Marker that is added at runs of each verdict except `within`."""
ESTIMATE_DASHES = (0, (4, 2))
"""Line style of the error estimates."""


def draw_panels(panels: Sequence[Panel], rows: pd.DataFrame) -> Figure:
    """Draw a panel for each parameter that has rows in the table.

    Parameters
    ----------
    panels : the panels in the order in which they are drawn
    rows : rows of the table, one for each run
    """
    drawn = [panel for panel in panels if (rows.family == panel.name).any()]
    grid_rows = -(-len(drawn) // COLUMNS)
    height = 1.0 + 1.75 * grid_rows
    figure = Figure(figsize=(1.35 * PAGE, height), dpi=200)
    grid = figure.subplots(grid_rows, COLUMNS, squeeze=False, sharey=True).ravel()
    for axes, panel in zip(grid, drawn, strict=False):
        _draw_panel(axes, panel, rows[rows.family == panel.name])
    for number, axes in enumerate(grid):
        if number % COLUMNS == 0:
            axes.set_ylabel("error / promised error", fontsize=7)
        axes.set_visible(number < len(drawn))
    ringwear_rows = rows[rows.method != NAIVE]
    counts = {verdict: int((ringwear_rows.verdict == verdict).sum()) for verdict in MEANINGS}
    figure.suptitle(in_words(counts, "runs at the extremes"), y=1 - 0.07 / height, fontsize=9)
    figure.legend(
        handles=_handles(),
        loc="lower center",
        ncols=7,
        frameon=False,
        fontsize=6.6,
        bbox_to_anchor=(0.5, 0.12 / height),
    )
    figure.text(
        0.5,
        0.05 / height,
        "Greatest error and greatest estimate of each run, relative to the tolerance (to twice the "
        "tolerance if contact edges move). Naive finite elements: indentation and pressure only.",
        ha="center",
        fontsize=6.2,
        color="0.3",
    )
    figure.subplots_adjust(
        left=0.055,
        right=0.99,
        top=1 - 0.42 / height,
        bottom=0.98 / height,
        wspace=0.08,
        hspace=0.62,
    )
    return figure


def _draw_panel(axes: "Axes", panel: Panel, rows: pd.DataFrame) -> None:
    """Draw the errors of every method over one parameter, and their estimates with dashes."""
    for name, (color, marker, _) in LOOKS.items():
        method_rows = rows[rows.method == name]
        numbers = ["x", "promised", "greatest error", "greatest estimate"]
        method_rows = method_rows.astype(dict.fromkeys(numbers, float)).sort_values("x")
        if not len(method_rows):
            continue
        x = _drawn_positions(panel, method_rows.x.to_numpy())
        relative_errors = method_rows["greatest error"] / method_rows.promised
        errors = _within_axis(relative_errors)
        naive = name == NAIVE
        axes.plot(
            x,
            errors,
            color=color,
            marker=marker,
            markersize=3,
            markerfacecolor="none",
            linewidth={"mdr": 2.2}.get(name, 0.9),
            alpha=0.6 if name == "mdr" else 1.0,
            linestyle=(0, (1, 1)) if naive else "-",
        )
        beyond = (relative_errors > GREATEST_DRAWN_ERROR).to_numpy()
        axes.plot(x[beyond], errors[beyond], linestyle="", marker="^", markersize=4, color=color)
        axes.plot(
            x,
            _within_axis(method_rows["greatest estimate"] / method_rows.promised),
            color=color,
            linestyle=ESTIMATE_DASHES,
            linewidth=0.8,
        )
        for verdict, look in VERDICT_MARKERS.items():
            selected = (method_rows.verdict == verdict).to_numpy()
            # runs that were refused or crashed have no error: they are drawn near the lower end
            height = np.where(np.isfinite(errors), errors, 3 * LEAST_DRAWN_ERROR)
            mark: Look = {"linestyle": "", "markerfacecolor": "none", "markeredgewidth": 0.8} | look
            axes.plot(x[selected], height[selected], **mark)
    axes.axhspan(1, GREATEST_DRAWN_ERROR, color=RED, alpha=0.06, linewidth=0)
    axes.axhline(1, color="0.4", linewidth=0.8)
    axes.text(
        0.03,
        0.97,
        f"naive: {panel.naive_failure}",
        transform=axes.transAxes,
        fontsize=5.4,
        color="0.3",
        va="top",
    )
    axes.set_title(panel.name, fontsize=7.5)
    axes.set_xlabel(panel.xlabel, fontsize=7, labelpad=1)
    # room above the curves for the text about the naive finite elements
    axes.set(yscale="log", ylim=(LEAST_DRAWN_ERROR, 1e3 * GREATEST_DRAWN_ERROR))
    axes.yaxis.set(
        major_locator=FixedLocator([1e-4, 1e-2, 1, 1e2, 1e4]), minor_locator=NullLocator()
    )
    axes.tick_params(labelsize=6)
    axes.grid(True, axis="y", color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    _set_ticks(axes, panel)


def _set_ticks(axes: "Axes", panel: Panel) -> None:
    """Set the ticks of the parameter axis; a logarithmic one may show zero at its end."""
    if panel.linear:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        return
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    # on less than two decades, powers of ten would be too few ticks
    subs = (1.0, 2.0, 5.0) if high < 100 * low else (1.0,)
    axes.xaxis.set(major_locator=LogLocator(subs=subs, numticks=6), minor_locator=NullLocator())
    if high < 100 * low:
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    if panel.zero_at is not None:
        ticks = [panel.zero_at, 1e-6, 1e-4, 1e-2, 1.0]
        labels = ["0", *(f"$10^{{{round(np.log10(tick))}}}$" for tick in ticks[1:])]
        axes.xaxis.set(major_locator=FixedLocator(ticks), major_formatter=FixedFormatter(labels))


def _drawn_positions(panel: Panel, x: Array) -> Array:
    """Return the positions on the axis at which values of the parameter are drawn."""
    return x if panel.zero_at is None else np.where(x == 0, panel.zero_at, x)


def _within_axis(errors: pd.Series) -> Array:
    """Return errors clipped to the ends of the axis."""
    return np.asarray(errors.clip(LEAST_DRAWN_ERROR, GREATEST_DRAWN_ERROR).to_numpy())


def _handles() -> list[Line2D]:
    """Return the entries of the legend: methods, error estimates and verdicts."""
    handles = [
        Line2D(
            [],
            [],
            color=color,
            marker=marker,
            markersize=3.2,
            linewidth=1,
            linestyle=(0, (1, 1)) if name == NAIVE else "-",
            markerfacecolor="none",
            label=label,
        )
        for name, (color, marker, label) in LOOKS.items()
    ]
    dashed: Look = {"color": "0.3", "linestyle": ESTIMATE_DASHES, "linewidth": 0.8}
    handles.append(Line2D([], [], **dashed, label="the method's error estimate"))
    handles += [
        Line2D([], [], linestyle="", markerfacecolor="none", **look, label=verdict)
        for verdict, look in VERDICT_MARKERS.items()
    ]
    beyond: Look = {"linestyle": "", "marker": "^", "markersize": 4, "color": "0.45"}
    return [*handles, Line2D([], [], **beyond, label=f"above {GREATEST_DRAWN_ERROR:.0e}")]
