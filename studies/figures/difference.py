"""Draw differences of methods in fields, along the radius at some times and over all times."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ...meshes import Array
from ..crosscheck import FieldComparison, FieldDifference, Result
from .scale import Scale, shown_times
from .style import (
    PAGE,
    Look,
    cell_edges,
    complete,
    label_of,
    new_panels,
    set_linear,
    set_logarithmic,
)
from .ticks import Decades, one_digit, power_of_ten

# name and symbol of each field, and the symbol of the norm that its differences are divided by
WORDS = {
    "pressure": ("pressure p", "p", "rms(p)"),
    "profile": ("worn profile f", "f", "d"),
    "displacement": ("displacement u", "u", "d"),
    "steady_pressure": ("steady pressure p", "p", "rms(p)"),
    "steady_profile": ("limiting profile f", "f", "uₘₐₓ"),
}
# number of decades below the greatest difference that panels and maps show
PANEL_DECADES, MAP_DECADES = 8, 6
# greatest number of rows of a map, each about a pixel on a screen
ROWS = 400
# look of the mark at the largest difference
MARK: Look = {
    "marker": "o",
    "markersize": 5,
    "markerfacecolor": "none",
    "markeredgecolor": "black",
    "markeredgewidth": 0.8,
    "linestyle": "",
    "clip_on": False,
    "label": "largest difference",
}
# curves with fewer radii than this have marks
FEW_RADII = 25


def draw_result_difference(result: Result) -> Figure:
    """Draw the difference of two methods of a run; a note lists differences of other methods."""
    return draw_difference(Scale.of(result), result.scene.title, result.field_comparisons)


def draw_difference(scale: Scale, title: str, comparisons: Sequence[FieldComparison]) -> Figure:
    """Draw the first of several comparisons, and list the largest differences of the others.

    Curves at the left show some of the times, with the error estimates of both methods as bands.
    Maps at the right show all times. The largest difference of each field is marked and printed.
    """
    comparison, *others = comparisons
    over_time = np.isfinite(comparison.fields[0].times[0])
    rows, columns = len(comparison.fields), 2 if over_time else 1
    figure, panels = new_panels(
        PAGE, 1.3 + 1.35 * rows, rows, columns, width_ratios=[1, 1.1][:columns]
    )
    times = _curve_times(comparison.fields)
    colours = colormaps["viridis"](np.linspace(0, 0.88, len(times)))
    top = max(float(np.nanmax(field.relative)) for field in comparison.fields)
    limits = _decades(top, MAP_DECADES)
    for number, (field, (curves, *maps)) in enumerate(zip(comparison.fields, panels, strict=True)):
        _draw_curves(curves, field, comparison, dict(zip(times, colours, strict=True)), scale)
        words = _largest_in_words(field, scale)
        for axes in maps:
            image = _draw_map(axes, field, comparison.contact_edges, limits, scale)
            axes.set_title(words, loc="left")
        field_name, symbol, norm_symbol = WORDS[field.quantity]
        title_of_curves = f"{field_name}: {_norm_in_words(field)}"
        curves.set_title(title_of_curves if maps else f"{title_of_curves}; {words}", loc="left")
        curves.set_ylabel(f"|Δ{symbol}| / {norm_symbol}")
        for axes in (curves, *maps):
            _mark_rings(axes, scale)
            axes.set_xlabel(scale.label("radius"))
            # ticks only in the last row: they take most of the time of a figure with many panels
            axes.xaxis.set_visible(number == rows - 1)
            set_linear(axes, "x")
    names = label_of(comparison.other), label_of(comparison.reference)
    # the names come first, because a long title is cut at its end
    titles = f"{names[0]} minus {names[1]}", title
    complete(figure, titles, panels.flat, _note(comparison, others), across=0.7, down=0.25)
    if over_time:
        bar = figure.colorbar(image, ax=list(panels[:, 1]), fraction=0.19, pad=0.03, aspect=35)
        bar.ax.yaxis.set_major_formatter(lambda value, _: power_of_ten(value))
        bar.locator = Decades(numticks=4)
        bar.minorticks_off()
        bar.set_label("relative difference")
    return figure


def _decades(top: float, count: int) -> tuple[float, float]:
    """Return the ends of a logarithmic scale with `count` decades; the last one contains `top`."""
    highest = float(10 ** np.ceil(np.log10(top))) if top > 0 else 1.0
    return highest * 10.0**-count, highest


def _curve_times(fields: Sequence[FieldDifference]) -> list[float]:
    """Choose times for curves: up to five of all times, and those of the largest differences."""
    largest_times = {float(field.times[field.largest[0]]) for field in fields}
    times = np.unique(np.concatenate([field.times for field in fields]))
    return sorted(largest_times | set(times[shown_times(times, 5)].tolist()))


def _draw_curves(
    axes: Axes,
    field: FieldDifference,
    comparison: FieldComparison,
    colours: dict[float, Any],
    scale: Scale,
) -> None:
    """Draw differences along the radius at some times, and error estimates as bands."""
    estimates = {comparison.reference: field.first_error, comparison.other: field.second_error}
    finite_estimates = {name: errors[np.isfinite(errors)] for name, errors in estimates.items()}
    bounds = {name: float(errors.max()) for name, errors in finite_estimates.items() if len(errors)}
    largest = float(np.nanmax(field.relative))
    low, high = _decades(max(2 * largest, *bounds.values(), 0.0), PANEL_DECADES)
    if largest:
        # show the largest difference even if it is far below the error estimates
        low = min(low, 0.1 * largest)
    for (name, bound), line in zip(bounds.items(), ("-.", "--"), strict=False):
        colour, label = scale.look(name)["color"], f"error estimate of {label_of(name)} (band)"
        axes.axhspan(low, bound, color=colour, alpha=0.13, linewidth=0, zorder=0)
        axes.axhline(bound, color=colour, linewidth=1.5, linestyle=line, label=label)
    for time, colour in colours.items():
        for row in np.flatnonzero(field.times == time):
            finite = np.isfinite(field.relative[row])
            heights = np.maximum(field.relative[row, finite], 0.1 * low)
            label = scale.when(time) if np.isfinite(time) else "steady state"
            look: Look = {"marker": "."} if finite.sum() < FEW_RADII else {}
            radii = scale.shown("radius", field.radii[finite])
            axes.plot(radii, heights, color=colour, linewidth=0.8, label=label, **look)
    if largest:
        _, index = field.largest
        axes.plot(scale.shown("radius", field.radii[index]), largest, **MARK)
    set_logarithmic(axes, "y", most=4)
    axes.set_ylim(low, high)


def _draw_map(
    axes: Axes,
    field: FieldDifference,
    contact_edges: Array,
    limits: tuple[float, float],
    scale: Scale,
) -> Any:
    """Draw differences over the radius and all times, as a map in which each time is one row.

    Of very many times, several are one row, which shows the greatest difference of them.
    """
    radii, count = scale.shown("radius", field.radii), len(field.times)
    first_times = np.unique(np.linspace(0, count, ROWS, endpoint=False).astype(int))
    greatest = np.fmax.reduceat(field.relative, first_times, axis=0)
    rows = np.append(first_times, count) - 0.5
    values = np.ma.masked_invalid(np.maximum(greatest, limits[0]))
    mesh = axes.pcolormesh(cell_edges(radii), rows, values, norm=LogNorm(*limits), cmap="magma_r")
    if contact_edges.shape[1] and len(contact_edges) == count:
        places = scale.shown("radius", contact_edges)
        places = np.where(places > _face(scale)[0], places, np.nan)
        look: Look = {"marker": "|", "linestyle": "", "color": "#1565c0", "markersize": 4}
        lines = axes.plot(places, np.arange(count), **look)
        lines[0].set_label("edge of the contact")
    row, index = field.largest
    if field.relative[row, index]:
        mark = MARK | {"markersize": 6.5}
        halo = mark | {"markeredgecolor": "white", "markeredgewidth": 1.8, "label": ""}
        axes.plot(radii[index], row, **halo)
        axes.plot(radii[index], row, **mark)
    labelled = shown_times(field.times, 5)
    # each time in its own unit: short numbers at all times
    labels = [scale.when(time).removeprefix("t = ") for time in field.times[labelled]]
    axes.set_yticks(labelled, labels)
    axes.set(ylim=rows[[0, -1]], ylabel=scale.label("time").partition(" (")[0])
    return mesh


def _face(scale: Scale) -> Array:
    """Return the inner and the outer radius of the face in the units of the axis."""
    edges = scale.problem.ring_edges[[0, -1]] * scale.problem.units.length
    return np.asarray(scale.shown("radius", edges))


def _mark_rings(axes: Axes, scale: Scale) -> None:
    """Mark the ring edges unless there are too many, and limit the axis to the face."""
    edges = scale.problem.ring_edges[1:-1] * scale.problem.units.length
    if len(edges) and not scale.many_rings:
        look: Look = {"color": "0.6", "linewidth": 0.5, "linestyle": ":", "zorder": 1}
        # vertical lines through the whole panel, independent of its scale
        transform = axes.get_xaxis_transform()
        axes.vlines(scale.shown("radius", edges), 0, 1, transform=transform, **look)
    axes.set_xlim(*_face(scale))


def _norm_in_words(field: FieldDifference) -> str:
    """Return the greatest norm of the difference, and the sum of error estimates then, as text."""
    row = int(np.nanargmax(field.norms))
    estimates = [error[row] for error in (field.first_error, field.second_error)]
    known = [error for error in estimates if np.isfinite(error)]
    estimate = f", estimate {one_digit(sum(known))}" if known else ", no error estimate"
    norm = one_digit(float(field.norms[row]))
    return f"norm {norm}{estimate}"


def _largest_in_words(field: FieldDifference, scale: Scale) -> str:
    """Return the largest difference with its radius and time as text."""
    row, index = field.largest
    if not field.relative[row, index]:
        return "no difference"
    time = f", {scale.when(field.times[row])}" if np.isfinite(field.times[row]) else ""
    size = one_digit(float(field.relative[row, index]))
    return f"largest {size} at {scale.where(field.radii[index])}{time}"


def _note(comparison: FieldComparison, others: Sequence[FieldComparison]) -> str:
    """Return the note below the figure: definitions, and differences of other methods."""
    over_time = np.isfinite(comparison.fields[0].times[0])
    lines = [
        "norm: greatest norm over time of the difference over the whole face; estimate: sum of "
        "both error estimates then. Single radii may lie above.",
        "rms: root mean square, weighted by wear and area; d: indentation beyond the first touch, "
        "the greatest so far."
        if over_time
        else "rms: root mean square, weighted by wear and area; uₘₐₓ: the greatest displacement.",
    ]
    if comparison.interpolated:
        lines.append(
            f"{label_of(comparison.other)} is interpolated linearly to the radii of "
            f"{label_of(comparison.reference)}."
        )
    for other in others:
        largest = ", ".join(
            f"{one_digit(float(np.nanmax(field.norms)))} in {WORDS[field.quantity][1]}"
            for field in other.fields
        )
        names = f"{label_of(other.other)} minus {label_of(other.reference)}"
        lines.append(f"Not drawn: {names}, norms up to {largest}.")
    return "\n".join(lines)
