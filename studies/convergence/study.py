"""Orders of convergence in the element size and the degree: finite elements and MDR, graded and uniform meshes.

For finite elements one base mesh is subdivided: an order is only as clean as its sequence of meshes.

Theory, for displacements of degree k and pressures of degree q: energies (d0, displacements, relaxation times) are of
order 2k on graded meshes and of order 1, set by the singular rim, on uniform ones. By MDR the energy norm of a pressure
is half an order weaker than the mean square: d0 is of order 2q+3, a history with its mean squares of order 2q+2, the RMS
gradient of order 2q. Even degrees come up to 2q+3, odd ones down: plane waves ``exp(ikx)`` at kh = 0.7 give 5.34, 6.60,
9.21, 10.77 (Fourier analysis, in the tests). Under a smooth pressure twelve elements see the limit; graded to the rim,
degree 4 meets roundoff before.

On quadrilaterals whose layers shrink by ``q``, the degree k itself is raised (hp). A layer ends one layer off the singular
point: polynomials converge there as ``r^k`` with ``r = (1-sqrt q)/(1+sqrt q)``, by Bernstein's ellipse (Gui & Babuška 1986),
and energies as ``r^2k``: a factor of 9 per degree for q = 1/4. Layers further in have lower degrees, but ever less energy:
they take some of the factor, and powers of k make it greater at first.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.studies.convergence.cases import (
    FLAT,
    LEVEL_FIELDS,
    RING_EDGE,
    SMOOTH_QUANTITY,
    TRUNCATION,
    Quantities,
    Recorder,
    punch_by_elements,
    punch_by_mdr,
    punch_by_quads,
    smooth_by_mdr,
)
from ringwear.studies.convergence.levels import (
    VERDICT,
    Sequence,
    Table,
    draw_orders,
    keeping_rows,
    legend_below,
    new_figure,
    style,
    verdicts,
    write_markdown,
)
from ringwear.studies.methods.quads import FACTOR as LAYER_FACTOR
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.refinement.subdivision import base_mesh, coarse_field
from threadpoolctl import threadpool_limits

UNIFORM_TRUNCATION = 4.0
# sizes of the base meshes: rim, ring edges, growth
PUNCH_SIZES, RING_SIZES, UNIFORM_SIZES = (4e-9, 4e-9, 0.7), (1e-7, 1e-7, 0.7), (0.35, 0.35, 0.0)
# subdivisions by degree: of the homogeneous punch, of the same on a uniform mesh, of the scene's rings
PUNCH = {2: (2, 3, 4, 6, 8), 3: (2, 3, 4, 5), 4: (1, 2, 3, 4)}
UNIFORM = {2: (3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4)}
RINGS = {2: (4, 6, 8), 3: (3, 4, 5), 4: (1, 2, 3)}
QUICK_LEVELS = {2: (2, 3, 4), 3: (2, 3), 4: (2, 3)}
# MDR: elements under a smooth pressure; by degree, ratios of neighbouring sizes of the mesh graded to the rim
SMOOTH = (12, 16, 24, 32)
PUNCH_GRADINGS = {1: (0.5, 0.6, 0.7, 0.8), 2: (0.7, 0.78, 0.84, 0.88), 3: (0.3, 0.4, 0.5, 0.6), 4: (0.4, 0.5, 0.6, 0.65)}
PUNCH_ROUNDOFF = 1e-13
# degree 1 on the scene's rings: with higher ones errors cross zero or meet roundoff before orders settle
RING_GRADINGS = (0.6, 0.7, 0.78, 0.84)
RAISED_DEGREES, RAISED_GRADING = (1, 2, 3, 4, 5, 6), 0.2
QUADS, QUAD_DEGREES = "FEM quads", tuple(range(4, 12))
QUAD_FLOORS = {"RMS gradient": RING_EDGE, "": 1e-13}
FACTOR = ((1 + LAYER_FACTOR**0.5) / (1 - LAYER_FACTOR**0.5)) ** 2  # per degree
# relative errors below which the innermost elements (their share of d0 is proportional to their size) or roundoff count
SHARE_OF_RIM, RING_FLOORS = 0.06, {"RMS gradient": RING_EDGE, "": 2e-10}
ORDER_FIELDS = (
    "refined", "quantity", "levels", "expected order", "least squares", "last levels", VERDICT, "between levels",
    "finest error", "Richardson value", "GCI", "three finest",
)  # fmt: skip
FACTOR_FIELDS = (
    "refined", "quantity", "degrees", "expected factor", "least squares", "between degrees", "finest error",
)  # fmt: skip


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Refine everything; writes `convergence.csv`, `orders.csv`, `factors.csv`, `convergence.md` and `convergence.png`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    by_degree: dict[int, float] = {}
    with threadpool_limits(1):
        quantities = Quantities(scene.natural)
        recorder = Recorder(Table(out / "convergence.csv", LEVEL_FIELDS), quantities.exact, report)
        degrees = Recorder(recorder.table, quantities.exact, report)
        with keeping_rows(conclusions):
            refine_mdr(recorder, quantities, quick)
            by_degree = raise_degree(recorder)
            raise_quads(degrees, quantities, scene.half_space.poisson_ratio, quick)
            refine_punch(recorder, scene.half_space.poisson_ratio, quick)
            if not quick:
                refine_rings(recorder, quantities, scene.half_space.poisson_ratio)
    orders = Table(out / "orders.csv", ORDER_FIELDS)
    for sequence in recorder.sequences.values():
        orders.add(**sequence.summary())
    gained = Table(out / "factors.csv", FACTOR_FIELDS)
    for sequence in degrees.sequences.values():
        gained.add(**factors(sequence))
    conclusions[:0] = conclude(recorder, degrees)
    draw(recorder, degrees, by_degree, out / "convergence.png")
    tables = {"Orders": orders, "Factors per degree on quadrilaterals": gained}
    write_markdown(out / "convergence.md", "Orders of convergence", conclusions, tables)
    return [*conclusions, *(table.markdown() for table in tables.values())]


def refine_mdr(recorder: Recorder, quantities: Quantities, quick: bool) -> None:
    """MDR in the element size: a smooth pressure, the singular flat start, and the history of the scene's rings."""

    def size(grading: float) -> float:  # how fast polynomials converge if singular one element away (Bernstein's ellipse)
        return float((1 - grading**0.5) / (1 + grading**0.5))

    degrees = (1, 2) if quick else (1, 2, 3, 4)
    for degree in degrees:
        name = f"MDR degree {degree}, uniform"
        for count in SMOOTH:
            recorder.level(name, 1 / count, {"": 2 * degree + 3}, partial(smooth_by_mdr, degree, count), {"": 0.0})
    for degree in degrees:
        name, orders, floors = f"MDR degree {degree}, graded", {"": 2 * degree + 3}, {"": PUNCH_ROUNDOFF}
        for grading in PUNCH_GRADINGS[degree]:
            recorder.level(name, size(grading), orders, partial(punch_by_mdr, degree, grading), floors)
    orders = {"": 4, "RMS gradient": 2}
    for grading in RING_GRADINGS[: 3 if quick else None]:
        recorder.level("MDR degree 1, rings", size(grading), orders, partial(quantities.by_mdr, 1, grading), RING_FLOORS)


