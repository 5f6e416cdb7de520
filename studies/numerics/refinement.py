"""Refining the mesh, each way against what is known.

Uniformly, graded by default sizes, in the degree, and by an indicator.

Errors are those of the flat punch's indentation (Eq. 10), of the indentation over the whole history
against a far finer MDR, and of the steady displacement in closed form. A mesh file of the user's is
one more row, tested the same way.

On uniformly refined meshes d0 is of order 1 whatever the degree, set by the singular rim; `ringwear
study convergence` has the orders of graded meshes and degrees beside theory.
"""

import argparse
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from skfem import Mesh, MeshQuad
from threadpoolctl import threadpool_limits

from ...mdr.direct import greatest_displacement, steady_pressures
from ...meshes import files
from ...meshes.errors import MeshError, SceneError
from ...meshes.half_space import quality, truncation
from ...meshes.radial import Array
from ..figures.mesh import mesh_panel
from ..figures.style import FAINT, RED, curve, new_figure
from ..measured import exact
from ..methods.fem import half_space_mesh
from ..methods.quantities import array
from ..methods.sampler import Sampler
from ..problem.defaults import WIDER_TRUNCATION, triangle_degree
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy
from ..progress import LOG
from ..tables import Row, Table, keeping_rows, write_page
from ..wear.contact import press_flat
from .adaptive import DEGREE, Solved, adapted, solved, uniform

GOAL = 1e-5
TIMES = np.geomspace(1e-3, 20, 12)
ERRORS = {"d0": "of $d_0$", "history": "of $d(t)$, greatest", "steady": "of steady $u_{z,max}$"}
FIELDS = (
    "case",
    "mesh",
    "refined",
    "degree",
    "unknowns",
    "elements",
    "multipliers",
    *ERRORS,
    "greatest",
    "estimate",
    "least quality",
    "median quality",
)

