"""Boussinesq's poles.

Exact solutions of elasticity with a free surface, and the boundary that they are tied to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.sparse.linalg import splu

from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import enough_poles, exterior_stiffness, poles
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.fem.stresses import displacements
from ringwear.fem.weak_form import moduli
from ringwear.meshes.bisection import mesh as bisection
from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import SizeField
from ringwear.studies.wear.flat_contact import press_flat

ORDERS = [0, 2, 4, 6]
RATIOS = [-0.3, 0.0, 0.3, 0.5]
SHEAR = 0.7
PLACES = np.array([[0.4, 1.1], [1.2, 0.9], [1.7, 0.2]])
EDGES = np.array([0.0, 1.0])


def pole(points: Array, order: int, ratio: float, shear: float) -> tuple[Array, Array]:
    (displacement,), (stress,) = poles(points, (order,), ratio, shear)
    return displacement, stress


def displacement(points: Array, order: int, ratio: float) -> Array:
    return pole(points, order, ratio, SHEAR)[0]


def slopes(function: Any, points: Array, step: float = 1e-3) -> tuple[Array, Array]:
    """Derivatives by radius and depth: central differences of sixth order."""
    weights = {1: 45, -1: -45, 2: -9, -2: 9, 3: 1, -3: -1}
    return tuple(
        sum(w * function(points + n * step * axis) for n, w in weights.items()) / (60 * step)
        for axis in np.eye(2)
    )  # type: ignore[return-value]


@pytest.mark.parametrize("ratio", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("order", ORDERS)
def test_hooke(order: int, ratio: float) -> None:
    points = PLACES
    by_r, by_z = slopes(lambda at: displacement(at, order, ratio), points)
    hoop = displacement(points, order, ratio)[:, 0] / points[:, 0]
    volume = 2 * SHEAR * ratio / (1 - 2 * ratio) * (by_r[:, 0] + by_z[:, 1] + hoop)
    direct = [volume + 2 * SHEAR * strain for strain in (by_r[:, 0], by_z[:, 1], hoop)]
    expected = np.stack(
        [direct[0], direct[1], SHEAR * (by_z[:, 0] + by_r[:, 1]), direct[2]], axis=1
    )
    found = pole(points, order, ratio, SHEAR)[1]
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("order", ORDERS)
def test_equilibrium(order: int, ratio: float) -> None:
    points = PLACES
    by_r, by_z = slopes(lambda at: pole(at, order, ratio, SHEAR)[1], points)
    rr, _, rz, hoop = pole(points, order, ratio, SHEAR)[1].T
    radius = points[:, 0]
    radial = by_r[:, 0] + by_z[:, 2] + (rr - hoop) / radius
    axial = by_r[:, 2] + by_z[:, 1] + rz / radius
    scale = np.abs(by_r).max()
    assert max(np.abs(radial).max(), np.abs(axial).max()) <= 1e-10 * scale


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("order", ORDERS)
def test_surface_is_free(order: int, ratio: float) -> None:
    surface = np.stack([np.linspace(0.3, 5, 20), np.zeros(20)], axis=1)
    _, zz, rz, _ = pole(surface, order, ratio, SHEAR)[1].T
    assert max(np.abs(zz).max(), np.abs(rz).max()) == 0


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("order", ORDERS[:3])
def test_poles_are_laplacians_of_boussinesq(order: int, ratio: float) -> None:
    """Order 0 is Boussinesq's point force 2 pi.

    Two orders more is its horizontal Laplacian, with the sign turned.
    """

    def axial(r: Any, z: Any) -> Any:
        rho = mp.hypot(r, z)
        return (z**2 / rho**3 + 2 * (1 - ratio) / rho) / (2 * SHEAR)

    def laplacian(times: int, r: Any, z: Any) -> Any:
        if times == 0:
            return axial(r, z)

        def before(x: Any) -> Any:
            return laplacian(times - 1, x, z)

        return -(mp.diff(before, r, 2) + mp.diff(before, r) / r)

    with mp.workdps(60):
        expected = [
            laplacian(order // 2, mp.mpf(r), mp.mpf(z)) / mp.factorial(order) for r, z in PLACES
        ]
    found = displacement(PLACES, order, ratio)[:, 1]
    np.testing.assert_allclose(found, np.array(expected, dtype=float), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("ratio", RATIOS)
def test_surface_of_a_point_force(ratio: float) -> None:
    """``u_z = (1 - nu) F / (2 pi G r)`` and ``u_r = -(1 - 2 nu) F / (4 pi G r)``, towards the
    force.
    """
    radii = np.geomspace(0.1, 100, 7)
    found = displacement(np.stack([radii, np.zeros(7)], axis=1), 0, ratio)
    np.testing.assert_allclose(found[:, 1], (1 - ratio) / SHEAR / radii, rtol=1e-14)
    np.testing.assert_allclose(
        found[:, 0], -(1 - 2 * ratio) / (2 * SHEAR) / radii, rtol=1e-14, atol=1e-16
    )


def polygon(sides: int, radius: float = 3.0) -> Array:
    angles = np.linspace(0, np.pi / 2, sides + 1)
    corners = radius * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    return np.stack([corners[:-1], corners[1:]], axis=1)


@pytest.mark.parametrize("sides", [3, 7])
@pytest.mark.parametrize("order", ORDERS)
def test_resultant(order: int, sides: int) -> None:
    """The monopole carries 2 pi through any surface around it, the other poles nothing."""
    node, weight = np.polynomial.legendre.leggauss(40)
    force = 0.0
    for start, end in polygon(sides):
        points = start + (1 + node[:, None]) / 2 * (end - start)
        normal = np.array([end[1] - start[1], start[0] - end[0]])
        normal *= np.sign(normal @ start)
        _, zz, rz, _ = pole(points, order, 0.3, SHEAR)[1].T
        force -= np.sum(weight / 2 * 2 * np.pi * points[:, 0] * (rz * normal[0] + zz * normal[1]))
    assert force == pytest.approx(2 * np.pi if order == 0 else 0.0, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("ratio", RATIOS)
def test_exterior_energy_is_that_of_the_exterior(ratio: float) -> None:
    """By the work on its boundary, whose difference between two boundaries is the energy between
    them.
    """
    orders = (0, 2, 4)
    matrix = exterior_stiffness(polygon(4), orders, ratio, SHEAR)
    np.testing.assert_allclose(matrix, matrix.T)
    assert np.linalg.eigvalsh(matrix).min() > 0
    # similar boundaries: energies of two poles scale as 1/rho^(n + m + 1)
    powers = np.add.outer(orders, orders) + 1.0
    np.testing.assert_allclose(
        exterior_stiffness(polygon(4, 6.0), orders, ratio, SHEAR) * 2**powers, matrix, rtol=1e-12
    )


def half_space(truncation: float, orders: tuple[int, ...], growth: float = 0.35) -> HalfSpace:
    solid = AxisymmetricElasticity(
        bisection(SizeField((0.0, 1.0), 1e-6, 1e-6, growth, truncation)), 4, 0.3
    )
    return HalfSpace(solid, pressure_space(solid, EDGES), orders)


@pytest.mark.parametrize("orders", [(), (0,), (0, 2, 4)], ids=str)
def test_reactions_balance_the_force(orders: tuple[int, ...]) -> None:
    """Nodal forces of the deformed solid.

    The load on the contact, its opposite on the outer boundary, nothing else.
    """
    solid_and_all = half_space(5.0, orders)
    solid = solid_and_all.solid
    pressure = press_flat(solid_and_all.compliance()).pressure
    moved = displacements(solid_and_all, pressure[None])[0]
    forces = (solid.stiffness @ moved[: solid.nodes].T.ravel())[solid.nodes :]
    far, contact = solid.boundary("far"), solid.boundary("contact")
    assert forces[contact].sum() == pytest.approx(1, rel=1e-10)
    assert forces[far].sum() == pytest.approx(-1, rel=1e-10)
    inside = np.setdiff1d(np.arange(solid.nodes), np.concatenate([far, contact]))
    assert np.abs(forces[inside]).max() <= 1e-11


@pytest.mark.parametrize(("truncation", "tolerance"), [(4.0, 1e-4), (8.0, 1e-5)])
def test_amplitude_of_the_monopole(truncation: float, tolerance: float) -> None:
    """Far from the contact the solid feels a point force of the same size."""
    whole = half_space(truncation, (0, 2, 4))
    right = np.zeros(whole.system.shape[0])
    right[-len(whole.coupling) :] = whole.coupling @ press_flat(whole.compliance()).pressure
    amplitude = splu(whole.system).solve(right)[-3]
    assert amplitude == pytest.approx(1 / (2 * np.pi), rel=tolerance)


def test_a_clamped_boundary_errs_by_one_over_its_radius() -> None:
    errors = [
        0.5 - press_flat(half_space(radius, (), 0.5).compliance()).indentation
        for radius in (20.0, 40.0, 80.0)
    ]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.01)


def test_poles_are_enough() -> None:
    """The first one neglected, of order 4n + 1 in a/R, is below what may be neglected.

    One pole less would not do.
    """
    for truncation, negligible in ((2.5, 1e-9), (5.0, 1e-9), (2.5, 1e-10), (1e3, 1e-9)):
        count = len(enough_poles(truncation, negligible))
        assert truncation ** -(4 * count + 1) <= negligible
        assert count == 1 or truncation ** -(4 * count - 3) > negligible


@pytest.mark.parametrize(("orders", "order"), [((0,), 5), ((0, 2), 9)], ids=str)
def test_order_of_the_tied_boundary(orders: tuple[int, ...], order: int) -> None:
    """Each pole that is tied cancels four powers of the truncation radius."""
    errors = [
        abs(press_flat(half_space(radius, orders, 0.2).compliance()).indentation / 0.5 - 1)
        for radius in (2.0, 3.0)
    ]
    assert np.log(errors[0] / errors[1]) / np.log(3 / 2) >= order - 1


def test_shear_modulus_of_the_solid() -> None:
    """Plane strain modulus 1.

    ``2 G / (1 - nu) = 1``, and the point force sinks the surface by ``1/(pi r)``.
    """
    for ratio in RATIOS:
        shear = (1 - ratio) / 2
        at_one = pole(np.array([[1.0, 0.0]]), 0, ratio, shear)[0][0, 1] / (2 * np.pi)
        assert at_one == pytest.approx(1 / np.pi, rel=1e-14)
        if ratio < 0.5:
            assert moduli(ratio)[1] == shear
