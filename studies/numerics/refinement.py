"""Refining the mesh, each way against closed forms and a far finer MDR.

Uniformly, graded by default sizes, in the degree, and by an indicator. A mesh file of the user's is
one more row, tested the same way. On uniformly refined meshes d0 is of order 1 whatever the degree,
set by the singular rim; `ringwear study convergence` has the orders of graded meshes and degrees
beside theory.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from skfem import Mesh, MeshQuad

from ...mdr.direct import greatest_displacement, steady_pressures
from ...meshes import files
from ...meshes.errors import MeshError, SceneError
from ...meshes.radial import Array
from ..figures.mesh import draw_mesh
from ..figures.style import FAINT, new_figure, save
from ..methods.fem import half_space_mesh
from ..problem.defaults import WIDER_TRUNCATION, triangle_degree
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy
from ..tables import Row, Table, write_page
from ..wear.flat_contact import press_flat
from .adaptive import DEGREE, SolvedMesh, refine_adaptively, solve_on, uniform_mesh
from .core import evaluate, exact_indentation
from .sequences import Family, Level, draw_errors, solve_all

GOAL = 1e-5
"""Error in every quantity for which the unknowns of each way are told."""
"""When the history is looked at."""
ADAPTIVE, OWN = "adaptive triangles", "file"
"""Ways whose finest meshes are drawn: by the indicator, and a file of the user's."""
ERRORS = {"d0": "of $d_0$", "history": "of $d(t)$, greatest", "steady": "of steady $u_{z,max}$"}
"""Errors of each mesh, and how figures call them."""


