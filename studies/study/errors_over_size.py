"""Log-log plots of errors over sizes or unknowns, with slope triangles for theoretical orders."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from ..crosscheck import Array
from ..figures.style import LOOKS, complete, curve, new_panels
from ..figures.ticks import power_of_ten, short_number
from .orders import Sequence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

MOST_TICKS = 5
ROUND_DIGITS = ((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9), tuple(np.arange(1, 10, 0.1)))
"""Sets of mantissas of ticks; the first set that yields at least two ticks is used."""
LABEL_HEIGHT = 0.04
"""Height of the label of a slope triangle, as a fraction of the height of the axes."""
Curves = dict[str, Sequence]
"""The sequences drawn in one panel, by their labels."""


def panels_of(sequences: Iterable[Sequence], xlabels: Mapping[str, str]) -> dict[str, Curves]:
    """Group sequences into panels: one panel for each label of the x axis.

    Parameters
    ----------
    sequences : sequences to be drawn
    xlabels : label of the x axis, by the name of the family
    """
    panels: dict[str, Curves] = {}
    for sequence in sequences:
        panels.setdefault(xlabels[sequence.name], {})[sequence.label] = sequence
    return panels


def draw_errors(panels: Mapping[str, Curves], ylabel: str, title: str = "") -> Figure:
    """Draw errors over sizes or unknowns on logarithmic axes, in one panel for each x label.

    Each curve has the colour of its method, and a slope triangle shows the theoretical order. The
    title of a panel lists its families. One legend below all panels explains the curves.
    """
    curve_count = sum(map(len, panels.values()))
    count = max(len(panels), 1)
    figure, grid = new_panels(max(4.4 * count, 5.5), 3.9 + 0.15 * curve_count, 1, count)
    row = grid[0]
    for axes, (xlabel, curves) in zip(row, panels.items(), strict=False):
        labels: list[Annotation] = []
        for number, (label, sequence) in enumerate(curves.items()):
            colors = [look["color"] for look in LOOKS.values()]
            method_color = LOOKS.get(label.split()[0].lower(), {}).get("color")
            look = curve(number) | {"color": method_color or colors[number % len(colors)]}
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
    """Set at most `MOST_TICKS` round ticks on each logarithmic axis, with grid lines at them."""
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        values = ticks(low, high)
        all_powers_of_ten = np.allclose(np.log10(values) % 1, 0)
        tick_labels = [
            power_of_ten(value) if all_powers_of_ten else short_number(value) for value in values
        ]
        axis.set_ticks(values, tick_labels)
        # minor ticks would take longer to draw than the rest of the figure
        axis.set_minor_locator(NullLocator())
    axes.grid(True, which="major", color="0.88", linewidth=0.6)


def ticks(low: float, high: float) -> Array:
    """Return 2 to `MOST_TICKS` round numbers on a logarithmic axis, powers of ten if two fit."""
    tens = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    for digits in ROUND_DIGITS:
        values = np.outer(tens, digits).ravel()
        values = values[(low <= values) & (values <= high)]
        if len(values) > 1:
            break
    return values[:: -(-len(values) // MOST_TICKS) or 1]


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
