"""The one figure of all studies: errors in panels, over size, unknowns, seconds or a parameter.

A curve is a way. What a panel shows beside the curves follows from the columns of the table:

- error estimates, if they are drawn, are dashed; a region of errors above the tolerance is shaded;
- a grey band at the bottom is the error of the reference: below it, errors mean nothing;
- slope triangles are the theoretical orders, if `orders` are given and the abscissa is the size;
- marks at the lower end of a panel are errors of zero: the solution is the reference itself;
- circles, crosses and dashes mark the verdicts on runs, if the table has a column `verdict`.
"""

import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...meshes import Array
from ..figures.style import (
    PAGE,
    RED,
    Look,
    complete,
    in_style,
    looks_of_ways,
    new_panels,
    set_linear,
    set_logarithmic,
)
from .way import Part

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

ABSCISSAS = ("size", "unknowns", "seconds")
"""Abscissas of figures that a user can choose: the size that theory refers to, and costs."""
XLABELS = {"unknowns": "unknowns", "seconds": "processor time (s)"}
MOST_COLUMNS = 4
ESTIMATE: Look = {"linestyle": (0, (4, 2)), "linewidth": 0.8}
"""Line of the error estimates."""
VERDICT_MARKS: dict[str, Look] = {
    "degraded": {"marker": "o", "markersize": 7, "markeredgecolor": "0.2"},
    "wrong": {"marker": "x", "markersize": 8, "markeredgecolor": "black", "markeredgewidth": 1.4},
    "refused": {"marker": "_", "markersize": 8, "markeredgecolor": "0.2"},
    "crashed": {"marker": "*", "markersize": 9, "markeredgecolor": "black"},
}
"""Marks of runs with other verdicts than `within`."""
GREATEST_ERROR = 1e3
"""Errors above this are drawn at it: the result is meaningless, and the march may be unstable."""
PANEL_WIDTH, PANEL_HEIGHT = PAGE / 4, 1.75
"""Sizes of a panel in inches."""
LABEL_HEIGHT = 0.04
"""Height of the label of a slope triangle, as a fraction of the height of the axes."""


def titled(*parts: str) -> str:
    """Return the title of a figure from its parts; parts that are empty have no colon."""
    return ": ".join(filter(None, parts))


