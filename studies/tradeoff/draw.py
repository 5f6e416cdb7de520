"""The figure of the tradeoff: errors over seconds, errors over tolerances, and the challenge."""

from collections.abc import Mapping
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, NullLocator

from ..figures.style import PAGE, RED

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
"""Colour, marker, line and label of each method and program."""
STATED = (0, (4, 2))
"""Dashes of what methods state."""
LABELLED = {"mdr": ((-3, -4), "right", "top"), "fem": ((3, 4), "left", "bottom")}
"""Methods at whose points the tolerance is written, where, and how it is aligned."""
TITLES = {
    "indentation, force, relaxation times": "d(t), F, relaxation times",
    "history": "whole history",
    "fields": "p, f, u along the radius",
    "steady state": "steady state",
}
"""Short titles of the groups of quantities; others keep their name."""
PROBLEMS = {1: "flat punch, start", 3: "five rings, history", 7: "sphere, start"}
"""Problems of the wear challenge that programs of others have solved."""
LETTERS = "abcdefghijklmnopqrstuvwxyz"
LEFT, RIGHT, TOP, HEIGHT = 0.072, 0.99, 0.92, 7.0
NOTE = (
    "Seconds of the processor, one thread, medians of at least three runs; whiskers end at the "
    "least and the greatest. Powers of ten at points are the tolerances asked for.\n"
    "Naive finite elements: degree 2, equal elements on the face, clamped at 10 a, explicit "
    "Euler; errors of d and p alone. Errors of the challenge are those of its README:\n"
    "p below 0.95 a, seconds on one core of a machine that is not named there, to a factor of two;"
    " triangles that point down are upper bounds."
)


def draw(rows: pd.DataFrame, effectivities: pd.DataFrame, title: str) -> Figure:
    """Draw errors over seconds and over tolerances, a column for each group, and the challenge.

    Parameters
    ----------
    rows : levels with an error
    effectivities : their medians by group and method, for the titles of the second row
    title : of the scene
    """
    groups = list(rows.group.unique())
    figure = Figure(figsize=(PAGE, HEIGHT), dpi=200)
    place = {"left": LEFT, "right": RIGHT, "wspace": 0.12}
    grid = figure.add_gridspec(2, len(groups), top=TOP, bottom=0.45, hspace=0.42, **place)
    panels = [figure.add_subplot(grid[0, column]) for column in range(len(groups))]
    below = [figure.add_subplot(grid[1, column]) for column in range(len(groups))]
    limits = _limits(rows)
    for number, (group, upper, lower) in enumerate(zip(groups, panels, below, strict=True)):
        of_group = rows[rows.group == group]
        _draw_seconds(upper, of_group)
        _draw_tolerances(lower, of_group)
        upper.set_title(f"{LETTERS[number]}  {TITLES.get(group, group)}", loc="left", fontsize=7)
        letter = LETTERS[len(groups) + number]
        name = _effectivity_in_words(effectivities, group)
        lower.set_title(f"{letter}  {name}", loc="left", fontsize=6.4)
        for axes in (upper, lower):
            axes.set_ylim(*limits)
            _set_error_axis(axes, labelled=not number)
        upper.set_xlim(*_seconds_limits(rows))
        upper.set_xlabel("processor time (s)", fontsize=7)
        lower.set_xlabel("tolerance asked for", fontsize=7)
        if not number:
            upper.set_ylabel("greatest relative error", fontsize=7)
            lower.set_ylabel("error (line), estimate (dashed)", fontsize=7)
            lower.text(0.03, 0.9, "worse than asked for", fontsize=5.6, color=RED)
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
    """Return what `studies/challenge/others/README.md` says of programs of others, and of ours."""
    with (files("ringwear.studies") / "challenge" / "others" / "errors.csv").open() as listing:
        return pd.read_csv(listing, keep_default_na=True)


