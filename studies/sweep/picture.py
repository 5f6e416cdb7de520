"""The figure of a sweep: kept numbers over the two longest axes, by xarray."""

from itertools import product
from pathlib import Path
from typing import Any

import xarray
from matplotlib.figure import Figure

from ..crosscheck import DESCRIBED, NO_UNIT, Scene, kind_of
from ..figures.style import in_style
from .axes import Sweep

PICTURE = "sweep.png"
MOST_QUANTITIES = 4
# ratio of the ends of an axis above which it is logarithmic
LOGARITHMIC = 20.0


def draw(dataset: xarray.Dataset, sweep: Sweep, file: Path) -> None:
    """Draw up to `MOST_QUANTITIES` quantities over the two numerical axes with most values.

    If only one axis is drawn, each of the keys that vary together along it, such as random ones,
    has a column of panels. The figure shows the first method that has the quantity, at the last
    time; other axes are held at their first values.
    """
    kinds = {
        column.name: kind_of(key, Scene)
        for key, column in sweep.columns.items()
        if dataset[column.name].dtype.kind in "fi" and sweep.sizes[column.dim] > 1
    }
    dims = dict.fromkeys(column.dim for column in sweep.columns.values() if column.name in kinds)
    longest = sorted(dims, key=lambda dim: -sweep.sizes[dim])[:2]
    along = [[name for name in kinds if dataset[name].dims == (dim,)] for dim in longest]
    panels = [dict(zip("xy", names, strict=False)) for names in zip(*along, strict=False)]
    style = {"marker": ".", "linestyle": "" if "draw" in longest else "-"}
    if len(longest) == 2:
        panels, style = panels[:1], {}
    shown = [
        name
        for name in sweep.keep
        if not {"radius", "ring", "state"} & {*dataset[name].dims} and dataset[name].notnull().any()
    ][:MOST_QUANTITIES]
    kinds["time"] = "time"
    with in_style():
        rows, columns = max(len(shown), 1), max(len(panels), 1)
        figure = Figure((5.0 * columns, 0.6 + 3.4 * rows), layout="constrained")
        for number, (name, places) in enumerate(product(shown, panels), 1):
            values = dataset[name].dropna("solver", how="all")
            values = values.isel(
                {dim: -(dim == "time") for dim in values.dims if dim not in longest}
            )
            values = values.sortby([*places.values()])
            coordinates = {
                key: readable(array, kinds[key], sweep) if key in kinds else array.drop_attrs()
                for key, array in values.coords.items()
            }
            values = readable(values, DESCRIBED[name].unit, sweep).assign_coords(coordinates)
            options: dict[str, Any] = places | style
            for which, key in places.items():
                if 0 < LOGARITHMIC * values[key].min() < values[key].max():
                    options[f"{which}scale"] = "log"
            values.plot(ax=figure.add_subplot(rows, columns, number), **options)
        if not (shown and panels):
            figure.text(0.1, 0.5, "no kept quantity is a number over a numerical key")
        figure.savefig(file)


def readable(values: xarray.DataArray, kind: str, sweep: Sweep) -> xarray.DataArray:
    """Return values of a kind in a unit that suits them, such as µm for lengths in m."""
    drawn, attributes = values.copy(), {**values.attrs}
    if attributes.pop("units", NO_UNIT) != NO_UNIT:
        size, attributes["units"] = sweep.first.unit_names.readable_together(
            values.values.ravel(), kind
        )
        drawn = values / size
    drawn.attrs = attributes
    return drawn
