"""A finished map on a page: numbers, and a figure.

The figure is a heat map over two axes, a family of curves of one and a few, or points of draws.
"""

import json
from io import BytesIO
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import xarray
from matplotlib.colors import LogNorm

from ..figures.style import new_figure
from .axes import DRAW, Sweep
from .store import DONE, FAILED, PENDING


def write_summary(dataset: xarray.Dataset, sweep: Sweep, out: Path) -> tuple[list[str], bool, bool]:
    """Write `summary.json` and `sweep.png`.

    Returns
    -------
    What there is to say, a line each; whether all scenes are done; whether methods agree.
    """
    status, reasons = dataset["status"].values.ravel(), dataset["reason"].values.ravel()
    done, failed, left = (int(np.sum(status == flag)) for flag in (DONE, FAILED, PENDING))
    summary: dict[str, Any] = {
        "scenes": sweep.count,
        "finished": done,
        "failed": failed,
        "sweep": sweep.table,
    }
    lines = [f"{done} scenes finished, {failed} failed, {left} left"]
    for word, key, flag in (("failed", "reasons", FAILED), ("left", "reasons_pending", PENDING)):
        texts = pandas.Series(reasons[(status == flag) & (reasons != "")], dtype=object)
        summary[key] = texts.value_counts().head(10).to_dict()
        lines += [f"{word}: {reason} ({count} scenes)" for reason, count in summary[key].items()]
    if failed or left:
        lines.append("--resume computes what is left, and with --retry-failed what failed")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    for name, words, find in (
        ("disagreement", "greatest difference over its uncertainty", np.nanargmax),
        ("effectivity", "least error stated, over the one a better method shows", np.nanargmin),
    ):
        if name in dataset and dataset[name].notnull().any():
            place = np.unravel_index(find(dataset[name].values), sweep.shape)
            scene = dataset[name][place]
            where = {str(label): value.item() for label, value in scene.coords.items()}
            summary[name] = {"worst": scene.item(), "scene": where}
            lines.append(f"{words}: {scene.item():.2g}, at {where}")
    write_whole(out / "summary.json", json.dumps(summary, indent=1).encode())
    write_whole(out / "sweep.png", draw(dataset, sweep))
    lines.append(f"sweep.zarr, sweep.png and summary.json in {out}")
    return lines, done == sweep.count, not disagreeing


def write_whole(file: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all."""
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    partial.replace(file)


def draw(dataset: xarray.Dataset, sweep: Sweep) -> bytes:
    """Draw the first four quantities kept as a PNG picture.

    Of histories the end, of relaxation times the slowest, by the first method that has it.
    """
    # matplotlib would read a formula between two dollars
    texts = {
        str(name): (label.dims, [str(text).replace("$", r"\$") for text in label.values])
        for name, label in dataset.coords.items()
        if label.dtype.kind in "OTU"
    }
    dataset = dataset.assign_coords(texts)
    numbers = [_one_number(dataset[name]) for name in sweep.keep]
    shown = [part for part in numbers if part is not None][:4]
    dims: list[Any] = [dim for dim in sweep.dims if dataset.sizes[dim] > 1]
    dims.sort(key=lambda dim: (dim != DRAW, dim in texts, -dataset.sizes[dim]))
    # points over the draws: all other axes give panels
    families = dims[:1] if DRAW in dims else dims[:2]
    others = dims[len(families) :]
    places = product(*(range(dataset.sizes[dim]) for dim in others))
    panels = [dict(zip(others, place, strict=True)) for place in islice(places, 6)]
    figure = new_figure(1.2 + 4.3 * len(panels), 0.6 + 3.5 * len(shown))
    grid = figure.subplots(max(len(shown), 1), len(panels), squeeze=False)
    for row, part in zip(grid, shown, strict=False):
        for axes, panel in zip(row, panels, strict=True):
            here = part.isel(panel)
            here = here.isel({dim: 0 for dim in here.dims if dim not in families})
            _draw_panel(axes, here, families)
            labels = (f"{dim} = {dataset[dim].values[at]:.4}" for dim, at in panel.items())
            axes.set_title(", ".join(labels), fontsize=9)
    left = int(np.prod([dataset.sizes[dim] for dim in others])) - len(panels)
    title = dataset.attrs["title"].replace("$", r"\$")
    further = f" ({left} further panels are in the store)" if left else ""
    figure.suptitle(title + further, fontsize=10)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _one_number(part: xarray.DataArray) -> xarray.DataArray | None:
    """Return one number of each scene; None of fields, and where no method gives any."""
    if {"radius", "ring"} & set(part.dims):
        return None
    label = str(part.name)
    if "time" in part.dims:
        label, part = f"{label} at t = {part['time'].values[-1]:.4g}", part.isel(time=-1)
    if "mode" in part.dims:
        label, part = f"{label}, slowest", part.isel(mode=0)
    for solver in part["solver"].values:
        if np.isfinite((by_solver := part.sel(solver=solver)).values).any():
            return by_solver.rename(f"{label} ({solver})").drop_attrs()
    return None


def _draw_panel(axes: Any, part: xarray.DataArray, dims: list[Any]) -> None:
    """Draw a map of two long axes of numbers, else curves; of draws points."""
    if dims == [DRAW]:
        names = [name for name, label in part.coords.items() if label.dims == (DRAW,)]
        names = [name for name in names if part[name].dtype.kind in "fi"]
        points = part.to_dataset(name="value").assign_coords({DRAW: np.arange(part.size)})
        across, colour = (*names, None, None)[:2]
        points.plot.scatter(x=across or DRAW, y="value", hue=colour, ax=axes, yscale=_scale(part))
        axes.set_ylabel(part.name)
    elif len(dims) == 2 and part.sizes[dims[1]] > 8 and part[dims[1]].dtype.kind in "fi":
        scales = {f"{way}scale": _scale(part[dim]) for way, dim in zip("xy", dims, strict=True)}
        norm = LogNorm() if _scale(part) == "log" else None
        part.plot.pcolormesh(x=dims[0], y=dims[1], ax=axes, cmap="viridis", norm=norm, **scales)
    else:
        across, hue = (*dims, None, None)[:2]
        if across is None:
            part, across = part.expand_dims(scene=[0]), "scene"
        if hue:
            part = part.isel({hue: slice(8)})
        part.plot.line(
            x=across, hue=hue, ax=axes, marker=".", xscale=_scale(part[across]), yscale=_scale(part)
        )


def _scale(part: xarray.DataArray) -> str:
    """Return the scale of an axis for numbers: logarithmic for more than a decade or so."""
    if part.dtype.kind not in "fi":
        return "linear"
    finite = part.values[np.isfinite(part.values)]
    return "log" if finite.size and 0 < 20 * finite.min() < finite.max() else "linear"
