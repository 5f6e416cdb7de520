"""One style for every figure.

Drawn without a display, readable in grey and in print, 89 mm or 183 mm wide.
"""

import textwrap
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from ...meshes.radial import Array
from ..methods.base import method

MARKERS = "os^Dvx+*"
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
GREYS = ("0.0", "0.45", "0.2", "0.6", "0.35")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
RED = "#c0392b"  # the punch and its ring edges
FAINT: dict[str, Any] = {"color": "0.4", "linewidth": 0.8, "linestyle": (0, (1, 2))}
# widths in inches of a figure in one column of a page, or in two
COLUMN, PAGE = 89 / 25.4, 183 / 25.4
SMALL = 6.5
# beyond this ratio of the last time to the first, time is logarithmic
DECADES = 30.0
STYLE: dict[str, Any] = {
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.pad": 2,
    "ytick.major.pad": 2,
    "axes.labelpad": 2,
    "axes.titlepad": 3,
    "axes.titley": 1.0,
    "mathtext.default": "it",
}
P = ParamSpec("P")
R = TypeVar("R")


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in this style, whatever the user's own, and leave that as it is."""

    @wraps(draw)
    def drawn(*arguments: P.args, **named: P.kwargs) -> R:
        with rc_context(STYLE):
            return draw(*arguments, **named)

    return drawn


class Margins(NamedTuple):
    """Inches round the panels of a figure, and between them."""

    left: float = 0.5
    right: float = 0.1
    top: float = 0.35
    bottom: float = 0.75
    across: float = 0.12
    down: float = 0.12


def page(
    rows: int, columns: int, height: float, margins: Margins, width: float = PAGE, **grid: Any
) -> tuple[Figure, Any]:
    """A figure with panels (rows, columns) of which each row is `height` high on average.

    Sizes in inches.

    Places are fixed, so that nothing has to be measured before it is drawn: that halves the time
    that a figure takes.
    """
    high = margins.top + margins.bottom + rows * height + (rows - 1) * margins.down
    figure = Figure(figsize=(width, high), dpi=200)
    FigureCanvasAgg(figure)
    wide = (width - margins.left - margins.right - (columns - 1) * margins.across) / columns
    places = {
        "left": margins.left / width,
        "right": 1 - margins.right / width,
        "top": 1 - margins.top / high,
        "bottom": margins.bottom / high,
        "wspace": margins.across / wide,
        "hspace": margins.down / height,
    }
    ratios = {name: grid.pop(name) for name in ("height_ratios", "width_ratios") if name in grid}
    return figure, figure.subplots(
        rows, columns, squeeze=False, gridspec_kw=places | ratios, **grid
    )


