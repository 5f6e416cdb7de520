"""The figure of the study: errors over seconds, errors over tolerances, and the challenge."""

from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, NullLocator

from ..figures.style import PAGE, RED, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LOOKS: dict[str, tuple[str, str, Any, str]] = {
    "mdr": ("#1f4e79", "o", "-", "MDR"),
    "bem": ("#2e7d32", "s", "-.", "BEM"),
    "fem": (RED, "D", "-", "FEM"),
    "direct": ("black", "*", "", "direct integration"),
    "mdr implicit": ("#6fa8dc", "v", ":", "MDR, implicit Euler"),
    "mdr explicit": ("#b36ae2", "<", ":", "MDR, explicit Euler"),
    "mdr-grid": ("#8e6c00", "^", "--", "the paper's own grid"),
    "naive": ("0.45", "X", "-", "naive finite elements"),
    "scikit-fem": ("black", "P", "-", "challenge: scikit-fem"),
    "CalculiX": ("#c0392b", ">", "-.", "challenge: CalculiX"),
    "ContactMechanics": ("#8e44ad", "p", "--", "challenge: ContactMechanics"),
    "Tamaas": ("#16a085", "h", ":", "challenge: Tamaas"),
}
"""Colour, marker, line style and label of each method and program."""
ESTIMATE_DASHES = (0, (4, 2))
"""Line style of the error estimates."""
LABELLED_METHODS = {"mdr": ((-3, -4), "right", "top"), "fem": ((3, 4), "left", "bottom")}
"""Methods whose points are labelled with the tolerance: offset in points, and alignment."""
TITLES = {
    "indentation, force, relaxation times": "d(t), F, relaxation times",
    "history": "whole history",
    "fields": "p, f, u along the radius",
    "steady state": "steady state",
}
"""Short titles of the groups of quantities; others keep their name."""
CHALLENGE_PROBLEMS = {1: "flat punch, start", 3: "five rings, history", 7: "sphere, start"}
"""Titles of the problems of the wear challenge that other programs have solved."""
LETTERS = "abcdefghijklmnopqrstuvwxyz"
"""Letters of the panels, in their order."""
LEFT, RIGHT, TOP, HEIGHT = 0.072, 0.99, 0.92, 7.0
"""Margins of the upper panels as fractions of the figure, and its height in inches."""
NOTE = (
    "Seconds are processor time of one thread, medians of at least three runs; whiskers show the "
    "least and the greatest. Powers of ten at points are the tolerances.\n"
    "Naive finite elements: degree 2, equal elements on the face, clamped at 10 a, explicit "
    "Euler; errors of d and p only. Errors of the challenge are from its README:\n"
    "p below 0.95 a, seconds on one core of a machine that is not named there, to a factor of two;"
    " triangles that point down are upper bounds."
)
"""Text below the panels."""


def draw(rows: pd.DataFrame, effectivities: pd.DataFrame, title: str) -> Figure:
    """Draw errors over seconds and over tolerances, one column per group, and the challenge.

    Parameters
    ----------
    rows : one row per level with an error
    effectivities : table of `list_effectivities`; its medians are in the titles of the second row
    title : title of the scene
    """
    groups = list(rows.group.unique())
    figure = Figure(figsize=(PAGE, HEIGHT), dpi=200)
    margins = {"left": LEFT, "right": RIGHT, "wspace": 0.12}
    grid = figure.add_gridspec(2, len(groups), top=TOP, bottom=0.45, hspace=0.42, **margins)
    panels = [figure.add_subplot(grid[0, column]) for column in range(len(groups))]
    below = [figure.add_subplot(grid[1, column]) for column in range(len(groups))]
    limits = _limits(rows)
    for number, (group, upper, lower) in enumerate(zip(groups, panels, below, strict=True)):
        group_rows = rows[rows.group == group]
        _draw_seconds(upper, group_rows)
        _draw_tolerances(lower, group_rows)
        upper.set_title(f"{LETTERS[number]}  {TITLES.get(group, group)}", loc="left", fontsize=7)
        letter = LETTERS[len(groups) + number]
        name = _effectivity_in_words(effectivities, group)
        lower.set_title(f"{letter}  {name}", loc="left", fontsize=6.4)
        for axes in (upper, lower):
            axes.set_ylim(*limits)
            _set_error_axis(axes, labelled=not number)
        upper.set_xlim(*_seconds_limits(rows))
        upper.set_xlabel("processor time (s)", fontsize=7)
        lower.set_xlabel("tolerance (rtol)", fontsize=7)
        if not number:
            upper.set_ylabel("greatest relative error", fontsize=7)
            lower.set_ylabel("error (line), estimate (dashed)", fontsize=7)
            lower.text(0.03, 0.9, "above the tolerance", fontsize=5.6, color=RED)
            lower.texts[-1].set_transform(lower.transAxes)
    _draw_challenge(figure, 2 * len(groups))
    figure.legend(
        handles=_handles(rows),
        loc="upper left",
        bbox_to_anchor=(0.715, 0.375),
        frameon=False,
        fontsize=6.2,
    )
    heading = f"{title}: speed against accuracy" if title else "Speed against accuracy"
    figure.suptitle(heading, y=0.985, fontsize=9, parse_math=False)
    figure.text(LEFT, 0.018, NOTE, fontsize=5.6, color="0.3")
    return figure


