"""Graded radii and the pressure space: values, slopes, forces, masses and coarser spaces."""

import numpy as np
import pytest

from ringwear import PressureSpace, ring_areas
from ringwear.meshes.radial import graded_breakpoints, layer_degrees, ring_of

EDGES = np.array([0.0, 0.25, 0.3, 0.8, 1.0])
WEAR = np.array([0.2, 1.0, 0.05, 0.6])


@pytest.fixture(params=[1, 2, 5, 9])
def space(request):
    return risen(EDGES, request.param)


def risen(edges, degree):
    """Return a space whose degrees rise away from the edges."""
    sizes = np.append(np.full(np.count_nonzero(edges) - 1, 1e-3), 1e-5)
    radii, _ = graded_breakpoints(edges, sizes, 0.3)
    return PressureSpace(radii, layer_degrees(radii, edges, degree, rise=1), edges)


def test_ring_areas():
    np.testing.assert_allclose(ring_areas(EDGES), np.pi * np.diff(EDGES**2), rtol=1e-14)
    # a narrow ring has the area 2 pi r w, up to roundoff
    narrow = 2 * np.pi * 2.0**-40 * (1 - 2.0**-41)
    assert ring_areas([1 - 2.0**-40, 1.0])[0] == pytest.approx(narrow, rel=1e-15)


@pytest.mark.parametrize("axis_size", [None, 1e-4])
@pytest.mark.parametrize("factor", [0.15, 0.5])
@pytest.mark.parametrize(("edge_size", "rim_size"), [(1e-2, 1e-2), (1e-3, 1e-8), (0.5, 0.5)])
@pytest.mark.parametrize(
    "edges", [[0.0, 1.0], EDGES, [0.0, 0.5, 0.5001, 1.0], [0.0, 1e-4, 0.9999, 1.0]], ids=str
)
def test_graded_breakpoints(edges, edge_size, rim_size, factor, axis_size):
    wanted = np.append(np.full(len(edges) - 2, edge_size), rim_size)
    radii, _ = graded_breakpoints(edges, wanted, factor, axis_size)
    assert (radii[0], radii[-1]) == (0.0, 1.0)
    widths = np.diff(radii)
    assert (widths > 0).all()
    assert np.isin(edges, radii).all()
    # sizes are right to within one step of the grading, or elements are half a narrow ring
    spans = np.diff(edges) / 2
    spans[0] *= 2 if axis_size is None else 1
    sizes = wanted / np.sqrt(factor)
    at = np.searchsorted(radii, edges)
    assert (widths[at[1:] - 1] <= np.maximum(sizes, spans) * (1 + 1e-9)).all()
    assert (widths[at[1:-1]] <= np.maximum(sizes[:-1], spans[1:]) * (1 + 1e-9)).all()
    assert axis_size is None or widths[0] <= max(axis_size / np.sqrt(factor), spans[0])


@pytest.mark.parametrize("sizes", [1e-8, [1e-3, 1e-6, 0.1, 1e-8]])
def test_the_elements_of_a_hollow_punch_are_those_outside_its_hole(sizes):
    (whole, low), (hollow, low_in_hollow) = (
        graded_breakpoints(edges, sizes, 0.3) for edges in (EDGES, EDGES[1:])
    )
    outside = np.searchsorted(whole + 1j * low, EDGES[1] + 0j)
    np.testing.assert_array_equal(hollow, whole[outside:])
    np.testing.assert_array_equal(low_in_hollow, low[outside:])
    degrees = layer_degrees(whole, EDGES, 6, rise=1)[outside:]
    np.testing.assert_array_equal(layer_degrees(hollow, EDGES[1:], 6, rise=1), degrees)


def test_the_space_of_a_hollow_punch():
    """It has no pressure in the hole, and forces on other rings are those outside of it."""
    edges = EDGES[1:]
    space = risen(edges, 5)
    rings = space.ring_indicator()
    values = space.matrix([0.0, 0.2, 0.25, 0.27, 1.0]) @ rings
    np.testing.assert_allclose(values, np.eye(5)[[4, 4, 0, 0, 2], :3], rtol=0, atol=1e-14)
    others = np.array([0.0, 0.27, 1.0])
    exact = ring_areas([0.25, 0.27, 1.0])
    np.testing.assert_allclose(space.ring_forces(others) @ rings.sum(axis=1), exact, rtol=1e-12)
    coarse = space.coarser()
    assert coarse.inner_radius == 0.25
    assert coarse.widths[0] > space.widths[0]


def test_layer_degrees():
    """Degrees are lowest on both sides of every edge and rise by one with each element."""
    radii, _ = graded_breakpoints(EDGES, 1e-4, 0.2)
    degrees = layer_degrees(radii, EDGES, 6, rise=1, lowest=2)
    at = np.searchsorted(radii, EDGES[1:])
    assert (degrees.min(), degrees.max()) == (2, 6)
    assert set(degrees[at - 1]) == set(degrees[at[:-1]]) == {2}
    assert np.abs(np.diff(degrees)).max() <= 1


