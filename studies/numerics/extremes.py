"""A map of the limits: every method at parameters far from the usual ones, against closed forms.

The scenes are listed in `extremes.toml`. A cell of the map is one scene by one method. Its verdict
is the worst of its quantities:

    within      the error is within the method's own estimate
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
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..crosscheck.run import run
from ..figures.style import GREYS, RED, legend_of, new_figure
from ..methods.quantities import QUANTITIES
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..progress import progress
from ..tables import Row, Table, keeping_rows, write_page
from .core import indentation, solve
from .steady_rings import SteadyRings

VERDICTS: dict[str, tuple[Any, ...]] = {
    "within": ("s", "0.8", 20, "its error is within its own estimate"),
    "degraded": ("^", GREYS[4], 24, "less accurate than asked for, and says so"),
    "refused": ("_", GREYS[0], 28, "says why it cannot"),
    "wrong": ("X", RED, 40, "less accurate than it says"),
    "crashed": ("*", RED, 60, "by any other exception"),
}
"""From the best to the worst: marker, shade, size, meaning. Only defects are red."""


class Cell(NamedTuple):
    """A scene by one method, at values `x` and `y`; a whole run of it is judged, or the method."""

    family: str
    method: str
    x: Any
    y: Any
    scene: Scene
    whole: bool


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Judge every cell; writes `extremes` and `extremes_limits`.

    Of the scene, Poisson's ratio is taken.
    """
    numbers = ("error", "estimate", "rtol", "seconds")
    fields = (
        "family",
        "method",
        "x",
        "y",
        "verdict",
        "quantity",
        *numbers,
        "message",
        "parameters",
    )
    table, conclusions = Table(out / "extremes.csv", fields), list[str]()
    with threadpool_limits(1), keeping_rows(conclusions):
        cells = list(list_cells(scene.half_space.poisson_ratio, options.quick))
        for cell in progress(cells, "extremes", lambda cell: f"{cell.family} by {cell.method}"):
            table.add(**judge(cell))
    if table.rows:
        draw(table.rows, out / "extremes.png")
    counts = Counter(row["verdict"] for row in table.rows)
    counted = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS)
    conclusions.append(f"{len(table.rows)} cells: {counted}")
    page = {"Limits": tabulate_limits(table.rows, out / "extremes_limits.csv")}
    write_page(out / "extremes.md", "Limits of the methods", conclusions, page)
    return conclusions


def list_cells(poisson_ratio: float, quick: bool) -> Iterator[Cell]:
    """Yield every cell; when quick, every fourth value of each axis, and the last."""
    listing = files("ringwear.studies") / "numerics" / "extremes.toml"
    table = tomllib.loads(listing.read_text("utf-8"))
    base = Scene.from_table(table["base"]).changed(half_space__poisson_ratio=poisson_ratio)
    for family in table["families"]:
        if quick and family.get("slow"):
            continue
        axes = [read_axis(family[axis], table["axes"]) for axis in "xy"]
        if quick:
            axes = [{x: axis[x] for x in (*list(axis)[::4], list(axis)[-1])} for axis in axes]
        for x, method, y in product(axes[0], family["methods"], axes[1]):
            changes = {"methods": [method], "accuracy.rtol": table["rtol"][method]}
            changes |= family.get("scene", {}) | axes[0][x] | axes[1][y]
            changed = base.changed(**{key.replace(".", "__"): changes[key] for key in changes})
            yield Cell(family["name"], method, x, y, changed, family.get("whole", False))


def read_axis(
    axis: str | dict[str, Any], named: dict[str, dict[str, Any]]
) -> dict[Any, dict[str, Any]]:
    """Return what each value of an axis changes: values of one scene key, or labels."""
    axis = named[axis] if isinstance(axis, str) else axis
    key, values = next(iter(axis.items()))
    if "." not in key:
        return axis
    if isinstance(values, dict):
        values = [float(f"{value:.9g}") for value in np.geomspace(*values["geomspace"])]
    return {value: {key: [value] if key == "wear.times" else value} for value in values}


def judge(cell: Cell) -> Row:
    """Return a row of the table: the cell by the worst of its quantities."""
    start = time.perf_counter()
    worst: dict[str, Any]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            worst = max(
                judge_quantities(cell),
                key=lambda row: (
                    list(VERDICTS).index(row["verdict"]),
                    row["error"] / row["estimate"],
                ),
            )
    except RingwearError as error:
        worst = {"verdict": "refused", "message": str(error)}
    except Exception as error:  # whatever else comes out is what the study looks for
        worst = {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}
    about = {"rtol": cell.scene.accuracy.rtol, "parameters": json.dumps(cell.scene.table())}
    return cell._asdict() | worst | about | {"seconds": round(time.perf_counter() - start, 4)}


