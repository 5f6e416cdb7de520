"""Error against seconds for every method and family of settings, measured on this machine.

Errors are those of the indentation over the scene's times, relative, against an MDR far more
accurate than anything measured here; seconds are of one whole history (mesh, assembly,
condensation, all times), the least of some repeats after a warm-up, on one thread. No error is
estimated while the clock runs.
"""

import argparse
import os
import platform
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..figures.style import legend_below, new_figure
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..tables import Row, Table
from .core import exact_indentation, indentation, solve
from .sequences import Family, Level, draw_errors, publish, solve_all


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every family; writes `tradeoff` and `front`."""
    problem, conclusions = replace(scene.problem, march="modal", step=None), list[str]()
    if not problem.earliest:
        problem = replace(problem, times=np.array([0.01, 0.1, 1.0]))
    fields = ("family", "setting", "unknowns", "seconds", "error", "estimate", "remark")
    table = Table(out / "tradeoff.csv", fields)
    solve_all(families(problem, options.quick), table, conclusions)
    rows = [row for row in table.rows if "error" in row]
    front = Table(out / "front.csv", fields, find_front(rows))
    draw(rows, front.rows, f"{scene.title}: what accuracy costs", out / "tradeoff.png")
    conclusions.append(f"Measured on {platform.platform()}, one thread of {os.cpu_count()}.")
    tables = {"Pareto front": front, "All settings": table}
    return publish(out / "tradeoff.md", "What accuracy costs", conclusions, tables)


def families(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield the settings of each method, from fast to accurate."""
    exact = exact_indentation(problem)

    def family(name: str, method: str, settings: dict[str, dict[str, Any]]) -> Family:
        return Family(
            name,
            [
                Level(setting, partial(measure, method, replace(problem, **changes), exact, quick))
                for setting, changes in settings.items()
            ],
        )

    few = 2 if quick else None
    dial = (1e-2, 1e-4) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    for name, changes in (
        ("mdr", {}),
        ("bem", {}),
        ("fem quads", {"fem": FemAccuracy(mesher="quads")}),
        *((f"fem P{k}", {"fem": FemAccuracy(mesher="gmsh", degree=k)}) for k in (2, 3, 4)),
    ):
        settings = {f"rtol {rtol:.0e}": {"rtol": rtol} | changes for rtol in dial}
        yield family(name, name.split()[0], settings)
    boundaries = {
        f"R = {radius} a": {"fem": FemAccuracy(far_field="fixed", truncation=radius)}
        for radius in (5, 20, 100, 1000)[:few]
    }
    yield family("fem fixed", "fem", boundaries)
    # the explicit march is only stable on a mesh that is not graded: the rim is left coarse for it
    coarse = MdrAccuracy(degree=2, rim_size=0.02, ring_size=0.02)
    for march, sizes in (("implicit", MdrAccuracy()), ("explicit", coarse)):
        steps = {
            f"step {step:g}": {"march": march, "step": step, "mdr": sizes}
            for step in (0.1, 0.01, 0.001)[:few]
        }
        yield family(f"mdr {march}", "mdr", steps)
    grids = {f"n = {count}": {"mdr": MdrAccuracy(grid=count)} for count in (100, 200, 400)[:few]}
    yield family("mdr-grid", "mdr-grid", grids)


def measure(name: str, problem: Problem, exact: Array, quick: bool) -> Row:
    """Measure seconds (the least of five repeats, or one), error and the method's estimate."""
    seconds = []
    for _ in range(2 if quick else 6):
        start = time.perf_counter()
        values = indentation(name, problem)
        seconds.append(time.perf_counter() - start)
    solution = solve(name, problem)
    return {
        "unknowns": solution.unknowns,
        "seconds": min(seconds[1:]),  # the first is a warm-up
        "error": float(np.abs(values / exact - 1).max()),
        "estimate": float(solution.errors["indentation"].max()),
    }


def find_front(rows: Iterable[Row]) -> list[Row]:
    """Return rows than which none is faster and as accurate (to a tenth), the fastest first."""
    front: list[Row] = []
    for row in sorted(rows, key=lambda row: float(row["seconds"])):
        if not front or row["error"] < 0.9 * front[-1]["error"]:
            front.append(row)
    return front


def draw(rows: list[Row], front: list[Row], title: str, path: Path) -> None:
    """Draw precision against work, a line for each family, and the Pareto front behind."""
    figure = new_figure(7.5, 5.6)
    axes = figure.subplots()

    def points(rows: Iterable[Row]) -> Array:
        return np.array([(row["seconds"], row["error"]) for row in rows]).reshape(-1, 2).T

    curves = {
        family: points(row for row in rows if row["family"] == family)
        for family in dict.fromkeys(row["family"] for row in rows)
    }
    labels = {
        "xlabel": "seconds for the whole history, one thread",
        "ylabel": "relative error of the indentation over all times",
    }
    draw_errors(axes, curves, **labels)
    axes.plot(*points(front), color="0.85", linewidth=5, zorder=0, label="Pareto front")
    legend_below(axes, ncols=4)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)
