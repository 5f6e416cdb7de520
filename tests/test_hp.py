"""Elements of high degree: polynomials exactly, then Boussinesq's pole, the flat punch, rings and inner stresses."""

from __future__ import annotations

import importlib.util
from functools import cache, partial

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from fem.compliance import HalfSpace
from fem.elasticity import moduli
from fem.far_field import pole
from fem.fields import displacements
from fem.hp import HpElasticity
from fem.hp_fields import sampled
from mdr.compliance import compliance as mdr_compliance
from mdr.direct import displacement as exact_displacement
from mdr.direct import greatest_displacement
from meshes import stars
from meshes.radial import Array, Indices
from meshes.stars import StarMesh
from studies.contact import flat_start

FLAT, FIVE = np.array([0.0, 1.0]), np.linspace(0, 1, 6)
SOLVERS = ["superlu"] + ["cholmod"] * bool(importlib.util.find_spec("kvxopt"))


@cache
def half_space(
    rings: int, degree: int, poisson_ratio: float, solver: str = "", poles: tuple[int, ...] = (0, 2, 4)
) -> HalfSpace:
    """Equal rings; layers as fine as the degree deserves."""
    edges = FLAT if rings == 1 else np.linspace(0, 1, rings + 1)
    mesh = stars.mesh(edges, 10.0 ** (-degree / 2), 10.0 ** (-1 - degree), 0.25, 0.8, 5.0)
    solid = HpElasticity(mesh, degree, poisson_ratio)
    return HalfSpace(solid, solid.pressure_space(edges), poles, solver)


