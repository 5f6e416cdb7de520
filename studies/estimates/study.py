"""Are stated errors honest, and is the accuracy reached? Every quantity at every time, on scenes
drawn at random.

True errors are against an independent reference (`reference.py`). An estimate is honest if it is
not below the truth, and worth having if it is not far above: their ratio, estimate over error, is
its effectivity.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..crosscheck.run import Result, run
from ..figures.style import new_figure
from ..methods.base import method
from ..methods.quantities import COMPARED_MODES, QUANTITIES, differences
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..progress import progress
from ..tables import Row, Table, keeping_rows, write_page
from .reference import known
from .scenes import random_scenes

FIELDS = (
    "scene",
    "rings",
    "narrowest",
    "least_wear",
    "poisson_ratio",
    "earliest",
    "rtol",
    "method",
    "quantity",
    "error",
    "estimate",
    "values",
    "below",
    "effectivity",
    "verdict",
    "seconds",
    "seconds_planned",
    "unknowns",
    "unknowns_planned",
    "remark",
)
# errors below this are roundoff, and their estimates with them
ROUNDOFF = 3e-13


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Draw scenes and compare.

    Writes `estimates.csv` and `estimates.png`. The scene given is for warming up only.
    """
    table, conclusions = Table(out / "estimates.csv", FIELDS), list[str]()
    count, most = (8, 5) if options.quick else (options.count, options.rings)
    drawn = list(random_scenes(options.seed, count, most))
    with keeping_rows(conclusions):
        run(
            scene.changed(methods=["mdr", "fem"], accuracy__rtol=1e-2)
        )  # what is loaded for the first run is not timed
        for one in progress(
            drawn, "scene", lambda one: f"{one.punch.rings} rings, rtol {one.accuracy.rtol:.1e}"
        ):
            for row in rows_of(one):
                table.add(**row)
    compared = {
        name: {
            quantity: rows for quantity in QUANTITIES if (rows := _of(table.rows, name, quantity))
        }
        for name in ("mdr", "fem")
    }
    if all(compared.values()):
        draw(compared, options.seed, out / "estimates.png")
        conclusions += [concluded(*of) for of in compared.items()]
        conclusions += [
            worth(name, quantity, rows)
            for name in compared
            for quantity, rows in compared[name].items()
        ]
    write_page(out / "estimates.md", "Estimated and true errors", conclusions, {"Scenes": table})
    return conclusions


def _of(rows: list[Row], name: str, quantity: str) -> list[Row]:
    return [row for row in rows if (row.get("method"), row.get("quantity")) == (name, quantity)]


def true_errors(result: Result) -> dict[str, dict[str, tuple[Array, Array]]]:
    """(error, estimate) at the checked times, by method and quantity of a run, beyond what the
    reference is known to.
    """
    problem = result.scene.problem
    exact, unsure = references(problem)
    out: dict[str, dict[str, tuple[Array, Array]]] = {}
    for name, solution in result.solutions.items():
        out[name] = {}
        for quantity, error in differences(solution.checked, exact, problem.face).items():
            estimate = solution.checked_error(problem, quantity)
            parts = [np.atleast_1d(part) for part in (error, estimate, unsure[quantity])]
            shown = min(len(part) for part in parts)
            if "mode" in QUANTITIES[quantity].dims:
                shown = min(shown, COMPARED_MODES)
            error, estimate, doubt = (part[:shown] for part in parts)
            out[name][quantity] = np.maximum(error - 2 * doubt, 0.0), estimate
    return out


def references(problem: Problem) -> tuple[xarray.Dataset, dict[str, Array]]:
    """The reference, and how far a coarser one is from it."""
    exact = known(problem)
    return exact, differences(known(problem, finer=0.03), exact, problem.face)


