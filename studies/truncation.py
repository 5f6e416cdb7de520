"""What the outer boundary costs: the flat start against ``a/R`` for every far field and several Poisson's ratios.

One local mesh serves every R: a graded quarter disc of radius 2 a, with layers of geometrically growing triangles
around it, of which the outer ones are left off. What remains with `MOST_POLES` at the same R is the discretisation's:
of the rim, and of nodal values that stand for the poles on the outer boundary, which is of first order in a/R. Without
it, the truncation remains. One condensation gives every far field: without its last row, the factor of the compliance
belongs to the same half-space with one pole less, and at last to a clamped boundary.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from meshes.errors import MeshError, RingwearError
from meshes.half_space import HalfSpaceMesh, SizeField, assemble
from meshes.radial import Array, Indices

from .contact import flat_start
from .levels import Sequence, Table, between, draw_orders, keeping_rows, legend_below, new_figure, write_markdown
from .scene import Scene
from .stages import Report

EDGES = np.array([0.0, 1.0])  # a flat punch: rings do not matter to the far field
CORE, LAYER = 2.0, 2**0.25  # radius of the local mesh in a, ratio of neighbouring layers
DEGREE = 4
SIZES = 1e-7, 0.3  # rim, growth
QUICK_SIZES = 1e-5, 0.35
LAYERS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 36)
MOST_POLES = 6
ROUNDOFF = 1e-11
ABOVE_PLATEAU = 20.0  # truncation errors that count are so much greater than what their nodal values differ by
POISSON_RATIOS = (0.0, 0.3, 0.4999, 0.5)
FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}
FIELDS = ("poisson_ratio", "far_field", "R", "unknowns", "d0", "error", "truncation", "remark")
ORDER_FIELDS = (
    "nu", "far field", "expected order", "least squares", "between levels", "R of these", "truncation at 4 a",
    "overtaken by the discretisation from",
)  # fmt: skip


def layered_meshes(layers: tuple[int, ...], rim_size: float, growth: float) -> dict[int, HalfSpaceMesh]:
    """The same local mesh inside any number of layers."""
    from meshes import bisection, gmsh_mesher

    field = SizeField((0.0, 1.0), rim_size, rim_size, growth, CORE)
    try:
        core = gmsh_mesher.mesh(field)
    except MeshError:
        core = bisection.mesh(field)
    return {count: _with_layers(core, count) for count in layers}


def _with_layers(core: HalfSpaceMesh, count: int) -> HalfSpaceMesh:
    """The core with layers of triangles between concentric arcs, on the rays of the points of its own arc."""
    arc = np.unique(core.boundaries["far"])
    arc = arc[np.argsort(np.arctan2(core.points[arc, 1], core.points[arc, 0]))]
    radii = LAYER ** np.arange(1, count + 1)
    points = np.concatenate([core.points, *(core.points[arc] * radius for radius in radii)])
    number = np.concatenate([arc[None], len(core.points) + np.arange(count * len(arc)).reshape(count, len(arc))])
    inner, outer = number[:-1], number[1:]
    corners = inner[:, :-1], outer[:, :-1], outer[:, 1:], inner[:, 1:]
    split: list[Indices] = [core.triangles]
    split += [np.stack([corners[i].ravel() for i in triangle], axis=1) for triangle in ((0, 1, 2), (0, 2, 3))]
    return assemble(points, np.concatenate(split), EDGES, core.mesher)


def indentations(mesh: HalfSpaceMesh, poisson_ratio: float) -> tuple[list[float], int]:
    """The flat start with a clamped boundary and with 1, 2, ... `MOST_POLES` poles, and the number of unknowns."""
    from fem.compliance import MULTIPLIER_DEGREE, HalfSpace, pressure_space
    from fem.elasticity import AxisymmetricElasticity

    space = pressure_space(mesh, EDGES, MULTIPLIER_DEGREE[DEGREE])
    poles = tuple(range(0, 2 * MOST_POLES, 2))
    half_space = HalfSpace(AxisymmetricElasticity(mesh, DEGREE, poisson_ratio), space, poles)
    compliance = half_space.compliance()
    last = len(compliance.factor) - MOST_POLES
    factors = (compliance.factor[: last + count] for count in range(MOST_POLES + 1))
    return [flat_start(replace(compliance, factor=factor)).indentation for factor in factors], half_space.unknowns


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Vary R, the far field and Poisson's ratio; writes `truncation.csv`, `orders.csv`, `truncation.md` and `.png`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    table, orders = Table(out / "truncation.csv", FIELDS), Table(out / "orders.csv", ORDER_FIELDS)
    studied: dict[float, Truncation] = {}
    ratios = sorted({0.3, scene.half_space.poisson_ratio} if quick else {*POISSON_RATIOS, scene.half_space.poisson_ratio})
    with threadpool_limits(1), keeping_rows(conclusions):
        meshes = layered_meshes(LAYERS[:8] if quick else LAYERS, *(QUICK_SIZES if quick else SIZES))
        for ratio in ratios:
            studied[ratio] = Truncation(ratio)
            studied[ratio].study(meshes, table, report)
    for one in studied.values():
        for name in FAR_FIELDS:
            orders.add(**one.order_row(name))
    conclusions[:0] = conclude(studied)
    draw(studied, out / "truncation.png")
    write_markdown(out / "truncation.md", "Truncation of the half-space", conclusions, {"Orders in a/R": orders})
    return [*conclusions, orders.markdown()]


class Truncation:
    """Truncation errors at one Poisson's ratio by far field, and what the discretisation errs by."""

    def __init__(self, poisson_ratio: float) -> None:
        self.poisson_ratio = poisson_ratio
        # values are over that with most poles, whose truncation error is nil
        self.sequences = {name: Sequence(name, "d0", order, 1.0, ROUNDOFF) for name, order in FAR_FIELDS.items()}
        self.discretisation = Sequence("discretisation", "d0", exact=1.0)

    def study(self, meshes: dict[int, HalfSpaceMesh], table: Table, report: Report) -> None:
        """Compute every R."""
        for mesh in meshes.values():
            outer = mesh.truncation
            report(f"  level  nu = {self.poisson_ratio:g}, R = {outer:.3g} a ...")
            try:
                found, unknowns = indentations(mesh, self.poisson_ratio)
            except RingwearError as error:
                table.add(poisson_ratio=self.poisson_ratio, R=outer, remark=f"failed: {error}")
                continue
            self.discretisation.add(1 / outer, found[-1] / 0.5)
            for name, value in zip(FAR_FIELDS, found, strict=False):
                self.sequences[name].add(1 / outer, value / found[-1])
                table.add(
                    poisson_ratio=self.poisson_ratio, far_field=name, R=outer, unknowns=unknowns, d0=value,
                    error=value / 0.5 - 1, truncation=value / found[-1] - 1,
                )  # fmt: skip

        # far out, poles beyond those that matter only mend the nodal values of the first: that is of first order in a/R
        last = self.sequences["3 poles"]
        for name in list(FAR_FIELDS)[1:] if len(last.sizes) else ():
            self.sequences[name].floor = ABOVE_PLATEAU * last.errors[-1] * last.sizes / last.sizes[-1]

    def order_row(self, name: str) -> dict[str, object]:
        """A row for the table of orders."""
        sequence = self.sequences[name]
        kept = sequence.above_floor
        sizes, errors = sequence.sizes[kept], sequence.errors[kept]
        near = np.flatnonzero(np.abs(4 * sequence.sizes - 1) < 1e-6)
        below = sequence.sizes[sequence.errors < self.discretisation.errors]
        return {
            "nu": self.poisson_ratio,
            "far field": name,
            "expected order": sequence.expected,
            "least squares": sequence.order,
            "between levels": " ".join(f"{order:.2f}" for order in between(sizes, errors)),
            "R of these": f"{1 / sizes[0]:.3g} to {1 / sizes[-1]:.3g} a" if len(sizes) else "",
            "truncation at 4 a": f"{sequence.errors[near[0]]:.1e}" if len(near) else "",
            "overtaken by the discretisation from": f"{1 / below[0]:.3g} a" if len(below) else "",
        }


