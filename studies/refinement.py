"""The mesh itself: uniform, graded by the recipe, and refined by the error indicator, each against what is known.

Errors are those of the flat punch's indentation (Eq. 10), of the indentation over the whole history against the MDR at
rtol 1e-7, and of the steady displacement in closed form. A mesh file of the user's is one more row, tested the same way.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from mdr.direct import greatest_displacement, steady_pressures
from meshes.errors import MeshError, RingwearError
from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array

from . import adaptive
from .contact import flat_start
from .levels import Table, keeping_rows, write_markdown
from .methods import mdr_model
from .outcome import Sampler
from .refinement_figures import ERRORS, FAMILIES, draw_errors, draw_meshes, draw_quality
from .scene import Scene
from .stages import Report, Stages
from .triangles import triangle_mesh
from .wear import Wear

GOAL = 1e-5
NARROW = 1e-3
START = 1.0  # element size of the uniform mesh that adaptation starts from
TIMES = np.geomspace(1e-3, 20, 12)
FIELDS = (
    "case", "mesh", "size or rtol", "unknowns", "triangles", "multipliers", *ERRORS, "greatest", "estimate",
    "least quality", "median quality", "seconds", "remark",
)  # fmt: skip


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Refine three ways on each case; writes `refinement.csv`, `refinement.md` and the figures."""
    table = Table(out / "refinement.csv", FIELDS)
    conclusions: list[str] = []
    best: dict[tuple[str, str], HalfSpaceMesh] = {}
    cases = _cases(scene)
    with threadpool_limits(1), keeping_rows(conclusions):
        for case in cases[::2] if options.quick else cases:
            for family, meshes in _families(case, options).items():
                report(f"refinement {case.name}: {family} ...")
                for row, mesh in meshes:
                    table.add(**row)
                    best[case.name, family] = mesh
            conclusions.append(_conclusion(case, table.rows))
        _file_rows(cases, options, table, best)
    conclusions += [_file_line(row) for row in table.rows if row["mesh"] == "file"]
    report("refinement figures ...")
    if best:
        draw_errors(table.rows, GOAL, out / "error_against_unknowns.png")
        draw_quality(best, out / "quality.png")
    for case in cases:
        shown = {family: mesh for (name, family), mesh in best.items() if name == case.name}
        if shown:
            draw_meshes(case.name, case.phases[0], shown, out / f"meshes_{case.name.replace(' ', '_')}.png")
    write_markdown(out / "refinement.md", "Refinement of the mesh", conclusions, {"Rows": table})
    return conclusions


@dataclass(frozen=True, eq=False)
class Case:
    """A scene with what is known of it.

    Parameters
    ----------
    name : for tables and file names
    scene : the scene
    """

    name: str
    scene: Scene

    @property
    def phases(self) -> tuple[Array, Array]:
        return self.scene.natural.phases

    @cached_property
    def history(self) -> Array:
        """Indentation at `TIMES` by the MDR at rtol 1e-7."""
        fine = self.scene.changed(accuracy__rtol=1e-7).natural
        return Wear(mdr_model(fine, Stages("mdr"), twins=False).compliance, self.phases[1]).modal(TIMES).indentation

    @cached_property
    def steady(self) -> float:
        edges, wear = self.phases
        return greatest_displacement(edges, steady_pressures(edges, wear))

    def errors(self, solved: adaptive.Round) -> dict[str, float]:
        """Relative errors by the name of the quantity."""
        wear = Wear(solved.compliance, self.phases[1])
        sampled = Sampler(self.scene.natural, solved.compliance.space).steady(wear)["steady_displacement_max"]
        found = {
            "d0": abs(flat_start(solved.compliance).indentation / 0.5 - 1),
            "history": float(np.abs(wear.modal(TIMES).indentation / self.history - 1).max()),
            "steady": abs(float(sampled[0]) / self.steady - 1),
        }
        return found | {"greatest": max(found.values())}

    def measured(self, mesh: HalfSpaceMesh, family: str, size: float | str, start: float) -> dict[str, Any]:
        """Solve on a mesh and compare."""
        solved = adaptive.solved(mesh, *self.phases, self.scene.half_space.poisson_ratio)
        return self.row(solved, family, size, start)

    def row(self, solved: adaptive.Round, family: str, size: float | str, start: float) -> dict[str, Any]:
        """A row of the table, timed from `start`."""
        seconds = time.perf_counter() - start
        quality = solved.mesh.quality
        return {
            "case": self.name, "mesh": family, "size or rtol": size, "unknowns": solved.half_space.unknowns,
            "triangles": len(solved.mesh.triangles), "multipliers": solved.compliance.space.size, **self.errors(solved),
            "estimate": solved.estimate, "least quality": float(quality.min()),
            "median quality": float(np.median(quality)), "seconds": round(seconds, 3), "remark": solved.mesh.mesher,
        }  # fmt: skip


