"""The figure of a sweep: each kept number over the two longest axes, by xarray."""

from pathlib import Path

import xarray
from matplotlib.figure import Figure

from ..figures.style import in_style
from .axes import Sweep

PICTURE = "sweep.png"
MOST_QUANTITIES = 4
# ratio of the ends of an axis above which it is logarithmic
LOGARITHMIC = 20.0


def draw(dataset: xarray.Dataset, sweep: Sweep, file: Path) -> None:
    """Draw up to `MOST_QUANTITIES` quantities over the numerical axes of a sweep."""
    names = {column.dim: column.name for column in sweep.columns.values()}
    numerical = {dim: name for dim, name in names.items() if dataset[name].dtype.kind in "fi"}
    dims = sorted(numerical, key=lambda dim: -sweep.sizes[dim])[:2]
    shown = [name for name in sweep.keep if not {"radius", "ring", "state"} & {*dataset[name].dims}]
    with in_style():
        figure = Figure((5.0, 0.6 + 3.4 * max(len(shown[:MOST_QUANTITIES]), 1)))
        for number, name in enumerate(shown[:MOST_QUANTITIES] if dims else (), 1):
            values = dataset[name].dropna("solver", how="all")
            values = values.isel({dim: -(dim == "time") for dim in values.dims if dim not in dims})
            axes = figure.add_subplot(len(shown[:MOST_QUANTITIES]), 1, number)
            scales = {
                f"{which}scale": "log"
                for which, dim in zip("xy", dims, strict=False)
                if 0 < LOGARITHMIC * values[numerical[dim]].min() < values[numerical[dim]].max()
            }
            places = {which: numerical[dim] for which, dim in zip("xy", dims, strict=False)}
            values.sortby([numerical[dim] for dim in dims]).plot(ax=axes, **places, **scales)
        figure.savefig(file)
