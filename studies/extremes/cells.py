"""A map over two parameters at a time: every method far from the usual parameters.

The scenes are listed in `cells.toml`. A cell of the map is a run of one scene by one method and by
direct integration. The verdict on a cell is the worst verdict on its quantities of the steady
state, which direct integration computes in closed form, and on its anchors
(`studies/crosscheck/anchors/`).
"""

import json
import time
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from importlib.resources import files
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ..crosscheck import Scene
from ..crosscheck.problem.fields import TomlTable
from ..crosscheck.result.outcome import Outcome
from ..crosscheck.result.run import run
from ..figures.style import GREYS, RED, legend_of, new_figure
from ..study.levels import Family
from ..tables import Row
from .verdicts import MEANINGS, Verdict, verdict_on, worst_of

Cell = tuple[str, Any, Any]
"""The method, and the values on both axes."""

LOOKS: dict[str, tuple[Any, ...]] = {
    "within": ("s", "0.8", 20),
    "degraded": ("^", GREYS[4], 24),
    "refused": ("_", GREYS[0], 28),
    "wrong": ("X", RED, 40),
    "crashed": ("*", RED, 60),
}
"""Marker, shade and size of each verdict. Only defects are red."""


def families(poisson_ratio: float, quick: bool) -> Iterator[Family]:
    """Yield the families of cells of `cells.toml`; when quick, with one extreme cell per method.

    Parameters
    ----------
    poisson_ratio : of the half-space
    quick : whether one cell per method is enough, and slow families are left out
    """
    listing = files("ringwear.studies") / "extremes" / "cells.toml"
    table = tomllib.loads(listing.read_text("utf-8"))
    base = Scene.from_table(table["base"]).changed(half_space__poisson_ratio=poisson_ratio)
    for family in table["families"]:
        if quick and family.get("slow"):
            continue
        axes = [read_axis(family[axis], table["axes"]) for axis in "xy"]
        points = list(product(*axes))
        if quick:
            points = [(far_value(axes[0]), far_value(axes[1]))]
        scenes = {}
        for (x, y), method in product(dict.fromkeys(points), family["methods"]):
            changes = {"accuracy.rtol": table["rtol"][method]}
            changes |= family.get("scene", {}) | axes[0][x] | axes[1][y]
            changed = {key.replace(".", "__"): value for key, value in changes.items()}
            scenes[method, x, y] = base.changed(**changed)
        seconds = table["seconds"] | family.get("seconds", {})
        yield Family(
            family["name"],
            dict.fromkeys(scenes, np.nan),
            partial(judge, scenes),
            work=partial(_seconds_of, seconds),
        )


def _seconds_of(seconds: Mapping[str, float], cell: Cell) -> float:
    """Return the expected seconds of a cell by its method."""
    return seconds[cell[0]]


def far_value(axis: Iterable[Any]) -> Any:
    """Return an extreme value of an axis: the one at 70 % of its length."""
    values = list(axis)
    return values[int(0.7 * (len(values) - 1) + 0.5)]


def read_axis(axis: str | TomlTable, shared_axes: TomlTable) -> dict[Any, TomlTable]:
    """Return the changes of scene keys for each value, or each label, of an axis.

    Parameters
    ----------
    axis : name of a shared axis, values of one scene key, or changes by label
    shared_axes : axes by their names
    """
    axis = shared_axes[axis] if isinstance(axis, str) else axis
    key, values = next(iter(axis.items()))
    if "." not in key:
        return axis
    if isinstance(values, dict):
        values = [float(f"{value:.9g}") for value in np.geomspace(*values["geomspace"])]
    return {value: {key: [value] if key == "wear.times" else value} for value in values}


def judge(scenes: dict[Cell, Scene], cell: Cell) -> Row:
    """Return the row of a cell: the worst verdict on a scene by one method."""
    (method, x, y), start = cell, time.perf_counter()
    methods = list(dict.fromkeys([method, "direct"]))
    row = {
        "part": "map",
        "method": method,
        "x": x,
        "y": y,
        "parameters": json.dumps(scenes[cell].table()),
        "promised": scenes[cell].accuracy.rtol,
    }
    row |= worst_of(lambda: judge_quantities(run(scenes[cell], methods)))
    return row | {"seconds": round(time.perf_counter() - start, 4)}


def judge_quantities(result: Outcome) -> Iterator[Verdict]:
    """Yield the verdict on every quantity of the steady state and on every anchor.

    The quantities are compared with `direct`, which has the steady state in closed form.
    """
    rtol = result.scene.accuracy.rtol
    for row in result.agreement:
        yield verdict_on(row.quantity, row.difference, row.uncertainty, rtol)
    for anchor in result.anchors:
        # the tolerance of an anchor allows for more than the error of the method
        allowed = max(rtol, anchor.tolerance)
        yield verdict_on(anchor.name, anchor.difference, anchor.tolerance, allowed)


def draw(cells: pd.DataFrame) -> Figure:
    """Draw one page with a panel for each family and method and a symbol for each cell."""
    panels = cells.groupby(["family", "method"], sort=False)
    height = -(-len(panels) // 5)
    figure = new_figure(16, 3.2 * height)
    for number, ((family, method), panel) in enumerate(panels, 1):
        across, _, up = str(family).partition(" × ")
        axes = figure.add_subplot(height, 5, number, title=method, xlabel=across, ylabel=up)
        (xs, x_values), (ys, y_values) = (pd.factorize(panel[axis]) for axis in "xy")
        for verdict, (marker, shade, size) in LOOKS.items():
            selected = panel.verdict == verdict
            look = {"s": size, "color": shade, "marker": marker}
            label = f"{verdict}: {MEANINGS[verdict]}"
            axes.scatter(xs[selected], ys[selected], **look, label=label)
        for axis, values in ((axes.xaxis, x_values), (axes.yaxis, y_values)):
            step = -(-len(values) // 5)
            labels = [f"{v:.3g}" if isinstance(v, float) else v for v in values[::step]]
            axis.set_ticks(range(0, len(values), step), labels)
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    return figure
