"""The MDR transforms against closed forms, their inverses, and quadrature in 30 digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import Prepare
from mpmath import mp
from scipy.integrate import quad

from ringwear.mdr import direct
from ringwear.mdr.energy import compliance
from ringwear.mdr.transforms import (
    line_density,
    panel_quadrature,
    pressure_transform,
    profile_transform,
)
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import graded_breakpoints, layer_degrees, ring_areas
from ringwear.studies.wear.flat_contact import press_flat

EDGES = np.array([0.0, 0.3, 0.45, 0.9, 1.0])


def space(degree: int = 6, smallest: float = 1e-4) -> PressureSpace:
    radii = graded_breakpoints(EDGES, smallest, smallest, 0.2)
    return PressureSpace(radii, layer_degrees(radii, EDGES, degree, rise=1), EDGES)


@pytest.mark.parametrize("degree", [1, 4, 9])
def test_uniform_pressure(degree: int) -> None:
    """``p = 1`` on rings: differences of discs, whose line density is ``2 sqrt(c^2 - x^2)``."""
    positions = np.linspace(0.001, 0.999, 500)
    found = line_density(space(degree), positions) @ space(degree).ring_indicator()
    discs = 2 * np.sqrt(np.maximum(EDGES**2 - positions[:, None] ** 2, 0))
    np.testing.assert_allclose(found, np.diff(discs, axis=1), atol=1e-14)


def test_flat_punch(prepare: Prepare) -> None:
    """Eq. 10: the line density of a flat punch is constant, half of the force by length."""
    punch = prepare("flat_punch", "mdr", accuracy__rtol=1e-6)
    found = (
        line_density(punch.space, np.linspace(0.001, 0.99, 50))
        @ press_flat(punch.compliance).pressure
    )
    np.testing.assert_allclose(found, 0.5, rtol=1e-4)


def test_force_is_twice_the_integral() -> None:
    """Eq. 17's sum of springs: ``F = 2 int q dx``, for every function of the space."""
    positions, weights = panel_quadrature(space())
    np.testing.assert_allclose(
        2 * weights @ line_density(space(), positions), space().weights, rtol=1e-12, atol=1e-15
    )


@pytest.mark.parametrize("gap", [0.25, 2.0**-13, 2.0**-26])
@pytest.mark.parametrize("degree", [1, 7, 12, 16])
def test_line_density_of_every_shape(degree: int, gap: float) -> None:
    """Integrated Legendre polynomials on an element at the rim, seen from inside it, from its edge
    and from afar.
    """
    left = 1 - gap
    element = PressureSpace(np.array([0.0, left, 1.0]), np.array([1, degree]), np.array([0.0, 1.0]))
    # dyadic, so that positions are as far from the element's ends as they say
    positions = np.array(
        [left / 2, left - gap, left - gap / 8, left, left + gap / 64, left + gap / 2, 1 - gap / 8]
    )
    found = line_density(element, positions)[:, element.dofs[1, 1 : degree + 1]]
    node, weight = np.polynomial.legendre.leggauss(80)
    orders = np.arange(2, degree + 1)
    for row, position in zip(found, positions, strict=True):
        with mp.workdps(40):
            # u^2 = r^2 - x^2 leaves a smooth integrand
            x = mp.mpf(float(position))
            begin, end = mp.sqrt(max(left, x) ** 2 - x**2), mp.sqrt(1 - x**2)
            radii = [mp.sqrt((begin + (end - begin) * (1 + t) / 2) ** 2 + x**2) for t in node]
            local = np.array([float(1 - 2 * (1 - r) / gap) for r in radii])
        legendre = np.polynomial.legendre.legvander(local, degree)
        bubbles = (legendre[:, 2:] - legendre[:, :-2]) / np.sqrt(4 * orders - 2)
        shapes = np.column_stack([(1 + local) / 2, bubbles])
        expected = float(end - begin) * weight @ shapes
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-13 * float(end - begin))


def test_profile_transform_is_exact_for_cones_and_constants() -> None:
    radii = np.sort(np.append(np.random.default_rng(1).random(20), [0.0, 1.0]))
    positions = np.linspace(0.01, 1, 57)
    matrix = profile_transform(radii, positions)
    np.testing.assert_allclose(matrix @ np.ones(22), 1, rtol=1e-13)
    np.testing.assert_allclose(matrix @ radii, np.pi / 2 * positions, rtol=1e-13)


def test_profile_transform_of_a_paraboloid() -> None:
    """Eq.

    3 turns ``r^2`` into ``2 x^2``; a polygon's slope errs by ``h``, under a root singularity: order
    3/2.
    """
    errors = []
    for count in (20, 80):
        radii = np.linspace(0, 1, count + 1)
        errors.append(
            np.abs(profile_transform(radii, radii[1:]) @ radii**2 - 2 * radii[1:] ** 2).max()
        )
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(1.5, abs=0.1)
    assert errors[1] <= 1e-3


