"""The common style of all figures.

Figures need no display, are readable in grey and in print, and are 89 mm or 183 mm wide.
"""

import textwrap
from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from ...meshes import Array
from ..crosscheck import METHODS
from .ticks import STEPS, Decades, power_of_ten, tick_label

Look: TypeAlias = dict[str, Any]
"""Keyword arguments of matplotlib for a curve or a mark."""

# curves of our methods, by their names
LOOKS: dict[str, Look] = {
    "mdr": {"color": "#1f4e79", "linewidth": 2.2, "alpha": 0.55},
    "mdr-grid": {"color": "#8e6c00", "linestyle": (0, (5, 1, 1, 1)), "marker": "v"},
    # large and hollow, so that marks of other methods are visible inside
    "bem": {
        "color": "#2e7d32",
        "linestyle": "-.",
        "marker": "s",
        "markerfacecolor": "none",
        "markersize": 4.5,
    },
    "direct": {"color": "black", "linestyle": ":", "linewidth": 1.4, "marker": "x"},
    "fem": {"color": "#c0392b", "linestyle": "--", "marker": "o", "markerfacecolor": "none"},
}
# curves of user-defined methods, and of results of other programs, in their order in a run
OWN_LOOKS: tuple[Look, ...] = (
    {"color": "#6a1b9a", "linestyle": "--", "marker": "^", "markerfacecolor": "none"},
    {"color": "#00838f", "linestyle": "-.", "marker": "D", "markerfacecolor": "none"},
    {"color": "#5d4037", "linestyle": (0, (1, 1)), "marker": "v", "markerfacecolor": "none"},
)
OTHERS_LOOKS: tuple[Look, ...] = (
    {"color": "#e67e00", "linestyle": "--", "marker": "+"},
    {"color": "#d81b88", "linestyle": "-.", "marker": "1"},
    {"color": "#1e88e5", "linestyle": ":", "marker": "2"},
    {"color": "#7cb342", "linestyle": (0, (5, 1, 1, 1)), "marker": "3"},
)
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
GREYS = ("0.0", "0.45", "0.2", "0.6", "0.35")
# colour of the punch and its ring edges
RED = "#c0392b"
# colour of interfaces of layers
BLUE = "#2874a6"
# look of reference curves
FAINT: Look = {"color": "0.4", "linewidth": 0.8, "linestyle": (0, (1, 2))}
# smallest span of an axis, over the largest value on it
LEAST_SPAN = 0.02
# ratio of wear coefficients above which the faster rings are shaded
LEAST_RATIO = 1.1
# width in inches of a figure over both columns of a page
PAGE = 183 / 25.4


def in_style() -> AbstractContextManager[None]:
    """Return a context in which figures have this style, independent of the user's settings."""
    return rc_context(fname=Path(__file__).with_name("ringwear.mplstyle"))


def png_of(figure: Figure) -> bytes:
    """Return a figure as PNG, for notebooks."""
    image = BytesIO()
    with in_style():
        figure.savefig(image, format="png", dpi=100)
    return image.getvalue()


def html_of(figure: Figure) -> str:
    """Return a figure as an HTML image with embedded data, for notebooks."""
    return f'<img src="data:image/png;base64,{b64encode(png_of(figure)).decode()}">'


def save(path: Path, draw: Callable[..., Figure], *arguments: Any) -> None:
    """Draw a figure and write it as PNG."""
    with in_style():
        # a higher compression level takes longer, and files are hardly smaller
        draw(*arguments).savefig(path, pil_kwargs={"compress_level": 3})


class Drawing(Figure):
    """A figure that notebooks show as a picture."""

    def _repr_png_(self) -> bytes:
        return png_of(self)


def new_figure(width: float, height: float) -> Figure:
    """Return a figure with automatic layout that needs no display; sizes in inches."""
    return Drawing(figsize=(width, height), layout="constrained", dpi=200)


def new_panels(
    width: float, height: float, rows: int = 1, columns: int = 1, **settings: Any
) -> tuple[Figure, Any]:
    """Return a figure and its panels (rows, columns); `complete` arranges them. Sizes in inches."""
    figure = Drawing(figsize=(width, height), dpi=200)
    return figure, figure.subplots(rows, columns, squeeze=False, **settings)