def read_challenge() -> pd.DataFrame:
    """Return the errors and seconds of other programs and of ringwear in the wear challenge.

    A test compares this table, `studies/challenge/others/errors.csv`, with the README beside it.
    """
    with (files("ringwear.studies") / "challenge" / "others" / "errors.csv").open() as listing:
        return pd.read_csv(listing, keep_default_na=True)


def _draw_seconds(axes: "Axes", rows: pd.DataFrame) -> None:
    """Draw errors over seconds with whiskers, and label some points with their tolerance."""
    for name, levels in rows.groupby("method", sort=False):
        color, marker, line, _ = LOOKS[name]
        seconds = levels.seconds
        whiskers = [seconds - levels["least seconds"], levels["greatest seconds"] - seconds]
        axes.errorbar(
            seconds,
            _positive(levels.error),
            xerr=whiskers,
            elinewidth=0.6,
            capsize=1.2,
            **_look(color, marker, line),
        )
        if name in LABELLED_METHODS:
            offset, across, down = LABELLED_METHODS[name]
            for index in _labelled(levels):
                level = levels.iloc[index]
                axes.annotate(
                    _power(level.tolerance),
                    (level.seconds, level.error),
                    xytext=offset,
                    textcoords="offset points",
                    ha=across,
                    va=down,
                    fontsize=5.2,
                    color=color,
                    path_effects=[withStroke(linewidth=1.5, foreground="white")],
                )
    axes.set_xscale("log")
    axes.xaxis.set_minor_locator(NullLocator())


def _draw_tolerances(axes: "Axes", rows: pd.DataFrame) -> None:
    """Draw errors and estimates over the tolerance, and shade errors above the tolerance."""
    with_tolerance = rows.dropna(subset="tolerance")
    for name, levels in with_tolerance.groupby("method", sort=False):
        color, marker, line, _ = LOOKS[name]
        axes.plot(levels.tolerance, _positive(levels.error), **_look(color, marker, line))
        axes.plot(
            levels.tolerance,
            _positive(levels.estimate),
            color=color,
            ls=ESTIMATE_DASHES,
            linewidth=0.8,
        )
    coarsest, finest = with_tolerance.tolerance.max(), with_tolerance.tolerance.min()
    ends = np.array([3 * coarsest, finest / 3])
    axes.plot(ends, ends, color="0.5", linewidth=0.7)
    axes.fill_between(ends, ends, [1e9, 1e9], color=RED, alpha=0.07, linewidth=0)
    axes.set(xscale="log", xlim=ends)
    powers = np.arange(np.ceil(np.log10(finest)), np.log10(coarsest) + 0.5)
    axes.xaxis.set(
        major_locator=FixedLocator(list(10.0 ** powers[:: -2 if len(powers) > 4 else -1])),
        minor_locator=NullLocator(),
    )


def _draw_challenge(figure: Figure, panels_before: int) -> None:
    """Draw the errors of other programs and of ringwear in the wear challenge over their seconds.

    Parameters
    ----------
    panels_before : number of panels that already have a letter
    """
    challenge = read_challenge()
    # a factor of two beyond all points, whose marks are then whole
    seconds, errors = (
        (column.min() / 2, 2 * column.max())
        for column in (challenge["seconds"], challenge["error of p"])
    )
    grid = figure.add_gridspec(
        1, len(CHALLENGE_PROBLEMS), left=LEFT, right=0.7, top=0.365, bottom=0.135, wspace=0.16
    )
    for column, (problem, title) in enumerate(CHALLENGE_PROBLEMS.items()):
        axes = figure.add_subplot(grid[0, column])
        solved = challenge[challenge.problem == problem]
        for name, levels in solved.groupby("program", sort=False):
            color, marker, line, _ = LOOKS[name]
            bounds = levels.bound.notna().all()
            look = _look(color, 7 if bounds else marker, line)
            axes.plot(levels.seconds, levels["error of p"], **look)
        axes.set(xscale="log", xlim=seconds, ylim=errors)
        axes.xaxis.set_minor_locator(NullLocator())
        _set_error_axis(axes, labelled=not column)
        letter = LETTERS[panels_before + column]
        axes.set_title(f"{letter}  challenge {problem}: {title}", loc="left", fontsize=6.4)
        axes.set_xlabel("time (s)", fontsize=7)
        if not column:
            axes.set_ylabel("relative error of p", fontsize=7)


