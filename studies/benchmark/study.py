"""What accuracy costs: seconds as ratios within one run, against the paper's algorithm, a bare factorisation, and
scikit-fem used plainly. Times are printed, never asserted; linear algebra runs on one thread.
"""

from __future__ import annotations

import argparse
import csv
import resource
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.radial import Array
from ringwear.studies.methods.fem import discretised, fem_model, half_space_mesh
from ringwear.studies.methods.model import Model
from ringwear.studies.methods.radial import mdr_model
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages
from ringwear.studies.wear.archard import Wear
from scipy.sparse import tril
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace

FIELDS = ("case", "unknowns", "seconds", "error", "remark")
Row = dict[str, Any]


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Measure every comparison; writes `benchmark.csv`."""
    repeats = 1 if options.quick else 5
    rows: list[Row] = []
    with threadpool_limits(1):
        for part in (histories, output_times, fem_stages, many_rings, growth, plain_finite_elements):
            report(f"bench {part.__name__.replace('_', ' ')} ...")
            rows += part(scene, repeats, bool(options.quick))
    with (out / "benchmark.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        writer.writeheader()
        writer.writerows(rows)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return [_line(row) for row in rows] + [f"peak memory {memory:.2f} GiB"]


def _line(row: Row) -> str:
    error = f"{row['error']:.1e}" if row["error"] != "" else ""
    return f"{row['case']:<52}{row['unknowns']:>9} {row['seconds']:>10.4f} s {error:>9}  {row['remark']}"


def _row(case: str, unknowns: int, seconds: float, error: float | str = "", remark: str = "") -> Row:
    return dict(zip(FIELDS, (case, unknowns, seconds, error, remark), strict=True))


def best(action: Callable[[], Any], repeats: int) -> float:
    """Least seconds of some repeats, after a warm-up."""
    action()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def silent_stages() -> Stages:
    """Stages of a model that nobody watches."""
    return Stages("bench")


def reference_indentation(natural: NaturalScene, times: Array) -> Array:
    """Indentation by the MDR far below the errors compared here."""
    fine = natural.scene.changed(accuracy__rtol=1e-7, accuracy__mdr={"degree": 9, "ring_size": 1e-5, "rim_size": 1e-8})
    model = mdr_model(fine.natural, silent_stages())
    return Wear(model.compliance, natural.phases[1]).modal(times).indentation


def histories(scene: Scene, repeats: int, quick: bool) -> list[Row]:
    """Whole histories to t = 5 natural units (0.5 in the five-ring scene) against the paper's algorithm."""
    from ringwear.mdr.uniform_grid import PaperGrid

    times = np.array([0.001, 0.01, 0.03, 0.1, 0.3, 0.5]) * 10
    exact = reference_indentation(scene.natural, times)
    edges, wear = scene.natural.phases
    grid = PaperGrid(edges, wear, 100 if quick else 400)
    step = grid.stability_limit() / 2

    def paper() -> Array:
        return PaperGrid(edges, wear, grid.count).march(times, step)[2]

    paper_seconds = best(paper, repeats)
    error = float(np.abs(paper() / exact - 1).max())
    rows = [_row(f"paper's algorithm, n = {grid.count}, explicit", grid.count, paper_seconds, error)]
    for method, build, rtol in (
        ("fem", fem_model, 1e-3),
        ("fem", fem_model, 1e-4),
        ("mdr", mdr_model, 1e-4),
        ("mdr", mdr_model, 1e-6),
    ):
        natural = scene.changed(accuracy__rtol=rtol).natural

        def history(build: Callable[..., Model] = build, natural: NaturalScene = natural) -> tuple[Array, Model]:
            model = build(natural, silent_stages(), twins=False)
            return Wear(model.compliance, natural.phases[1]).modal(times).indentation, model

        seconds = best(history, repeats)
        indentation, model = history()
        error = float(np.abs(indentation / exact - 1).max())
        remark = f"{paper_seconds / seconds:.1f} x as fast, error {rows[0]['error'] / error:.0f} x smaller"
        rows.append(_row(f"{method} history, rtol {rtol:g}", model.unknowns, seconds, error, remark))
    return rows


def output_times(scene: Scene, repeats: int, _quick: bool) -> list[Row]:
    """A thousand output times against ten."""
    natural = scene.natural
    seconds = {}
    for count in (10, 1000):
        times = np.geomspace(0.01, 20, count)

        def history(times: Array = times) -> None:
            model = mdr_model(natural, silent_stages(), twins=False)
            Wear(model.compliance, natural.phases[1]).modal(times)

        seconds[count] = best(history, 3 * repeats)
    remark = f"{seconds[1000] / seconds[10]:.2f} x the cost of ten"
    return [
        _row(f"mdr history, {count} times", 0, value, "", remark if count == 1000 else "")
        for count, value in seconds.items()
    ]


def fem_stages(scene: Scene, repeats: int, quick: bool) -> list[Row]:
    """The finite-element history stage by stage, against one bare factorisation of the same matrix and one mesh."""
    rows = []
    for mesher in ("quads", "gmsh"):
        for rtol in (1e-4,) if quick else (1e-4, 1e-5, 1e-6):
            changed = scene.changed(methods=["fem"], accuracy__rtol=rtol, accuracy__fem__mesher=mesher)
            rows += _stages_of(f"fem {mesher} rtol {rtol:g}", changed.natural, repeats)
    return rows


