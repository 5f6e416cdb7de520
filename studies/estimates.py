"""Are stated errors honest? True error over estimate (the effectivity index, inverted) on scenes drawn at random.

True errors are those against an MDR far finer than anything compared here. An estimate is honest where the true error
lies between a twentieth of it and all of it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ringwear.meshes.errors import RingwearError
from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.figures.style import new_figure
from ringwear.studies.methods import mdr
from ringwear.studies.methods.base import method
from ringwear.studies.methods.quantities import array, error_name, relative_difference
from ringwear.studies.methods.sampler import Evaluation
from ringwear.studies.problem.scene import Scene
from ringwear.studies.problem.sections import MdrAccuracy
from ringwear.studies.progress import Stages, progress
from ringwear.studies.tables import Table, keeping_rows, write_page

FINE = MdrAccuracy(degree=9, rim_size=1e-8, ring_size=2e-5, grading=0.25)
QUANTITIES = ("indentation", "steady_rms_slope")
FIELDS = ("scene", "rings", "wear_ratio", "width_ratio", "poisson_ratio", "rtol", "method", "quantity", "error",
          "estimate", "ratio", "seconds", "seconds_planned", "unknowns", "unknowns_planned", "remark")  # fmt: skip
HONEST = (0.05, 1.0)


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Draw scenes and compare; writes `estimates.csv` and `estimates.png`. The scene given is for warming up only."""
    table, conclusions = Table(out / "estimates.csv", FIELDS), list[str]()
    count, most = (8, 6) if options.quick else (options.count, options.rings)
    drawn = list(random_scenes(options.seed, count, most))
    with keeping_rows(conclusions):
        run(scene.changed(methods=["mdr", "fem"], accuracy__rtol=1e-2))  # what is loaded for the first run is not timed
        for one in progress(drawn, "scene", lambda one: f"{one.punch.rings} rings, rtol {one.accuracy.rtol:.1e}"):
            for row in rows_of(one):
                table.add(**row)
    if table.rows:
        draw(table.rows, options.seed, out / "estimates.png")
        conclusions += [_conclusion(table.rows, name, quantity) for name in ("mdr", "fem") for quantity in QUANTITIES]
    write_page(out / "estimates.md", "Estimated and true errors", conclusions, {"Scenes": table})
    return conclusions


def random_scenes(seed: int, count: int, most_rings: int = 64) -> Iterator[Scene]:
    """Rings 1 to `most_rings`, wear ratios 1e-3 to 1e3, width ratios 0.1 to 10, nu 0 to 0.5, rtol 1e-2 to 1e-7."""
    generator = np.random.default_rng(seed)
    for number in range(count):
        rings = int(np.exp(generator.uniform(0, np.log(most_rings + 1))))
        ratio, width = 10 ** generator.uniform(-3, 3), 10 ** generator.uniform(-1, 1)
        times = np.concatenate([[0.0], np.geomspace(1e-3, 10, 7) / max(1.0, ratio) * max(1.0, 1 / ratio)])
        coefficients = [1.0, float(ratio)]
        yield Scene.from_table(
            {
                "title": f"random scene {number} of seed {seed}",
                "methods": ["mdr", "fem"],
                "punch": {"radius": 1.0, "rings": rings, "width_ratio": float(width), "wear_coefficients": coefficients},
                "half_space": {"plane_strain_modulus": 1.0, "poisson_ratio": float(generator.uniform(0, 0.5))},
                "load": {"normal_force": 1.0},
                "wear": {"times": [float(time) for time in times]},
                "accuracy": {"rtol": float(10 ** generator.uniform(-7, -2))},
            }
        )


