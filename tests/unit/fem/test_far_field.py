"""Boussinesq's poles: exact solutions with a free surface, and the boundary tied to them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from ringwear.fem import (
    AxisymmetricElasticity,
    HalfSpace,
    displacements,
    enough_poles,
    exterior_stiffness,
    poles,
    pressure_space,
)
from ringwear.meshes import Array, SizeField, bisection
from ringwear.studies.wear.flat_contact import press_flat

ORDERS = (0, 2, 4, 6)
SHEAR = 0.7
PLACES = np.array([[0.4, 1.1], [1.2, 0.9], [1.7, 0.2]])
EDGES = np.array([0.0, 1.0])
each_ratio = pytest.mark.parametrize("ratio", [-0.3, 0.0, 0.3, 0.5])


def slopes(fields: Any, step: float = 1e-3) -> Any:
    """Derivatives by radius and depth at `PLACES`: central differences of sixth order."""
    weights = {1: 45, -1: -45, 2: -9, -2: 9, 3: 1, -3: -1}
    for axis in np.eye(2):
        yield sum(w * fields(PLACES + n * step * axis) for n, w in weights.items()) / (60 * step)


@each_ratio
def test_equilibrium_and_hooke(ratio: float) -> None:
    def fields(points: Array) -> Array:
        return np.concatenate(poles(points, ORDERS, ratio, SHEAR), axis=-1)

    # radial and axial displacement, then stresses rr, zz, rz, hoop, of every pole
    (by_r, by_z), radius = slopes(fields), PLACES[:, 0]
    u, _, rr, zz, rz, hoop = np.moveaxis(fields(PLACES), -1, 0)
    radial = by_r[..., 2] + by_z[..., 4] + (rr - hoop) / radius
    axial = by_r[..., 4] + by_z[..., 3] + rz / radius
    scale = np.abs(by_r).max(axis=(1, 2))[:, None]
    assert (np.maximum(np.abs(radial), np.abs(axial)) <= 1e-10 * scale).all()
    # strains times 2 G (1 + nu), finite at nu = 1/2
    trace = rr + zz + hoop
    strains = by_r[..., 0], by_z[..., 1], u / radius
    for strain, stress in zip(strains, (rr, zz, hoop), strict=True):
        hooke = (1 + ratio) * stress - ratio * trace
        assert (np.abs(2 * SHEAR * (1 + ratio) * strain - hooke) <= 1e-10 * scale).all()
    assert (np.abs(SHEAR * (by_z[..., 0] + by_r[..., 1]) - rz) <= 1e-10 * scale).all()


@each_ratio
def test_surface_is_free(ratio: float) -> None:
    """And sinks under a point force by ``(1 - nu) F / (2 pi G r)``, drawn towards it."""
    radii = np.geomspace(0.1, 100, 7)
    moved, stress = poles(np.stack([radii, 0 * radii], axis=1), ORDERS, ratio, SHEAR)
    assert np.abs(stress[..., 1:3]).max() == 0
    np.testing.assert_allclose(moved[0, :, 1], (1 - ratio) / SHEAR / radii, rtol=1e-14)
    radial = -(1 - 2 * ratio) / (2 * SHEAR) / radii
    np.testing.assert_allclose(moved[0, :, 0], radial, rtol=1e-14, atol=1e-16)


@each_ratio
@pytest.mark.parametrize("order", ORDERS[:3])
def test_poles_are_laplacians_of_boussinesq(order: int, ratio: float) -> None:
    """Order 0 is a point force 2 pi, two orders more its horizontal Laplacian, sign turned."""

    def laplacian(times: int, r: Any, z: Any) -> Any:
        if times == 0:
            rho = mp.hypot(r, z)
            return (z**2 / rho**3 + 2 * (1 - ratio) / rho) / (2 * SHEAR)

        def before(x: Any) -> Any:
            return laplacian(times - 1, x, z)

        return -(mp.diff(before, r, 2) + mp.diff(before, r) / r)

    with mp.workdps(60):
        exact = [laplacian(order // 2, mp.mpf(r), mp.mpf(z)) for r, z in PLACES]
        expected = np.array([value / mp.factorial(order) for value in exact], dtype=float)
    found = poles(PLACES, (order,), ratio, SHEAR)[0][0, :, 1]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-13)


def polygon(sides: int, radius: float = 3.0) -> Array:
    angles = np.linspace(0, np.pi / 2, sides + 1)
    corners = radius * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    return np.stack([corners[:-1], corners[1:]], axis=1)


@each_ratio
def test_exterior_energy_is_that_of_the_exterior(ratio: float) -> None:
    """Symmetric and definite, and for similar boundaries as ``1/rho^(n + m + 1)``."""
    near, far = (exterior_stiffness(polygon(4, r), ORDERS, ratio, SHEAR) for r in (3.0, 6.0))
    np.testing.assert_allclose(near, near.T)
    assert np.linalg.eigvalsh(near).min() > 0
    np.testing.assert_allclose(far * 2 ** (np.add.outer(ORDERS, ORDERS) + 1.0), near, rtol=1e-12)


@cache
def half_space(truncation: float, orders: tuple[int, ...], growth: float = 0.35) -> HalfSpace:
    mesh = bisection.mesh(SizeField((0.0, 1.0), 1e-6, 1e-6, growth, truncation))
    solid = AxisymmetricElasticity(mesh, 4, 0.3)
    return HalfSpace(solid, pressure_space(solid, EDGES), orders)


def indentation_error(radius: float, orders: tuple[int, ...], growth: float) -> float:
    return press_flat(half_space(radius, orders, growth).compliance()).indentation / 0.5 - 1


@pytest.mark.parametrize("orders", [(), (0,), (0, 2, 4)], ids=str)
def test_reactions_balance_the_force(orders: tuple[int, ...]) -> None:
    """Nodal forces: the load on the contact, its opposite on the outer boundary, nothing else."""
    whole = half_space(5.0, orders)
    solid, pressure = whole.solid, press_flat(whole.compliance()).pressure
    moved = displacements(whole, pressure[None])[0]
    forces = (solid.stiffness @ moved[: solid.nodes].T.ravel())[solid.nodes :]
    far, contact = solid.boundary("far"), solid.boundary("contact")
    assert forces[contact].sum() == pytest.approx(1, rel=1e-10)
    assert forces[far].sum() == pytest.approx(-1, rel=1e-10)
    assert np.abs(np.delete(forces, np.concatenate([far, contact]))).max() <= 1e-11


def test_a_clamped_boundary_errs_by_one_over_its_radius() -> None:
    errors = [indentation_error(radius, (), 0.5) for radius in (20.0, 40.0, 80.0)]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize(("orders", "order"), [((0,), 5), ((0, 2), 9)], ids=str)
def test_order_of_the_tied_boundary(orders: tuple[int, ...], order: int) -> None:
    """Each pole that is tied cancels four powers of the truncation radius."""
    near, far = (abs(indentation_error(radius, orders, 0.2)) for radius in (2.0, 3.0))
    assert np.log(near / far) / np.log(3 / 2) >= order - 1


@pytest.mark.parametrize(
    ("truncation", "negligible"), [(2.5, 1e-9), (5.0, 1e-9), (2.5, 1e-10), (1e3, 1e-9)]
)
def test_poles_are_enough(truncation: float, negligible: float) -> None:
    """The first neglected is of order 4n + 1 in a/R; a pole less would not be enough."""
    count = len(enough_poles(truncation, negligible))
    assert truncation ** -(4 * count + 1) <= negligible
    assert count == 1 or truncation ** -(4 * count - 3) > negligible
