"""What the outer boundary costs: the flat start against ``a/R``, by far field, shape and Poisson's ratio.

One local mesh serves every R: a graded quarter disc of radius 2 a, with layers of geometrically growing triangles
around it, of which the outer ones are left off; stretched, the same mesh fills a square box of half-width R. One
condensation gives every far field: without its last row, the factor of the compliance belongs to the same half-space
with one pole less, and at last to a clamped boundary. Errors are differences to `MOST_POLES` at the same R, which err
by the discretisation alone: by the rim, and by nodal values that stand for the poles on the outer boundary.

Theory: with n poles tied, the first one neglected falls as ``1/rho^(2n+1)``, and the energy that it has outside R as
``(a/R)^(4n+1)``: order 1, 5, 9, 13 for a clamped boundary and one, two, three poles, whatever the shape. The next pole
adds a term smaller by ``(a/R)^2``, so levels count from R = `ASYMPTOTIC` on.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.half_space import truncation
from ringwear.meshes.radial import Array
from ringwear.meshes.size_field import SizeField
from ringwear.studies.convergence.levels import (
    VERDICT,
    Sequence,
    Table,
    draw_orders,
    keeping_rows,
    legend_below,
    new_figure,
    verdicts,
    write_markdown,
)
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.refinement.subdivision import CORE, base_mesh, boxed, condensed, layered
from ringwear.studies.wear.contact import flat_start
from skfem import MeshTri
from threadpoolctl import threadpool_limits

EDGES = np.array([0.0, 1.0])  # a flat punch: rings do not matter to the far field
DEGREE = 4
SIZES = 1e-7, 0.3  # rim, growth
QUICK_SIZES = 1e-5, 0.35
LAYERS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 36)
QUICK_LAYERS = (0, 2, 4, 5, 6, 7, 8)
MOST_POLES = 6
ROUNDOFF = 1e-12  # a hundred times what is left of three poles far out
ASYMPTOTIC = 4.0
POISSON_RATIOS = (0.0, 0.3, 0.4999, 0.5)
SHAPES = {"disc": lambda mesh: mesh, "box": boxed}
FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}
FIELDS = ("poisson_ratio", "shape", "far_field", "R", "unknowns", "d0", "error", "truncation", "remark")
ORDER_FIELDS = (
    "nu", "shape", "far field", "expected order", "least squares", "last levels", VERDICT, "between levels",
    "R of those that count", "truncation at 4 a", "overtaken by the discretisation from",
)  # fmt: skip


def indentations(mesh: MeshTri, poisson_ratio: float) -> tuple[list[float], int]:
    """The flat start with a clamped boundary and with 1, 2, ... `MOST_POLES` poles, and the number of unknowns."""
    compliance, unknowns = condensed(mesh, EDGES, DEGREE, poisson_ratio, tuple(range(0, 2 * MOST_POLES, 2)))
    last = len(compliance.factor) - MOST_POLES
    factors = (compliance.factor[: last + count] for count in range(MOST_POLES + 1))
    return [flat_start(replace(compliance, factor=factor)).indentation for factor in factors], unknowns


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Vary R, its shape, the far field and Poisson's ratio; writes `truncation` and `orders`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    table, orders = Table(out / "truncation.csv", FIELDS), Table(out / "orders.csv", ORDER_FIELDS)
    studied: list[Truncation] = []
    ratios = sorted({0.3, scene.half_space.poisson_ratio} if quick else {*POISSON_RATIOS, scene.half_space.poisson_ratio})
    with threadpool_limits(1), keeping_rows(conclusions):
        rim, growth = QUICK_SIZES if quick else SIZES
        core = base_mesh(SizeField((0.0, 1.0), rim, rim, growth, CORE))
        meshes = [layered(core, count) for count in (QUICK_LAYERS if quick else LAYERS)]
        for ratio in ratios:
            for shape in SHAPES:
                studied.append(Truncation(ratio, shape))
                studied[-1].study(meshes, table, report)
    studied = [one for one in studied if len(one.discretisation.sizes)]  # the last may have none if interrupted
    for one in studied:
        for name in FAR_FIELDS:
            orders.add(**one.order_row(name))
    conclusions[:0] = conclude(studied)
    draw(studied, out / "truncation.png")
    write_markdown(out / "truncation.md", "Truncation of the half-space", conclusions, {"Orders in a/R": orders})
    return [*conclusions, orders.markdown()]


def _sequences() -> dict[str, Sequence]:
    # values are over that with most poles, whose truncation error is nil
    return {
        name: Sequence(name, "d0", order, 1.0, ROUNDOFF, coarsest=1.001 / ASYMPTOTIC) for name, order in FAR_FIELDS.items()
    }


@dataclass(frozen=True, eq=False)
class Truncation:
    """Truncation errors at one Poisson's ratio and shape by far field, and what the discretisation errs by."""

    poisson_ratio: float
    shape: str
    sequences: dict[str, Sequence] = field(default_factory=_sequences)
    discretisation: Sequence = field(default_factory=lambda: Sequence("discretisation", "d0", exact=1.0))

    def study(self, meshes: list[MeshTri], table: Table, report: Report) -> None:
        """Compute every R."""
        for disc in meshes:
            outer = truncation(disc)
            row = {"poisson_ratio": self.poisson_ratio, "shape": self.shape, "R": outer}
            report(f"  level  nu = {self.poisson_ratio:g}, {self.shape}, R = {outer:.3g} a ...")
            try:
                found, unknowns = indentations(SHAPES[self.shape](disc), self.poisson_ratio)
            except RingwearError as error:
                table.add(**row, remark=f"failed: {error}")
                continue
            self.discretisation.add(1 / outer, found[-1] / 0.5)
            for name, value in zip(FAR_FIELDS, found, strict=False):
                self.sequences[name].add(1 / outer, value / found[-1])
                table.add(
                    **row, far_field=name, unknowns=unknowns, d0=value, error=value / 0.5 - 1,
                    truncation=value / found[-1] - 1,
                )  # fmt: skip

    def at_four(self, name: str) -> float:
        """Truncation error of a far field at R = 4 a; NaN if that has not been computed."""
        sequence = self.sequences[name]
        return next((e for size, e in zip(sequence.sizes, sequence.errors, strict=True) if abs(4 * size - 1) < 1e-6), np.nan)

    def order_row(self, name: str) -> dict[str, object]:
        """A row for the table of orders."""
        sequence = self.sequences[name]
        counted, below = sequence.sizes[sequence.counted], sequence.sizes[sequence.errors < self.discretisation.errors]
        return {
            "nu": self.poisson_ratio,
            "shape": self.shape,
            "far field": name,
            **sequence.summary(),
            "R of those that count": f"{1 / counted[0]:.3g} to {1 / counted[-1]:.3g} a" if len(counted) else "",
            "truncation at 4 a": f"{self.at_four(name):.1e}",
            "overtaken by the discretisation from": f"{1 / below[0]:.3g} a" if len(below) else "",
        }


