"""Errors over sizes or unknowns, logarithmic, with the orders of theory as triangles."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from ...meshes.radial import Array
from ..figures.style import LOOKS, curve, legend_below, new_figure
from .orders import Sequence

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Curves = dict[str, Sequence]
"""Of a panel, by their labels."""


def panels_of(sequences: Iterable[Sequence], xlabels: Mapping[str, str]) -> dict[str, Curves]:
    """Return a panel for each label of sizes, with the sequences that have it.

    Parameters
    ----------
    sequences : to be drawn
    xlabels : what sizes are called, by the name of their family
    """
    panels: dict[str, Curves] = {}
    for sequence in sequences:
        panels.setdefault(xlabels[sequence.name], {})[sequence.label] = sequence
    return panels


def draw_errors(panels: Mapping[str, Curves], ylabel: str) -> Figure:
    """Draw errors over sizes or unknowns, logarithmic: a panel for each label of these.

    Curves are in the colours of their methods, with orders in theory as triangles beside them.
    """
    longest = max(map(len, panels.values()), default=0)
    figure = new_figure(4.4 * max(len(panels), 1), 5 + 0.2 * longest)
    row = figure.subplots(1, max(len(panels), 1), sharey=True, squeeze=False)[0]
    for axes, (xlabel, curves) in zip(row, panels.items(), strict=False):
        for number, (label, sequence) in enumerate(curves.items()):
            colors = [look["color"] for look in LOOKS.values()]
            of_method = LOOKS.get(label.split()[0].lower(), {}).get("color")
            look = curve(number) | {"color": of_method or colors[number % len(colors)]}
            errors = np.where(sequence.errors > 0, sequence.errors, np.nan)
            axes.loglog(sequence.sizes, errors, label=label, **look)
            if np.isfinite(sequence.theory.order) and len(errors) > 1:
                order, color = sequence.theory.order, look["color"]
                draw_slope_triangle(axes, sequence.sizes, sequence.errors, order, color)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        low, high = axes.get_xlim()
        ticks = LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,))
        axes.xaxis.set(major_locator=ticks, minor_formatter=NullFormatter())
        axes.grid(True, which="major", color="0.88", linewidth=0.6)
        axes.label_outer()
        legend_below(axes)
    return figure


def draw_slope_triangle(
    axes: "Axes", sizes: Array, errors: Array, order: float, color: str
) -> None:
    """Draw the slope of theory below the first step of a curve, and say which it is.

    Parameters
    ----------
    axes : logarithmic
    sizes, errors : (n,) of the curve, from coarse to fine
    order : of theory
    color : of the curve
    """
    right, second, *_ = sizes
    left, high = np.sqrt(right * second), errors[0] / 2
    low = high * (left / right) ** order
    axes.plot([left, right, right, left], [low, low, high, low], color=color, linewidth=0.6)
    axes.annotate(
        f"{order:.2g}",
        (right, np.sqrt(low * high)),
        xytext=(2, 0),
        textcoords="offset points",
        va="center",
        fontsize=6,
        color=color,
    )
