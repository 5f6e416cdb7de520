"""The compliance by boundary elements: that of the MDR as an operator, and closed forms."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import scipy.linalg

from ringwear.mdr import energy, line_density, ring_kernel
from ringwear.meshes import (
    Array,
    PressureSpace,
    alternating_edges,
    graded_breakpoints,
    layer_degrees,
)


def graded(edges: Array) -> PressureSpace:
    breakpoints = graded_breakpoints(edges, 1e-4, 1e-7, 0.2)
    return PressureSpace(breakpoints, layer_degrees(breakpoints, edges, 8, 1, 2), edges)


def uniform(elements: int, rings: int, degree: int) -> PressureSpace:
    return PressureSpace(
        np.linspace(0, 1, elements + 1), np.full(elements, degree), alternating_edges(rings)
    )


def mdr_factor(space: PressureSpace) -> Array:
    """MDR's weighted line density by more points than its own rule, exact for all bubbles too."""
    node, weight = np.polynomial.legendre.leggauss(2 * space.top + 20)
    node, weight = (1 + node) / 2, weight / 2
    # squares at the outer end of every panel, and at both ends of the one at the axis
    folded = node * (2 - node)
    outer = np.tile(node**2, (len(space.degrees), 1))
    slopes = np.tile(2 * node, (len(space.degrees), 1))
    outer[0], slopes[0] = folded**2, 4 * folded * (1 - node)
    width = np.diff(space.breakpoints)[:, None]
    positions, weights = space.breakpoints[1:, None] - width * outer, width * slopes * weight
    return np.sqrt(2 * weights.ravel())[:, None] * line_density(space, positions.ravel())


def deviation(first: Array, second: Array) -> float:
    """Largest |lambda - 1| of the generalised eigenvalues of two matrices ``F^T F``, by factors."""
    triangle = np.linalg.qr(second, mode="r")
    ratio = scipy.linalg.solve_triangular(triangle.T, first.T, lower=True)
    return float(np.abs(np.linalg.svd(ratio, compute_uv=False) ** 2 - 1).max())


def slow_modes(space: PressureSpace, factor: Array, count: int) -> Array:
    """The slowest pressures without force where every second ring wears ten times as fast."""
    wear = np.where(np.arange(len(space.ring_edges) - 1) % 2 == 0, 1.0, 10.0)
    basis = space.joined(wear)
    basis = basis @ scipy.linalg.null_space((basis.T @ space.weights)[None, :])
    energies = (factor @ basis).T @ (factor @ basis)
    return basis @ scipy.linalg.eigh(energies, basis.T @ space.mass(wear) @ basis)[1][:, -count:]


SPACES = [graded(alternating_edges(count)) for count in (1, 2, 5)] + [uniform(60, 5, 3)]


@pytest.mark.parametrize("space", SPACES, ids=lambda space: f"{space.size} pressures")
def test_equals_mdr_as_an_operator(space: PressureSpace) -> None:
    compliance, reference = ring_kernel.compliance(space), mdr_factor(space)
    constants, slow = space.ring_indicator(), slow_modes(space, reference, 20)
    for span, tolerance in ((constants, 1e-12), (slow, 1e-9), (np.eye(space.size), 1e-6)):
        assert deviation(compliance.factor @ span, reference @ span) < tolerance
    by_energy = energy.compliance(space).factor
    assert deviation(compliance.factor @ constants, by_energy @ constants) < 1e-9
    # uniform pressure on the disc: int (4/pi) E(r) dA
    everywhere = constants.sum(axis=1)
    assert everywhere @ compliance.matrix @ everywhere == pytest.approx(16 / 3, rel=1e-13)
    # the coarser space is a restriction
    coarser = compliance.coarser()
    assert deviation(ring_kernel.compliance(coarser.space).factor, coarser.factor) < 1e-9


@pytest.mark.parametrize("widths", [[0.5, 1e-4, 0.4999], [1e-4, 0.9999], [0.9999, 1e-4]])
def test_neighbours_may_differ_ten_thousandfold(widths: list[float]) -> None:
    """Constants on coarse elements against the same on a graded mesh of like neighbours."""
    edges = np.append(0.0, np.cumsum(widths) / sum(widths))
    spaces = PressureSpace(edges, np.full(len(widths), 8), edges), graded(edges)
    sums = [ring_kernel.compliance(space).factor @ space.ring_indicator() for space in spaces]
    assert deviation(*sums) < 1e-12


def test_one_element_has_the_energies_of_the_closed_line_densities() -> None:
    """``int u p dA = 2 int q^2 dx`` of the pressures 1 and r."""
    densities = (
        lambda x: 2 * mpmath.sqrt(1 - x**2),
        lambda x: mpmath.sqrt(1 - x**2) + x**2 * mpmath.acosh(1 / x),
    )
    expected = [
        [float(2 * mpmath.quad(lambda x: q(x) * s(x), [0, 0.1, 1])) for q in densities]  # noqa: B023
        for s in densities
    ]
    powers = np.array([[1.0, 0.0], [1.0, 1.0]])  # hats of the pressures 1 and r
    found = powers.T @ ring_kernel.compliance(uniform(1, 1, 1)).matrix @ powers
    np.testing.assert_allclose(found, expected, rtol=1e-13)
