"""The axisymmetric solid on every kind of element, by identities.

Forms, patches, Lame's cylinder, Boussinesq's field.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve
from skfem import (
    Basis,
    BilinearForm,
    Element,
    ElementQuad2,
    ElementQuadP,
    ElementQuadS2,
    ElementTriP2B,
    ElementVector,
    Mesh,
    MeshQuad,
    MeshTri,
)

from ringwear.fem import AxisymmetricElasticity, element_of_degree, moduli, poles, stiffness
from ringwear.meshes import Array, turned
from ringwear.meshes.half_space import LOWER

# kind of mesh and degree of the displacement; of `layers`, degrees differ from element to element
SOLIDS = [
    *(("triangles", degree) for degree in (1, 2, 3, 4)),
    *(("quadrilaterals", degree) for degree in (1, 2, 3, 5, 8)),
    *(("layers", degree) for degree in (4, 6, 8)),
]
each_solid = pytest.mark.parametrize(("kind", "degree"), SOLIDS)


Field = Callable[[Array], Array]
AROUND = "inner", "outer", "top", "bottom"


def rectangle(kind: str, r0: float, r1: float, z0: float, z1: float, count: int = 4) -> Mesh:
    """`count` by `count` skew quadrilaterals, no two alike, or each cut in two, with every boundary
    named.
    """
    grid = np.linspace(0, 1, count + 1)
    mesh = MeshQuad.init_tensor(grid, grid)
    if kind == "triangles":
        mesh = mesh.to_meshtri()
    else:
        # in an order of vertices that no neighbours agree on
        shift = np.arange(mesh.nelements) % 4
        corners = np.take_along_axis(mesh.t, (np.arange(4)[:, None] + shift) % 4, axis=0)
        mesh = turned(MeshQuad(mesh.p, corners))
    x, y = mesh.p
    skew = 0.5 * x * (1 - x) * y * (1 - y)
    points = np.stack([r0 + (r1 - r0) * (x + skew), z0 + (z1 - z0) * (y - skew)])
    sides = {"inner": x == 0, "outer": x == 1, "top": y == 0, "bottom": y == 1}
    outer = mesh.boundary_facets()
    named = {name: outer[on[mesh.facets[:, outer]].all(axis=0)] for name, on in sides.items()}
    named["axis"] = named["inner"] if r0 == 0 else np.empty(0, dtype=np.int64)
    made = type(mesh)(points, mesh.t).with_boundaries(named)
    if kind == "layers":
        made = made.with_subdomains(
            {f"{LOWER}{k}": np.arange(made.nelements)[k::4] for k in (1, 2)}
        )
    return made


def coefficients(solid: AxisymmetricElasticity, field: Callable[[Array], Array]) -> Array:
    """(2 nodes,) of a displacement (2, ...) at points (2, ...) that the elements hold exactly."""
    basis = Basis(solid.mesh, solid.element, intorder=2 * solid.degree + 2)
    at = field(np.asarray(basis.global_coordinates()))
    return np.concatenate([basis.project(component)[: solid.nodes] for component in at])


@BilinearForm
def energy(u, v, w):  # type: ignore[no-untyped-def]
    """Twice the energy of displacements (radial, axial), as it stands in a textbook."""
    r = w.x[0]

    def strains(displacement, gradient):  # type: ignore[no-untyped-def]
        (rr, rz), (zr, zz) = gradient
        return rr, zz, (rz + zr) / np.sqrt(2), displacement[0] / r

    first, second = strains(u, u.grad), strains(v, v.grad)
    traces = (sum(first[i] for i in (0, 1, 3)), sum(second[i] for i in (0, 1, 3)))
    products = sum(a * b for a, b in zip(first, second, strict=True))
    return 2 * np.pi * r * (2 * w.shear * products + w.lame * traces[0] * traces[1])


@each_solid
@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.3, 0.4999])
def test_stiffness_is_that_of_the_bilinear_form(
    kind: str, degree: int, poisson_ratio: float
) -> None:
    mesh = rectangle(kind, 0.5, 1.5, 0.2, 1.0, 3)
    element = element_of_degree(mesh, degree)
    order = 2 * degree + (4 if kind == "triangles" else 1)
    basis = Basis(mesh, ElementVector(element), intorder=order)
    lame, shear = moduli(poisson_ratio)
    expected = energy.assemble(basis, lame=lame, shear=shear)
    functions, elements = np.arange(len(element.doflocs)), np.arange(mesh.nelements)
    found = stiffness(mesh, element, functions, elements, degree, poisson_ratio)
    # scikit-fem has both components of a function side by side
    blocks = found.transpose(0, 2, 1, 4, 3).reshape(len(found), *[2 * len(functions)] * 2)
    rows = np.broadcast_to(basis.element_dofs.T[:, :, None], blocks.shape)
    places = rows.ravel(), rows.transpose(0, 2, 1).ravel()
    assembled = coo_matrix((blocks.ravel(), places), expected.shape)
    assert abs(assembled - expected).max() <= 1e-13 * abs(expected).max()


def affine(right: float, down: float, wider: float, longer: float) -> Field:
    return lambda x: np.stack([right + wider * x[0], down + longer * x[1]])


def bent(x: Array) -> Array:
    """Every strain at once, and neither a body force nor a change of volume."""
    return np.stack([x[0] * x[1], x[0] ** 2 / 2 - x[1] ** 2])


@each_solid
@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.0, 0.3, 0.4999])
def test_patches(kind: str, degree: int, poisson_ratio: float) -> None:
    """Fields without body force leave no force inside, and have their exact energies.

    A rigid shift has none.
    """
    solid = AxisymmetricElasticity(rectangle(kind, 0.0, 1.0, 0.0, 1.0), degree, poisson_ratio)
    lame, shear = moduli(poisson_ratio)
    basis = Basis(solid.mesh, element_of_degree(solid.mesh, 1), intorder=8)
    (r, z), dx = np.asarray(basis.global_coordinates()), basis.dx
    volumes = 2 * np.pi * r * dx
    around = np.concatenate([solid.boundary(name) for name in AROUND])
    scale, volume = abs(solid.stiffness).max(), volumes.sum()
    shifted, stretched, widened = (
        coefficients(solid, affine(*parts)) for parts in ((0, 1, 0, 0), (0, 0, 0, 1), (0, 0, 1, 0))
    )
    rigid = solid.stiffness @ shifted
    assert np.abs(np.delete(rigid, solid.boundary("axis"))).max() <= 1e-12 * scale
    fields = [stretched, widened] + [coefficients(solid, bent)] * (degree > 1)
    forces = [solid.stiffness @ field for field in fields]
    for force in [rigid, *forces]:
        inside = np.delete(force, np.concatenate([around, around + solid.nodes]))
        assert np.abs(inside).max(initial=0) <= 1e-11 * scale
    assert stretched @ forces[0] == pytest.approx((lame + 2 * shear) * volume, rel=1e-11)
    assert widened @ forces[1] == pytest.approx(4 * (lame + shear) * volume, rel=1e-11)
    mixed = widened @ forces[0]
    assert mixed == pytest.approx(2 * lame * volume, rel=1e-11, abs=1e-13 * scale)
    if degree > 1:
        bending = shear * np.sum((12 * z**2 + 4 * r**2) * volumes)
        assert fields[2] @ forces[2] == pytest.approx(bending, rel=1e-9)


def greatest_error(
    solid: AxisymmetricElasticity, given: dict[str, tuple[int, ...]], field: Field
) -> float:
    """Solve with a field (n, 2) at (n, 2) points given on boundaries.

    Greatest error at vertices over the greatest value.
    """
    exact = np.full(2 * solid.nodes, np.nan)
    for name, components in given.items():
        values = solid.interpolate(name, field)
        for component in components:
            exact[solid.boundary(name) + component * solid.nodes] = values[:, component]
    exact[np.tile(solid.fixed, 2)] = 0.0
    free = np.isnan(exact)
    matrix = solid.stiffness.tocsr()
    exact[free] = spsolve(matrix[free][:, free].tocsc(), -matrix[free][:, ~free] @ exact[~free])
    expected = field(solid.mesh.p.T)
    found = exact.reshape(2, -1).T[: len(expected)]
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def lame_cylinder(kind: str, count: int, degree: int, poisson_ratio: float) -> float:
    """A thick-walled cylinder in plane strain, ``u_r = A r + B / r``, given on its walls."""
    mesh = rectangle(kind, 1.0, 2.0, 0.0, 1.0, count)
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    walls = {"inner": (0,), "outer": (0,), "top": (1,), "bottom": (1,)}
    return greatest_error(
        solid, walls, lambda x: np.stack([0.3 * x[:, 0] + 0.7 / x[:, 0], 0 * x[:, 0]], axis=1)
    )


def boussinesq(kind: str, count: int, degree: int, poisson_ratio: float) -> float:
    """A box on the axis in the field of a point force: all strains, hoop strain at the axis."""
    solid = AxisymmetricElasticity(
        rectangle(kind, 0.0, 1.0, 1.5, 2.5, count), degree, poisson_ratio
    )
    shear = moduli(poisson_ratio)[1]
    walls = dict.fromkeys(AROUND, (0, 1)) | {"inner": (0,)}
    return greatest_error(solid, walls, lambda x: poles(x, (0,), poisson_ratio, shear)[0][0])


@pytest.mark.parametrize(
    ("kind", "degree", "poisson_ratio", "order", "cap"),
    [
        ("triangles", 2, 0.3, 3, 5e-5),
        ("triangles", 3, 0.3, 4, 5e-7),
        ("triangles", 4, 0.3, 5, 1e-8),
        # without all the products inside, an order is lost on quadrilaterals that are no
        # parallelograms
        ("quadrilaterals", 3, 0.3, 4, 5e-7),
        ("quadrilaterals", 4, 0.3, 4, 1e-9),
        # nearly incompressible, dilatations of the lower degrees are not stable and an order is
        # lost; no more than one
        ("triangles", 2, 0.49999, 2, 5e-3),
        ("triangles", 3, 0.49999, 3, 1e-5),
        ("triangles", 4, 0.49999, 4, 1e-7),
        ("quadrilaterals", 4, 0.49999, 3, 1e-7),
    ],
)
@pytest.mark.parametrize("problem", [lame_cylinder, boussinesq])
def test_order_of_displacements_at_vertices(
    problem: Callable[..., float],
    kind: str,
    degree: int,
    poisson_ratio: float,
    order: int,
    cap: float,
) -> None:
    coarse, fine = (problem(kind, count, degree, poisson_ratio) for count in (8, 16))
    assert np.log2(coarse / fine) >= order - 0.45
    assert fine <= cap


@pytest.mark.parametrize(
    ("poisson_ratio", "highest", "cap"), [(0.0, 9, 1e-12), (0.3, 9, 5e-12), (0.49999, 7, 5e-9)]
)
def test_error_falls_exponentially_with_the_degree(
    poisson_ratio: float, highest: int, cap: float
) -> None:
    """On quadrilaterals numbered at random.

    Sides that ran differently in their two elements would stop it at 1e-4.
    """
    errors = [
        boussinesq("quadrilaterals", 4, degree, poisson_ratio)
        for degree in range(3, highest + 1, 2)
    ]
    assert (np.array(errors[:-1]) / errors[1:] >= 30).all()
    assert errors[-1] <= cap


@pytest.mark.parametrize(
    ("element", "cap"),
    # the last is without one of the products, and no complete quadratic on quadrilaterals that are
    # no parallelograms
    [(ElementQuad2(), 1e-10), (ElementTriP2B(), 1e-10), (ElementQuadS2(), 5e-6)],
    ids=["ElementQuad2", "ElementTriP2B", "ElementQuadS2"],
)
def test_an_element_of_ones_own(element: Element, cap: float) -> None:
    """Any H1 element of scikit-fem's."""
    kind = "triangles" if isinstance(element, ElementTriP2B) else "quadrilaterals"
    mesh = rectangle(kind, 0.0, 1.0, 0.0, 1.0, 8)
    solid = AxisymmetricElasticity(mesh, 2, 0.3, element)
    assert solid.element is element

    assert greatest_error(solid, dict.fromkeys(AROUND, (0, 1)), lambda x: bent(x.T).T) <= cap