def test_ring_indicator(space):
    radii = np.linspace(0, 1, 777)
    values = space.matrix(radii) @ space.ring_indicator()
    np.testing.assert_allclose(values, np.eye(4)[ring_of(EDGES, radii)], rtol=0, atol=1e-14)


def test_each_element_holds_polynomials_of_its_degree(space):
    """Polynomials of the element's degree are represented exactly, with their slopes."""
    element = len(space.degrees) // 2
    left, right = space.breakpoints[element : element + 2]
    radii = left + (right - left) * (1 - np.cos(np.linspace(0, np.pi, 40)) * (1 - 1e-9)) / 2
    polynomial = np.polynomial.Legendre(np.ones(space.degrees[element] + 1), [left, right])
    matrix = space.matrix(radii).toarray()
    coefficients = np.linalg.lstsq(matrix, polynomial(radii), rcond=None)[0]
    np.testing.assert_allclose(matrix @ coefficients, polynomial(radii), rtol=0, atol=1e-11)
    slopes = space.matrix(radii, derivative=True) @ coefficients
    exact = polynomial.deriv()(radii)
    np.testing.assert_allclose(slopes, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_forces(space):
    """Forces on the punch's rings, and on other rings, whose edges cut elements, are areas."""
    rings, forces = space.ring_indicator(), space.ring_forces(EDGES)
    np.testing.assert_allclose(forces @ rings, np.diag(ring_areas(EDGES)), rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(forces.sum(axis=0), space.weights, rtol=1e-12, atol=1e-15)
    others = np.array([0.0, 0.123, 0.456, 1.0])
    of_others = space.ring_forces(others) @ rings @ np.ones(4)
    np.testing.assert_allclose(of_others, ring_areas(others), rtol=1e-12)


def test_mass(space):
    mass, rings = space.mass(WEAR).toarray(), space.ring_indicator()
    np.testing.assert_allclose(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    expected = np.diag(WEAR * ring_areas(EDGES))
    np.testing.assert_allclose(rings.T @ mass @ rings, expected, rtol=1e-12, atol=1e-16)
    forces = space.mass() @ rings @ np.ones(4)
    np.testing.assert_allclose(forces, space.weights, rtol=1e-10, atol=1e-16)


def test_the_joined_basis_makes_the_product_with_k_continuous(space):
    """k p is continuous at the three ring edges, and there are no other conditions."""
    basis = space.joined(WEAR).toarray()
    assert np.linalg.matrix_rank(basis) == basis.shape[1] == space.size - 3
    inside, outside = (
        space.matrix(radii) @ basis for radii in (np.nextafter(EDGES[1:-1], 0), EDGES[1:-1])
    )
    scale = np.abs(outside).max()
    jumps = WEAR[:-1, None] * inside - WEAR[1:, None] * outside
    np.testing.assert_allclose(jumps, 0, rtol=0, atol=1e-10 * scale)
    # a constant product, that is every steady state, is in the space
    steady = space.ring_indicator() @ (1 / WEAR)
    coefficients = np.linalg.lstsq(basis, steady, rcond=None)[0]
    np.testing.assert_allclose(basis @ coefficients, steady, rtol=1e-13, atol=1e-13)


def test_a_coarser_space_lies_within(space):
    """The finer space reproduces its functions, and it has one layer less at every edge."""
    coarse = space.coarser()
    assert set(coarse.breakpoints) < set(space.breakpoints)
    assert (coarse.degrees.max() < space.top) or space.top == 1
    radii = np.sort(np.random.default_rng(4).random(500))
    embedded = space.matrix(radii) @ space.embedding(coarse)
    np.testing.assert_allclose(
        embedded.toarray(), coarse.matrix(radii).toarray(), rtol=0, atol=1e-13
    )
    for edge in space.ring_edges[1:]:
        first, second = (np.abs(mesh.breakpoints - edge) for mesh in (space, coarse))
        assert np.sort(second)[1] > np.sort(first)[1]


def test_coarsening_keeps_the_halves_of_rings():
    """Coarsening removes layers; if there are none, both halves of a ring are kept."""
    edges = np.array([0.0, 0.5, 1.0])
    breakpoints = np.array([0.0, 0.4, 0.5, 0.75, 0.95, 1.0])
    coarse = PressureSpace(breakpoints, np.full(5, 3), edges).coarser()
    np.testing.assert_array_equal(coarse.breakpoints, [0.0, 0.5, 0.75, 1.0])
    np.testing.assert_array_equal(coarse.degrees, [2, 2, 2])