def rows_of(drawn: Scene) -> Iterator[dict[str, Any]]:
    """A row for each method and quantity of one scene, or the reason why there is none."""
    common = {
        "scene": drawn.title, "rings": drawn.punch.rings, "wear_ratio": drawn.punch.wear_coefficients[1],
        "width_ratio": drawn.punch.width_ratio, "poisson_ratio": drawn.half_space.poisson_ratio, "rtol": drawn.accuracy.rtol,
    }  # fmt: skip
    try:
        result = run(drawn)
    except RingwearError as reason:
        yield common | {"remark": str(reason)}
        return
    remark = "" if result.agrees else "the verdict was a false alarm"
    for name, errors in true_errors(result).items():
        cost, seconds = method(name).cost(drawn.problem), sum(result.stages[name].seconds.values())
        plan = {
            "seconds": seconds, "seconds_planned": cost.seconds, "unknowns": result.solutions[name].unknowns,
            "unknowns_planned": cost.unknowns,
        }  # fmt: skip
        for quantity, (error, estimate) in errors.items():
            compared = {"error": error, "estimate": estimate, "ratio": error / estimate}
            yield common | plan | {"method": name, "quantity": quantity, "remark": remark} | compared


def true_errors(result: Result) -> dict[str, dict[str, tuple[float, float]]]:
    """Greatest (error, estimate) by method and quantity of a run, against a far finer MDR, exact in time."""
    problem = replace(result.scene.problem, rtol=1e-8, mdr=FINE, march="modal", step=None)
    exact = Evaluation(problem, mdr.METHOD.discretised(problem, Stages("exact"), pairs=False).compliance).results
    # at the start it is known in closed form, more accurately than on any mesh
    exact.indentation[problem.times == 0] = 0.5

    def greatest(values: Array) -> float:
        return float(np.max(values))

    return {
        name: {
            quantity: (
                greatest(relative_difference(quantity, array(solution.results, quantity), array(exact, quantity))),
                greatest(array(solution.results, error_name(quantity))),
            )
            for quantity in QUANTITIES
        }
        for name, solution in result.solutions.items()
    }


def _ratios(rows: list[Any], name: str, quantity: str) -> Array:
    return np.array([row["ratio"] for row in rows if (row.get("method"), row.get("quantity")) == (name, quantity)])


def _conclusion(rows: list[Any], name: str, quantity: str) -> str:
    ratios = _ratios(rows, name, quantity)
    honest = np.mean((ratios >= HONEST[0]) & (ratios <= HONEST[1]))
    line = f"{name}, {quantity}: error / estimate within [0.05, 1] for {honest:.1%}, above 1 for {np.mean(ratios > 1):.1%}"
    if quantity == "indentation":
        own = [row for row in rows if (row.get("method"), row.get("quantity")) == (name, quantity)]
        reached, alarms = np.mean([row["error"] <= row["rtol"] for row in own]), sum(bool(row["remark"]) for row in own)
        spans = {what: [row[what] / row[f"{what}_planned"] for row in own] for what in ("seconds", "unknowns")}
        line += f" of {len(own)} scenes; rtol reached in {reached:.1%}, false alarms: {alarms}; measured over planned: "
        line += ", ".join(f"{what} {min(span):.2f} to {max(span):.2f}" for what, span in spans.items())
    return line


def draw(rows: list[Any], seed: int, path: Path) -> None:
    """Histograms of true error over estimate."""
    figure = new_figure(8.5, 3.6)
    bins = np.geomspace(1e-3, 10, 25)
    styles = {"mdr": {"histtype": "stepfilled", "color": "0.6"}, "fem": {"histtype": "step", "color": "black"}}
    panels = figure.subplots(1, 2, sharey=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        axes.axvspan(*HONEST, color="0.9", linewidth=0)
        for name, style in styles.items():
            axes.hist(np.clip(_ratios(rows, name, quantity), bins[0], bins[-1]), bins, label=name.upper(), **style)
        axes.set_xscale("log")
        axes.set_xlabel("true error over estimate")
        axes.set_title(quantity.replace("_", " ") + "; honest where shaded", fontsize=9)
    axes.legend(frameon=False, fontsize=9)
    panels[0].set_ylabel("scenes")
    figure.suptitle(f"scenes drawn at random, seed {seed}", fontsize=10)
    figure.savefig(path)
