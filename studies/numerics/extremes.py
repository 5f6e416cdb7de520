"""A map of the limits: every method at parameters far from the usual ones, against closed forms.

The scenes are listed in `extremes.toml`. A cell of the map is a run of one scene by one method. Its
verdict is the worst of its quantities and anchors (`studies/crosscheck/anchors.py`):

    within      the error is within the method's own estimate, and every anchor holds
    degraded    the estimate states an error above ten times the accuracy asked for, or falls short
                of the error by less than three times, or the error is at least within that accuracy
    refused     a RingwearError says why not
    wrong       the error is beyond both, and nothing says so: a defect
    crashed     any other exception or a RuntimeWarning: a defect
"""

import argparse
import json
import time
import tomllib
import warnings
from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...mdr import direct
from ...meshes.errors import RingwearError
from ...meshes.radial import ring_areas, ring_of
from ..crosscheck.dataset import Result
from ..crosscheck.run import run
from ..figures.style import GREYS, RED, legend_of, new_figure
from ..problem.problem import D0
from ..problem.quantities import QUANTITIES
from ..problem.scene import Scene
from ..tables import Row, Table
from .sequences import Family, Level, solve_all

VERDICTS: dict[str, tuple[Any, ...]] = {
    "within": ("s", "0.8", 20, "its error is within its own estimate"),
    "degraded": ("^", GREYS[4], 24, "less accurate than asked for, and says so"),
    "refused": ("_", GREYS[0], 28, "says why it cannot"),
    "wrong": ("X", RED, 40, "less accurate than it says"),
    "crashed": ("*", RED, 60, "by any other exception"),
}
"""From the best to the worst: marker, shade, size, meaning. Only defects are red."""


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Judge every cell; writes `extremes` and `extremes_limits`.

    Of the scene, Poisson's ratio is taken.
    """
    fields = ["family", "method", "x", "y", "verdict", "quantity", "error", "estimate", "rtol"]
    table = Table(out / "extremes.csv", [*fields, "seconds", "message", "parameters"])
    conclusions: list[str] = []
    solve_all(families(scene.half_space.poisson_ratio, options.quick), table, conclusions)
    if table.rows:
        draw(table.rows, out / "extremes.png")
        tabulate_limits(table.rows).to_csv(out / "extremes_limits.csv", index=False)
    verdicts = [row["verdict"] for row in table.rows]
    counted = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in VERDICTS)
    conclusions.append(f"{len(verdicts)} cells: {counted}")
    return conclusions


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
        levels = []
        for x, method, y in product(axes[0], family["methods"], axes[1]):
            changes = {"methods": [method], "accuracy.rtol": table["rtol"][method]}
            changes |= family.get("scene", {}) | axes[0][x] | axes[1][y]
            scene = base.changed(**{key.replace(".", "__"): changes[key] for key in changes})
            levels.append(Level((method, x, y), partial(judge, scene, method, x, y)))
        yield Family(family["name"], levels)


def read_axis(axis: str | dict[str, Any], named: dict[str, Any]) -> dict[Any, dict[str, Any]]:
    """Return what each value of an axis changes: values of one scene key, or labels."""
    axis = named[axis] if isinstance(axis, str) else axis
    key, values = next(iter(axis.items()))
    if "." not in key:
        return axis
    if isinstance(values, dict):
        values = [float(f"{value:.9g}") for value in np.geomspace(*values["geomspace"])]
    return {value: {key: [value] if key == "wear.times" else value} for value in values}


def judge(scene: Scene, method: str, x: Any, y: Any) -> Row:
    """Return a row of the table: a scene by one method, by the worst of its quantities."""
    start = time.perf_counter()
    worst: dict[str, Any]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            worst = max(judge_quantities(run(scene)), key=rank)
    except RingwearError as error:
        worst = {"verdict": "refused", "message": str(error)}
    except Exception as error:  # whatever else comes out is what the study looks for
        worst = {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}
    about = {"rtol": scene.accuracy.rtol, "parameters": json.dumps(scene.table())}
    seconds = round(time.perf_counter() - start, 4)
    return {"method": method, "x": x, "y": y} | worst | about | {"seconds": seconds}


def rank(judged: dict[str, Any]) -> tuple[int, float]:
    """Return how bad a quantity is: by its verdict, then by its error over the estimate."""
    return list(VERDICTS).index(judged["verdict"]), judged["error"] / judged["estimate"]


def judge_quantities(result: Result) -> Iterator[dict[str, Any]]:
    """Yield the verdict on every number that has a closed form, and on every anchor."""
    problem, ((_, solution),) = result.scene.problem, result.solutions.items()
    edges, times = problem.merged.ring_edges, problem.times
    pressures = direct.steady_pressures(*problem.merged)
    wear_rate = pressures[0] * problem.merged.wear_coefficients[0]
    expected: dict[str, Any] = {
        "steady_wear_rate": wear_rate,
        "steady_displacement_max": direct.greatest_displacement(edges, pressures),
        "steady_rms_slope": direct.rms_slope(edges, pressures, problem.gradient_average),
    }
    if solution.wear and len(times):
        # after fifty of the slowest relaxation times, 0.4 / k_min, only the steady state is left
        late = times > 50 * 0.4 / problem.wear_coefficients.min()
        radii, weights, _ = direct.slopes_everywhere(edges, pressures)
        ring, areas = ring_of(edges, radii), radii * weights
        moved = np.bincount(ring, areas * direct.displacement(edges, pressures, radii))
        work = (pressures * ring_areas(edges)) @ (moved / np.bincount(ring, areas))
        between = np.where(times > 0, np.nan, D0)
        expected["indentation"] = np.where(late, wear_rate * times + work, between)
    for name, exact in expected.items():
        unit = getattr(problem.units, QUANTITIES[name].unit)
        errors = np.abs(result.dataset[name].values[0] / unit / exact - 1)
        for error, estimate in np.nditer([errors, solution.errors[name]]):
            if np.isfinite(exact).all():
                yield verdict_on(name, float(error), float(estimate), problem.rtol)
    for anchor in result.anchors:
        # what is tolerated is not the method's error alone
        rtol = max(problem.rtol, anchor.tolerance)
        yield verdict_on(anchor.name, anchor.difference, anchor.tolerance, rtol)


def verdict_on(quantity: str, error: float, estimate: float, rtol: float) -> dict[str, Any]:
    """Return the verdict on a number, in the words of `VERDICTS`."""
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, 3 * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def draw(rows: list[Row], path: Path) -> None:
    """Draw one page: a panel for each family and method, a symbol for each cell."""
    panels = pd.DataFrame(rows).groupby(["family", "method"], sort=False)
    height = -(-len(panels) // 5)
    figure = new_figure(16, 3.2 * height)
    for number, ((family, method), cells) in enumerate(panels, 1):
        across, _, up = str(family).partition(" × ")
        axes = figure.add_subplot(height, 5, number, title=method, xlabel=across, ylabel=up)
        (xs, x_values), (ys, y_values) = (pd.factorize(cells[axis]) for axis in "xy")
        for verdict, (marker, shade, size, meaning) in VERDICTS.items():
            these = cells.verdict == verdict
            look = {"s": size, "color": shade, "marker": marker}
            axes.scatter(xs[these], ys[these], **look, label=f"{verdict}: {meaning}")
        for axis, values in ((axes.xaxis, x_values), (axes.yaxis, y_values)):
            step = -(-len(values) // 5)
            labels = [f"{v:.3g}" if isinstance(v, float) else v for v in values[::step]]
            axis.set_ticks(range(0, len(values), step), labels)
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    figure.savefig(path)


def tabulate_limits(rows: list[Row]) -> pd.DataFrame:
    """Count the verdicts of each family and method; at which values they are is for the map."""
    cells = pd.DataFrame(rows)
    panels = [cells.family, cells.method]
    counts = pd.crosstab(panels, cells.verdict).reindex(columns=list(VERDICTS), fill_value=0)
    return counts.assign(**{"greatest error": cells.groupby(panels).error.max()}).reset_index()
