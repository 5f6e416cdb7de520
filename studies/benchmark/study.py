"""What accuracy costs: seconds as ratios within one run, against the paper's algorithm, a bare factorisation, and
scikit-fem used plainly. Times are printed, never asserted; linear algebra runs on one thread.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import tril
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from ringwear.meshes.radial import Array, alternating_edges
from ringwear.studies.benchmark.plain_fem import plain_history
from ringwear.studies.methods import fem, mdr
from ringwear.studies.methods.by_compliance import ComplianceMethod
from ringwear.studies.problem.problem import Problem, Rings
from ringwear.studies.problem.scene import Scene
from ringwear.studies.problem.sections import FemAccuracy, MdrAccuracy
from ringwear.studies.progress import LOG, Stages
from ringwear.studies.tables import Table
from ringwear.studies.wear.archard import RunningIn

FIELDS = ("case", "unknowns", "seconds", "error", "remark")
FINE = MdrAccuracy(degree=9, ring_size=1e-5, rim_size=1e-8)


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every comparison; writes `benchmark.csv`."""
    table = Table(out / "benchmark.csv", FIELDS)
    with threadpool_limits(1):
        for part in (histories, output_times, fem_stages, many_rings, growth, plain_finite_elements):
            LOG.info("   bench  %s ...", part.__name__.replace("_", " "))
            part(scene.problem, table, bool(options.quick))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return [*map(_line, table.rows), f"peak memory {memory:.2f} GiB"]


def _line(row: Any) -> str:
    error = f"{row['error']:.1e}" if "error" in row else ""
    return f"{row['case']:<52}{row['unknowns']:>9} {row['seconds']:>10.4f} s {error:>9}  {row.get('remark', '')}"


def best(action: Callable[[], Any], quick: bool) -> float:
    """Least seconds of five calls, or of one, after a warm-up."""
    action()
    seconds = []
    for _ in range(1 if quick else 5):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def indentation(method: ComplianceMethod, problem: Problem, times: Array) -> tuple[Array, int]:
    """Indentation at non-dimensional times, without estimates, and the number of unknowns."""
    made = method.discretised(problem, Stages("bench"), pairs=False)
    wear = RunningIn(made.compliance, problem.merged.wear_coefficients, float(times[times > 0].min()))
    return wear.modal(times).indentation, made.unknowns


def error_of(values: Array, problem: Problem, times: Array) -> float:
    """Greatest relative error, against an MDR far below the errors compared here."""
    exact, _ = indentation(mdr.METHOD, replace(problem, rtol=1e-7, mdr=FINE), times)
    return float(np.abs(values / exact[: len(values)] - 1).max())


def histories(problem: Problem, table: Table, quick: bool) -> None:
    """Whole histories to t = 5 against the paper's algorithm."""
    from ringwear.mdr.uniform_grid import UniformGrid

    times = np.array([0.001, 0.01, 0.03, 0.1, 0.3, 0.5]) * 10
    count = 100 if quick else 400

    def paper() -> Array:
        grid = UniformGrid(*problem.merged, count)
        return grid.march(times, grid.stability_limit() / 2)[2]

    seconds, error = best(paper, quick), error_of(paper(), problem, times)
    table.add(case=f"paper's algorithm, n = {count}, explicit", unknowns=count, seconds=seconds, error=error)
    for method, rtol in ((fem.METHOD, 1e-3), (fem.METHOD, 1e-4), (mdr.METHOD, 1e-4), (mdr.METHOD, 1e-6)):
        at_rtol = replace(problem, rtol=rtol)
        own = best(partial(indentation, method, at_rtol, times), quick)
        values, unknowns = indentation(method, at_rtol, times)
        own_error = error_of(values, problem, times)
        remark = f"{seconds / own:.1f} x as fast, error {error / own_error:.0f} x smaller"
        case = f"{method.name} history, rtol {rtol:g}"
        table.add(case=case, unknowns=unknowns, seconds=own, error=own_error, remark=remark)


def output_times(problem: Problem, table: Table, quick: bool) -> None:
    """A thousand output times against ten."""
    few, many = (
        best(partial(indentation, mdr.METHOD, problem, np.geomspace(0.01, 20, count)), quick) for count in (10, 1000)
    )
    table.add(case="mdr history, 10 times", unknowns=0, seconds=few)
    table.add(case="mdr history, 1000 times", unknowns=0, seconds=many, remark=f"{many / few:.2f} x the cost of ten")


