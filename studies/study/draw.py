"""The one figure of all studies: errors over the axis of the study, a panel for each quantity.

A curve is a way. A grey band at the bottom is the error of the reference: below it, errors mean
nothing. Dotted lines have the slopes of the theoretical orders. A region of errors above the
tolerance is shaded. Errors of zero, of solutions that are the reference itself, are drawn as
roundoff; crosses at the upper end of a panel are runs without a result.
"""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

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
from .way import KEYS_OF_STUDIES, Part

if TYPE_CHECKING:
    from matplotlib.axes import Axes

XLABELS = {
    "unknowns": "unknowns",
    "seconds": "processor time (s)",
    "reach": "radius of the mesh / a",
}
KEYS = ("case", "quantity", "when")
"""Columns whose values the titles of panels have, if they differ."""
WITH_SLOPES = {"size": 1.0, "step": 1.0, "reach": -1.0}
"""Abscissas that theory refers to, and the sign of orders over them."""
MOST_COLUMNS, MOST_IN_ROW = 4, 3
"""Greatest number of quantities that have columns, and of panels in a row otherwise."""
MOST_PANELS = 20
"""Greatest number of panels of a figure; with more, each case has a figure."""
LEAST_ERROR, GREATEST_ERROR = 1e-16, 1e3
"""Errors beyond these are drawn at them: roundoff, and the results of an unstable march."""
BELOW = 0.5
"""Distance of the line of an order from the curve of a way, as a factor on the errors."""
PANEL_HEIGHT = 1.75


def titled(*parts: str) -> str:
    """Return the title of a figure from its parts; parts that are empty have no colon."""
    return ": ".join(filter(None, parts))


class _Panel(NamedTuple):
    """Values that the rows of a panel share, and its abscissa, by their columns; and the rows."""

    key: dict[str, str]
    x: str
    rows: pd.DataFrame

    @property
    def part(self) -> Part:
        """The quantity, whose panels are below each other."""
        return Part(self.key["quantity"], self.key["when"])

    @property
    def kind(self) -> tuple[str, ...]:
        """What the panels of a row share."""
        return self.x, self.key["case"], self.key.get("refined", "")


def _panels(table: pd.DataFrame, axes: Sequence[str], y: str) -> list[_Panel]:
    """Return the panels: over each abscissa one for each case, quantity and kind of size."""
    panels = list[_Panel]()
    for x in axes:
        by = ["case", *(["refined"] if x == "size" else []), "quantity", "when"]
        groups = table.dropna(subset=[x, y]).groupby(by, sort=False)
        panels += [_Panel(dict(zip(by, key, strict=True)), x, rows) for key, rows in groups]
    return panels


def figures_of(
    name: str, table: pd.DataFrame, axes: Sequence[str], title: str, **settings: Any
) -> dict[str, Figure]:
    """Return the figure of a study by its name, or of each case if there are many panels."""
    several = len(_panels(table, axes, "error")) > MOST_PANELS
    ways, figures = table.drop_duplicates("way"), dict[str, Figure]()
    looks = looks_of_ways(zip(ways["way"], ways["method"], strict=True))
    for case, rows in table.groupby("case" if several else lambda _: "", sort=False):
        file = f"{name} {case}".strip().replace(" ", "_")
        figures[file] = draw(rows, axes, title=titled(str(case), title), looks=looks, **settings)
    return figures


