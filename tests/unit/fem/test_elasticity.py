"""The axisymmetric solid on every kind of element.

It is compared with a bilinear form, patch fields, Lame's cylinder and Boussinesq's field.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementTriP2B,
    ElementVector,
    MeshQuad,
)

from ringwear.fem.condensation import symmetric
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import poles
from ringwear.fem.weak_form import element_of_degree, moduli, stiffness
from ringwear.meshes.ground.ground import Ground
from ringwear.meshes.half_space import LOWERED_DEGREE_PREFIX, oriented

# kind of mesh and degree of the displacement
SOLIDS = [
    *(("triangles", degree) for degree in (1, 2, 3, 4)),
    *(("quadrilaterals", degree) for degree in (1, 2, 3, 5, 8)),
]


def square(kind, r, z, count=4):
    """Return a mesh of a square of size 1 with a corner at (r, z).

    It has `count` by `count` different skew quadrilaterals, or twice as many triangles. With the
    kind "layers", degrees differ from element to element.
    """
    grid = np.linspace(0, 1, count + 1)
    mesh = MeshQuad.init_tensor(grid, grid)
    if kind == "triangles":
        mesh = mesh.to_meshtri()
    else:
        # neighbours have different orders of vertices
        shift = np.arange(mesh.nelements) % 4
        corners = np.take_along_axis(mesh.t, (np.arange(4)[:, None] + shift) % 4, axis=0)
        mesh = oriented(MeshQuad(mesh.p, corners))
    x, y = mesh.p
    skew = 0.5 * x * (1 - x) * y * (1 - y)
    mesh = replace(mesh.with_defaults(), doflocs=np.stack([r + x + skew, z + y - skew]))
    if kind == "layers":
        layers = {f"{LOWERED_DEGREE_PREFIX}{k}": np.arange(mesh.nelements)[k::4] for k in (1, 2)}
        mesh = mesh.with_subdomains(layers)
    return mesh


@BilinearForm
def energy(u, v, w):
    """Return twice the energy of displacements (radial, axial), written as in a textbook."""
    r = w.x[0]

    def strains(displacement, gradient):
        (rr, rz), (zr, zz) = gradient
        return rr, zz, (rz + zr) / np.sqrt(2), displacement[0] / r

    first, second = strains(u, u.grad), strains(v, v.grad)
    traces = (sum(first[i] for i in (0, 1, 3)), sum(second[i] for i in (0, 1, 3)))
    products = sum(a * b for a, b in zip(first, second, strict=True))
    return 2 * np.pi * r * (2 * w.shear * products + w.lame * traces[0] * traces[1])


@pytest.mark.parametrize(
    ("kind", "degree"),
    [
        pytest.param(*solid, marks=[pytest.mark.slow] * (solid == ("quadrilaterals", 8)))
        for solid in SOLIDS
    ],
)
@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.4999])
def test_stiffness_equals_the_bilinear_form(kind, degree, poisson_ratio):
    mesh = square(kind, 0.5, 0.2, 3)
    element = element_of_degree(mesh, degree)
    order = 2 * degree + (4 if kind == "triangles" else 1)
    basis = Basis(mesh, ElementVector(element), intorder=order)
    lame, shear = moduli(poisson_ratio)
    expected = energy.assemble(basis, lame=lame, shear=shear)
    functions, elements = np.arange(len(element.doflocs)), np.arange(mesh.nelements)
    materials = np.full(mesh.nelements, lame), np.full(mesh.nelements, shear)
    matrices = stiffness(mesh, element, functions, elements, degree, materials)
    # scikit-fem has both components of a function side by side
    blocks = matrices.transpose(0, 2, 1, 4, 3).reshape(len(elements), *[2 * len(functions)] * 2)
    rows = np.broadcast_to(basis.element_dofs.T[:, :, None], blocks.shape)
    places = rows.ravel(), rows.transpose(0, 2, 1).ravel()
    assembled = coo_matrix((blocks.ravel(), places), expected.shape)
    assert abs(assembled - expected).max() <= 1e-13 * abs(expected).max()


def greatest_error(solid, field):
    """Return the greatest error at vertices, relative to the greatest value.

    The displacement is prescribed on the boundary by a field, (n, 2) at (n, 2) points. On the left,
    only its radial part is prescribed, because the field has no shear there.
    """
    moved = np.where(np.tile(solid.fixed, (2, 1)), 0.0, np.nan)
    for name, components in (("left", 1), ("right", 2), ("top", 2), ("bottom", 2)):
        values = solid.interpolate(name, field)[:, :components]
        moved[:components, solid.boundary(name)] = values.T
    moved = moved.ravel()
    free = np.isnan(moved)
    rows = symmetric(solid.lower_triangle(np.arange(free.size)))[free]
    moved[free] = spsolve(rows[:, free], -rows[:, ~free] @ moved[~free])
    expected = field(solid.mesh.p.T).T
    vertices = moved.reshape(2, -1)[:, : solid.mesh.nvertices]
    return float(np.abs(vertices - expected).max() / np.abs(expected).max())


def affine(points):
    return points * [0.3, -0.7] + [0, 1]


def bent(points):
    """Return a field with all strains, but without body force or change of volume."""
    r, z = points.T
    return np.stack([r * z, r**2 / 2 - z**2], axis=1)


@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.0, 0.3, 0.4999])
@pytest.mark.parametrize(
    ("kind", "degree", "element"),
    # the last two are elements that a user chooses: any H1 element of scikit-fem is allowed
    [
        *((*solid, None) for solid in SOLIDS),
        *(("layers", degree, None) for degree in (4, 6, 8)),
        ("quadrilaterals", 2, ElementQuad2()),
        ("triangles", 2, ElementTriP2B()),
    ],
)
def test_patch_fields_are_exact(kind, degree, element, poisson_ratio):
    """Fields without body force that elements can represent are exact up to roundoff."""
    solid = AxisymmetricElasticity(
        square(kind, 0.0, 0.0), degree, Ground.half_space(poisson_ratio), element
    )
    assert element is None or solid.element is element
    assert greatest_error(solid, bent if degree > 1 else affine) <= 1e-10


def lame_cylinder(points, _):
    """Return displacements of a thick-walled cylinder in plane strain, ``u_r = A r + B / r``."""
    radius = points[:, :1]
    return (0.3 * radius + 0.7 / radius) * [1, 0]


def boussinesq(points, poisson_ratio):
    """Return displacements below a point force, with all strains and hoop strain at the axis."""
    return poles(points, (0,), poisson_ratio, moduli(poisson_ratio)[1])[0][0]


CORNERS = {lame_cylinder: (1.0, 0.0), boussinesq: (0.0, 1.5)}


def vertex_error(field, kind, degree, poisson_ratio, count):
    mesh = square(kind, *CORNERS[field], count)
    solid = AxisymmetricElasticity(mesh, degree, Ground.half_space(poisson_ratio))
    return greatest_error(solid, lambda points: field(points, poisson_ratio))


@pytest.mark.parametrize(
    ("kind", "degree", "poisson_ratio", "order", "cap"),
    [
        ("triangles", 2, 0.3, 3, 5e-5),
        ("triangles", 3, 0.3, 4, 5e-7),
        ("triangles", 4, 0.3, 5, 1e-8),
        # without all products of polynomials, quadrilaterals that are no parallelograms lose an
        # order
        ("quadrilaterals", 3, 0.3, 4, 5e-7),
        ("quadrilaterals", 4, 0.3, 4, 1e-9),
        # nearly incompressible: dilatations of lower degrees are not stable, and one order is lost
        ("triangles", 2, 0.49999, 2, 5e-3),
        ("triangles", 3, 0.49999, 3, 1e-5),
        ("triangles", 4, 0.49999, 4, 1e-7),
        ("quadrilaterals", 4, 0.49999, 3, 1e-7),
    ],
)
@pytest.mark.parametrize("field", CORNERS)
def test_order_of_displacements_at_vertices(field, kind, degree, poisson_ratio, order, cap):
    coarse, fine = (vertex_error(field, kind, degree, poisson_ratio, count) for count in (8, 16))
    assert np.log2(coarse / fine) >= order - 0.45
    assert fine <= cap


@pytest.mark.parametrize(
    ("poisson_ratio", "highest", "cap"), [(0.0, 9, 1e-12), (0.3, 9, 5e-12), (0.49999, 7, 5e-9)]
)
def test_error_falls_exponentially_with_the_degree(poisson_ratio, highest, cap):
    """Convergence on quadrilaterals whose vertices have a random order.

    If a side had opposite directions in its two elements, errors would not fall below 1e-4.
    """
    degrees = range(3, highest + 1, 2)
    errors = [vertex_error(boussinesq, "quadrilaterals", p, poisson_ratio, 4) for p in degrees]
    assert (np.array(errors[:-1]) / errors[1:] >= 30).all()
    assert errors[-1] <= cap


def test_degrees_of_layers_are_lower_where_the_mesh_allows_it():
    batches = AxisymmetricElasticity(square("layers", 0.0, 0.0), 6, Ground.half_space(0.3)).batches
    assert [batch.degree for batch in batches] == [4, 5, 6]
