"""One style for every figure.

Drawn without a display, readable in grey and in print, 89 mm or 183 mm wide.
"""

import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from ...meshes.radial import Array
from ..problem.scene import Scene

# curves by the name of their method; those of a user's own join at their first figure
LOOKS: dict[str, dict[str, Any]] = {
    "mdr": {"color": "#1f4e79", "linewidth": 2.2, "alpha": 0.55},
    "mdr-grid": {"color": "#8e6c00", "linestyle": (0, (5, 1, 1, 1)), "marker": "v"},
    "bem": {"color": "#2e7d32", "linestyle": "-.", "marker": "s"},
    "direct": {"color": "black", "linestyle": ":", "linewidth": 1.4, "marker": "x"},
    "fem": {"color": "#c0392b", "linestyle": "--", "marker": "o", "markerfacecolor": "none"},
}
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
GREYS = ("0.0", "0.45", "0.2", "0.6", "0.35")
# of the punch and its ring edges
RED = "#c0392b"
# of what others are seen against
FAINT: dict[str, Any] = {"color": "0.4", "linewidth": 0.8, "linestyle": (0, (1, 2))}
# width in inches of a figure over both columns of a page
PAGE = 183 / 25.4
STYLE: dict[str, Any] = {
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2,
    "ytick.major.pad": 2,
    "axes.labelpad": 2,
    "axes.titlepad": 3,
    "axes.titley": 1.0,
}


def save(path: Path, draw: Callable[..., Figure], *arguments: Any) -> None:
    """Draw a figure in this style, whatever the user's own, and write it as PNG."""
    with rc_context(STYLE):
        # little is gained by squeezing it longer
        draw(*arguments).savefig(path, pil_kwargs={"compress_level": 3})


class Picture(NamedTuple):
    """A figure of a run.

    Parameters
    ----------
    file : str
        Its name in the folder of results.
    caption : str
        What it shows, for the page.
    draw : Result -> Figure
    drawn_for : Result -> bool
        Whether a result has what it shows.
    """

    file: str
    caption: str
    draw: Callable[[Any], Figure]
    drawn_for: Callable[[Any], bool]

    def write(self, result: Any, path: Path) -> None:
        """Draw it and write it as PNG."""
        save(path, self.draw, result)


def page(
    rows: int,
    columns: int,
    height: float,
    *,
    width: float = PAGE,
    left: float = 0.5,
    right: float = 0.1,
    top: float = 0.3,
    bottom: float = 0.68,
    across: float = 0.12,
    down: float = 0.12,
    **grid: Any,
) -> tuple[Figure, Any]:
    """Return a figure and its panels (rows, columns).

    Places are fixed, so that nothing has to be measured before it is drawn: that halves the time
    that a figure takes.

    Parameters
    ----------
    height : float
        Of a row of panels, on average, in inches as all sizes here.
    left, right, top, bottom : float
        Margins round the panels.
    across, down : float
        Gaps between them.
    grid
        What else `Figure.subplots` takes.
    """
    high = top + bottom + rows * height + (rows - 1) * down
    wide = (width - left - right - (columns - 1) * across) / columns
    figure = Figure(figsize=(width, high), dpi=200)
    FigureCanvasAgg(figure)
    figure.subplots_adjust(
        left / width, bottom / high, 1 - right / width, 1 - top / high, across / wide, down / height
    )
    return figure, figure.subplots(rows, columns, squeeze=False, **grid)


def complete(figure: Figure, title: str, axes: Iterable[Any] = (), note: str = "") -> Figure:
    """Add a title in plain text above, one legend of some axes and a note below; return the figure.

    Two lines of title are shown, and every label once.
    """
    width, height = figure.get_size_inches()
    centred: dict[str, Any] = {"ha": "center", "parse_math": False}
    lines = textwrap.fill(title, int(width * 16), max_lines=2, placeholder=" ...")
    figure.text(0.5, 1 - 0.05 / height, lines, va="top", fontsize=8, **centred)
    figure.text(0.5, 0.05 / height, note, va="bottom", fontsize=6.5, **centred)
    if handles := labelled(axes):
        figure.legend(
            handles.values(),
            handles.keys(),
            loc="lower center",
            bbox_to_anchor=(0.5, (0.13 if note else 0.0) / height),
            ncols=len(handles),
            frameon=False,
            borderaxespad=0.2,
        )
    return figure


