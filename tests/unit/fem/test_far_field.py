"""Far fields: exact solutions with a free surface, on layers too, and the boundary tied to them."""

import numpy as np
import pytest

from ringwear import SizeField, bisection, press_flat
from ringwear.fem.condensation import symmetric
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import enough_poles, exterior_stiffness, poles
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.fem.layered_far_field import independent_count, loaded_fields
from ringwear.meshes.ground.ground import Ground

ORDERS = (0, 2, 4, 6)
# radius at which fields of loads on layers are tied to the mesh
OUTER = 2.5
SHEAR = 0.7
PLACES = np.array([[0.4, 1.1], [1.2, 0.9], [1.7, 0.2]])
each_ratio = pytest.mark.parametrize("ratio", [-0.3, 0.0, 0.3, 0.5])


def slopes(fields, places, step=1e-3):
    """Yield derivatives by radius and depth at places, by central differences of sixth order."""
    weights = {1: 45, -1: -45, 2: -9, -2: 9, 3: 1, -3: -1}
    for axis in np.eye(2):
        yield sum(w * fields(places + n * step * axis) for n, w in weights.items()) / (60 * step)


def assert_elastic(fields, places, ratio, shear):
    """Assert equilibrium and Hooke's law of (displacements, stresses) at places."""

    def both(points):
        return np.concatenate(fields(points), axis=-1)

    # radial and axial displacement, then stresses rr, zz, rz, hoop, of every field
    (by_r, by_z), radius = slopes(both, places), places[:, 0]
    u, _, rr, zz, rz, hoop = np.moveaxis(both(places), -1, 0)
    radial = by_r[..., 2] + by_z[..., 4] + (rr - hoop) / radius
    axial = by_r[..., 4] + by_z[..., 3] + rz / radius
    scale = np.abs(by_r).max(axis=(1, 2))[:, None]
    assert (np.maximum(np.abs(radial), np.abs(axial)) <= 1e-10 * scale).all()
    # strains times 2 G (1 + nu), finite at nu = 1/2
    trace = rr + zz + hoop
    strains = by_r[..., 0], by_z[..., 1], u / radius
    for strain, stress in zip(strains, (rr, zz, hoop), strict=True):
        hooke = (1 + ratio) * stress - ratio * trace
        assert (np.abs(2 * shear * (1 + ratio) * strain - hooke) <= 1e-10 * scale).all()
    assert (np.abs(shear * (by_z[..., 0] + by_r[..., 1]) - rz) <= 1e-10 * scale).all()


@each_ratio
def test_equilibrium_and_hooke(ratio):
    assert_elastic(lambda points: poles(points, ORDERS, ratio, SHEAR), PLACES, ratio, SHEAR)


def test_equilibrium_and_hooke_below_layers():
    below = GROUND.poisson_ratios[2], GROUND.shear_moduli[2]
    place = np.array([[2.3, 1.4]])
    assert_elastic(lambda points: loaded_fields(points, 3, GROUND, OUTER), place, *below)


@each_ratio
def test_surface_is_free(ratio):
    """A point force displaces the surface by ``(1 - nu) F / (2 pi G r)``, and towards itself."""
    radii = np.geomspace(0.1, 100, 7)
    moved, stress = poles(np.stack([radii, 0 * radii], axis=1), ORDERS, ratio, SHEAR)
    assert np.abs(stress[..., 1:3]).max() == 0
    np.testing.assert_allclose(moved[0, :, 1], (1 - ratio) / SHEAR / radii, rtol=1e-14)
    radial = -(1 - 2 * ratio) / (2 * SHEAR) / radii
    np.testing.assert_allclose(moved[0, :, 0], radial, rtol=1e-14, atol=1e-16)


@each_ratio
def test_exterior_stiffness_is_definite_and_scales_with_the_poles(ratio):
    """It is symmetric and definite, and proportional to ``1/rho^(n + m + 1)`` for poles n and m."""
    angles = np.linspace(0, np.pi / 2, 5)
    corners = 3 * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    sides = np.stack([corners[:-1], corners[1:]], axis=1)
    near, far = (
        exterior_stiffness(scale * sides, lambda points: poles(points, ORDERS, ratio, SHEAR))
        for scale in (1, 2)
    )
    np.testing.assert_allclose(near, near.T)
    assert np.linalg.eigvalsh(near).min() > 0
    np.testing.assert_allclose(far * 2 ** (np.add.outer(ORDERS, ORDERS) + 1.0), near, rtol=1e-12)


