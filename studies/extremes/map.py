"""The map of limits.

A panel for each family and method with a symbol for each cell, and a table of how many are within.
"""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..figures.style import GREYS, RED, legend_of, new_figure
from ..tables import Row, Table

# marker, shade and size of each verdict, from the best to the worst; only defects are red
LOOKS = {
    "within": ("s", "0.8", 20),
    "degraded": ("^", GREYS[4], 24),
    "refused": ("_", GREYS[0], 28),
    "wrong": ("X", RED, 40),
    "crashed": ("*", RED, 60),
}
# what each verdict means, for the legend
MEANINGS = {
    "within": "within: its error is within its own estimate",
    "degraded": "degraded: less accurate than asked for, and says so",
    "refused": "refused: says why it cannot",
    "wrong": "wrong: less accurate than it says",
    "crashed": "crashed",
}
COLUMNS = 5


def panels(rows: Sequence[Row]) -> dict[tuple[str, str], list[Row]]:
    """Rows by family and method."""
    grouped: dict[tuple[str, str], list[Row]] = {}
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
            axes.scatter(*at, s=size, color=shade, marker=marker, label=MEANINGS[verdict])
        for axis, values, most in ((axes.xaxis, xs, 3), (axes.yaxis, ys, 9)):
            places = np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int)
            shown = (values[place] for place in places)
            axis.set_ticks(
                places, [f"{value:.3g}" if isinstance(value, float) else value for value in shown]
            )
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    figure.savefig(path)


def limits(rows: Sequence[Row], path: Path) -> Table:
    """For each family and method.

    How many of each verdict, and the greatest error; at which values is for the map.
    """
    table = Table(path, ("family", "method", *LOOKS, "greatest error"))
    for place, own in panels(rows).items():
        counts = Counter(row["verdict"] for row in own)
        greatest = max(
            (row["error"] for row in own if np.isfinite(row.get("error", np.nan))), default=np.nan
        )
        table.add(*place, *(counts[verdict] for verdict in LOOKS), f"{greatest:.1e}")
    return table