def _stages_of(name: str, natural: NaturalScene, repeats: int) -> list[Row]:
    from ringwear.fem.condensation import solver

    meshed = half_space_mesh(natural)
    wear = natural.phases[1]

    def assembled() -> HalfSpace:
        made = discretised(natural, meshed)
        _ = made.lower_triangle
        return made

    made = assembled()
    compliance = made.compliance()
    seconds = {
        "mesh": best(partial(half_space_mesh, natural), repeats),
        "assembly": best(assembled, repeats),
        "modes": best(partial(_modes, compliance, wear), repeats),
    }
    # the factor is kept with the half-space: only a new one is condensed anew
    seconds["condensation"] = best(partial(_condensed, assembled), repeats) - seconds["assembly"]
    bare = best(partial(bare_factorisation, made.system), repeats)
    total = sum(seconds.values())
    times = np.geomspace(0.01, 20, 12)
    found = Wear(compliance, wear).modal(times).indentation
    error = float(np.abs(found / reference_indentation(natural, times) - 1).max())
    ratio = f"{total / (4 * bare + seconds['mesh']):.2f} x (4 bare factorisations + 1 mesh)"
    return [
        *(_row(f"{name}, {stage}", made.unknowns, value) for stage, value in seconds.items()),
        _row(f"{name}, bare factorisation ({solver()})", made.unknowns, bare),
        _row(f"{name}, whole history", made.unknowns, total, error, ratio),
    ]


def many_rings(scene: Scene, repeats: int, quick: bool) -> list[Row]:
    """Many rings against the scene's own few, at the same accuracy."""
    rows: list[Row] = []
    for rings in (5, 64) if quick else (5, 64, 256):
        punch = {"radius": 1.0, "rings": rings, "wear_coefficients": [1.0, 10.0]}
        natural = scene.changed(methods=["fem"], accuracy__rtol=1e-4, punch=punch).natural

        def history(natural: NaturalScene = natural) -> Model:
            model = fem_model(natural, silent_stages(), twins=False)
            _ = Wear(model.compliance, natural.phases[1], natural.earliest).modal(natural.times)
            return model

        seconds = best(history, repeats if rings < 100 else 1)
        remark = f"{seconds / rows[0]['seconds']:.0f} x the cost of {rows[0]['case']}" if rows else ""
        rows.append(_row(f"{rings} rings, rtol 1e-4", history().unknowns, seconds, remark=remark))
    return rows


def _modes(compliance: Compliance, wear: Array) -> Array:
    return Wear(compliance, wear).relaxation_times


def _condensed(half_space: Callable[[], Any]) -> Compliance:
    condensed: Compliance = half_space().compliance()
    return condensed


def bare_factorisation(system: Any) -> None:
    """Factorise a stiffness as it comes, by the solver in use: order, analyse, factorise."""
    from ringwear.fem.condensation import cholmod_matrix, solver

    if solver() == "cholmod":
        from kvxopt import cholmod

        matrix = cholmod_matrix(tril(system, format="coo"))
        cholmod.numeric(matrix, cholmod.symbolic(matrix))
    else:
        splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def growth(scene: Scene, _repeats: int, quick: bool) -> list[Row]:
    """Cost against unknowns, by halving the growth of the element size; the exponent between the ends."""
    rows = []
    for growth_rate in (0.8, 0.4) if quick else (0.8, 0.4, 0.2, 0.12):
        natural = scene.changed(
            accuracy__fem={"mesher": "gmsh", "growth": growth_rate, "rim_size": 1e-5, "ring_size": 1e-3}
        ).natural
        start = time.perf_counter()
        model = fem_model(natural, silent_stages(), twins=False)
        _ = Wear(model.compliance, natural.phases[1]).relaxation_times
        rows.append(_row(f"fem, growth {growth_rate:g}", model.unknowns, time.perf_counter() - start))
    first, last = rows[0], rows[-1]
    exponent = np.log(last["seconds"] / first["seconds"]) / np.log(last["unknowns"] / first["unknowns"])
    last["remark"] = f"cost grows as unknowns^{exponent:.2f}"
    return rows


def plain_finite_elements(scene: Scene, _repeats: int, quick: bool) -> list[Row]:
    """scikit-fem as its examples use it, with a clamped boundary at 20 a, solved again at every step."""
    from ringwear.studies.benchmark.plain_fem import plain_history

    steps, unknowns = (5, 4000) if quick else (20, 20_000)
    natural = scene.natural
    times = np.linspace(0.05, 5, 1000)
    exact = reference_indentation(natural, times)
    plain = plain_history(natural, unknowns, times[:steps])
    start = time.perf_counter()
    model = fem_model(natural.scene.changed(accuracy__rtol=1e-5).natural, silent_stages(), twins=False)
    ours = Wear(model.compliance, natural.phases[1]).modal(times).indentation
    seconds = time.perf_counter() - start
    error = float(np.abs(ours / exact - 1).max())
    plain_error = float(np.abs(plain.indentation / exact[:steps] - 1).max())
    whole = plain.seconds_before + plain.seconds_per_step * len(times)
    remark = f"{whole / seconds:.0f} x as fast for 1000 steps, error {plain_error / error:.0f} x smaller"
    return [
        _row(f"plain scikit-fem, {steps} of 1000 steps, extrapolated", plain.unknowns, whole, plain_error),
        _row("ours, rtol 1e-5, 1000 times", model.unknowns, seconds, error, remark),
    ]
