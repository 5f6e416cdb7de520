"""What the outer boundary costs: the flat start against ``a/R``, by far field and Poisson's ratio.

A quarter disc of radius R is meshed. One condensation gives every far field: without its last row,
the factor of the compliance belongs to the same half-space with one pole less, and at last to a
clamped boundary. Values are over that of `MOST_POLES` on the same mesh, which errs by the
discretisation alone: by the rim, and by nodal values that stand for the poles on the outer
boundary.

Theory: with n poles tied, the first one neglected falls as ``1/rho^(2n+1)``, and the energy that it
has outside R as ``(a/R)^(4n+1)``: order 1, 5, 9, 13 for a clamped boundary and one, two, three
poles. The next pole adds a term smaller by ``(a/R)^2``, so levels count from R = 4 a on.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..meshes.compliance import Compliance
from ..meshes.sizes import SizeField
from .convergence.cases import FLAT, Discretised, condensed, flat_d0
from .convergence.meshes import triangulated
from .convergence.orders import ORDER_FIELDS, Refinement, Sequence, draw_orders, refined, verdicts
from .figures.style import FAINT, legend_below, new_figure
from .problem.problem import D0
from .problem.scene import Scene
from .tables import Table, write_page

MOST_POLES = 6
# R/a, and Poisson's ratios beside the scene's
FULL = (2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 11, 16, 32, 128, 1024), (0.0, 0.3, 0.4999, 0.5)
QUICK = (2, 3, 4, 5, 6, 7, 8), (0.3,)
ROUNDOFF = 1e-12  # a hundred times what is left of three poles far out
FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}  # and their orders
DISCRETISATION = "discretisation"


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary R, the far field and Poisson's ratio; writes `truncation` and `orders`."""
    radii, ratios = QUICK if options.quick else FULL
    ratios = tuple(sorted({*ratios, scene.problem.poisson_ratio}))
    conclusions: list[str] = []
    refinements = (outwards(radii, ratio) for ratio in ratios)
    sequences = refined(refinements, out / "truncation.csv", conclusions)
    orders = Table(
        out / "orders.csv",
        ORDER_FIELDS,
        (one.summary() for one in sequences if one.quantity in FAR_FIELDS),
    )
    conclusions[:0] = conclude(sequences)
    draw(sequences, ratios, out / "truncation.png")
    write_page(
        out / "truncation.md",
        "Truncation of the half-space",
        conclusions,
        {"Orders in a/R": orders},
    )
    return [*conclusions, orders.markdown()]


def outwards(radii: tuple[float, ...], ratio: float) -> Refinement:
    """Ever greater half-spaces.

    The truncation error of each far field, and what the discretisation errs by.
    """

    def discretise(outer: float) -> Discretised:
        # the far field is wanted well resolved on the outer boundary, wherever that is
        disc = triangulated(SizeField((0.0, 1.0), 1e-7, 1e-7, 0.3, outer, far_size=0.06))
        return condensed(disc, FLAT, 4, ratio, tuple(range(0, 2 * MOST_POLES, 2)))

    name = f"nu = {ratio:g}"
    sequences = [
        Sequence(name, far, order, 1.0, ROUNDOFF, coarsest=0.25)
        for far, order in FAR_FIELDS.items()
    ]
    sequences.append(Sequence(name, DISCRETISATION, exact=1.0))
    return Refinement(sequences, {outer: 1 / outer for outer in radii}, discretise, by_far_field)


def by_far_field(compliance: Compliance) -> dict[str, float]:
    """The flat start of each far field over that with most poles, and that one over what it should
    be.
    """
    rows = len(compliance.factor) - MOST_POLES + np.arange(MOST_POLES + 1)
    *fewer, most = (
        flat_d0(replace(compliance, factor=compliance.factor[:count]))["d0"] for count in rows
    )
    return {far: value / most for far, value in zip(FAR_FIELDS, fewer, strict=False)} | {
        DISCRETISATION: most / D0
    }


def conclude(sequences: list[Sequence]) -> list[str]:
    """The order of each far field over Poisson's ratios."""
    ranges = []
    for far, theory in FAR_FIELDS.items():
        orders = [one.order for one in sequences if one.quantity == far and np.isfinite(one.order)]
        if orders:
            ranges.append(f"{far} {min(orders):.2f} to {max(orders):.2f} ({theory:g})")
    line = (
        "Order of the truncation error in a/R, over Poisson's ratios (theory): "
        f"{', '.join(ranges)}."
    )
    return [line, verdicts(sequences)]


def draw(sequences: list[Sequence], ratios: tuple[float, ...], path: Path) -> None:
    """A panel for each Poisson's ratio."""
    figure = new_figure(4.4 * len(ratios), 5.4)
    panels = figure.subplots(1, len(ratios), sharey=True, squeeze=False)
    for axes, ratio in zip(panels.flat, ratios, strict=True):
        own = [one for one in sequences if one.name == f"nu = {ratio:g}"]
        far = [replace(one, name=one.quantity) for one in own if one.quantity in FAR_FIELDS]
        labels = (
            "punch radius over the half-space's, $a/R$",
            r"truncation part of the relative error of $d_0$",
        )
        draw_orders(axes, far, *labels, rf"$\nu$ = {ratio:g}")
        axes.label_outer()
        for one in own[len(FAR_FIELDS) :]:
            axes.plot(one.sizes, one.errors, **FAINT, label=DISCRETISATION)
        axes.set_ylim(bottom=ROUNDOFF)
        legend_below(axes, title="observed order")
    figure.savefig(path)
