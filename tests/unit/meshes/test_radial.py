"""Ring edges, graded radii, and the pressure space.

Partitions of unity, forces, slopes, and joined bases.
"""

from __future__ import annotations

import numpy as np
import pytest

from ringwear.meshes.pressure_space import PressureSpace, shape_slopes, shapes
from ringwear.meshes.radial import alternating_edges, graded_breakpoints, layer_degrees, ring_areas

EDGES = np.array([0.0, 0.25, 0.3, 0.8, 1.0])
WEAR = np.array([0.2, 1.0, 0.05, 0.6])


@pytest.fixture(params=[1, 2, 5, 9])
def space(request: pytest.FixtureRequest) -> PressureSpace:
    radii = graded_breakpoints(EDGES, 1e-3, 1e-5, 0.3)
    return PressureSpace(radii, layer_degrees(radii, EDGES, request.param, rise=1), EDGES)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 7.0])
@pytest.mark.parametrize("count", [1, 2, 5, 16])
def test_alternating_edges(count: int, ratio: float) -> None:
    edges = alternating_edges(count, ratio)
    widths = np.diff(edges)
    assert (edges[0], edges[-1], len(edges)) == (0.0, 1.0, count + 1)
    np.testing.assert_allclose(widths[::2], widths[0], rtol=1e-12)
    np.testing.assert_allclose(widths[1::2], ratio * widths[0], rtol=1e-12)


def test_ring_areas() -> None:
    np.testing.assert_allclose(ring_areas(EDGES), np.pi * np.diff(EDGES**2), rtol=1e-14)
    # of a narrow ring, to roundoff: 2 pi r w
    assert ring_areas([1 - 2.0**-40, 1.0])[0] == pytest.approx(
        2 * np.pi * 2.0**-40 * (1 - 2.0**-41), rel=1e-15
    )


@pytest.mark.parametrize("factor", [0.15, 0.5])
@pytest.mark.parametrize(("edge_size", "rim_size"), [(1e-2, 1e-2), (1e-3, 1e-8), (0.5, 0.5)])
@pytest.mark.parametrize(
    "edges", [[0.0, 1.0], EDGES, [0.0, 0.5, 0.5001, 1.0], [0.0, 1e-4, 0.9999, 1.0]], ids=str
)
def test_graded_breakpoints(
    edges: list[float], edge_size: float, rim_size: float, factor: float
) -> None:
    radii = graded_breakpoints(edges, edge_size, rim_size, factor)
    assert (radii[0], radii[-1]) == (0.0, 1.0)
    assert (np.diff(radii) > 0).all()
    assert np.isin(edges, radii).all()
    # the wanted sizes within the step of the grading, or the ring itself where it is narrower
    widths = np.diff(radii)
    narrowest = np.diff(edges)[-1] / (1 if len(edges) == 2 else 2)
    assert widths[-1] <= max(rim_size / np.sqrt(factor), narrowest) * (1 + 1e-9)
    for edge in edges[1:-1]:
        at = np.searchsorted(radii, edge)
        ring = np.searchsorted(edges, edge)
        inner = (edges[ring] - edges[ring - 1]) / (1 if ring == 1 else 2)
        outer = (edges[ring + 1] - edges[ring]) / 2
        assert widths[at - 1] <= min(edge_size / np.sqrt(factor), 1) * (1 + 1e-9) or widths[
            at - 1
        ] <= inner * (1 + 1e-9)
        assert widths[at] <= edge_size / np.sqrt(factor) * (1 + 1e-9) or widths[at] <= outer * (
            1 + 1e-9
        )


def test_layer_degrees() -> None:
    radii = graded_breakpoints(EDGES, 1e-4, 1e-4, 0.2)
    degrees = layer_degrees(radii, EDGES, 6, rise=1, lowest=2)
    at = np.searchsorted(radii, EDGES[1:])
    assert (degrees.min(), degrees.max()) == (2, 6)
    # lowest on both sides of every edge, and by one more with each element
    np.testing.assert_array_equal(degrees[at - 1], 2)
    np.testing.assert_array_equal(degrees[at[:-1]], 2)
    assert np.abs(np.diff(degrees)).max() <= 1


def test_partition_of_unity(space: PressureSpace) -> None:
    radii = np.linspace(0, 1, 777)
    np.testing.assert_allclose(
        space.matrix(radii) @ space.ring_indicator() @ np.ones(4), 1, rtol=1e-14
    )
    ring = np.clip(np.searchsorted(EDGES, radii, side="right") - 1, 0, 3)
    np.testing.assert_allclose(
        space.matrix(radii) @ space.ring_indicator(), np.eye(4)[ring], atol=1e-14
    )


