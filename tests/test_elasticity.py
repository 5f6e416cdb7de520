"""The axisymmetric elements by identities: rigid shift, patches, Lame's cylinder, and fields of Boussinesq's pole."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import tril
from scipy.sparse.linalg import spsolve

from fem.elasticity import AxisymmetricElasticity, moduli
from fem.far_field import pole
from meshes.bisection import mesh as bisection
from meshes.half_space import HalfSpaceMesh, SizeField
from meshes.radial import Array

DEGREES = [1, 2, 3, 4]


def rectangle(r0: float, r1: float, z0: float, z1: float, count: int) -> HalfSpaceMesh:
    """`count` by `count` squares, each cut in two, with every boundary named; a slanted inside avoids symmetry."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(0, 1, count + 1)] * 2, indexing="ij"))
    skew = 0.3 * x * (1 - x) * y * (1 - y)
    points = np.stack([r0 + (r1 - r0) * (x + skew), z0 + (z1 - z0) * (y - skew)], axis=1)
    number = np.arange((count + 1) ** 2).reshape(count + 1, -1)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    def facets(vertices: Array) -> Array:
        return np.stack([vertices[:-1], vertices[1:]], axis=1)

    sides = {"inner": number[0], "outer": number[-1], "top": number[:, 0], "bottom": number[:, -1]}
    boundaries = {name: facets(vertices) for name, vertices in sides.items()}
    boundaries["axis"] = boundaries["inner"] if r0 == 0 else np.empty((0, 2), dtype=np.int64)
    return HalfSpaceMesh(points, triangles, boundaries, "test")


def cubature(mesh: HalfSpaceMesh) -> tuple[Array, Array, Array]:
    """Radius, depth and volume of points that integrate polynomials up to the square over the solid of revolution."""
    barycentric = np.array([[5, 5, 5], [9, 3, 3], [3, 9, 3], [3, 3, 9]]) / 15
    r, z = np.einsum("qv,mvx->xqm", barycentric, mesh.points[mesh.triangles])
    weight = np.array([[-27], [25], [25], [25]]) / 48 * mesh.areas
    return r.ravel(), z.ravel(), (2 * np.pi * r * weight).ravel()


@pytest.fixture(scope="module")
def quarter_disc() -> HalfSpaceMesh:
    return bisection(SizeField((0.0, 0.4, 1.0), 1e-3, 1e-2, 0.6, 5.0))


@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.0, 0.3, 0.4999])
@pytest.mark.parametrize("degree", DEGREES)
def test_patches(quarter_disc: HalfSpaceMesh, degree: int, poisson_ratio: float) -> None:
    """Polynomial fields without body force, which the elements hold exactly, have their exact energies."""
    solid = AxisymmetricElasticity(quarter_disc, degree, poisson_ratio)
    lame, shear = moduli(poisson_ratio)
    stiffness, (r, z) = solid.stiffness, solid.positions.T
    radii, depths, volumes = cubature(quarter_disc)
    volume = volumes.sum()
    none = np.zeros(solid.nodes)
    # a rigid shift feels no force at any node
    assert np.abs(stiffness @ np.append(none, none + 1)).max() <= 1e-13 * abs(stiffness).max()
    stretched, widened = np.append(none, z), np.append(r, none)
    assert stretched @ stiffness @ stretched == pytest.approx((lame + 2 * shear) * volume, rel=1e-12)
    assert widened @ stiffness @ widened == pytest.approx(4 * (lame + shear) * volume, rel=1e-12)
    assert widened @ stiffness @ stretched == pytest.approx(2 * lame * volume, rel=1e-12, abs=1e-13 * volume)
    if degree > 1:
        # every strain at once, without a change of volume
        bent = np.append(r * z, r**2 / 2 - z**2)
        energy = shear * (12 * depths**2 + 4 * radii**2) @ volumes
        assert bent @ stiffness @ bent == pytest.approx(energy, rel=1e-11)


def test_stiffness_is_symmetric_and_definite_but_for_the_shift() -> None:
    solid = AxisymmetricElasticity(rectangle(0.0, 1.0, 0.0, 1.0, 3), 3, 0.3)
    stiffness = solid.stiffness.toarray()
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-13 * np.abs(stiffness).max())
    free = np.setdiff1d(np.arange(len(stiffness)), solid.boundary("axis"))
    eigenvalues = np.linalg.eigvalsh(stiffness[np.ix_(free, free)])
    assert abs(eigenvalues[0]) <= 1e-13 * eigenvalues[-1]
    assert eigenvalues[1] >= 1e-6 * eigenvalues[-1]


@pytest.mark.parametrize("degree", DEGREES)
def test_parts_of_the_stiffness(quarter_disc: HalfSpaceMesh, degree: int) -> None:
    """Its lower triangle with unknowns held and in another order, and forces of displacements here and there."""
    solid = AxisymmetricElasticity(quarter_disc, degree, 0.3)
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


def greatest_error(solid: AxisymmetricElasticity, held: Array, exact: Array) -> float:
    """Solve with the exact values on `held` unknowns; greatest nodal error over the greatest displacement."""
    free = np.setdiff1d(np.arange(2 * solid.nodes), held)
    stiffness = solid.stiffness.tocsr()
    found = spsolve(stiffness[free][:, free].tocsc(), -stiffness[free][:, held] @ exact[held])
    return float(np.abs(found - exact[free]).max() / np.abs(exact).max())


def lame_cylinder(count: int, degree: int, poisson_ratio: float) -> float:
    """A thick-walled cylinder in plane strain, ``u_r = A r + B / r``, its radial displacements given."""
    solid = AxisymmetricElasticity(rectangle(1.0, 2.0, 0.0, 1.0, count), degree, poisson_ratio)
    r, _ = solid.positions.T
    exact = np.append(0.3 * r + 0.7 / r, np.zeros(solid.nodes))
    held = [solid.boundary("inner"), solid.boundary("outer")]
    held += [solid.boundary(name) + solid.nodes for name in ("top", "bottom")]
    return greatest_error(solid, np.unique(np.concatenate(held)), exact)


def boussinesq(count: int, degree: int, poisson_ratio: float) -> float:
    """A box on the axis, off the origin, in the field of a point force: all strains, and the hoop strain at the axis."""
    solid = AxisymmetricElasticity(rectangle(0.0, 1.0, 1.5, 2.5, count), degree, poisson_ratio)
    exact = pole(solid.positions, 0, poisson_ratio, moduli(poisson_ratio)[1])[0].T.ravel()
    around = np.unique(np.concatenate([solid.boundary(name) for name in ("outer", "top", "bottom")]))
    held = np.concatenate([around, around + solid.nodes, solid.boundary("axis")])
    return greatest_error(solid, np.unique(held), exact)


@pytest.mark.parametrize(
    ("degree", "poisson_ratio", "order", "cap"),
    [(2, 0.3, 3, 5e-5), (3, 0.3, 4, 5e-7), (4, 0.3, 5, 1e-8),
     # nearly incompressible, dilatations of the lower degrees are not stable and an order is lost; no more than one
     (2, 0.49999, 2, 5e-3), (3, 0.49999, 3, 5e-6), (4, 0.49999, 5, 2e-8)],
)  # fmt: skip
@pytest.mark.parametrize("problem", [lame_cylinder, boussinesq])
def test_order_of_nodal_displacements(
    problem: Callable[[int, int, float], float], degree: int, poisson_ratio: float, order: int, cap: float
) -> None:
    coarse, fine = (problem(count, degree, poisson_ratio) for count in (8, 16))
    assert np.log2(coarse / fine) >= order - 0.45
    assert fine <= cap
