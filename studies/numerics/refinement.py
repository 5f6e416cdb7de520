"""Refining the mesh, each way against closed forms and a far finer MDR.

Uniformly, graded by default sizes, and in the degree. A mesh file of the user's is one more row,
tested the same way. On uniformly refined meshes d0 is of order 1 whatever the degree, set by the
singular rim; `ringwear study convergence` has the orders of graded meshes and degrees beside
theory.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from skfem import Mesh, MeshQuad

from ...mdr.direct import greatest_displacement, steady_pressures
from ...meshes import bisection, files
from ...meshes.errors import MeshError, SceneError
from ...meshes.half_space import as_half_space, truncation
from ...meshes.sizes import SizeField
from ..methods.base import method
from ..methods.fem import half_space_mesh
from ..problem.problem import Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..progress import Stages
from ..sizes.defaults import WIDER_TRUNCATION, pole_orders, triangle_degree
from ..study.errors_over_size import Curves, draw_errors
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.orders import Sequence
from ..study.study import Study
from ..tables import Row
from .core import FLAT, condense, evaluate, flat_d0_error

GOAL = 1e-5
"""Error in every quantity for which the unknowns of each way are told."""
OWN = "file"
"""The way of a mesh file of the user's."""
ERRORS = ("d0", "history", "steady")
"""Errors of each mesh: of d0, the greatest of d(t), and of the greatest steady displacement."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine each way on each case."""
    problem = scene.problem
    cases = {"flat punch": replace(problem, rings=Rings(FLAT, np.ones(1)))}
    if len(problem.merged.wear_coefficients) > 1 or problem.inner_radius:
        cases["scene"] = problem
    for mesh in options.meshes:
        try:
            own_mesh(cases["flat punch"], mesh)
        except MeshError as error:  # what does not fit the flat punch fits nothing
            raise SceneError(f"--mesh {error}") from error
    ways = (family for name, case in cases.items() for family in families(name, case, options))
    columns = ["case", "family", "setting", "degree", "unknowns", "elements", "multipliers"]
    columns += [*ERRORS, "greatest"]
    table = record.solve("refinement", ways, columns)
    rows, conclusions = table.dropna(subset="greatest"), list(record.conclusions)
    panels, drawn = dict[str, Curves](), ["unknowns", "greatest"]
    for case, of_case in rows.groupby("case", sort=False):
        panels[f"unknowns, {case}"] = {
            str(way): Sequence(str(way), "greatest", Theory(), *of_way[drawn].to_numpy(float).T)
            for way, of_way in of_case.groupby("family", sort=False)
        }
        conclusions += conclude(str(case), of_case)
    figures = {"error_against_unknowns": draw_errors(panels, "greatest relative error")}
    return Study("refinement", scene, table, conclusions=tuple(conclusions), figures=figures)


def families(case: str, problem: Problem, options: Options) -> Iterator[Family]:
    """Yield each way to refine a mesh of a case, from coarse to fine; last the user's meshes."""
    quick = options.quick
    rings = problem.merged
    edges = tuple(rings.ring_edges.tolist())
    # meshes suit the times of the scene; what they are held to knows nothing of its settings
    watched = replace(problem, times=np.geomspace(1e-3, 20, 12), quantities=None)
    watched = replace(watched, march="modal", step=None, mdr=MdrAccuracy())
    exact = method("mdr").solve(replace(watched, rtol=1e-9), Stages("mdr")).results["indentation"]
    greatest = greatest_displacement(rings.ring_edges, steady_pressures(*rings))

    def solve_on(mesh: Mesh, degree: int) -> Row:
        poles = len(pole_orders(problem, truncation(mesh)))
        compliance, unknowns = condense(
            mesh, rings.ring_edges, degree, problem.poisson_ratio, poles, rings.hollow
        )
        results = evaluate(watched, compliance)
        errors = {
            "d0": abs(flat_d0_error(compliance)),
            "history": float(np.abs(results["indentation"] / exact - 1).max()),
            "steady": abs(float(results["steady_displacement_max"]) / greatest - 1),
        }
        return errors | {
            "case": case,
            "degree": degree,
            "unknowns": unknowns,
            "elements": mesh.nelements,
            "multipliers": compliance.space.size,
            "greatest": max(errors.values()),
        }

    def solve(meshes: dict[str, tuple[Mesh, int]], setting: str) -> Row:
        return solve_on(*meshes[setting])

    def solve_own(given: str | Mesh) -> Row:
        mesh = own_mesh(problem, given)
        quads = isinstance(mesh, MeshQuad)
        degree = (problem.fem.degree or 6) if quads else triangle_degree(problem)
        return solve_on(mesh, options.degree or degree)

    def mesh_at(rtol: float, mesher: str) -> Mesh:
        fem = FemAccuracy.model_validate({"mesher": mesher})
        return half_space_mesh(replace(problem, rtol=rtol, fem=fem)).mesh

    # of one size, smaller only where a ring edge would not be a vertex
    size, degree = 1.2, 4
    coarse = bisection.mesh(SizeField(edges, size, size, 0.0, WIDER_TRUNCATION, size))
    tolerances = (1e-2, GOAL) if quick else (1e-1, 1e-2, 1e-3, 1e-4, GOAL, 1e-6)
    layered = mesh_at(1e-7, "quads")
    ways = {
        "uniform triangles": {
            f"halved {n} times": (coarse.refined(n), degree) for n in range(3 if quick else 4)
        },
        "graded triangles": {f"rtol {x:g}": (mesh_at(x, "gmsh"), degree) for x in tolerances},
    }
    if isinstance(layered, MeshQuad):  # triangles take their place where gmsh cannot be used
        degrees = range(4, 8 if quick else 10)
        ways["quadrilaterals of rising degree"] = {f"degree {k}": (layered, k) for k in degrees}
    for way, meshes in ways.items():
        yield Family(way, dict.fromkeys(meshes, np.nan), partial(solve, meshes))
    if options.meshes:
        named = {
            Path(mesh).name if isinstance(mesh, str) else f"mesh {number}": mesh
            for number, mesh in enumerate(options.meshes, 1)
        }
        yield Family(OWN, dict.fromkeys(named, np.nan), lambda name: solve_own(named[name]))


def own_mesh(problem: Problem, given: str | Mesh) -> Mesh:
    """Return the user's mesh, read from a file if it is one.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of it, or if it is no mesh of a half-space
    """
    if isinstance(given, Mesh):
        return as_half_space(given, problem.merged.ring_edges)
    return files.read(given, problem.merged.ring_edges, problem.units.length)


def conclude(case: str, rows: pd.DataFrame) -> Iterator[str]:
    """Yield the errors on the user's mesh, and the unknowns that each way needs for the goal."""
    for row in rows[rows.family == OWN].to_dict("records"):
        errors = ", ".join(f"{name} {row[name]:.1e}" for name in ERRORS)
        elements = f"{row['elements']} elements of degree {row['degree']}"
        yield f"{case}: {row['setting']}, {elements}, errors: {errors}"
    reached = rows[rows.greatest <= GOAL].groupby("family").first()
    unknowns = [
        f"{way} {reached.unknowns[way]} ({reached.setting[way]})"
        if way in reached.index
        else f"{way} do not reach it"
        for way in rows.family.unique()
    ]
    yield f"{case}: unknowns to {GOAL:g} in every quantity: {'; '.join(unknowns)}"
