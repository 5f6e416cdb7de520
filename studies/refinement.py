"""Refinement: what an accuracy costs on uniform, graded, adaptive, layered and one's own meshes."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..meshes import SceneError, contact_radii
from ..meshes.by_gmsh import unavailable
from .crosscheck import Solution, Source
from .study.accept import accept, refuse_degree_without_mesh
from .study.draw import draw, titled
from .study.errors import DEFAULT, EIGENVALUE, ENERGY, STABLE
from .study.measure import measure
from .study.mesh_figures import (
    DrawnLevel,
    draw_meshes,
    draw_own_meshes,
    draw_pressure_errors,
    worst_place,
)
from .study.own import Methods, Quantities, length_of, read_meshes, read_methods, read_quantities
from .study.record import Record
from .study.reference import Reference, reference
from .study.study import Study, choose_parts, remarks, rows_of
from .study.theory import conclude_orders, observed_orders
from .study.way import Case, Part, Way
from .study.ways.finite_elements import (
    OWN_MESHES,
    adaptive,
    by_tolerance,
    degree_on,
    halved,
    own_meshes,
    raised_degree,
)
from .study.ways.runs import tolerances

if TYPE_CHECKING:
    from skfem import Mesh

TOLERANCES = tuple(10.0 ** (-half / 2) for half in range(2, 13))
TOLERANCES_QUICK = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Values of rtol for which graded and layered meshes are made."""
DEGREE_MESH_RTOL = 1e-7
"""Value of rtol for which the mesh is made on which the degree is raised."""
MOST_UNKNOWNS, MOST_UNKNOWNS_QUICK = 100_000, 40_000
"""Unknowns of the finest level, approximately."""
QUANTITIES = ("indentation", "pressure", "rms_slope", "steady_rms_slope", "steady_profile", ENERGY)
DRAWN = (("indentation", "start"), ("indentation", "later"), ("pressure", "later"))
DRAWN_ALWAYS = (("steady_rms_slope", "all"),)
"""Quantities in the figures, with their values of `when`."""
IN_SENTENCES = (("pressure", "later"), ("indentation", "later"))
"""Quantities whose cost is in the conclusions."""
GOALS = (1e-2, 1e-3, 1e-5)
"""Relative errors whose cost is reported."""
WITH_ORDERS = ("uniform triangles", "adaptive triangles", OWN_MESHES)
"""Ways whose errors have orders over 1 / sqrt(unknowns)."""
MESHES, RAISED = {"triangles": range(2, 5), "quadrilaterals": range(2, 17)}, "rising degree"
"""Degrees of the displacement for which stable multipliers exist, by kind of elements."""


