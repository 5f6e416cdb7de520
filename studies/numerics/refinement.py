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
from ...meshes.half_space import quality, truncation
from ...meshes.radial import Array
from ..figures.mesh import mesh_panel
from ..figures.style import FAINT, new_figure
from ..methods.fem import half_space_mesh
from ..problem.defaults import WIDER_TRUNCATION, triangle_degree
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy
from ..tables import Row, Table, write_page
from ..wear.contact import press_flat
from .adaptive import DEGREE, SolvedMesh, refine_adaptively, solve_on, uniform_mesh
from .core import evaluate, exact_indentation
from .sequences import Family, Level, Sequence, Theory, draw_errors, solve_all

GOAL = 1e-5
"""Error in every quantity for which the unknowns of each way are told."""
TIMES = np.geomspace(1e-3, 20, 12)
"""When the history is looked at."""
ERRORS = {"d0": "of $d_0$", "history": "of $d(t)$, greatest", "steady": "of steady $u_{z,max}$"}
"""Errors of each mesh, and how figures call them."""


@dataclass(frozen=True, eq=False)
class Case:
    """A problem, with its exact indentation at `TIMES`."""

    name: str
    problem: Problem

    @cached_property
    def watched(self) -> Problem:
        """The problem at `TIMES`; meshes suit the times of the scene."""
        return replace(self.problem, times=TIMES)

    @cached_property
    def exact(self) -> Array:
        return exact_indentation(self.watched)

    def row(self, solved: SolvedMesh) -> Row:
        """Return what a mesh costs, relative errors by the name of the quantity, their estimate,
        and the mesh itself.
        """
        rings, solid = self.problem.merged, solved.half_space.solid
        compliance, shape = solved.wear.compliance, quality(solid.mesh)
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
            "least quality": float(shape.min()),
            "median quality": float(np.median(shape)),
            "mesh": solid.mesh,
        }


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Refine each way on each case; writes `refinement` and the figures."""
    columns = ("degree", "unknowns", "elements", "multipliers", *ERRORS, "greatest", "estimate")
    qualities = ("least quality", "median quality")
    fields = ("case", "family", "setting", *columns, *qualities, "remark")
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
    sequences = solve_all(ways, table, conclusions)
    rows = [row for row in table.rows if "greatest" in row]
    conclusions[:0] = conclude(rows, sequences)
    if rows:
        draw(rows, out / "error_against_unknowns.png")
    for case in cases:
        if finest := {way_of(row): row["mesh"] for row in rows if row["case"] == case.name}:
            path = out / f"meshes_{case.name.replace(' ', '_')}.png"
            draw_meshes(case, finest, path)
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


def families(case: Case, quick: bool, own: str | None = None) -> Iterator[Family]:
    """Yield each way to refine a mesh of a case, from coarse to fine; last a mesh file."""
    problem = case.problem

    def mesh_at(rtol: float, **settings: Any) -> Mesh:
        fem = FemAccuracy.model_validate(settings)
        return half_space_mesh(replace(problem, rtol=rtol, fem=fem)).mesh

    def level(setting: str, mesh: Mesh, degree: int, size: float = np.nan) -> Level:
        return Level(setting, lambda: case.row(solve_on(problem, mesh, degree)), size)

    def halved(way: str, mesh: Mesh) -> Family:
        sizes = {times: 0.5**times for times in range(3 if quick else 4)}
        refined = (
            level(f"{times} times", mesh.refined(times), DEGREE, size)
            for times, size in sizes.items()
        )
        return Family(f"{case.name}: {way}", refined, {"d0": Theory(1.0)})

    def raised(way: str, mesh: Mesh, degrees: range) -> Family:
        by_degree = [level(f"degree {degree}", mesh, degree) for degree in degrees]
        return Family(f"{case.name}: {way}", by_degree)

    coarse = uniform_mesh(problem.merged.ring_edges)
    yield halved("h, triangles", coarse)
    yield raised("p, triangles", mesh_at(GOAL, mesher="gmsh"), range(2, 5))
    tolerances = (1e-2, GOAL) if quick else (1e-1, 1e-2, 1e-3, 1e-4, GOAL, 1e-6)
    graded = (level(f"rtol {rtol:g}", mesh_at(rtol, mesher="gmsh"), DEGREE) for rtol in tolerances)
    yield Family(f"{case.name}: graded triangles", graded)
    rounds = enumerate(refine_adaptively(problem, coarse, GOAL / 2 if quick else GOAL / 10))
    adapted = (Level(f"round {number}", partial(case.row, solved)) for number, solved in rounds)
    yield Family(f"{case.name}: adaptive triangles", adapted)
    layered = mesh_at(1e-7, mesher="quads")
    if isinstance(layered, MeshQuad):  # triangles take their place where gmsh cannot be used
        few = {"rim_size": 0.5, "ring_size": 0.5, "truncation": WIDER_TRUNCATION}
        # without subdomains of lower degree
        plain = replace(mesh_at(GOAL, mesher="quads", **few), _subdomains=None)
        yield halved("h, quadrilaterals", plain)
        yield raised("p, quadrilaterals", layered, range(4, 8 if quick else 10))
    if own:

        def solve_own() -> Row:
            mesh, remark = own_mesh(problem, own)
            quads = isinstance(mesh, MeshQuad)
            degree = (problem.fem.degree or 6) if quads else triangle_degree(problem)
            return case.row(solve_on(problem, mesh, degree)) | {"remark": remark}

        yield Family(f"{case.name}: file", [Level(Path(own).name, solve_own)])


def own_mesh(problem: Problem, path: str) -> tuple[Mesh, str]:
    """Read the user's mesh, with a remark on how it was taken.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of it, or if it is no mesh of a half-space
    """
    return files.read(path, problem.merged.ring_edges, problem.units.length)


def way_of(row: Row) -> str:
    """Return how the mesh of a row was refined."""
    return str(row["family"].removeprefix(f"{row['case']}: "))


def conclude(rows: list[Row], sequences: list[Sequence]) -> list[str]:
    """Say the errors on the user's mesh, orders, and the unknowns with which each way reaches the
    goal.
    """
    lines = []
    for row in rows:
        if way_of(row) == "file":
            errors = ", ".join(f"{name} {row[name]:.1e}" for name in (*ERRORS, "estimate"))
            lines.append(
                f"{row['case']}: {row['setting']}, {row['elements']} elements of degree "
                f"{row['degree']}, errors: {errors}"
            )
    lines += [
        f"{halved.name}: d0 is of order {halved.last_order:.2f} between the finest, by theory 1"
        for halved in sequences
    ]
    for case in dict.fromkeys(row["case"] for row in rows):
        unknowns = {way_of(row): "do not reach it" for row in rows if row["case"] == case}
        for row in reversed(rows):
            if row["case"] == case and row["greatest"] <= GOAL:
                unknowns[way_of(row)] = f"{row['unknowns']} ({row['setting']})"
        reached = "; ".join(f"{way} {count}" for way, count in unknowns.items())
        lines.append(f"{case}: unknowns to {GOAL:g} in every quantity: {reached}")
    return lines


def draw(rows: list[Row], path: Path) -> None:
    """Draw errors against unknowns: a column for each case, a row for each quantity."""
    cases = list(dict.fromkeys(row["case"] for row in rows))
    ways = list(dict.fromkeys(way_of(row) for row in rows))
    figure = new_figure(0.6 + 3.2 * len(cases), 8.2)
    panels = figure.subplots(len(ERRORS), len(cases), sharex="col", sharey=True, squeeze=False)
    for line, (quantity, label) in zip(panels, ERRORS.items(), strict=True):
        for axes, case in zip(line, cases, strict=True):
            points = {
                way: [
                    (row["unknowns"], row[quantity])
                    for row in rows
                    if (row["case"], way_of(row)) == (case, way)
                ]
                for way in ways
            }
            curves = {way: np.array(points[way]).reshape(-1, 2).T for way in ways}
            ylabel = f"relative error\n{label}"
            draw_errors(axes, curves, title=case, xlabel="unknowns", ylabel=ylabel)
            axes.set_xscale("log")
            axes.axhline(GOAL, **FAINT)
            axes.label_outer()
    place = {"loc": "outside lower center", "ncols": 1 + len(cases), "frameon": False}
    figure.legend(*panels[0, 0].get_legend_handles_labels(), fontsize=9, **place)
    title = f"refinement in size (h), in degree (p),\ngraded and adaptive (goal {GOAL:g}: dotted)"
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)


def draw_meshes(case: Case, meshes: dict[str, Mesh], path: Path) -> None:
    """Draw the finest mesh of each way, whole and at three places."""
    rings = case.problem.merged
    views = {
        "under the punch": ((0.0, 1.15), 0.0, "$r/a$"),
        "at the rim": ((-2e-2, 2e-2), 1.0, "$(r-a)/a$"),
    }
    if len(rings.widths) > 1:
        narrowest = int(rings.widths.argmin())
        reach = min(2 * rings.widths.min(), 0.4)
        middle = float(rings.ring_edges[narrowest : narrowest + 2].mean())
        views["narrowest ring"] = ((-reach, reach), middle, rf"$r/a - {middle:.4g}$")
    figure = new_figure(3.2 * (1 + len(views)), 3.5 * len(meshes))
    panels = figure.subplots(len(meshes), 1 + len(views), squeeze=False)
    for (whole, *line), (way, mesh) in zip(panels, meshes.items(), strict=True):
        mesh_panel(whole, mesh, (0, truncation(mesh)), "whole", "$r/a$")
        whole.set_ylabel(f"{way}: depth $z/a$")
        for axes, (name, (view, centre, label)) in zip(line, views.items(), strict=True):
            mesh_panel(axes, mesh, view, name, label, centre)
    title = f"{case.name}: the finest mesh of each way; the bar above is the punch"
    figure.suptitle(title, fontsize=10)
    figure.savefig(path)