def conclude(studied: list[Truncation]) -> list[str]:
    """The order of each far field over Poisson's ratios and shapes, and the box against the quarter disc."""
    parts = []
    for name, theory in FAR_FIELDS.items():
        found: Array = np.array([one.sequences[name].order for one in studied])
        if np.isfinite(found).any():
            parts.append(f"{name} {np.nanmin(found):.2f} to {np.nanmax(found):.2f} ({theory:g})")
    lines = [f"Order of the truncation error in a/R, over Poisson's ratios and shapes (theory): {', '.join(parts)}."]
    lines.append(verdicts(sequence for one in studied for sequence in one.sequences.values()))
    by_shape = {one.shape: one for one in studied if one.poisson_ratio == 0.3}
    if len(by_shape) == len(SHAPES):
        ratios = {name: by_shape["box"].at_four(name) / by_shape["disc"].at_four(name) for name in FAR_FIELDS}
        worth = ", ".join(f"{name} {ratio:.2f} ({ratio ** (-1 / FAR_FIELDS[name]):.2f} R)" for name, ratio in ratios.items())
        lines.append(
            "A box of half-width R against a quarter disc of radius R = 4 a, nu = 0.3, at equal unknowns (the same "
            f"triangles, stretched): truncation error times (as much as a disc of) {worth}; a disc of the box's area has "
            f"{np.sqrt(4 / np.pi):.2f} R."
        )
    return lines


def draw(studied: list[Truncation], path: Path) -> None:
    """A panel for each Poisson's ratio."""
    ratios = sorted({one.poisson_ratio for one in studied})
    columns = 1 + (len(ratios) > 1)
    rows = -(-max(1, len(ratios)) // columns)
    figure = new_figure(4.4 * columns, 5.4 * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, ratio in zip(panels.ravel(), ratios, strict=False):
        by_shape = {one.shape: one for one in studied if one.poisson_ratio == ratio}
        draw_orders(axes, by_shape["disc"].sequences.values(), "punch radius over the half-space's, $a/R$", "")
        if "box" in by_shape:
            for name, sequence in by_shape["box"].sequences.items():
                label = "the same in a box of half-width $R$" if name == "fixed" else None
                shown = np.where(sequence.errors > 0, sequence.errors, np.nan)
                axes.loglog(sequence.sizes, shown, color="0.5", linewidth=0.6, label=label)
        rest = by_shape["disc"].discretisation
        axes.loglog(rest.sizes, rest.errors, color="0.4", linewidth=0.9, linestyle=(0, (1, 2)), label="discretisation")
        axes.set_ylim(bottom=ROUNDOFF)
        legend_below(axes, title="quarter disc of radius $R$: observed order")
        axes.set_title(rf"$\nu$ = {ratio:g}", fontsize=9)
    for axes in panels[:, 0]:
        axes.set_ylabel(r"truncation part of the relative error of $d_0$")
    figure.savefig(path)
