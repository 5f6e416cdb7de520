"""Refining the mesh, each way against closed forms and a far finer MDR.

Uniformly, graded by default sizes, in the degree, and by an indicator. A mesh file of the user's is
one more row, tested the same way. On uniformly refined meshes d0 is of order 1 whatever the degree,
set by the singular rim; `ringwear study convergence` has the orders of graded meshes and degrees
beside theory.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from skfem import Mesh, MeshQuad

from ...mdr.direct import greatest_displacement, steady_pressures
from ...meshes import files
from ...meshes.errors import MeshError, SceneError
from ..figures.mesh import draw_mesh
from ..figures.style import save
from ..methods.fem import half_space_mesh
from ..problem.defaults import triangle_degree
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy
from ..tables import Row, Table
from ..wear.flat_contact import press_flat
from .adaptive import DEGREE, SolvedMesh, refine_adaptively, solve_on, uniform_mesh
from .core import evaluate, exact_indentation
from .sequences import Curves, Family, Level, draw_errors, solve_all

GOAL = 1e-5
"""Error in every quantity for which the unknowns of each way are told."""
ADAPTIVE, OWN = "adaptive triangles", "file"
"""Ways whose finest meshes are drawn: by the indicator, and a file of the user's."""
ERRORS = ("d0", "history", "steady")
"""Errors of each mesh: of d0, the greatest of d(t), and of the greatest steady displacement."""


class Case:
    """A problem, with what is exact of it: its indentation at twelve times, and its greatest steady
    displacement.
    """

    def __init__(self, name: str, problem: Problem) -> None:
        self.name, self.problem, rings = name, problem, problem.merged
        # meshes suit the times of the scene
        self._watched = replace(problem, times=np.geomspace(1e-3, 20, 12))
        self._exact = exact_indentation(self._watched)
        self._greatest = greatest_displacement(rings.ring_edges, steady_pressures(*rings))

    def row(self, solved: SolvedMesh) -> Row:
        """Return what a mesh costs, relative errors by the name of the quantity, their estimate,
        and the mesh itself.
        """
        solid, compliance = solved.half_space.solid, solved.wear.compliance
        results = evaluate(self._watched, compliance)
        errors = {
            "d0": abs(press_flat(compliance).indentation / D0 - 1),
            "history": float(np.abs(results["indentation"] / self._exact - 1).max()),
            "steady": abs(float(results["steady_displacement_max"]) / self._greatest - 1),
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
    ways = (family for case in cases for family in families(case, options.quick, options.mesh))
    solve_all(ways, table, conclusions)
    rows = pd.DataFrame(row for row in table.rows if "greatest" in row)
    if rows.empty:
        return conclusions
    conclusions[:0] = [
        line
        for case, of_case in rows.groupby("case", sort=False)
        for line in conclude(case, of_case)
    ]
    panels: dict[str, Curves] = {}
    for (case, way), of_way in rows.groupby(["case", "family"], sort=False):
        panels.setdefault(f"unknowns, {case}", {})[way] = of_way.unknowns, of_way.greatest, np.nan
        if way in (ADAPTIVE, OWN):
            path = out / f"{way} of {case}.png".replace(" ", "_")
            edges = next(each for each in cases if each.name == case).problem.merged.ring_edges
            save(path, draw_mesh, of_way.mesh.iloc[-1], way, edges)
    draw_errors(out / "error_against_unknowns.png", panels, "greatest relative error")
    return conclusions


def list_cases(problem: Problem) -> list[Case]:
    """Return the flat punch, and the problem if it has rings."""
    flat = Case("flat punch", replace(problem, rings=Rings(np.array([0.0, 1.0]), np.ones(1))))
    return [flat, Case("scene", problem)] if len(problem.merged.wear_coefficients) > 1 else [flat]


def families(case: Case, quick: bool, mesh_file: str | None = None) -> Iterator[Family]:
    """Yield each way to refine a mesh of a case, from coarse to fine; last a mesh file."""
    problem = case.problem

    def mesh_at(rtol: float, mesher: str) -> Mesh:
        fem = FemAccuracy.model_validate({"mesher": mesher})
        return half_space_mesh(replace(problem, rtol=rtol, fem=fem)).mesh

    def solve(mesh: Mesh, degree: int) -> Row:
        return case.row(solve_on(problem, mesh, degree))

    def solve_own(path: str) -> Row:
        mesh = own_mesh(problem, path)
        quads = isinstance(mesh, MeshQuad)
        degree = (problem.fem.degree or 6) if quads else triangle_degree(problem)
        return solve(mesh, degree)

    tolerances = (1e-2, GOAL) if quick else (1e-1, 1e-2, 1e-3, 1e-4, GOAL, 1e-6)
    coarse, layered = uniform_mesh(problem.merged.ring_edges), mesh_at(1e-7, "quads")
    ways = {
        "uniform triangles": {
            f"halved {n} times": (coarse.refined(n), DEGREE) for n in range(3 if quick else 4)
        },
        "graded triangles": {f"rtol {x:g}": (mesh_at(x, "gmsh"), DEGREE) for x in tolerances},
    }
    if isinstance(layered, MeshQuad):  # triangles take their place where gmsh cannot be used
        degrees = range(4, 8 if quick else 10)
        ways["quadrilaterals of rising degree"] = {f"degree {k}": (layered, k) for k in degrees}
    for way, meshes in ways.items():
        settings = [Level(setting, partial(solve, *of)) for setting, of in meshes.items()]
        yield Family(way, settings)
    rounds = enumerate(refine_adaptively(problem, coarse, GOAL / 2 if quick else GOAL / 10))
    adapted = (Level(f"round {number}", partial(case.row, solved)) for number, solved in rounds)
    yield Family(ADAPTIVE, adapted)
    if mesh_file:
        yield Family(OWN, [Level(Path(mesh_file).name, partial(solve_own, mesh_file))])


def own_mesh(problem: Problem, path: str) -> Mesh:
    """Read the user's mesh.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of it, or if it is no mesh of a half-space
    """
    return files.read(path, problem.merged.ring_edges, problem.units.length)


def conclude(case: str, rows: pd.DataFrame) -> Iterator[str]:
    """Yield the errors on the user's mesh, the order on uniform ones, and the unknowns with which
    each way reaches the goal.
    """
    for row in rows[rows.family == OWN].to_dict("records"):
        errors = ", ".join(f"{name} {row[name]:.1e}" for name in (*ERRORS, "estimate"))
        elements = f"{row['elements']} elements of degree {row['degree']}"
        yield f"{case}: {row['setting']}, {elements}, errors: {errors}"
    finest = rows.d0[rows.family == "uniform triangles"].to_numpy()[-2:]
    if len(finest) > 1:
        order = np.log2(finest[0] / finest[1])
        yield f"{case}: uniform triangles: d0 is of order {order:.2f} between the finest (theory 1)"
    reached = rows[rows.greatest <= GOAL].groupby("family").first()
    unknowns = [
        f"{way} {reached.unknowns[way]} ({reached.setting[way]})"
        if way in reached.index
        else f"{way} do not reach it"
        for way in rows.family.unique()
    ]
    yield f"{case}: unknowns to {GOAL:g} in every quantity: {'; '.join(unknowns)}"
