"""A finished map on a page: numbers, and a figure.

The figure is a heat map over two axes, a family of curves of one and a few, or points of draws.
"""

import json
from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
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
        texts = Counter(map(str, reasons[(status == flag) & (reasons != "")]))
        summary[key] = dict(texts.most_common(10))
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
    """Draw the first four quantities over two axes, or over the draws, as a PNG picture.

    Of histories the end, of relaxation times the slowest, by the first method that has it; further
    axes at their first value. Titles say so.
    """
    texts = [name for name, label in dataset.coords.items() if label.dtype.kind in "OTU"]
    for name in texts:
        # matplotlib would read a formula between two dollars
        escaped = [str(text).replace("$", r"\$") for text in dataset[name].values]
        dataset = dataset.assign_coords({name: (dataset[name].dims, escaped)})
    dims: list[Any] = sorted(sweep.dims, key=lambda dim: (dim in texts, -dataset.sizes[dim]))
    shown = [DRAW] if DRAW in dims else [dim for dim in dims if dataset.sizes[dim] > 1][:2]
    first = {dim: 0 for dim in ("mode", "solver", *dims) if dim not in shown}
    parts = [dataset[name].drop_attrs().dropna("solver", how="all") for name in sweep.keep]
    parts = [
        part.isel(first | {"time": -1}, missing_dims="ignore")
        for part in parts
        if part.sizes["solver"] and not {"radius", "ring"} & set(part.dims)
    ][:4]
    figure = new_figure(6.0, 0.6 + 3.5 * len(parts))
    for axes, part in zip(
        figure.subplots(max(1, len(parts)), squeeze=False).flat, parts, strict=False
    ):
        _draw_panel(axes, part, *shown)
    figure.suptitle(dataset.attrs["title"].replace("$", r"\$"), fontsize=10)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _draw_panel(axes: Any, part: xarray.DataArray, across: Any = None, along: Any = None) -> None:
    """Draw points of draws, a map of two long axes of numbers, else curves."""
    numeric = [name for name, label in part.coords.items() if label.dtype.kind in "fi"]
    if across == DRAW:
        x, colour = (*(name for name in numeric if part[name].ndim), None, None)[:2]
        points = part.to_dataset(name="value").assign_coords({DRAW: np.arange(part.size)})
        points.plot.scatter(x=x or DRAW, y="value", hue=colour, ax=axes, yscale=_scale(part))
        axes.set_ylabel(part.name)
    elif along in numeric and part.sizes[along] > 8:
        norm = LogNorm() if _scale(part) == "log" else None
        part.plot.pcolormesh(
            x=across,
            y=along,
            ax=axes,
            norm=norm,
            xscale=_scale(part[across]),
            yscale=_scale(part[along]),
        )
    elif across is None:
        axes.plot(part.values, "o")
    else:
        curves = part.isel({along: slice(8)}) if along else part
        curves.plot.line(
            x=across, hue=along, ax=axes, xscale=_scale(part[across]), yscale=_scale(part)
        )


def _scale(values: xarray.DataArray) -> Any:
    """Return the scale of an axis for numbers: logarithmic for more than a decade or so."""
    if values.dtype.kind not in "fi":
        return "linear"
    return "log" if 0 < 20 * values.min() < values.max() else "linear"
