"""Boundary elements: the ring kernel of Eq. 19 on the radial mesh of the MDR.

The method uses no identity of the MDR.
"""

from ...mdr import ring_kernel
from ...meshes.compliance import Compliance
from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from .pipeline import AnySpaceMethod


class Bem(AnySpaceMethod):
    """Boundary elements."""

    name = "bem"
    knows_layers = True
    what = (
        "the half-space by boundary elements: the ring kernel of Eq. 19, no identity of the MDR "
        "in it"
    )

    def compliance(self, space: PressureSpace, ground: Ground | None = None) -> Compliance:
        """Return the compliance on a space by integration of the ring kernel."""
        return ring_kernel.compliance(space, ground)


METHOD = Bem()
