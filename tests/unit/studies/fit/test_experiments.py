"""Models of measurements against balances, and synthetic experiments with known true values."""

from dataclasses import replace

import numpy as np
import pytest
from fit_experiments import WEAR, Experiments, cases

from ringwear import Scene, ring_areas
from ringwear.studies.estimate.estimator import Likelihood, fix_ineffective_parameters
from ringwear.studies.estimate.parameter import situation
from ringwear.studies.fit.parameters import find_parameters


def differences(model, x, steps):
    """Return central differences of each measurement, by steps of the coordinates."""
    ends = [(model.predict(x + shift), model.predict(x - shift)) for shift in np.diag(steps)]
    columns = [[(a - b) / 2 for a, b in zip(*pair, strict=True)] for pair in ends]
    return [np.column_stack(each) / steps for each in zip(*columns, strict=True)]


def test_worn_volumes_over_k_sum_to_the_work_of_the_load():
    """``sum V_i / k_i = int F ds``, also for a rising force and for any values of parameters."""
    load = {"normal_force": {"times": [0.0, 0.5, 1.0], "values": [1.0, 1.0, 2.0]}}
    table = Scene.load("five_rings").table() | {"load": load}
    case = Experiments(
        Scene.from_table(table),
        (WEAR,),
        tuple(("worn_volume", np.array([0.4, 2.0]), None, 0.01, ring) for ring in range(5)),
    )
    x = np.array([0.3, -0.5])
    volumes = np.array(case.sharp.predict(x))
    wear = np.resize(np.exp(x) * [1.0, 10.0], 5)
    assert volumes.T @ (1 / wear) == pytest.approx([0.4, 0.5 + 0.75 + 2.0], rel=1e-9)


def test_late_depths_depend_on_the_harmonic_mean_only():
    """Late depths depend on the wear coefficients only through ``w = F / sum(A / k)``."""
    case = cases()["two"]
    late = np.linspace(3.0, 5.0, 20)
    rates = replace(case, columns=(("indentation", late, None, 1e-3, None),))
    (slopes,) = differences(rates.sharp, np.zeros(2), np.full(2, 1e-4))
    growth = slopes[-1] - slopes[0]
    areas = ring_areas(Scene.load("five_rings").problem.ring_edges)
    shares = np.array([areas[::2].sum() / 1.0, areas[1::2].sum() / 10.0])
    rate = 2.0 / shares.sum()
    assert growth / 2.0 == pytest.approx(rate * shares / shares.sum(), rel=1e-3)


def test_offset_and_compliance_are_indistinguishable_under_one_force():
    names = (WEAR, "sensor_offset", "machine_compliance")
    rising = {"times": [0.3, 0.4], "values": [1.0, 2.0]}
    for force, combinations in ((2.0, [(2, 3)]), (rising, [])):
        scene = Scene.load("five_rings").changed({"load.normal_force": force})
        times = np.geomspace(0.001, 5.0, 12)
        case = Experiments(scene, names, (("indentation", times, None, 1e-3, None),))
        likelihood = Likelihood(case.sharp, case.sharp.parameters, (0, 1, 2, 3))
        assert fix_ineffective_parameters(likelihood)[1] == combinations


def test_a_table_of_wear_along_the_radius_is_fitted():
    table = {"radii": [0.0, 0.5, 1.0], "values": [1.0, 2.0, 4.0]}
    scene = Scene.load("flat_punch").table() | {"punch": {"radius": 1.0, "wear_coefficient": table}}
    radii = np.linspace(0.05, 0.95, 40)
    case = Experiments(
        Scene.from_table(scene),
        ("punch.wear_coefficient",),
        (
            ("indentation", np.geomspace(0.01, 5.0, 30), None, 1e-3, None),
            ("profile", np.full(40, 0.3), radii, 0.01, None),
        ),
    )
    truth, result = case.conduct(3)
    assert result.fits
    for each, true in zip(result.found, truth, strict=True):
        assert abs(each.best - true) < 1.5 * max(each.high - each.best, each.best - each.low)
    parameters = find_parameters(result.scene, case.names)[1]
    moved, _ = situation(result.scene, parameters, result.best.x)
    assert moved.punch.table.values == pytest.approx(result.estimates.value.tolist())


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "count", "least"), [("two", 25, 20), ("ball", 30, 25)])
def test_intervals_contain_the_true_values(name, count, least):
    """At least `least` of `count` 95 % intervals contain the true value, for fixed seeds.

    For correct intervals, the chance of fewer is 1 %.
    """
    case, counts = cases()[name], 0
    for seed in range(count):
        truth, result = case.conduct(seed)
        pairs = zip(result.found, truth, strict=True)
        counts = counts + np.array([each.low <= true <= each.high for each, true in pairs])
    assert min(counts) >= least


def test_interpolation_between_layers_is_at_the_load_of_the_same_time():
    """The force rises by 500 until t = 1, and the unit of time depends on the layer."""
    model = cases()["layer under a flat punch"].sharp
    assert model.interpolates
    for x in (np.array([0.13, -0.21]), np.array([-0.4, 0.3])):
        pairs = zip(model.predict(x), model.solved_directly().predict(x), strict=True)
        for interpolated, solved in pairs:
            assert interpolated == pytest.approx(solved, rel=1e-3)


@pytest.mark.slow
def test_a_flat_punch_does_not_determine_a_layer_by_two_forces():
    """Its indentation is proportional to the force: two forces have one compliance."""
    case = cases()["layer under a flat punch"]
    for seed in range(3):
        truth, result = case.conduct(seed)
        assert not any(each.identifiable for each in result.found)
        assert all(each.low <= true for each, true in zip(result.found, truth, strict=True))
    assert any("cannot be separated by these data" in line for line in result.conclusions)


@pytest.mark.slow
def test_a_wrong_wear_law_is_rejected():
    case = cases()["k falls"]
    for seed in range(5):
        _, result = case.conduct(seed)
        assert not result.fits
        assert any("THE MODEL DOES NOT FIT" in line for line in result.conclusions)
