"""Figures of a fit: data and residuals, and profiles of the likelihood."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtri

from ...meshes import Array
from ..crosscheck import UnitNames
from ..estimate.measurement import Measurement
from ..figures.style import (
    FAINT,
    PAGE,
    curve,
    new_figure,
    set_linear,
    set_logarithmic,
    show_values,
)
from ..tables.headings import KINDS

if TYPE_CHECKING:
    from .result import Fit

# colour of the fit, and look of its band
RED = "#c0392b"
BAND: Any = {"color": RED, "alpha": 0.25, "linewidth": 0}
# half width of the 95 % interval of a normal variable of deviation one
NORMAL_HALF_WIDTH = float(ndtri(0.975))
# greatest number of measurements of one quantity that are drawn in its panel
MAX_SERIES = 6
# least ratio of the last to the first value of an axis that is drawn logarithmically
LOGARITHMIC_RATIO = 30.0
# greatest rise of chi-square that is drawn in profiles
MAX_RISE = 9.0


def draw_all(fit: "Fit") -> dict[str, Figure]:
    """Return the figures of a fit, by name."""
    figures = {"fit": draw_fit(fit)}
    if fit.profiles.traces:
        figures["likelihood"] = draw_profiles(fit)
    return figures


def draw_fit(fit: "Fit") -> Figure:
    """Draw the data with the fit and its 95 % band, and their residuals below, by quantity."""
    quantities = list(dict.fromkeys(each.quantity for each in fit.measurements))
    figure = new_figure(PAGE, 4.2)
    panels = figure.subplots(2, len(quantities), squeeze=False, height_ratios=[2, 1])
    names, table = fit.scene.unit_names, fit.residuals.assign(band=fit.bands)
    rows = zip(fit.measurements, fit.likelihood.split(np.arange(len(table))), strict=True)
    tables = [(each, table.iloc[part]) for each, part in rows]
    for column, quantity in enumerate(quantities):
        upper, lower = panels[:, column]
        series = [(each, part) for each, part in tables if each.quantity == quantity]
        greatest = max(float(np.abs(each.values).max()) for each, _ in series)
        unit, unit_name = names.readable(greatest, KINDS[quantity])
        for number, (each, part) in enumerate(series[:MAX_SERIES]):
            look = curve(number)
            abscissas, label = _abscissa(each, names)
            drawn = part.assign(at=abscissas).sort_values("at")
            at, fitted, band = drawn["at"], drawn["fitted"], drawn["band"]
            points = {"color": look["color"], "markersize": 3, "fillstyle": "none"}
            name = _label(each, names, len(series))
            upper.plot(at, drawn["measured"] / unit, look["marker"], **points, label=name)
            upper.plot(at, fitted / unit, color=RED)
            upper.fill_between(at, (fitted - band) / unit, (fitted + band) / unit, **BAND)
            lower.plot(at, drawn["residual"], look["marker"], **points)
            relative = band / drawn["noise"]
            lower.fill_between(at, -relative, relative, **BAND)
            lower.set_xlabel(label)
        for height in (-NORMAL_HALF_WIDTH, 0.0, NORMAL_HALF_WIDTH):
            lower.axhline(height, **FAINT)
        _scale_times((upper, lower), series[0][0])
        title = quantity.replace("_", " ")
        upper.set_ylabel(f"{title} ({unit_name})" if unit_name else title)
        lower.set_ylabel("residual / noise")
        show_values(upper)
        set_linear(lower, "y", most=4)
        if len(series) > 1:
            upper.legend(frameon=False, fontsize=6)
    figure.suptitle("data, fit, and 95 % band of the fit", fontsize=9)
    return figure


def draw_profiles(fit: "Fit") -> Figure:
    """Draw the profiles of the likelihood of parameters whose intervals follow from them."""
    numbers = sorted(fit.profiles.traces)
    columns = min(len(numbers), 4)
    rows = -(-len(numbers) // columns)
    figure = new_figure(PAGE, 0.6 + 1.9 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for axes in panels[len(numbers) :]:
        axes.set_visible(False)
    names = fit.scene.unit_names
    for axes, number in zip(panels, numbers, strict=False):
        estimate = fit.found[number]
        trace = dict([*fit.profiles.traces[number], (estimate.best, fit.chi_square)])
        coordinates, rises = np.array(sorted(trace.items())).T
        rises = rises - fit.chi_square
        drawn = rises <= MAX_RISE
        value_at = np.vectorize(estimate.parameter.at)
        values = value_at(coordinates)
        axes.plot(values[drawn], rises[drawn], "o", color="black", markersize=2.5)
        dense = np.linspace(coordinates[drawn].min(), coordinates[drawn].max(), 200)
        # the root of the rise is interpolated, because it is nearly linear between points
        signed = np.sign(coordinates - estimate.best) * np.sqrt(np.maximum(rises, 0.0))
        axes.plot(
            value_at(dense),
            PchipInterpolator(coordinates, signed)(dense) ** 2,
            color="black",
            linewidth=1,
        )
        axes.axhline(fit.profiles.threshold, **FAINT)
        if estimate.parameter.logarithmic and np.ptp(coordinates[drawn]) > np.log(
            LOGARITHMIC_RATIO
        ):
            set_logarithmic(axes, "x")
        else:
            set_linear(axes, "x", most=3)
        parameter = estimate.parameter
        unit = names.name(parameter.unit) if parameter.unit != "compliance" else "1"
        label = parameter.name.partition(".")[2] or parameter.name
        axes.set_xlabel(label if unit == "1" else f"{label} ({unit})", fontsize=7)
        # the mark of the best point at 0 is whole
        axes.set_ylim(-0.03 * MAX_RISE, MAX_RISE)
        set_linear(axes, "y")
    for axes in panels[::columns]:
        axes.set_ylabel("rise of chi-square")
    figure.suptitle("profiles of the likelihood; dotted: threshold of the interval", fontsize=9)
    return figure


def _abscissa(each: Measurement, names: UnitNames) -> tuple[Array, str]:
    """Return the times or radii over which a measurement is drawn, and the label with a unit."""
    values, kind = each.times, "time"
    name = "sliding distance t" if names.distances else "time t"
    if each.radii is not None:
        values, name, kind = each.radii, "radius r", "length"
    unit, unit_name = names.readable(float(np.abs(values).max()), kind)
    return values / unit, f"{name} ({unit_name})" if unit_name else name


def _label(each: Measurement, names: UnitNames, several: int) -> str:
    if each.radii is not None:
        return f"t = {names.write(float(each.times[0]), 'time', 3)}"
    return each.label if several > 1 else "data"


def _scale_times(panels: tuple[Axes, ...], each: Measurement) -> None:
    """Set a logarithmic axis for times with a wide range, and else a linear one."""
    positive = each.times[each.times > 0]
    wide = len(positive) and positive.max() > LOGARITHMIC_RATIO * positive.min()
    scaled = set_logarithmic if each.radii is None and wide else set_linear
    for axes in panels:
        scaled(axes, "x")
