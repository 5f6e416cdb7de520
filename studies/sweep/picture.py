"""Draw the results of a sweep: each quantity over every key that varies."""

import textwrap
from pathlib import Path
from typing import Literal

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..crosscheck import NO_UNIT
from ..figures.style import in_style, new_figure, set_logarithmic
from .axes import Sweep

# file of the figure
PICTURE = "sweep.png"
# greatest numbers of quantities and of keys that are drawn
MOST_QUANTITIES, MOST_KEYS = 4, 5
# least number of values of the second key of a map; fewer values are curves
LEAST_OF_MAP = 9
# ratio of the ends of an axis from which it is logarithmic
LOGARITHMIC = 20.0


def draw(dataset: xarray.Dataset, sweep: Sweep, file: Path) -> None:
    """Draw up to four of the kept quantities, each over the keys that vary.

    The first panel of a quantity has the two keys with most values, and each other panel one more
    key. The figure shows the first method that has the quantity, at the last time; keys that a
    panel does not show are held at their first values.
    """
    numerical = (
        column for column in sweep.columns.values() if dataset[column.name].dtype.kind in "fi"
    )
    # of the keys that vary together, the first is drawn
    keys = {column.dim: column.name for column in reversed([*numerical])}
    dims = sorted(keys, key=lambda dim: -sweep.sizes[dim])
    shown = [dims[:2], *([dim] for dim in dims[2:MOST_KEYS] if sweep.sizes[dim] > 1)]
    quantities = [
        name
        for name in sweep.keep
        if not {"radius", "ring", "state"} & {*dataset[name].dims}
        and dims
        and dataset[name].notnull().any()
    ][:MOST_QUANTITIES]
    with in_style():
        figure = new_figure(5.0 * len(shown), 0.6 + 3.4 * max(len(quantities), 1))
        for row, name in enumerate(quantities):
            values = dataset[name].dropna("solver", how="all")
            for column, axes_dims in enumerate(shown):
                place = row * len(shown) + column + 1
                axes = figure.add_subplot(len(quantities), len(shown), place)
                _draw_panel(figure, axes, values, {dim: keys[dim] for dim in axes_dims})
        if not quantities:
            figure.text(0.1, 0.5, "no kept quantity is a number over a numerical key")
        figure.savefig(file)


def _draw_panel(figure: Figure, axes: Axes, values: xarray.DataArray, keys: dict[str, str]) -> None:
    """Draw a quantity over one or two keys, which are given by their dimensions."""
    values = values.isel({dim: -(dim == "time") for dim in values.dims if dim not in keys})
    dims, coordinates = [*keys], [values[name] for name in keys.values()]
    values, x = values.transpose(*dims), coordinates[0]
    if len(dims) > 1 and len(coordinates[1]) >= LEAST_OF_MAP and _in_order(*coordinates):
        mesh = axes.pcolormesh(x, coordinates[1], values.T, shading="nearest")
        figure.colorbar(mesh, ax=axes, label=_label(values))
        axes.set_ylabel(_label(coordinates[1]))
        _set_scale(axes, "y", coordinates[1])
    else:
        curves = values.values.reshape(len(x), -1).T
        labels = [f"{float(value):.4g}" for value in coordinates[1]] if len(dims) > 1 else [""]
        for curve, label in zip(curves, labels, strict=True):
            axes.plot(x, curve, ".-" if _in_order(x) else ".", label=label)
        if len(dims) > 1:
            axes.legend(title=_label(coordinates[1]))
        axes.set_ylabel(_label(values))
    axes.set_xlabel(_label(x))
    _set_scale(axes, "x", x)
    names = [str(name) for name in values.coords if values[str(name)].ndim == 0]
    order = sorted(set(names) - {"methods"}, key=lambda name: name != "solver")
    held = ", ".join(_held(values[name]) for name in order)
    axes.set_title("\n".join(textwrap.wrap(held, 60)), fontsize="small")


def _label(values: xarray.DataArray) -> str:
    """Return the name of a quantity or a key, with its unit."""
    name = str(values.name).replace("_", " ").replace("rms", "RMS")
    unit = values.attrs.get("units", NO_UNIT)
    return name if unit == NO_UNIT else f"{name} ({unit})"


def _held(value: xarray.DataArray) -> str:
    """Return a coordinate that a panel holds, with its value and unit."""
    unit, item = value.attrs.get("units", NO_UNIT), value.item()
    if value.name == "solver":
        return f"by {item}"
    text = f"{item:.4g}" if isinstance(item, int | float) else str(item)[:40]
    name = str(value.name).replace("_", " ")
    return f"{name} = {text}" + ("" if unit == NO_UNIT else f" {unit}")


def _set_scale(axes: Axes, which: Literal["x", "y"], coordinate: xarray.DataArray) -> None:
    """Make an axis logarithmic if its values are positive and span decades."""
    if 0 < LOGARITHMIC * coordinate.min() < coordinate.max():
        set_logarithmic(axes, which)


def _in_order(*coordinates: xarray.DataArray) -> bool:
    """Return whether coordinates rise or fall, as a map of cells needs; random draws do not."""
    steps = [np.diff(coordinate) for coordinate in coordinates]
    return all(bool((step > 0).all() or (step < 0).all()) for step in steps)
