"""Relaxation modes by a Krylov space against all modes; banded factors against dense ones."""

import numpy as np
import pytest
from groups import slow
from scipy.integrate import quad
from scipy.sparse import csr_matrix, diags

from ringwear import RunningIn, SceneError, SolverError
from ringwear.meshes import BandedCholesky
from ringwear.studies.crosscheck.wear.modes import (
    Modes,
    every_mode,
    excited_modes,
    mean_decay,
)

COARSE = {"accuracy__rtol": 1e-2}


def pencil(wear):
    return wear._energy.__matmul__, wear._weights, wear._moments


def modes_of(wear):
    """Return all modes."""
    return every_mode(wear._energy, wear._factor, wear._weights, wear._moments, 0.0)


@pytest.fixture(scope="module")
def many_rings(prepare):
    wear = prepare("many_rings", "mdr", **COARSE).wear
    return wear, modes_of(wear)


@pytest.mark.parametrize("earliest", [*slow(1e-4), 1e-2, 1.0, 1e12])
def test_the_flat_start_excites_few_modes(many_rings, earliest):
    """A few modes give the history from the earliest time on, and the slowest relaxation times."""
    wear, whole = many_rings
    few = excited_modes(*pencil(wear), earliest)
    assert 5 <= few.exact < len(few.relaxation) < len(whole.relaxation)
    exact = slice(few.exact)
    np.testing.assert_allclose(few.relaxation[exact], whole.relaxation[exact], rtol=1e-10)

    def left(modes, time):
        return modes.shapes @ (np.exp(-time / modes.relaxation) * modes.amplitudes)

    def worn(modes, time):
        gone = -np.expm1(-time / modes.relaxation) * modes.relaxation
        return modes.shapes @ (gone * modes.amplitudes)

    for part in (left, worn):
        for time in earliest * np.array([1, 3, 1000]):
            expected = part(whole, time)
            atol = 1e-9 * np.abs(expected).max()
            np.testing.assert_allclose(part(few, time), expected, rtol=0, atol=atol)


def test_modes_of_an_invariant_space_are_exact(prepare):
    """From a start in a two-dimensional invariant space, the search ends with its two modes."""
    wear = prepare("five_rings", "mdr", **COARSE).wear
    whole = modes_of(wear)
    start = whole.shapes[:, [1, 4]] @ np.ones(2)
    few = excited_modes(wear._energy.__matmul__, wear._weights, start, 1e-3)
    np.testing.assert_allclose(few.relaxation[:2], whole.relaxation[[1, 4]], rtol=1e-12)


def test_times_too_early_are_refused(prepare):
    wear = prepare("five_rings", "mdr", **COARSE).wear
    energy = np.diag([1.0] * 3 + [1e-18] * (len(wear._weights) - 3))
    with pytest.raises(SolverError, match="too early for double precision"):
        excited_modes(energy.__matmul__, wear._weights, wear._moments, 1e-16)
    later = RunningIn(wear.compliance, wear.wear_coefficients, earliest=0.1)
    with pytest.raises(SceneError, match=r"for sliding distances from 0\.1 on"):
        later.modal(np.array([0.0, 0.01]))


def test_time_until_against_closed_forms():
    """Closed forms: one exponential, and two, one twice as fast (a quadratic equation)."""
    one = Modes(np.array([3.0]), np.eye(1), np.array([2.0]), 1)
    assert one.time_until(12 * 1e-5) == pytest.approx(3 * np.log(1e5), rel=1e-14)
    # y + y^2 is left, with y = exp(-t)
    two = Modes(np.array([1.0, 0.5]), np.eye(2), np.array([1.0, 2**0.5]), 2)
    for y in (1e-8, 0.3, 0.9999):
        assert two.time_until(y + y**2) == pytest.approx(-np.log(y), rel=1e-11)
    # very different times: the fast mode has vanished
    far = Modes(np.array([1.0, 1e-12]), np.eye(2), np.array([1e-3, 1e5]), 2)
    assert far.time_until(1e-8) == pytest.approx(np.log(100), rel=1e-13)
    assert np.isnan(two.time_until(2.1))


def test_banded_cholesky_against_a_dense_factor():
    bands = np.array([0.3, 0.5, 4.0, 0.5, 0.3])
    matrix, right = diags(bands, range(-2, 3), (9, 9)).toarray(), np.eye(9)
    factor, lower = BandedCholesky(csr_matrix(matrix)), np.linalg.cholesky(matrix)
    np.testing.assert_allclose(matrix @ factor.solve(right), right, rtol=0, atol=1e-14)
    np.testing.assert_allclose(lower @ factor.forward(right[:, 0]), right[:, 0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(lower.T @ factor.backward(right), right, rtol=0, atol=1e-14)
    # LAPACK's wrapper writes out of bounds if there are no columns
    assert factor.solve(np.empty((9, 0))).shape == (9, 0)
    with pytest.raises(SolverError, match="too extreme for double precision"):
        BandedCholesky(csr_matrix(matrix - 20 * np.eye(9)))


@pytest.mark.parametrize("bend", [-1.0, -0.3, -1e-9, 0.0, 1e-13, 1e-4, 0.7, 1.0])
def test_mean_decay_during_a_rise_against_quadrature(bend):
    for decayed in (0.0, 1e-9, 0.3, 0.999, 1.001, 7.0, 40.0):
        exact = quad(
            lambda u, x=decayed: np.exp(-x * u * (1 + bend * (1 - u))), 0, 1, epsabs=0, epsrel=1e-13
        )
        value = mean_decay(np.array([[decayed]]), np.array([bend]))[0, 0]
        assert value == pytest.approx(exact[0], rel=1e-11), decayed