def conclude(studied: dict[float, Truncation]) -> list[str]:
    """The order of each far field, over Poisson's ratios."""
    parts = []
    for name in FAR_FIELDS:
        found: Array = np.array([one.sequences[name].order for one in studied.values()])
        if np.isfinite(found).any():
            parts.append(f"{name} {np.nanmin(found):.2f} to {np.nanmax(found):.2f}")
    return [f"Order of the truncation error in a/R, over Poisson's ratios: {', '.join(parts)}."]


def draw(studied: dict[float, Truncation], path: Path) -> None:
    """A panel for each Poisson's ratio."""
    figure = new_figure(3.6 * max(1, len(studied)), 5.4)
    panels = figure.subplots(1, max(1, len(studied)), sharey=True, squeeze=False)[0]
    for axes, (ratio, one) in zip(panels, studied.items(), strict=False):
        draw_orders(axes, one.sequences.values(), "punch radius over the half-space's, $a/R$", "")
        rest = one.discretisation
        axes.loglog(rest.sizes, rest.errors, color="0.4", linewidth=0.9, linestyle=(0, (1, 2)), label="discretisation")
        legend_below(axes, title="observed order")
        axes.set_title(rf"$\nu$ = {ratio:g}", fontsize=9)
    panels[0].set_ylabel(r"truncation part of the relative error of $d_0$")
    figure.savefig(path)