def test_turned_quadrilaterals_agree_on_the_direction_of_every_side() -> None:
    mesh = rectangle("quadrilaterals", 0.0, 1.0, 0.0, 1.0, 6)
    runs = [(0, 1), (1, 2), (3, 2), (0, 3)]
    direction = np.zeros(mesh.nfacets)
    for side, (start, end) in enumerate(runs):
        np.add.at(direction, mesh.t2f[side], np.sign(mesh.t[end] - mesh.t[start]))
    assert (np.abs(direction[mesh.f2t[1] >= 0]) == 2).all()
    unturned = MeshQuad.init_tensor(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    np.testing.assert_array_equal(np.sort(turned(unturned).t, axis=0), np.sort(unturned.t, axis=0))


def test_degrees_of_layers_are_lower_where_the_mesh_allows_it() -> None:
    solid = AxisymmetricElasticity(rectangle("layers", 0.0, 1.0, 0.0, 1.0), 6, 0.3)
    assert set(solid.degrees) == {4, 5, 6}
    elements = [(batch.degree, type(batch.element)) for batch in solid.batches]
    assert elements == [(degree, ElementQuadP) for degree in (4, 5, 6)]
    first, second = solid.mesh.f2t
    lower = solid.degrees[np.stack([first, np.where(second < 0, first, second)])].min(axis=0)
    np.testing.assert_array_equal(solid.facet_degrees, lower)
    assert set(AxisymmetricElasticity(MeshTri(), 3, 0.3).degrees) == {3}