def complete(
    figure: Figure,
    titles: Iterable[str],
    axes: Iterable[Axes] = (),
    note: str = "",
    across: float = 0.6,
    down: float = 0.1,
    right: float = 0.13,
) -> Figure:
    """Add a title, a legend and a note to a figure, and arrange its panels; return the figure.

    Parameters
    ----------
    titles : parts of the title, joined by colons; empty ones are left out
    axes : panels whose labels are in the legend below the figure, each label once
    note : text below the panels
    across, down : distances between panels, in inches
    right : distance of the panels from the right end, in inches
    """
    width, height = figure.get_size_inches()
    title = textwrap.wrap(
        ": ".join(filter(None, titles)), int(16 * width), max_lines=2, placeholder=" ..."
    )
    figure.suptitle("\n".join(title), y=1 - 0.05 / height, parse_math=False)
    grid: Any = figure.axes[0].get_gridspec()
    rows, columns = grid.get_geometry()
    # sizes in inches: a line of text is 1/8 high; ticks and labels need 1/2 to the left of panels,
    # and 1/3 below them
    top = 0.31 + 0.125 * len(figure.axes[0].get_title().splitlines()) + 0.15 * (len(title) - 1)
    left, bottom = 0.56, 0.36 + legend_of(figure, axes, note)
    panel_width = (width - left - right - (columns - 1) * across) / columns
    panel_height = (height - top - bottom - (rows - 1) * down) / rows
    figure.subplots_adjust(
        left=left / width,
        right=1 - right / width,
        top=1 - top / height,
        bottom=bottom / height,
        wspace=across / panel_width,
        hspace=down / panel_height,
    )
    return figure


