"""The condensed compliance against the whole system, theory, dense algebra, and each solver."""

import importlib.util
from functools import cache

import numpy as np
import pytest
from conftest import WITHOUT_GMSH
from scipy.sparse import coo_matrix

from ringwear.fem import AxisymmetricElasticity, HalfSpace, pressure_space, trailing_factor
from ringwear.mdr import direct, energy
from ringwear.meshes import SizeField, SolverError, bisection, quads
from ringwear.studies.wear.flat_contact import press_flat

SOLVERS = ["superlu"] + ["cholmod"] * bool(importlib.util.find_spec("kvxopt"))
EDGES = np.array([0.0, 0.3, 0.7, 1.0])
# on quadrilaterals in layers or, of degree 2 to 4, on triangles
SOLIDS = [("triangles", 2), ("triangles", 3), ("triangles", 4), ("quads", 4), ("quads", 6)]
each_solid = pytest.mark.parametrize("solid", SOLIDS, ids=str)


@cache
def half_space(solid, poisson_ratio=0.3, poles=(0, 2, 4), solver=""):
    kind, degree = solid
    if kind == "quads":
        if WITHOUT_GMSH:
            pytest.skip(WITHOUT_GMSH)
        size = 10 ** (-degree / 2)
        mesh = quads.graded(EDGES, size, size / 10, 0.25, 0.8, 5.0).mesh
    else:
        mesh = bisection.mesh(SizeField(tuple(EDGES), 1e-4, 1e-2, 0.7, 5.0))
    elastic = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    return HalfSpace(elastic, pressure_space(elastic, EDGES), poles, solver)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("poles", [(), (0, 2, 4)], ids=str)
@each_solid
def test_saddle_point_agrees(solid, poles, solver):
    whole = half_space(solid, poles=poles, solver=solver)
    pressure, indentation = whole.saddle_point(force=2.0)
    condensed = press_flat(whole.compliance())
    assert 2 * condensed.indentation == pytest.approx(indentation, rel=1e-10)
    energies = whole.compliance().factor @ (2 * condensed.pressure - pressure)
    assert np.linalg.norm(energies) <= 1e-9 * np.sqrt(2 * indentation)


def squared_ratios(factor, reference):
    """Generalised eigenvalues of two matrices, both given by factors ``A = F^T F``."""
    inverse = np.linalg.inv(np.linalg.qr(reference, mode="r"))
    return np.linalg.svd(factor @ inverse, compute_uv=False) ** 2


# an incompressible solid is modelled by lambda / G = 5e4, and roundoff grows by as much
@pytest.mark.parametrize(("poisson_ratio", "tolerance"), [(0.0, 1e-8), (0.3, 1e-8), (0.5, 1e-6)])
def test_solvers_agree_for_each_pressure(poisson_ratio, tolerance):
    pytest.importorskip("kvxopt")
    first, second = (
        half_space(("triangles", 4), poisson_ratio, solver=solver).compliance().factor
        for solver in SOLVERS
    )
    assert np.abs(squared_ratios(second, first) - 1).max() <= tolerance


@each_solid
def test_coupling_carries_forces_and_moments(solid):
    """Displacements 1 and r on the contact meet each pressure with its force and its moment."""
    whole = half_space(solid)
    ones, radii = (
        whole.solid.interpolate("contact", field)[:, 0] for field in (np.ones_like, np.asarray)
    )
    coupling = whole.coupling[: len(radii)]
    np.testing.assert_allclose(ones @ coupling, whole.space.weights, rtol=1e-12, atol=1e-15)
    moments = radii @ coupling @ whole.space.ring_indicator()
    np.testing.assert_allclose(moments, 2 * np.pi * np.diff(EDGES**3) / 3, rtol=1e-12)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.4999])
@each_solid
def test_multipliers_are_stable(solid, poisson_ratio):
    """No checkerboards: displacements see each pressure as well as theory does."""
    whole = half_space(solid, poisson_ratio)
    ratios = squared_ratios(whole.compliance().factor, energy.compliance(whole.space).factor)
    assert ratios.min() >= 0.3
    assert ratios.max() <= 1 + 1e-3


@pytest.mark.parametrize(("degree", "tolerance"), [(5, 3e-4), (6, 4e-5), (8, 1e-5)])
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999])
def test_displacements_and_slopes_of_rings(degree, poisson_ratio, tolerance):
    whole = half_space(("quads", degree), poisson_ratio, tuple(range(0, 12, 2)))
    pressures = np.array([1.0, 0.1, 1.0])
    local, weights = np.polynomial.legendre.leggauss(12)
    coefficients = whole.space.ring_indicator() @ pressures
    radii, moved, slopes = whole.contact_displacement(coefficients, (1 + local) / 2)
    expected = direct.displacement(EDGES, pressures, radii.ravel())
    np.testing.assert_allclose(moved.ravel(), expected, rtol=tolerance)
    fall = np.sum(slopes * weights / 2 * np.diff(whole.space.breakpoints)[:, None])
    centre, rim = direct.displacement(EDGES, pressures, np.array([0.0, 1.0]))
    assert fall == pytest.approx(rim - centre, rel=tolerance)


def random_definite(seed):
    draw = np.random.default_rng(seed)
    matrix = draw.normal(size=(40, 40)) * (draw.random((40, 40)) < 0.2)
    return matrix @ matrix.T + 0.1 * np.eye(40)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("inside", [1, 25, 39])
def test_trailing_factor_is_the_schur_complement(solver, inside):
    dense = random_definite(inside)
    factor = trailing_factor(coo_matrix(np.tril(dense)), inside, solver)
    np.testing.assert_allclose(factor, np.tril(factor))
    # the inverse of the Schur complement is the trailing block of the inverse
    complement = np.linalg.inv(np.linalg.inv(dense)[inside:, inside:])
    np.testing.assert_allclose(factor @ factor.T, complement, atol=1e-11)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("spoilt", [0, 39], ids=["inside", "trailing"])
@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_what_is_not_definite_is_refused(solver, spoilt, value):
    dense = random_definite(7)
    dense[spoilt, spoilt] = value
    with pytest.raises(SolverError):
        trailing_factor(coo_matrix(np.tril(dense)), 25, solver)
