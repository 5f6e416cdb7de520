"""Are stated errors honest? Scenes drawn at random from a seed, true error over own estimate, and the histogram.

True errors are those against an MDR far finer than anything compared here. An estimate is honest where the true error
lies between a twentieth of it and all of it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.meshes.errors import RingwearError
from ringwear.studies.convergence.levels import Table, keeping_rows, new_figure
from ringwear.studies.crosscheck.costs import predicted
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.methods.outcome import Evaluation, relative_difference
from ringwear.studies.methods.radial import mdr_model
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages
from ringwear.studies.random_scenes import random_scenes

FINE = {"degree": 9, "rim_size": 1e-8, "ring_size": 2e-5, "grading": 0.25}
QUANTITIES = ("indentation", "steady_rms_slope")
FIELDS = ("scene", "rings", "wear_ratio", "width_ratio", "poisson_ratio", "rtol", "method", "quantity", "error",
          "estimate", "ratio", "seconds", "seconds_planned", "unknowns", "unknowns_planned", "remark")  # fmt: skip
PLANNED = ("seconds", "seconds_planned", "unknowns", "unknowns_planned")
HONEST = (0.05, 1.0)


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Draw scenes and compare; writes `estimates.csv` and `estimates.png`. The scene given is for warming up only."""
    table, conclusions = Table(out / "estimates.csv", FIELDS), list[str]()
    count, most = (8, 6) if options.quick else (options.count, options.rings)
    run(scene.changed(methods=["mdr", "fem"], accuracy__rtol=1e-2))  # what is loaded for the first run of all is not timed
    with keeping_rows(conclusions):
        for number, drawn in enumerate(random_scenes(options.seed, count, most)):
            report(f"scene   {number + 1} of {count}: {drawn.punch.rings} rings, rtol {drawn.accuracy.rtol:.1e} ...")
            for row in compared(number, drawn):
                table.add(**row)
    draw(table.rows, options.seed, out / "estimates.png")
    conclusions += [_conclusion(table.rows, method, quantity) for method in ("mdr", "fem") for quantity in QUANTITIES]
    (out / "estimates.md").write_text("\n\n".join(conclusions) + "\n\n" + table.markdown(), "utf-8")
    return conclusions


def compared(number: int, drawn: Scene) -> list[dict[str, Any]]:
    """A row for each method and quantity of one scene, or the reason why there is none."""
    common = {
        "scene": number, "rings": drawn.punch.rings, "wear_ratio": drawn.punch.wear_coefficients[1],
        "width_ratio": drawn.punch.width_ratio, "poisson_ratio": drawn.half_space.poisson_ratio, "rtol": drawn.accuracy.rtol,
    }  # fmt: skip
    try:
        result = run(drawn)
    except RingwearError as error:
        blank = {"method": "", "quantity": "", "error": np.nan, "estimate": np.nan, "ratio": np.nan}
        return [common | blank | dict.fromkeys(PLANNED, np.nan) | {"remark": str(error)}]
    verdict = "" if result.agrees else "the verdict was a false alarm"
    return [common | row | planned(result, row["method"]) | {"remark": verdict} for row in true_errors(result)]


def planned(result: Result, method: str) -> dict[str, float]:
    """What a method cost beside what the plan had foretold."""
    foretold = predicted(result.scene.natural, method)
    seconds = sum(result.stages[method].seconds.values())
    return dict(zip(PLANNED, (seconds, foretold.seconds, result.models[method].unknowns, foretold.unknowns), strict=True))


def true_errors(result: Result) -> list[dict[str, Any]]:
    """Error, estimate and their ratio for every method and quantity of a run."""
    asked = result.scene.wear
    exact_in_time = {"times": asked.times, "steady": asked.steady}
    natural = result.scene.changed(accuracy__rtol=1e-8, accuracy__mdr=FINE, wear=exact_in_time).natural
    exact = Evaluation(natural, mdr_model(natural, Stages("exact"), twins=False).compliance).outcome
    # at the start it is known in closed form, and finer than any mesh tells
    exact.indentation[natural.times == 0] = 0.5
    rows = []
    for method, outcome in result.outcomes.items():
        for name in QUANTITIES:
            error = float(relative_difference(name, getattr(outcome, name), getattr(exact, name)).max())
            estimate = float(getattr(result.errors[method], name).max())
            rows.append(
                {"method": method, "quantity": name, "error": error, "estimate": estimate, "ratio": error / estimate}
            )
    return rows


def _ratios(rows: list[dict[str, Any]], method: str, quantity: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([row["ratio"] for row in rows if (row["method"], row["quantity"]) == (method, quantity)])


def _conclusion(rows: list[dict[str, Any]], method: str, quantity: str) -> str:
    ratios = _ratios(rows, method, quantity)
    mine = [row for row in rows if (row["method"], row["quantity"]) == (method, quantity)]
    honest = np.mean((ratios >= HONEST[0]) & (ratios <= HONEST[1]))
    line = f"{method}, {quantity}: error / estimate within [0.05, 1] for {honest:.1%}, above 1 for {np.mean(ratios > 1):.1%}"
    if quantity == "indentation":
        reached = np.mean([row["error"] <= row["rtol"] for row in mine])
        alarms = sum(bool(row["remark"]) for row in mine)
        line += f" of {len(mine)} scenes; rtol reached in {reached:.1%}, false alarms: {alarms}"
        line += "; measured over planned: " + ", ".join(f"{name} {_span(mine, name)}" for name in ("seconds", "unknowns"))
    return line


def _span(rows: list[dict[str, Any]], name: str) -> str:
    ratios = [row[name] / row[f"{name}_planned"] for row in rows]
    return f"{min(ratios):.2f} to {max(ratios):.2f}"


def draw(rows: list[dict[str, Any]], seed: int, path: Path) -> None:
    """Histograms of true error over own estimate."""
    figure = new_figure(8.5, 3.6)
    bins = np.geomspace(1e-3, 10, 25)
    for axes, quantity in zip(figure.subplots(1, 2, sharey=True), QUANTITIES, strict=True):
        axes.axvspan(*HONEST, color="0.9", linewidth=0)
        for method, style in (
            ("mdr", {"histtype": "stepfilled", "color": "0.6"}),
            ("fem", {"histtype": "step", "color": "black"}),
        ):
            axes.hist(np.clip(_ratios(rows, method, quantity), bins[0], bins[-1]), bins, label=method.upper(), **style)
        axes.set_xscale("log")
        axes.set_xlabel("true error over own estimate")
        axes.set_title(quantity.replace("_", " ") + "; honest where shaded", fontsize=9)
    axes.legend(frameon=False, fontsize=9)
    figure.axes[0].set_ylabel("scenes")
    figure.suptitle(f"scenes drawn at random, seed {seed}", fontsize=10)
    figure.savefig(path)
