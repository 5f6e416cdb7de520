"""Are stated errors honest? True error over estimate (the effectivity index, inverted) on scenes drawn at random.

An estimate is honest where the true error lies between a twentieth of it and all of it.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ringwear.meshes.errors import RingwearError
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.figures.style import new_figure
from ringwear.studies.measured import exact
from ringwear.studies.methods.base import method
from ringwear.studies.methods.quantities import array, error_name, relative_difference
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import progress
from ringwear.studies.tables import Row, Table, keeping_rows, write_page

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
    compared = {
        (name, quantity): [row for row in table.rows if (row.get("method"), row.get("quantity")) == (name, quantity)]
        for name in ("mdr", "fem")
        for quantity in QUANTITIES
    }
    if all(compared.values()):
        draw(compared, options.seed, out / "estimates.png")
        conclusions += [concluded(*of, rows) for of, rows in compared.items()]
    write_page(out / "estimates.md", "Estimated and true errors", conclusions, {"Scenes": table})
    return conclusions


def random_scenes(seed: int, count: int, most_rings: int = 64) -> Iterator[Scene]:
    """Rings 1 to `most_rings`, wear ratios 1e-3 to 1e3, width ratios 0.1 to 10, nu 0 to 0.5, rtol 1e-2 to 1e-7."""
    generator = np.random.default_rng(seed)
    for number in range(count):
        rings = int(np.exp(generator.uniform(0, np.log(most_rings + 1))))
        ratio, width = float(10 ** generator.uniform(-3, 3)), float(10 ** generator.uniform(-1, 1))
        times = np.concatenate([[0.0], np.geomspace(1e-3, 10, 7) / max(1.0, ratio) * max(1.0, 1 / ratio)])
        yield Scene.load("five_rings").changed(
            title=f"random scene {number} of seed {seed}",
            methods=["mdr", "fem"],
            punch={"radius": 1.0, "rings": rings, "width_ratio": width, "wear_coefficients": [1.0, ratio]},
            half_space__poisson_ratio=float(generator.uniform(0, 0.5)),
            wear={"times": times.tolist()},
            accuracy__rtol=float(10 ** generator.uniform(-7, -2)),
        )


def true_errors(result: Result) -> dict[str, dict[str, tuple[float, float]]]:
    """Greatest (error, estimate) by method and quantity of a run, against `exact`."""
    known = exact(result.scene.problem)

    def greatest(results: xarray.Dataset, quantity: str) -> tuple[float, float]:
        error = relative_difference(quantity, array(results, quantity), array(known, quantity))
        return float(error.max()), float(array(results, error_name(quantity)).max())

    return {
        name: {quantity: greatest(solution.results, quantity) for quantity in QUANTITIES}
        for name, solution in result.solutions.items()
    }


def rows_of(drawn: Scene) -> Iterator[Row]:
    """A row for each method and quantity of one scene, or the reason why there is none."""
    common: dict[str, Any] = {
        "scene": drawn.title, "rings": drawn.punch.rings, "wear_ratio": drawn.punch.wear_coefficients[1],
        "width_ratio": drawn.punch.width_ratio, "poisson_ratio": drawn.half_space.poisson_ratio, "rtol": drawn.accuracy.rtol,
    }  # fmt: skip
    try:
        result = run(drawn)
    except RingwearError as reason:
        yield common | {"remark": str(reason)}
        return
    common["remark"] = "" if result.agrees else "the verdict was a false alarm"
    for name, errors in true_errors(result).items():
        cost = method(name).cost(drawn.problem)
        common |= {"method": name, "seconds_planned": cost.seconds, "unknowns_planned": cost.unknowns}
        common |= {"seconds": sum(result.stages[name].seconds.values()), "unknowns": result.solutions[name].unknowns}
        for quantity, (error, estimate) in errors.items():
            yield common | {"quantity": quantity, "error": error, "estimate": estimate, "ratio": error / estimate}


def concluded(name: str, quantity: str, rows: list[Row]) -> str:
    """How honest the estimates of a quantity by a method are; with the indentation, also what was reached and its cost."""
    ratios = np.array([row["ratio"] for row in rows])
    honest = np.mean((ratios >= HONEST[0]) & (ratios <= HONEST[1]))
    line = f"{name}, {quantity}: error / estimate within [0.05, 1] for {honest:.1%}, above 1 for {np.mean(ratios > 1):.1%}"
    if quantity == "indentation":
        reached, alarms = np.mean([row["error"] <= row["rtol"] for row in rows]), sum(bool(row["remark"]) for row in rows)
        spans = {what: [row[what] / row[f"{what}_planned"] for row in rows] for what in ("seconds", "unknowns")}
        line += f" of {len(rows)} scenes; rtol reached in {reached:.1%}, false alarms: {alarms}; measured over planned: "
        line += ", ".join(f"{what} {min(span):.2f} to {max(span):.2f}" for what, span in spans.items())
    return line


def draw(compared: dict[tuple[str, str], list[Row]], seed: int, path: Path) -> None:
    """Histograms of true error over estimate."""
    figure = new_figure(8.5, 3.6)
    panels = dict(zip(QUANTITIES, figure.subplots(1, 2, sharey=True), strict=True))
    styles = {"mdr": {"histtype": "stepfilled", "color": "0.6"}, "fem": {"histtype": "step", "color": "black"}}
    bins = np.geomspace(1e-3, 10, 25)
    for (name, quantity), rows in compared.items():
        ratios = np.clip([row["ratio"] for row in rows], bins[0], bins[-1])
        panels[quantity].hist(ratios, bins, label=name.upper(), **styles[name])
    for quantity, axes in panels.items():
        axes.axvspan(*HONEST, color="0.9", linewidth=0, zorder=0)
        axes.set(xscale="log", xlabel="true error over estimate")
        axes.set_title(f"{quantity.replace('_', ' ')}; honest where shaded", fontsize=9)
    panels["indentation"].set_ylabel("scenes")
    axes.legend(frameon=False, fontsize=9)
    figure.suptitle(f"scenes drawn at random, seed {seed}", fontsize=10)
    figure.savefig(path)