def raise_degree(recorder: Recorder) -> dict[int, float]:
    """Error of d0 by MDR on one radial mesh, by the degree: each gains a factor."""
    by_degree = {}
    for degree in RAISED_DEGREES:
        values, unknowns = punch_by_mdr(degree, RAISED_GRADING)
        row = {"refined": f"MDR, degree {degree} on one mesh", "quantity": "d0", "value": values["d0"]}
        by_degree[degree] = abs(values["d0"] / 0.5 - 1)
        recorder.table.add(**row, unknowns=unknowns, error=values["d0"] / 0.5 - 1)
    return by_degree


def raise_quads(recorder: Recorder, quantities: Quantities, poisson_ratio: float, quick: bool) -> None:
    """The flat start and the rings on quadrilaterals; the order over ``10^-degree`` is the digits that a degree gains."""
    levels = (("punch", punch_by_quads),) if quick else (("punch", punch_by_quads), ("rings", quantities.by_quads))
    for name, compute in levels:
        for degree in QUAD_DEGREES:
            level, digits = partial(compute, poisson_ratio, degree), {"": np.log10(FACTOR)}
            recorder.level(f"{QUADS}, {name}", 0.1**degree, digits, level, QUAD_FLOORS, degree)


def quad_degrees(sequence: Sequence) -> list[int]:
    """Degrees of the levels that did not fail."""
    return [degree for degree in QUAD_DEGREES if 0.1**degree in sequence.sizes]


