"""Boundary elements: the ring kernel of Eq. 19 on the radial mesh of the MDR.

No identity of the MDR is used, so that the two methods are independent.
"""

from ....mdr import ring_kernel
from .pipeline import AnySpaceMethod


class Bem(AnySpaceMethod):
    """Boundary elements: the compliance is an integral of the ring kernel."""

    name = "bem"
    knows_layers = True
    what = (
        "the half-space by boundary elements: integrals of the ring kernel of Eq. 19, without any "
        "identity of the MDR"
    )

    compliance = staticmethod(ring_kernel.compliance)


METHOD = Bem()
