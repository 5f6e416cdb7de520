"""Relaxation modes by a Krylov space against all modes; banded factors against dense ones."""

import numpy as np
import pytest
import xarray
from scipy.sparse import csr_matrix, diags

from ringwear import RunningIn, Scene, SceneError, SolverError, differences, run
from ringwear.studies.wear.modes import BandedCholesky, Modes, every_mode, excited_modes

COARSE = {"accuracy__rtol": 1e-2}


def pencil(wear):
    return wear._energy, wear._weights, wear._moments


def modes_of(wear):
    """Return all modes."""
    return every_mode(wear._energy, wear._factor, wear._weights, wear._moments, 0.0)


@pytest.fixture(scope="module")
def many_rings(prepare):
    wear = prepare("many_rings", "mdr", **COARSE).wear
    return wear, modes_of(wear)


@pytest.mark.parametrize("earliest", [1e-4, 1e-2, 1.0, 1e12])
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
            np.testing.assert_allclose(part(few, time), expected, atol=atol)


def test_modes_of_an_invariant_space_are_exact(prepare):
    """From a start in a two-dimensional invariant space, the search ends with its two modes."""
    wear = prepare("five_rings", "mdr", **COARSE).wear
    whole = modes_of(wear)
    start = whole.shapes[:, [1, 4]] @ np.ones(2)
    few = excited_modes(wear._energy, wear._weights, start, 1e-3)
    np.testing.assert_allclose(few.relaxation[:2], whole.relaxation[[1, 4]], rtol=1e-12)


def test_times_too_early_are_refused(prepare):
    wear = prepare("five_rings", "mdr", **COARSE).wear
    energy = np.diag([1.0] * 3 + [1e-18] * (len(wear._weights) - 3))
    with pytest.raises(SolverError, match="too early for double precision"):
        excited_modes(energy, wear._weights, wear._moments, 1e-16)
    later = RunningIn(wear.compliance, wear.wear_coefficients, earliest=0.1)
    with pytest.raises(SceneError, match=r"for sliding distances from 0\.1 on"):
        later.modal(np.array([0.0, 0.01]))


@pytest.mark.parametrize("ratio", [1e-6, 1e-12])
def test_slow_rings_do_not_change_early_times(ratio):
    """Rings that hardly wear relax far more slowly, but do not affect the others."""
    scene = Scene.load("five_rings").changed(
        methods=["mdr"], wear__times=[0.0, 1e-6, 1e-4], accuracy__rtol=1e-3
    )
    result, limit = (
        run(scene.changed(punch__wear_coefficients=[1.0, slow])).dataset.isel(solver=0)
        for slow in (ratio, 1e-14)
    )
    for name in ("indentation", "rms_slope", "ring_force"):
        # to within rtol
        np.testing.assert_allclose(result[name], limit[name], rtol=1e-3)


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
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-14)
    np.testing.assert_allclose(lower @ factor.forward(right[:, 0]), right[:, 0], atol=1e-14)
    np.testing.assert_allclose(lower.T @ factor.backward(right), right, atol=1e-14)
    # LAPACK's wrapper writes out of bounds if there are no columns
    assert factor.solve(np.empty((9, 0))).shape == (9, 0)
    with pytest.raises(SolverError, match="too extreme for double precision"):
        BandedCholesky(csr_matrix(matrix - 20 * np.eye(9)))


def test_results_with_different_numbers_of_modes_are_compared():
    times = np.array([1.0, 0.5, 0.25])
    three, two = (
        xarray.Dataset({"relaxation_time": ("mode", values)}) for values in (1.5 * times, times[:2])
    )
    compared = differences(three, two, Scene.load("five_rings").problem.face)
    np.testing.assert_array_equal(compared["relaxation_time"], [0.5, 0.5])


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize(
    ("edges", "wear"),
    [([1.0], [1.0]), ([0.5, 1.0], [1.0, 1.22]), ([0.2, 0.3, 1.0], [0.03, 1.0, 0.2])],
)
def test_reported_relaxation_times_are_as_accurate_as_stated(edges, wear, rtol):
    """The faster modes are reported only as far as the discretisation resolves them."""
    punch = {"radius": 1.0, "ring_edges": edges, "wear_coefficients": wear}
    scene = Scene.load("five_rings").changed(
        punch=punch, wear__times=[0.0, 0.01, 1.0], output__quantities=["history"]
    )

    def reported(tolerance):
        result = run(scene.changed(accuracy__rtol=tolerance), methods=["mdr"])
        data = result.dataset.sel(solver="mdr")
        return data.relaxation_time.values, data.relaxation_time_error.values

    times, stated = reported(rtol)
    count = int(np.isfinite(times).sum())
    assert count >= 8
    assert not np.isfinite(times[count:]).any()
    # at a rtol that is a thousand times smaller, more of them are resolved
    exact, errors = reported(max(rtol * 1e-3, 1e-9))
    known = np.isfinite(exact[:count])
    error = np.abs(times[:count] / exact[:count] - 1)[known]
    assert (error <= 1.5 * np.maximum(stated[:count], rtol)[known] + errors[:count][known]).all()
    assert stated[:count].max() <= 0.02 or count == 8


def test_the_anchor_resolves_modes_of_one_wide_ring():
    """Eight slow modes lie on the last ring, whose middle was one element of the small problem."""
    result = run(
        Scene.from_table(
            {
                "punch": {
                    "radius": 1.0,
                    "ring_edges": [0.3, 0.34, 0.39, 1.0],
                    "wear_coefficients": [0.0125, 1.0, 0.0125, 1.0],
                },
                "half_space": {"plane_strain_modulus": 1.0},
                "load": {"normal_force": 1.0},
                "wear": {"times": [0.0, 1.0]},
                "accuracy": {"rtol": 1.5e-6},
            }
        ),
        methods=["mdr"],
    )
    assert [anchor.name for anchor in result.anchors if not anchor.holds] == []
