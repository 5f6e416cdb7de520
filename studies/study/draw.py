"""The one figure of all studies: errors over the axis of the study, a panel for each quantity.

A curve is a way. A grey band at the bottom is the error of the reference: below it, errors mean
nothing. Dotted lines have the slopes of the theoretical orders. A region of errors above the
tolerance is shaded. Errors of zero, of solutions that are the reference itself, are drawn as
roundoff; crosses at the upper end of a panel are runs without a result.
"""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

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
KEY = ("x", "case", "kind", "quantity", "when")
"""What the rows of a panel share: the abscissa, the case, what the size is, and the quantity."""
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


def _panels(table: pd.DataFrame, axes: Sequence[str], y: str) -> list[tuple[Any, pd.DataFrame]]:
    """Return the panels: over each abscissa one for each case, kind of size and quantity.

    Each has its key, the values of `KEY`, and its rows, with the abscissa as `place`.
    """
    over_axes = [
        table.assign(x=x, place=table[x], kind=table["refined"] if x == "size" else "")
        for x in axes
    ]
    rows = pd.concat(over_axes).dropna(subset=["place", y])
    return list(rows.groupby(list(KEY), sort=False))


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
    table : table of `measure`, or rows of it; sizes below a column `unresolved` are shaded
    axes : columns of the abscissas; each has rows of panels of its own
    y : column of the ordinate
    orders : table of observed orders, whose theoretical orders are drawn as dotted lines
    title : text above the panels
    labels : labels of abscissas by their columns, and of keys that are varied
    looks : looks of ways, by their names
    """
    ways, panels = table.drop_duplicates("way"), _panels(table, axes, y)
    looks = looks or looks_of_ways(zip(ways["way"], ways["method"], strict=True))
    # panels of a row share abscissa, case and kind of size, those of a column the quantity
    kinds = list(dict.fromkeys(key[:3] for key, _ in panels))
    parts = list(dict.fromkeys(Part(*key[3:]) for key, _ in panels))
    cases = {case for _, case, *_ in kinds}
    places = [(kinds.index(key[:3]), parts.index(Part(*key[3:]))) for key, _ in panels]
    down, across = len(kinds), len(parts)
    if down == 1 or not 1 < across <= MOST_COLUMNS:
        count = max(len(panels), 1)
        down = -(-count // MOST_IN_ROW)
        across = -(-count // down)
        places = [divmod(number, across) for number in range(count)]
    width = PAGE if across > 1 else 0.62 * PAGE
    height = 0.95 + (PANEL_HEIGHT + 0.3) * down + 0.15 * -(-len(ways) // max(1, int(width / 1.7)))
    with in_style():
        figure, grid = new_panels(width, height, down, across)
        for (key, rows), place in zip(panels, places, strict=False):
            sub, (x, case, kind, *part) = grid[place], key
            _draw_panel(sub, rows, x, y, looks)
            if orders is not None and len(orders) and x in WITH_SLOPES and y == "error":
                _draw_orders(sub, rows, orders, WITH_SLOPES[x])
            if y == "error":
                _shade(sub, rows, x)
            _mark_failures(sub, table[(table["case"] == case) & table["quantity"].isna()], x, looks)
            alone = len(parts) == 1 < len(cases)
            name = titled(case * (len(cases) > 1), "" if alone else str(Part(*part)))
            sub.set_title(textwrap.fill(name, 34))
            by_key = x == "parameter"
            label = (XLABELS | dict(labels or {})).get(case if by_key else x)
            sub.set_xlabel(textwrap.fill(label or (case if by_key else kind or x), 42))
        for place in set(np.ndindex(grid.shape)) - set(places[: len(panels)]):
            grid[place].set_axis_off()
        for row in range(down):
            grid[row, 0].set_ylabel("relative error" if y == "error" else y)
        return complete(figure, [title], list(grid.flat), across=0.52, down=0.66)


def _draw_panel(
    axes: "Axes", rows: pd.DataFrame, x: str, y: str, looks: Mapping[str, Look]
) -> None:
    """Draw the curves of a panel, and the spread of seconds."""
    by_key = x == "parameter"
    for way, levels in rows.groupby("way", sort=False):
        look, levels = looks[str(way)], levels.sort_values("place") if by_key else levels
        abscissa = levels["place"].to_numpy(float)
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
    places = rows["place"].to_numpy(float)
    if y == "error" or (rows[y] > 0).all():
        set_logarithmic(axes, "y")
    else:
        set_linear(axes, "y", most=4)
    if (places > 0).all() and (not by_key or places.max() > 8 * places.min()):
        set_logarithmic(axes, "x")
    else:
        set_linear(axes, "x", most=4)
    axes.margins(x=0.08)
    axes.grid(True, which="major", color="0.92", linewidth=0.5)
    axes.set_axisbelow(True)


def _draw_orders(axes: "Axes", rows: pd.DataFrame, orders: pd.DataFrame, sign: float) -> None:
    """Draw a dotted line for each theoretical order, below the most accurate way that has it."""
    judged = rows.merge(orders[[*KEYS_OF_STUDIES, "theory"]], on=[*KEYS_OF_STUDIES])
    for order, levels in judged[judged["error"] != 0].groupby("theory"):
        finest = levels.loc[levels["error"].abs().idxmin()]
        lowest = BELOW * abs(finest["error"])
        sizes = levels.loc[levels["way"] == finest["way"], "place"].to_numpy(float)
        line = lowest * (sizes / finest["place"]) ** (sign * float(order))
        axes.plot(sizes, line, color="0.3", linewidth=0.8, linestyle=":", scaley=False)
        axes.annotate(f"{order:.2g}", (finest["place"], lowest), fontsize=6, ha="right", va="top")


def _mark_failures(axes: "Axes", failed: pd.DataFrame, x: str, looks: Mapping[str, Look]) -> None:
    """Draw a cross at the upper end of the axes for each run without a result."""
    for way, levels in failed.dropna(subset=[x]).groupby("way", sort=False):
        cross = looks[str(way)] | {"linestyle": "", "marker": "x", "label": None}
        heights = np.full(len(levels), 0.96)
        axes.plot(levels[x], heights, transform=axes.get_xaxis_transform(), **cross)


def _shade(axes: "Axes", rows: pd.DataFrame, x: str) -> None:
    """Shade what is beyond a tolerance, the error of the reference, or the size of the elements."""
    low, high = axes.get_ylim()
    promised = rows.dropna(subset=["tolerance"]).sort_values("place").drop_duplicates("place")
    if len(promised) > 1 and x == "parameter":
        ends = promised["place"], promised["tolerance"]
        axes.plot(*ends, color="0.4", linewidth=0.7)
        axes.fill_between(*ends, 1e12, color=RED, alpha=0.07, lw=0)
    floor = rows.groupby("place")["reference"].max()
    shade: Look = {"color": "0.93", "linewidth": 0, "zorder": 0}
    if x == "parameter":
        # each value of a key has a reference of its own
        axes.fill_between(floor.index, low / 10, floor, where=floor > low, **shade)
    elif floor.max() > low:
        axes.axhspan(low / 10, floor.max(), **shade)
    if "unresolved" in rows:
        left, _ = axes.get_xlim()
        unresolved = "waves finer than the elements"
        axes.axvspan(left, rows["unresolved"].min(), label=unresolved, **shade)
        axes.set_xlim(left=left)
    axes.set_ylim(low, high)
