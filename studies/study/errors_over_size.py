"""Errors over sizes or unknowns, logarithmic, with the orders of theory as triangles."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from ...meshes.radial import Array
from ..figures.style import LOOKS, complete, curve, new_panels
from ..figures.ticks import power_of_ten
from .orders import Sequence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

MOST_TICKS = 5
ROUND_DIGITS = ((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9), tuple(np.arange(1, 10, 0.1)))
"""First digits that numbers at ticks may have: the first of these that lead to two ticks."""
LABEL_HEIGHT = 0.04
"""Height of the label of a triangle, as a part of the axis."""
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


def draw_errors(panels: Mapping[str, Curves], ylabel: str, title: str = "") -> Figure:
    """Draw errors over sizes or unknowns, logarithmic: a panel for each label of these.

    Curves are in the colours of their methods, with orders in theory as triangles beside them. A
    panel has the names of its families as its title; one legend is below all panels.
    """
    longest = sum(map(len, panels.values()))
    count = max(len(panels), 1)
    figure, grid = new_panels(max(4.4 * count, 5.5), 3.9 + 0.15 * longest, 1, count)
    row = grid[0]
    for axes, (xlabel, curves) in zip(row, panels.items(), strict=False):
        labels: list[Annotation] = []
        for number, (label, sequence) in enumerate(curves.items()):
            colors = [look["color"] for look in LOOKS.values()]
            of_method = LOOKS.get(label.split()[0].lower(), {}).get("color")
            look = curve(number) | {"color": of_method or colors[number % len(colors)]}
            errors = np.where(sequence.errors > 0, sequence.errors, np.nan)
            axes.loglog(sequence.sizes, errors, label=label, **look)
            if np.isfinite(sequence.theory.order) and len(errors) > 1:
                order, color = sequence.theory.order, look["color"]
                labels.append(
                    draw_slope_triangle(axes, sequence.sizes, sequence.errors, order, color)
                )
        families = dict.fromkeys(sequence.name for sequence in curves.values())
        axes.set(xlabel=xlabel, title=", ".join(families))
        set_round_ticks(axes)
        separate(labels, axes)
    for axes in row:
        axes.set_ylabel(ylabel)
    return complete(figure, [title], row, across=0.75)


def set_round_ticks(axes: "Axes") -> None:
    """Set few round ticks on logarithmic axes, and a grid at them."""
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        values = ticks(low, high)
        in_tens = np.allclose(np.log10(values) % 1, 0)
        labels_of = [power_of_ten(value) if in_tens else f"{value:g}" for value in values]
        axis.set_ticks(values, labels_of)
        # ticks between them take longer than all the rest of a figure
        axis.set_minor_locator(NullLocator())
    axes.grid(True, which="major", color="0.88", linewidth=0.6)


def ticks(low: float, high: float) -> Array:
    """Return two to `MOST_TICKS` round numbers of a logarithmic axis, powers of ten if they do."""
    tens = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    for digits in ROUND_DIGITS:
        values = np.outer(tens, digits).ravel()
        values = values[(low <= values) & (values <= high)]
        if len(values) > 1:
            break
    return values[:: -(-len(values) // MOST_TICKS) or 1]


def separate(labels: Iterable["Annotation"], axes: "Axes") -> None:
    """Move labels up that would lie over one below them, at logarithmic axes whose limits stay."""
    low, high = np.log10(axes.get_ylim())
    apart = LABEL_HEIGHT * (high - low)
    placed = list[tuple[float, float]]()
    for label in sorted(labels, key=lambda each: each.xy[1]):
        x, y = np.log10(label.xy)
        beside = [other for at, other in placed if np.isclose(at, x, atol=0.05)]
        moved = max([y, *(other + apart for other in beside)])
        label.xy = (label.xy[0], 10**moved)
        placed.append((x, moved))


def draw_slope_triangle(
    axes: "Axes", sizes: Array, errors: Array, order: float, color: str
) -> "Annotation":
    """Draw the slope of theory below the first step of a curve; return the label that tells it.

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
    return axes.annotate(
        f"{order:.2g}",
        (right, np.sqrt(low * high)),
        xytext=(2, 0),
        textcoords="offset points",
        va="center",
        fontsize=6,
        color=color,
    )
