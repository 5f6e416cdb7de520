"""Relaxation modes: those of a Krylov space against all of them, and banded factors against dense ones."""

from typing import Any

import numpy as np
import pytest
import xarray
from scipy.sparse import csr_matrix

from ringwear import Scene
from ringwear.meshes.errors import SceneError, SolverError
from ringwear.studies.methods.quantities import differences
from ringwear.studies.wear.modes import BandedCholesky, every_mode, excited_modes


def pencil(wear: Any) -> tuple[Any, ...]:
    return BandedCholesky(wear._mass), wear._weights, wear._to_pressure.T @ wear.steady.moments


@pytest.mark.parametrize("earliest", [1e-4, 1e-2, 1.0, 1e12])
def test_the_flat_start_excites_few_modes(prepare: Any, earliest: float) -> None:
    """The Krylov space carries the history from its earliest time on, and the slowest relaxation times."""
    wear = prepare("many_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    whole = every_mode(wear._energy, wear._factor, mass, weights, moments, gentle=False)
    few = excited_modes(wear._energy, mass, weights, moments, earliest)
    assert len(few.relaxation) < len(whole.relaxation)
    assert few.exact >= 5
    np.testing.assert_allclose(few.relaxation[: few.exact], whole.relaxation[: few.exact], rtol=1e-10)
    for time in earliest * np.array([1, 3, 1000]):
        # left of the flat start, and worn off by then
        for share in (lambda tau: np.exp(-time / tau), lambda tau: -np.expm1(-time / tau) * tau):  # noqa: B023
            found, expected = (modes.shapes @ (share(modes.relaxation) * modes.amplitudes) for modes in (few, whole))
            np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_a_start_that_excites_nothing_more_ends_the_search(prepare: Any) -> None:
    """Two modes of a two-dimensional invariant space are found exactly."""
    wear = prepare("five_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    whole = every_mode(wear._energy, wear._factor, mass, weights, moments, gentle=True)
    start = wear._mass @ whole.shapes[:, [1, 4]] @ np.ones(2)
    few = excited_modes(wear._energy, mass, weights, start, 1e-3)
    np.testing.assert_allclose(few.relaxation[:2], whole.relaxation[[1, 4]], rtol=1e-12)


def test_too_early_is_refused(prepare: Any) -> None:
    wear = prepare("five_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    energy = np.diag([1.0] * 3 + [1e-18] * (len(weights) - 3))
    with pytest.raises(SolverError, match="too early for double precision"):
        excited_modes(energy, mass, weights, moments, 1e-16)
    prepared = type(wear)(wear.compliance, wear.wear_coefficients, earliest=0.1)
    with pytest.raises(SceneError, match=r"prepared for times from 0\.1 on"):
        prepared.modal(np.array([0.0, 0.01]))


def test_banded_factor() -> None:
    random = np.random.default_rng(3)
    matrix = np.diag(4 + random.random(9)) + np.diag(random.random(7), 2) + np.diag(random.random(8), -1)
    matrix = matrix + matrix.T
    factor = BandedCholesky(csr_matrix(matrix))
    right = random.random((9, 3))
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-14)
    np.testing.assert_allclose(np.linalg.cholesky(matrix) @ factor.forward(right[:, 0]), right[:, 0], atol=1e-14)
    np.testing.assert_allclose(np.linalg.cholesky(matrix).T @ factor.backward(right), right, atol=1e-14)
    with pytest.raises(SolverError, match="too extreme for double precision"):
        BandedCholesky(csr_matrix(matrix - 20 * np.eye(9)))


def test_two_results_may_know_another_number_of_modes() -> None:
    times = np.array([1.0, 0.5, 0.25])
    three, two = (xarray.Dataset({"relaxation_time": ("mode", known)}) for known in (1.5 * times, times[:2]))
    found = differences(three, two, Scene.load("five_rings").problem.face)
    np.testing.assert_array_equal(found["relaxation_time"], [0.5, 0.5])


def test_no_columns_are_no_harm() -> None:
    """LAPACK's wrapper writes past the end of none."""
    factor = BandedCholesky(csr_matrix(np.eye(5)))
    assert factor.solve(np.empty((5, 0))).shape == (5, 0)