def heading(figure: Figure, text: str) -> None:
    """A title in plain text, wrapped."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(text, int(width * 16)) or [""]
    if len(lines) > 2:
        lines = [lines[0], f"{lines[1][: int(width * 16) - 4]} ..."]
    figure.text(
        0.5,
        1 - 0.05 / height,
        "\n".join(lines),
        ha="center",
        va="top",
        parse_math=False,
        fontsize=8,
    )


def footing(figure: Figure, axes: Iterable[Any], note: str = "") -> None:
    """One legend for the whole figure, every label of some axes once, and a note below it."""
    _, height = figure.get_size_inches()
    if note:
        figure.text(0.5, 0.05 / height, note, ha="center", va="bottom", fontsize=SMALL)
    handles = {
        label: handle
        for one in axes
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True)
    }
    if handles:
        place: dict[str, Any] = {
            "loc": "lower center",
            "bbox_to_anchor": (0.5, (0.13 if note else 0.0) / height),
        }
        figure.legend(
            handles.values(),
            handles.keys(),
            **place,
            ncols=len(handles),
            frameon=False,
            borderaxespad=0.2,
        )


def save(figure: Figure, path: Path) -> None:
    """Write a figure; little is gained by squeezing it longer."""
    figure.savefig(path, pil_kwargs={"compress_level": 3})


def new_figure(width: float, height: float) -> Figure:
    """A figure that needs no display; sizes in inches."""
    figure = Figure(figsize=(width, height), layout="constrained", dpi=200)
    FigureCanvasAgg(figure)
    return figure


def curve(number: int) -> dict[str, Any]:
    """Marker, line and grey of the n-th curve: distinct without colour."""
    return {
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": LINES[number % len(LINES)],
        "color": GREYS[number % len(GREYS)],
        "markersize": 4.5,
        "markerfacecolor": "none",
        "linewidth": 1.1,
    }


def method_curve(name: str, points: int = 0) -> dict[str, Any]:
    """The curve of a method, in its own look, with about 24 markers on so many points."""
    look = dict(method(name).look) | {"label": name.upper()}
    return look | {"markevery": max(1, points // 24)} if "marker" in look and points else look


def titled(scene: str, what: str) -> str:
    """The title of a figure of a scene, which may have none itself."""
    return f"{scene}: {what}" if scene else what


def shade_rings(
    axes: Any, ring_edges: Array, wear_coefficients: Array, radius: float = 1.0
) -> None:
    """Grey bands over the rings that wear fastest, and the radius from 0 to that of the punch."""
    fast = wear_coefficients > np.sqrt(wear_coefficients.min() * wear_coefficients.max())
    spans = np.column_stack([ring_edges[:-1], np.diff(ring_edges)])[fast] * radius
    axes.broken_barh(
        spans, (0, 1), transform=axes.get_xaxis_transform(), color="0.9", linewidth=0, zorder=0
    )
    axes.set_xlim(0, radius)
    if radius == 1:
        axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
    else:
        axes.locator_params(axis="x", nbins=4)


def broken_at(ring_edges: Array, radii: Array, values: Array) -> tuple[Array, Array]:
    """A curve broken at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, ring_edges[1:-1])
    return np.insert(radii, cuts, ring_edges[1:-1]), np.insert(values, cuts, np.nan)


def powers(*axes: Any) -> None:
    """Ticks of logarithmic axes at powers of ten only, and in plain text.

    It takes a fifth of the time of mathtext.
    """
    for axis in axes:
        axis.set_major_formatter(_power)
        axis.set_minor_locator(NullLocator())


def _power(value: float, _: int) -> str:
    exponent = round(np.log10(value))
    return {0: "1", 1: "10", -1: "0.1"}.get(exponent, "10" + str(exponent).translate(RAISED))


def time_axis(axes: Any, times: Array) -> None:
    """Logarithmic over several decades; the start, where nothing has happened, is left of it."""
    positive = times[times > 0]
    if positive[-1] / positive[0] > DECADES:
        axes.set_xscale("log")
        powers(axes.xaxis)
        axes.set_xlim(positive[0] / 1.2, positive[-1] * 1.2)
    else:
        axes.set_xlim(0, positive[-1] * 1.05)


def plain_numbers(axis: Any) -> None:
    """Ticks of a logarithmic axis as 0.1, 1, 10."""
    axis.set_major_formatter(lambda value, _: f"{value:g}")


def legend_below(axes: Any, **settings: Any) -> None:
    """A legend under the axes, where it covers nothing.

    None without curves, as after an early interruption.
    """
    if axes.get_legend_handles_labels()[0]:
        place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14)}
        axes.legend(**place, frameon=False, fontsize=8, title_fontsize=8, **settings)


def legend_of(figure: Figure, axes: Iterable[Any]) -> None:
    """One legend for the whole figure: every label of some axes, once."""
    handles = {
        label: handle
        for one in axes
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True)
    }
    place = {
        "loc": "outside lower center",
        "ncols": min(len(handles), round(figure.get_figwidth() / 1.4)),
    }
    figure.legend(handles.values(), handles.keys(), **place, frameon=False, fontsize=9)