def factors(sequence: Sequence) -> dict[str, Any]:
    """A row for the table of factors per degree; in brackets where one of two errors does not count."""
    between = sequence.errors[:-1] / sequence.errors[1:]
    both = sequence.counted[:-1] & sequence.counted[1:]
    return {
        "refined": sequence.name,
        "quantity": sequence.quantity,
        "degrees": " ".join(map(str, quad_degrees(sequence))),
        "expected factor": FACTOR,
        "least squares": 10**sequence.order,
        "between degrees": " ".join(
            f"{factor:.1f}" if counts else f"({factor:.1f})" for factor, counts in zip(between, both, strict=True)
        ),
        "finest error": f"{sequence.errors[-1]:.1e}",
    }


def refine_punch(recorder: Recorder, poisson_ratio: float, quick: bool) -> None:
    """The flat start by finite elements, on a graded and on a uniform mesh."""
    meshes = (
        ("graded", FLAT[1:], PUNCH, base_mesh(coarse_field(FLAT, PUNCH_SIZES, TRUNCATION))),
        ("uniform", FLAT[:0], UNIFORM, base_mesh(coarse_field(FLAT, UNIFORM_SIZES, UNIFORM_TRUNCATION))),
    )
    for name, tips, levels, base in meshes:
        for degree, counts in (QUICK_LEVELS if quick else levels).items():
            orders = {"": 2 * degree if len(tips) else 1}
            for count in counts:
                compute = partial(punch_by_elements, base, tips, degree, poisson_ratio, count)
                recorder.level(f"FEM P{degree}, {name}", 1 / count, orders, compute, {"": SHARE_OF_RIM * PUNCH_SIZES[0]})


def refine_rings(recorder: Recorder, quantities: Quantities, poisson_ratio: float) -> None:
    """The scene's rings by finite elements, on a mesh graded to every ring edge."""
    base = base_mesh(coarse_field(quantities.edges, RING_SIZES, TRUNCATION))
    for degree, counts in RINGS.items():
        # slopes are those of the displacement on the multipliers' space, one degree lower
        orders = {"": 2 * degree, "RMS gradient": 2 * (degree - 1)}
        for count in counts:
            compute = partial(quantities.by_elements, base, degree, poisson_ratio, count)
            recorder.level(f"FEM P{degree}, rings, graded", 1 / count, orders, compute, RING_FLOORS)


def conclude(recorder: Recorder, degrees: Recorder) -> list[str]:
    """The orders of d0 in a line, how all orders agree with theory, and what a degree gains on quadrilaterals."""

    def orders(mesh: str) -> str:
        return ", ".join(f"P{k} {s.order:.2f}" for k in PUNCH for s in recorder.of("d0", f"FEM P{k}, {mesh}"))

    return [
        f"d0 converges with order {orders('graded')} on graded meshes (theory 4, 6, 8), "
        f"but {orders('uniform')} on uniform ones (1).",
        verdicts(recorder.sequences.values()),
        *(
            f"On quadrilaterals each degree takes the error of d0 down by {10**s.order:.1f} (theory: in the end "
            f"{FACTOR:.0f}), to {s.errors[-1]:.0e} at degree {quad_degrees(s)[-1]}."
            for s in degrees.of("d0", QUADS)
        ),
    ]


