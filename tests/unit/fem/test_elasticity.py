"""The axisymmetric solid on every kind of element, by identities.

Forms, patches, Lame's cylinder, Boussinesq's field.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import coo_matrix, tril
from scipy.sparse.linalg import spsolve
from skfem import (
    Basis,
    Element,
    ElementQuad2,
    ElementQuadS2,
    ElementTriP2B,
    Mesh,
    MeshQuad,
    MeshTri,
)

from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import poles
from ringwear.fem.weak_form import (
    axial_axial,
    element_of_degree,
    moduli,
    radial_axial,
    radial_radial,
    stiffness,
)
from ringwear.meshes.bisection import mesh as bisection
from ringwear.meshes.half_space import LOWER, turned
from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import SizeField

# kind of mesh and degree of the displacement; of `layers`, degrees differ from element to element
SOLIDS = [
    *(("triangles", degree) for degree in (1, 2, 3, 4)),
    *(("quadrilaterals", degree) for degree in (1, 2, 3, 5, 8)),
    *(("layers", degree) for degree in (4, 6, 8)),
]
every_solid = pytest.mark.parametrize(("kind", "degree"), SOLIDS)


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


@every_solid
@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.3, 0.4999])
def test_stiffness_is_that_of_the_bilinear_forms(
    kind: str, degree: int, poisson_ratio: float
) -> None:
    mesh = rectangle(kind, 0.5, 1.5, 0.2, 1.0, 3)
    element = element_of_degree(mesh, degree)
    basis = Basis(mesh, element, intorder=2 * degree + (4 if kind == "triangles" else 1))
    lame, shear = moduli(poisson_ratio)
    everything, dofs = np.arange(len(element.doflocs)), basis.element_dofs.T
    found = stiffness(mesh, element, everything, np.arange(mesh.nelements), degree, poisson_ratio)
    for form, one, other in ((radial_radial, 0, 0), (radial_axial, 0, 1), (axial_axial, 1, 1)):
        expected = form.assemble(basis, lame=lame, shear=shear)
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        assembled = coo_matrix(
            (found[:, one, :, other].ravel(), (rows.ravel(), columns.ravel())), expected.shape
        )
        assert abs(assembled - expected).max() <= 1e-13 * abs(expected).max()
    np.testing.assert_array_equal(found[:, 1, :, 0], found[:, 0, :, 1].transpose(0, 2, 1))


def shifted(x: Array) -> Array:
    return np.stack([0 * x[0], 1 + 0 * x[1]])


def stretched(x: Array) -> Array:
    return np.stack([0 * x[0], x[1]])


def widened(x: Array) -> Array:
    return np.stack([x[0], 0 * x[1]])


def bent(x: Array) -> Array:
    """Every strain at once, and neither a body force nor a change of volume."""
    return np.stack([x[0] * x[1], x[0] ** 2 / 2 - x[1] ** 2])


@every_solid
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
    around = np.unique(
        np.concatenate([solid.boundary(name) for name in ("inner", "outer", "top", "bottom")])
    )
    inside = np.setdiff1d(
        np.arange(2 * solid.nodes), np.concatenate([around, around + solid.nodes])
    )
    scale = abs(solid.stiffness).max()
    fields = [
        coefficients(solid, field)
        for field in (shifted, stretched, widened, bent)[: 3 + (degree > 1)]
    ]
    forces = [solid.stiffness @ field for field in fields]
    held = solid.boundary("axis")
    assert np.abs(np.delete(forces[0], held)).max() <= 1e-12 * scale
    for force in forces:
        assert np.abs(force[inside]).max() <= 1e-11 * scale
    assert fields[1] @ forces[1] == pytest.approx((lame + 2 * shear) * volumes.sum(), rel=1e-11)
    assert fields[2] @ forces[2] == pytest.approx(4 * (lame + shear) * volumes.sum(), rel=1e-11)
    assert fields[2] @ forces[1] == pytest.approx(
        2 * lame * volumes.sum(), rel=1e-11, abs=1e-13 * scale
    )
    if degree > 1:
        energy = shear * np.sum((12 * z**2 + 4 * r**2) * volumes)
        assert fields[3] @ forces[3] == pytest.approx(energy, rel=1e-9)


@every_solid
def test_stiffness_is_symmetric_and_definite_but_for_the_shift(kind: str, degree: int) -> None:
    solid = AxisymmetricElasticity(rectangle(kind, 0.0, 1.0, 0.0, 1.0, 3), degree, 0.3)
    dense = solid.stiffness.toarray()
    np.testing.assert_allclose(dense, dense.T, atol=1e-13 * np.abs(dense).max())
    held = np.concatenate([np.flatnonzero(solid.held), solid.boundary("axis")])
    free = np.setdiff1d(
        np.arange(len(dense)), np.concatenate([held, np.flatnonzero(solid.held) + solid.nodes])
    )
    eigenvalues = np.linalg.eigvalsh(dense[np.ix_(free, free)])
    assert abs(eigenvalues[0]) <= 1e-13 * eigenvalues[-1]
    assert eigenvalues[1] >= 1e-7 * eigenvalues[-1]


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_parts_of_the_stiffness(degree: int) -> None:
    """Its lower triangle with unknowns held and in another order, and forces of displacements here
    and there.
    """
    solid = AxisymmetricElasticity(
        bisection(SizeField((0.0, 0.4, 1.0), 1e-3, 1e-2, 0.6, 5.0)), degree, 0.3
    )
    size, random = 2 * solid.nodes, np.random.default_rng(degree)
    order = random.permutation(size)[: size // 2]
    position = np.full(size, -1)
    position[order] = np.arange(len(order))
    tolerance = 1e-14 * abs(solid.stiffness).max()
    expected = tril(solid.stiffness[order][:, order])
    assert abs(solid.lower_triangle(position) - expected).max() <= tolerance
    moved = np.zeros((size, 2))
    moved[order[:3]] = random.normal(size=(3, 2))
    assert np.abs(solid.forces(moved) - solid.stiffness @ moved).max() <= 10 * tolerance


Field = Callable[[Array], Array]


def greatest_error(
    solid: AxisymmetricElasticity, held: dict[str, tuple[int, ...]], field: Field
) -> float:
    """Solve with a field (n, 2) at (n, 2) points given on boundaries.

    Greatest error at vertices over the greatest value.
    """
    exact = np.full(2 * solid.nodes, np.nan)
    for name, components in held.items():
        values = solid.interpolate(name, field)
        for component in components:
            exact[solid.boundary(name) + component * solid.nodes] = values[:, component]
    exact[np.tile(solid.held, 2)] = 0.0
    free = np.isnan(exact)
    matrix = solid.stiffness.tocsr()
    exact[free] = spsolve(matrix[free][:, free].tocsc(), -matrix[free][:, ~free] @ exact[~free])
    expected = field(solid.mesh.p.T)
    found = exact.reshape(2, -1).T[: len(expected)]
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def lame_cylinder(kind: str, count: int, degree: int, poisson_ratio: float) -> float:
    """A thick-walled cylinder in plane strain, ``u_r = A r + B / r``, its radial displacements
    given.
    """
    solid = AxisymmetricElasticity(
        rectangle(kind, 1.0, 2.0, 0.0, 1.0, count), degree, poisson_ratio
    )

    def field(points: Array) -> Array:
        return np.stack([0.3 * points[:, 0] + 0.7 / points[:, 0], 0 * points[:, 0]], axis=1)

    return greatest_error(solid, {"inner": (0,), "outer": (0,), "top": (1,), "bottom": (1,)}, field)


def boussinesq(kind: str, count: int, degree: int, poisson_ratio: float) -> float:
    """A box on the axis, off the origin, in the field of a point force.

    All strains, and the hoop strain at the axis.
    """
    solid = AxisymmetricElasticity(
        rectangle(kind, 0.0, 1.0, 1.5, 2.5, count), degree, poisson_ratio
    )

    def field(points: Array) -> Array:
        return poles(points, (0,), poisson_ratio, moduli(poisson_ratio)[1])[0][0]

    return greatest_error(
        solid, {"inner": (0,), "outer": (0, 1), "top": (0, 1), "bottom": (0, 1)}, field
    )


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

    def field(points: Array) -> Array:
        return bent(points.T).T

    around = dict.fromkeys(("inner", "outer", "top", "bottom"), (0, 1))
    assert greatest_error(solid, around, field) <= cap


def test_turned_quadrilaterals_agree_on_the_direction_of_every_side() -> None:
    mesh = rectangle("quadrilaterals", 0.0, 1.0, 0.0, 1.0, 6)
    runs = [(0, 1), (1, 2), (3, 2), (0, 3)]
    direction = np.zeros(mesh.nfacets)
    for side, (start, end) in enumerate(runs):
        np.add.at(direction, mesh.t2f[side], np.sign(mesh.t[end] - mesh.t[start]))
    shared = mesh.f2t[1] >= 0
    assert (np.abs(direction[shared]) == 2).all()
    unturned = MeshQuad.init_tensor(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    np.testing.assert_array_equal(np.sort(turned(unturned).t, axis=0), np.sort(unturned.t, axis=0))


def test_degrees_of_layers_are_lower_where_the_mesh_allows_it() -> None:
    solid = AxisymmetricElasticity(rectangle("layers", 0.0, 1.0, 0.0, 1.0), 6, 0.3)
    assert set(solid.degrees) == {4, 5, 6}
    assert [(batch.degree, type(batch.element).__name__) for batch in solid.batches] == [
        (4, "ElementQuadP"),
        (5, "ElementQuadP"),
        (6, "ElementQuadP"),
    ]
    first, second = solid.mesh.f2t
    own = np.where(
        second < 0, solid.degrees[first], np.minimum(solid.degrees[first], solid.degrees[second])
    )
    np.testing.assert_array_equal(solid.facet_degrees, own)
    uniform = AxisymmetricElasticity(MeshTri(), 3, 0.3)
    assert set(uniform.degrees) == {3}
