"""Fits of wear coefficients against closed forms and an independent history."""

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, fit, run

WEAR = "punch.wear_coefficients"


def test_wear_coefficients_of_an_independent_history_are_found(reference):
    """The independent history of the five rings has k = 1 and 10; fits begin at 1.5 and 6."""
    states = reference["states"]
    times = [state["time"] for state in states if state["time"] > 0]
    depths = [state["indentation"] for state in states if state["time"] > 0]
    data = pd.DataFrame({"time": times, "indentation": depths})
    scene = Scene.load("five_rings").changed({WEAR: [1.5, 6.0]})
    result = fit(scene, data, WEAR, noise=1e-6)
    assert result.estimates.value.tolist() == pytest.approx([1.0, 10.0], rel=1e-4)
    # the numerical error is at most a tenth of the noise
    assert result.model_error <= 0.1
    assert result.degrees_of_freedom == len(times) - 2


@pytest.mark.slow
def test_a_brake_that_is_applied_and_released_is_fitted():
    """Data come from a run of a load that bends and falls between the times of the data."""
    scene = Scene.load("duty_cycle")
    times = np.array(scene.wear.times[1:])
    truth = scene.changed({WEAR: [1.3e-15, 5e-15], "accuracy.rtol": 1e-3})
    result = run(truth.changed(output__quantities=["indentation"]), methods=["mdr"])
    depths = result.dataset.indentation.sel(time=times).values[0]
    noise = 2e-3 * float(depths.max())
    data = pd.DataFrame({"time": times, "indentation": depths})
    fit_result = fit(scene, data, f"{WEAR}[0]", noise=noise)
    assert fit_result.chi_square < 1.0
    row = fit_result.estimates.iloc[0]
    assert row.low < 1.3e-15 < row.high


@pytest.mark.slow
def test_the_scale_of_wear_is_not_known_if_force_and_modulus_are_free(reference):
    """Only k F and E / F follow from depths: no interval may be given for a mean of k."""
    data = pd.DataFrame(reference["states"])[["time", "indentation"]]
    scene = Scene.load("five_rings").changed(load__normal_force=4.0)
    names = [WEAR, "half_space.plane_strain_modulus", "load.normal_force"]
    result = fit(scene, data, names, noise=1e-3)
    assert not result.estimates.identifiable.any()
    assert not any("harmonic mean" in line for line in result.conclusions)
    sentence = f"load.normal_force is held at {result.estimates.value['load.normal_force']:.4g}"
    assert any(sentence in line for line in result.conclusions)


def test_data_in_other_units_have_no_interval(reference):
    data = pd.DataFrame(reference["states"])[["time", "indentation"]]
    data["indentation"] *= 1e6
    result = fit("five_rings", data, [WEAR])
    assert not result.estimates.identifiable.any()


def test_equal_values_have_no_noise():
    data = pd.DataFrame({"time": np.linspace(0.1, 1.0, 10), "indentation": 1.0})
    with pytest.raises(SceneError, match="give --noise indentation"):
        fit("five_rings", data, [WEAR])
