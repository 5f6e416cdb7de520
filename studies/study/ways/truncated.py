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
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ....fem import AxisymmetricElasticity, HalfSpace, pressure_space
from ....mdr import flat_punch_of
from ....meshes import Compliance, Ground, SizeField, relative_stiffness
from ....meshes.by_gmsh import graded, truncation_with_interfaces
from ...crosscheck import Problem, Solution, press_flat
from ..reference import Reference
from ..way import Case, Solve, Theory, Way, inverse
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
        return [_outwards(poles, radii) for poles in range(len(ORDERS))]
    interfaces = tuple(ground.depths.tolist())
    outers = sorted({truncation_with_interfaces(interfaces, radius) for radius in radii})
    count = 1 if ground.rigid else len(ORDERS_ON_LAYERS)
    return [_outwards_on_layers(loads, outers, ground.rigid) for loads in range(count)]


def start(depth: float, unknowns: int) -> Solution:
    """Return a solution that has the indentation at the start only."""
    compared = {"time": np.zeros(1), "indentation": np.array([depth])}
    return Solution({}, compared, {}, {}, unknowns)


def exact_disc(case: Case) -> Reference:
    """Return the indentation of a flat punch of the radius 1 without a hole under the force 1."""
    depth = flat_punch_of(0.0).indentation / relative_stiffness(case.problem.ground)
    values = {"time": np.zeros(1), "indentation": np.array([depth])}
    return Reference(values, lambda _: ROUNDOFF)


def _outwards(poles: int, radii: Sequence[float]) -> Way:
    def solve(problem: Problem, level: float, _: Solution | None) -> Solution:
        compliance, unknowns = condensed(level, problem.ground)
        rows = len(compliance.factor) - MOST_POLES + poles
        with_fewer = replace(compliance, factor=compliance.factor[:rows])
        ratio = press_flat(with_fewer).indentation / press_flat(compliance).indentation
        return start(ratio * flat_punch_of(0.0).indentation, unknowns)

    name, order = tuple(ORDERS.items())[poles]
    return _way(name, radii, solve, Theory(order, ROUNDOFF, REASON, "roundoff"))


def _outwards_on_layers(loads: int, radii: Sequence[float], rigid: bool) -> Way:
    def solve(problem: Problem, level: float, _: Solution | None) -> Solution:
        compliances, unknowns = condensed_on_layers(level, problem.ground)
        return start(press_flat(compliances[loads]).indentation, unknowns)

    name, order = tuple(ORDERS_ON_LAYERS.items())[loads]
    theory = Theory(order, DISCRETISATION_ERROR, REASON, "the error of the elements")
    theory = theory._replace(order=np.nan, reason=RIGID) if rigid else theory
    return _way(name, radii, solve, theory)


def _way(name: str, radii: Sequence[float], solve: Solve, theory: Theory) -> Way:
    def theory_of(*_: str) -> Theory:
        return theory

    return Way(name, "fem", tuple(radii), solve, "$a/R$", inverse, theory_of)


@lru_cache(maxsize=16)
def condensed(outer: float, ground: Ground) -> tuple[Compliance, int]:
    """Return the half-space with most poles; its elements resolve the far field on the boundary."""
    disc = triangulated(SizeField((0.0, 1.0), 1e-7, 1e-7, 0.3, outer, far_size=0.06))
    solid = AxisymmetricElasticity(disc, DEGREE, ground)
    orders = tuple(range(0, 2 * MOST_POLES, 2))
    half_space = HalfSpace(solid, pressure_space(solid, FLAT), orders)
    return half_space.compliance(), half_space.unknowns


@lru_cache(maxsize=16)
def condensed_on_layers(outer: float, ground: Ground) -> tuple[list[Compliance], int]:
    """Return the compliances with 0, 1, 2, ... loads in the far field, and the unknowns."""
    interfaces = tuple(ground.depths.tolist())
    mesh = graded(
        FLAT, (), RIM_SIZE, GRADING, GROWTH, outer, interfaces=interfaces, rigid=ground.rigid
    ).mesh
    solid = AxisymmetricElasticity(mesh, DEGREE_ON_LAYERS, ground)
    loads = tuple(range(0, 2 * (len(ORDERS_ON_LAYERS) - 1), 2))
    half_space = HalfSpace(solid, pressure_space(solid, FLAT), loads).without_dependent_poles()
    return list(half_space.compliances_by_poles()), half_space.unknowns
