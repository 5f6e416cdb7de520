"""Figures of a fit: data and residuals, profiles of the likelihood, and the next measurement."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator
from scipy.stats import norm

from ...meshes.radial import Array
from ..figures.style import FAINT, PAGE, curve, new_figure, set_logarithmic
from ..problem.unit_names import UnitNames
from .measurement import Measurement
from .outcome import Outcome

UNITS = {
    "indentation": "displacement",
    "profile": "displacement",
    "normal_force": "force",
    "worn_volume": "volume",
}
TWO_SIDED = float(norm.ppf(0.975))
# quantities of which each has a panel; further measurements at the most shown in one
MOST_SHOWN = 6
# span of times from which on they are drawn by their logarithms
WIDE = 30.0
# rise of chi-square up to which profiles are drawn
HIGHEST = 9.0


def draw_all(fit: Outcome) -> dict[str, Figure]:
    """Return the figures that a fit has, by name."""
    figures = {"fit": draw_fit(fit)}
    if fit.profiles.traces:
        figures["likelihood"] = draw_profiles(fit)
    if len(fit.design):
        figures["design"] = draw_design(fit)
    return figures


def draw_fit(fit: Outcome) -> Figure:
    """Draw data with the fit and its 95 % band, above their residuals, by quantity."""
    quantities = list(dict.fromkeys(each.quantity for each in fit.measurements))
    figure = new_figure(PAGE, 4.2)
    panels = figure.subplots(2, len(quantities), squeeze=False, height_ratios=[2, 1])
    names, table, bands = UnitNames.of(fit.scene.units), fit.residuals, fit.bands
    rows = np.cumsum([0, *(len(each.values) for each in fit.measurements)])
    for column, quantity in enumerate(quantities):
        upper, lower = panels[:, column]
        of_it = [
            (each, slice(rows[number], rows[number + 1]))
            for number, each in enumerate(fit.measurements)
            if each.quantity == quantity
        ]
        greatest = max(float(np.abs(each.values).max()) for each, _ in of_it)
        unit, unit_name = names.readable(greatest, UNITS[quantity])
        for number, (each, part) in enumerate(of_it[:MOST_SHOWN]):
            look = curve(number)
            places, label = _abscissa(each, names)
            order = np.argsort(places)
            measured, fitted = table["measured"][part], table["fitted"][part]
            upper.plot(
                places,
                measured / unit,
                look["marker"],
                color=look["color"],
                markersize=3,
                fillstyle="none",
                label=_label(each, names, len(of_it)),
            )
            upper.plot(places[order], (fitted / unit).to_numpy()[order], color="#c0392b")
            band = bands[part]
            upper.fill_between(
                places[order],
                ((fitted - band) / unit).to_numpy()[order],
                ((fitted + band) / unit).to_numpy()[order],
                color="#c0392b",
                alpha=0.25,
                linewidth=0,
            )
            lower.plot(
                places,
                table["residual"][part],
                look["marker"],
                color=look["color"],
                markersize=3,
                fillstyle="none",
            )
            relative = (band / each.noise)[order]
            lower.fill_between(
                places[order], -relative, relative, color="#c0392b", alpha=0.25, linewidth=0
            )
            lower.set_xlabel(label)
        for height in (-TWO_SIDED, 0.0, TWO_SIDED):
            lower.axhline(height, **FAINT)
        _scale_times((upper, lower), of_it[0][0])
        what = quantity.replace("_", " ")
        upper.set_ylabel(f"{what} ({unit_name})" if unit_name else what)
        lower.set_ylabel("residual / noise")
        if len(of_it) > 1:
            upper.legend(frameon=False, fontsize=6)
    figure.suptitle("data, fit and its 95 % band", fontsize=9)
    return figure


def draw_profiles(fit: Outcome) -> Figure:
    """Draw the least chi-square by each parameter whose interval it gives, beside the parabola."""
    numbers = sorted(fit.profiles.traces)
    columns = min(len(numbers), 4)
    rows = -(-len(numbers) // columns)
    figure = new_figure(PAGE, 0.6 + 1.9 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for axes in panels[len(numbers) :]:
        axes.set_visible(False)
    names = UnitNames.of(fit.scene.units)
    for axes, number in zip(panels, numbers, strict=False):
        each = fit.found[number]
        traced = dict([*fit.profiles.traces[number], fit.own_point(number)])
        places, rises = np.array(sorted(traced.items())).T
        rises = rises - fit.chi_square
        near = rises <= HIGHEST
        values = np.array([each.parameter.at(place) for place in places])
        axes.plot(values[near], rises[near], "o", color="black", markersize=2.5)
        dense = np.linspace(places[near].min(), places[near].max(), 200)
        # the root of the rise is nearly straight between points
        signed = np.sign(places - each.best) * np.sqrt(np.maximum(rises, 0.0))
        axes.plot(
            [each.parameter.at(x) for x in dense],
            PchipInterpolator(places, signed)(dense) ** 2,
            color="black",
            linewidth=1,
        )
        place = fit.likelihood.free.index(number)
        deviation = np.sqrt(fit.covariance[place, place])
        along = np.linspace(places[near].min(), places[near].max(), 200)
        parabola = ((along - each.best) / deviation) ** 2
        low = parabola <= HIGHEST
        axes.plot(
            [each.parameter.at(x) for x in along[low]],
            parabola[low],
            "--",
            color="0.5",
            linewidth=0.8,
        )
        axes.axhline(fit.profiles.threshold, **FAINT)
        if each.parameter.logarithmic and np.ptp(places[near]) > np.log(WIDE):
            set_logarithmic(axes, "x")
        elif each.parameter.logarithmic:
            axes.locator_params(axis="x", nbins=3)
        unit = names.name(each.parameter.unit) if each.parameter.unit != "compliance" else "1"
        label = each.parameter.name.partition(".")[2] or each.parameter.name
        axes.set_xlabel(label if unit == "1" else f"{label} ({unit})", fontsize=7)
        axes.set_ylim(0, HIGHEST)
    for axes in panels[::columns]:
        axes.set_ylabel("rise of chi-square")
    figure.suptitle(
        "profiles of the likelihood; dashed: by curvature; dotted: ends of intervals", fontsize=9
    )
    return figure


def draw_design(fit: Outcome) -> Figure:
    """Draw the half widths of all intervals before and after each further measurement."""
    table = fit.design
    figure = new_figure(PAGE, 1.2 + 0.2 * len(table))
    axes = figure.subplots()
    names = [
        f"half width of {each.parameter.name}"
        for number, each in enumerate(fit.found)
        if each.parameter.logarithmic and number in fit.likelihood.free
    ]
    heights = np.arange(1, len(table) + 1)
    before = table.attrs["before"]
    for number, name in enumerate(names):
        look = curve(number) | {"linestyle": ""}
        places = np.append(before[name], table[name].to_numpy())
        axes.plot(places, np.append(0, heights), **look, label=name.removeprefix("half width of "))
    axes.set_yticks([0, *heights], ["the data alone", *table["measurement"]], fontsize=6)
    axes.invert_yaxis()
    set_logarithmic(axes, "x")
    axes.set_xlabel("half width of the 95 % interval, of logarithms")
    axes.grid(axis="x", color="0.9", linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=7)
    figure.suptitle("intervals with one further measurement", fontsize=9)
    return figure


def _abscissa(each: Measurement, names: UnitNames) -> tuple[Array, str]:
    """Return what a measurement is drawn over, and its label with a unit."""
    places, name, kind = each.times, "time t", "time"
    if each.radii is not None:
        places, name, kind = each.radii, "radius r", "length"
    unit, unit_name = names.readable(float(np.abs(places).max()), kind)
    return places / unit, f"{name} ({unit_name})" if unit_name else name


def _label(each: Measurement, names: UnitNames, several: int) -> str:
    if each.radii is not None:
        return f"t = {names.write(float(each.times[0]), 'time', 3)}"
    return each.label if several > 1 else "data"


def _scale_times(panels: tuple[Axes, ...], each: Measurement) -> None:
    """Draw times that span much by their logarithms."""
    positive = each.times[each.times > 0]
    if each.radii is None and len(positive) and positive.max() > WIDE * positive.min():
        for axes in panels:
            set_logarithmic(axes, "x")