def draw(
    table: pd.DataFrame,
    axes: Sequence[str] = ("size",),
    y: str = "error",
    orders: pd.DataFrame | None = None,
    title: str = "",
    labels: Mapping[str, str] | None = None,
    looks: Mapping[str, Look] | None = None,
) -> Figure:
    """Draw errors on logarithmic axes, with one legend below all panels.

    Parameters
    ----------
    table : table of `measure`, or rows of it
    axes : columns of the abscissas; each has rows of panels of its own
    y : column of the ordinate
    orders : table of observed orders, whose theoretical orders are drawn as dotted lines
    title : text above the panels
    labels : labels of abscissas by their columns, and of keys that are varied
    looks : looks of ways, by their names
    """
    ways, panels = table.drop_duplicates("way"), _panels(table, axes, y)
    looks = looks or looks_of_ways(zip(ways["way"], ways["method"], strict=True))
    parts = list(dict.fromkeys(panel.part for panel in panels))
    kinds = list(dict.fromkeys(panel.kind for panel in panels))
    count = max(len(panels), 1)
    if len(kinds) > 1 and 1 < len(parts) <= MOST_COLUMNS:
        across = len(parts)
        places = [(kinds.index(panel.kind), parts.index(panel.part)) for panel in panels]
    else:
        across = -(-count // -(-count // MOST_IN_ROW))
        places = [divmod(number, across) for number in range(count)]
    down = 1 + max(row for row, _ in places)
    varied = [name for name in KEYS if len({panel.key[name] for panel in panels}) > 1]
    width = PAGE if across > 1 else 0.62 * PAGE
    height = 0.95 + (PANEL_HEIGHT + 0.3) * down + 0.15 * -(-len(ways) // max(1, int(width / 1.7)))
    with in_style():
        figure, grid = new_panels(width, height, down, across)
        for panel, place in zip(panels, places, strict=False):
            sub, x, rows, case = grid[place], panel.x, panel.rows, panel.key["case"]
            _draw_panel(sub, rows, x, y, looks)
            if orders is not None and len(orders) and x in WITH_SLOPES and y == "error":
                _draw_orders(sub, rows, x, orders, WITH_SLOPES[x])
            if y == "error":
                _shade(sub, rows, x)
            _mark_failures(sub, table[(table["case"] == case) & table["quantity"].isna()], x, looks)
            sub.set_title(_panel_title(panel, varied))
            kind = ", ".join(rows["refined"].dropna().unique()) if x == "size" else x
            name, default = (case, case) if x == "parameter" else (x, kind)
            label = (XLABELS | dict(labels or {})).get(name, default)
            sub.set_xlabel(textwrap.fill(label, 42))
        for place in set(np.ndindex(grid.shape)) - set(places[: len(panels)]):
            grid[place].set_axis_off()
        for row in range(down):
            grid[row, 0].set_ylabel("relative error" if y == "error" else y)
        return complete(figure, [title], list(grid.flat), across=0.52, down=0.66)


def _panel_title(panel: _Panel, varied: list[str]) -> str:
    """Return the title of a panel: the values that differ between panels."""
    words = [panel.key["case"]] if "case" in varied else []
    if {"quantity", "when"} & set(varied) or not words:
        words.append(str(panel.part))
    return "\n".join(textwrap.wrap(": ".join(words), 34))


def _draw_panel(
    axes: "Axes", rows: pd.DataFrame, x: str, y: str, looks: Mapping[str, Look]
) -> None:
    """Draw the curves of a panel, and the spread of seconds."""
    for way, levels in rows.groupby("way", sort=False):
        look, levels = looks[str(way)], levels.sort_values(x) if x == "parameter" else levels
        abscissa = levels[x].to_numpy(float)
        values = levels[y].to_numpy(float)
        if y == "error":
            values = np.clip(np.abs(values), LEAST_ERROR, GREATEST_ERROR)
        axes.plot(abscissa, values, **look)
        if x == "seconds" and "least seconds" in levels and levels["least seconds"].notna().any():
            spread_of = [
                abscissa - levels["least seconds"].to_numpy(float),
                levels["greatest seconds"].to_numpy(float) - abscissa,
            ]
            style: Look = {"fmt": "none", "color": look["color"], "linewidth": 0.6}
            axes.errorbar(abscissa, values, xerr=spread_of, **style)
    places = rows[x].to_numpy(float)
    if y == "error" or (rows[y] > 0).all():
        set_logarithmic(axes, "y")
    else:
        set_linear(axes, "y", most=4)
    if (places > 0).all() and (x != "parameter" or places.max() > 8 * places.min()):
        set_logarithmic(axes, "x")
    else:
        set_linear(axes, "x", most=4)
    axes.margins(x=0.08)
    axes.grid(True, which="major", color="0.92", linewidth=0.5)
    axes.set_axisbelow(True)


def _draw_orders(
    axes: "Axes", rows: pd.DataFrame, x: str, orders: pd.DataFrame, sign: float
) -> None:
    """Draw a dotted line for each theoretical order, below the most accurate way that has it."""
    judged = rows.merge(orders[[*KEYS_OF_STUDIES, "theory"]], on=[*KEYS_OF_STUDIES])
    for order, levels in judged[judged["error"] != 0].groupby("theory"):
        finest = levels.loc[levels["error"].abs().idxmin()]
        lowest = BELOW * abs(finest["error"])
        sizes = levels.loc[levels["way"] == finest["way"], x].to_numpy(float)
        line = lowest * (sizes / finest[x]) ** (sign * float(order))
        axes.plot(sizes, line, color="0.3", linewidth=0.8, linestyle=":", scaley=False)
        axes.annotate(f"{order:.2g}", (finest[x], lowest), fontsize=6, ha="right", va="top")


def _mark_failures(axes: "Axes", failed: pd.DataFrame, x: str, looks: Mapping[str, Look]) -> None:
    """Draw a cross at the upper end of the axes for each run without a result."""
    for way, levels in failed.dropna(subset=[x]).groupby("way", sort=False):
        cross = looks[str(way)] | {"linestyle": "", "marker": "x", "label": None}
        heights = np.full(len(levels), 0.96)
        axes.plot(levels[x], heights, transform=axes.get_xaxis_transform(), **cross)


def _shade(axes: "Axes", rows: pd.DataFrame, x: str) -> None:
    """Shade errors above what is promised, and those below the error of the reference."""
    low, high = axes.get_ylim()
    promised = rows.dropna(subset=["tolerance"]).sort_values(x).drop_duplicates(x)
    if len(promised) > 1 and x == "parameter":
        axes.plot(promised[x], promised["tolerance"], color="0.4", linewidth=0.7)
        axes.fill_between(promised[x], promised["tolerance"], 1e12, color=RED, alpha=0.07, lw=0)
    floor = rows.groupby(x)["reference"].max()
    shade: Look = {"color": "0.93", "linewidth": 0, "zorder": 0}
    if x == "parameter":
        # each value of a key has a reference of its own
        axes.fill_between(floor.index, low / 10, floor, where=floor > low, **shade)
    elif floor.max() > low:
        axes.axhspan(low / 10, floor.max(), **shade)
    axes.set_ylim(low, high)
