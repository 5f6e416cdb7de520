"""The method of dimensionality reduction: its energy on a graded radial mesh."""

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.pressure_space import PressureSpace
from .pipeline import AnySpaceMethod


class Mdr(AnySpaceMethod):
    """Dimensionality reduction: exact for full contact, except for the pressure space."""

    name = "mdr"
    knows_layers = True
    what = (
        "the half-space by dimensionality reduction, exact for full contact except for the "
        "pressure space"
    )

    def compliance(self, space: PressureSpace, ground: Ground = HALF_SPACE) -> Compliance:
        """Return the compliance on a space by the energy of the MDR."""
        return energy.compliance(space, ground)


METHOD = Mdr()
