"""The weak form of axisymmetric linear elasticity, and the stiffness of many elements at once.

The energy is ``int 2 mu eps(u) : eps(v) + lambda tr eps(u) tr eps(v) dV`` with
``dV = 2 pi r dr dz``: stiffness, forces and areas all include the full 2 pi. The strains are
``eps_rr = du_r/dr``, ``eps_zz = du_z/dz``, ``eps_hoop = u_r/r``, ``2 eps_rz = du_r/dz + du_z/dr``;
z is the depth. Radial and axial displacement are two scalar fields on the same scalar element.
scikit-fem's `BilinearForm` processes the pairs of functions one after the other, which is slow for
high degrees; `stiffness` computes the same numbers in one product.
"""

from functools import lru_cache

import numpy as np
import skfem
from skfem import Element, ElementQuadP, Mesh, MeshQuad
from skfem.quadrature import get_quadrature

from ..meshes.errors import SceneError
from ..meshes.half_space import derivative_mapping
from ..meshes.radial import Array, Indices

HIGHEST_ON_TRIANGLES = 4
"""Highest degree of scikit-fem's continuous elements on triangles."""


def moduli(poisson_ratio: float) -> tuple[float, float]:
    """Return Lame's lambda and shear modulus for the plane strain modulus 1."""
    shear = (1 - poisson_ratio) / 2
    return 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio), shear


def element_of_degree(mesh: Mesh, degree: int) -> Element:
    """Return scikit-fem's element of a degree on quadrilaterals (any) or triangles (1 to 4).

    Raises
    ------
    SceneError
        if scikit-fem has no element of that degree
    """
    quadrilaterals = isinstance(mesh, MeshQuad)
    if degree < 1 or (degree > HIGHEST_ON_TRIANGLES and not quadrilaterals):
        raise SceneError(
            f"scikit-fem has no continuous element of degree {degree} on this mesh: give 1 to "
            f"{HIGHEST_ON_TRIANGLES} on triangles, 1 or more on quadrilaterals"
        )
    return _element(quadrilaterals, degree)


@lru_cache(maxsize=64)
def _element(on_quadrilaterals: bool, degree: int) -> Element:
    if on_quadrilaterals and degree > 2:
        return ElementQuadP(degree)
    kind = "Quad" if on_quadrilaterals else "TriP"
    return getattr(skfem, f"Element{kind}{degree}")()


def stiffness(
    mesh: Mesh,
    element: Element,
    functions: Indices,
    elements: Indices,
    degree: int,
    materials: tuple[Array, Array],
) -> Array:
    """Return the stiffness (m, 2, n, 2, n) of functions on elements, radial before axial.

    Parameters
    ----------
    mesh, element : scikit-fem's mesh and scalar element
    functions : (n,) local numbers of the functions
    elements : (m,) numbers of the elements
    degree : highest polynomial degree p of the functions
    materials : Lame's lambda (m,) and the shear modulus (m,) of these elements

    Notes
    -----
    The quadrature is exact for polynomials of degree 2p + 1 on quadrilaterals. Triangles may touch
    the axis with a corner; because of the hoop strain u/r they need degree 2p + 4.
    """
    order = 2 * degree + (1 if isinstance(mesh, MeshQuad) else 4)
    points, weights = get_quadrature(element, order)
    value, gradient = tables(element, functions, points)
    mapping = mesh.mapping()
    exact = derivative_mapping(mesh)
    r, inverse = mapping.F(points, elements)[0], exact.invDF(points, elements)
    root = np.sqrt(2 * np.pi * r * np.abs(exact.detDF(points, elements)) * weights)
    m, n, q = len(elements), len(value), len(weights)
    # slopes: du_r/dr, u_r/r and du_r/dz (or du_z/dz) of every function at every point; products:
    # those of every two slopes
    slopes = np.empty((m, 3, n, q))
    slopes[:, 1] = (root / r)[:, None] * value
    for field, axis in ((0, 0), (2, 1)):
        first, second = root * inverse[:, axis]
        slopes[:, field] = first[:, None] * gradient[:, 0]
        slopes[:, field] += second[:, None] * gradient[:, 1]
    flat = slopes.reshape(m, 3 * n, q)
    products = (flat @ flat.transpose(0, 2, 1)).reshape(m, 3, n, 3, n).transpose(1, 3, 0, 2, 4)
    (rr, rh, rz), (hr, hh, hz), (zr, _, zz) = products
    lame, shear = (constant[:, None, None] for constant in materials)
    out = np.empty((m, 2, n, 2, n))
    out[:, 0, :, 0] = (lame + 2 * shear) * (rr + hh) + lame * (rh + hr) + shear * zz
    out[:, 1, :, 1] = (lame + 2 * shear) * zz + shear * rr
    out[:, 0, :, 1] = lame * (rz + hz) + shear * zr
    out[:, 1, :, 0] = out[:, 0, :, 1].transpose(0, 2, 1)
    return out


def tables(element: Element, functions: Indices, points: Array) -> tuple[Array, Array]:
    """Return the values (n, q) and reference gradients (n, 2, q) of functions of an element."""
    return _tables(element, tuple(functions.tolist()), points.tobytes(), points.shape)


@lru_cache(maxsize=64)
def _tables(
    element: Element, functions: tuple[int, ...], content: bytes, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return the tables at points whose coordinates are given as bytes, which can be compared."""
    points = np.frombuffer(content).reshape(shape)
    values, gradients = zip(*(element.lbasis(points, i) for i in functions), strict=True)
    return np.array(values), np.array(gradients)
