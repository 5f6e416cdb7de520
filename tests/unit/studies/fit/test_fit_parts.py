"""The parts of a fit: parameters, measurements, likelihood, profiles, tests of residuals."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import linregress

from ringwear import Scene, SceneError
from ringwear.studies.estimate.estimator import Likelihood, fix_ineffective_parameters
from ringwear.studies.estimate.measurement import Measurement
from ringwear.studies.estimate.model import STENCIL, lagrange
from ringwear.studies.estimate.parameter import Parameter, situation
from ringwear.studies.estimate.profiles import Profiles
from ringwear.studies.fit import residual_tests
from ringwear.studies.fit.data import read_measurements
from ringwear.studies.fit.parameters import find_parameters
from ringwear.studies.fit.residual_tests import combined, small_differences
from ringwear.studies.fit.result import Estimate
from ringwear.studies.fit.words import _bounds

SCENE = Scene(
    units="SI",
    punch={"radius": 0.01, "rings": 3, "wear_coefficient": 1e-15, "wear_ratio": 5.0},
    half_space={"youngs_modulus": 2e9},
    load={"normal_force": {"times": [0.0, 10.0], "values": [50.0, 100.0]}},
    wear={"times": [0.0, 10.0]},
)


class Formula:
    """Model whose predictions are a formula of the coordinates x."""

    rtol = 0.0

    def __init__(self, formula, values, noise=0.1):
        self.formula = formula
        count = len(values)
        given = np.arange(1.0, count + 1), np.asarray(values, dtype=float), np.full(count, noise)
        self.measurements = (Measurement("indentation", "indentation", *given, True),)

    def predict(self, x):
        return [np.asarray(self.formula(x), dtype=float)]


def likelihood_of(model, count):
    free = tuple(Parameter(f"punch.wear_coefficients[{n}]", None) for n in range(count))
    return Likelihood(model, free, tuple(range(count)))


def test_the_key_of_a_list_means_all_of_its_values():
    scene, parameters = find_parameters(SCENE, ["punch.wear_coefficients", "load.normal_force"])
    names = [each.name for each in parameters]
    assert names == [
        "punch.wear_coefficients[0]",
        "punch.wear_coefficients[1]",
        "load.normal_force.values[0]",
        "load.normal_force.values[1]",
    ]
    moved = situation(scene, parameters, np.array([0.0, np.log(2.0), 0.0, np.log(3.0)]))[0]
    assert moved.punch.wear_coefficients == pytest.approx([1e-15, 1e-14])
    assert moved.load_.load_over_time.values == pytest.approx([50.0, 300.0])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("punch.wear_coeficient", "did you mean punch.wear_coefficient?"),
        ("punch.wear_coefficients[2]", "has 2 values, counted from 0"),
        ("punch.radius", "only wear coefficients, moduli, layers, loads and unknowns of the rig"),
        ("punch.rings", "punch.rings cannot be fitted, only wear coefficients"),
        ("load.mean_pressure", "the scene does not have it"),
        ("half_space.youngs_modulus[0]", "is one number in the scene: leave out the index"),
        ("punch.wear_coefficients,punch.wear_ratio", "describe the same"),
        ("start_time,start_time", "given twice"),
    ],
)
def test_parameters_that_cannot_be_fitted_are_refused(name, words):
    with pytest.raises(SceneError, match=words.replace("?", r"\?")):
        find_parameters(SCENE, name.split(","))


def test_every_parameter_that_is_listed_can_be_fitted():
    """The list contains a sliding speed that the scene leaves at 1, and the ratio of two values."""
    pair = SCENE.changed({"punch.wear_coefficients": [1e-15, 5e-15]})
    for scene in (SCENE, pair):
        with pytest.raises(SceneError) as refusal:
            find_parameters(scene, ["punch.rings"])
        names = str(refusal.value).rpartition("fit some of ")[2].split(", ")
        assert {"load.sliding_speed", "punch.wear_ratio", "start_time"} <= set(names)
        for name in names:
            _, parameters = find_parameters(scene, [name])
            assert parameters[0].name.startswith(name)
    _, (speed,) = find_parameters(SCENE, ["load.sliding_speed"])
    assert speed.value == 1.0
    changed, (ratio,) = find_parameters(pair, ["punch.wear_ratio"])
    assert ratio.value == pytest.approx(5.0)
    assert changed.punch.coefficients == pytest.approx([1e-15, 5e-15])
    assert situation(changed, [ratio], np.array([np.log(2.0)]))[
        0
    ].punch.wear_ratio == pytest.approx(10)


def test_a_ratio_needs_two_materials():
    single = SCENE.changed({"punch.wear_coefficients": [1e-15, 5e-15, 2e-15]})
    with pytest.raises(SceneError, match=r"fit punch\.wear_coefficients$"):
        find_parameters(single, ["punch.wear_ratio"])


SERIES = {"time": np.arange(9.0), "indentation": np.arange(9.0)}


@pytest.mark.parametrize(
    "tables",
    [
        {"a": SERIES, "b": SERIES},
        {"a": SERIES, "b": {"time": np.arange(9.0)[::-1], "indentation": np.arange(9.0)[::-1]}},
        {"a": SERIES, "b": SERIES | {"normal_force": np.arange(9.0)}},
        {"a": SERIES, "b": {"time": np.arange(9.0), "indentation [mm]": 1e3 * np.arange(9.0)}},
        {"a": {"time": [5.0], "worn_volume": [2.0]}, "b": {"time": [5.0], "worn_volume": [2.0]}},
    ],
)
def test_a_table_that_is_given_twice_is_refused(tables):
    frames = {name: pd.DataFrame(columns) for name, columns in tables.items()}
    with pytest.raises(SceneError, match=r"a and b have the same .* would count twice"):
        read_measurements(SCENE, frames, {"indentation": 1e-3, "worn_volume": 1e-3})


def test_different_measurements_of_one_quantity_are_accepted():
    again = SERIES | {"indentation": np.arange(9.0) + 0.1}
    frames = {"a": pd.DataFrame(SERIES), "b": pd.DataFrame(again)}
    assert len(read_measurements(SCENE, frames)) == 2


def test_lost_mass_is_volume_times_density():
    table = pd.DataFrame({"time [s]": [0.0, 5.0, 10.0], "lost_mass_2 [mg]": [0.0, 1.0, 3.0]})
    (measurement,) = read_measurements(SCENE, table, {"lost_mass": "0.1 mg"}, "8 g/cm^3")
    assert (measurement.quantity, measurement.ring) == ("worn_volume", 1)
    # 1 mg of 8 mg/mm^3
    assert measurement.values == pytest.approx([0.125e-9, 0.375e-9])
    assert measurement.noise == pytest.approx(0.0125e-9)
    assert measurement.times.tolist() == [5.0, 10.0]


@pytest.mark.parametrize(
    ("noise", "density", "words"),
    [
        (None, None, "needs a density"),
        ("1 mg", "8", "give a noise for each"),
        ({"profile": 1.0}, "8", "no such column"),
        ({"lost_mass": "0 %"}, "8", "above 0"),
    ],
)
def test_incomplete_measurements_are_refused_with_a_reason(noise, density, words):
    table = pd.DataFrame({"time": np.arange(9.0), "lost_mass": 1e-9, "indentation": np.arange(9.0)})
    with pytest.raises(SceneError, match=words):
        read_measurements(SCENE, table, noise, density)


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"time": [1.0], "mass": [1.0]}, "worn_volume, lost_mass, each once, by --columns mass=lo"),
        ({"time": [1.0], "worn_volume_4": [1.0]}, "give worn_volume_1 to worn_volume_3"),
        ({"time": [1.0], "lost_mass_0": [1.0]}, "numbered from 1 at the centre to 3"),
        ({"time": [0.0], "worn_volume": [0.0]}, "given only at the start: give later times"),
        ({"time": [1.0, 2.0], "worn_volume": [-1.0, -2.0]}, "as positive numbers"),
    ],
)
def test_columns_that_cannot_be_fitted_are_refused_with_the_remedy(columns, words):
    with pytest.raises(SceneError, match=words):
        read_measurements(SCENE, pd.DataFrame(columns))


def test_a_cubic_is_interpolated_exactly():
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0])
    for place in (0.0, 0.37, 1.0):
        assert np.dot(lagrange(place), cubic(STENCIL)) == pytest.approx(cubic(place))


def test_a_straight_model_has_the_intervals_of_linear_regression():
    design = np.column_stack([np.ones(6), np.arange(6.0)])
    values = np.array([0.1, 1.2, 1.9, 3.1, 3.9, 5.2])
    likelihood = likelihood_of(Formula(lambda x: design @ x, values), 2)
    best = likelihood.best_from(np.zeros(2))
    exact = np.linalg.lstsq(design, values, rcond=None)[0]
    assert best.x == pytest.approx(exact, abs=1e-7)
    covariance = 0.01 * np.linalg.inv(design.T @ design)
    assert likelihood.covariance(best.x) == pytest.approx(covariance)
    profiles = Profiles(likelihood, best, covariance, 1.96**2)
    for number, (low, high) in profiles.intervals([0, 1]).items():
        half = 1.96 * np.sqrt(covariance[number, number])
        assert (high - low) / 2 == pytest.approx(half, rel=0.02)


def test_an_interval_includes_every_minimum():
    """The data x^2 = 1 +- 0.1 / sqrt(4) are explained by both signs of x."""
    model = Formula(lambda x: x[0] ** 2 * np.ones(4), [1.0] * 4)
    likelihood = likelihood_of(model, 1)
    ends = [likelihood.best_from(np.array([start])) for start in (0.5, -0.5)]
    best, other = ends
    profiles = Profiles(likelihood, best, likelihood.covariance(best.x), 1.96**2, [other])
    low, high = profiles.intervals([0])[0]
    assert (low, high) == pytest.approx((-np.sqrt(1.098), np.sqrt(1.098)), rel=5e-3)


def test_an_unbounded_parameter_has_an_infinite_interval():
    """The datum exp(-x) = 0 +- 0.1 is explained by any large x."""
    model = Formula(lambda x: np.exp(-x), [0.0])
    likelihood = likelihood_of(model, 1)
    best = likelihood.best_from(np.array([3.0]))
    profiles = Profiles(likelihood, best, likelihood.covariance(best.x), 1.96**2)
    low, high = profiles.intervals([0])[0]
    assert np.isinf(high)
    # ends of wide intervals are located with a tolerance of 0.1 in the square root of the rise
    assert low == pytest.approx(-np.log(0.196), abs=0.1)


@pytest.mark.parametrize(
    ("low", "best", "high", "words"),
    [
        (-1.0, 0.0, 1.0, "it lies between 0.3679 and 2.718 (95 %)"),
        (-1.0, 0.0, np.inf, "at least 0.3679 (97.5 %), and the data give no upper bound"),
        (-np.inf, 0.0, 1.0, "at most 2.718 (97.5 %), and the data give no lower bound"),
        (-np.inf, 0.0, np.inf, "the data allow every value"),
        (1.0, 0.0, 2.0, "check the units of the data"),
    ],
)
def test_bounds_of_what_is_not_identifiable_are_told(low, best, high, words):
    estimate = Estimate(Parameter("k", "k", 1.0), best, low, high, 1.0, 0.0, True)
    assert not estimate.identifiable
    ends = (f"{end:.4g}" for end in estimate.ends)
    assert words in _bounds(estimate, *ends)


def test_combinations_without_effect_are_named_and_one_of_each_is_fixed():
    design = np.column_stack([np.arange(5.0), np.ones(5), 2 * np.ones(5), np.zeros(5)])
    model = Formula(lambda x: design @ x, np.arange(5.0))
    likelihood, combinations = fix_ineffective_parameters(likelihood_of(model, 4))
    assert sorted(map(sorted, combinations)) == [[1, 2], [3]]
    assert likelihood.free == (0, 1)


def test_residuals_that_are_alike_are_detected_but_noise_is_not():
    random = np.random.default_rng(5)
    noise = random.normal(size=(400, 40))
    alarms = np.mean([small_differences(series) < 0.05 for series in noise])
    # 2.5 standard deviations of the rate of false alarms in 400 series
    assert 0.01 < alarms < 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / 400)
    waves = noise + 3 * np.sin(np.linspace(0, 4 * np.pi, 40))
    assert np.mean([small_differences(series) < 0.05 for series in waves]) > 0.9


def test_no_test_rejects_nothing():
    assert combined({}) == 1.0
    assert combined({"one": 0.2}) == 0.2
    assert combined({"one": 0.2, "other": 0.01}) == pytest.approx(0.02)


def test_noise_in_the_offset_of_a_profile_is_projected_out():
    model = Formula(lambda x: 0 * x[0] * np.ones(5), np.full(5, 7.0))
    (measured,) = model.measurements
    model.measurements = (replace(measured, quantity="profile", radii=np.arange(5.0)),)
    likelihood = likelihood_of(model, 1)
    assert likelihood.residuals(np.zeros(1)) == pytest.approx(np.zeros(5), abs=1e-12)
    assert likelihood.degrees_of_freedom == 3


def test_a_drift_is_tested_as_the_slope_of_a_regression():
    times, values = np.arange(6.0), np.array([2.0, 3.0, 1.0, 5.0, 4.0, 6.0])
    centred = times - times.mean()
    score = values @ centred / np.linalg.norm(centred)
    # the mean of the values is the only parameter
    likelihood = SimpleNamespace(
        measurements=[SimpleNamespace(noise_known=False)], degrees_of_freedom=5
    )
    found = residual_tests._probability_of_score(likelihood, values - values.mean(), score)
    assert found == pytest.approx(linregress(times, values).pvalue)
