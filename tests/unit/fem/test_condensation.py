"""The condensed compliance against the whole system, and the factorisations against dense algebra
and each other.
"""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from conftest import WITHOUT_GMSH
from scipy.sparse import coo_matrix

from ringwear.fem.condensation import fill_reducing_order, trailing_factor
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.meshes import quads
from ringwear.meshes.bisection import mesh as bisection
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import SizeField
from ringwear.studies.wear.flat_contact import press_flat

SOLVERS = ["superlu"] + ["cholmod"] * bool(importlib.util.find_spec("kvxopt"))
EDGES = np.array([0.0, 0.3, 0.7, 1.0])
# on quadrilaterals in layers or, of degree 2 to 4, on triangles
SOLIDS = [("triangles", 2), ("triangles", 3), ("triangles", 4), ("quads", 4), ("quads", 6)]
every_solid = pytest.mark.parametrize(("kind", "degree"), SOLIDS)


def half_space(
    kind: str,
    degree: int,
    poisson_ratio: float = 0.3,
    poles: tuple[int, ...] = (0, 2, 4),
    solver: str = "",
) -> HalfSpace:
    if kind == "quads":
        if WITHOUT_GMSH:
            pytest.skip(WITHOUT_GMSH)
        mesh = quads.graded(
            EDGES, 10.0 ** (-degree / 2), 10.0 ** (-1 - degree / 2), 0.25, 0.8, 5.0
        ).mesh
    else:
        mesh = bisection(SizeField(tuple(EDGES), 1e-4, 1e-2, 0.7, 5.0))
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    return HalfSpace(solid, pressure_space(solid, EDGES), poles, solver)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("poles", [(), (0, 2, 4)], ids=str)
@every_solid
def test_saddle_point_agrees(kind: str, degree: int, poles: tuple[int, ...], solver: str) -> None:
    whole = half_space(kind, degree, poles=poles, solver=solver)
    pressure, indentation = whole.saddle_point(force=2.0)
    condensed = press_flat(whole.compliance())
    assert 2 * condensed.indentation == pytest.approx(indentation, rel=1e-10)
    energy = whole.compliance().factor @ (2 * condensed.pressure - pressure)
    assert np.linalg.norm(energy) <= 1e-9 * np.sqrt(2 * indentation)


# an incompressible solid is modelled by lambda / G = 5e4, and roundoff grows by as much
@pytest.mark.parametrize(("poisson_ratio", "tolerance"), [(0.0, 1e-10), (0.3, 1e-10), (0.5, 1e-8)])
def test_solvers_agree(poisson_ratio: float, tolerance: float) -> None:
    one, *others = (
        half_space("triangles", 4, poisson_ratio, solver=solver).compliance().matrix
        for solver in SOLVERS
    )
    for other in others:
        assert np.abs(one - other).max() <= tolerance * np.abs(one).max()
        # relative in every direction, not only in that of the greatest entries
        lower = np.linalg.cholesky(one)
        ratio = np.linalg.solve(lower, np.linalg.solve(lower, other).T)
        assert np.abs(np.linalg.eigvalsh(ratio) - 1).max() <= 100 * tolerance


@pytest.mark.parametrize("solver", SOLVERS)
def test_order_leaves_no_vertex_out(solver: str) -> None:
    neighbours, part = half_space("triangles", 4).solid.parts
    order = fill_reducing_order(neighbours, solver)
    np.testing.assert_array_equal(np.sort(order), np.arange(neighbours.max() + 1))
    assert set(part) == set(order)