def _draw_seconds(axes: "Axes", rows: pd.DataFrame) -> None:
    """Draw errors over seconds with whiskers, and tolerances at some points."""
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
        if name in LABELLED:
            offset, across, down = LABELLED[name]
            for at in _labelled(levels):
                level = levels.iloc[at]
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
    """Draw true and stated errors over the tolerance, and where an error is above it."""
    asked = rows.dropna(subset="tolerance")
    for name, levels in asked.groupby("method", sort=False):
        color, marker, line, _ = LOOKS[name]
        axes.plot(levels.tolerance, _positive(levels.error), **_look(color, marker, line))
        axes.plot(
            levels.tolerance, _positive(levels.estimate), color=color, ls=STATED, linewidth=0.8
        )
    coarsest, finest = asked.tolerance.max(), asked.tolerance.min()
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
    """Draw what programs of others, and ours, err by in the wear challenge."""
    challenge = read_challenge()
    grid = figure.add_gridspec(
        1, len(PROBLEMS), left=LEFT, right=0.7, top=0.365, bottom=0.135, wspace=0.16
    )
    for column, (problem, title) in enumerate(PROBLEMS.items()):
        axes = figure.add_subplot(grid[0, column])
        solved = challenge[challenge.problem == problem]
        for name, levels in solved.groupby("program", sort=False):
            color, marker, line, _ = LOOKS[name]
            bounds = levels.bound.notna().all()
            look = _look(color, 7 if bounds else marker, line)
            axes.plot(levels.seconds, levels["error of p"], **look)
        axes.set(xscale="log", xlim=(8e-3, 5), ylim=(1e-9, 1))
        axes.xaxis.set_minor_locator(NullLocator())
        _set_error_axis(axes, labelled=not column)
        letter = LETTERS[panels_before + column]
        axes.set_title(f"{letter}  challenge {problem}: {title}", loc="left", fontsize=6.4)
        axes.set_xlabel("time (s)", fontsize=7)
        if not column:
            axes.set_ylabel("relative error of p", fontsize=7)


def _look(color: str, marker: Any, line: Any) -> dict[str, Any]:
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
    """Return the entries of the legend: what is drawn in any panel."""
    drawn = {*rows.method, *read_challenge().program}
    handles = [
        Line2D([], [], label=label, **_look(color, marker, line))
        for name, (color, marker, line, label) in LOOKS.items()
        if name in drawn
    ]
    stated: Mapping[str, Any] = {"color": "0.3", "linestyle": STATED, "linewidth": 0.8}
    return [*handles, Line2D([], [], label="the method's own estimate", **stated)]


def _effectivity_in_words(effectivities: pd.DataFrame, group: str) -> str:
    """Return the medians of stated over true errors of a group, for MDR and FEM."""
    if not len(effectivities):
        return "no estimate"
    of_group = effectivities[effectivities.group == group].set_index("method")
    medians = of_group["median effectivity"]
    words = ", ".join(
        f"{LOOKS[name][3]} {_short(medians[name])}" for name in LABELLED if name in medians
    )
    return f"stated/true: {words}" if words else "stated and true error"


def _short(number: float) -> str:
    """Return a number with two digits, and without an exponent."""
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"


def _labelled(levels: pd.DataFrame) -> list[int]:
    """Return which of the levels show their tolerance: the first, the middle one and the last.

    Of neighbours whose labels would overlap, the first does.
    """
    places = np.log10(levels[["seconds", "error"]].to_numpy(float))
    chosen = list[int]()
    for at in sorted({0, len(levels) // 2, len(levels) - 1}):
        apart = [np.abs(places[at] - places[other]) for other in chosen]
        if all(across > 0.3 or along > 0.7 for across, along in apart):
            chosen.append(at)
    return chosen


def _power(tolerance: float) -> str:
    """Return a tolerance as a formula: a power of ten, or a multiple of one."""
    exponent = int(np.floor(np.log10(tolerance) + 1e-9))
    factor = tolerance / 10.0**exponent
    times = "" if np.isclose(factor, 1) else rf"{factor:.0f}\cdot"
    return f"${times}10^{{{exponent}}}$"


def _positive(values: pd.Series) -> pd.Series:
    """Return values that a logarithmic axis can show."""
    return values.where(values > 0)


def _limits(rows: pd.DataFrame) -> tuple[float, float]:
    """Return ends of the axis of errors, powers of ten that hold all errors and estimates."""
    asked = rows.dropna(subset="tolerance")
    values = np.concatenate([rows.error, asked.estimate, asked.tolerance])
    values = values[(values > 0) & np.isfinite(values)]
    low, high = np.log10([values.min(), values.max()])
    return float(10.0 ** np.floor(low - 0.3)), float(10.0 ** np.ceil(high + 0.6))


def _seconds_limits(rows: pd.DataFrame) -> tuple[float, float]:
    """Return ends of the axis of seconds, with room for the tolerances at points."""
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
