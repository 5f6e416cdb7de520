"""The map of limits on one page: a panel for each family and method, a symbol for each cell; legible in grey."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.studies.convergence.levels import new_figure

# grey and symbol of each verdict, and a colour for those who see one
LOOKS: dict[str, tuple[str, str, float]] = {
    "within": ("#c7e3c7", "s", 14),
    "degraded": ("#b06f10", "^", 15),
    "refused": ("#5a7fb5", "_", 17),
    "wrong": ("#9c1c10", "X", 22),
    "crashed": ("black", "*", 30),
}


def groups(rows: list[dict[str, Any]]) -> Iterable[tuple[str, str, list[dict[str, Any]]]]:
    for family, method in dict.fromkeys((row["family"], row["method"]) for row in rows):
        yield family, method, [row for row in rows if (row["family"], row["method"]) == (family, method)]


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """One page: a panel for each family and method, a symbol for each cell."""
    panels_of = list(groups(rows))
    columns = 5
    figure = new_figure(11.5, 2.3 * -(-len(panels_of) // columns) + 0.6)
    panels = figure.subplots(-(-len(panels_of) // columns), columns, squeeze=False).ravel()
    for axes, (family, method, own) in zip(panels, panels_of, strict=False):
        across, up = (list(dict.fromkeys(sorted({r[a] for r in own}, key=_sortable))) for a in ("x", "y"))
        for name, (colour, symbol, size) in LOOKS.items():
            cells = [(across.index(r["x"]), up.index(r["y"])) for r in own if r["verdict"] == name]
            if cells:
                scale = min(1.0, 14 / max(len(across), len(up)))
                axes.scatter(*zip(*cells, strict=True), s=size * scale + 2, c=colour, marker=symbol, linewidths=1.0)
        for axis, values, most in ((axes.xaxis, across, 3 if len(across) < 10 else 4), (axes.yaxis, up, 6)):
            count = len(values) if isinstance(values[0], str) else min(len(values), most)
            places = np.unique(np.linspace(0, len(values) - 1, count).round().astype(int))
            axis.set_ticks(places, [_tick(values[i]) for i in places], fontsize=7)
        across_name, _, up_name = family.partition(" × ")
        axes.set_xlabel(across_name, fontsize=8, labelpad=3)
        axes.set_ylabel(up_name, fontsize=8, labelpad=3)
        axes.set_xlim(-0.7, len(across) - 0.3)
        axes.set_ylim(-0.7, len(up) - 0.3)
        axes.set_title(method, fontsize=8, pad=3)
    for axes in panels[len(panels_of) :]:
        axes.set_visible(False)
    for name, (colour, symbol, size) in LOOKS.items():
        count = sum(row["verdict"] == name for row in rows)
        panels[0].scatter([], [], s=size + 8, c=colour, marker=symbol, label=f"{name} ({count})", linewidths=1.0)
    figure.legend(loc="outside upper center", ncols=len(LOOKS), frameon=False, fontsize=9)
    figure.savefig(path)


def _tick(value: float | str) -> str:
    """Two digits, or whole numbers; a power of ten where there would be many."""
    if isinstance(value, str):
        return value
    if value == 0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def _sortable(value: float | str) -> tuple[int, float, str]:
    return (1, 0.0, value) if isinstance(value, str) else (0, float(value), "")