def titled(scene: Scene, what: str) -> str:
    """Return the title of a figure of a scene, which may have none itself."""
    return f"{scene.title}: {what}" if scene.title else what


def labelled(axes: Iterable[Any]) -> dict[str, Any]:
    """Return what is labelled in some axes, every label once."""
    return {
        label: handle
        for panel in axes
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }


def new_figure(width: float, height: float) -> Figure:
    """Return a figure that needs no display and arranges itself; sizes in inches."""
    figure = Figure(figsize=(width, height), layout="constrained", dpi=200)
    FigureCanvasAgg(figure)
    return figure


def curve(number: int) -> dict[str, Any]:
    """Return marker, line and grey of the n-th curve: distinct without colour."""
    return {
        "marker": "os^Dvx+*"[number % 8],
        "linestyle": LINES[number % len(LINES)],
        "color": GREYS[number % len(GREYS)],
        "markersize": 4.5,
        "markerfacecolor": "none",
        "linewidth": 1.1,
    }


def method_curve(name: str, points: int = 0) -> dict[str, Any]:
    """Return the curve of a method, with about 24 markers on so many points."""
    look = LOOKS.setdefault(name, curve(len(LOOKS)))
    look = {"linewidth": 1.0, "markersize": 3.0} | look | {"label": name.upper()}
    return look | {"markevery": max(1, points // 24)} if "marker" in look and points else look


def without_marks(look: dict[str, Any]) -> dict[str, Any]:
    """Return a curve without its marks."""
    return {key: value for key, value in look.items() if not key.startswith("mark")}


def shade_rings(
    axes: Any, ring_edges: Array, wear_coefficients: Array, radius: float = 1.0
) -> None:
    """Draw grey bands over the rings that wear fastest, and the radius from 0 to that of the
    punch.
    """
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
    """Return a curve broken at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, ring_edges[1:-1])
    return np.insert(radii, cuts, ring_edges[1:-1]), np.insert(values, cuts, np.nan)


def powers(*axes: Any) -> None:
    """Tick logarithmic axes at powers of ten only, in plain text: mathtext takes far longer."""
    for axis in axes:
        axis.set_major_formatter(_power)
        axis.set_minor_locator(NullLocator())


def _power(value: float, _: int) -> str:
    exponent = round(np.log10(value))
    if abs(exponent) < 2:
        return f"{value:g}"
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def spans_decades(times: Array) -> bool:
    """Tell whether times are to be shown on a logarithmic axis."""
    positive = times[times > 0]
    return bool(len(positive) and positive[-1] > 30 * positive[0])


def time_axis(axes: Any, times: Array) -> None:
    """Set an axis of ascending times: logarithmic over several decades, from the first that is
    later than the start.
    """
    if spans_decades(times):
        axes.set_xscale("log")
        powers(axes.xaxis)
        axes.set_xlim(times[times > 0][0] / 1.2, times[-1] * 1.2)
    else:
        axes.set_xlim(0, times[-1] * 1.05)


def plain_numbers(axis: Any) -> None:
    """Tick a logarithmic axis as 0.1, 1, 10."""
    axis.set_major_formatter(lambda value, _: f"{value:g}")


def legend_below(axes: Any, **settings: Any) -> None:
    """Add a legend under the axes, where it covers nothing.

    None without curves, as after an early interruption.
    """
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="upper center",
            bbox_to_anchor=(0.5, -0.14),
            frameon=False,
            fontsize=8,
            title_fontsize=8,
            **settings,
        )


def legend_of(figure: Figure, axes: Iterable[Any]) -> None:
    """Add one legend for the whole figure: every label of some axes, once."""
    handles = labelled(axes)
    figure.legend(
        handles.values(),
        handles.keys(),
        loc="outside lower center",
        ncols=min(len(handles), round(figure.get_figwidth() / 1.4)),
        frameon=False,
        fontsize=9,
    )
