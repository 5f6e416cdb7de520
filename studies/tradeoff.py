"""The trade itself: error against seconds for every method and family of settings, measured on this machine.

Errors are those of the indentation over the scene's times, relative, against an MDR far more accurate than anything
measured here; seconds are of one whole history (mesh, assembly, condensation, all times), the least of some repeats
after a warm-up, on one thread. The error is not computed while the clock runs.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.radial import Array
from ringwear.studies.benchmark.study import best, reference_indentation, silent_stages
from ringwear.studies.crosscheck.dataset import versions
from ringwear.studies.figures.run import _figure
from ringwear.studies.methods.outcome import estimated
from ringwear.studies.methods.radial import MODELS
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.wear.archard import Wear
from threadpoolctl import threadpool_limits

FIELDS = ("method", "setting", "unknowns", "seconds", "error", "estimate")
MARKERS = "os^Dv<>Pxh*"


@dataclass(frozen=True)
class Point:
    """One setting of one family; a failure has its reason as the setting and no numbers."""

    method: str
    setting: str
    unknowns: int
    seconds: float
    error: float
    estimate: float


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Measure every family; writes `tradeoff.csv`, `.png`, `.md` and what it ran on, `tradeoff.json`."""
    if not any(scene.wear.times):
        scene = scene.changed(wear__times=[0.01, 0.1, 1.0])
    repeats = 1 if options.quick else 3
    points: list[Point] = []
    try:
        with threadpool_limits(1):
            exact = reference_indentation(scene.natural, scene.natural.times)
            for method, setting, natural in families(scene, bool(options.quick)):
                report(f"trade   {method} {setting} ...")
                points.append(measure(method, setting, natural, exact, repeats))
            report("trade   paper's algorithm ...")
            points += paper_points(scene.natural, exact, (100, 200) if options.quick else (100, 200, 400, 800))
    finally:
        # what was measured before an interruption is kept
        _write(points, out)
    draw(points, scene, out / "tradeoff.png")
    advice = recommend(points)
    (out / "tradeoff.md").write_text(_markdown(advice), "utf-8")
    (out / "tradeoff.json").write_text(json.dumps(machine(), indent=1) + "\n", "utf-8")
    failures = [f"failed: {point.method} {point.setting}" for point in points if not np.isfinite(point.error)]
    return [f"to get {tolerance:.0e} choose {point.method} ({point.setting}): {point.seconds:.3f} s, error {point.error:.1e}"
            for tolerance, point in advice] + failures  # fmt: skip


def families(scene: Scene, quick: bool) -> Iterator[tuple[str, str, NaturalScene]]:
    """Every (family, setting, scene) of the dial."""
    dial = (1e-2, 1e-4) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    for rtol in dial:
        for method in ("mdr", "bem"):
            yield method, f"rtol {rtol:.0e}", scene.changed(methods=[method], accuracy__rtol=rtol).natural
        yield "fem quads", f"rtol {rtol:.0e}", scene.changed(methods=["fem"], accuracy__rtol=rtol).natural
        for degree in (2, 3, 4):
            if degree == 2 and rtol < 1e-5:
                continue
            changed = scene.changed(methods=["fem"], accuracy__rtol=rtol, accuracy__fem={"mesher": "gmsh", "degree": degree})
            yield f"fem P{degree}", f"rtol {rtol:.0e}", changed.natural
    for truncation in (5, 20) if quick else (5, 20, 100, 1000):
        fixed = {"far_field": "fixed", "truncation": float(truncation)}
        yield "fem fixed", f"R = {truncation} a", scene.changed(methods=["fem"], accuracy__fem=fixed).natural
    for march in ("implicit", "explicit"):
        for step in (0.1, 0.01) if quick else (0.1, 0.03, 0.01, 0.003):
            # the explicit march is only stable on a mesh that is not graded: the rim is left coarse for it
            sizes = {"rim_size": 0.02, "ring_size": 0.02, "degree": 2} if march == "explicit" else {}
            wear = {"march": march, "step": step * scene.natural.time, "times": scene.wear.times}
            changed = scene.changed(methods=["mdr"], wear=wear, accuracy__mdr=sizes)
            yield f"mdr {march}", f"step {step:g}", changed.natural