def _look(color: str, marker: Any, line: Any) -> Look:
    """Return the arguments of a curve for matplotlib."""
    return {
        "color": color,
        "marker": marker,
        "linestyle": line,
        "markersize": 3,
        "markerfacecolor": "none",
        "markeredgewidth": 0.8,
        "linewidth": 0.9,
    }


def _handles(rows: pd.DataFrame) -> list[Line2D]:
    """Return the entries of the legend for all methods and programs in any panel."""
    drawn = {*rows.method, *read_challenge().program}
    handles = [
        Line2D([], [], label=label, **_look(color, marker, line))
        for name, (color, marker, line, label) in LOOKS.items()
        if name in drawn
    ]
    dashed: Look = {"color": "0.3", "linestyle": ESTIMATE_DASHES, "linewidth": 0.8}
    return [*handles, Line2D([], [], label="the method's error estimate", **dashed)]


def _effectivity_in_words(effectivities: pd.DataFrame, group: str) -> str:
    """Return the median effectivities of a group for MDR and FEM, as a text."""
    if not len(effectivities):
        return "no estimate"
    group_rows = effectivities[effectivities.group == group].set_index("method")
    medians = group_rows["median effectivity"]
    words = ", ".join(
        f"{LOOKS[name][3]} {_short(medians[name])}" for name in LABELLED_METHODS if name in medians
    )
    return f"effectivity: {words}" if words else "estimate and error"


def _short(number: float) -> str:
    """Return a number with two digits and without an exponent."""
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"


def _labelled(levels: pd.DataFrame) -> list[int]:
    """Return the indices of the levels to label: the first, the middle one and the last.

    A label that would overlap an earlier one is left out.
    """
    positions = np.log10(levels[["seconds", "error"]].to_numpy(float))
    labelled = list[int]()
    for index in sorted({0, len(levels) // 2, len(levels) - 1}):
        distances = [np.abs(positions[index] - positions[other]) for other in labelled]
        if all(across > 0.3 or along > 0.7 for across, along in distances):
            labelled.append(index)
    return labelled


def _power(tolerance: float) -> str:
    """Return a tolerance as a formula: a power of ten, or a multiple of a power of ten."""
    exponent = int(np.floor(np.log10(tolerance) + 1e-9))
    factor = tolerance / 10.0**exponent
    times = "" if np.isclose(factor, 1) else rf"{factor:.0f}\cdot"
    return f"${times}10^{{{exponent}}}$"


def _positive(values: pd.Series) -> pd.Series:
    """Return positive values, and NaN for others, which a logarithmic axis cannot show."""
    return values.where(values > 0)


def _limits(rows: pd.DataFrame) -> tuple[float, float]:
    """Return the ends of the error axis: powers of ten around all errors and estimates."""
    with_tolerance = rows.dropna(subset="tolerance")
    values = np.concatenate([rows.error, with_tolerance.estimate, with_tolerance.tolerance])
    values = values[(values > 0) & np.isfinite(values)]
    low, high = np.log10([values.min(), values.max()])
    return float(10.0 ** np.floor(low - 0.3)), float(10.0 ** np.ceil(high + 0.6))


def _seconds_limits(rows: pd.DataFrame) -> tuple[float, float]:
    """Return the ends of the axis of seconds, with room for the labels at points."""
    return float(rows["least seconds"].min() / 3), float(6 * rows["greatest seconds"].max())


def _set_error_axis(axes: "Axes", labelled: bool) -> None:
    """Set a logarithmic axis of errors with a few powers of ten."""
    axes.set_yscale("log")
    low, high = np.log10(axes.get_ylim())
    powers = np.arange(np.ceil(low), high + 0.01, 2 if high - low > 5 else 1)
    axes.yaxis.set(major_locator=FixedLocator(list(10.0**powers)), minor_locator=NullLocator())
    axes.tick_params(labelsize=6)
    axes.grid(True, color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    if not labelled:
        axes.set_yticklabels([])
