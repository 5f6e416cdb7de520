"""The command `ringwear fit`, and the call: what they print, write and refuse."""

import numpy as np
import pandas as pd
import pytest
from groups import nightly

import ringwear
from ringwear import Scene

SCENE = Scene(
    title="a pin",
    units="SI",
    methods=["mdr"],
    punch={"radius": 0.005, "wear_coefficient": "1e-6 mm^3/(N m)"},
    half_space={"youngs_modulus": "2 GPa"},
    load={"normal_force": 100.0, "sliding_speed": 0.1},
    wear={"times": "running-in"},
)
TRUTH = 1.4e-15
NOISE = 1e-8


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Return a scene, and d(t) of a pin that wears 1.4 times as fast, in hours and um."""
    folder = tmp_path_factory.mktemp("measured")
    (folder / "pin.toml").write_text(SCENE.to_toml(), "utf-8")
    times = np.geomspace(60.0, 40_000.0, 30)
    wears = SCENE.changed(punch__wear_coefficient=TRUTH, wear__times=times.tolist())
    wears = wears.changed(output__quantities=["indentation"])
    depths = ringwear.run(wears).dataset.indentation.values[0]
    shown = depths + np.random.default_rng(2).normal(0.0, NOISE, len(times))
    table = pd.DataFrame({"time [h]": times / 3600, "Depth [um]": 1e6 * shown})
    table.to_csv(folder / "data.csv", index=False)
    return folder


def test_the_command_finds_a_wear_coefficient(measured, command, tmp_path):
    parameters = "punch.wear_coefficient,sensor_offset,machine_compliance"
    flags = f"--parameters {parameters} --noise '0.01 um' --out out"
    printed = command(f"fit {measured / 'pin.toml'} {measured / 'data.csv'} {flags}").out
    assert "punch.wear_coefficient = 1." in printed
    assert "mm³/(N m) (95 %: " in printed
    assert "sensor_offset and machine_compliance cannot be separated" in printed
    assert "the residuals do not contradict Archard's law" in printed
    files = {"estimates.csv", "residuals.csv", "tests.csv", "fit.png", "report.html"}
    assert files <= {file.name for file in (tmp_path / "out").iterdir()}
    estimates = pd.read_csv(tmp_path / "out" / "estimates.csv", index_col="parameter")
    row = estimates.loc["punch.wear_coefficient"]
    assert row.low < TRUTH < row.high
    assert row.identifiable
    assert not estimates.identifiable["sensor_offset"]
    assert np.isinf(estimates.high["machine_compliance"])


def test_the_result_displays_itself_in_print_and_in_a_notebook(measured, tmp_path):
    result = ringwear.fit(measured / "pin.toml", measured / "data.csv", "punch.wear_coefficient")
    # no noise was given, so it is estimated from the data
    noise = result.measurements[0].noise[0]
    assert noise == pytest.approx(NOISE, rel=0.4)
    assert repr(result).startswith("Fit of a pin\n")
    assert "estimated from the residuals" in repr(result)
    assert "+/-" in repr(result)
    page = result._repr_html_()
    assert "<table" in page
    assert "data:image/png;base64," in page
    assert "report.html" in result.save(tmp_path / "saved")


def test_the_report_has_the_correlations_of_the_fit(reference):
    data = pd.DataFrame(reference["states"])[["time", "indentation"]]
    result = ringwear.fit("five_rings", data, "punch.wear_coefficients", noise=1e-3)
    (shown,) = [line for line in result.report().splitlines() if line.strip().startswith("C(")]
    assert float(shown.partition("=")[2]) == pytest.approx(result.correlations.iloc[0, 1], abs=1e-4)


def test_the_report_has_the_standard_error_of_linear_regression():
    """Worn volumes are proportional to k, so that k and its errors are those of a weighted mean."""
    times = np.array([1e3, 2e3, 4e3, 7e3, 9e3])
    worn = 1.4e-15 * 100.0 * 0.1 * times * (1 + 0.02 * np.array([1.0, -0.5, 0.3, -1.2, 0.8]))
    data = pd.DataFrame({"time": times, "worn_volume": worn})
    result = ringwear.fit(SCENE, data, "punch.wear_coefficient", noise="2 %")
    ratios, weights = worn / (10.0 * times), (times / worn) ** 2
    exact = np.average(ratios, weights=weights)
    error = 0.02 / np.sqrt((weights * 100.0).sum())
    (row,) = result.estimates.itertuples()
    assert (row.value, row.stderr) == (pytest.approx(exact), pytest.approx(error, rel=1e-4))
    squares = ((ratios / exact - 1) ** 2 * weights * (10.0 * exact) ** 2).sum() / 0.02**2
    (shown,) = [line for line in result.report().splitlines() if "reduced chi-square" in line]
    assert float(shown.partition("=")[2]) == pytest.approx(squares / 4, rel=1e-4)
    lines = [line.split() for line in result.report().splitlines()]
    (shown,) = [line for line in lines if line[0] == "punch.wear_coefficient:" and "+/-" in line]
    assert float(shown[1]) == pytest.approx(exact)
    assert float(shown[3]) == pytest.approx(error, rel=1e-4)
    assert f"{row.low:.7g} to {row.high:.7g}" in result.report()


@pytest.mark.parametrize("count", [5, *nightly(7, 9, 30)])
@pytest.mark.parametrize("noise", ["", *nightly("--noise '1 %'")])
def test_few_values_are_tested_against_archards_law(measured, command, tmp_path, count, noise):
    """The worn volume is k F v t; one that grows faster than the time contradicts the law."""
    times = np.geomspace(60.0, 40_000.0, count)
    volumes = TRUTH * 100.0 * 0.1 * times
    for faster, status in ((0.0, 0), (0.5, 3)):
        worn = volumes * (1 + faster * times / times[-1])
        table = pd.DataFrame({"time": times, "worn_volume": worn})
        table.to_csv("data.csv", index=False)
        flags = f"--parameters punch.wear_coefficient --out out {noise}"
        printed = command(f"fit {measured / 'pin.toml'} data.csv {flags}", status).out
        assert ("THE MODEL DOES NOT FIT" in printed) == bool(faster)
        if not faster:
            estimates = pd.read_csv(tmp_path / "out" / "estimates.csv")
            assert estimates.value[0] == pytest.approx(TRUTH, rel=1e-6)


def test_too_few_values_for_any_test_are_reported(measured):
    weighed = pd.DataFrame({"time": [1e3, 5e3, 9e3], "worn_volume": [1.4e-11, 7e-11, 1.26e-10]})
    result = ringwear.fit(measured / "pin.toml", weighed, "punch.wear_coefficient")
    assert result.fits
    (line,) = [line for line in result.conclusions if "cannot be tested" in line]
    assert "measure more, or give the noise" in line


@pytest.mark.parametrize(
    ("data", "options", "words"),
    [
        ("time,indentation\n1,1e-6\n2,2e-6\n", "", "too few values, 2, to estimate the noise"),
        ("time,lost_mass\n1,1e-6\n2,2e-6\n", "--noise '1 mg'", "give --density"),
        ("time,radius,pressure\n1,0,1e6\n", "", "nothing to fit"),
        ("time,indentation\n1,1e-6\n2,2e-6\n", "--noise profile=1", "no such column"),
    ],
)
def test_wrong_data_and_options_are_refused_in_one_line(
    measured, command, tmp_path, data, options, words
):
    (tmp_path / "data.csv").write_text(data, "utf-8")
    flags = f"--parameters punch.wear_coefficient --out out {options}"
    assert words in command(f"fit {measured / 'pin.toml'} data.csv {flags}", 2).err
    assert not (tmp_path / "out").exists()


def test_a_parameter_without_effect_is_named_in_plain_words(measured):
    """Worn volumes do not depend on the zero of the displacement sensor."""
    weighed = pd.DataFrame({"time": [1e3, 5e3, 9e3], "worn_volume": [1e-12, 5e-12, 9e-12]})
    parameters = ["punch.wear_coefficient", "sensor_offset"]
    conclusions = ringwear.fit(measured / "pin.toml", weighed, parameters, "2 %").conclusions
    (line,) = [line for line in conclusions if line.startswith("sensor_offset")]
    assert "it has no effect on any of the measured quantities" in line


@pytest.mark.slow
def test_a_ball_determines_a_layer_by_two_forces():
    """The contact is as wide as the layer is thick under one of them. Data by boundary elements."""
    layer = {"thickness": 0.3, "youngs_modulus": 1.0, "poisson_ratio": 0.3}
    scene = ringwear.Scene(
        punch={
            "radius": 1.0,
            "profile": {"kind": "ball", "ball_radius": 5.0},
            "wear_coefficient": 1e-9,
        },
        half_space={"youngs_modulus": 2.0, "poisson_ratio": 0.3, "layers": [layer]},
        load={"normal_force": {"times": [0.0, 1.0], "values": [3e-4, 0.15]}, "sliding_speed": 1.0},
        wear={"times": [0.0, 1.0], "steady": False},
    )
    names = ["half_space.layers[0].thickness", "half_space.layers[0].youngs_modulus"]
    truth = dict(zip(names, (0.33, 0.9), strict=True))
    data = ringwear.run(scene.changed(truth), methods=["bem"], quantities=["indentation"]).dataset
    table = {"time": [0.0, 1.0], "indentation": data.indentation.values[0]}
    found = ringwear.fit(scene, table, names, noise="0.3 %").estimates
    assert found.identifiable.all()
    for name, row in found.iterrows():
        assert row.low < truth[name] < row.high
        assert row.value == pytest.approx(truth[name], rel=0.02)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("half_space.layers[1].thickness", "layers\\[0\\].thickness"),
        ("half_space.layers[0].poisson_ratio", "only wear coefficients, moduli, layers"),
        ("half_space.layers", "layers\\[0\\].youngs_modulus"),
    ],
)
def test_what_no_layer_has_is_refused(name, words):
    layer = {"thickness": 0.3, "youngs_modulus": 0.25, "poisson_ratio": 0.3}
    scene = ringwear.Scene.load("five_rings").changed(
        half_space={"youngs_modulus": 1.0, "poisson_ratio": 0.3, "layers": [layer]}
    )
    with pytest.raises(ringwear.SceneError, match=words):
        ringwear.fit(scene, {"time": [1.0], "indentation": [1.0]}, name, noise=0.1)
