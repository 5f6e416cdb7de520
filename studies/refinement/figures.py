"""Draw errors of the ways to refine over unknowns and seconds, and the error indicator."""

import textwrap
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator

from ..figures.style import FAINT, PAGE, Look, complete, new_panels, set_logarithmic
from ..figures.ticks import short_number
from ..study.levels import SECONDS
from .case import ERRORS
from .observed_orders import FAMILY_NAMES, sequences

LOOKS: dict[str, Look] = {
    "uniform": {"color": "#8a8a8a", "marker": "o", "linestyle": ":"},
    "graded": {"color": "#2e7d32", "marker": "D", "linestyle": "-."},
    "adaptive": {"color": "#c0392b", "marker": "^", "linestyle": "-"},
    "layered": {"color": "#1f4e79", "marker": "s", "linestyle": "--"},
    "degree": {"color": "#8e44ad", "marker": "v", "linestyle": (0, (5, 1, 1, 1))},
    "file": {"color": "black", "marker": "x", "linestyle": "-"},
}
"""Look of the curve of each family."""
LARGE_EFFECTIVITY = 10.0
"""If effectivities exceed this value, their axis is logarithmic."""
THOUSANDS = "thousands of unknowns"
"""Label of axes with the ticks of `_mark_thousands`."""


def draw_errors(rows: pd.DataFrame, column: str, label: str, titles: Mapping[str, str]) -> Figure:
    """Draw the errors of every way over a column of the table, one row of panels for each case.

    Parameters
    ----------
    rows : table of the study
    column, label : column of the abscissas, and its label
    titles : titles of the cases by their names
    """
    cases = list(rows["case"].unique())
    figure, panels = new_panels(PAGE, 0.9 + 2.0 * len(cases), len(cases), len(ERRORS))
    orders = {(sequence.name, sequence.quantity): sequence.order for sequence in sequences(rows)}
    for axes_of_case, case in zip(panels, cases, strict=True):
        for axes, (quantity, title) in zip(axes_of_case, ERRORS.items(), strict=True):
            case_rows = rows[rows["case"] == case]
            for family, levels in case_rows.groupby("family", sort=False):
                axes.plot(levels[column], levels[quantity], **_look(str(family), levels))
                order = orders.get((f"{case}, {family}", quantity), np.nan)
                if column == "unknowns" and family == "file" and np.isfinite(order):
                    last_level = levels.iloc[-1]
                    axes.annotate(
                        f"order {order:.1f}",
                        (last_level[column], last_level[quantity]),
                        xytext=(0, 4),
                        textcoords="offset points",
                        fontsize=6,
                        path_effects=[withStroke(linewidth=2, foreground="white")],
                    )
            set_logarithmic(axes, "x", "y")
            if column == "unknowns":
                _mark_thousands(axes)
            axes.grid(True, color="0.92", linewidth=0.5)
            axes.axhline(1e-3, **FAINT)
            axes.set_title(f"{titles[case]}\n{title}")
        axes_of_case[0].set_ylabel("relative error")
    for axes in panels[-1]:
        axes.set_xlabel(label)
    note = "The dotted line is an error of 0.001."
    if column == SECONDS:
        note += " The seconds of an adaptive mesh include all coarser levels and error estimates."
    elif (rows.family == "file").any():
        note += " The order of your meshes is the slope over N^(-1/2) with N unknowns."
    return complete(
        figure,
        [f"Errors of each way to refine, over {column}"],
        panels.ravel(),
        note,
        across=0.42,
        down=0.5,
    )


def draw_indicator(rows: pd.DataFrame, titles: Mapping[str, str]) -> Figure:
    """Draw the effectivity of the indicator, and the energy errors of all ways.

    `titles` are the titles of the cases by their names.
    """
    cases = list(rows["case"].unique())
    figure, panels = new_panels(PAGE, 0.9 + 1.9 * len(cases), len(cases), 2)
    for (ratios, energies), case in zip(panels, cases, strict=True):
        case_rows = rows[rows["case"] == case]
        for family, levels in case_rows.groupby("family", sort=False):
            look = _look(str(family), levels)
            estimated = levels.dropna(subset="least effectivity")
            if len(estimated):
                unknowns = estimated["unknowns"].to_numpy(float)
                least, greatest = (
                    estimated[f"{which} effectivity"].to_numpy(float)
                    for which in ("least", "greatest")
                )
                ratios.plot(unknowns, least, **look)
                ratios.plot(unknowns, greatest, **{**look, "label": None})
                ratios.fill_between(unknowns, least, greatest, color=look["color"], alpha=0.15)
            energies.plot(levels["unknowns"], levels["energy"].where(levels["energy"] > 0), **look)
        ratios.set_ylabel("indicator over error")
        set_logarithmic(ratios, "x")
        if case_rows["greatest effectivity"].max() > LARGE_EFFECTIVITY:
            set_logarithmic(ratios, "y")
        else:
            ratios.set_ylim(0, LARGE_EFFECTIVITY)
        ratios.set_title(f"{titles[case]}\neffectivity, least and greatest over the states")
        set_logarithmic(energies, "x", "y")
        energies.set_ylabel("relative error")
        energies.set_title(f"{titles[case]}\nenergy norm of the error, greatest over the states")
        for axes in (ratios, energies):
            _mark_thousands(axes)
            axes.grid(True, color="0.92", linewidth=0.5)
    for axes in panels[-1]:
        axes.set_xlabel(THOUSANDS)
    title = "The error indicator, and the error that it estimates"
    return complete(figure, [title], panels[:, 1], across=0.6, down=0.5)


def _mark_thousands(axes: Axes) -> None:
    """Set ticks at 1, 3, 10, 30, ... thousand on a logarithmic axis of unknowns."""
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    axes.xaxis.set_major_formatter(lambda value, _: short_number(value / 1000))


def _look(family: str, levels: pd.DataFrame) -> Look:
    """Return the look of the curve of a family; the user's meshes have their names as label."""
    label = FAMILY_NAMES[family]
    if family in ("uniform", "graded", "adaptive"):
        label += f", degree {levels['degree'].iloc[0]}"
    if family == "file":
        names = textwrap.shorten(", ".join(levels["setting"]), 60, placeholder=" ...")
        degrees = ", ".join(str(degree) for degree in sorted(set(levels["degree"])))
        label = f"{names}: degree {degrees}"
    return {
        "markersize": 3.0,
        "markerfacecolor": "none",
        "markeredgewidth": 0.7,
        "linewidth": 1.0,
        "label": label,
        **LOOKS[family],
    }
