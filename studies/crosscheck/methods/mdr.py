"""The method of dimensionality reduction: its energy on a graded radial mesh."""

from ....mdr import energy
from .pipeline import AnySpaceMethod


class Mdr(AnySpaceMethod):
    """Dimensionality reduction: exact for full contact, except for the pressure space."""

    name = "mdr"
    knows_layers = True
    what = (
        "the half-space by dimensionality reduction, exact for full contact except for the "
        "pressure space"
    )

    compliance = staticmethod(energy.compliance)


METHOD = Mdr()
