"""The boundary-element compliance against closed forms, against MDR as an operator, and against
injected faults.
"""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import scipy.interpolate
import scipy.linalg

from ringwear.mdr import direct
from ringwear.mdr import energy as compliance
from ringwear.mdr import ring_kernel as bem
from ringwear.mdr.transforms import line_density
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array, alternating_edges, graded_breakpoints, layer_degrees


def graded(rings: int) -> PressureSpace:
    edges = alternating_edges(rings)
    breakpoints = graded_breakpoints(edges, 1e-4, 1e-7, 0.2)
    return PressureSpace(breakpoints, layer_degrees(breakpoints, edges, 8, 1, 2), edges)


def uniform(elements: int, rings: int, degree: int) -> PressureSpace:
    return PressureSpace(
        np.linspace(0, 1, elements + 1), np.full(elements, degree), alternating_edges(rings)
    )


def stretched(smallest: float, growth: float, rings: int, degree: int) -> PressureSpace:
    """Facets that grow by a constant ratio from both edges of every ring, as those of a
    finite-element mesh.
    """
    count = int(np.ceil(np.log1p((growth - 1) / (2 * rings * smallest)) / np.log(growth)))
    part = np.cumsum(growth ** np.arange(count))
    part = np.concatenate([[0.0], part / part[-1]]) / 2
    ring = np.concatenate([part, 1 - part[-2::-1]])[:-1]
    breakpoints = np.append((np.arange(rings)[:, None] + ring).ravel(), rings) / rings
    return PressureSpace(
        breakpoints, np.full(len(breakpoints) - 1, degree), breakpoints[:: 2 * count]
    )


def mdr_factor(space: PressureSpace) -> Array:
    """MDR's weighted line density, by more points than its own panel rule has.

    Exact for the highest bubbles too.
    """
    node, weight = np.polynomial.legendre.leggauss(2 * space.top + 20)
    node, weight = (1 + node) / 2, weight / 2
    # squares at the outer end of every panel, and at both ends of the one at the axis
    folded, slope = node * (2 - node), 2 * (1 - node)
    outer = np.tile(node**2, (len(space.degrees), 1))
    slopes = np.tile(2 * node, (len(space.degrees), 1))
    outer[0], slopes[0] = folded**2, 2 * folded * slope
    width = np.diff(space.breakpoints)[:, None]
    positions, weights = space.breakpoints[1:, None] - width * outer, width * slopes * weight
    return np.sqrt(2 * weights.ravel())[:, None] * line_density(space, positions.ravel())


def deviation(one: Array, other: Array) -> float:
    """Largest |lambda - 1| of the generalised eigenvalues of (A, B), both given by factors ``A =
    one.T @ one``.
    """
    triangle = np.linalg.qr(other, mode="r")
    ratio = scipy.linalg.solve_triangular(triangle.T, one.T, lower=True)
    return float(np.abs(np.linalg.svd(ratio, compute_uv=False) ** 2 - 1).max())


def slow_modes(space: PressureSpace, factor: Array, count: int) -> Array:
    """The pressures, free of force, that relax the slowest when every second ring wears ten times
    as fast.
    """
    wear = np.where(np.arange(len(space.ring_edges) - 1) % 2 == 0, 1.0, 10.0)
    basis = space.joined(wear)
    basis = basis @ scipy.linalg.null_space((basis.T @ space.weights)[None, :])
    root = np.linalg.cholesky(basis.T @ space.mass(wear) @ basis)
    left, _, _ = np.linalg.svd(
        scipy.linalg.solve_triangular(root, (factor @ basis).T, lower=True), full_matrices=False
    )
    return basis @ scipy.linalg.solve_triangular(root.T, left[:, :count])


def indentation(factor: Array, space: PressureSpace) -> float:
    """Indentation of a flat punch by a unit force."""
    return 1 / float(np.sum(np.linalg.solve(factor.T, space.weights) ** 2))


SPACES = {
    "one ring": lambda: graded(1),
    "two rings": lambda: graded(2),
    "five rings": lambda: graded(5),
    "uniform": lambda: uniform(60, 5, 3),
    "facets": lambda: stretched(1e-3, 1.5, 5, 3),
}


@pytest.mark.parametrize("name", SPACES)
def test_equals_mdr_as_an_operator(name: str) -> None:
    space = SPACES[name]()
    factor, reference = bem.compliance(space).factor, mdr_factor(space)
    constants, slow = space.ring_indicator(), slow_modes(space, reference, 20)
    assert deviation(factor @ constants, reference @ constants) < 1e-12
    assert deviation(factor @ slow, reference @ slow) < 1e-9
    assert deviation(factor, reference) < 1e-6


@pytest.mark.parametrize("name", SPACES)
def test_equals_the_compliance_of_mdr_on_constant_rings(name: str) -> None:
    space = SPACES[name]()
    constants = space.ring_indicator()
    assert (
        deviation(
            bem.compliance(space).factor @ constants,
            compliance.compliance(space).factor @ constants,
        )
        < 1e-9
    )