def rectangle(r0: float, r1: float, z0: float, z1: float, count: int = 4) -> StarMesh:
    """`count` by `count` skew quadrilaterals, no two alike, those of the outer half cut in two, in layers of all kinds."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(0, 1, count + 1)] * 2, indexing="ij"))
    skew = 0.5 * x * (1 - x) * y * (1 - y)
    points = np.stack([r0 + (r1 - r0) * (x + skew), z0 + (z1 - z0) * (y - skew)], axis=1)
    number = np.arange((count + 1) ** 2).reshape(count + 1, -1)
    cells = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=2)
    inner, outer = cells[: count // 2].reshape(-1, 4), cells[count // 2 :].reshape(-1, 4)
    triangles = np.concatenate([outer[:, [0, 1, 2]], outer[:, [2, 3, 0]]])

    def facets(vertices: Indices) -> Indices:
        return np.stack([vertices[:-1], vertices[1:]], axis=1)

    sides = {"inner": number[0], "outer": number[-1], "top": number[:, 0], "bottom": number[:, -1]}
    boundaries = {name: facets(vertices) for name, vertices in sides.items()}
    return StarMesh(points, inner, triangles, np.arange(len(inner)) % 3, boundaries, "test")


def greatest_error(solid: HpElasticity, held: dict[str, tuple[int, ...]], field: partial[Array]) -> float:
    """Solve with a field given on boundaries, in some components; greatest error at vertices over the greatest value."""
    exact = np.full(2 * solid.nodes, np.nan)
    for name, components in held.items():
        values = solid.interpolate(name, field)
        for component in components:
            exact[solid.boundary(name) + component * solid.nodes] = values[:, component]
    free = np.isnan(exact)
    stiffness = solid.stiffness.tocsr()
    exact[free] = spsolve(stiffness[free][:, free].tocsc(), -stiffness[free][:, ~free] @ exact[~free])
    expected = field(solid.mesh.points)
    found = exact.reshape(2, -1).T[: len(expected)]
    return float(np.abs(found - expected).max() / np.abs(expected).max())


BOTH = dict.fromkeys(("inner", "outer", "top", "bottom"), (0, 1))


def linear(points: Array) -> Array:
    return points @ np.array([[0.7, 0.0], [0.0, -0.4]]) + [0, 0.3]


def bent(points: Array) -> Array:
    """Every strain at once, and neither a body force nor a change of volume."""
    r, z = points.T
    return np.stack([r * z, r**2 / 2 - z**2], axis=1)


@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.0, 0.3, 0.4999])
@pytest.mark.parametrize("degree", range(2, 9))
@pytest.mark.parametrize("lowest", [2, 3])
def test_patches(degree: int, lowest: int, poisson_ratio: float) -> None:
    """Polynomials without body force, on quadrilaterals and triangles of mixed degrees."""
    solid = HpElasticity(rectangle(0.0, 1.0, 0.0, 1.0), degree, poisson_ratio, lowest)
    assert greatest_error(solid, BOTH, linear) <= 1e-11
    assert greatest_error(solid, BOTH, bent) <= 1e-11


@pytest.mark.parametrize("degree", [2, 5, 8])
def test_energies(degree: int) -> None:
    """A shift has none; uniform strains have those of their volume."""
    solid = HpElasticity(stars.mesh([0.0, 0.4, 1.0], 1e-2, 1e-4, 0.25, 0.8, 5.0), degree, 0.3)
    lame, shear = moduli(0.3)
    points = solid.mesh.points
    r, z = np.pad(points.T, ((0, 0), (0, solid.nodes - len(points))))
    none, vertices = np.zeros(solid.nodes), np.arange(solid.nodes) < len(points)
    a, b = points[solid.mesh.boundaries["far"]].transpose(1, 2, 0)
    # Guldin: the cones over the sides of the outer polygon
    volume = 2 * np.pi / 6 * (np.abs(a[0] * b[1] - b[0] * a[1]) * (a[0] + b[0])).sum()
    stiffness = solid.stiffness
    assert np.abs(stiffness @ np.append(none, vertices)).max() <= 1e-13 * abs(stiffness).max()
    stretched, widened = np.append(none, z), np.append(r, none)
    assert stretched @ stiffness @ stretched == pytest.approx((lame + 2 * shear) * volume, rel=1e-11)
    assert widened @ stiffness @ widened == pytest.approx(4 * (lame + shear) * volume, rel=1e-11)
    assert widened @ stiffness @ stretched == pytest.approx(2 * lame * volume, rel=1e-11)
    moved = np.stack([stretched, np.append(none, vertices)], axis=1)
    np.testing.assert_allclose(solid.forces(moved), stiffness @ moved, atol=1e-12 * abs(stiffness).max())


def test_stiffness_is_symmetric_and_definite_but_for_the_shift() -> None:
    solid = HpElasticity(rectangle(0.0, 1.0, 0.0, 1.0), 5, 0.3)
    stiffness = solid.stiffness.toarray()
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-13 * np.abs(stiffness).max())
    free = np.setdiff1d(np.arange(len(stiffness)), solid.boundary("inner"))
    eigenvalues = np.linalg.eigvalsh(stiffness[np.ix_(free, free)])
    assert abs(eigenvalues[0]) <= 1e-13 * eigenvalues[-1]
    assert eigenvalues[1] >= 1e-6 * eigenvalues[-1]


@pytest.mark.parametrize(("poisson_ratio", "cap"), [(0.0, 1e-12), (0.3, 5e-12), (0.49999, 5e-9)])
def test_boussinesq_by_degree(poisson_ratio: float, cap: float) -> None:
    """The field of a point force in a box on the axis, off the origin: every two degrees gain a factor."""

    def field(points: Array) -> Array:
        return pole(points, 0, poisson_ratio, moduli(poisson_ratio)[1])[0]

    held = {"inner": (0,), "outer": (0, 1), "top": (0, 1), "bottom": (0, 1)}
    mesh = rectangle(0.0, 1.0, 1.5, 2.5)
    errors = [greatest_error(HpElasticity(mesh, degree, poisson_ratio, degree - 1), held, field) for degree in (3, 5, 7, 9)]
    assert (np.array(errors[:-1]) / errors[1:] >= 30).all()
    assert errors[-1] <= cap


@pytest.mark.parametrize(
    ("poisson_ratio", "caps"),
    [(0.0, (1e-5, 1e-7, 2e-9)), (0.3, (1e-5, 1e-7, 2e-9)), (0.4999, (2e-4, 2e-6, 3e-8)), (0.5, (4e-4, 2e-6, 3e-8))],
)
def test_flat_punch(poisson_ratio: float, caps: tuple[float, ...]) -> None:
    errors = [abs(2 * flat_start(half_space(1, degree, poisson_ratio).compliance()).indentation - 1) for degree in (4, 6, 8)]
    assert (np.array(errors) <= caps).all()
    # exponential: a decade by degree, or nearly so
    assert errors[0] / errors[2] >= 3e3


@pytest.mark.parametrize(("degree", "energies", "heights"), [(5, 3e-5, 1e-4), (6, 2e-6, 3e-5), (8, 1e-7, 1e-5)])
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999])
def test_ringwise_constant_pressures(degree: int, poisson_ratio: float, energies: float, heights: float) -> None:
    """Energies of all of them at once, and displacements of one, against closed forms."""
    whole = half_space(5, degree, poisson_ratio)
    found, space = whole.compliance(), whole.space
    rings = space.ring_indicator()
    triangle = np.linalg.qr(mdr_compliance(space).factor @ rings, mode="r")
    ratios = np.linalg.svd(np.linalg.solve(triangle.T, (found.factor @ rings).T), compute_uv=False) ** 2
    assert np.abs(ratios - 1).max() <= energies
    pressures = np.array([1.0, 0.1, 1.0, 0.1, 1.0])
    radii, moved = whole.contact_displacement(rings @ pressures)
    expected = exact_displacement(FIVE, pressures, radii)
    assert np.abs(moved / expected - 1).max() <= heights
    assert moved.max() == pytest.approx(greatest_displacement(FIVE, pressures), rel=energies)
    at, weights, slopes = whole.contact_slope(moved)
    assert weights.sum() == pytest.approx(1, rel=1e-12)
    assert (slopes * weights).sum() == pytest.approx(expected[-1] - expected[0], rel=heights)
    assert (np.diff(at.ravel()) > 0).all()


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.4999])
@pytest.mark.parametrize(("rings", "degree"), [(1, 4), (1, 8), (5, 5), (5, 8)])
def test_multipliers_are_stable(rings: int, degree: int, poisson_ratio: float) -> None:
    """Checkerboards: pressures that the displacements do not see, beside a compliance that sees them all."""
    found = half_space(rings, degree, poisson_ratio).compliance()
    exact = np.linalg.qr(mdr_compliance(found.space).factor, mode="r")
    ratios = np.linalg.svd(np.linalg.solve(exact.T, found.factor.T), compute_uv=False) ** 2
    assert ratios.min() >= 0.5
    assert ratios.max() <= 1 + 1e-9


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("poles", [(), (0, 2, 4)], ids=str)
def test_saddle_point_agrees(solver: str, poles: tuple[int, ...]) -> None:
    whole = half_space(3, 4, 0.3, solver, poles)
    pressure, indentation = whole.saddle_point(force=2.0)
    condensed = flat_start(whole.compliance())
    assert 2 * condensed.indentation == pytest.approx(indentation, rel=1e-10)
    energy = whole.compliance().factor @ (2 * condensed.pressure - pressure)
    assert np.linalg.norm(energy) <= 1e-9 * np.sqrt(2 * indentation)


def test_coupling_carries_forces_and_moments() -> None:
    """Constant and linear displacements on the contact meet each pressure with its force and its moment."""
    whole = half_space(5, 6, 0.3)
    ones, radii = (whole.solid.interpolate("contact", field)[:, 0] for field in (np.ones_like, np.asarray))
    coupling = whole.coupling[: len(radii)]
    np.testing.assert_allclose(ones @ coupling, whole.space.weights, rtol=1e-12, atol=1e-16)
    moments = 2 * np.pi * np.diff(FIVE**3) / 3
    np.testing.assert_allclose(radii @ coupling @ whole.space.ring_indicator(), moments, rtol=1e-12)


def test_one_degree_less() -> None:
    solid = half_space(5, 6, 0.3).solid
    coarser = solid.coarser()
    assert isinstance(coarser, HpElasticity)
    found, twin = ([batch.degree for batch in one.batches] for one in (solid, coarser))
    assert found == [3, 4, 5, 6, 6]
    assert twin == [3, 4, 5, 5]
    assert coarser.unknowns < 0.8 * solid.unknowns
    # a shell less in every star, on either side of its edge
    assert len(coarser.mesh.quadrilaterals) == len(solid.mesh.quadrilaterals) - 4 * 5
    assert len(coarser.mesh.contact_radii) == len(solid.mesh.contact_radii) - 9
    assert coarser.mesh.quality.min() >= solid.mesh.quality.min()
    np.testing.assert_array_equal(np.diff(coarser.mesh.contact_radii).min() > np.diff(solid.mesh.contact_radii).min(), True)


@pytest.fixture(scope="module", params=[0.0, 0.3, 0.4999, 0.5])
def loaded(request: pytest.FixtureRequest) -> tuple[float, tuple[Array, Indices, Array, Array]]:
    """Unit pressure on the whole contact."""
    whole = half_space(2, 8, request.param)
    pressure = whole.space.ring_indicator().sum(axis=1)
    return request.param, sampled(whole, pressure[None], 5)


def test_stresses_of_a_loaded_disc(loaded: tuple[float, tuple[Array, Indices, Array, Array]]) -> None:
    """Love: ``zz = c^3 - 1`` and ``rr = (1 + nu) c - (1 + 2 nu)/2 - c^3/2`` on the axis, c the cosine to the rim."""
    poisson_ratio, (points, _, moved, stress) = loaded
    depth = points[:, 1]
    axis, surface = points[:, 0] == 0, depth == 0
    cosine = depth[axis] / np.hypot(1, depth[axis])
    rr, zz, rz, hoop = stress[0, axis].T
    assert np.abs(zz - (cosine**3 - 1)).max() <= 3e-5
    assert np.abs(rr - ((1 + poisson_ratio) * cosine - 0.5 - poisson_ratio - cosine**3 / 2)).max() <= 3e-5
    assert np.abs(hoop - rr).max() <= 1e-12
    assert np.abs(rz).max() <= 3e-5
    # the load, and nothing beside it, but for the last layers at the rim
    _, zz, rz, _ = stress[0, surface].T
    off_rim = np.abs(points[surface, 0] - 1) > 0.02
    load = np.where(points[surface, 0] < 1, -1.0, 0.0)
    assert np.abs(zz - load)[off_rim].max() <= 5e-4
    assert np.abs(rz)[off_rim].max() <= 5e-4
    near = surface & (points[:, 0] < 2.5)
    np.testing.assert_allclose(moved[0, near, 1], exact_displacement(FLAT, np.ones(1), points[near, 0]), rtol=2e-6)


def test_samples_fill_the_half_space_and_agree_on_sides(loaded: tuple[float, tuple[Array, Indices, Array, Array]]) -> None:
    _, (points, triangles, moved, _) = loaded
    a, b, c = points[triangles].transpose(1, 2, 0)
    areas = ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2
    far = half_space(2, 8, 0.3).solid.mesh
    ends = far.points[far.boundaries["far"]]
    fan = np.abs(ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]).sum() / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(fan, rel=1e-12)
    # points on sides are told by both elements, of different degrees and kinds: the displacement is one
    off_rim = np.flatnonzero(np.hypot(points[:, 0] - 1, points[:, 1]) > 1e-3)
    place = np.round(points[off_rim], 9)
    _, first, same = np.unique(place, axis=0, return_index=True, return_inverse=True)
    assert len(first) < 0.9 * len(place)
    np.testing.assert_allclose(moved[0, off_rim], moved[0, off_rim[first]][same], atol=1e-7)


def test_work_of_the_pressures() -> None:
    """``p . A p`` by the displacements that the pressures make."""
    whole = half_space(5, 5, 0.3)
    pressures = whole.space.ring_indicator().T
    contact = whole.solid.boundary("contact")
    work = displacements(whole, pressures)[:, contact, 1] @ whole.coupling[: len(contact)] @ pressures.T
    np.testing.assert_allclose(work, pressures @ whole.compliance().matrix @ pressures.T, rtol=1e-9)
