"""The one figure of all studies: errors over the axis of the study, a panel for each quantity.

A curve is a way. A grey band at the bottom is the error of the reference: below it, errors mean
nothing. Slope triangles are the theoretical orders. A region of errors above the tolerance is
shaded. Marks at the lower end of a panel are errors of zero, because the solution is the reference
itself; crosses at the upper end are runs without a result.
"""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

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

XLABELS = {
    "unknowns": "unknowns",
    "seconds": "processor time (s)",
    "reach": "radius of the mesh / a",
}
KEYS = ("case", "quantity", "when")
"""Columns whose values the titles of panels have, if they differ."""
ABSCISSAS = ("size", "unknowns", "seconds")
"""Abscissas that a user can choose: the size that theory refers to, and costs."""
WITH_SLOPES = {"size": 1.0, "step": 1.0, "reach": -1.0}
"""Abscissas that theory refers to, and the sign of orders over them."""
MOST_COLUMNS, MOST_IN_ROW = 4, 3
"""Greatest number of quantities that have columns, and of panels in a row otherwise."""
MOST_PANELS = 20
"""Greatest number of panels of a figure; with more, each case has a figure."""
GREATEST_ERROR = 1e3
"""Errors above this are drawn at it: the result is meaningless, and the march may be unstable."""
PANEL_HEIGHT = 1.75
SHARE = 0.07
"""Least width of a slope triangle, as a fraction of the width of the axes."""
LABEL_HEIGHT = 0.06
"""Height of the label of a slope triangle, as a fraction of the height of the axes."""


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
    orders : table of observed orders, whose theoretical orders are drawn as triangles
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
                _draw_slopes(sub, rows, x, looks, orders, WITH_SLOPES[x])
            _complete_panel(sub, rows, table[table["case"] == case], x, y, looks)
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
        values = _drawn(levels[y]) if y == "error" else levels[y].to_numpy(float)
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


def _draw_slopes(
    axes: "Axes",
    rows: pd.DataFrame,
    x: str,
    looks: Mapping[str, Look],
    orders: pd.DataFrame,
    sign: float,
) -> None:
    """Draw triangles of the theoretical orders; those of one order share one, the lowest."""
    triangles = dict[float, tuple[float, Array, Array, str]]()
    for (case, way, quantity, when), levels in rows.groupby(["case", "way", "quantity", "when"]):
        keys = {"case": case, "way": way, "quantity": quantity, "when": when}
        fits = orders[(orders[[*keys]] == pd.Series(keys)).all(axis=1)]
        errors = levels["error"].abs().to_numpy(float)
        for order in fits["theory"].dropna():
            if len(errors) > 1 and 0 < errors[-2] < triangles.get(order, (np.inf,))[0]:
                places = levels[x].to_numpy(float)
                triangles[order] = errors[-2], places, errors, looks[str(way)]["color"]
    labels = [
        draw_slope_triangle(axes, places, errors, sign * order, color)
        for order, (_, places, errors, color) in triangles.items()
    ]
    if labels:
        # make room for the labels of the triangles
        axes.margins(x=0.14)
        separate(labels, axes)


def _complete_panel(
    axes: "Axes",
    rows: pd.DataFrame,
    table: pd.DataFrame,
    x: str,
    y: str,
    looks: Mapping[str, Look],
) -> None:
    """Shade a panel, and mark what has no place on its axes."""
    if y == "error":
        _shade(axes, rows, x)
    for way, levels in rows[rows[y] == 0].groupby("way", sort=False):
        _mark(axes, levels[x], 0.04, looks[str(way)] | {"linestyle": ""})
    lost = table[table["quantity"].isna()]
    for way, levels in lost.dropna(subset=[x]).groupby("way", sort=False):
        _mark(axes, levels[x], 0.96, looks[str(way)] | {"linestyle": "", "marker": "x"})
    # marks widen the horizontal axis
    axes.set_xlim(axes.get_xlim())


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


def _mark(axes: "Axes", x: pd.Series, height: float, mark: Look) -> None:
    """Mark runs whose error has no place on the axis: it is zero, or there is none."""
    axes.plot(
        x, np.full(len(x), height), transform=axes.get_xaxis_transform(), **mark | {"label": None}
    )


def _drawn(values: "pd.Series[float]") -> Array:
    """Return errors that a logarithmic axis can show: positive ones, up to `GREATEST_ERROR`."""
    errors = values.abs().to_numpy(float)
    return np.where(errors > 0, np.minimum(errors, GREATEST_ERROR), np.nan)


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
    """Draw a slope triangle below the last two points of a curve; return its label.

    Parameters
    ----------
    axes : logarithmic axes
    sizes, errors : (n,) points of the curve, from coarse to fine
    order : theoretical order of convergence, whose size the label shows
    color : colour of the curve
    """
    *_, coarse_size, second_size = sizes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    # half the way to the last point, but wide enough to be seen
    width = max(np.log(second_size / coarse_size) / 2, SHARE * np.log(right / left), key=abs)
    middle_size = coarse_size * np.exp(np.copysign(width, second_size - coarse_size))
    high_error = errors[-2] / max(2, (high / low) ** (SHARE / 2))
    low_error = high_error * (middle_size / coarse_size) ** order
    axes.plot(
        [middle_size, coarse_size, coarse_size, middle_size],
        [low_error, low_error, high_error, low_error],
        color=color,
        linewidth=0.6,
    )
    return axes.annotate(
        f"{abs(order):.2g}",
        (coarse_size, np.sqrt(low_error * high_error)),
        xytext=(2 * np.sign(order), 0),
        textcoords="offset points",
        va="center",
        ha="left" if order > 0 else "right",
        fontsize=6,
        color=color,
    )
