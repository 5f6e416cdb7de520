"""Ways to move the outer boundary outwards: for every far field, on a half-space and on layers.

A quarter disc of radius R is meshed and condensed once. The last rows of the factor of its
compliance belong to the poles of the far field; without its last row, the factor belongs to the
same half-space with one pole less; without all of them, to a clamped boundary. On a homogeneous
half-space, the indentation of each is divided by that with most poles on the same mesh, so that the
error of the mesh cancels. On layers, the far field is that of loads which are exact on the layers
(`fem/layered_far_field.py`), and the mesh is so fine that its error is below
`DISCRETISATION_ERROR`.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ....fem import AxisymmetricElasticity, HalfSpace, pressure_space
from ....mdr import flat_punch_of
from ....meshes import Compliance, Ground, SizeField, relative_stiffness
from ....meshes.by_gmsh import graded, truncation_with_interfaces
from ...crosscheck import Problem, Solution, press_flat
from ..reference import Reference
from ..way import OTHERS, Case, Theory, Way, inverse
from .subdivision import FLAT, triangulated

ORDERS = {"clamped": 1.0, "1 pole": 5.0, "2 poles": 9.0, "3 poles": 13.0}
"""Far fields on a homogeneous half-space, and the orders of their errors."""
ORDERS_ON_LAYERS = {"clamped": 1.0, "1 load": 5.0, "2 loads": 9.0} | dict.fromkeys(
    ("3 loads", "4 loads"), np.nan
)
"""The same on layers over an elastic substrate."""
MOST_POLES, DEGREE, ROUNDOFF = 6, 4, 1e-12
DEGREE_ON_LAYERS, RIM_SIZE, GRADING, GROWTH = 10, 1e-8, 0.15, 0.5
"""Degree, size at the rim, ratio of neighbouring layers of quadrilaterals, and growth."""
DISCRETISATION_ERROR = 1e-9
"""Relative error of the indentation that these sizes leave, above which an order is fitted."""
REASON = "The energy of the first neglected pole outside R is of order (a/R)^(4n+1) for n poles."
RIGID = "No order is expected: on a rigid base, errors decay exponentially with R over its depth."


def far_fields(radii: Sequence[float], ground: Ground) -> list[Way]:
    """Return a way through ever greater radii for each far field, the clamped boundary first."""
    if not ground.layered:
        return [_outwards(number, radii, ground) for number in range(len(ORDERS))]
    interfaces = tuple(ground.depths.tolist())
    outers = sorted({truncation_with_interfaces(interfaces, radius) for radius in radii})
    count = 1 if ground.rigid else len(ORDERS_ON_LAYERS)
    return [_outwards(number, outers, ground) for number in range(count)]


def exact_disc(case: Case) -> Reference:
    """Return the indentation of a flat punch of the radius 1 without a hole under the force 1."""
    depth = flat_punch_of(0.0).indentation / relative_stiffness(case.problem.ground)
    values = {"time": np.zeros(1), "indentation": np.array([depth])}
    return Reference(values, lambda _: ROUNDOFF)


def _outwards(poles: int, radii: Sequence[float], ground: Ground) -> Way:
    """Return the way through radii with a number of poles, or of loads on layers."""

    def solve(problem: Problem, level: float) -> Solution:
        compliances, unknowns = condensed(level, problem.ground)
        depth = press_flat(compliances[poles]).indentation
        if not problem.ground.layered:
            ratio = depth / press_flat(compliances[-1]).indentation
            depth = ratio * flat_punch_of(0.0).indentation
        compared = {"time": np.zeros(1), "indentation": np.array([depth])}
        return Solution({}, compared, {}, {}, unknowns)

    floor, cause = ROUNDOFF, "roundoff"
    if ground.layered:
        floor, cause = DISCRETISATION_ERROR, "the error of the elements"
    name, order = tuple((ORDERS_ON_LAYERS if ground.layered else ORDERS).items())[poles]
    theory = Theory(order, floor, REASON, cause)
    if ground.rigid:
        theory = theory._replace(order=np.nan, reason=RIGID)
    return Way(name, "fem", tuple(radii), solve, "$a/R$", inverse, {OTHERS: theory})


@lru_cache(maxsize=16)
def condensed(outer: float, ground: Ground) -> tuple[list[Compliance], int]:
    """Return the compliances with 0, 1, 2, ... poles or loads in the far field, and the unknowns.

    The elements of a homogeneous half-space resolve the far field on the boundary.
    """
    if ground.layered:
        interfaces = tuple(ground.depths.tolist())
        sizes = RIM_SIZE, GRADING, GROWTH, outer
        mesh = graded(FLAT, (), *sizes, interfaces=interfaces, rigid=ground.rigid).mesh
        solid = AxisymmetricElasticity(mesh, DEGREE_ON_LAYERS, ground)
    else:
        disc = triangulated(SizeField((0.0, 1.0), 1e-7, 1e-7, 0.3, outer, far_size=0.06))
        solid = AxisymmetricElasticity(disc, DEGREE, ground)
    count = len(ORDERS_ON_LAYERS) - 1 if ground.layered else MOST_POLES
    half_space = HalfSpace(solid, pressure_space(solid, FLAT), tuple(range(0, 2 * count, 2)))
    if ground.layered:
        half_space = half_space.without_dependent_poles()
    return half_space.compliances_by_poles(), half_space.unknowns
