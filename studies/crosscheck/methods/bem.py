"""Boundary elements: the ring kernel of Eq. 19 on the radial mesh of the MDR.

No identity of the MDR is used, so that the two methods are independent.
"""

from ....mdr import ring_kernel
from ....meshes.compliance import Compliance
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.pressure_space import PressureSpace
from .pipeline import AnySpaceMethod


class Bem(AnySpaceMethod):
    """Boundary elements: the compliance is an integral of the ring kernel."""

    name = "bem"
    knows_layers = True
    what = (
        "the half-space by boundary elements: integrals of the ring kernel of Eq. 19, without any "
        "identity of the MDR"
    )

    def compliance(self, space: PressureSpace, ground: Ground = HALF_SPACE) -> Compliance:
        """Return the compliance on a space by integration of the ring kernel."""
        return ring_kernel.compliance(space, ground)


METHOD = Bem()
