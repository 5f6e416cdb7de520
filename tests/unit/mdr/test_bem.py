"""The compliance by boundary elements equals that of the MDR, as an operator."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from ringwear import PressureSpace, alternating_edges, energy, ring_kernel
from ringwear.mdr.transforms import line_density, panel_quadrature
from ringwear.meshes.radial import graded_breakpoints, layer_degrees


def graded(edges):
    sizes = np.append(np.full(len(edges) - 2, 1e-4), 1e-7)
    breakpoints, _ = graded_breakpoints(edges, sizes, 0.2)
    return PressureSpace(breakpoints, layer_degrees(breakpoints, edges, 8, 1, 2), edges)


def uniform(elements, rings, degree):
    return PressureSpace(
        np.linspace(0, 1, elements + 1), np.full(elements, degree), alternating_edges(rings)
    )


def deviation(first, second):
    """Return the largest |lambda - 1| of generalised eigenvalues of two matrices ``F^T F``."""
    triangle = np.linalg.qr(second, mode="r")
    ratio = scipy.linalg.solve_triangular(triangle.T, first.T, lower=True)
    return float(np.abs(np.linalg.svd(ratio, compute_uv=False) ** 2 - 1).max())


@pytest.mark.parametrize(
    "space",
    [
        *(graded(alternating_edges(count)) for count in (1, 2, 5)),
        uniform(60, 5, 3),
        uniform(1, 1, 1),
    ],
    ids=lambda space: f"{space.size} pressures",
)
def test_equals_mdr_as_an_operator(space):
    factor, rings = ring_kernel.compliance(space).factor, space.ring_indicator()
    # with more quadrature points than the MDR uses, so that all bubbles are exact, too
    positions, weights, _ = panel_quadrature(replace(space, degrees=space.degrees + 10))
    reference = np.sqrt(2 * weights)[:, None] * line_density(space, positions)
    assert deviation(factor @ rings, reference @ rings) < 1e-12
    assert deviation(factor, reference) < 1e-6


def test_restricted_to_a_coarser_space():
    """The restriction of a compliance to a coarser space equals the one computed there."""
    space = graded(alternating_edges(5))
    coarse = space.coarser()
    for compliance in (ring_kernel.compliance, energy.compliance):
        within = compliance(space).restricted(coarse)
        assert deviation(within.factor, compliance(coarse).factor) < 1e-6


@pytest.mark.parametrize("widths", [[0.5, 1e-4, 0.4999], [1e-4, 0.9999], [0.9999, 1e-4]])
def test_neighbours_may_differ_ten_thousandfold(widths):
    """Constants on elements of very different widths agree with those on a graded mesh."""
    edges = np.append(0.0, np.cumsum(widths) / sum(widths))
    spaces = PressureSpace(edges, np.full(len(widths), 8), edges), graded(edges)
    sums = [ring_kernel.compliance(space).factor @ space.ring_indicator() for space in spaces]
    assert deviation(*sums) < 1e-12