def rows_of(drawn: Scene) -> Iterator[Row]:
    """A row for each method and quantity of one scene, or the reason why there is none."""
    problem = drawn.problem
    common: dict[str, Any] = {
        "scene": drawn.title,
        "rings": len(problem.merged.widths),
        "narrowest": float(problem.merged.widths.min()),
        "least_wear": float(problem.merged.wear_coefficients.min()),
        "poisson_ratio": problem.poisson_ratio,
        "earliest": problem.earliest,
        "rtol": problem.rtol,
    }
    try:
        result = run(drawn)
    except RingwearError as reason:
        yield common | {"remark": str(reason)}
        return
    disagreeing = [
        quantity for quantity, verdict in result.quantities.items() if verdict == "disagree"
    ]
    disagreeing += [
        f"{anchor.method} {anchor.name}" for anchor in result.anchors if not anchor.holds
    ]
    common["remark"] = f"false alarm: {', '.join(disagreeing)}" if disagreeing else ""
    for name, errors in true_errors(result).items():
        if name == "direct":
            continue
        cost = method(name).cost(problem)
        common |= {
            "method": name,
            "seconds_planned": cost.seconds,
            "unknowns_planned": cost.unknowns,
        }
        common |= {
            "seconds": sum(result.stages[name].seconds.values()),
            "unknowns": result.solutions[name].unknowns,
        }
        for quantity, (error, estimate) in errors.items():
            worst, ratios = int(np.argmax(error)), effectivities(error, estimate)
            yield common | {
                "quantity": quantity,
                "error": float(error[worst]),
                "estimate": float(estimate[worst]),
                "values": len(error),
                "below": int(np.sum(error > estimate)),
                "effectivity": float(np.median(ratios)) if len(ratios) else np.nan,
                "verdict": reached(error, estimate, problem.rtol),
            }


def effectivities(error: Array, estimate: Array) -> Array:
    """Estimates over errors that are above roundoff."""
    counted = error > ROUNDOFF
    return np.asarray(estimate[counted] / error[counted])


def reached(error: Array, estimate: Array, rtol: float) -> str:
    """Whether the accuracy was reached at all times, or said not to be where it was not."""
    if (error <= rtol).all():
        return "reached"
    return "said" if (estimate[error > rtol] > rtol).all() else "missed"


def concluded(name: str, quantities: dict[str, list[Row]]) -> str:
    """What holds for all quantities of a method."""
    rows = [row for of_quantity in quantities.values() for row in of_quantity]
    below, values = (sum(row[what] for row in rows) for what in ("below", "values"))
    verdicts = [row["verdict"] for row in rows]
    one = quantities["steady_wear_rate"]
    alarms = sum(bool(row["remark"]) for row in one)
    spans = {
        what: [row[what] / row[f"{what}_planned"] for row in one]
        for what in ("seconds", "unknowns")
    }
    listed = ", ".join(f"{what} {min(span):.2f} to {max(span):.2f}" for what, span in spans.items())
    return (
        f"{name}: of {values} values {below / values:.2%} have errors above their estimate; of "
        f"{len(rows)} quantities of "
        f"{len(one)} scenes {verdicts.count('reached')} reach rtol at all times, "
        f"{verdicts.count('said')} say that they do "
        f"not, {verdicts.count('missed')} miss it; scenes with a false alarm: {alarms}; measured "
        f"over planned: {listed}"
    )


def worth(name: str, quantity: str, rows: list[Row]) -> str:
    """How honest the estimates of a quantity are, and what they are worth."""
    ratios = np.array([row["effectivity"] for row in rows])
    ratios = ratios[np.isfinite(ratios)]
    below, values = (sum(row[what] for row in rows) for what in ("below", "values"))
    line = f"{name}, {quantity}: {below} of {values} values below the truth"
    if len(ratios):
        line += f"; effectivity {np.median(ratios):.1f}, 95 % up to {np.quantile(ratios, 0.95):.0f}"
    return line


def draw(compared: dict[str, dict[str, list[Row]]], seed: int, path: Path) -> None:
    """Effectivities of every quantity: medians over the times of each scene."""
    figure = new_figure(8.5, 4.6)
    axes = figure.subplots()
    found = {
        name
        for rows in compared.values()
        for name in rows
        if any(np.isfinite(one["effectivity"]) for one in rows[name])
    }
    names = [name for name in QUANTITIES if name in found]
    for shift, (name, quantities) in zip((-0.15, 0.15), compared.items(), strict=True):
        look: dict[str, Any] = {
            "marker": "o" if name == "mdr" else "x",
            "color": "0.5" if name == "mdr" else "black",
        }
        points = [
            (row["effectivity"], names.index(quantity) + shift)
            for quantity in names
            for row in quantities.get(quantity, ())
        ]
        axes.plot(*np.array(points).T, linestyle="none", markersize=3, label=name.upper(), **look)
    axes.axvline(1, color="0.4", linewidth=0.8)
    axes.set(
        xscale="log",
        xlabel="estimated over true error, median over the times of a scene; honest right of the "
        "line",
    )
    axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=8)
    axes.invert_yaxis()
    axes.legend(frameon=False, fontsize=9)
    figure.suptitle(f"scenes drawn at random, seed {seed}", fontsize=10)
    figure.savefig(path)