def judge_quantities(cell: Cell) -> Iterator[dict[str, Any]]:
    """Yield the verdict on every number with a closed form, and on the balance of forces."""
    problem = cell.scene.problem
    expected = closed_forms(problem, cell.method)
    if cell.whole:
        result = run(cell.scene)
        solution = result.solutions[cell.method]
        units = {name: getattr(problem.units, QUANTITIES[name].unit) for name in expected}
        values = {name: result.dataset[name].values[0] / units[name] for name in expected}
    else:
        solution = solve(cell.method, problem)
        values = {name: solution.results[name].values for name in expected}
    for name, (exact, accuracy) in expected.items():
        wrong, stated = np.abs(values[name] / exact - 1), solution.errors[name] + accuracy
        for error, estimate in np.nditer([wrong, stated]):
            yield verdict_on(name, float(error), float(estimate), problem.rtol)
    if "ring_force" in solution.results:
        for force in solution.results["ring_force"].values.sum(axis=-1):
            # whatever the discretisation
            yield verdict_on("force balance", abs(float(force) - 1), 1e-9, 1e-9)


def verdict_on(quantity: str, error: float, estimate: float, rtol: float) -> dict[str, Any]:
    """Return the verdict on a number, in the words of `VERDICTS`."""
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, 3 * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def closed_forms(problem: Problem, method: str) -> dict[str, tuple[Any, Any]]:
    """Return what the results of a method must be, and how accurately that is known."""
    quadrature = 2e-10
    rings, wear, times = (
        steady_rings(tuple(problem.ring_edges)),
        problem.wear_coefficients,
        problem.times,
    )
    pressures = rings.pressures(wear)
    rate, greatest = float(wear[0] * pressures[0]), rings.greatest_displacement(pressures)
    # at every ring edge but the last a disc of one pressure less the other ends, at the rim one of
    # its own pressure
    cancelled = (np.ptp(pressures) * problem.ring_edges[:-1].sum() + pressures.max()) / greatest
    values: dict[str, tuple[Any, Any]] = {
        "steady_wear_rate": (rate, quadrature),
        # against 60 digits: up to 3.6e-15 of what cancels
        "steady_displacement_max": (greatest, quadrature + 5e-15 * cancelled),
    }
    if len(wear) <= 64:  # with more rings that quadrature would take longer than the study
        slope = np.sqrt(pressures @ rings.grams[0] @ pressures)
        values["steady_rms_slope"] = slope, quadrature + 3e-15 / problem.rings.widths.min()
    if len(times) and method != "direct":
        # after fifty of the slowest relaxation times, 0.4 / k_min, only the steady state is left
        late = times > 50 * 0.4 / wear.min()
        exact = np.where(late, rate * times + pressures @ rings.grams[1] @ pressures, D0)
        between = ~late & (times > 0)
        if between.any():
            other = "fem" if method == "mdr" else "mdr"
            punch = (tuple(part) for part in problem.merged)
            exact[between] = accurate_indentation(other, *punch, tuple(times[between]))
        values["indentation"] = exact, np.where(between, 5e-7, quadrature)
    return values


@lru_cache(maxsize=16)  # neighbouring cells have it in common
def steady_rings(ring_edges: tuple[float, ...]) -> SteadyRings:
    """Return the steady states of rings."""
    return SteadyRings(np.array(ring_edges))


@lru_cache(maxsize=16)
def accurate_indentation(
    method: str, ring_edges: tuple[float, ...], wear: tuple[float, ...], times: tuple[float, ...]
) -> Array:
    """Return the indentation (T,) by a method at an accuracy of 1e-6."""
    rings = Rings(np.array(ring_edges), np.array(wear))
    return indentation(method, Problem(rings, np.array(times), rtol=1e-6))


def draw(rows: list[Row], path: Path) -> None:
    """Draw one page: a panel for each family and method, a symbol for each cell."""
    panels = list(dict.fromkeys((row["family"], row["method"]) for row in rows))
    height = -(-len(panels) // 5)
    figure = new_figure(16, 3.2 * height)
    for number, (family, method) in enumerate(panels, 1):
        cells = [row for row in rows if (row["family"], row["method"]) == (family, method)]
        across, _, up = family.partition(" × ")
        axes = figure.add_subplot(height, 5, number, title=method, xlabel=across, ylabel=up)
        xs, ys = (list(dict.fromkeys(row[axis] for row in cells)) for axis in "xy")
        for verdict, (marker, shade, size, meaning) in VERDICTS.items():
            places = [
                (xs.index(row["x"]), ys.index(row["y"]))
                for row in cells
                if row["verdict"] == verdict
            ]
            look = {"s": size, "color": shade, "marker": marker}
            axes.scatter(*np.reshape(places, (-1, 2)).T, **look, label=f"{verdict}: {meaning}")
        for axis, values in ((axes.xaxis, xs), (axes.yaxis, ys)):
            step = -(-len(values) // 5)
            labels = [f"{v:.3g}" if isinstance(v, float) else v for v in values[::step]]
            axis.set_ticks(range(0, len(values), step), labels)
        axes.margins(0.1)
    legend_of(figure, figure.axes[:1])
    figure.savefig(path)


def tabulate_limits(rows: list[Row], path: Path) -> Table:
    """Count the verdicts of each family and method; at which values they are is for the map."""
    table = Table(path, ("family", "method", *VERDICTS, "greatest error"))
    panels: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        panels.setdefault((row["family"], row["method"]), []).append(row)
    for panel, cells in panels.items():
        counts = Counter(row["verdict"] for row in cells)
        greatest = np.nanmax([row.get("error", np.nan) for row in cells] + [0.0])
        table.add(*panel, *(counts[verdict] for verdict in VERDICTS), f"{greatest:.1e}")
    return table
