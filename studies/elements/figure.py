"""The figure of the study: eigenvalues, errors, a pressure with checkerboards, wear and locking."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from ...mdr.flat_punch import D0, P0
from ..crosscheck import Array, PressureSpace
from ..figures.style import PAGE, Look, in_style
from ..figures.ticks import power_of_ten
from .choice import SINGULAR, UNSTABLE
from .pairs import Pressures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKERS = "^v<>sDohX*Pp"
"""Markers of the displacements, in the order in which the table has them."""
COLOURS = {
    "continuous, k - 1": "#1f4e79",
    "continuous, k": "#6fa8dc",
    "broken at ring edges, k - 1": "#7d3c98",
    "wear rate continuous": "black",
    "broken everywhere, k - 2": "#2e7d32",
    "constant on facets, k > 1": "#b8860b",
    "broken everywhere, k - 1": "#c0392b",
}
"""Colours of the pressure spaces; their degree is relative to the degree k of the displacement."""
DASHED_PRESSURES = ("wear rate continuous", "broken at ring edges, k - 1")
"""Pressure spaces that are drawn dashed, because their curves lie on curves of others."""
THIN_CURVE: Look = {"linewidth": 0.8, "markersize": 3.2, "markerfacecolor": "none"}


class DrawnPressure(NamedTuple):
    """The pressure of the flat start as one pair of spaces computes it.

    Parameters
    ----------
    displacement : name of the displacement element
    pressures : pressure space of the pair
    space, coefficients : the pressure, by its coefficients (size,) in the full pressure space
    indentation : at the start, in F/(a E*); 1/2 is exact
    error : error of the pressure over its norm, as `start_error` measures it
    """

    displacement: str
    pressures: Pressures
    space: PressureSpace
    coefficients: Array
    indentation: float
    error: float


def draw(table: pd.DataFrame, choice: pd.DataFrame, drawn: Sequence[DrawnPressure]) -> Figure:
    """Draw six panels with one legend below them.

    Parameters
    ----------
    table : one row per level of every family
    choice : one row per pair, of `choose`
    drawn : pressures of the flat start for panel d
    """
    with in_style():
        figure = Figure(figsize=(PAGE, 6.3), dpi=200)
        axes = figure.subplots(2, 3).ravel()
        figure.subplots_adjust(0.075, 0.215, 0.985, 0.885, wspace=0.34, hspace=0.48)
        pairs = table[~table.family.str.startswith("locking")].copy()
        columns = pairs[["pressure", "degree", "pressure degree"]]
        pairs["group"] = [_group(*row) for row in columns.itertuples(index=False)]
        markers = _markers(table)
        failures = _failures_in_words(choice)
        titles = (
            ("least eigenvalue", "a  least eigenvalue: falls as $h^2$\nwith checkerboards"),
            ("p at the start", "b  flat start, error of the pressure:\ngrows with checkerboards"),
            ("d0", "c  flat start, error of $d_0$:\nthe same pairs look accurate"),
        )
        labels = ("eigenvalue, FEM over MDR", "error of p over its norm", "relative error of $d_0$")
        for panel, (column, title), label in zip(axes[:3], titles, labels, strict=True):
            _draw_groups(panel, pairs, column, markers)
            panel.set(ylabel=label)
            panel.set_title(title, loc="left")
        _draw_pressures(axes[3], drawn)
        _draw_groups(axes[4], pairs, "p(t)", markers)
        axes[4].set(ylabel="greatest error of p(t) over its norm")
        axes[4].set_title(
            "e  wear: checkerboards heal, but p\ncontinuous at ring edges fails", loc="left"
        )
        _draw_locking(axes[5], table, markers)
        for panel in axes:
            panel.grid(True, color="0.9", linewidth=0.5)
            panel.set_axisbelow(True)
        _add_legend(figure, pairs, markers, bool(drawn))
        note = f": {failures}" if failures else ""
        figure.suptitle(f"Which pair of displacement and pressure is stable{note}", y=0.985)
    return figure


def _group(kind: str, degree: float, pressure_degree: float) -> str:
    """Return the name in `COLOURS` of the pressure space of a pair; empty if it is not drawn."""
    if not isinstance(kind, str):
        return ""
    if kind == "wear rate continuous":
        return kind
    reduction = degree - pressure_degree
    if kind == "broken everywhere" and pressure_degree == 0 and degree > 1:
        return "constant on facets, k > 1"
    name = f"{kind}, k" if reduction == 0 else f"{kind}, k - {reduction:.0f}"
    return name if name in COLOURS else ""


def _markers(table: pd.DataFrame) -> dict[str, str]:
    """Return the marker of each displacement in the table."""
    names = table["displacement"].dropna().unique()
    return {name: MARKERS[number % len(MARKERS)] for number, name in enumerate(names)}


def _failures_in_words(choice: pd.DataFrame) -> str:
    """Return how many pairs are unstable or singular, as a text for the title."""
    if not len(choice):
        return ""
    counts = choice["stable"].value_counts()
    return (
        f"{counts.get(UNSTABLE, 0)} of {len(choice)} pairs have checkerboards; "
        f"{counts.get(SINGULAR, 0)} are singular and not drawn"
    )


def _draw_groups(panel: "Axes", pairs: pd.DataFrame, column: str, markers: dict[str, str]) -> None:
    """Draw a column of the table over the number of facets, one curve per pair."""
    shown = pairs[(pairs["group"] != "") & pairs["d0"].notna() & pairs[column].notna()]
    for (group, displacement), rows in shown.groupby(["group", "displacement"], sort=False):
        style = "--" if group in DASHED_PRESSURES else "-"
        panel.loglog(
            rows["facets"],
            rows[column].abs(),
            color=COLOURS[str(group)],
            marker=markers[str(displacement)],
            linestyle=style,
            **THIN_CURVE,
        )
    facets = np.unique(shown["facets"].to_numpy(float))
    if len(facets):
        panel.xaxis.set_major_locator(FixedLocator(facets.tolist()))
    panel.xaxis.set_minor_locator(NullLocator())
    panel.xaxis.set_major_formatter(lambda value, _: f"{value:.0f}")
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.set_xlabel("facets on the contact")


def _draw_pressures(panel: "Axes", drawn: Sequence[DrawnPressure]) -> None:
    """Draw the pressure of the flat start by an unstable and by a stable pair."""
    radii = np.linspace(0.0, 0.9995, 2001)
    exact = P0 / np.sqrt(1 - radii**2)
    for pressure in drawn:
        ends = pressure.space.breakpoints
        inside = np.sort(np.concatenate([ends[:-1] + 1e-9, ends[1:] - 1e-9]))
        kind, degree = pressure.pressures.kind, pressure.pressures.degree
        color = COLOURS[_group(kind, degree + 1, degree)]
        width = 0.7 if kind == "broken everywhere" else 1.6
        values = pressure.space.matrix(inside) @ pressure.coefficients
        panel.plot(inside, values, color, linewidth=width)
    panel.plot(radii, exact, "k:", linewidth=1.0)
    panel.set(xlim=(0, 1), ylim=(-1.7, 1.9), xlabel="r / a", ylabel="$p\\,a^2/F$, flat start")
    title = "d  pressures of a flat start"
    if drawn:
        depth_errors = " and ".join(
            f"{100 * abs(each.indentation / D0 - 1):.1f} %" for each in drawn
        )
        errors = " and ".join(f"{each.error:.2g}" for each in drawn)
        title = (
            f"d  {drawn[0].displacement}: $d_0$ errs by {depth_errors},\np by {errors} of its norm"
        )
    panel.set_title(title, loc="left")


def _draw_locking(panel: "Axes", table: pd.DataFrame, markers: dict[str, str]) -> None:
    """Draw the error of d0 as Poisson's ratio tends to 1/2."""
    rows = table[table.family.str.startswith("locking") & table["d0"].notna()]
    for name, levels in rows.groupby("displacement", sort=False):
        compressibility = 1 - 2 * levels["poisson ratio"].to_numpy(float)
        panel.loglog(
            compressibility,
            levels["d0"].abs(),
            color="0.25",
            marker=markers[str(name)],
            **THIN_CURVE,
        )
    facets = f", {rows['facets'].iloc[0]:.0f} facets" if len(rows) else ""
    panel.set(xlabel=r"$1 - 2 \nu$", ylabel=f"relative error of $d_0${facets}")
    panel.xaxis.set_major_formatter(lambda value, _: power_of_ten(value))
    panel.xaxis.set_minor_locator(NullLocator())
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.invert_xaxis()
    panel.set_title("f  locking towards $\\nu = 1/2$,\npressures as in ringwear run", loc="left")


def _add_legend(figure: Figure, pairs: pd.DataFrame, markers: dict[str, str], exact: bool) -> None:
    """Add one legend for all panels: pressures by colour, displacements by marker."""
    groups = set(pairs["group"])
    handles = [
        Line2D(
            [],
            [],
            color=color,
            linestyle="--" if name in DASHED_PRESSURES else "-",
            label=f"p {name}",
        )
        for name, color in COLOURS.items()
        if name in groups
    ]
    if exact:
        handles.append(Line2D([], [], color="black", linestyle=":", label="exact"))
    handles += [
        Line2D(
            [],
            [],
            color="0.25",
            linestyle="none",
            marker=mark,
            markerfacecolor="none",
            label=f"u {name}",
        )
        for name, mark in markers.items()
    ]
    figure.legend(
        handles=handles,
        loc="lower center",
        ncols=4,
        frameon=False,
        fontsize=6.5,
        title="pressure p, its degree relative to the degree k of the displacement u",
    )