def legend_of(figure: Figure, axes: Iterable[Axes], note: str = "") -> float:
    """Add a note and a legend with all labels of some axes below the figure.

    Each label appears once. Return the height of note and legend in inches.
    """
    handles = {
        label: handle
        for panel in axes
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    # 20 letters of a note need an inch
    note_lines = [
        part
        for line in note.splitlines()
        for part in textwrap.wrap(line, int(20 * figure.get_figwidth()))
    ]
    # a label, with the sample of its curve, needs an inch for about 16 letters
    longest = max(map(len, handles), default=0)
    columns = max(1, min(len(handles), int(18 * figure.get_figwidth() / (8 + longest))))
    legend = figure.legend(
        handles.values(),
        handles.keys(),
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        title="\n".join(note_lines),
    )
    legend.get_title().set(parse_math=False, multialignment="center")
    return 0.13 + 0.15 * -(-len(handles) // columns) + 0.125 * len(note_lines)


def set_logarithmic(axes: Axes, direction: str, most: int = 5) -> None:
    """Make an axis logarithmic, with up to `most` ticks at powers of ten.

    Minor ticks, and formulas in labels, would take as long as the rest of the figure.
    """
    axes.set(**{f"{direction}scale": "log"})
    axis = getattr(axes, f"{direction}axis")
    axis.set_major_locator(Decades(numticks=most))
    axis.set_major_formatter(lambda value, _: power_of_ten(value))
    axis.set_minor_locator(NullLocator())


def set_linear(axes: Axes, direction: str, most: int = 6) -> None:
    """Give a linear axis up to `most` intervals between ticks, with labels of up to three digits.

    There is no offset at the axis: one such as ``1e-5+6.2475e1`` is easily overlooked.
    """
    axis = getattr(axes, f"{direction}axis")
    axis.set_major_locator(MaxNLocator(most, steps=STEPS))
    axis.set_major_formatter(lambda value, _: tick_label(value, np.ptp(axis.get_view_interval())))


def show_values(axes: Axes) -> None:
    """Label a vertical axis with full numbers, and let it span at least 2 % of the values.

    A narrower span would magnify roundoff. The span has space for two ticks that differ in their
    first three digits.
    """
    low, high = axes.get_ylim()
    largest = max(abs(low), abs(high))
    # relative to the end of the axis after widening
    least = LEAST_SPAN * (1 + LEAST_SPAN) * largest
    if abs(high - low) < least:
        middle, half = (low + high) / 2, np.copysign(least / 2, high - low)
        axes.set_ylim(middle - half, middle + half)
    set_linear(axes, "y")


def curve(number: int) -> Look:
    """Return marker, line style and grey of the n-th curve, distinct without colour."""
    return {
        "marker": "os^Dvx+*"[number % 8],
        "linestyle": LINES[number % len(LINES)],
        "color": GREYS[number % len(GREYS)],
        "markersize": 4.5,
        "markerfacecolor": "none",
        "linewidth": 1.1,
    }


def label_of(name: str) -> str:
    """Return the name of a method in figures; only ringwear's methods are in capitals."""
    return name.upper() if name in METHODS else name


def method_curve(name: str, points: int = 0, look: Look | None = None) -> Look:
    """Return the look of the curve of a method, with about 24 markers on `points` points.

    `look` is needed for a method that is not in `LOOKS`.
    """
    look = {"linewidth": 1.0, "markersize": 3.0, "label": label_of(name)} | (look or LOOKS[name])
    return look | {"markevery": max(1, points // 24)} if "marker" in look and points else look


def looks_of(methods: Iterable[str], of_others: Sequence[str] = ()) -> dict[str, Look]:
    """Return the look of each method of a run, and of the programs that it is compared with.

    Methods of ringwear always have the same looks. Those of user-defined methods and of programs
    depend only on their order in the run.
    """
    user_defined = [name for name in methods if name not in LOOKS and name not in of_others]
    groups = ((user_defined, OWN_LOOKS), (of_others, OTHERS_LOOKS))
    return LOOKS | {
        name: looks[number % len(looks)]
        for names, looks in groups
        for number, name in enumerate(names)
    }


# colours of the ways of each method in a study, in their order there: blue, green, red to purple
SHADES: dict[str, tuple[str, ...]] = {
    "mdr": (LOOKS["mdr"]["color"], "#3d8bcd", "#00838f", "#8fb8de", "#5c6bc0"),
    "bem": (LOOKS["bem"]["color"], "#7cb342", "#00695c"),
    "fem": (
        LOOKS["fem"]["color"],
        *("#e69f00", "#7b241c", "#8e44ad", "#f0784a", "#d81b88", "#4a235a", "#a67c00"),
    ),
    "direct": (LOOKS["direct"]["color"],),
    "mdr-grid": (LOOKS["mdr-grid"]["color"],),
    "naive": ("0.45",),
}
FIRST_MARKER = {"mdr": 0, "bem": 1, "fem": 3, "direct": 6, "mdr-grid": 5, "naive": 7}
MARKERS = "osv^D<xX*P>ph"


def looks_of_ways(ways: Iterable[tuple[str, str]]) -> dict[str, Look]:
    """Return the look of each way to compute a case, by its name.

    The hue tells the method; marker and line tell its ways apart.

    Parameters
    ----------
    ways : name and method of each way, in the order of the study
    """
    counts, looks = dict[str, int](), dict[str, Look]()
    of_users = tuple(look["color"] for look in OWN_LOOKS)
    for name, method in dict(ways).items():
        number = counts[method] = counts.get(method, -1) + 1
        shades = SHADES.get(method, of_users)
        looks[name] = {
            "color": shades[number % len(shades)],
            "marker": MARKERS[(FIRST_MARKER.get(method, 0) + number) % len(MARKERS)],
            "linestyle": LINES[number % len(LINES)],
            "markersize": 3.4,
            "markerfacecolor": "none",
            "markeredgewidth": 0.8,
            "linewidth": 1.0,
            "label": name,
        }
    return looks


def rings_differ(wear_coefficients: Array) -> bool:
    """Return whether some rings wear visibly faster than others."""
    return bool(wear_coefficients.max() > LEAST_RATIO * wear_coefficients.min())


def shade_rings(
    axes: Axes, ring_edges: Array, wear_coefficients: Array, radius: float = 1.0
) -> None:
    """Draw grey bands over the rings that wear fastest, if they wear visibly faster.

    The axis of the radius ends at the punch radius, and begins at 0 unless the hole is wide.
    """
    if rings_differ(wear_coefficients):
        fast = wear_coefficients > np.sqrt(wear_coefficients.min() * wear_coefficients.max())
        for inner, outer in zip(ring_edges[:-1][fast], ring_edges[1:][fast], strict=True):
            axes.axvspan(inner * radius, outer * radius, color="0.9", linewidth=0, zorder=0)
    axes.set_xlim(axis_start(float(ring_edges[0]) * radius, radius), radius)
    set_linear(axes, "x", most=3)


def axis_start(hole: float, last: float) -> float:
    """Return the start of an axis of the radius: just inside a hole wider than half of it, or 0."""
    return hole - 0.05 * (last - hole) if last / 2 < hole < last else 0.0


def broken_at(ring_edges: Array, radii: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve with gaps (NaN) at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, ring_edges[1:-1])
    return np.insert(radii, cuts, ring_edges[1:-1]), np.insert(values, cuts, np.nan)


def cell_edges(places: Array) -> Array:
    """Return the edges (n + 1,) of cells around (n,) places, half-way between neighbours."""
    if len(places) == 1:
        return places[0] + np.array([-0.5, 0.5])
    middle = (places[1:] + places[:-1]) / 2
    first, last = 2 * places[[0, -1]] - middle[[0, -1]]
    return np.array([first, *middle, last])