def quad_curves(degrees: Recorder, name: str) -> dict[str, dict[int, float]]:
    """Errors on quadrilaterals by degree, of each quantity."""
    found = (s for s in degrees.sequences.values() if s.name == f"{QUADS}, {name}")
    return {
        f"FEM quads, {s.quantity}: {10**s.order:.1f} per degree": dict(zip(quad_degrees(s), s.errors.tolist(), strict=True))
        for s in found
    }


def draw_degrees(axes: Any, curves: Mapping[str, Mapping[int, float]]) -> None:
    """Errors by degree, and the factor that theory has for quadrilaterals."""
    for number, (label, curve) in enumerate(curves.items()):
        axes.semilogy(list(curve), list(curve.values()), label=label, **style(number))
    degrees = np.array(QUAD_DEGREES)
    theory = 1e-5 * FACTOR ** (QUAD_DEGREES[0] - degrees)
    axes.semilogy(degrees, theory, color="0.8", linewidth=4, zorder=0, label=f"theory for quads: {FACTOR:.0f} per degree")
    axes.set_xlabel("polynomial degree $k$")
    axes.grid(True, color="0.88", linewidth=0.6)
    legend_below(axes)


def draw_unknowns(axes: Any, rows: Iterable[Mapping[str, Any]], names: Iterable[str]) -> None:
    """Error of the flat start over unknowns."""
    for number, name in enumerate(names):
        own = [row for row in rows if (row["refined"], row.get("quantity")) == (name, "d0")]
        axes.loglog([row["unknowns"] for row in own], [abs(row["error"]) for row in own], label=name, **style(number))
    axes.grid(True, color="0.88", linewidth=0.6)
    legend_below(axes, ncols=2)


def draw(recorder: Recorder, degrees: Recorder, by_degree: dict[int, float], path: Path) -> None:
    """Finite elements by size and by unknowns, MDR under a singular and a smooth pressure, and errors by degree."""
    figure = new_figure(9, 14)
    (elements, unknowns), (singular, smooth), (raised, rings) = figure.subplots(3, 2)
    error = r"relative error of the flat start, $|d_0 / (F/2aE^*) - 1|$"
    punch = [f"FEM P{degree}, {mesh}" for mesh in ("graded", "uniform") for degree in PUNCH]
    draw_orders(elements, recorder.of("d0", *punch), r"element size over the base mesh's, $h/h_0 = 1/n$", error)
    elements.set_title("finite elements, by size", fontsize=9)
    draw_unknowns(unknowns, recorder.table.rows, [*punch, f"{QUADS}, punch"])
    unknowns.set(xlabel="unknowns", ylabel=error, title="finite elements, by unknowns")
    size = r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of neighbouring sizes"
    draw_orders(singular, recorder.of("d0", "MDR"), size, error)
    singular.set_title("MDR, elements graded to the rim", fontsize=9)
    draw_orders(
        smooth, recorder.of(SMOOTH_QUANTITY, "MDR"), "element size over the punch radius, $h/a$", "share of energy lost"
    )
    smooth.set_title(r"MDR, smooth pressure $\exp(-2r^2/a^2)$", fontsize=9)
    curves = {f"MDR, pressure of degree $k$, $q$ = {RAISED_GRADING:g}": by_degree}
    for mesh in ("graded", "uniform"):
        found = ((k, s) for k in PUNCH for s in recorder.of("d0", f"FEM P{k}, {mesh}") if 1 / 3 in s.sizes)
        label = f"FEM, displacement of degree $k$, {mesh}, $n$ = 3"
        curves[label] = {k: float(s.errors[s.sizes == 1 / 3][0]) for k, s in found}
    draw_degrees(raised, curves | quad_curves(degrees, "punch"))
    raised.set(ylabel=error, title="raising the degree, flat start")
    draw_degrees(rings, quad_curves(degrees, "rings"))
    rings.set(ylabel="relative error", title="raising the degree, rings on quadrilaterals")
    for axes in (unknowns, raised, rings):
        axes.title.set_fontsize(9)
    figure.savefig(path)
