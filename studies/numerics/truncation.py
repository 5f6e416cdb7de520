"""What the outer boundary costs: the flat start against ``a/R``, by far field and Poisson's ratio.

A quarter disc of radius R is meshed. One condensation gives every far field: without its last row,
the factor of the compliance belongs to the same half-space with one pole less, and at last to a
clamped boundary. Values are over that of most poles on the same mesh, which errs by the
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

from ...meshes.compliance import Compliance
from ...meshes.sizes import SizeField
from ..problem.problem import D0
from ..problem.scene import Scene
from ..tables import Row
from .sequences import Family, Sequence, Theory, draw_orders, levels, publish, study_orders
from .subdivision import FLAT, condense, flat_d0, triangulated

FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}
"""Far fields, and the orders of what they err by."""
"""A hundred times what is left of three poles far out."""


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary R, the far field and Poisson's ratio; writes `truncation` and `orders`."""
    radii = (2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 11, 16, 32, 128, 1024)
    ratios = {0.3} if options.quick else {0.0, 0.3, 0.4999, 0.5}
    families = [
        move_outwards((2, 3, 4, 5, 6, 7, 8) if options.quick else radii, ratio)
        for ratio in sorted(ratios | {scene.problem.poisson_ratio})
    ]
    conclusions: list[str] = []
    sequences, orders = study_orders(families, out, "truncation", conclusions)
    panels = {
        f"$a/R$, {family.name}": [fitted for fitted in sequences if fitted.name == family.name]
        for family in families
    }
    draw_orders(out / "truncation.png", panels, "truncation part of the relative error of $d_0$")
    conclusions.insert(0, conclude(sequences))
    page, title = out / "truncation.md", "Truncation of the half-space"
    return publish(page, title, conclusions, {"Orders in a/R": orders})


def move_outwards(radii: tuple[float, ...], poisson_ratio: float) -> Family:
    """Return ever greater half-spaces."""
    roundoff = 1e-12

    def solve(outer: float) -> Row:
        # the far field is wanted well resolved on the outer boundary, wherever that is
        disc = triangulated(SizeField((0.0, 1.0), 1e-7, 1e-7, 0.3, outer, far_size=0.06))
        compliance, unknowns = condense(disc, FLAT, 4, poisson_ratio, poles=6)
        return {"unknowns": unknowns} | far_field_errors(compliance, poles=6)

    theory = {far: Theory(order, roundoff, coarsest=0.25) for far, order in FAR_FIELDS.items()}
    sizes = {outer: 1 / outer for outer in radii}
    name = f"nu = {poisson_ratio:g}"
    return Family(name, levels(sizes, solve), theory | {"discretisation": Theory()})


def far_field_errors(compliance: Compliance, poles: int) -> dict[str, float]:
    """Return by how much the flat start of each far field is off that with all poles, and that one
    off what it should be.
    """
    clamped = len(compliance.factor) - poles
    starts = [
        flat_d0(replace(compliance, factor=compliance.factor[: clamped + count]))["d0"]
        for count in (*range(len(FAR_FIELDS)), poles)
    ]
    errors = {far: start / starts[-1] - 1 for far, start in zip(FAR_FIELDS, starts, strict=False)}
    return errors | {"discretisation": starts[-1] / D0 - 1}


def conclude(sequences: list[Sequence]) -> str:
    """Say the order of each far field over Poisson's ratios."""
    ranges = []
    for far, theory in FAR_FIELDS.items():
        orders = [sequence.order for sequence in sequences if sequence.quantity == far]
        if np.isfinite(orders).any():
            ranges.append(f"{far} {np.nanmin(orders):.2f} to {np.nanmax(orders):.2f} ({theory:g})")
    line = "Order of the truncation error in a/R, over Poisson's ratios (theory): "
    return f"{line}{', '.join(ranges)}."
