"""The figure of a map.

A heat map of two axes, a family of curves of one and a few, points of random draws.
"""

from io import BytesIO
from itertools import islice, product
from typing import Any

import numpy as np
import xarray

from ...meshes.radial import Array
from ..figures.style import curve, new_figure
from .axes import DRAW, Sweep

# quantities (rows), further values (columns), and curves that a page holds; an axis of more values
# wants a map
ROWS, COLUMNS, CURVES = 4, 6, 8
# greatest over least of values that are drawn on a logarithmic axis
DECADES = 20.0


def drawn(dataset: xarray.Dataset, sweep: Sweep) -> bytes:
    """The first quantities kept.

    Of histories the end, of relaxation times the slowest, by the first method that has it.
    """
    shown = [part for name in sweep.keep if (part := _of_scenes(dataset, name)) is not None][:ROWS]
    dims: list[Any] = [dim for dim in sweep.dims if dataset.sizes[dim] > 1]
    dims.sort(key=lambda dim: (not _numeric(dataset, dim), -dataset.sizes[dim]))
    if DRAW in dims:
        # points over the draws: every other axis gives panels
        dims = [DRAW, None, *(dim for dim in dims if dim != DRAW)]
    across, along, *others = (*dims, None, None)[: max(2, len(dims))]
    panels = list(islice(product(*(range(dataset.sizes[dim]) for dim in others if dim)), COLUMNS))
    figure = new_figure(1.2 + 4.3 * len(panels), 0.6 + 3.5 * len(shown))
    grid = figure.subplots(max(len(shown), 1), len(panels), squeeze=False)
    for row, part in zip(grid, shown, strict=False):
        for axes, place in zip(row, panels, strict=True):
            chosen = dict(zip(others, place, strict=True))
            here = part.isel({dim: at for dim, at in chosen.items() if dim})
            here = here.isel({dim: 0 for dim in here.dims if dim not in (across, along)})
            if across == DRAW:
                _points(axes, dataset, here, sweep, figure)
            elif along is not None and dataset.sizes[along] > CURVES and _numeric(dataset, along):
                _map(axes, dataset, here.transpose(along, across), figure)
            else:
                _curves(axes, dataset, here, across, along)
            labels = (
                f"{dim} = {_short(dataset[dim].values[at])}" for dim, at in chosen.items() if dim
            )
            axes.set_title(", ".join(labels), fontsize=9)
    left = int(np.prod([dataset.sizes[dim] for dim in others if dim])) - len(panels)
    title = dataset.attrs["title"] + (f" ({left} further panels are in the store)" if left else "")
    figure.suptitle(_plain(title), fontsize=10)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _of_scenes(dataset: xarray.Dataset, name: str) -> Any:
    """One number of each scene, labelled with what it is.

    None of fields, and where no method gives it.
    """
    part, label = dataset[name], name
    if {"radius", "ring"} & set(part.dims):
        return None
    if "time" in part.dims:
        label += f" at t = {_short(dataset['time'].values[-1])}"
        part = part.isel(time=-1)
    if "mode" in part.dims:
        part, label = part.isel(mode=0), f"{label}, slowest"
    for number, solver in enumerate(dataset["solver"].values):
        if np.isfinite((one := part.isel(solver=number)).values).any():
            return one.rename(f"{label} ({solver})")
    return None


def _numeric(dataset: xarray.Dataset, dim: str) -> bool:
    return dim == DRAW or bool(np.issubdtype(dataset[dim].dtype, np.number))


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float | np.floating) else _plain(str(value))


def _plain(text: str) -> str:
    """The user's text for matplotlib, which would read a formula between two dollars."""
    return text.replace("$", r"\$")


def _logarithmic(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return bool(len(finite)) and bool(finite.min() > 0 and finite.max() > DECADES * finite.min())


def _scaled(axes: Any, which: str, values: Any) -> None:
    if np.issubdtype(values.dtype, np.number) and _logarithmic(values):
        getattr(axes, f"set_{which}scale")("log")


def _map(axes: Any, dataset: xarray.Dataset, part: xarray.DataArray, figure: Any) -> None:
    from matplotlib.colors import LogNorm

    along, across = part.dims
    x, y, values = dataset[across].values, dataset[along].values, part.values
    norm = LogNorm() if _logarithmic(values) else None
    shades = axes.pcolormesh(
        x, y, np.ma.masked_invalid(values), shading="nearest", cmap="viridis", norm=norm
    )
    _scaled(axes, "x", x)
    _scaled(axes, "y", y)
    axes.set(xlabel=across, ylabel=along)
    figure.colorbar(shades, ax=axes, label=part.name)


def _curves(
    axes: Any, dataset: xarray.Dataset, part: xarray.DataArray, across: Any, along: Any
) -> None:
    x = dataset[across].values if across else np.zeros(1)
    numeric = bool(np.issubdtype(x.dtype, np.number))
    count = dataset.sizes[along] if along else 1
    for number in range(min(count, CURVES)):
        values = np.atleast_1d(part.isel({along: number}).values if along else part.values)
        look = curve(number) | {"marker": "none" if len(x) > 40 else curve(number)["marker"]}
        label = _short(dataset[along].values[number]) if along else None
        axes.plot(x if numeric else np.arange(len(x)), values, label=label, **look)
    if numeric:
        _scaled(axes, "x", x)
    else:
        axes.set_xticks(np.arange(len(x)), [_short(value) for value in x])
    _scaled(axes, "y", part.values.ravel())
    axes.set(xlabel=across or "", ylabel=part.name)
    axes.grid(color="0.92")
    if along:
        axes.legend(title=along, fontsize=8, title_fontsize=8, frameon=False)


def _points(
    axes: Any, dataset: xarray.Dataset, part: xarray.DataArray, sweep: Sweep, figure: Any
) -> None:
    names = [
        name
        for name, dim, *_ in sweep.coordinates()
        if dim == DRAW and np.issubdtype(dataset[name].dtype, np.number)
    ]
    x = dataset[names[0]].values if names else np.arange(dataset.sizes[DRAW])
    if len(names) > 1:
        shades = axes.scatter(x, part.values, s=6, c=dataset[names[1]].values, cmap="viridis")
        figure.colorbar(shades, ax=axes, label=names[1])
    else:
        axes.scatter(x, part.values, s=6)
    _scaled(axes, "x", x)
    _scaled(axes, "y", part.values)
    axes.set(xlabel=names[0] if names else DRAW, ylabel=part.name)
