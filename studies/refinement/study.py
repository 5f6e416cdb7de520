"""Refining the mesh, each way against what is known: uniformly, graded by the recipe, in the degree, and by an indicator.

Errors are those of the flat punch's indentation (Eq. 10), of the indentation over the whole history against the MDR at
rtol 1e-7, and of the steady displacement in closed form. A mesh file of the user's is one more row, tested the same way.

Theory: on uniformly refined meshes (h), contact facets among them, d0 is of order 1 whatever the degree, set by the
singular rim; in the degree (p) on geometric layers of factor 1/4 every degree takes the error down by 9 (`convergence`).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.mdr.direct import greatest_displacement, steady_pressures
from ringwear.meshes.errors import MeshError, RingwearError
from ringwear.meshes.gmsh_session import unavailable
from ringwear.meshes.half_space import quality
from ringwear.meshes.radial import Array
from ringwear.studies.convergence.levels import Table, keeping_rows, write_markdown
from ringwear.studies.methods import quads
from ringwear.studies.methods.outcome import Sampler
from ringwear.studies.methods.radial import mdr_model
from ringwear.studies.methods.triangles import TRUNCATION, triangle_mesh
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages
from ringwear.studies.refinement import adaptive
from ringwear.studies.refinement.figures import ERRORS, draw_errors, draw_meshes, draw_quality
from ringwear.studies.wear.archard import Wear
from ringwear.studies.wear.contact import flat_start
from skfem import Mesh, MeshQuad
from threadpoolctl import threadpool_limits

GOAL = 1e-5
NARROW = 1e-3
START = 1.0  # element size of the uniform mesh that adaptation starts from
TIMES = np.geomspace(1e-3, 20, 12)
# of the displacement, where the degree is not what is refined
DEGREE = {"triangles": 4, "quadrilaterals": 6}
FIELDS = (
    "case", "mesh", "refined", "degree", "unknowns", "elements", "multipliers", *ERRORS, "greatest", "estimate",
    "least quality", "median quality", "seconds", "remark",
)  # fmt: skip


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Refine three ways on each case; writes `refinement.csv`, `refinement.md` and the figures."""
    table = Table(out / "refinement.csv", FIELDS)
    conclusions: list[str] = []
    best: dict[tuple[str, str], Mesh] = {}
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

    def measured(self, mesh: Mesh, family: str, refined: float | str, degree: int, start: float) -> dict[str, Any]:
        """Solve on a mesh and compare."""
        solved = adaptive.solved(mesh, *self.phases, self.scene.half_space.poisson_ratio, degree)
        return self.row(solved, family, refined, start)

    def row(self, solved: adaptive.Round, family: str, refined: float | str, start: float) -> dict[str, Any]:
        """A row of the table, timed from `start`."""
        seconds = time.perf_counter() - start
        shape = quality(solved.mesh)
        return {
            "case": self.name, "mesh": family, "refined": refined, "degree": solved.solid.degree,
            "unknowns": solved.half_space.unknowns, "elements": solved.mesh.nelements,
            "multipliers": solved.compliance.space.size, **self.errors(solved), "estimate": solved.estimate,
            "least quality": float(shape.min()), "median quality": float(np.median(shape)),
            "seconds": round(seconds, 3), "remark": "",
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


Rows = Iterator[tuple[dict[str, Any], Mesh]]


def _families(case: Case, options: argparse.Namespace) -> dict[str, Rows]:
    quick = bool(options.quick)
    levels = 3 if quick else 4
    coarse = adaptive.uniform(case.phases[0], TRUNCATION, START)
    families = {
        "h, triangles": _refined(case, "h, triangles", coarse.mesh, DEGREE["triangles"], levels),
        "p, triangles": _degrees(case, "p, triangles", triangle_mesh(_at(case, GOAL))[0], range(2, 5)),
        "graded triangles": _graded(case, (1e-2, 1e-5) if quick else (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
        "adaptive triangles": _adaptive(case, coarse, GOAL / 2 if quick else GOAL / 10),
    }
    if not unavailable():
        name = "quadrilaterals"
        families[f"h, {name}"] = _refined(case, f"h, {name}", _coarse_quads(case), DEGREE["triangles"], levels)
        families[f"p, {name}"] = _degrees(case, f"p, {name}", _quads(case, 1e-7), range(4, 8 if quick else 10))
    return families


def _at(case: Case, rtol: float) -> NaturalScene:
    return case.scene.changed(accuracy__rtol=rtol).natural


def _quads(case: Case, rtol: float) -> MeshQuad:
    """Quadrilaterals in geometric layers, as the recipe has them at an accuracy."""
    return quads.graded_quads(_at(case, rtol)).mesh


def _coarse_quads(case: Case) -> MeshQuad:
    """As few quadrilaterals as there can be, all of the same degree."""
    from ringwear.meshes.quads import graded

    mesh = graded(case.phases[0], 1.0, 1.0, quads.FACTOR, quads.GROWTH, TRUNCATION).mesh
    return replace(mesh, _subdomains=None)


def _refined(case: Case, family: str, mesh: Mesh, degree: int, levels: int) -> Rows:
    """Every element refined into four by scikit-fem, those at the contact among them, again and again."""
    for level in range(levels):
        start = time.perf_counter()
        finer = mesh.refined(level) if level else mesh
        yield case.measured(finer, family, f"{level} times", degree, start), finer


def _degrees(case: Case, family: str, mesh: Mesh, degrees: range) -> Rows:
    for degree in degrees:
        yield case.measured(mesh, family, f"degree {degree}", degree, time.perf_counter()), mesh


def _graded(case: Case, tolerances: tuple[float, ...]) -> Rows:
    for rtol in tolerances:
        start = time.perf_counter()
        mesh, *_ = triangle_mesh(_at(case, rtol))
        yield case.measured(mesh, "graded triangles", rtol, DEGREE["triangles"], start), mesh


def _adaptive(case: Case, coarse: adaptive.Nested, tolerance: float) -> Rows:
    """Rounds from a coarse uniform mesh; seconds are those of all rounds so far, kept apart from the comparing."""
    nu = case.scene.half_space.poisson_ratio
    rounds = adaptive.adapted(coarse, case.phases[1], nu, tolerance, degree=DEGREE["triangles"])
    spent, start = 0.0, time.perf_counter()
    for number, now in enumerate(rounds):
        spent += time.perf_counter() - start
        yield case.row(now, "adaptive triangles", f"round {number}", time.perf_counter() - spent), now.mesh
        start = time.perf_counter()


def _file_rows(cases: list[Case], options: argparse.Namespace, table: Table, best: dict[tuple[str, str], Mesh]) -> None:
    """The user's mesh on every case whose ring edges it has; one that fits none of them is refused."""
    if not getattr(options, "mesh", None):
        return
    from ringwear.meshes.files import read

    fitting = 0
    for case in cases:
        start = time.perf_counter()
        try:
            mesh, remark = read(options.mesh, case.phases[0], case.scene.punch.radius)
            degree = (
                case.scene.accuracy.fem.degree or DEGREE["quadrilaterals" if isinstance(mesh, MeshQuad) else "triangles"]
            )
            row = case.measured(mesh, "file", Path(options.mesh).name, degree, start) | {"remark": remark}
        except RingwearError as error:
            refusal = error
            row = {"case": case.name, "mesh": "file", "refined": Path(options.mesh).name, "remark": f"refused: {error}"}
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
    turned = f" ({row['remark']})" if row["remark"] else ""
    return (
        f"{row['case']}: {row['refined']}{turned}, {row['elements']} elements of degree {row['degree']}, errs by {values} "
        f"(estimate {row['estimate']:.1e})"
    )


def _conclusion(case: Case, rows: list[dict[str, Any]]) -> str:
    """One line: observed orders beside theory, and unknowns to the goal in every quantity, adaptive against graded."""
    own = [row for row in rows if row["case"] == case.name]

    def order(family: str) -> float:
        coarser, finer = [row["d0"] for row in own if row["mesh"] == family][-2:]
        return float(np.log2(coarser / finer))

    def gained(family: str) -> float:
        errors = [row["d0"] for row in own if row["mesh"] == family]
        return float((errors[0] / min(errors)) ** (1 / (len(errors) - 1)))

    def fewest(family: str, quantity: str) -> int | None:
        return min((r["unknowns"] for r in own if r["mesh"] == family and r[quantity] <= GOAL), default=None)

    kinds = [kind for kind in DEGREE if any(row["mesh"] == f"h, {kind}" for row in own)]
    by_size = " and ".join(f"{order('h, ' + kind):.2f} on {kind}" for kind in kinds)
    by_degree = " and ".join(f"{gained('p, ' + kind):.1f} on {kind}" for kind in kinds)
    orders = (
        f"d0 by uniform refinement (h) is of order {by_size} (theory 1); each degree (p) takes its error down by "
        f"{by_degree} (theory on quadrilaterals 9)"
    )
    reached = fewest("adaptive triangles", "greatest")
    if reached is None:
        return f"{case.name}: {orders}; adaptation did not reach {GOAL:g}"
    recipe = next(row for row in own if row["mesh"] == "graded triangles" and row["refined"] == GOAL)
    row = next(row for row in own if row["mesh"] == "adaptive triangles" and row["unknowns"] == reached)
    values = ", ".join(f"{name} {row[name]:.1e}" for name in ERRORS)
    on_quads = fewest("p, quadrilaterals", "greatest")
    return (
        f"{case.name}: {orders}; adaptation from a uniform mesh reaches {GOAL:g} ({values}) with {reached} unknowns in "
        f"{row['refined']} and {row['seconds']:.1f} s, {reached / recipe['unknowns']:.2f} x those of graded triangles "
        f"at rtol {GOAL:g} ({recipe['unknowns']})" + (f", quadrilaterals with {on_quads}" if on_quads else "")
    )
