"""Which elements of scikit-fem the half-space takes, and why it refuses others.

An element has to be scalar, continuous, and defined on a reference element. On a side, its
functions of the two vertices and of the side are all polynomials of one degree. Functions inside
may be anything that vanishes on the sides.
"""

import numpy as np
from skfem import Element, Mesh, MeshQuad, MeshTri
from skfem.element import ElementH1, ElementVector

from ..meshes.errors import SceneError
from ..meshes.radial import Array

USABLE = {
    MeshTri.elem.refdom: "ElementTriP1 to ElementTriP4, ElementTriMini, ElementTriP2B or "
    "ElementTriCCR on triangles",
    MeshQuad.elem.refdom: "ElementQuad1, ElementQuad2, ElementQuadS2 or ElementQuadP(degree) on "
    "quadrilaterals",
}
"""Elements of scikit-fem that can be used, by the reference element."""


def degree_along_side(element: Element) -> int:
    """Return the polynomial degree of an element along a side.

    Raises
    ------
    SceneError
        if the half-space cannot take the element, in one line that names elements it can take
    """
    if fault := _fault(element):
        name = type(element).__name__
        usable = USABLE.get(getattr(element, "refdom", None)) or "; ".join(USABLE.values())
        raise SceneError(f"{name} cannot carry the displacement: {fault}; use {usable}")
    return int(element.facet_dofs) + 1


def check_element(element: Element, mesh: Mesh, degree: int) -> None:
    """Raise if the half-space on a mesh cannot take an element, or if its degree is another.

    Raises
    ------
    SceneError
        in one line that names what to use
    """
    own, name = degree_along_side(element), type(element).__name__
    if element.refdom is not mesh.elem.refdom:
        raise SceneError(
            f"{name} does not fit the mesh, whose elements are others: use "
            f"{USABLE[mesh.elem.refdom]}"
        )
    if own != degree:
        raise SceneError(f"{name} has degree {own} along a side, not {degree}: give degree = {own}")


def is_on_quadrilaterals(element: Element) -> bool:
    """Return whether an element is one of quadrilaterals, not of triangles."""
    return bool(element.refdom is MeshQuad.elem.refdom)


def _fault(element: Element) -> str:
    """Return why the half-space cannot take an element; empty if it can."""
    if isinstance(element, ElementVector):
        return "it is a vector, but radial and axial displacement are two fields on a scalar one"
    if getattr(element, "refdom", None) not in USABLE:
        return "it is neither on triangles nor on quadrilaterals"
    if not isinstance(element, ElementH1):
        return "it is not of scikit-fem's kind ElementH1, with functions on a reference element"
    if element.nodal_dofs == 0:
        return "it is not continuous from one element to the next"
    if element.nodal_dofs > 1 or element.edge_dofs:
        return "it has unknowns at vertices or edges other than the value at each vertex"
    if not all(_complete_on_side(element, side) for side in range(len(element.refdom.facets))):
        degree = element.facet_dofs + 1
        return f"its functions on a side are not the polynomials of degree {degree}"
    return ""


def _complete_on_side(element: Element, side: int) -> bool:
    """Return whether the functions of a side are its polynomials, and all others vanish on it."""
    reference, degree = element.refdom, int(element.facet_dofs) + 1
    ends = reference.facets[side]
    local = np.linspace(0.0, 1.0, 2 * degree + 2)
    start, end = reference.p[:, ends].T[..., None]
    values = np.array(
        [element.lbasis(start + (end - start) * local, i)[0] for i in range(len(element.doflocs))]
    )
    first = reference.nnodes + side * element.facet_dofs
    of_side = [*ends, *range(first, first + element.facet_dofs)]
    powers = np.vander(local, degree + 1)
    return bool(
        np.abs(np.delete(values, of_side, axis=0)).max(initial=0.0) < 1e-9
        and _spans(values[of_side], powers.T)
    )


def _spans(functions: Array, polynomials: Array) -> bool:
    """Return whether functions (k, q) at points span as many polynomials (k, q)."""
    missed = polynomials - np.linalg.lstsq(functions.T, polynomials.T, rcond=None)[0].T @ functions
    return len(functions) == len(polynomials) and bool(np.abs(missed).max() < 1e-9)
