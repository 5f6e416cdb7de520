"""One style for every figure: drawn without a display, readable in grey and in print."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ringwear.meshes.radial import Array
from ringwear.studies.methods.base import method

MARKERS = "os^Dvx+*"
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
GREYS = ("0.0", "0.45", "0.2", "0.6", "0.35")
RED = "#c0392b"  # the punch and its ring edges
FAINT: dict[str, Any] = {"color": "0.4", "linewidth": 0.8, "linestyle": (0, (1, 2))}


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


def shade_rings(axes: Any, ring_edges: Array, wear_coefficients: Array) -> None:
    """Grey bands over the rings that wear fastest, and the radius from 0 to 1."""
    fast = wear_coefficients > np.sqrt(wear_coefficients.min() * wear_coefficients.max())
    for inner, outer in zip(ring_edges[:-1][fast], ring_edges[1:][fast], strict=True):
        axes.axvspan(inner, outer, color="0.9", linewidth=0, zorder=0)
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])


def broken_at(ring_edges: Array, radii: Array, values: Array) -> tuple[Array, Array]:
    """A curve broken at ring edges, where pressures jump."""
    cuts = np.searchsorted(radii, ring_edges[1:-1])
    return np.insert(radii, cuts, ring_edges[1:-1]), np.insert(values, cuts, np.nan)


def plain_numbers(axis: Any) -> None:
    """Ticks of a logarithmic axis as 0.1, 1, 10."""
    axis.set_major_formatter(lambda value, _: f"{value:g}")


def legend_below(axes: Any, **settings: Any) -> None:
    """A legend under the axes, where it covers nothing; none without curves, as after an early interruption."""
    if axes.get_legend_handles_labels()[0]:
        place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14)}
        axes.legend(**place, frameon=False, fontsize=8, title_fontsize=8, **settings)


def legend_of(figure: Figure, axes: Iterable[Any]) -> None:
    """One legend for the whole figure: every label of some axes, once."""
    handles = {label: handle for one in axes for handle, label in zip(*one.get_legend_handles_labels(), strict=True)}
    place = {"loc": "outside lower center", "ncols": min(len(handles), round(figure.get_figwidth() / 1.4))}
    figure.legend(handles.values(), handles.keys(), **place, frameon=False, fontsize=9)
