"""A map of the limits: every method at parameters far from the usual ones, against closed forms.

The scenes are listed in `extremes.toml`. A cell of the map is a run of one scene by one method,
beside direct integration. Its verdict is the worst of the quantities of the steady state, which
direct integration has in closed form, and of anchors (`studies/anchors/`):

    within      the error is within the method's own estimate, and every anchor holds
    degraded    the estimate states an error above ten times the accuracy asked for, or falls short
                of the error by less than three times, or the error is at least within that accuracy
    refused     a RingwearError says why not
    wrong       the error is beyond both, and nothing says so: a defect
    crashed     any other exception or a RuntimeWarning: a defect
"""

import json
import sys
import time
import tomllib
import warnings
from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...meshes.errors import RingwearError
from ..crosscheck.dataset import Result
from ..crosscheck.run import run
from ..figures.style import GREYS, RED, legend_of, new_figure
from ..problem.scene import Scene
from ..study.levels import Family, Record
from ..study.options import Options
from ..study.study import Study
from ..tables import Row

VERDICTS: dict[str, tuple[Any, ...]] = {
    "within": ("s", "0.8", 20, "its error is within its own estimate"),
    "degraded": ("^", GREYS[4], 24, "less accurate than asked for, and says so"),
    "refused": ("_", GREYS[0], 28, "says why it cannot"),
    "wrong": ("X", RED, 40, "less accurate than it says"),
    "crashed": ("*", RED, 60, "by any other exception"),
}
"""From the best to the worst: marker, shade, size, meaning. Only defects are red."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Judge every cell.

    Of the scene, Poisson's ratio is taken.
    """
    columns = ["family", "method", "x", "y", "verdict", "quantity", "error", "estimate"]
    columns += ["seconds", "message", "parameters"]
    judged = families(scene.half_space.poisson_ratio, options.quick)
    cells = record.solve("extremes", judged, columns)
    counted = ", ".join(f"{(cells.verdict == verdict).sum()} {verdict}" for verdict in VERDICTS)
    conclusions = (*record.conclusions, f"{len(cells)} cells: {counted}")
    figures = {"extremes": draw(cells)} if len(cells) else {}
    return Study("extremes", scene, cells, conclusions=conclusions, figures=figures)


def families(poisson_ratio: float, quick: bool) -> Iterator[Family]:
    """Yield the cells of each family; when quick, every fourth value of each axis, and the last."""
    listing = files("ringwear.studies") / "numerics" / "extremes.toml"
    table = tomllib.loads(listing.read_text("utf-8"))
    base = Scene.from_table(table["base"]).changed(half_space__poisson_ratio=poisson_ratio)
    for family in table["families"]:
        if quick and family.get("slow"):
            continue
        axes = [read_axis(family[axis], table["axes"]) for axis in "xy"]
        if quick:
            axes = [{x: axis[x] for x in (*list(axis)[::4], list(axis)[-1])} for axis in axes]
        scenes = {}
        for x, method, y in product(axes[0], family["methods"], axes[1]):
            changes = {"accuracy.rtol": table["rtol"][method]}
            changes |= family.get("scene", {}) | axes[0][x] | axes[1][y]
            changed = {key.replace(".", "__"): value for key, value in changes.items()}
            scenes[method, x, y] = base.changed(**changed)
        yield Family(family["name"], dict.fromkeys(scenes, np.nan), partial(judge, scenes))


def read_axis(axis: str | dict[str, Any], named: dict[str, Any]) -> dict[Any, dict[str, Any]]:
    """Return what each value of an axis changes: values of one scene key, or labels."""
    axis = named[axis] if isinstance(axis, str) else axis
    key, values = next(iter(axis.items()))
    if "." not in key:
        return axis
    if isinstance(values, dict):
        values = [float(f"{value:.9g}") for value in np.geomspace(*values["geomspace"])]
    return {value: {key: [value] if key == "wear.times" else value} for value in values}


def judge(scenes: dict[tuple[str, Any, Any], Scene], cell: tuple[str, Any, Any]) -> Row:
    """Return a row of the table: a scene by one method, by the worst of its quantities."""
    (method, x, y), start = cell, time.perf_counter()
    worst: dict[str, Any]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            methods = dict.fromkeys([method, "direct"])
            worst = max(judge_quantities(run(scenes[cell], list(methods))), key=rank)
    except RingwearError as error:
        worst = {"verdict": "refused", "message": str(error)}
    except Exception as error:  # whatever else comes out is what the study looks for
        worst = {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}
    seconds, parameters = round(time.perf_counter() - start, 4), json.dumps(scenes[cell].table())
    about = {"method": method, "x": x, "y": y, "seconds": seconds, "parameters": parameters}
    return about | worst


def rank(judged: dict[str, Any]) -> tuple[int, float]:
    """Return how bad a quantity is: by its verdict, then by its error over the estimate."""
    # what is exact, such as a key that is passed on, has an estimate of zero
    estimate = max(judged["estimate"], sys.float_info.min)
    return list(VERDICTS).index(judged["verdict"]), judged["error"] / estimate


def judge_quantities(result: Result) -> Iterator[dict[str, Any]]:
    """Yield the verdict on every quantity of the steady state and on every anchor.

    The quantities are compared with `direct`, which has the steady state in closed form.
    """
    rtol = result.scene.accuracy.rtol
    for row in result.agreement:
        yield verdict_on(row.quantity, row.difference, row.uncertainty, rtol)
    for anchor in result.anchors:
        # what is tolerated is not the method's error alone
        tolerated = max(rtol, anchor.tolerance)
        yield verdict_on(anchor.name, anchor.difference, anchor.tolerance, tolerated)


def verdict_on(quantity: str, error: float, estimate: float, rtol: float) -> dict[str, Any]:
    """Return the verdict on a number, in the words of `VERDICTS`."""
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, 3 * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def draw(cells: pd.DataFrame) -> Figure:
    """Draw one page: a panel for each family and method, a symbol for each cell."""
    panels = cells.groupby(["family", "method"], sort=False)
    height = -(-len(panels) // 5)
    figure = new_figure(16, 3.2 * height)
    for number, ((family, method), panel) in enumerate(panels, 1):
        across, _, up = str(family).partition(" × ")
        axes = figure.add_subplot(height, 5, number, title=method, xlabel=across, ylabel=up)
        (xs, x_values), (ys, y_values) = (pd.factorize(panel[axis]) for axis in "xy")
        for verdict, (marker, shade, size, meaning) in VERDICTS.items():
            these = panel.verdict == verdict
            look = {"s": size, "color": shade, "marker": marker}
            axes.scatter(xs[these], ys[these], **look, label=f"{verdict}: {meaning}")
        for axis, values in ((axes.xaxis, x_values), (axes.yaxis, y_values)):
            step = -(-len(values) // 5)
            labels = [f"{v:.3g}" if isinstance(v, float) else v for v in values[::step]]
            axis.set_ticks(range(0, len(values), step), labels)
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    return figure