def test_profile_transform_round_trip() -> None:
    """``f(r) = (2/pi) int g / sqrt(r^2 - x^2) dx`` undoes Eq. 3."""
    radii = np.array([0.0, 0.1, 0.35, 0.6, 1.0])
    profile = np.array([0.2, 0.5, -0.3, 0.1, 0.7])

    def transformed(angle: float, radius: float) -> float:
        return float(
            profile_transform(radii, np.array([max(radius * np.sin(angle), 1e-12)]))[0] @ profile
        )

    for radius in (0.05, 0.2, 0.5, 0.99):
        kinks = np.arcsin(radii[(radii > 0) & (radii < radius)] / radius)
        back, _ = quad(
            transformed, 0, np.pi / 2, args=(radius,), points=kinks, epsabs=1e-11, limit=200
        )
        assert 2 / np.pi * back == pytest.approx(np.interp(radius, radii, profile), abs=1e-9)


def test_pressure_transform_is_exact_for_polygons() -> None:
    """Eq. 7: a constant gives the flat punch's pressure, ``1 - x`` gives ``arcosh(1/r) / pi``."""
    positions, radii = np.linspace(0, 1, 12), np.linspace(0.003, 0.997, 101)
    matrix = pressure_transform(positions, radii)
    np.testing.assert_allclose(
        matrix @ np.ones(12), 1 / (np.pi * np.sqrt(1 - radii**2)), rtol=1e-12
    )
    np.testing.assert_allclose(matrix @ (1 - positions), np.arccosh(1 / radii) / np.pi, rtol=1e-12)


def test_pressure_transform_undoes_the_line_density() -> None:
    """From a smooth pressure on the space to springs and back, on a grid that is fine at
    the rim.
    """
    whole = PressureSpace(np.linspace(0, 1, 6), np.full(5, 8), np.array([0.0, 1.0]))
    radii = np.linspace(0.05, 0.95, 19)
    fitted = np.linspace(0, 1, 200)
    pressure = np.linalg.lstsq(whole.matrix(fitted).toarray(), np.cos(2 * fitted), rcond=None)[0]
    errors = []
    for count in (100, 400):
        # q falls as a root at the rim
        positions = np.sin(np.linspace(0, np.pi / 2, count + 1))
        density = np.append(line_density(whole, np.maximum(positions[:-1], 1e-12)) @ pressure, 0.0)
        errors.append(
            np.abs(pressure_transform(positions, radii) @ density - np.cos(2 * radii)).max()
        )
    assert errors[1] <= errors[0] / 6
    assert errors[1] <= 1e-3


def test_energy_of_a_uniform_disc() -> None:
    """``int u dA = 16/3``.

    By the energy identity, and by the chords through each point of the disc.
    """
    one = compliance(space()).factor @ np.ones(len(EDGES) - 1).dot(space().ring_indicator().T)

    def chords(radius: Any) -> Any:
        return (
            4
            / mp.pi
            * mp.quad(lambda angle: mp.sqrt(1 - (radius * mp.sin(angle)) ** 2), [0, mp.pi / 2])
        )

    with mp.workdps(20):
        expected = mp.quad(lambda r: 2 * mp.pi * r * chords(r), [0, 1])
    assert float(expected) == pytest.approx(16 / 3, rel=1e-12)
    assert one @ one == pytest.approx(16 / 3, rel=1e-13)


def test_energies_of_rings() -> None:
    """The identity ``int u p dA = 2 int q^2 dx`` against the ring kernel, for every pair of
    rings.
    """
    rings = space().ring_indicator()
    found = rings.T @ compliance(space()).matrix @ rings
    node, weight = np.polynomial.legendre.leggauss(40)
    # displacements have r log r at ring edges: powers flatten it
    node, weight = (1 + node) / 2, weight / 2
    halves = np.sort(np.concatenate([EDGES, (EDGES[1:] + EDGES[:-1]) / 2]))
    for j in range(len(EDGES) - 1):
        edge, away = halves[[2 * j, 2 * j + 2]], np.diff(EDGES)[j] / 2
        radii = np.concatenate([edge[0] + away * node**4, edge[1] - away * node**4])
        weights = np.tile(away * 4 * node**3 * weight, 2) * 2 * np.pi * radii
        for i in range(len(EDGES) - 1):
            assert weights @ direct.displacement(EDGES, np.eye(4)[i], radii) == pytest.approx(
                found[i, j], rel=1e-11
            )


def test_mutual_energy_of_thin_rings() -> None:
    """Two thin rings far apart act on each other as Eq. 19 says."""
    edges = np.array([0.0, 0.3, 0.3001, 0.9, 0.9001, 1.0])
    radii = graded_breakpoints(edges, 1e-4, 1e-4, 0.2)
    rings = PressureSpace(radii, np.full(len(radii) - 1, 4), edges)
    energy = rings.ring_indicator().T @ compliance(rings).matrix @ rings.ring_indicator()
    areas = ring_areas(edges)
    kernel = direct.ring_kernel(np.array(0.30005), np.array(0.90005))
    assert energy[1, 3] / areas[1] / areas[3] == pytest.approx(float(kernel), rel=1e-8)


def test_compliance_is_definite_and_refines_itself() -> None:
    """A space within another gives the same energies.

    The coarser compliance is a block of the finer.
    """
    fine = compliance(space(6))
    coarse = fine.coarser()
    assert np.linalg.svd(fine.factor, compute_uv=False).min() > 0
    direct_one = compliance(coarse.space)
    np.testing.assert_allclose(coarse.matrix, direct_one.matrix, rtol=1e-10, atol=1e-15)
    assert press_flat(fine).indentation <= press_flat(coarse).indentation