@pytest.mark.parametrize("widths", [[0.5, 1e-4, 0.4999], [1e-4, 0.9999], [0.9999, 1e-4]])
def test_neighbours_may_differ_ten_thousandfold(widths: list[float]) -> None:
    # constants on three coarse elements against the same on the graded mesh, whose neighbours
    # differ by 5 at most
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    edges /= edges[-1]
    breakpoints = graded_breakpoints(edges, 1e-6, 1e-6, 0.2)
    fine = PressureSpace(breakpoints, np.ones(len(breakpoints) - 1, dtype=np.int64), edges)
    coarse = PressureSpace(edges, np.full(len(widths), 8), edges)
    sums = [bem.compliance(space).factor @ space.ring_indicator() for space in (coarse, fine)]
    assert deviation(*sums) < 1e-12


def test_one_element_has_the_energies_of_the_closed_line_densities() -> None:
    space = uniform(1, 1, 1)
    # q of the pressures 1 and r; the energy of two pressures is twice the integral of the product
    # of their q
    densities = (
        lambda x: 2 * mpmath.sqrt(1 - x**2),
        lambda x: mpmath.sqrt(1 - x**2) + x**2 * mpmath.acosh(1 / x),
    )

    def energy(i: int, j: int) -> float:
        return float(2 * mpmath.quad(lambda x: densities[i](x) * densities[j](x), [0, 0.1, 1]))

    expected = [[energy(0, 0), energy(0, 1)], [energy(1, 0), energy(1, 1)]]
    powers = np.array([[1.0, 0.0], [1.0, 1.0]])  # hats of the pressures 1 and r
    np.testing.assert_allclose(
        powers.T @ bem.compliance(space).matrix @ powers, expected, rtol=1e-13
    )


@pytest.mark.parametrize("name", SPACES)
def test_uniform_pressure_on_the_disc(name: str) -> None:
    space = SPACES[name]()
    one = space.ring_indicator().sum(axis=1)
    # the displacement inside the disc is (4 / pi) E(r)
    total = float(mpmath.quad(lambda r: 8 * r * mpmath.ellipe(r**2), [0, 1]))
    assert total == pytest.approx(16 / 3, rel=1e-14)
    assert one @ bem.compliance(space).matrix @ one == pytest.approx(total, rel=1e-13)


def test_rings_are_differences_of_discs() -> None:
    space = graded(5)
    pressures = np.array([1.0, -2.0, 0.5, 3.0, -1.0])
    # the displacement has x log x at ring edges: fifth powers at both ends of every element
    node, weight = np.polynomial.legendre.leggauss(24)
    step = scipy.interpolate.BPoly.from_derivatives([-1, 1], [[-1, 0, 0, 0, 0], [1, 0, 0, 0, 0]])
    local, weight = step(node), step.derivative()(node) * weight
    half = np.diff(space.breakpoints)[:, None] / 2
    radii = (space.breakpoints[:-1, None] + half * (1 + local)).ravel()
    areas = 2 * np.pi * radii * (half * weight).ravel()
    expected = space.matrix(radii).T @ (
        areas * direct.displacement(space.ring_edges, pressures, radii)
    )
    found = bem.compliance(space).matrix @ (space.ring_indicator() @ pressures)
    hats = space.order == 1
    np.testing.assert_allclose(found[hats], expected[hats], rtol=1e-8)


def test_matrix_is_symmetric_and_definite() -> None:
    found = bem.compliance(graded(5))
    assert found.factor.shape == (found.space.size,) * 2
    np.testing.assert_array_equal(found.factor, np.triu(found.factor))
    np.testing.assert_array_equal(found.matrix, found.matrix.T)
    scale = 1 / np.sqrt(np.diag(found.matrix))
    assert np.linalg.eigvalsh(scale[:, None] * found.matrix * scale).min() > 1e-8


def test_coarser_space_is_a_restriction() -> None:
    found = bem.compliance(graded(2)).coarser()
    assert deviation(bem.compliance(found.space).factor, found.factor) < 1e-9


def test_kernel_is_the_ring_kernel() -> None:
    radius, ring = np.random.default_rng(3).uniform(0.1, 1, (2, 40))
    expected = 4 * np.pi**2 * radius * ring * direct.ring_kernel(radius, ring)
    np.testing.assert_allclose(
        bem._weighted_kernel(radius, ring, np.abs(radius - ring)), expected, rtol=1e-12
    )


def test_a_wrong_modulus_shows() -> None:
    space = graded(2)
    factor = bem.compliance(space).factor / np.sqrt(1.01)
    constants = space.ring_indicator()
    assert deviation(factor @ constants, mdr_factor(space) @ constants) == pytest.approx(
        1 - 1 / 1.01, rel=1e-6
    )


def test_a_ring_edge_out_of_place_shows() -> None:
    space = uniform(60, 5, 3)
    moved = replace(
        space, breakpoints=np.where(np.isclose(space.breakpoints, 0.4), 0.401, space.breakpoints)
    )
    constants = space.ring_indicator()
    assert deviation(bem.compliance(moved).factor @ constants, mdr_factor(space) @ constants) > 1e-3
