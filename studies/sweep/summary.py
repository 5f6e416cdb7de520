"""A finished map on a page: numbers, and a figure.

The figure is a heat map over two axes, a family of curves of one and a few, or points of draws.
"""

import json
from io import BytesIO
from pathlib import Path
from typing import Any

import xarray
from matplotlib.colors import LogNorm

from ..figures.style import new_figure
from .axes import DRAW, JUDGED, Sweep
from .store import DONE, FAILED, PENDING


def write_summary(dataset: xarray.Dataset, sweep: Sweep, out: Path) -> tuple[list[str], bool, bool]:
    """Write `summary.json` and `sweep.png`.

    Returns
    -------
    What there is to say, a line each; whether all scenes are done; whether methods agree.
    """
    status, reasons = dataset["status"].to_series(), dataset["reason"].to_series()
    done, failed, left = (int((status == flag).sum()) for flag in (DONE, FAILED, PENDING))
    summary: dict[str, Any] = {
        "scenes": sweep.count,
        "finished": done,
        "failed": failed,
        "sweep": sweep.table,
    }
    lines = [f"{done} scenes finished, {failed} failed, {left} left"]
    texts = reasons[reasons != ""].value_counts().head(10)
    summary["reasons"] = texts.to_dict()
    lines += [f"{reason} ({count} scenes)" for reason, count in texts.items()]
    if failed or left:
        lines.append("--resume computes what is left, and with --retry-failed what failed")
    disagreeing = int((dataset["disagreement"] > 1).sum()) if "disagreement" in dataset else 0
    if disagreeing:
        lines.append(f"methods disagree in {disagreeing} scenes")
    for name, definition in JUDGED.items():
        if name in dataset and dataset[name].notnull().any():
            values = dataset[name]
            worst = values[values.argmax(...) if name == "disagreement" else values.argmin(...)]
            where = {str(label): value.item() for label, value in worst.coords.items()}
            summary[name] = {"worst": worst.item(), "scene": where}
            lines.append(f"{definition}; worst {worst.item():.2g}, at {where}")
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
    """Draw the first four quantities over the two longest axes, or the draws, as a PNG picture.

    Of histories the end, of relaxation times the slowest, by the first method that has it; further
    axes at their first value. Titles say so.
    """
    texts = [name for name, label in dataset.coords.items() if label.dtype.kind in "OTU"]
    for name in texts:
        # matplotlib would read a formula between two dollars
        escaped = [str(text).replace("$", r"\$") for text in dataset[name].values]
        dataset = dataset.assign_coords({name: (dataset[name].dims, escaped)})
    dims: list[Any] = sorted(sweep.dims, key=lambda dim: (dim in texts, -dataset.sizes[dim]))
    shown = [DRAW] if DRAW in dims else dims[:2]
    places = {dim: 0 for dim in ("mode", "solver", *dims) if dim not in shown} | {"time": -1}
    parts = [
        dataset[name].drop_attrs().dropna("solver", how="all")
        for name in sweep.keep
        if not {"radius", "ring"} & set(dataset[name].dims)
    ]
    parts = [part.isel(places, missing_dims="ignore") for part in parts if part.size][:4]
    figure = new_figure(6.0, 0.6 + 3.5 * len(parts))
    for number, part in enumerate(parts):
        _draw_panel(figure.add_subplot(len(parts), 1, number + 1), part, *shown)
    figure.suptitle(dataset.attrs["title"].replace("$", r"\$"), fontsize=10)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _draw_panel(axes: Any, part: xarray.DataArray, across: Any, along: Any = None) -> None:
    """Draw points of draws, a map of two long axes, else curves."""
    if across == DRAW:
        drawn = [name for name, label in part.coords.items() if label.ndim and _is_number(label)]
        x, hue = (*drawn, None, None)[:2]
        part.plot.scatter(x=x or DRAW, hue=hue, ax=axes, yscale=_scale(part))
    elif along and part.sizes[along] > 8:
        norm = LogNorm() if _scale(part) == "log" else None
        scales = {"xscale": _scale(part[across]), "yscale": _scale(part[along])}
        part.plot.pcolormesh(x=across, y=along, ax=axes, norm=norm, **scales)
    else:
        scales = {"xscale": _scale(part[across]), "yscale": _scale(part)}
        part.plot.line(x=across, hue=along, marker=".", ax=axes, **scales)


def _is_number(values: xarray.DataArray) -> bool:
    return values.dtype.kind in "fi"


def _scale(values: xarray.DataArray) -> Any:
    """Return the scale of an axis for numbers: logarithmic for more than a decade or so."""
    wide = _is_number(values) and 0 < 20 * values.min() < values.max()
    return "log" if wide else "linear"
