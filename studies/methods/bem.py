"""Boundary elements.

The ring kernel of Eq. 19 on the radial mesh of the MDR, and no identity of the MDR in it.
"""

from typing import Any, ClassVar

from ...mdr import ring_kernel
from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from .mdr import Mdr


class Bem(Mdr):
    """Boundary elements."""

    name = "bem"
    what = (
        "the half-space by boundary elements: the ring kernel of Eq. 19, no identity of the MDR "
        "in it"
    )
    look: ClassVar[dict[str, Any]] = {
        "color": "#2e7d32",
        "linestyle": "-.",
        "linewidth": 1,
        "marker": "s",
        "markersize": 3,
    }

    def compliance(self, space: PressureSpace) -> Compliance:
        return ring_kernel.compliance(space)


METHOD = Bem()
