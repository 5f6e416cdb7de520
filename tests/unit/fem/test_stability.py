"""Pairs of displacements and pressures on the contact: stable, with checkerboards, singular."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_matrix
from skfem import MeshTri

from ringwear import PressureSpace, SizeField, SolverError, bisection, energy
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import enough_poles
from ringwear.fem.half_space import HalfSpace, contact_breakpoints, pressure_space
from ringwear.meshes.ground.ground import Ground
from ringwear.meshes.half_space import as_half_space

EDGES = np.array([0.0, 0.3, 0.7, 1.0])
FIELD = SizeField(tuple(EDGES), 0.02, 0.02, 0.7, 4.0)


@cache
def meshed(halvings):
    mesh = bisection.mesh(FIELD).refined(halvings)
    points = mesh.p.copy()
    arc = np.setdiff1d(mesh.boundary_nodes(), np.flatnonzero((points == 0).any(axis=0)))
    points[:, arc] *= 4.0 / np.hypot(*points[:, arc])
    return as_half_space(MeshTri(points, mesh.t), EDGES)


def half_space(degree, pressures, broken_at, halvings=0):
    """Return a half-space with given degrees of displacements and pressures.

    Pressures are discontinuous nowhere, at ring edges ("rings") or at all breakpoints.
    """
    mesh = meshed(halvings)
    breakpoints, below = contact_breakpoints(mesh, EDGES)
    breaks = {"nowhere": EDGES[[0, -1]], "rings": EDGES, "everywhere": breakpoints}[broken_at]
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, pressures), breaks, below)
    solid = AxisymmetricElasticity(mesh, degree, Ground.half_space(0.3))
    return HalfSpace(solid, space, enough_poles(4.0, 1e-9))


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("broken_at", ["rings", "everywhere"])
def test_discontinuous_pressures_of_the_same_degree_are_refused(degree, broken_at):
    singular = half_space(degree, degree, broken_at)
    assert singular.stability() < 1e-12
    with pytest.raises(SolverError, match="pair of spaces is singular"):
        singular.compliance()


def test_a_pressure_that_displaces_nothing_is_detected():
    """One such pressure suffices, even if there are more displacements than pressures."""
    many = half_space(2, 2, "rings")
    count = len(many.coupling) - len(many.poles)
    unseen = np.linalg.svd(many.coupling[:count])[2][-1]
    few = csr_matrix(np.stack([many.space.uniform, unseen], axis=1))
    assert many.stability(few) < 1e-12
    assert many.stability(few[:, :1]) > 0.1


@pytest.mark.parametrize("broken_at", ["nowhere", "rings"])
@pytest.mark.parametrize("degree", [2, 3, 4])
def test_stable_pairs_stay_stable(degree, broken_at):
    """The constant does not depend on the size of elements, and falls as 1 / degree."""
    ratios = [half_space(degree, degree - 1, broken_at, n).stability() for n in range(3)]
    assert min(ratios) > 1 / degree
    assert max(ratios) < 1.5 * min(ratios)


@pytest.mark.parametrize("degree", [2, 3])
def test_the_stability_of_checkerboards_falls_as_the_square_of_the_size(degree):
    ratios = [half_space(degree, degree - 1, "everywhere", n).stability() for n in range(3)]
    np.testing.assert_allclose(np.log2(ratios[:-1]) - np.log2(ratios[1:]), 2.0, atol=0.25)
    # such a pair is not singular, and the compliance can be computed
    half_space(degree, degree - 1, "everywhere").compliance()


@pytest.mark.parametrize("halvings", [0, 1, 2])
def test_linear_pressures_beneath_linear_displacements_are_stable(halvings):
    """Pressures are discontinuous at ring edges, where two facets share one linear pressure."""
    solid = AxisymmetricElasticity(meshed(halvings), 1, Ground.half_space(0.3))
    space = pressure_space(solid, EDGES)
    assert np.isin(EDGES, space.breakpoints).all()
    whole = HalfSpace(solid, space, enough_poles(4.0, 1e-9))
    assert whole.stability() > 0.4
    ratios = eigh(whole.compliance().matrix, energy.compliance(space).matrix, eigvals_only=True)
    assert ratios[0] > 0.14
    assert ratios[-1] <= 1.001
    # the coupling of a constant displacement with each pressure is the force of that pressure
    coupling = whole.coupling[: len(whole.coupling) - len(whole.poles)]
    np.testing.assert_allclose(coupling.sum(axis=0), space.weights, rtol=1e-12)
