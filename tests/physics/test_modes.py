"""Relaxation modes.

Those of a Krylov space against all of them, and banded factors against dense ones.
"""

import numpy as np
import pytest
import xarray
from scipy.sparse import csr_matrix

from ringwear import Scene
from ringwear.meshes import SceneError, SolverError
from ringwear.studies.methods.quantities import differences
from ringwear.studies.wear.full_contact import RunningIn
from ringwear.studies.wear.modes import BandedCholesky, every_mode, excited_modes
from ringwear.studies.wear.shared_modes import SharedModes


def pencil(wear):
    return BandedCholesky(wear._mass), wear._weights, wear._to_pressure.T @ wear.steady.moments


@pytest.mark.parametrize("earliest", [1e-4, 1e-2, 1.0, 1e12])
def test_the_flat_start_excites_few_modes(prepare, earliest):
    """The Krylov space carries the history from its earliest time on, and the slowest relaxation
    times.
    """
    wear = prepare("many_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    whole = every_mode(wear._energy, wear._factor, mass, weights, moments, gentle=False)
    few = excited_modes(wear._energy, mass, weights, moments, earliest)
    assert len(few.relaxation) < len(whole.relaxation)
    assert few.exact >= 5
    np.testing.assert_allclose(
        few.relaxation[: few.exact], whole.relaxation[: few.exact], rtol=1e-10
    )
    for time in earliest * np.array([1, 3, 1000]):
        # left of the flat start, and worn off by then
        for part in (lambda tau: np.exp(-time / tau), lambda tau: -np.expm1(-time / tau) * tau):  # noqa: B023
            values, expected = (
                modes.shapes @ (part(modes.relaxation) * modes.amplitudes) for modes in (few, whole)
            )
            np.testing.assert_allclose(values, expected, atol=1e-9 * np.abs(expected).max())


def test_a_start_that_excites_nothing_more_ends_the_search(prepare):
    """Two modes of a two-dimensional invariant space are found exactly."""
    wear = prepare("five_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    whole = every_mode(wear._energy, wear._factor, mass, weights, moments, gentle=True)
    start = wear._mass @ whole.shapes[:, [1, 4]] @ np.ones(2)
    few = excited_modes(wear._energy, mass, weights, start, 1e-3)
    np.testing.assert_allclose(few.relaxation[:2], whole.relaxation[[1, 4]], rtol=1e-12)


def test_too_early_is_refused(prepare):
    wear = prepare("five_rings", "mdr", accuracy__rtol=1e-2).wear
    mass, weights, moments = pencil(wear)
    energy = np.diag([1.0] * 3 + [1e-18] * (len(weights) - 3))
    with pytest.raises(SolverError, match="too early for double precision"):
        excited_modes(energy, mass, weights, moments, 1e-16)
    prepared = type(wear)(wear.compliance, wear.wear_coefficients, earliest=0.1)
    with pytest.raises(SceneError, match=r"prepared for times from 0\.1 on"):
        prepared.modal(np.array([0.0, 0.01]))


@pytest.mark.parametrize("wear", [[1.0, 0.1, 1.0, 0.1, 1.0], [0.2, 1.0, 0.03, 0.7, 0.5]])
def test_a_span_of_everything_leaves_nothing_out(prepare, wear):
    """Its modes are those of the punch, whatever the materials, and so is the history."""
    compliance, times = (
        prepare("five_rings", "mdr", accuracy__rtol=1e-2).wear.compliance,
        np.array([0.0, 1e-3, 0.1, 3.0]),
    )
    whole = RunningIn(compliance, np.array(wear), earliest=1e-3)
    materials = np.unique(wear, return_inverse=True)[1]
    everything = np.eye(len(whole._weights))[:, 1:]
    span = SharedModes.spanned(compliance, materials, everything, 1e-12)
    shared = RunningIn(compliance, np.array(wear), 1e-3, span)
    np.testing.assert_allclose(shared.relaxation_times, whole.relaxation_times[:20], rtol=1e-9)
    history, exact = shared.modal(times), whole.modal(times)
    np.testing.assert_allclose(history.indentation, exact.indentation, rtol=1e-11)
    for values, expected, part in (
        (history.pressure, exact.pressure, 1e-8),
        (history.profile, exact.profile, 1e-10),
    ):
        np.testing.assert_allclose(values, expected, atol=part * np.abs(expected).max())
    assert shared.left_out(times[1:]) < 1e-7


def test_a_few_histories_span_those_between(prepare):
    """And what they leave out is as much as the wear rate errs by."""
    compliance, times = (
        prepare("five_rings", "mdr", accuracy__rtol=1e-3).wear.compliance,
        np.geomspace(1e-3, 3, 9),
    )
    alike = np.array([0, 1, 0, 1, 0])

    def worn(ratio, shared=None):
        return RunningIn(compliance, np.array([1.0, ratio])[alike], 1e-3, shared)

    lost = []
    for ratios in ([0.1, 10.0], [0.1, 1.0, 10.0], [0.1, 0.3, 1.0, 3.0, 10.0]):
        rates = [worn(ratio).rates(np.geomspace(1e-6, 6, 46)) for ratio in ratios]
        shared = SharedModes.spanned(compliance, alike, np.column_stack(rates), 1e-8)
        few, whole = worn(0.5, shared), worn(0.5)
        mass = compliance.space.mass(whole.wear_coefficients)
        differs, pressure = (
            few.modal(times).pressure - whole.modal(times).pressure,
            whole.modal(times).pressure,
        )
        errors = np.sqrt(
            np.sum(differs * (mass @ differs.T).T, axis=1)
            / np.sum(pressure * (mass @ pressure.T).T, axis=1)
        )
        lost.append(float(errors.max()))
        assert few.left_out(times) > 0.1 * lost[-1]
    # histories nearer to each other leave out several times less
    assert lost[0] > 5 * lost[1] > 25 * lost[2]


def test_banded_factor():
    random = np.random.default_rng(3)
    matrix = (
        np.diag(4 + random.random(9)) + np.diag(random.random(7), 2) + np.diag(random.random(8), -1)
    )
    matrix = matrix + matrix.T
    factor = BandedCholesky(csr_matrix(matrix))
    right = random.random((9, 3))
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-14)
    lower = np.linalg.cholesky(matrix)
    np.testing.assert_allclose(lower @ factor.forward(right[:, 0]), right[:, 0], atol=1e-14)
    np.testing.assert_allclose(lower.T @ factor.backward(right), right, atol=1e-14)
    with pytest.raises(SolverError, match="too extreme for double precision"):
        BandedCholesky(csr_matrix(matrix - 20 * np.eye(9)))


def test_two_results_may_know_another_number_of_modes():
    times = np.array([1.0, 0.5, 0.25])
    three, two = (
        xarray.Dataset({"relaxation_time": ("mode", values)}) for values in (1.5 * times, times[:2])
    )
    compared = differences(three, two, Scene.load("five_rings").problem.face)
    np.testing.assert_array_equal(compared["relaxation_time"], [0.5, 0.5])


def test_no_columns_are_no_harm():
    """LAPACK's wrapper writes past the end of none."""
    factor = BandedCholesky(csr_matrix(np.eye(5)))
    assert factor.solve(np.empty((5, 0))).shape == (5, 0)