@every_solid
def test_coupling_carries_forces_and_moments(kind: str, degree: int) -> None:
    """Constant and linear displacements on the contact meet each pressure with its force and its
    moment.
    """
    whole = half_space(kind, degree)
    solid, space = whole.solid, whole.space
    ones, radii = (
        solid.interpolate("contact", field)[:, 0] for field in (np.ones_like, np.asarray)
    )
    coupling = whole.coupling[: len(radii)]
    np.testing.assert_allclose(ones @ coupling, space.weights, rtol=1e-12, atol=1e-15)
    moments = 2 * np.pi * np.diff(EDGES**3) / 3
    np.testing.assert_allclose(radii @ coupling @ space.ring_indicator(), moments, rtol=1e-12)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.4999])
@every_solid
def test_multipliers_are_stable(kind: str, degree: int, poisson_ratio: float) -> None:
    """Checkerboards.

    Pressures that the displacements do not see, beside a compliance that sees them all.
    """
    from ringwear.mdr.energy import compliance

    whole = half_space(kind, degree, poisson_ratio)
    exact = compliance(whole.space).factor
    ratios = np.linalg.svd(
        whole.compliance().factor @ np.linalg.inv(np.linalg.qr(exact, mode="r")), compute_uv=False
    )
    assert ratios.min() ** 2 >= 0.3
    assert ratios.max() ** 2 <= 1 + 1e-3


@pytest.mark.parametrize(
    ("degree", "energies", "heights"), [(5, 3e-5, 3e-4), (6, 2e-6, 4e-5), (8, 1e-7, 1e-5)]
)
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999])
def test_ringwise_constant_pressures(
    degree: int, poisson_ratio: float, energies: float, heights: float
) -> None:
    """Energies of all of them at once, and displacements and slopes of one, against closed
    forms.
    """
    from ringwear.mdr.direct import displacement
    from ringwear.mdr.energy import compliance

    whole = half_space("quads", degree, poisson_ratio, tuple(range(0, 12, 2)))
    rings = whole.space.ring_indicator()
    triangle = np.linalg.qr(compliance(whole.space).factor @ rings, mode="r")
    found = np.linalg.solve(triangle.T, (whole.compliance().factor @ rings).T)
    assert np.abs(np.linalg.svd(found, compute_uv=False) ** 2 - 1).max() <= energies
    pressures = np.array([1.0, 0.1, 1.0])
    local, weights = np.polynomial.legendre.leggauss(12)
    radii, moved, slopes = whole.contact_displacement(rings @ pressures, (1 + local) / 2)
    assert (np.diff(radii.ravel()) > 0).all()
    expected = displacement(EDGES, pressures, radii.ravel()).reshape(radii.shape)
    assert np.abs(moved / expected - 1).max() <= heights
    fall = np.sum(slopes * weights / 2 * np.diff(whole.space.breakpoints)[:, None])
    ends = displacement(EDGES, pressures, np.array([0.0, 1.0]))
    assert fall == pytest.approx(ends[1] - ends[0], rel=heights)


def random_definite(size: int, seed: int) -> Array:
    matrix = np.random.default_rng(seed).normal(size=(size, size)) * (
        np.random.default_rng(seed).random((size, size)) < 0.2
    )
    return matrix @ matrix.T + 0.1 * np.eye(size)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("inside", [1, 25, 39])
def test_trailing_factor_is_the_schur_complement(solver: str, inside: int) -> None:
    dense = random_definite(40, inside)
    block, border, corner = (
        dense[:inside, :inside],
        dense[:inside, inside:],
        dense[inside:, inside:],
    )
    factor = trailing_factor(coo_matrix(np.tril(dense)), inside, solver)
    np.testing.assert_allclose(factor, np.tril(factor))
    np.testing.assert_allclose(
        factor @ factor.T, corner - border.T @ np.linalg.solve(block, border), atol=1e-11
    )


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("spoilt", [0, 39], ids=["inside", "kept"])
@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_what_is_not_definite_is_refused(solver: str, spoilt: int, value: float) -> None:
    dense = random_definite(40, 7)
    dense[spoilt, spoilt] = value
    with pytest.raises(SolverError):
        trailing_factor(coo_matrix(np.tril(dense)), 25, solver)
