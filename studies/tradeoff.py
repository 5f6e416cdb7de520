"""The trade itself: error against seconds for every method and family of settings, measured on this machine.

Errors are those of the indentation over the scene's times, relative, against an MDR far more accurate than anything
measured here; seconds are of one whole history (mesh, assembly, condensation, all times), the least of some repeats
after a warm-up, on one thread. Nothing is logged and no error is estimated while the clock runs.
"""

from __future__ import annotations

import argparse
import logging
import os
import platform
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ringwear.mdr.uniform_grid import UniformGrid
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.radial import Array
from ringwear.studies.benchmark.study import FINE, best
from ringwear.studies.crosscheck.dataset import versions
from ringwear.studies.figures.style import curve, legend_below, new_figure
from ringwear.studies.methods.base import method
from ringwear.studies.methods.by_compliance import ComplianceMethod
from ringwear.studies.methods.quantities import array, error_name
from ringwear.studies.problem.defaults import grid_step
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.scene import Scene
from ringwear.studies.problem.sections import FemAccuracy, MdrAccuracy
from ringwear.studies.progress import LOG, Stages
from ringwear.studies.tables import Table, keeping_rows, write_page
from ringwear.studies.wear.archard import RunningIn

Row = Mapping[str, Any]
FIELDS = ("family", "setting", "unknowns", "seconds", "error", "estimate", "remark")
DIALLED = ("fem quads", "mdr")  # the families of the dial
RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
TRUNCATIONS, STEPS, GRIDS = (5, 20, 100, 1000), (0.1, 0.01, 0.001), (100, 200, 400)
# the explicit march is only stable on a mesh that is not graded: the rim is left coarse for it
MARCHED = {"implicit": MdrAccuracy(), "explicit": MdrAccuracy(degree=2, rim_size=0.02, ring_size=0.02)}


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every family; writes `tradeoff.csv`, `dial.csv`, `front*.csv`, `tradeoff.md` and `tradeoff.png`."""
    quick = bool(options.quick)
    problem = replace(scene.problem, march="modal", step=None)
    if not problem.earliest:
        problem = replace(problem, times=np.array([0.01, 0.1, 1.0]))
    conclusions, table = list[str](), Table(out / "tradeoff.csv", FIELDS)
    with keeping_rows(conclusions), threadpool_limits(1):
        exact = indentation("mdr", replace(problem, rtol=1e-7, mdr=FINE))
        for name, family, setting, asked in settings(problem, quick):
            LOG.info("   trade  %s, %s ...", family, setting)
            table.add(family=family, setting=setting, **measured(name, asked, exact, quick))
    rows = [row for row in table.rows if "error" in row]
    front, of_elements = pareto_front(rows), pareto_front(row for row in rows if row["family"].startswith("fem"))
    LOG.info("   trade  drawing ...")
    draw(rows, front, f"{scene.title}: what accuracy costs", out / "tradeoff.png")
    conclusions += [f"Failed: {row['family']}, {row['setting']}: {row['remark']}" for row in table.rows if "remark" in row]
    software = ", ".join(f"{name} {version}" for name, version in versions().items())
    conclusions.append(f"Measured on {platform.platform()}, one thread of {os.cpu_count()}, with {software}.")
    tables = {
        "By the accuracy asked for": Table(out / "dial.csv", FIELDS, (row for row in rows if row["family"] in DIALLED)),
        "Pareto front": Table(out / "front.csv", FIELDS, front),
        "Pareto front of finite elements": Table(out / "front_fem.csv", FIELDS, of_elements),
    }
    write_page(out / "tradeoff.md", "What accuracy costs", conclusions, tables)
    return [*conclusions, *(f"{heading}\n{part.markdown()}" for heading, part in tables.items())]


def settings(problem: Problem, quick: bool) -> Iterator[tuple[str, str, str, Problem]]:
    """Method, family, setting, and the problem that asks for it."""
    few = 2 if quick else None
    for rtol in RTOLS[:3:2] if quick else RTOLS:
        asked = replace(problem, rtol=rtol)
        for name in ("mdr", "bem"):
            yield name, name, f"rtol {rtol:.0e}", asked
        yield "fem", "fem quads", f"rtol {rtol:.0e}", replace(asked, fem=FemAccuracy(mesher="quads"))
        for degree in (2, 3, 4):
            yield "fem", f"fem P{degree}", f"rtol {rtol:.0e}", replace(asked, fem=FemAccuracy(mesher="gmsh", degree=degree))
    for radius in TRUNCATIONS[:few]:
        fixed = FemAccuracy(far_field="fixed", truncation=radius)
        yield "fem", "fem fixed", f"R = {radius} a", replace(problem, fem=fixed)
    for march, sizes in MARCHED.items():
        for step in STEPS[:few]:
            yield "mdr", f"mdr {march}", f"step {step:g}", replace(problem, march=march, step=step, mdr=sizes)
    for count in GRIDS[:few]:
        yield "mdr-grid", "mdr-grid", f"n = {count}", replace(problem, mdr=MdrAccuracy(grid=count))


def indentation(name: str, problem: Problem) -> Array:
    """The history by a method, without its estimate."""
    one = method(name)
    if not isinstance(one, ComplianceMethod):
        grid = UniformGrid(*problem.merged, problem.mdr.grid)
        return grid.march(problem.times, grid_step(problem, grid.stability_limit()))[2]
    made = one.discretised(problem, Stages(name), pairs=False)
    wear = RunningIn(made.compliance, problem.merged.wear_coefficients, problem.earliest)
    return wear.history(problem.times, problem.march, problem.step).indentation


def measured(name: str, problem: Problem, exact: Array, quick: bool) -> Row:
    """Seconds, error and own estimate of one setting, or the reason why it failed."""
    logging.disable(logging.INFO)
    try:
        seconds = best(partial(indentation, name, problem), quick)
        error = float(np.abs(indentation(name, problem) / exact - 1).max())
        solution = method(name).solve(problem, Stages(name))
    except RingwearError as failure:
        return {"remark": str(failure)}
    finally:
        logging.disable(logging.NOTSET)
    estimate = float(array(solution.results, error_name("indentation")).max())
    return {"unknowns": solution.unknowns, "seconds": seconds, "error": error, "estimate": estimate}


def pareto_front(rows: Iterable[Row]) -> list[Row]:
    """Rows than which none is faster and as accurate (to a tenth), the fastest first."""
    front: list[Row] = []
    for row in sorted(rows, key=lambda row: float(row["seconds"])):
        if not front or row["error"] < 0.9 * front[-1]["error"]:
            front.append(row)
    return front


def draw(rows: list[Row], front: list[Row], title: str, path: Path) -> None:
    """Work against precision, a line for each family, and the Pareto front behind."""
    figure = new_figure(7.5, 5.6)
    axes = figure.subplots()
    for number, family in enumerate(["Pareto front", *dict.fromkeys(row["family"] for row in rows)]):
        points = [row for row in rows if row["family"] == family] if number else front
        look = curve(number) if number else {"color": "0.85", "linewidth": 5}
        axes.loglog([row["error"] for row in points], [row["seconds"] for row in points], label=family, **look)
    axes.invert_xaxis()
    axes.set(xlabel="relative error of the indentation over all times", ylabel="seconds for the whole history, one thread")
    axes.grid(which="major", color="0.9")
    legend_below(axes, ncols=4)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)
