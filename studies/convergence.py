"""Orders of convergence in the element size and the degree: finite elements and MDR, graded and uniform meshes.

For finite elements one base mesh is subdivided: an order is only as clean as its sequence of meshes.

Theory, for displacements of degree k and pressures of degree q: energies (d0, displacements, relaxation times) are of
order 2k on graded meshes and of order 1, set by the singular rim, on uniform ones. By MDR the energy norm of a pressure
is half an order weaker than the mean square: d0 is of order 2q+3, a history with its mean squares of order 2q+2, the RMS
gradient of order 2q. Even degrees come up to 2q+3, odd ones down: plane waves ``exp(ikx)`` at kh = 0.7 give 5.34, 6.60,
9.21, 10.77 (Fourier analysis, in the tests). Under a smooth pressure twelve elements see the limit; graded to the rim,
degree 4 meets roundoff before.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from mdr import direct
from mdr.compliance import compliance as mdr_compliance
from meshes.compliance import Compliance
from meshes.errors import RingwearError
from meshes.half_space import HalfSpaceMesh
from meshes.pressure_space import PressureSpace
from meshes.radial import Array, graded_breakpoints

from .contact import flat_start
from .levels import (
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
from .methods import edge_weight
from .natural import NaturalScene
from .scene import Scene
from .stages import Report
from .subdivision import base_mesh, coarse_field, condensed, subdivided
from .wear import Wear

FLAT = np.array([0.0, 1.0])
TRUNCATION, UNIFORM_TRUNCATION = 1e4, 4.0
# sizes of the base meshes: rim, ring edges, growth
PUNCH_SIZES, RING_SIZES, UNIFORM_SIZES = (4e-9, 4e-9, 0.7), (1e-7, 1e-7, 0.7), (0.35, 0.35, 0.0)
TIME = 1.0  # of the history, in natural units
# subdivisions by degree: of the homogeneous punch, of the same on a uniform mesh, of the scene's rings
PUNCH = {2: (2, 3, 4, 6, 8), 3: (2, 3, 4, 5), 4: (1, 2, 3, 4)}
UNIFORM = {2: (3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4)}
RINGS = {2: (4, 6, 8), 3: (3, 4, 5), 4: (1, 2, 3)}
QUICK_LEVELS = {2: (2, 3, 4), 3: (2, 3), 4: (2, 3)}
# MDR: elements under a smooth pressure; by degree, ratios of neighbouring sizes of the mesh graded to the rim
SMOOTH, SMOOTH_QUANTITY = (12, 16, 24, 32), "energy of a smooth pressure"
PUNCH_GRADINGS = {1: (0.5, 0.6, 0.7, 0.8), 2: (0.7, 0.78, 0.84, 0.88), 3: (0.3, 0.4, 0.5, 0.6), 4: (0.4, 0.5, 0.6, 0.65)}
PUNCH_RIM, PUNCH_ROUNDOFF = 1e-13, 1e-13
# degree 1 on the scene's rings: with higher ones errors cross zero or meet roundoff before orders settle
RING_GRADINGS, RING_EDGE = (0.6, 0.7, 0.78, 0.84), 1e-7
RAISED_DEGREES, RAISED_GRADING = (1, 2, 3, 4, 5, 6), 0.2
# relative errors below which the innermost elements (their share of d0 is proportional to their size) or roundoff count
SHARE_OF_RIM, RING_FLOORS = 0.06, {"RMS gradient": RING_EDGE, "": 2e-10}
Level = tuple[dict[str, float], int]  # quantities, unknowns
Orders = Mapping[str, float]
LEVEL_FIELDS = ("refined", "quantity", "size", "unknowns", "value", "error", "remark")
ORDER_FIELDS = (
    "refined", "quantity", "levels", "expected order", "least squares", "last levels", VERDICT, "between levels",
    "finest error", "Richardson value", "GCI", "three finest",
)  # fmt: skip


class Recorder:
    """Levels into sequences, and into the table as they come; a level that fails is a row, too.

    Parameters
    ----------
    table : with `LEVEL_FIELDS`
    exact : value of each quantity
    """

    def __init__(self, table: Table, exact: dict[str, float], report: Report) -> None:
        self.table, self.exact, self.report = table, exact, report
        self.sequences: dict[tuple[str, str], Sequence] = {}

    def level(self, refined: str, size: float, orders: Orders, compute: Callable[[], Level], floors: Orders) -> None:
        """Compute one level; `orders` are expected, below `floors` errors do not count; those of "" are for all others."""
        self.report(f"  level  {refined}, h = {size:.3g} ...")
        try:
            values, unknowns = compute()
        except RingwearError as error:
            self.table.add(refined=refined, size=size, remark=f"failed: {error}")
            return
        for quantity, value in values.items():
            exact = self.exact[quantity]
            order, floor = (known.get(quantity, known[""]) for known in (orders, floors))
            sequence = self.sequences.setdefault((refined, quantity), Sequence(refined, quantity, order, exact, floor))
            sequence.add(size, value)
            row = {"refined": refined, "quantity": quantity, "size": size, "unknowns": unknowns, "value": value}
            self.table.add(**row, error=(value - exact) / (exact or 1.0))

    def of(self, quantity: str, *names: str) -> Iterator[Sequence]:
        """Sequences of a quantity whose name begins with one of the names."""
        return (s for (refined, what), s in self.sequences.items() if what == quantity and refined.startswith(names))


class Quantities:
    """The quantities of a scene that are refined, and their exact values: closed form, or a fine MDR."""

    def __init__(self, natural: NaturalScene) -> None:
        self.edges, self.wear = natural.phases
        slope = direct.rms_slope(self.edges, direct.steady_pressures(self.edges, self.wear))
        known = {"d0": 0.5, SMOOTH_QUANTITY: 0.0, "RMS gradient": slope}
        self.exact = self(by_mdr(self.edges, RING_EDGE, 10, 0.15)) | known

    def __call__(self, compliance: Compliance) -> dict[str, float]:
        """Every quantity of a compliance, in natural units."""
        wear, space = Wear(compliance, self.wear, TIME), compliance.space
        state, history = wear.steady, wear.modal(np.array([TIME]))
        slopes = space.slope_gram(edge_weight(space, "line"))
        steady = compliance.factor @ state.pressure
        return {
            f"d({TIME:g})": float(history.indentation[0]),
            "slowest relaxation time": float(wear.relaxation_times[0]),
            f"force on the outer ring at {TIME:g}": float(space.ring_forces(self.edges)[-1] @ history.pressure[0]),
            "mean steady displacement": float(steady @ steady),
            "RMS gradient": float(np.sqrt(state.displacement @ slopes @ state.displacement)),
        }

    def by_mdr(self, degree: int, grading: float) -> Level:
        """The quantities by MDR on a radial mesh whose neighbouring sizes have the ratio `grading`."""
        found = by_mdr(self.edges, RING_EDGE, degree, grading)
        values = self(found)
        # the factor holds q exactly: the energy of a known pressure has no error to refine
        del values["mean steady displacement"]
        return values, found.space.size

    def by_elements(self, base: HalfSpaceMesh, degree: int, poisson_ratio: float, count: int) -> Level:
        """The quantities by finite elements on a subdivided mesh."""
        found, unknowns = condensed(subdivided(base, count, self.edges[1:]), self.edges, degree, poisson_ratio)
        return self(found), unknowns


def by_mdr(edges: Array, size: float, degree: int, grading: float) -> Compliance:
    """Compliance by MDR on a radial mesh graded to `size` at ring edges and rim."""
    breakpoints = graded_breakpoints(edges, size, size, grading)
    return mdr_compliance(PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), edges))


def punch_by_mdr(degree: int, grading: float) -> Level:
    """The flat start, singular at the rim, on a mesh graded to it."""
    found = by_mdr(FLAT, PUNCH_RIM, degree, grading)
    return {"d0": flat_start(found).indentation}, found.space.size


def smooth_by_mdr(degree: int, count: int) -> Level:
    """Share of the energy of the pressure ``exp(-2 r^2)`` that equal elements cannot hold.

    Galerkin's error is at right angles to what the space holds, so the share is a sum of squares and meets no roundoff.
    """
    fine = mdr_compliance(PressureSpace(np.linspace(0, 1, count + 1), np.full(count, degree + 6), FLAT))
    radii = (np.arange(16 * count) + 0.5) / (16 * count)
    pressure, *_ = np.linalg.lstsq(fine.space.matrix(radii).toarray(), np.exp(-2 * radii**2), rcond=None)
    energy, held = fine.factor @ pressure, fine.factor[:, fine.space.order <= degree]
    best, *_ = np.linalg.lstsq(held, energy, rcond=None)
    return {SMOOTH_QUANTITY: float(np.sum((energy - held @ best) ** 2) / np.sum(energy**2))}, held.shape[1]


def punch_by_elements(base: HalfSpaceMesh, tips: Array, degree: int, poisson_ratio: float, count: int) -> Level:
    """The flat start by finite elements on a subdivided mesh."""
    found, unknowns = condensed(subdivided(base, count, tips), FLAT, degree, poisson_ratio)
    return {"d0": flat_start(found).indentation}, unknowns


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Refine everything; writes `convergence.csv`, `orders.csv`, `convergence.md` and `convergence.png`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    by_degree: dict[int, float] = {}
    with threadpool_limits(1):
        quantities = Quantities(scene.natural)
        recorder = Recorder(Table(out / "convergence.csv", LEVEL_FIELDS), quantities.exact, report)
        with keeping_rows(conclusions):
            refine_mdr(recorder, quantities, quick)
            by_degree = raise_degree(recorder)
            refine_punch(recorder, scene.half_space.poisson_ratio, quick)
            if not quick:
                refine_rings(recorder, quantities, scene.half_space.poisson_ratio)
    orders = Table(out / "orders.csv", ORDER_FIELDS)
    for sequence in recorder.sequences.values():
        orders.add(**sequence.summary())
    conclusions[:0] = conclude(recorder)
    draw(recorder, by_degree, out / "convergence.png")
    write_markdown(out / "convergence.md", "Orders of convergence", conclusions, {"Orders": orders})
    return [*conclusions, orders.markdown()]


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


def conclude(recorder: Recorder) -> list[str]:
    """The orders of d0 in a line, and how all orders agree with theory in another."""

    def orders(mesh: str) -> str:
        return ", ".join(f"P{k} {s.order:.2f}" for k in PUNCH for s in recorder.of("d0", f"FEM P{k}, {mesh}"))

    return [
        f"d0 converges with order {orders('graded')} on graded meshes (theory 4, 6, 8), "
        f"but {orders('uniform')} on uniform ones (1).",
        verdicts(recorder.sequences.values()),
    ]


def draw(recorder: Recorder, by_degree: dict[int, float], path: Path) -> None:
    """Finite elements graded against uniform, MDR under a singular and a smooth pressure, and the error by degree."""
    figure = new_figure(9, 10.5)
    (elements, singular), (smooth, degrees) = figure.subplots(2, 2)
    error = r"relative error of the flat start, $|d_0 / (F/2aE^*) - 1|$"
    punch = [f"FEM P{degree}, {mesh}" for mesh in ("graded", "uniform") for degree in PUNCH]
    draw_orders(elements, recorder.of("d0", *punch), r"element size over the base mesh's, $h/h_0 = 1/n$", error)
    elements.set_title("finite elements", fontsize=9)
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
    for number, (label, curve) in enumerate(curves.items()):
        degrees.semilogy(list(curve), list(curve.values()), label=label, **style(number))
    degrees.set(xlabel="polynomial degree $k$", ylabel=error, xticks=RAISED_DEGREES)
    degrees.set_title("raising the degree on one mesh", fontsize=9)
    degrees.grid(True, color="0.88", linewidth=0.6)
    legend_below(degrees)
    figure.savefig(path)
