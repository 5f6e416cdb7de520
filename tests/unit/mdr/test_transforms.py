"""The MDR transforms against closed forms and quadrature in 40 digits."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp

from ringwear import PressureSpace, energy, press_flat
from ringwear.mdr.transforms import (
    line_density,
    panel_quadrature,
    pressure_transform,
    profile_transform,
)
from ringwear.meshes.pressure_space import shapes
from ringwear.meshes.radial import graded_breakpoints, layer_degrees

EDGES = np.array([0.0, 0.3, 0.45, 0.9, 1.0])


@pytest.fixture(params=[(6, EDGES), (9, EDGES), (6, EDGES[1:])], ids=["6", "9", "6, hollow"])
def space(request):
    degree, edges = request.param
    radii, _ = graded_breakpoints(edges, 1e-4, 0.2)
    return PressureSpace(radii, layer_degrees(radii, edges, degree, rise=1), edges)


def test_line_density_of_rings(space):
    """Rings are differences of discs, whose line density is ``2 sqrt(c^2 - x^2)``."""
    x = np.linspace(0.001, 0.999, 500)
    discs = 2 * np.sqrt(np.maximum(space.ring_edges**2 - x[:, None] ** 2, 0))
    densities = line_density(space, x) @ space.ring_indicator()
    np.testing.assert_allclose(densities, np.diff(discs, axis=1), rtol=0, atol=1e-14)


def test_force_is_twice_the_integral(space):
    """Eq. 17's sum of springs, ``F = 2 int q dx``, for every function of the space."""
    positions, weights, _ = panel_quadrature(space)
    forces = 2 * weights @ line_density(space, positions)
    np.testing.assert_allclose(forces, space.weights, rtol=1e-12, atol=1e-15)


def test_compliance_is_definite_and_indentations_fall_with_refinement(space):
    """A space that contains another has a smaller indentation, or the same."""
    fewer = replace(space, degrees=np.maximum(space.degrees - 1, 1))
    fine, coarse = energy.compliance(space), energy.compliance(fewer)
    assert np.linalg.svd(fine.factor, compute_uv=False).min() > 0
    assert press_flat(fine).indentation <= press_flat(coarse).indentation


@pytest.mark.parametrize("gap", [0.25, 2.0**-13, 2.0**-26])
@pytest.mark.parametrize("degree", [1, 7, 12, 16])
def test_line_density_of_every_shape(degree, gap):
    """The element is at the rim; positions are inside it, at its edge and far away."""
    left = 1 - gap
    element = PressureSpace(np.array([0.0, left, 1.0]), np.array([1, degree]), np.array([0.0, 1.0]))
    # dyadic numbers, so that distances from the ends of the element have no roundoff
    positions = np.array(
        [left / 2, left - gap, left - gap / 8, left, left + gap / 64, left + gap / 2, 1 - gap / 8]
    )
    densities = line_density(element, positions)[:, element.dofs[1, 1 : degree + 1]]
    node, weight = np.polynomial.legendre.leggauss(80)
    for row, position in zip(densities, positions, strict=True):
        with mp.workdps(40):
            # u^2 = r^2 - x^2 leaves a smooth integrand
            x = mp.mpf(float(position))
            begin, end = mp.sqrt(max(left, x) ** 2 - x**2), mp.sqrt(1 - x**2)
            radii = [mp.sqrt((begin + (end - begin) * (1 + t) / 2) ** 2 + x**2) for t in node]
            local = np.array([float(1 - 2 * (1 - r) / gap) for r in radii])
        length = float(end - begin)
        expected = length * weight @ shapes(local, degree)[:, 1:]
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-13 * length)


def test_profile_transform():
    """Eq. 3 is exact for constants and cones; ``r^2`` becomes ``2 x^2`` with the order 3/2."""
    radii = np.sort(np.append(np.random.default_rng(1).random(20), [0.0, 1.0]))
    positions = np.linspace(0.01, 1, 57)
    matrix = profile_transform(radii, positions)
    np.testing.assert_allclose(matrix @ np.ones(22), 1, rtol=1e-13)
    np.testing.assert_allclose(matrix @ radii, np.pi / 2 * positions, rtol=1e-13)
    grids = [np.linspace(0, 1, count + 1) for count in (20, 80)]
    errors = [
        np.abs(profile_transform(grid, grid[1:]) @ grid**2 - 2 * grid[1:] ** 2).max()
        for grid in grids
    ]
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(1.5, abs=0.1)
    assert errors[1] <= 1e-3


def test_pressure_transform():
    """Eq. 7 is exact for functions that are linear between positions.

    A constant gives the flat punch, and ``c - x`` on ``x < c`` gives ``arcosh(c/r) / pi``.
    """
    positions, radii = np.linspace(0, 1, 12), np.linspace(0.003, 0.997, 101)[:, None]
    matrix = pressure_transform(positions, radii.ravel())
    flat = matrix @ np.ones((12, 1))
    np.testing.assert_allclose(flat, 1 / (np.pi * np.sqrt(1 - radii**2)), rtol=1e-12)
    cones = matrix @ np.maximum(positions[1:] - positions[:, None], 0)
    expected = np.arccosh(np.maximum(positions[1:] / radii, 1)) / np.pi
    np.testing.assert_allclose(cones, expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(("extra_points", "accuracy"), [(4, 1e-7), (8, 1e-10)])
def test_energies_by_few_and_by_many_points(extra_points, accuracy):
    """The search for the first contact uses few points, and all else uses many.

    A linear pressure on cells is a sum of cones ``c (b - r)``, each for r < b, with the line
    densities ``c (b sqrt(b^2 - x^2) - x^2 arcosh(b / x))``.
    """
    breakpoints = np.array([0.0, 0.05, 0.2, 0.3, 0.31, 0.6, 0.65, 1.0])
    factors = np.array([0.3, 2.0, -1.0, 3.0, 0.2, -0.7, 1.0])

    def density(x):
        cones = zip(breakpoints[1:].tolist(), factors.tolist(), strict=True)
        return mp.fsum(
            c * (b * mp.sqrt(mp.mpf(b) ** 2 - x**2) - x**2 * mp.acosh(b / x))
            for b, c in cones
            if b > x
        )

    with mp.workdps(30):
        exact = float(mp.quad(lambda x: 2 * density(x) ** 2, breakpoints.tolist()))
    space = PressureSpace(breakpoints, np.ones(7, dtype=int), np.array([0.0, 1.0]))
    pressure = np.maximum(breakpoints[1:] - breakpoints[:, None], 0) @ factors
    matrix = energy.compliance(space, extra_points=extra_points).matrix
    assert abs(pressure @ matrix @ pressure / exact - 1) <= accuracy