def measure(method: str, setting: str, natural: NaturalScene, exact: Array, repeats: int) -> Point:
    """Seconds, error and own estimate of one setting."""
    name = natural.scene.methods[0]
    asked = natural.scene.wear

    def history() -> Array:
        model = MODELS[name](natural, silent_stages(), twins=False)
        wear = Wear(model.compliance, natural.phases[1], natural.earliest)
        return wear.history(natural.times, asked.march, natural.step).indentation

    try:
        seconds = best(history, repeats)
        error = float(np.abs(history() / exact - 1).max())
        model = MODELS[name](natural, silent_stages())
        _, errors, _, _ = estimated(natural, model)
        return Point(method, setting, model.unknowns, seconds, error, float(errors.indentation.max()))
    except RingwearError as failure:
        return Point(method, f"{setting}: {failure}", 0, np.nan, np.nan, np.nan)


def paper_points(natural: NaturalScene, exact: Array, counts: tuple[int, ...]) -> list[Point]:
    """The paper's algorithm at half its stability limit; its estimate is the difference to half the points."""
    from ringwear.mdr.uniform_grid import PaperGrid

    edges, wear = natural.phases
    points, coarser = [], None
    for count in counts:
        step = PaperGrid(edges, wear, count).stability_limit() / 2
        march: Callable[[], Array] = partial(_paper_history, edges, wear, count, natural.times, step)
        found = march()
        estimate = np.nan if coarser is None else float(np.abs(coarser / found - 1).max())
        points.append(
            Point("paper", f"n = {count}", count, best(march, 1), float(np.abs(found / exact - 1).max()), estimate)
        )
        coarser = found
    return points


def _paper_history(edges: Array, wear: Array, count: int, times: Array, step: float) -> Array:
    from ringwear.mdr.uniform_grid import PaperGrid

    return PaperGrid(edges, wear, count).march(times, step)[2]


def recommend(points: list[Point]) -> list[tuple[float, Point]]:
    """The cheapest setting that reached each power of ten."""
    advice = []
    for power in range(2, 11):
        reached = [point for point in points if point.error <= 10.0**-power]
        if reached:
            advice.append((10.0**-power, min(reached, key=lambda point: point.seconds)))
        fem = [point for point in reached if point.method.startswith("fem")]
        if fem:
            advice.append((10.0**-power, min(fem, key=lambda point: point.seconds)))
    return list(dict.fromkeys(advice))


def _markdown(advice: list[tuple[float, Point]]) -> str:
    lines = [
        "| to get | choose | setting | it costs | its error | its own estimate |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {tolerance:.0e} | {p.method} | {p.setting} | {p.seconds:.3f} s | {p.error:.1e} | {p.estimate:.1e} |"
        for tolerance, p in advice
    ]
    return "\n".join([*lines, "", "Relative error of the indentation over all times; the cheapest of all, and of FEM.", ""])


def machine() -> dict[str, Any]:
    """What the seconds were measured on."""
    return {"machine": platform.machine(), "system": platform.platform(), "python": platform.python_version(),
            "cores": os.cpu_count(), "threads": 1, "versions": versions()}  # fmt: skip


def _write(points: list[Point], out: Path) -> None:
    with (out / "tradeoff.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(FIELDS)
        writer.writerows([getattr(point, name) for name in FIELDS] for point in points)


def draw(points: list[Point], scene: Scene, path: Path) -> None:
    """Work against precision, a line for each family."""
    figure = _figure(7.5, 5.2)
    axes = figure.subplots()
    names = list(dict.fromkeys(point.method for point in points))
    for name, marker in zip(names, MARKERS, strict=False):
        line = [point for point in points if point.method == name and np.isfinite(point.error)]
        axes.loglog([p.error for p in line], [p.seconds for p in line], marker=marker, markersize=4, linewidth=1, label=name)
    axes.invert_xaxis()
    axes.set_xlabel("relative error of the indentation over all times")
    axes.set_ylabel("seconds for the whole history, one thread")
    axes.grid(which="major", color="0.9")
    axes.legend(frameon=False, fontsize=8, ncols=2)
    figure.suptitle(f"{scene.title}: what accuracy costs", fontsize=10)
    figure.savefig(path)
