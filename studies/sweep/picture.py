"""The figure of a sweep: kept numbers over the two longest axes, by xarray."""

from pathlib import Path
from typing import Any

import xarray
from matplotlib.figure import Figure

from ..crosscheck import NO_UNIT
from ..figures.style import in_style
from .axes import Sweep

PICTURE = "sweep.png"
MOST_QUANTITIES = 4
# ratio of the ends of an axis above which it is logarithmic
LOGARITHMIC = 20.0


def draw(dataset: xarray.Dataset, sweep: Sweep, file: Path) -> None:
    """Draw up to `MOST_QUANTITIES` quantities over the two numerical axes with most values.

    The figure shows the first method that has the quantity, at the last time; other axes are held
    at their first values.
    """
    numerical = [
        column
        for column in sweep.columns.values()
        if dataset[column.name].dtype.kind in "fi" and sweep.sizes[column.dim] > 1
    ]
    # of the keys that vary together, the first is drawn
    keys = {column.dim: column.name for column in reversed(numerical)}
    dims = sorted(keys, key=lambda dim: -sweep.sizes[dim])[:2]
    places = dict(zip("xy", (keys[dim] for dim in dims), strict=False))
    style = {"marker": ".", "linestyle": "" if "draw" in dims else "-"} if len(dims) == 1 else {}
    shown = [
        name
        for name in sweep.keep
        if not {"radius", "ring", "state"} & {*dataset[name].dims}
        and dims
        and dataset[name].notnull().any()
    ][:MOST_QUANTITIES]
    with in_style():
        figure = Figure((5.0, 0.6 + 3.4 * max(len(shown), 1)))
        for number, name in enumerate(shown, 1):
            values = dataset[name].dropna("solver", how="all")
            values = values.isel({dim: -(dim == "time") for dim in values.dims if dim not in dims})
            values = values.sortby([*places.values()]).copy()
            for labelled in (values, *values.coords.values()):
                if labelled.attrs.get("units") == NO_UNIT:
                    del labelled.attrs["units"]
            options: dict[str, Any] = places | style
            for which, key in places.items():
                if 0 < LOGARITHMIC * values[key].min() < values[key].max():
                    options[f"{which}scale"] = "log"
            values.plot(ax=figure.add_subplot(len(shown), 1, number), **options)
        if not shown:
            figure.text(0.1, 0.5, "no kept quantity is a number over a numerical key")
        figure.savefig(file)