Family = Iterable[tuple[str, Solved]]  # how far each mesh is refined, and what it gives
Results = dict[
    str, list[Row]
]  # of a case: rows by the kind of mesh, each also with the mesh itself as `geometry`


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Refine each way on each case; writes `refinement.csv`, `refinement.md` and the figures."""
    table, every = Table(out / "refinement.csv", FIELDS), cases(scene.problem)
    conclusions, results = list[str](), dict[Case, Results]()
    with threadpool_limits(1), keeping_rows(conclusions):
        for case in every[::2] if options.quick and not options.mesh else every:
            own = {}
            if options.mesh:
                try:
                    own["file"] = [own_mesh(case.problem, options.mesh)]
                except MeshError as error:
                    if case is every[0]:  # what does not fit the flat punch fits nothing
                        raise SceneError(f"--mesh {error}") from error
                    conclusions.append(f"{case.name}: refused: {error}")
            ways = families(case.problem, options.quick) | own
            for name, family in ways.items():
                LOG.info("refinement  %s: %s ...", case.name, name)
                for refined, one in family:
                    row = {"case": case.name, "mesh": name, "refined": refined, **case.row(one)}
                    table.add(**row)
                    results.setdefault(case, {}).setdefault(name, []).append(row)
            conclusions += [f"{case.name}: {line}" for line in concluded(results[case])]
    LOG.info("refinement  figures ...")
    if results:
        draw(results, out / "error_against_unknowns.png")
    for case, rows in results.items():
        draw_meshes(case, rows, out / f"meshes_{case.name.replace(' ', '_')}.png")
    write_page(out / "refinement.md", "Refinement of the mesh", conclusions, {"Rows": table})
    return conclusions


@dataclass(frozen=True, eq=False)
class Case:
    """A problem with what is known of it."""

    name: str
    problem: Problem

    @cached_property
    def history(self) -> Array:
        """Indentation at `TIMES`."""
        return array(exact(replace(self.problem, times=TIMES)), "indentation")

    def row(self, one: Solved) -> Row:
        """What a mesh costs and gives.

        Relative errors by the name of the quantity, and their estimate.
        """
        rings, wear, solid = self.problem.merged, one.wear, one.half_space.solid
        space, shape = wear.compliance.space, quality(solid.mesh)
        steady = float(Sampler(self.problem, space).steady(wear.steady)["steady_displacement_max"])
        errors = {
            "d0": abs(press_flat(wear.compliance).indentation / D0 - 1),
            "history": float(np.abs(wear.modal(TIMES).indentation / self.history - 1).max()),
            "steady": abs(
                steady / greatest_displacement(rings.ring_edges, steady_pressures(*rings)) - 1
            ),
        }
        return errors | {
            "degree": solid.degree,
            "unknowns": one.half_space.unknowns,
            "elements": solid.mesh.nelements,
            "multipliers": space.size,
            "greatest": max(errors.values()),
            "estimate": one.estimate,
            "least quality": float(shape.min()),
            "median quality": float(np.median(shape)),
            "geometry": solid.mesh,
        }


def cases(problem: Problem) -> list[Case]:
    """The flat punch, the problem, and the problem with its middle ring narrow."""
    flat = Case("flat punch", replace(problem, rings=Rings(np.array([0.0, 1.0]), np.ones(1))))
    ring_edges, wear_coefficients = problem.rings
    if len(wear_coefficients) == 1:
        return [flat]
    narrow, middle = ring_edges.copy(), (len(wear_coefficients) - 1) // 2
    narrow[middle + 1] = min(narrow[middle + 1], narrow[middle] + 1e-3)
    return [
        flat,
        Case("scene", problem),
        Case("narrow ring", replace(problem, rings=Rings(narrow, wear_coefficients))),
    ]


def families(problem: Problem, quick: bool) -> dict[str, Family]:
    """Each way to refine a mesh, from coarse to fine; solved one by one as they are asked for."""

    def meshed(rtol: float, fem: FemAccuracy) -> Mesh:
        return half_space_mesh(replace(problem, rtol=rtol, fem=fem)).mesh

    def in_size(mesh: Mesh) -> Family:
        return (
            (f"{times} times", solved(problem, mesh.refined(times), DEGREE))
            for times in range(3 if quick else 4)
        )

    def in_degree(mesh: Mesh, degrees: range) -> Family:
        return ((f"degree {degree}", solved(problem, mesh, degree)) for degree in degrees)

    triangles, quads = FemAccuracy(mesher="gmsh"), FemAccuracy(mesher="quads")
    few = FemAccuracy(mesher="quads", rim_size=0.5, ring_size=0.5, truncation=WIDER_TRUNCATION)
    tolerances = (1e-2, GOAL) if quick else (1e-1, 1e-2, 1e-3, 1e-4, GOAL, 1e-6)
    coarse = uniform(problem.merged.ring_edges)
    rounds = enumerate(adapted(problem, coarse, GOAL / 2 if quick else GOAL / 10))
    out: dict[str, Family] = {
        "h, triangles": in_size(coarse),
        "p, triangles": in_degree(meshed(GOAL, triangles), range(2, 5)),
        "graded triangles": (
            (f"rtol {rtol:g}", solved(problem, meshed(rtol, triangles), DEGREE))
            for rtol in tolerances
        ),
        "adaptive triangles": ((f"round {number}", one) for number, one in rounds),
    }
    layered = meshed(1e-7, quads)
    if isinstance(layered, MeshQuad):  # triangles take their place where gmsh cannot be used
        # without subdomains of lower degree
        out["h, quadrilaterals"] = in_size(replace(meshed(GOAL, few), _subdomains=None))
        out["p, quadrilaterals"] = in_degree(layered, range(4, 8 if quick else 10))
    return out


def own_mesh(problem: Problem, path: str) -> tuple[str, Solved]:
    """The user's mesh.

    Refused if a ring edge is not a vertex of it, or if it is no mesh of a half-space.
    """
    mesh, remark = files.read(path, problem.merged.ring_edges, problem.units.length)
    degree = (problem.fem.degree or 6) if isinstance(mesh, MeshQuad) else triangle_degree(problem)
    return Path(path).name + (f" ({remark})" if remark else ""), solved(problem, mesh, degree)


def concluded(rows: Results) -> list[str]:
    """The errors on the user's mesh, if there is one, orders, and the unknowns with which each way
    reaches the goal.
    """
    lines, unknowns = list[str](), list[str]()
    for row in rows.get("file", ()):
        errors = ", ".join(f"{quantity} {row[quantity]:.1e}" for quantity in (*ERRORS, "estimate"))
        lines.append(
            f"{row['refined']}, {row['elements']} elements of degree {row['degree']}, errors: "
            f"{errors}"
        )
    for name, own in rows.items():
        reaching = [
            f"{row['unknowns']} ({row['refined']})" for row in own if row["greatest"] <= GOAL
        ]
        unknowns.append(f"{name} {reaching[0] if reaching else 'do not reach it'}")
        if name.startswith("h, ") and len(own) > 1:  # sizes are halved
            order = np.log2(own[-2]["d0"] / own[-1]["d0"])
            lines.append(f"{name}: d0 is of order {order:.2f} between the finest, by theory 1")
    return [*lines, f"unknowns to {GOAL:g} in every quantity: {'; '.join(unknowns)}"]


def draw(results: dict[Case, Results], path: Path) -> None:
    """Errors against unknowns: a column for each case, a row for each quantity."""
    figure = new_figure(0.6 + 3.2 * len(results), 8.2)
    panels = figure.subplots(len(ERRORS), len(results), sharex="col", sharey=True, squeeze=False)
    for line, (quantity, label) in zip(panels, ERRORS.items(), strict=True):
        for axes, (case, rows) in zip(line, results.items(), strict=True):
            for number, (kind, own) in enumerate(rows.items()):
                unknowns, errors = ([row[name] for row in own] for name in ("unknowns", quantity))
                axes.loglog(
                    unknowns,
                    errors,
                    label=kind,
                    **curve(number) | ({"color": RED} if kind == "file" else {}),
                )
            axes.set(title=case.name, xlabel="unknowns", ylabel=f"relative error\n{label}")
            axes.grid(True, color="0.9", linewidth=0.6)
            axes.axhline(GOAL, **FAINT)
            axes.label_outer()
    known = panels[0, 0].get_legend_handles_labels()
    figure.legend(
        *known, loc="outside lower center", ncols=1 + len(results), frameon=False, fontsize=9
    )
    figure.suptitle(
        f"refinement in size (h), in degree (p),\ngraded and adaptive (goal {GOAL:g}: dotted)",
        fontsize=10,
    )
    figure.savefig(path)


def draw_meshes(case: Case, rows: Results, path: Path) -> None:
    """The finest mesh of each kind: whole, under the punch, at the narrowest ring, at the rim."""
    rings = case.problem.merged
    views = [
        ("under the punch", (0.0, 1.15), 0.0, "$r/a$"),
        ("at the rim", (-2e-2, 2e-2), 1.0, "$(r-a)/a$"),
    ]
    if len(rings.widths) > 1:
        narrowest = int(rings.widths.argmin())
        reach, middle = (
            min(2 * rings.widths.min(), 0.4),
            float(rings.ring_edges[narrowest : narrowest + 2].mean()),
        )
        views.insert(1, ("narrowest ring", (-reach, reach), middle, rf"$r/a - {middle:.4g}$"))
    figure = new_figure(3.2 * (1 + len(views)), 3.5 * len(rows))
    panels = figure.subplots(len(rows), 1 + len(views), squeeze=False)
    for line, (kind, (*_, finest)) in zip(panels, rows.items(), strict=True):
        mesh = finest["geometry"]
        mesh_panel(line[0], mesh, (0, truncation(mesh)), "whole", "$r/a$")
        for axes, (name, view, centre, label) in zip(line[1:], views, strict=True):
            mesh_panel(axes, mesh, view, name, label, centre)
        line[0].set_ylabel(f"{kind}: depth $z/a$")
    figure.suptitle(
        f"{case.name}: the finest mesh of each kind; the bar above is the punch", fontsize=10
    )
    figure.savefig(path)