def fem_stages(problem: Problem, table: Table, quick: bool) -> None:
    """The finite-element history stage by stage, against one bare factorisation of the same matrix and one mesh."""
    from ringwear.fem.condensation import solver

    times = np.geomspace(0.01, 20, 12)
    for mesher in ("quads", "gmsh"):
        for rtol in (1e-4,) if quick else (1e-4, 1e-5, 1e-6):
            at_rtol = replace(problem, rtol=rtol, fem=FemAccuracy(mesher=mesher))
            seconds = dict.fromkeys(("meshing", "assembling", "condensing", "modes"), np.inf)
            for _ in range(2 if quick else 6):
                stages = Stages("bench")
                made = fem.METHOD.discretised(at_rtol, stages, pairs=False)
                with stages("modes"):
                    history = RunningIn(made.compliance, problem.merged.wear_coefficients).modal(times)
                seconds = {name: min(seconds[name], stages.seconds[name]) for name in seconds}
            assert made.half_space is not None
            bare = best(partial(bare_factorisation, made.half_space.system), quick)
            name = f"fem {mesher} rtol {rtol:g}"
            for stage, value in (seconds | {f"bare factorisation ({solver()})": bare}).items():
                table.add(case=f"{name}, {stage}", unknowns=made.unknowns, seconds=value)
            total, error = sum(seconds.values()), error_of(history.indentation, problem, times)
            remark = f"{total / (4 * bare + seconds['meshing']):.2f} x (4 bare factorisations + 1 mesh)"
            case = f"{name}, whole history"
            table.add(case=case, unknowns=made.unknowns, seconds=total, error=error, remark=remark)


def bare_factorisation(system: Any) -> None:
    """Factorise a stiffness as it comes, by the solver in use: order, analyse, factorise."""
    from ringwear.fem.condensation import SYMMETRIC, cholmod_matrix, solver

    if solver() == "cholmod":
        from kvxopt import cholmod

        matrix = cholmod_matrix(tril(system, format="coo"))
        cholmod.numeric(matrix, cholmod.symbolic(matrix))
    else:
        splu(system, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC)


def many_rings(problem: Problem, table: Table, quick: bool) -> None:
    """Many rings against five, at the same accuracy."""
    first = np.nan
    for count in (5, 64) if quick else (5, 64, 256):
        rings = Rings(alternating_edges(count), np.where(np.arange(count) % 2, 1.0, 0.1))
        many = replace(problem, rings=rings, rtol=1e-4)
        seconds = best(partial(indentation, fem.METHOD, many, problem.times), quick or count > 100)
        first = seconds if np.isnan(first) else first
        unknowns = indentation(fem.METHOD, many, problem.times)[1]
        remark = f"{seconds / first:.0f} x the cost of 5 rings"
        table.add(case=f"{count} rings, rtol 1e-4", unknowns=unknowns, seconds=seconds, remark=remark)


def growth(problem: Problem, table: Table, quick: bool) -> None:
    """Cost against unknowns, by halving the growth of the element size; the exponent between the ends."""
    seconds, unknowns = [], []
    for rate in (0.8, 0.4) if quick else (0.8, 0.4, 0.2, 0.12):
        sizes = FemAccuracy(mesher="gmsh", growth=rate, rim_size=1e-5, ring_size=1e-3)
        start = time.perf_counter()
        unknowns.append(indentation(fem.METHOD, replace(problem, fem=sizes), problem.times)[1])
        seconds.append(time.perf_counter() - start)
        exponent = np.log(seconds[-1] / seconds[0]) / np.log(unknowns[-1] / unknowns[0]) if len(seconds) > 1 else np.nan
        remark = f"cost grows as unknowns^{exponent:.2f}" if len(seconds) > 1 else ""
        table.add(case=f"fem, growth {rate:g}", unknowns=unknowns[-1], seconds=seconds[-1], remark=remark)


def plain_finite_elements(problem: Problem, table: Table, quick: bool) -> None:
    """scikit-fem as its examples use it, with a clamped boundary at 20 a, solved again at every step."""
    steps, size = (5, 4000) if quick else (20, 20_000)
    times = np.linspace(0.05, 5, 1000)
    plain = plain_history(problem, size, times[:steps])
    whole = plain.seconds_before + plain.seconds_per_step * len(times)
    plain_error = error_of(plain.indentation, problem, times)
    case = f"plain scikit-fem, {steps} of 1000 steps, extrapolated"
    table.add(case=case, unknowns=plain.unknowns, seconds=whole, error=plain_error)
    start = time.perf_counter()
    values, unknowns = indentation(fem.METHOD, replace(problem, rtol=1e-5), times)
    seconds, error = time.perf_counter() - start, error_of(values, problem, times)
    remark = f"{whole / seconds:.0f} x as fast for 1000 steps, error {plain_error / error:.0f} x smaller"
    table.add(case="ours, rtol 1e-5, 1000 times", unknowns=unknowns, seconds=seconds, error=error, remark=remark)
