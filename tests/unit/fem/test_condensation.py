"""The condensed compliance against the whole system, theory, dense algebra and each solver."""

import importlib.util
from functools import cache

import numpy as np
import pytest
from conftest import WITHOUT_GMSH
from groups import nightly
from scipy.sparse import bmat, coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from ringwear import SizeField, SolverError, bisection, direct, press_flat
from ringwear.fem import condensation
from ringwear.fem.condensation import Factor, symmetric
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.meshes.by_gmsh import quads
from ringwear.meshes.ground.ground import Ground
from ringwear.meshes.half_space import contact_facets

SOLVERS = ["superlu"] + ["cholmod"] * bool(importlib.util.find_spec("kvxopt"))
EDGES = np.array([0.0, 0.3, 0.7, 1.0])
# kind of mesh and degree of the displacement
SOLIDS = [("triangles", 2), ("triangles", 3), ("triangles", 4), ("quads", 4), ("quads", 6)]
each_solid = pytest.mark.parametrize("solid", SOLIDS, ids=str)


@pytest.fixture(params=SOLVERS)
def solver(request, monkeypatch):
    monkeypatch.setattr(condensation, "solver", lambda: request.param)


@cache
def half_space(solid, poisson_ratio=0.3, poles=(0, 2, 4)):
    kind, degree = solid
    if kind == "quads":
        if WITHOUT_GMSH:
            pytest.skip(WITHOUT_GMSH)
        size = 10 ** (-degree / 2)
        mesh = quads.graded(EDGES, size, size / 10, 0.25, 0.8, 5.0).mesh
    else:
        mesh = bisection.mesh(SizeField(tuple(EDGES), 1e-4, 1e-2, 0.7, 5.0))
    elastic = AxisymmetricElasticity(mesh, degree, Ground.half_space(poisson_ratio))
    return HalfSpace(elastic, pressure_space(elastic, EDGES), poles)


def saddle_point(half_space, force):
    """Return pressure coefficients and indentation of the flat punch from the whole system."""
    continuous, system = half_space.space.joined(), symmetric(half_space.lower_triangle)
    inside = system.shape[0]
    loads = np.pad(half_space.coupling, ((inside - len(half_space.coupling), 0), (0, 0)))
    coupling = csc_matrix(loads @ continuous)
    weights = csc_matrix(half_space.space.weights @ continuous)
    blocks = [[system, -coupling, None], [-coupling.T, None, weights.T], [None, weights, None]]
    whole = bmat(blocks, format="csc")
    solution = splu(whole).solve(force * np.eye(whole.shape[0])[-1])
    return continuous @ solution[inside:-1], float(solution[-1])


@pytest.mark.usefixtures("solver")
@pytest.mark.parametrize("poles", [(), *nightly(((0, 2, 4),))], ids=str)
@each_solid
def test_the_condensed_compliance_agrees_with_the_saddle_point(solid, poles):
    whole = half_space(solid, poles=poles)
    pressure, indentation = saddle_point(whole, force=2.0)
    condensed = press_flat(whole.compliance())
    assert 2 * condensed.indentation == pytest.approx(indentation, rel=1e-10)
    energies = whole.compliance().factor @ (2 * condensed.pressure - pressure)
    assert np.linalg.norm(energies) <= 1e-9 * np.sqrt(2 * indentation)


@each_solid
def test_coupling_carries_forces_and_moments(solid):
    """The coupling of displacements 1 and r with each pressure is its force and its moment."""
    whole = half_space(solid)
    ones, radii = (
        whole.solid.interpolate("contact", field)[:, 0] for field in (np.ones_like, np.asarray)
    )
    coupling = whole.coupling[: len(radii)]
    np.testing.assert_allclose(ones @ coupling, whole.space.weights, rtol=1e-12, atol=1e-15)
    moments = radii @ coupling @ whole.space.ring_indicator()
    np.testing.assert_allclose(moments, 2 * np.pi * np.diff(EDGES**3) / 3, rtol=1e-12)


@pytest.mark.parametrize(("degree", "tolerance"), [(5, 3e-4), (6, 4e-5), (8, 1e-5)])
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999])
def test_displacements_of_rings(degree, poisson_ratio, tolerance):
    whole = half_space(("quads", degree), poisson_ratio, tuple(range(0, 12, 2)))
    solid, pressures, local = whole.solid, np.array([1.0, 0.1, 1.0]), np.linspace(0.05, 0.95, 12)
    coefficients = whole.displacements((whole.space.ring_indicator() @ pressures)[None])
    trace = solid.trace(contact_facets(solid.mesh), local)
    starts, widths = whole.space.breakpoints[:-1, None], np.diff(whole.space.breakpoints)[:, None]
    expected = direct.displacement(EDGES, pressures, (starts + widths * local).ravel())
    moved = trace @ coefficients[0, : solid.nodes, 1]
    np.testing.assert_allclose(moved, expected, rtol=tolerance)


def random_definite(seed):
    draw = np.random.default_rng(seed)
    matrix = draw.normal(size=(40, 40)) * (draw.random((40, 40)) < 0.2)
    return matrix @ matrix.T + 0.1 * np.eye(40)


@pytest.mark.usefixtures("solver")
@pytest.mark.parametrize("inside", [1, 25, 39])
def test_trailing_factor_is_the_schur_complement(inside):
    dense = random_definite(inside)
    factor = Factor(coo_matrix(np.tril(dense))).trailing(inside)
    np.testing.assert_allclose(factor, np.tril(factor))
    # the inverse of the Schur complement is the trailing block of the inverse
    complement = np.linalg.inv(np.linalg.inv(dense)[inside:, inside:])
    np.testing.assert_allclose(factor @ factor.T, complement, rtol=0, atol=1e-11)


@pytest.mark.usefixtures("solver")
def test_solutions_fulfil_the_system():
    dense, right = random_definite(3), np.random.default_rng(3).normal(size=(40, 2))
    solution = Factor(coo_matrix(np.tril(dense))).solve(right)
    np.testing.assert_allclose(dense @ solution, right, rtol=0, atol=1e-10)


@pytest.mark.usefixtures("solver")
@pytest.mark.parametrize("spoilt", [0, 39], ids=["inside", "trailing"])
@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_indefinite_matrices_are_refused(spoilt, value):
    dense = random_definite(7)
    dense[spoilt, spoilt] = value
    with pytest.raises(SolverError):
        Factor(coo_matrix(np.tril(dense))).trailing(25)
    with pytest.raises(SolverError):
        Factor(coo_matrix(np.tril(dense))).solve(np.ones((40, 1)))