@dataclass(frozen=True, eq=False)
class Case:
    """A problem, with its exact indentation at `TIMES`."""

    name: str
    problem: Problem

    @cached_property
    def watched(self) -> Problem:
        """The problem at twelve times; meshes suit those of the scene."""
        times = np.geomspace(1e-3, 20, 12)
        return replace(self.problem, times=times)

    @cached_property
    def exact(self) -> Array:
        return exact_indentation(self.watched)

    def row(self, solved: SolvedMesh) -> Row:
        """Return what a mesh costs, relative errors by the name of the quantity, their estimate,
        and the mesh itself.
        """
        rings, solid = self.problem.merged, solved.half_space.solid
        compliance = solved.wear.compliance
        results = evaluate(self.watched, compliance)
        greatest = greatest_displacement(rings.ring_edges, steady_pressures(*rings))
        errors = {
            "d0": abs(press_flat(compliance).indentation / D0 - 1),
            "history": float(np.abs(results["indentation"] / self.exact - 1).max()),
            "steady": abs(float(results["steady_displacement_max"]) / greatest - 1),
        }
        return errors | {
            "case": self.name,
            "degree": solid.degree,
            "unknowns": solved.half_space.unknowns,
            "elements": solid.mesh.nelements,
            "multipliers": compliance.space.size,
            "greatest": max(errors.values()),
            "estimate": solved.estimate,
            "mesh": solid.mesh,
        }


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Refine each way on each case; writes `refinement`, and figures of errors and meshes."""
    columns = ("degree", "unknowns", "elements", "multipliers", *ERRORS, "greatest", "estimate")
    fields = ("case", "family", "setting", *columns, "remark")
    table, conclusions = Table(out / "refinement.csv", fields), list[str]()
    cases = list_cases(scene.problem)
    if options.mesh:
        try:
            own_mesh(cases[0].problem, options.mesh)
        except MeshError as error:  # what does not fit the flat punch fits nothing
            raise SceneError(f"--mesh {error}") from error
    elif options.quick:
        cases = cases[::2]
    ways = (family for case in cases for family in families(case, options.quick, options.mesh))
    solve_all(ways, table, conclusions)
    by_case: dict[str, dict[str, list[Row]]] = {}
    for row in table.rows:
        if "greatest" in row:
            by_case.setdefault(row["case"], {}).setdefault(row["family"], []).append(row)
    conclusions[:0] = [line for case, ways in by_case.items() for line in conclude(case, ways)]
    if by_case:
        draw(by_case, out / "error_against_unknowns.png")
    for case in cases:
        for way in {ADAPTIVE, OWN} & by_case.get(case.name, {}).keys():
            path = out / f"{way} of {case.name}.png".replace(" ", "_")
            finest = by_case[case.name][way][-1]["mesh"]
            save(path, draw_mesh, finest, way, case.problem.merged.ring_edges)
    write_page(out / "refinement.md", "Refinement of the mesh", conclusions, {"Rows": table})
    return conclusions


def list_cases(problem: Problem) -> list[Case]:
    """Return the flat punch, the problem, and the problem with its middle ring narrow."""
    flat = Case("flat punch", replace(problem, rings=Rings(np.array([0.0, 1.0]), np.ones(1))))
    ring_edges, wear_coefficients = problem.rings
    if len(wear_coefficients) == 1:
        return [flat]
    narrow, middle = ring_edges.copy(), (len(wear_coefficients) - 1) // 2
    narrow[middle + 1] = min(narrow[middle + 1], narrow[middle] + 1e-3)
    narrow_ring = replace(problem, rings=Rings(narrow, wear_coefficients))
    return [flat, Case("scene", problem), Case("narrow ring", narrow_ring)]


def families(case: Case, quick: bool, mesh_file: str | None = None) -> Iterator[Family]:
    """Yield each way to refine a mesh of a case, from coarse to fine; last a mesh file."""
    problem = case.problem

    def mesh_at(rtol: float, mesher: str, **sizes: Any) -> Mesh:
        fem = FemAccuracy.model_validate({"mesher": mesher} | sizes)
        return half_space_mesh(replace(problem, rtol=rtol, fem=fem)).mesh

    def solve(mesh: Mesh, degree: int) -> Row:
        return case.row(solve_on(problem, mesh, degree))

    def solve_own() -> Row:
        mesh, remark = own_mesh(problem, mesh_file or "")
        quads = isinstance(mesh, MeshQuad)
        degree = (problem.fem.degree or 6) if quads else triangle_degree(problem)
        return dict(solve(mesh, degree), remark=remark)

    times = range(3 if quick else 4)
    tolerances = (1e-2, GOAL) if quick else (1e-1, 1e-2, 1e-3, 1e-4, GOAL, 1e-6)
    coarse, graded = uniform_mesh(problem.merged.ring_edges), mesh_at(GOAL, "gmsh")
    ways = {
        "h, triangles": [(f"{n} times", coarse.refined(n), DEGREE) for n in times],
        "p, triangles": [(f"degree {k}", graded, k) for k in range(2, 5)],
        "graded triangles": [(f"rtol {x:g}", mesh_at(x, "gmsh"), DEGREE) for x in tolerances],
    }
    layered = mesh_at(1e-7, "quads")
    if isinstance(layered, MeshQuad):  # triangles take their place where gmsh cannot be used
        plain = mesh_at(GOAL, "quads", rim_size=0.5, ring_size=0.5, truncation=WIDER_TRUNCATION)
        # without subdomains of lower degree
        plain = replace(plain, _subdomains=None)
        ways["h, quadrilaterals"] = [(f"{n} times", plain.refined(n), DEGREE) for n in times]
        degrees = range(4, 8 if quick else 10)
        ways["p, quadrilaterals"] = [(f"degree {k}", layered, k) for k in degrees]
    for way, meshes in ways.items():
        settings = [Level(setting, partial(solve, *of)) for setting, *of in meshes]
        yield Family(way, settings)
    rounds = enumerate(refine_adaptively(problem, coarse, GOAL / 2 if quick else GOAL / 10))
    adapted = (Level(f"round {number}", partial(case.row, solved)) for number, solved in rounds)
    yield Family(ADAPTIVE, adapted)
    if mesh_file:
        yield Family(OWN, [Level(Path(mesh_file).name, solve_own)])


def own_mesh(problem: Problem, path: str) -> tuple[Mesh, str]:
    """Read the user's mesh, with a remark on how it was taken.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of it, or if it is no mesh of a half-space
    """
    return files.read(path, problem.merged.ring_edges, problem.units.length)


def conclude(case: str, ways: dict[str, list[Row]]) -> list[str]:
    """Say the errors on the user's mesh, orders, and the unknowns with which each way reaches the
    goal.
    """
    lines, unknowns = [], []
    for row in ways.get(OWN, ()):
        errors = ", ".join(f"{name} {row[name]:.1e}" for name in (*ERRORS, "estimate"))
        elements = f"{row['elements']} elements of degree {row['degree']}"
        lines.append(f"{case}: {row['setting']}, {elements}, errors: {errors}")
    for way, rows in ways.items():
        if way.startswith("h, ") and len(rows) > 1:  # sizes are halved
            order = np.log2(rows[-2]["d0"] / rows[-1]["d0"])
            lines.append(
                f"{case}: {way}: d0 is of order {order:.2f} between the finest, by theory 1"
            )
        reached = [
            f"{row['unknowns']} ({row['setting']})" for row in rows if row["greatest"] <= GOAL
        ]
        unknowns.append(f"{way} {reached[0] if reached else 'do not reach it'}")
    return [*lines, f"{case}: unknowns to {GOAL:g} in every quantity: {'; '.join(unknowns)}"]


def draw(by_case: dict[str, dict[str, list[Row]]], path: Path) -> None:
    """Draw errors against unknowns: a column for each case, a row for each quantity."""
    figure = new_figure(0.6 + 3.2 * len(by_case), 8.2)
    panels = figure.subplots(len(ERRORS), len(by_case), sharex="col", sharey=True, squeeze=False)
    for line, (quantity, label) in zip(panels, ERRORS.items(), strict=True):
        for axes, (case, ways) in zip(line, by_case.items(), strict=True):
            curves = {
                way: np.array([(row["unknowns"], row[quantity]) for row in rows]).T
                for way, rows in ways.items()
            }
            ylabel = f"relative error\n{label}"
            draw_errors(axes, curves, title=case, xlabel="unknowns", ylabel=ylabel)
            axes.axhline(GOAL, **FAINT)
            axes.label_outer()
    place = {"loc": "outside lower center", "ncols": 1 + len(by_case), "frameon": False}
    figure.legend(*panels[0, 0].get_legend_handles_labels(), **place)
    title = f"refinement in size (h), in degree (p),\ngraded and adaptive (goal {GOAL:g}: dotted)"
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)