def _cases(scene: Scene) -> list[Case]:
    """The flat punch, the scene, and the scene with a ring made narrow."""
    table = scene.table()
    radius = scene.punch.radius
    flat = {"radius": radius, "rings": 1, "wear_coefficients": [scene.punch.wear_coefficients[0]]}
    cases = [Case("flat punch", Scene.from_table(table | {"punch": flat}))]
    edges = scene.natural.edges.copy()
    if len(edges) == 2:
        return cases
    cases.append(Case("scene", scene))
    middle = (len(edges) - 1) // 2
    if edges[middle + 1] - edges[middle] > NARROW:
        edges[middle + 1] = edges[middle] + NARROW
    outer = [*(float(edge) * radius for edge in edges[1:-1]), radius]
    narrow = {"radius": radius, "ring_edges": outer, "wear_coefficients": list(scene.punch.wear_coefficients)}
    return [*cases, Case("narrow ring", Scene.from_table(table | {"punch": narrow}))]


Meshed = Iterator[tuple[dict[str, Any], HalfSpaceMesh]]


def _families(case: Case, options: argparse.Namespace) -> dict[str, Meshed]:
    quick = bool(options.quick)
    return {
        "uniform": _uniform(case, (2.0, 1.0, 0.5) if quick else (2.0, 1.0, 0.5, 0.25, 0.125)),
        "graded": _graded(case, (1e-2, 1e-5) if quick else (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
        "adaptive": _adaptive(case, GOAL / 2 if quick else GOAL / 10),
    }


def _uniform(case: Case, sizes: tuple[float, ...]) -> Meshed:
    for size in sizes:
        start = time.perf_counter()
        mesh = adaptive.uniform(case.phases[0], _truncation(case), size).mesh
        yield case.measured(mesh, "uniform", size, start), mesh


def _graded(case: Case, tolerances: tuple[float, ...]) -> Meshed:
    for rtol in tolerances:
        start = time.perf_counter()
        mesh, _ = triangle_mesh(case.scene.changed(accuracy__rtol=rtol).natural)
        yield case.measured(mesh, "graded", rtol, start), mesh


def _adaptive(case: Case, tolerance: float) -> Meshed:
    """Rounds from a coarse uniform mesh; seconds are those of all rounds so far, kept apart from the comparing."""
    nu = case.scene.half_space.poisson_ratio
    rounds = adaptive.adapted(adaptive.uniform(case.phases[0], _truncation(case), START), case.phases[1], nu, tolerance)
    spent, start = 0.0, time.perf_counter()
    for number, now in enumerate(rounds):
        spent += time.perf_counter() - start
        yield case.row(now, "adaptive", f"round {number}", time.perf_counter() - spent), now.mesh
        start = time.perf_counter()


def _truncation(case: Case) -> float:
    return case.scene.accuracy.fem.truncation


def _file_rows(
    cases: list[Case], options: argparse.Namespace, table: Table, best: dict[tuple[str, str], HalfSpaceMesh]
) -> None:
    """The user's mesh on every case whose ring edges it has; one that fits none of them is refused."""
    if not getattr(options, "mesh", None):
        return
    from meshes.mesh_file import read

    fitting = 0
    for case in cases:
        start = time.perf_counter()
        try:
            mesh = read(options.mesh, case.phases[0], case.scene.punch.radius)
            row = case.measured(mesh, "file", options.mesh, start)
        except RingwearError as error:
            refusal = error
            row = {"case": case.name, "mesh": "file", "size or rtol": options.mesh, "remark": f"refused: {error}"}
        else:
            fitting += 1
            best[case.name, "file"] = mesh
        table.add(**row)
    if not fitting:
        raise MeshError(str(refusal))


def _file_line(row: dict[str, Any]) -> str:
    if "greatest" not in row:
        return f"{row['case']}: {row['remark']}"
    values = ", ".join(f"{name} {row[name]:.1e}" for name in ERRORS)
    estimate = f"estimate {row['estimate']:.1e}"
    return f"{row['case']}: {row['remark']}, with {row['unknowns']} unknowns errs by {values} ({estimate})"


def _conclusion(case: Case, rows: list[dict[str, Any]]) -> str:
    """One line: unknowns to the goal in every quantity, adaptive against graded."""
    own = [row for row in rows if row["case"] == case.name]
    recipe = next(row for row in own if row["mesh"] == "graded" and row["size or rtol"] == GOAL)

    def fewest(family: str, quantity: str) -> int | None:
        return min((r["unknowns"] for r in own if r["mesh"] == family and r[quantity] <= GOAL), default=None)

    reached = {family: fewest(family, "greatest") for family in FAMILIES}
    if reached["adaptive"] is None:
        return f"{case.name}: adaptation did not reach {GOAL:g}"
    row = next(row for row in own if row["mesh"] == "adaptive" and row["unknowns"] == reached["adaptive"])
    values = ", ".join(f"{name} {row[name]:.1e}" for name in ERRORS)
    leanest = f"the leanest graded mesh within {GOAL:g} has {reached['graded']}" if reached["graded"] else "none is within"
    uniform = max((r for r in own if r["mesh"] == "uniform"), key=lambda r: r["unknowns"])
    return (
        f"{case.name}: adaptation from a uniform mesh reaches {GOAL:g} ({values}) with {reached['adaptive']} unknowns in "
        f"{row['size or rtol']} and {row['seconds']:.1f} s, {reached['adaptive'] / recipe['unknowns']:.2f} x those of the "
        f"recipe at rtol {GOAL:g} ({recipe['unknowns']}; {leanest}); "
        f"for d0 alone {fewest('adaptive', 'd0')} against {fewest('graded', 'd0')} at the loosest rtol that will do; "
        f"uniform: {uniform['greatest']:.0e} with {uniform['unknowns']}."
    )