def test_each_element_holds_polynomials_of_its_degree(space: PressureSpace) -> None:
    element = len(space.degrees) // 2
    left, right = space.breakpoints[element : element + 2]
    radii = left + (right - left) * (1 - np.cos(np.linspace(0, np.pi, 40))) / 2 * (1 - 1e-9)
    degree = int(space.degrees[element])
    local = 2 * (radii - left) / (right - left) - 1
    polynomial = np.polynomial.legendre.legval(local, np.ones(degree + 1))
    residual = np.linalg.lstsq(space.matrix(radii).toarray(), polynomial, rcond=None)[1]
    fitted = (
        space.matrix(radii)
        @ np.linalg.lstsq(space.matrix(radii).toarray(), polynomial, rcond=None)[0]
    )
    assert residual.size == 0 or residual[0] < 1e-20
    np.testing.assert_allclose(fitted, polynomial, atol=1e-11)


def test_forces(space: PressureSpace) -> None:
    rings = space.ring_indicator()
    np.testing.assert_allclose(
        space.ring_forces(EDGES) @ rings, np.diag(ring_areas(EDGES)), rtol=1e-12, atol=1e-16
    )
    np.testing.assert_allclose(
        space.ring_forces(EDGES).sum(axis=0), space.weights, rtol=1e-12, atol=1e-15
    )
    # rings of another punch, whose edges cut elements
    others = np.array([0.0, 0.123, 0.456, 1.0])
    np.testing.assert_allclose(
        space.ring_forces(others) @ rings @ np.ones(4), ring_areas(others), rtol=1e-12
    )


def test_forces_of_every_function(space: PressureSpace) -> None:
    """By Gauss points that do not come from the space."""
    node, weight = np.polynomial.legendre.leggauss(20)
    half = np.diff(space.breakpoints)[:, None] / 2
    radii = (space.breakpoints[:-1, None] + half * (1 + node)).ravel()
    expected = (2 * np.pi * radii * (half * weight).ravel()) @ space.matrix(radii)
    np.testing.assert_allclose(space.weights, expected, rtol=1e-10, atol=1e-15)


def test_mass(space: PressureSpace) -> None:
    mass = space.mass(WEAR).toarray()
    np.testing.assert_allclose(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    rings = space.ring_indicator()
    np.testing.assert_allclose(
        rings.T @ mass @ rings, np.diag(WEAR * ring_areas(EDGES)), rtol=1e-12, atol=1e-16
    )
    np.testing.assert_allclose(
        space.mass(np.ones(4)) @ rings @ np.ones(4), space.weights, rtol=1e-10, atol=1e-16
    )


def test_slopes(space: PressureSpace) -> None:
    """Of the function ``r``, which is in the space: one, and its mean square too."""
    linear = np.zeros(space.size)
    linear[space.dofs[:, 0]], linear[space.dofs[:, 1]] = (
        space.breakpoints[:-1],
        space.breakpoints[1:],
    )
    radii = np.linspace(0, 0.999, 50)
    np.testing.assert_allclose(space.matrix(radii) @ linear, radii, atol=1e-15)
    np.testing.assert_allclose(space.matrix(radii, derivative=True) @ linear, 1, rtol=1e-9)
    quadrature, _, local = space.quadrature
    np.testing.assert_allclose(space.on_elements(local, derivative=True) @ linear, 1, rtol=1e-10)
    np.testing.assert_allclose(space.on_elements(local) @ linear, quadrature.ravel(), rtol=1e-13)


def test_joined(space: PressureSpace) -> None:
    """As many conditions as inner edges.

    The product with the coefficients is continuous, and nothing more is asked.
    """
    basis = space.joined(WEAR).toarray()
    assert basis.shape == (space.size, space.size - 3)
    assert np.linalg.matrix_rank(basis) == space.size - 3
    for edge, before, after in zip(EDGES[1:-1], WEAR[:-1], WEAR[1:], strict=True):
        inside, outside = (
            space.matrix([radius]) @ basis for radius in (np.nextafter(edge, 0), edge)
        )
        np.testing.assert_allclose(
            before * inside, after * outside, atol=1e-10 * np.abs(outside).max()
        )
    # a constant product, that is every steady state, is held exactly
    steady = space.ring_indicator() @ (1 / WEAR)
    coefficients = np.linalg.lstsq(basis, steady, rcond=None)[0]
    np.testing.assert_allclose(basis @ coefficients, steady, rtol=1e-13, atol=1e-13)


def test_shapes() -> None:
    """Hats that are one at one end, bubbles that vanish at both and whose slopes are
    orthonormal.
    """
    ends = shapes(np.array([-1.0, 1.0]), 9)
    np.testing.assert_allclose(ends[:, :2], np.eye(2))
    np.testing.assert_allclose(ends[:, 2:], 0, atol=1e-15)
    node, weight = np.polynomial.legendre.leggauss(12)
    slopes = shape_slopes(node, 9)[:, 2:]
    np.testing.assert_allclose(slopes.T @ (weight[:, None] * slopes), np.eye(8), atol=1e-13)
    step = 1e-6
    differences = (shapes(node + step, 9) - shapes(node - step, 9)) / (2 * step)
    np.testing.assert_allclose(shape_slopes(node, 9), differences, atol=1e-8)