def draw(
    table: pd.DataFrame,
    x: str = "size",
    panels: Sequence[str] = ("case", "quantity", "when"),
    estimates: bool = False,
    orders: pd.DataFrame | None = None,
    title: str = "",
    xlabel: str = "",
    ylabel: str = "relative error",
    note: str = "",
    same_axes: bool = False,
) -> Figure:
    """Draw errors on logarithmic axes, with one legend below all panels.

    Parameters
    ----------
    table : table of `measure`, or rows of it
    x : column of the abscissa: `size`, `unknowns`, `seconds` or `parameter`
    panels : columns whose values tell the panels apart; those with one value are not in the titles
    estimates : whether to draw the error estimates, too
    orders : table of observed orders, whose theoretical orders are drawn as triangles
    title, xlabel, ylabel, note : texts above, at the axes and below; by default the abscissa is
        named by the table
    same_axes : whether all panels have the same axes
    """
    ways = table.drop_duplicates("way")
    looks = looks_of_ways(zip(ways["way"], ways["method"], strict=True))
    shown = table.dropna(subset=["error"])
    groups = list(shown.groupby(list(panels), sort=False))
    count = max(len(groups), 1)
    across = 3 if count in (5, 6, 9) else min(MOST_COLUMNS, count)
    down = -(-count // across)
    width = max(0.4 + PANEL_WIDTH * across, 0.62 * PAGE)
    height = 0.95 + (PANEL_HEIGHT + 0.3) * down + 0.15 * -(-len(ways) // max(1, int(width / 1.7)))
    with in_style():
        figure, grid = new_panels(width, height, down, across, sharex=same_axes, sharey=same_axes)
        varied = [n for n in range(len(panels)) if len({key[n] for key, _ in groups}) > 1]
        xlabels = [
            xlabel or XLABELS.get(x) or ", ".join(rows["refined"].unique()) for _, rows in groups
        ]
        many_labels = len(set(xlabels)) > 1
        for number, (axes, (key, rows)) in enumerate(zip(grid.flat, groups, strict=False)):
            _draw_panel(axes, rows, x, looks, estimates, orders)
            axes.set_title(_panel_title(dict(zip(panels, key, strict=True)), panels, varied))
            if number + across >= count or many_labels:
                # the lowest panel of its column, or one with a label of its own
                axes.tick_params(labelbottom=True)
                axes.set_xlabel(textwrap.fill(xlabels[number], 42))
        # the limits of the axes are final only when all panels are drawn
        for axes, (_, rows) in zip(grid.flat, groups, strict=False):
            _complete_panel(axes, rows, table, x, looks)
        for axes in list(grid.flat)[len(groups) :]:
            axes.set_axis_off()
        for axes in grid[:, 0]:
            axes.set_ylabel(ylabel)
        _add_to_legend(grid.flat[0], table, estimates)
        return complete(
            figure, [title], list(grid.flat), note, across=0.5, down=0.62 if many_labels else 0.52
        )


def _panel_title(key: dict[str, str], panels: Sequence[str], varied: Sequence[int]) -> str:
    """Return the title of a panel: the values that differ between panels."""
    words = [str(key[panels[n]]) for n in varied if panels[n] not in ("quantity", "when")]
    if "quantity" in key:
        words.append(str(Part(key["quantity"], key.get("when", "all"))))
    words = words or list(filter(None, map(str, key.values())))
    return "\n".join(textwrap.wrap(": ".join(words), 34))


def _draw_panel(
    axes: "Axes",
    rows: pd.DataFrame,
    x: str,
    looks: dict[str, Look],
    estimates: bool,
    orders: pd.DataFrame | None,
) -> None:
    """Draw the curves of a panel, and triangles of their theoretical orders."""
    # ways of the same order share one triangle, below the lowest of their curves
    triangles = dict[float, tuple[float, Array, Array, str]]()
    for way, levels in rows.groupby("way", sort=False):
        look = looks[str(way)]
        abscissa = levels[x].to_numpy(float)
        errors = np.abs(levels["error"].to_numpy(float))
        _draw_curve(axes, levels, x, look, estimates)
        if orders is not None and len(orders) and x == "size" and len(levels) > 1 and errors[0] > 0:
            fits = orders[(orders["way"] == way) & orders["case"].isin(levels["case"])]
            fits = fits[fits["quantity"].isin(levels["quantity"])]
            fits = fits[fits["when"].isin(levels["when"])]
            for order in fits["expected"].dropna().unique()[:1]:
                if order not in triangles or errors[0] < triangles[order][0]:
                    triangles[order] = errors[0], abscissa, errors, look["color"]
    values = rows[x].to_numpy(float)
    wide = values.max() > 8 * values.min()
    if logarithmic := bool((values > 0).all() and (wide or x != "parameter")):
        set_logarithmic(axes, "y", "x")
    else:
        set_logarithmic(axes, "y")
        set_linear(axes, "x", most=4)
    labels = [
        draw_slope_triangle(axes, abscissa, errors, order, color)
        for order, (_, abscissa, errors, color) in triangles.items()
        if logarithmic
    ]
    if labels:
        # make room for the labels of the triangles
        axes.margins(x=0.14)
        separate(labels, axes)
    elif x == "size":
        axes.margins(x=0.06)
    axes.grid(True, which="major", color="0.92", linewidth=0.5)
    axes.set_axisbelow(True)


def _draw_curve(axes: "Axes", levels: pd.DataFrame, x: str, look: Look, estimates: bool) -> None:
    """Draw the errors of a way, their estimates and verdicts, and the spread of its seconds."""
    abscissa, errors = levels[x].to_numpy(float), levels["error"].to_numpy(float)
    axes.plot(abscissa, _drawn(errors), **look)
    if x == "seconds" and "least seconds" in levels and levels["least seconds"].notna().any():
        least, greatest = (
            levels[f"{which} seconds"].to_numpy(float) for which in ("least", "greatest")
        )
        spread = [abscissa - least, greatest - abscissa]
        axes.errorbar(
            abscissa, _drawn(errors), xerr=spread, fmt="none", color=look["color"], linewidth=0.6
        )
    states_errors = levels["estimate"].notna().any()
    if estimates and states_errors:
        axes.plot(abscissa, _drawn(levels["estimate"]), color=look["color"], **ESTIMATE)
    if "verdict" in levels and states_errors:
        for verdict, mark in VERDICT_MARKS.items():
            selected = (levels["verdict"] == verdict).to_numpy()
            style: Look = {"linestyle": "", "markerfacecolor": "none", **mark}
            axes.plot(abscissa[selected], _drawn(errors)[selected], **style)


def _complete_panel(
    axes: "Axes", rows: pd.DataFrame, table: pd.DataFrame, x: str, looks: dict[str, Look]
) -> None:
    """Shade a panel, and mark what has no place on its axes."""
    _shade(axes, rows, x)
    for way, levels in rows[rows["error"] == 0].groupby("way", sort=False):
        _mark_at_lower_end(axes, levels[x], looks[str(way)] | {"linestyle": ""})
    if x == "parameter" and "verdict" in table:
        for verdict in ("refused", "crashed"):
            lost = table[table["verdict"] == verdict]
            _mark_at_lower_end(axes, lost[x], VERDICT_MARKS[verdict])


def _shade(axes: "Axes", rows: pd.DataFrame, x: str) -> None:
    """Shade errors above the tolerance, and errors below that of the reference."""
    low, high = axes.get_ylim()
    promised = rows.dropna(subset=["tolerance"]).sort_values(x)
    if len(promised) and x in ("size", "parameter"):
        places, line = promised.drop_duplicates(x)[[x, "tolerance"]].to_numpy(float).T
        if len(places) > 1:
            axes.plot(places, line, color="0.4", linewidth=0.7)
            axes.fill_between(places, line, 1e12, color=RED, alpha=0.07, linewidth=0)
    floor = rows.groupby(x, sort=True)["reference"].max()
    if x == "parameter" and len(floor) > 1:
        # each value of the parameter has a reference of its own
        axes.fill_between(
            floor.index, low / 10, floor, color="0.93", linewidth=0, zorder=0, where=floor > low
        )
    elif len(floor) and floor.max() > low:
        axes.axhspan(low / 10, float(floor.max()), color="0.93", linewidth=0, zorder=0)
    axes.set_ylim(low, high)


def _mark_at_lower_end(axes: "Axes", x: pd.Series, mark: Look) -> None:
    """Mark runs whose error has no place on the axis: it is zero, or there is none."""
    style: Look = {"linestyle": "", "markerfacecolor": "none", **mark}
    axes.plot(x, np.full(len(x), 0.04), transform=axes.get_xaxis_transform(), **style)


def _add_to_legend(axes: "Axes", rows: pd.DataFrame, estimates: bool) -> None:
    """Add entries for estimates and verdicts to the legend of the figure."""
    if estimates and rows["estimate"].notna().any():
        axes.plot([], [], color="0.3", label="the method's own estimate", **ESTIMATE)
    if "verdict" not in rows:
        return
    # methods that state no error are not marked, unless they have no result at all
    marked = rows[rows["estimate"].notna() | rows["verdict"].isin(["refused", "crashed"])]
    for verdict, mark in VERDICT_MARKS.items():
        if (marked["verdict"] == verdict).any():
            axes.plot([], [], linestyle="", markerfacecolor="none", label=verdict, **mark)


def _drawn(values: Any) -> Array:
    """Return errors that a logarithmic axis can show: positive ones, up to `GREATEST_ERROR`."""
    errors = np.abs(np.asarray(values, float))
    return np.where(errors > 0, np.minimum(errors, GREATEST_ERROR), np.nan)


def worst(table: pd.DataFrame, by: Sequence[str] = ("case", "way", "level")) -> pd.DataFrame:
    """Return one row for each level: that of its quantity with the greatest error.

    Its estimate and the error of its reference are the greatest of all quantities of the level.
    """
    solved = table.dropna(subset=["error"])
    groups = solved.assign(error=solved["error"].abs()).groupby(list(by), sort=False)
    rows = solved.loc[groups["error"].idxmax()].copy()
    return rows.assign(
        error=rows["error"].abs(),
        estimate=groups["estimate"].max().to_numpy(),
        reference=groups["reference"].max().to_numpy(),
    )


def separate(labels: Iterable["Annotation"], axes: "Axes") -> None:
    """Move labels upwards until none overlaps another. The limits of the axes do not change."""
    low, high = np.log10(axes.get_ylim())
    spacing = LABEL_HEIGHT * (high - low)
    placed = list[tuple[float, float]]()
    for label in sorted(labels, key=lambda each: each.xy[1]):
        x, y = np.log10(label.xy)
        neighbours = [other for other_x, other in placed if np.isclose(other_x, x, atol=0.05)]
        new_y = max([y, *(other + spacing for other in neighbours)])
        label.xy = (label.xy[0], 10**new_y)
        placed.append((x, new_y))


def draw_slope_triangle(
    axes: "Axes", sizes: Array, errors: Array, order: float, color: str
) -> "Annotation":
    """Draw a slope triangle below the first two points of a curve; return its label.

    Parameters
    ----------
    axes : logarithmic axes
    sizes, errors : (n,) points of the curve, from coarse to fine
    order : theoretical order of convergence, which the label shows
    color : colour of the curve
    """
    coarse_size, second_size, *_ = sizes
    middle_size, high_error = np.sqrt(coarse_size * second_size), errors[0] / 2
    low_error = high_error * (middle_size / coarse_size) ** order
    axes.plot(
        [middle_size, coarse_size, coarse_size, middle_size],
        [low_error, low_error, high_error, low_error],
        color=color,
        linewidth=0.6,
    )
    return axes.annotate(
        f"{order:.2g}",
        (coarse_size, np.sqrt(low_error * high_error)),
        xytext=(2, 0),
        textcoords="offset points",
        va="center",
        fontsize=6,
        color=color,
    )
