"""Draw the figures of the study: one panel for each measure or group of ways."""

from collections.abc import Sequence as Listed
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck import Array
from ..figures.style import LINES, complete, new_panels
from ..study.errors_over_size import draw_slope_triangle, separate, set_round_ticks
from ..study.orders import Sequence

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS = {
    "FEM P1": "#e69f00",
    "FEM P2": "#d55e00",
    "FEM P3": "#c0392b",
    "FEM P4": "#7b241c",
    "FEM Q1": "#56b4e9",
    "FEM Q2": "#0072b2",
    "FEM quads": "#4a235a",
    "MDR": "#1f4e79",
    "MDR degree 1": "#1f4e79",
    "MDR degree 2": "#5d8aa8",
    "MDR degree 3": "#16a085",
    "MDR degree 4": "#7f8c8d",
    "BEM": "#2e7d32",
    "BEM degree 1": "#2e7d32",
}
"""Colours of curves by their labels. Other labels get the colours of `SPARE_COLORS` in turn."""
SPARE_COLORS = ("#c0392b", "#0072b2", "#2e7d32", "#e69f00", "#4a235a", "#7f8c8d")
MARKERS = "os^Dvx+*"
MOST_COLUMNS = 4
LABELS = {"unknowns": "number of unknowns", "seconds": "seconds of the level"}
"""Labels of the abscissas other than the size that theory refers to."""


@dataclass(frozen=True)
class Curve:
    """A sequence of errors with its abscissa and label.

    Parameters
    ----------
    label : label of the curve; all sequences with the same elements have the same label
    group : group of ways that are drawn in one figure
    sequence : errors of the levels
    abscissa : (n,) abscissa of each level
    xlabel : label of the abscissa
    by_size : whether the abscissa is the size that theory refers to
    """

    label: str
    group: str
    sequence: Sequence
    abscissa: Array
    xlabel: str
    by_size: bool


@dataclass(frozen=True)
class Panel:
    """The title of a panel, and its curves."""

    title: str
    curves: Listed[Curve]


def draw(title: str, panels: Listed[Panel]) -> Figure:
    """Draw errors on logarithmic axes in panels, with one legend for all panels."""
    columns = max(1, min(3 if len(panels) in (5, 6, 9) else MOST_COLUMNS, len(panels)))
    rows = max(1, -(-len(panels) // columns))
    figure, grid = new_panels(max(2.9 * columns, 5.0), 2.5 * rows + 1.3, rows, columns)
    labels = list(dict.fromkeys(curve.label for panel in panels for curve in panel.curves))
    axes: Axes
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw_panel(axes, panel, labels)
    for axes in grid.flat[len(panels) :]:
        axes.set_axis_off()
    for axes in grid[:, 0]:
        axes.set_ylabel("relative error")
    return complete(figure, [title], list(grid.flat), across=0.5, down=0.72)


def color_of(label: str, labels: list[str]) -> str:
    """Return the colour of the curves with a label, which is one of the labels of the figure."""
    return COLORS.get(label, SPARE_COLORS[labels.index(label) % len(SPARE_COLORS)])


def _draw_panel(axes: "Axes", panel: Panel, labels: list[str]) -> None:
    lowest_curves = dict[float, Curve]()
    for curve in panel.curves:
        number = labels.index(curve.label)
        errors = np.where(curve.sequence.errors > 0, curve.sequence.errors, np.nan)
        axes.loglog(
            curve.abscissa,
            errors,
            label=curve.label,
            color=color_of(curve.label, labels),
            marker=MARKERS[number % len(MARKERS)],
            linestyle=LINES[number % len(LINES)],
            markersize=4,
            markerfacecolor="none",
            linewidth=1.1,
        )
        order = curve.sequence.theory.order
        if curve.by_size and np.isfinite(order) and len(errors) > 1:
            # curves of the same order share one triangle, below the lowest of these curves
            other = lowest_curves.setdefault(order, curve)
            if curve.sequence.errors[0] < other.sequence.errors[0]:
                lowest_curves[order] = curve
    triangles = [
        draw_slope_triangle(
            axes, curve.abscissa, curve.sequence.errors, order, color_of(curve.label, labels)
        )
        for order, curve in lowest_curves.items()
    ]
    # make room for the labels of the triangles
    axes.margins(x=0.12)
    axes.set_title(panel.title, fontsize=8)
    if panel.curves:
        axes.set_xlabel(panel.curves[0].xlabel, fontsize=7)
    set_round_ticks(axes)
    separate(triangles, axes)
    axes.tick_params(labelsize=6)
