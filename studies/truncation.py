"""What the outer boundary costs: the flat start against ``a/R``, by far field, shape and Poisson's ratio.

One local mesh serves every R: a graded quarter disc of radius 2 a, with layers of geometrically growing triangles
around it, of which the outer ones are left off; stretched, the same mesh fills a square box of half-width R. One
condensation gives every far field: without its last row, the factor of the compliance belongs to the same half-space
with one pole less, and at last to a clamped boundary. Values are over that of `MOST_POLES` at the same R, which errs by
the discretisation alone: by the rim, and by nodal values that stand for the poles on the outer boundary.

Theory: with n poles tied, the first one neglected falls as ``1/rho^(2n+1)``, and the energy that it has outside R as
``(a/R)^(4n+1)``: order 1, 5, 9, 13 for a clamped boundary and one, two, three poles, whatever the shape. The next pole
adds a term smaller by ``(a/R)^2``, so levels count from R = 4 a on.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from skfem import MeshTri

from ringwear.meshes.compliance import Compliance
from ringwear.studies.convergence.cases import FLAT, condensed, flat_d0
from ringwear.studies.convergence.meshes import CORE, LAYER, base_mesh, boxed, layered
from ringwear.studies.convergence.orders import ORDER_FIELDS, Refinement, Sequence, draw_orders, refined, verdicts
from ringwear.studies.figures.style import FAINT, legend_below, new_figure
from ringwear.studies.problem.problem import D0
from ringwear.studies.problem.scene import Scene
from ringwear.studies.tables import Table, write_page

DEGREE, MOST_POLES = 4, 6
# size at the rim, growth, numbers of layers, Poisson's ratios beside the scene's
FULL = 1e-7, 0.3, (0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 36), (0.0, 0.3, 0.4999, 0.5)
QUICK = 1e-5, 0.35, (0, 2, 4, 5, 6, 7, 8), (0.3,)
ROUNDOFF = 1e-12  # a hundred times what is left of three poles far out
COARSEST = 0.2503  # a/R of R = 4 a, from which on levels count
SHAPES = {"disc": lambda mesh: mesh, "box": boxed}
FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}  # and their orders
DISCRETISATION = "discretisation"


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary R, its shape, the far field and Poisson's ratio; writes `truncation` and `orders`."""
    rim, growth, layers, ratios = QUICK if options.quick else FULL
    ratios = tuple(sorted({*ratios, scene.problem.poisson_ratio}))
    conclusions: list[str] = []
    core = base_mesh(FLAT, rim, growth, CORE, CORE / 8)
    refinements = (outwards(core, ratio, shape, layers) for ratio, shape in product(ratios, SHAPES))
    sequences = refined(refinements, out / "truncation.csv", conclusions)
    orders = Table(out / "orders.csv", ORDER_FIELDS, (one.summary() for one in sequences if one.quantity in FAR_FIELDS))
    conclusions[:0] = conclude(sequences)
    draw(sequences, ratios, out / "truncation.png")
    write_page(out / "truncation.md", "Truncation of the half-space", conclusions, {"Orders in a/R": orders})
    return [*conclusions, orders.markdown()]


def case(ratio: float, shape: str) -> str:
    """Name of the sequences of one Poisson's ratio and shape."""
    return f"nu = {ratio:g}, {shape}"


def outwards(core: MeshTri, ratio: float, shape: str, layers: tuple[int, ...]) -> Refinement:
    """Ever more layers around a core: the truncation error of each far field, and what the discretisation errs by."""
    poles = tuple(range(0, 2 * MOST_POLES, 2))
    sequences = [Sequence(case(ratio, shape), far, p, 1.0, ROUNDOFF, coarsest=COARSEST) for far, p in FAR_FIELDS.items()]
    return Refinement(
        [*sequences, Sequence(case(ratio, shape), DISCRETISATION, exact=1.0)],
        {count: LAYER**-count / CORE for count in layers},
        lambda count: condensed(SHAPES[shape](layered(core, count)), FLAT, DEGREE, ratio, poles),
        by_far_field,
    )


def by_far_field(compliance: Compliance) -> dict[str, float]:
    """The flat start of each far field over that with most poles, and that one over what it should be."""
    rows = len(compliance.factor) - MOST_POLES + np.arange(MOST_POLES + 1)
    *fewer, most = (flat_d0(replace(compliance, factor=compliance.factor[:count]))["d0"] for count in rows)
    return {far: value / most for far, value in zip(FAR_FIELDS, fewer, strict=False)} | {DISCRETISATION: most / D0}


def conclude(sequences: list[Sequence]) -> list[str]:
    """The order of each far field over Poisson's ratios and shapes, and the box against the quarter disc."""
    ranges, worth = [], []
    for far, theory in FAR_FIELDS.items():
        orders = [one.order for one in sequences if one.quantity == far and np.isfinite(one.order)]
        if orders:
            ranges.append(f"{far} {min(orders):.2f} to {max(orders):.2f} ({theory:g})")
        at_four = {one.name: one.errors[np.isclose(one.sizes, 0.25)] for one in sequences if one.quantity == far}
        disc, box = (at_four.get(case(0.3, shape), np.empty(0)) for shape in SHAPES)
        if len(disc) and len(box):
            worth.append(f"{far} {float(box[0] / disc[0]):.2f} ({float(box[0] / disc[0]) ** (-1 / theory):.2f} R)")
    lines = [
        f"Order of the truncation error in a/R, over Poisson's ratios and shapes (theory): {', '.join(ranges)}.",
        verdicts(sequences),
    ]
    if worth:
        lines.append(
            "A box of half-width R against a quarter disc of radius R = 4 a, nu = 0.3, at equal unknowns (the same "
            f"triangles, stretched): truncation error times (as much as a disc of) {', '.join(worth)}; a disc of the box's "
            f"area has {np.sqrt(4 / np.pi):.2f} R."
        )
    return lines


def draw(sequences: list[Sequence], ratios: tuple[float, ...], path: Path) -> None:
    """A panel for each Poisson's ratio."""
    columns, rows = min(len(ratios), 2), -(-len(ratios) // 2)
    figure = new_figure(4.4 * columns, 5.4 * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, ratio in zip(panels.flat, ratios, strict=False):
        disc, box = ([one for one in sequences if one.name == case(ratio, shape)] for shape in SHAPES)
        far = [replace(one, name=one.quantity) for one in disc if one.quantity in FAR_FIELDS]
        error = r"truncation part of the relative error of $d_0$" if axes in panels[:, 0] else ""
        draw_orders(axes, far, "punch radius over the half-space's, $a/R$", error, rf"$\nu$ = {ratio:g}")
        for one in box[: len(FAR_FIELDS)]:
            label = "the same in a box of half-width $R$" if one.quantity == "fixed" else None
            axes.plot(one.sizes, one.errors, color="0.5", linewidth=0.6, label=label)
        for one in disc[len(FAR_FIELDS) :]:
            axes.plot(one.sizes, one.errors, **FAINT, label=DISCRETISATION)
        axes.set_ylim(bottom=ROUNDOFF)
        legend_below(axes, title="quarter disc of radius $R$: observed order")
    figure.savefig(path)
