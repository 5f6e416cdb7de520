"""What accuracy costs, as ratios within one run, against the paper's algorithm and a bare
factorisation.

Times are printed, never asserted; linear algebra runs on one thread.
"""

import argparse
import resource
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from scipy.sparse import csc_matrix, tril
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from ...fem.condensation import SYMMETRIC, cholmod_matrix, solver
from ..measured import best, exact, indentation, measured
from ..methods import fem
from ..methods.quantities import array
from ..problem.problem import Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..progress import LOG, Stages
from ..tables import Row, Table
from ..wear.full_contact import RunningIn

FIELDS = ("case", "unknowns", "seconds", "error", "remark")
Rows = Iterator[Row]


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Measure every comparison; writes `benchmark.csv`."""
    problem, table = (
        replace(scene.problem, march="modal", step=None),
        Table(out / "benchmark.csv", FIELDS),
    )
    with threadpool_limits(1):
        for part in (histories, fem_stages, many_rings):
            LOG.info("   bench  %s ...", part.__name__.replace("_", " "))
            for row in part(problem, options.quick):
                table.add(**row)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return [table.markdown(), f"peak memory {memory:.2f} GiB"]


def histories(problem: Problem, quick: bool) -> Rows:
    """Whole histories to t = 5 against the paper's algorithm."""
    times, count = np.array([0.01, 0.1, 0.3, 1.0, 3.0, 5.0]), 100 if quick else 400
    problem = replace(problem, times=times, mdr=MdrAccuracy(grid=count))
    known = array(exact(problem), "indentation")
    paper = measured("mdr-grid", problem, known, quick)
    yield {"case": f"paper's algorithm, n = {count}, explicit", **paper}
    for name, rtol in (("fem", 1e-3), ("fem", 1e-4), ("mdr", 1e-4), ("mdr", 1e-6)):
        own = measured(name, replace(problem, rtol=rtol), known, quick)
        remark = (
            f"{paper['seconds'] / own['seconds']:.1f} x as fast, error "
            f"{paper['error'] / own['error']:.0f} x smaller"
        )
        yield {"case": f"{name} history, rtol {rtol:g}", "remark": remark, **own}


def fem_stages(problem: Problem, quick: bool) -> Rows:
    """The finite-element history stage by stage, against one bare factorisation of the same matrix
    and one mesh.
    """
    times = np.geomspace(0.01, 20, 12)
    meshers = FemAccuracy(mesher="quads"), FemAccuracy(mesher="gmsh")
    for sizes, rtol in product(meshers, (1e-4,) if quick else (1e-4, 1e-5, 1e-6)):
        asked = replace(problem, rtol=rtol, fem=sizes)
        seconds = dict.fromkeys(("meshing", "assembling", "condensing", "modes"), np.inf)
        for _ in range(2 if quick else 6):
            stages = Stages("bench")
            ready = fem.METHOD.discretise(asked, stages)
            with stages("modes"):
                RunningIn(ready.compliance, problem.merged.wear_coefficients).modal(times)
            seconds = {name: min(seconds[name], stages.seconds[name]) for name in seconds}
        assert ready.half_space is not None
        whole, bare = (
            sum(seconds.values()),
            best(partial(bare_factorisation, ready.half_space.system), quick),
        )
        remark = {
            "whole history": f"{whole / (4 * bare + seconds['meshing']):.2f} x "
            "(4 bare factorisations + 1 mesh)"
        }
        seconds |= {f"bare factorisation ({solver()})": bare, "whole history": whole}
        for name, value in seconds.items():
            case = f"fem {sizes.mesher} rtol {rtol:g}, {name}"
            yield {
                "case": case,
                "unknowns": ready.unknowns,
                "seconds": value,
                "remark": remark.get(name, ""),
            }


def bare_factorisation(system: csc_matrix) -> None:
    """Factorise a stiffness as it comes, by the solver in use: order, analyse, factorise."""
    if solver() == "cholmod":
        from kvxopt import cholmod

        matrix = cholmod_matrix(tril(system, format="coo"))
        cholmod.numeric(matrix, cholmod.symbolic(matrix))
    else:
        splu(system, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC)


def many_rings(problem: Problem, quick: bool) -> Rows:
    """Many rings against five, at the same accuracy."""
    seconds = dict[int, float]()
    for count in (5, 64) if quick else (5, 64, 256):
        many = replace(problem, rings=Rings.alternating(count, 1.0, 10.0), rtol=1e-4)
        unknowns = fem.METHOD.discretise(many, Stages("bench")).unknowns
        seconds[count] = best(partial(indentation, "fem", many), quick or count > 100)
        remark = f"{seconds[count] / seconds[5]:.0f} x the cost of 5 rings"
        yield {
            "case": f"{count} rings, rtol 1e-4",
            "unknowns": unknowns,
            "seconds": seconds[count],
            "remark": remark,
        }
