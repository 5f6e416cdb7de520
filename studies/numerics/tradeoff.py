"""Error against seconds for every method and family of settings, measured on this machine.

Errors are those of the indentation over the scene's times, relative, against an MDR far more
accurate than anything measured here; seconds are of one whole history with the method's estimate of
its error (meshes, assembly, condensation, all times), the least of some repeats after a warm-up, on
one thread.
"""

import argparse
import os
import platform
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...meshes.radial import Array
from ..methods.base import method
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..progress import Stages
from ..tables import Row, Table
from .core import exact_indentation
from .sequences import Family, Level, draw_errors, solve_all


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every family; writes `tradeoff` and `front`."""
    problem, conclusions = replace(scene.problem, march="modal", step=None), list[str]()
    if not problem.earliest:
        problem = replace(problem, times=np.array([0.01, 0.1, 1.0]))
    fields = ["family", "setting", "unknowns", "seconds", "error", "estimate", "remark"]
    table = Table(out / "tradeoff.csv", fields)
    solve_all(families(problem, options.quick), table, conclusions)
    rows = pd.DataFrame(table.rows, columns=fields).dropna(subset="error")
    front = find_front(rows)
    front.to_csv(out / "front.csv", index=False)
    by_family = dict(iter(rows.groupby("family", sort=False)))
    curves = {
        name: (of_name.seconds, of_name.error)
        for name, of_name in (by_family | {"Pareto front": front}).items()
    }
    panels = {"seconds for the whole history, one thread": curves}
    ylabel = "relative error of the indentation over all times"
    draw_errors(out / "tradeoff.png", panels, ylabel)
    conclusions.append(f"Measured on {platform.platform()}, one thread of {os.cpu_count()}.")
    return conclusions


def families(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield the settings of each method, from fast to accurate."""
    # the indentation alone: no fields are sampled while the clock runs
    problem = replace(problem, steady=False, quantities=frozenset(["indentation"]))
    exact = exact_indentation(problem)
    dial = (1e-2, 1e-4) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    quads, gmsh = FemAccuracy(mesher="quads"), FemAccuracy(mesher="gmsh", degree=4)
    settings: dict[str, dict[str, dict[str, Any]]] = {
        "mdr": {f"rtol {rtol:.0e}": {"rtol": rtol} for rtol in dial},
        "bem": {f"rtol {rtol:.0e}": {"rtol": rtol} for rtol in dial},
        "fem quads": {f"rtol {rtol:.0e}": {"rtol": rtol, "fem": quads} for rtol in dial},
        "fem P4": {f"rtol {rtol:.0e}": {"rtol": rtol, "fem": gmsh} for rtol in dial},
        "mdr implicit": {
            f"step {step:g}": {"march": "implicit", "step": step} for step in (0.1, 0.01, 0.001)
        },
        "mdr-grid": {
            f"n = {count}": {"mdr": MdrAccuracy(grid=count)}
            for count in ((100, 200) if quick else (100, 200, 400))
        },
    }
    for name, changes in settings.items():
        yield Family(
            name,
            [
                Level(
                    setting,
                    partial(measure, name.split()[0], replace(problem, **change), exact, quick),
                )
                for setting, change in changes.items()
            ],
        )


def measure(name: str, problem: Problem, exact: Array, quick: bool) -> Row:
    """Measure seconds (the least of five repeats, or one), error and the method's estimate."""
    seconds = []
    for _ in range(2 if quick else 6):
        start = time.perf_counter()
        solution = method(name).solve(problem, Stages(name))
        seconds.append(time.perf_counter() - start)
    return {
        "unknowns": solution.unknowns,
        "seconds": min(seconds[1:]),  # the first is a warm-up
        "error": float(np.abs(solution.results["indentation"] / exact - 1).max()),
        "estimate": float(solution.errors["indentation"].max()),
    }


def find_front(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows than which none is faster and as accurate, the fastest first."""
    rows = rows.sort_values("seconds")
    return rows[rows.error < rows.error.cummin().shift(fill_value=np.inf)]
