"""Names of the elements of other programs, and of the ways in which these compute pressures."""

from ...meshes import SceneError
from ..crosscheck import did_you_mean, shown

ELEMENTS = {
    "P1": "ElementTriP1",
    "P2": "ElementTriP2",
    "Q1": "ElementQuad1",
    "Q2": "ElementQuad2",
    "Q2S": "ElementQuadS2",
}
"""Names of scikit-fem's classes by the names of the elements: on triangles (P) and quadrilaterals
(Q), of degree 1 or 2; Q2S has eight nodes."""
PER_NODE, CONSISTENT = "per node", "consistent"
TREATMENTS = (PER_NODE, CONSISTENT)
"""Ways to compute the pressure of a node from the forces on the nodes."""


def element_named(name: str) -> str:
    """Return the name of an element in upper case.

    Raises
    ------
    SceneError
        if there is no such element
    """
    if str(name).upper() not in ELEMENTS:
        hint = did_you_mean(str(name), ELEMENTS, f"give one of {', '.join(ELEMENTS)}")
        raise SceneError(f"element = {shown(name)}{hint}")
    return str(name).upper()
