"""The map of limits: a panel for each family and method with a symbol for each cell, and a table of what is within."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ringwear.studies.figures.style import GREYS, RED, legend_of, new_figure
from ringwear.studies.tables import Table

Row = Mapping[str, Any]
Panels = dict[tuple[str, str], list[Row]]  # rows by family and method
# marker, shade and size of each verdict, from the best to the worst; only defects are red
LOOKS = {"within": ("s", "0.8", 20), "degraded": ("^", GREYS[4], 24), "refused": ("_", GREYS[0], 28),
         "wrong": ("X", RED, 40), "crashed": ("*", RED, 60)}  # fmt: skip
COLUMNS = 5


def panels(rows: Sequence[Row]) -> Panels:
    """Rows by family and method."""
    grouped: Panels = {}
    for row in rows:
        grouped.setdefault((row["family"], row["method"]), []).append(row)
    return grouped


def draw(rows: Sequence[Row], path: Path) -> None:
    """One page: a panel for each family and method, a symbol for each cell."""
    grouped = panels(rows)
    height = -(-len(grouped) // COLUMNS)
    figure = new_figure(16, 3.2 * height)
    for number, ((family, method), own) in enumerate(grouped.items(), 1):
        across, _, up = family.partition(" × ")
        axes = figure.add_subplot(height, COLUMNS, number, title=method, xlabel=across, ylabel=up)
        xs, ys = (list(dict.fromkeys(row[axis] for row in own)) for axis in "xy")
        for verdict, (marker, shade, size) in LOOKS.items():
            cells = [row for row in own if row["verdict"] == verdict]
            at = [xs.index(row["x"]) for row in cells], [ys.index(row["y"]) for row in cells]
            axes.scatter(*at, s=size, color=shade, marker=marker, label=verdict)
        for axis, values, most in ((axes.xaxis, xs, 3), (axes.yaxis, ys, 9)):
            places = np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int)
            axis.set_ticks(places, [_shown(values[place]) for place in places])
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    figure.savefig(path)


def limits(rows: Sequence[Row], path: Path) -> Table:
    """For each family and method: how many of each verdict, and at which values every cell is within."""
    table = Table(path, ("family", "method", *LOOKS, "x all within", "y all within", "greatest error"))
    for (family, method), own in panels(rows).items():
        counts = Counter(row["verdict"] for row in own)
        greatest = max((row["error"] for row in own if np.isfinite(row.get("error", np.nan))), default=np.nan)
        numbers = {verdict: counts[verdict] for verdict in LOOKS} | {"greatest error": f"{greatest:.1e}"}
        table.add(family=family, method=method, **numbers, **{f"{axis} all within": _all_within(own, axis) for axis in "xy"})
    return table


def _all_within(rows: Sequence[Row], axis: str) -> str:
    others = {row[axis] for row in rows if row["verdict"] != "within"}
    values = dict.fromkeys(row[axis] for row in rows if row[axis] not in others)
    return (" ".join(map(_shown, values)) or "none") if others else "all"


def _shown(value: float | str) -> str:
    return re.sub(r"e\+?(-?)0?", r"e\1", f"{value:.3g}") if isinstance(value, float) else str(value)