@pytest.mark.parametrize("orders", [(), (0, 2, 4)], ids=str)
def test_reactions_balance_the_force(orders):
    """Nodal forces sum to 1 on the contact, to -1 on the outer boundary, and are 0 elsewhere."""
    mesh = bisection.mesh(SizeField((0.0, 1.0), 1e-6, 1e-6, 0.35, 5.0))
    solid = AxisymmetricElasticity(mesh, 4, Ground.half_space(0.3))
    whole = HalfSpace(solid, pressure_space(solid, np.array([0.0, 1.0])), orders)
    moved = whole.displacements(press_flat(whole.compliance()).pressure[None])[0]
    stiffness = symmetric(solid.lower_triangle(np.arange(2 * solid.nodes)))
    forces = (stiffness @ moved[: solid.nodes].T.ravel())[solid.nodes :]
    far, contact = solid.boundary("far"), solid.boundary("contact")
    assert forces[contact].sum() == pytest.approx(1, rel=1e-10)
    assert forces[far].sum() == pytest.approx(-1, rel=1e-10)
    assert np.abs(np.delete(forces, np.concatenate([far, contact]))).max() <= 1e-11


@pytest.mark.parametrize(
    ("truncation", "negligible"), [(2.5, 1e-9), (5.0, 1e-9), (2.5, 1e-10), (1e3, 1e-9)]
)
def test_enough_poles_returns_the_least_sufficient_number(truncation, negligible):
    """The first pole neglected after n has the order 4n + 1 in a/R; one pole less would not do."""
    count = len(enough_poles(truncation, negligible))
    assert truncation ** -(4 * count + 1) <= negligible
    assert count == 1 or truncation ** -(4 * count - 3) > negligible


GROUND = Ground((0.5, 0.4), (0.35, 3.0, 0.1), (0.3, 0.2, 0.45))


def at(radius, depth, ground=GROUND, count=3):
    points = np.stack(np.broadcast_arrays(np.asarray(radius, float), depth), axis=-1)
    return loaded_fields(np.atleast_2d(points), count, ground, OUTER)


def test_an_interface_between_equal_layers_changes_nothing():
    radii, depths = np.array([2.5, 1.5, 0.3]), np.array([0.1, 2.0, 2.6])
    fields = [
        at(radii, depths, Ground((thickness,), (0.35, 0.35), (0.3, 0.3)))
        for thickness in (0.2, 2.2)
    ]
    for first, second in zip(*fields, strict=True):
        assert second == pytest.approx(first, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("depth", [0.5, 0.9])
def test_fields_are_continuous_across_interfaces(depth):
    radii = np.array([1.5, 2.0, 2.4])
    (above, stress_above), (below, stress_below) = (
        at(radii, depth * (1 + sign * 1e-12)) for sign in (-1, 1)
    )
    assert above == pytest.approx(below, abs=1e-9)
    # zz and rz act across the interface
    assert stress_above[..., 1:3] == pytest.approx(stress_below[..., 1:3], abs=1e-9)
    assert np.abs(stress_above[..., 0] - stress_below[..., 0]).max() > 1e-4


def test_the_surface_beside_the_load_is_free():
    _, stress = at(np.array([2.0, 2.3, 2.5]), 0.0)
    assert np.abs(stress[..., 1:3]).max() < 1e-10


def test_a_rigid_base_does_not_move():
    rigid = Ground((0.5,), (0.35, np.inf), (0.3, 0.0))
    moved, _ = at(np.array([2.0, 2.4]), 0.5, rigid)
    assert np.abs(moved).max() < 1e-10


def test_dependent_and_vanishing_fields_are_not_counted():
    alike = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-12]])
    assert independent_count(alike, 1.0) == 1
    assert independent_count(1e-20 * np.eye(3), 1.0) == 0
    assert independent_count(np.diag([1.0, 2.0, 0.5]), 1.0) == 3
    # a ground a billion times as soft has the same fields
    fading = np.diag(10.0 ** -np.arange(0, 40, 2))
    assert 0 < independent_count(fading, 1.0) == independent_count(1e-9 * fading, 1e-9) < 20