def refinement(
    scene: Source = "five_rings",
    *,
    meshes: "Sequence[str | Mesh]" = (),
    degree: int | None = None,
    units: str = "",
    methods: Methods = None,
    quantities: Quantities = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Refine the mesh of a flat punch in every way, and tabulate what each accuracy costs.

    Parameters
    ----------
    scene : a scene, a file, the name of a bundled scene, or nested dictionaries
    meshes : your own mesh files or meshes of scikit-fem, from coarse to fine
    degree : polynomial degree of the finite elements on them
    units : unit of lengths in mesh files, such as "mm", or a factor on them, such as 0.1, if they
        are not those of the scene
    methods : methods of your own, whose tolerances are levels
    quantities : names as in results.nc, `energy`, and functions of a result
    quick : whether to use fewer and smaller levels
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    RingwearError
        if the reference cannot be computed
    """
    scene = accept("refinement", scene, radial_wear=True)
    known = tuple(dict.fromkeys((*QUANTITIES, *DEFAULT)))
    names, functions = read_quantities(quantities, known)
    named, own_methods = read_methods(methods, ("fem",), "refinement")
    refuse_degree_without_mesh(degree, bool(meshes))
    record, case = record or Record(), Case.of(scene)
    own_by_name = read_meshes(case.problem, meshes, length_of(scene, units)) if meshes else {}
    refuse_degrees(case, own_by_name, degree)
    rtols = TOLERANCES_QUICK if quick else TOLERANCES
    ways = [
        *(all_ways(quick, rtols) if named else []),
        *([own_meshes(own_by_name, degree)] if own_by_name else []),
        *(tolerances(each, rtols) for each in own_methods),
    ]
    wanted = (*dict.fromkeys((*names, *QUANTITIES)), *((EIGENVALUE,) if own_by_name else ()))
    references = list[Reference]()

    def exact(case: Case) -> Reference:
        references.append(reference(case, wanted, functions, confirmed=not quick))
        return references[-1]

    def keep(case: Case, way: Way, level: Any, solution: Solution) -> DrawnLevel | None:
        if solution.half_space is None or not (case.problem.times > 0).any():
            return None
        return DrawnLevel.of(case, way, level, solution, references[-1].values)

    most = MOST_UNKNOWNS_QUICK if quick else MOST_UNKNOWNS
    table = measure([case], ways, wanted, record, functions, exact, most_unknowns=most, keep=keep)
    # meshes of other ways are not similar to each other, so that their errors have no order
    similar = [way for way in ways if way.name in WITH_ORDERS or way.promises]
    fits = observed_orders(table, similar)
    rows = choose_parts(table, (*DRAWN, *DRAWN_ALWAYS), (*names, *functions))
    levels = [level for level in record.kept if level is not None]
    cost = costs(rows)
    of_own = fits[fits["way"] == OWN_MESHES]
    sentences = (
        *conclude_orders(of_own),
        *describe_own_meshes(case, table, levels),
        *conclude_costs(cost),
        *conclude_indicator(table),
        *conclude_orders(fits[fits["way"] != OWN_MESHES]),
        *remarks(record, quick),
    )
    figures = figures_of(case, scene.title, table, rows, levels)
    tables = {"costs": cost} if len(cost) else {}
    return Study("refinement", scene, table, fits, sentences, figures, tables)


def all_ways(quick: bool, rtols: Sequence[float]) -> list[Way]:
    """Return every way to refine the mesh of a flat punch, from coarse to fine."""
    ways = [
        halved(range(3 if quick else 4)),
        by_tolerance("triangles graded before solving", rtols, {"mesher": "gmsh", "degree": None}),
        adaptive(),
    ]
    if unavailable():  # gmsh makes the layered meshes
        return ways
    return [
        *ways,
        by_tolerance("the default: layers and degrees", rtols, {"mesher": "quads"}),
        raised_degree(range(4, 8 if quick else 10), DEGREE_MESH_RTOL),
    ]


def refuse_degrees(case: Case, meshes: "dict[str, Mesh]", degree: int | None) -> None:
    """Raise an error if the degree on a mesh of the user has no stable multipliers.

    Raises
    ------
    SceneError
        its message names the mesh and the degrees that have them
    """
    for name, mesh in meshes.items():
        kind = "triangles" if len(mesh.t) == 3 else "quadrilaterals"
        chosen = degree or degree_on(case.problem, mesh)
        if chosen not in MESHES[kind]:
            raise SceneError(
                f"--degree {chosen}: does not fit {name}, which has {kind}: give "
                f"{MESHES[kind][0]} to {MESHES[kind][-1]}"
            )


def figures_of(
    case: Case, title: str, table: pd.DataFrame, rows: pd.DataFrame, levels: list[DrawnLevel]
) -> dict[str, Any]:
    """Return all figures by their names; figures without data are left out."""
    if table["error"].isna().all():
        return {}
    heading = titled(title, "errors of each way to refine")
    note = "The seconds of adaptive triangles include all coarser levels and error indicators."
    figures = {
        "error_over_unknowns": draw(rows, "unknowns", title=heading),
        "error_over_seconds": draw(rows, "seconds", title=heading, note=note),
        "indicator": draw(
            table[table["quantity"] == ENERGY],
            "unknowns",
            estimates=True,
            title=titled(title, "energy norm of the error, and the indicator that estimates it"),
        ),
    }
    of_ways = [level for level in levels if level.way not in (RAISED, OWN_MESHES)]
    if of_ways:
        figures["meshes"] = draw_meshes(case, title, of_ways)
    if levels:
        figures["pressure_error"] = draw_pressure_errors(case, title, levels)
    if own := [level for level in levels if level.way == OWN_MESHES]:
        figures["own_meshes"] = draw_own_meshes(case, title, own)
    return figures


def costs(table: pd.DataFrame) -> pd.DataFrame:
    """Return the unknowns and seconds of the first level that reaches each goal; NaN if none does.

    The last column is the least error of the way.
    """
    rows, keys = [], ["case", "way", "quantity", "when"]
    for key, levels in table.dropna(subset=["error"]).groupby(keys, sort=False):
        errors = levels["error"].abs()
        for goal in GOALS:
            within = levels[errors <= goal]
            cost = within.iloc[0][["unknowns", "seconds"]] if len(within) else {}
            row = dict(zip(keys, key, strict=True)) | {"goal": goal, **dict(cost)}
            rows.append(row | {"least error": errors.min()})
    columns = [*keys, "goal", "unknowns", "seconds", "least error"]
    return pd.DataFrame(rows, columns=columns)


def conclude_costs(cost: pd.DataFrame) -> Iterator[str]:
    """Yield a line for each way: what each goal costs in the quantities of `IN_SENTENCES`."""
    for way, rows in rows_of(cost, IN_SENTENCES).groupby("way", sort=False):
        parts = []
        for (quantity, when), goals in rows.groupby(["quantity", "when"], sort=False):
            costs = [
                f"{row['goal']:g} costs {row['unknowns']:.0f} unknowns and {row['seconds']:.2g} s"
                if np.isfinite(row["seconds"])
                else f"{row['goal']:g} is not reached (least error {row['least error']:.1e})"
                for row in goals.to_dict("records")
            ]
            parts.append(f"{Part(str(quantity), str(when))} within {', '.join(costs)}")
        yield f"{way}: {'; '.join(parts)}."


def conclude_indicator(table: pd.DataFrame) -> Iterator[str]:
    """Yield how far the error indicator is from the true energy error."""
    rows = table[(table["quantity"] == ENERGY) & table["estimate"].notna() & (table["error"] > 0)]
    for way, levels in rows.groupby("way", sort=False):
        ratio = levels["estimate"] / levels["error"]
        yield (
            f"{way}: the error indicator is {ratio.min():.2g} to {ratio.max():.2g} times the true "
            f"energy error, over {len(levels)} levels."
        )


def describe_own_meshes(case: Case, table: pd.DataFrame, levels: list[DrawnLevel]) -> Iterator[str]:
    """Yield, for each mesh of the user, its errors, its stability, and where to refine it."""
    adaptive_pressure = table[
        (table["way"] == "adaptive triangles")
        & (table["quantity"] == "pressure")
        & (table["when"] == "later")
        & (table["error"] <= GOALS[1])
    ]
    facets = {(level.way, level.name): np.diff(contact_radii(level.mesh)).min() for level in levels}
    for level in levels:
        if level.way != OWN_MESHES:
            continue
        rows = table[(table["way"] == level.way) & (table["level"] == level.name)]
        named = {
            str(Part(row["quantity"], row["when"])): abs(row["error"])
            for row in rows.to_dict("records")
        }
        eigenvalue = named.pop(str(Part(EIGENVALUE)), np.nan)
        errors = ", ".join(f"{name} {error:.1e}" for name, error in named.items())
        kind = "triangles" if len(level.mesh.t) == 3 else "quadrilaterals"
        place = worst_place(case, level)
        sentences = [
            f"{level.name}, {level.mesh.nelements} {kind} of degree {level.degree} with "
            f"{level.unknowns} unknowns, has the errors: {errors}.",
            describe_multipliers(eigenvalue),
            f"{place.share:.0%} of the squared error of p(t = {place.time:.3g}) lies next to "
            f"r = {place.edge:.6g} a, {place.share_of_facet:.0%} on the facet from "
            f"{place.facet[0]:.6g} a to {place.facet[1]:.6g} a: refine there.",
        ]
        if level.indicators is not None:
            r, depth = level.mesh.p[:, level.mesh.t[:, level.indicators.argmax()]].mean(axis=1)
            sentences.append(
                f"The error indicator is greatest in the triangle at r = {r:.4g} a and depth "
                f"{depth:.4g} a."
            )
        if len(adaptive_pressure) and named.get("pressure, later", 0.0) > GOALS[1]:
            first = adaptive_pressure.iloc[0]
            finest = facets.get((first["way"], first["level"]))
            if finest:
                sentences.append(
                    f"The adaptive mesh whose pressure is within {GOALS[1]:g} has facets down to "
                    f"{finest:.0e} a; the facets of your mesh go down to "
                    f"{facets[level.way, level.name]:.0e} a."
                )
        yield " ".join(sentences)


def describe_multipliers(eigenvalue: float) -> str:
    """Return a sentence on the stability of the multipliers of a mesh."""
    if np.isnan(eigenvalue):
        return "The mesh has too many multipliers to compute their least eigenvalue."
    verdict = "they are stable" if eigenvalue >= STABLE else "they are unstable: change the degree"
    return f"The least eigenvalue of the multipliers is {eigenvalue:.2g}: {verdict}."
