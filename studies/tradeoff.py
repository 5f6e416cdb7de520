"""The trade itself.

Error against seconds for every method and family of settings, measured on this machine.

Errors are those of the indentation over the scene's times, relative, against an MDR far more
accurate than anything measured here; seconds are of one whole history (mesh, assembly,
condensation, all times), the least of some repeats after a warm-up, on one thread. No error is
estimated while the clock runs.
"""

import argparse
import os
import platform
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from .figures.style import curve, legend_below, new_figure
from .measured import exact, measured
from .methods.quantities import array
from .problem.problem import Problem
from .problem.scene import Scene
from .problem.sections import FemAccuracy, MdrAccuracy
from .progress import LOG, progress
from .tables import Row, Table, keeping_rows, write_page

FIELDS = ("family", "setting", "unknowns", "seconds", "error", "estimate", "remark")
DIALLED = ("fem quads", "mdr")  # the families of the dial
# the explicit march is only stable on a mesh that is not graded: the rim is left coarse for it
MARCHED = {
    "implicit": MdrAccuracy(),
    "explicit": MdrAccuracy(degree=2, rim_size=0.02, ring_size=0.02),
}


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every family.

    Writes `tradeoff.csv`, `dial.csv`, `front*.csv`, `tradeoff.md` and `tradeoff.png`.
    """
    problem, conclusions = replace(scene.problem, march="modal", step=None), list[str]()
    if not problem.earliest:
        problem = replace(problem, times=np.array([0.01, 0.1, 1.0]))
    table = Table(out / "tradeoff.csv", FIELDS)
    with keeping_rows(conclusions), threadpool_limits(1):
        LOG.info("   trade  reference ...")
        known = array(exact(problem), "indentation")
        every = list(settings(problem, options.quick))
        for name, family, setting, asked in progress(
            every, "trade", lambda one: f"{one[1]}, {one[2]}"
        ):
            table.add(family=family, setting=setting, **measured(name, asked, known, options.quick))
    rows = [row for row in table.rows if "error" in row]
    front, of_elements = (
        pareto_front(rows),
        pareto_front(row for row in rows if row["family"].startswith("fem")),
    )
    draw(rows, front, f"{scene.title}: what accuracy costs", out / "tradeoff.png")
    conclusions += [
        f"Failed: {row['family']}, {row['setting']}: {row['remark']}"
        for row in table.rows
        if "remark" in row
    ]
    conclusions.append(f"Measured on {platform.platform()}, one thread of {os.cpu_count()}.")
    tables = {
        "By the accuracy asked for": Table(
            out / "dial.csv", FIELDS, (row for row in rows if row["family"] in DIALLED)
        ),
        "Pareto front": Table(out / "front.csv", FIELDS, front),
        "Pareto front of finite elements": Table(out / "front_fem.csv", FIELDS, of_elements),
    }
    write_page(out / "tradeoff.md", "What accuracy costs", conclusions, tables)
    return [*conclusions, *(f"{heading}\n{part.markdown()}" for heading, part in tables.items())]


def settings(problem: Problem, quick: bool) -> Iterator[tuple[str, str, str, Problem]]:
    """Method, family, setting, and the problem that asks for it."""
    few = 2 if quick else None
    for rtol in (1e-2, 1e-4) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        asked = replace(problem, rtol=rtol)
        for name in ("mdr", "bem"):
            yield name, name, f"rtol {rtol:.0e}", asked
        yield (
            "fem",
            "fem quads",
            f"rtol {rtol:.0e}",
            replace(asked, fem=FemAccuracy(mesher="quads")),
        )
        for degree in (2, 3, 4):
            yield (
                "fem",
                f"fem P{degree}",
                f"rtol {rtol:.0e}",
                replace(asked, fem=FemAccuracy(mesher="gmsh", degree=degree)),
            )
    for radius in (5, 20, 100, 1000)[:few]:
        fixed = FemAccuracy(far_field="fixed", truncation=radius)
        yield "fem", "fem fixed", f"R = {radius} a", replace(problem, fem=fixed)
    for march, sizes in MARCHED.items():
        for step in (0.1, 0.01, 0.001)[:few]:
            yield (
                "mdr",
                f"mdr {march}",
                f"step {step:g}",
                replace(problem, march=march, step=step, mdr=sizes),
            )
    for count in (100, 200, 400)[:few]:
        yield "mdr-grid", "mdr-grid", f"n = {count}", replace(problem, mdr=MdrAccuracy(grid=count))


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
    for number, family in enumerate(
        ["Pareto front", *dict.fromkeys(row["family"] for row in rows)]
    ):
        points = [row for row in rows if row["family"] == family] if number else front
        look = curve(number) if number else {"color": "0.85", "linewidth": 5}
        axes.loglog(
            [row["error"] for row in points],
            [row["seconds"] for row in points],
            label=family,
            **look,
        )
    axes.invert_xaxis()
    axes.set(
        xlabel="relative error of the indentation over all times",
        ylabel="seconds for the whole history, one thread",
    )
    axes.grid(which="major", color="0.9")
    legend_below(axes, ncols=4)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)
