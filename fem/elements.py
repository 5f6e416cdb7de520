"""Check whether the half-space can use an element of scikit-fem.

An element must be scalar, continuous, and defined on a reference element. On each side, the
functions of its two vertices and of the side itself must span the polynomials of one degree.
Functions inside may be any functions that vanish on the sides.
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
"""Usable elements of scikit-fem for each reference element."""


def degree_along_side(element: Element) -> int:
    """Return the polynomial degree of an element along a side.

    Raises
    ------
    SceneError
        if the half-space cannot use the element; the message is one line that names usable elements
    """
    if fault := _fault(element):
        name = type(element).__name__
        usable = USABLE.get(getattr(element, "refdom", None)) or "; ".join(USABLE.values())
        raise SceneError(f"{name} cannot carry the displacement: {fault}; use {usable}")
    return int(element.facet_dofs) + 1


def check_element(element: Element, mesh: Mesh, degree: int) -> None:
    """Raise an error if an element does not fit the half-space, its mesh or its degree.

    Raises
    ------
    SceneError
        if it does not fit; the message is one line that names what to use instead
    """
    element_degree, name = degree_along_side(element), type(element).__name__
    if element.refdom is not mesh.elem.refdom:
        raise SceneError(
            f"{name} does not fit the elements of the mesh: use {USABLE[mesh.elem.refdom]}"
        )
    if element_degree != degree:
        raise SceneError(
            f"{name} has degree {element_degree} along a side, not {degree}: give degree = "
            f"{element_degree}"
        )


def is_on_quadrilaterals(element: Element) -> bool:
    """Return whether the reference element is a quadrilateral, not a triangle."""
    return bool(element.refdom is MeshQuad.elem.refdom)


def _fault(element: Element) -> str:
    """Return the reason why the half-space cannot use an element; empty if it can."""
    if isinstance(element, ElementVector):
        return "it is a vector element, but each displacement component needs a scalar element"
    if getattr(element, "refdom", None) not in USABLE:
        return "it is neither on triangles nor on quadrilaterals"
    if not isinstance(element, ElementH1):
        return (
            "it is not derived from scikit-fem's ElementH1, with functions on a reference element"
        )
    if element.nodal_dofs == 0:
        return "it is not continuous from one element to the next"
    if element.nodal_dofs > 1 or element.edge_dofs:
        return "it has unknowns at vertices or edges besides the value at each vertex"
    if not all(_complete_on_side(element, side) for side in range(len(element.refdom.facets))):
        degree = element.facet_dofs + 1
        return f"its functions on a side are not the polynomials of degree {degree}"
    return ""


def _complete_on_side(element: Element, side: int) -> bool:
    """Return whether the functions of a side span its polynomials, and all others vanish on it."""
    reference, degree = element.refdom, int(element.facet_dofs) + 1
    ends = reference.facets[side]
    local = np.linspace(0.0, 1.0, 2 * degree + 2)
    start, end = reference.p[:, ends].T[..., None]
    values = np.array(
        [element.lbasis(start + (end - start) * local, i)[0] for i in range(len(element.doflocs))]
    )
    first = reference.nnodes + side * element.facet_dofs
    side_functions = [*ends, *range(first, first + element.facet_dofs)]
    powers = np.vander(local, degree + 1)
    return bool(
        np.abs(np.delete(values, side_functions, axis=0)).max(initial=0.0) < 1e-9
        and _spans(values[side_functions], powers.T)
    )


def _spans(functions: Array, polynomials: Array) -> bool:
    """Return whether functions (k, q), given at points, span k polynomials (k, q)."""
    residual = (
        polynomials - np.linalg.lstsq(functions.T, polynomials.T, rcond=None)[0].T @ functions
    )
    return len(functions) == len(polynomials) and bool(np.abs(residual).max() < 1e-9)
