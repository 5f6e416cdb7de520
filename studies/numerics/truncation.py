"""Study of the outer boundary: error of the flat start against ``a/R``, by far field.

The error also depends on Poisson's ratio, so that several are tested.

A quarter disc of radius R is meshed. One condensation gives all far fields: the last rows of the
factor of the compliance belong to the poles. Without its last row, the factor belongs to the same
half-space with one pole less; without all of them, to a clamped boundary. Errors are relative to
the solution with most poles on the same mesh. The error of that solution is only the discretisation
error: that of the rim, and that of the nodal values that represent the poles on the outer boundary.

Theory: with n poles, the first neglected pole decays as ``1/rho^(2n+1)``, and its energy outside R
as ``(a/R)^(4n+1)``. Hence the order is 1, 5, 9, 13 for a clamped boundary and for one, two, three
poles. The next pole adds a term that is smaller by ``(a/R)^2``; levels therefore begin at R = 4 a.
"""

from dataclasses import replace

from ..crosscheck import Compliance, Scene, SizeField, press_flat
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.study import Study
from ..study.study_orders import study_orders
from ..tables import Row
from .core import FLAT, condense
from .layered_truncation import move_outwards_on_layers
from .subdivision import triangulated

FAR_FIELDS = {"fixed": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}
"""Far fields, and the orders of their errors."""

RADII_ON_LAYERS = (1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 7.0, 10.0, 16.0)
"""Truncation radii on layers, in punch radii."""
LABEL = "truncation part of the relative error of $d_0$"


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Compute the errors of several R, far fields and Poisson's ratios."""
    radii = (4, 5, 6, 7, 8) if options.quick else (4, 5, 6, 7, 8, 11, 16, 32, 128, 1024)
    ratios = {0.3} if options.quick else {0.0, 0.3, 0.4999, 0.5}
    if (ground := scene.problem.ground).layered:
        families = [
            move_outwards_on_layers(RADII_ON_LAYERS[: 6 if options.quick else None], ground)
        ]
        return study_orders(families, record, "truncation", scene, LABEL)
    families = [
        move_outwards(radii, ratio) for ratio in sorted(ratios | {scene.problem.poisson_ratio})
    ]
    return study_orders(families, record, "truncation", scene, LABEL)


def move_outwards(radii: tuple[float, ...], poisson_ratio: float) -> Family:
    """Return half-spaces of increasing truncation radius."""
    roundoff = 1e-12

    def solve(outer: float) -> Row:
        # elements are small enough everywhere on the outer boundary to resolve the far field
        disc = triangulated(SizeField((0.0, 1.0), 1e-7, 1e-7, 0.3, outer, far_size=0.06))
        compliance, unknowns = condense(disc, FLAT, 4, poisson_ratio, poles=6)
        return {"unknowns": unknowns} | far_field_errors(compliance, poles=6)

    theory = {far: Theory(order, roundoff) for far, order in FAR_FIELDS.items()}
    name, sizes = f"nu = {poisson_ratio:g}", {outer: 1 / outer for outer in radii}
    return Family(name, sizes, solve, theory, f"$a/R$, {name}")


def far_field_errors(compliance: Compliance, poles: int) -> dict[str, float]:
    """Return the relative error of the flat start with each far field, against all poles."""
    rows_without_poles, reference = (
        len(compliance.factor) - poles,
        press_flat(compliance).indentation,
    )
    errors = {}
    for count, far in enumerate(FAR_FIELDS):
        with_fewer_poles = replace(
            compliance, factor=compliance.factor[: rows_without_poles + count]
        )
        errors[far] = press_flat(with_fewer_poles).indentation / reference - 1
    return errors
