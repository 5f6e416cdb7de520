"""Study of the outer boundary on layered ground: error of the flat start, by far field.

The quarter disc is meshed in quadrilaterals, with lines at the interfaces above its outer boundary.
Its far field is a clamped boundary, or the fields of one to four loads, exact on the layers
(`fem/layered_far_field.py`). Errors are relative to the stiffness of the flat punch in theory.

Theory: far below the layers, the field on an elastic substrate is that of a homogeneous half-space,
so that the orders are those of poles (`truncation.py`): 1 for a clamped boundary, 5 for one load, 9
for two. On a rigid base the errors decay exponentially with R over the depth of the base.
"""

import numpy as np

from ...fem.half_space import pressure_space
from ...meshes.by_gmsh.outline import truncation_with_interfaces
from ...meshes.by_gmsh.quads import graded
from ...meshes.ground.line_energy import relative_stiffness
from ..crosscheck import AxisymmetricElasticity, Ground, HalfSpace, flat_punch, press_flat
from ..study.levels import Family, Theory
from ..tables import Row
from .core import FLAT

# degree of the displacement, sizes at the rim, ratio of the sizes of neighbouring layers of
# quadrilaterals, and growth: the discretisation errs by less than 1e-9
# (unit/studies/convergence/test_orders.py::test_truncation_on_layers)
DEGREE, RIM_SIZE, GRADING, GROWTH = 10, 1e-8, 0.15, 0.5
DISCRETISATION_ERROR = 1e-9
"""Relative error of d0 that these sizes leave, above which an order is fitted."""
ORDERS = (1.0, 5.0, 9.0)
"""Orders of the error on an elastic substrate: clamped, with one load, with two loads."""
LOADS = 4
"""Number of loads in the far field, at most."""


def move_outwards_on_layers(radii: tuple[float, ...], ground: Ground) -> Family:
    """Return ever greater quarter discs of layers.

    Parameters
    ----------
    radii : truncation radii, in punch radii; those that an interface nearly touches are enlarged
    ground : the layers
    """
    interfaces = tuple(ground.depths.tolist())
    exact = flat_punch(0.0).indentation / relative_stiffness(ground)

    def solve(outer: float) -> Row:
        mesh = graded(
            FLAT,
            (),
            RIM_SIZE,
            GRADING,
            GROWTH,
            outer,
            interfaces=interfaces,
            rigid=ground.rigid,
        ).mesh
        solid = AxisymmetricElasticity(mesh, DEGREE, ground)
        loads = tuple(range(0, 2 * LOADS, 2))
        half_space = HalfSpace(solid, pressure_space(solid, FLAT), loads).without_dependent_poles()
        errors = {
            far_field(count): press_flat(compliance).indentation / exact - 1
            for count, compliance in enumerate(half_space.compliances_by_poles())
        }
        return {"unknowns": half_space.unknowns} | errors

    orders = (np.nan,) if ground.rigid else ORDERS
    theory = {
        far_field(loads): Theory(order, DISCRETISATION_ERROR) for loads, order in enumerate(orders)
    }
    outers = sorted({truncation_with_interfaces(interfaces, radius) for radius in radii})
    sizes = {outer: 1 / outer for outer in outers}
    return Family("layers", sizes, solve, theory, "$a/R$")


def far_field(loads: int) -> str:
    """Return the name of the far field of some loads; without any, the boundary is clamped."""
    return {0: "fixed", 1: "1 load"}.get(loads, f"{loads} loads")
