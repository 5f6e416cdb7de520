"""Sweeps: the file, the grid, shared work, and equality of every scene with `run`."""

import json
import os
import tomllib
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import tomli_w
import xarray
from matplotlib.figure import Figure

from ringwear import Rings, Scene, SceneError, direct, run, sweep

FIVE = Scene.load("five_rings").changed(
    methods=["mdr", "direct"], accuracy__rtol=1e-3, wear__times=[0.0, 0.01, 0.3]
)
ANSWERS = ["worn_volume", "force_share", "running_in_time", "time_to_90", "time_to_99"]
RATIOS = {"punch.wear_ratio": [0.1, 1.0, 20.0]}


def quantities_of(dataset):
    """Return the names of all variables that have error estimates."""
    return [str(name) for name in dataset if f"{name}_error" in dataset]


@pytest.fixture(scope="module")
def small():
    """Keep all quantities of a sweep by default, and the answers."""
    axes = RATIOS | {"punch.rings": [2, 5], "load.normal_force": [1.0, 3.0]}
    by_default = quantities_of(sweep(FIVE, {"punch.rings": [2]}))
    assert {"indentation", "steady_wear_rate"} < {*by_default}
    return sweep(FIVE, axes, keep=[*by_default, *ANSWERS])


@pytest.mark.parametrize(
    ("ratio", "rings", "force"), [(0.1, 5, 3.0), (20.0, 2, 1.0), (1.0, 5, 1.0)]
)
def test_scenes_are_those_of_run(small, ratio, rings, force):
    """A scene of a sweep and the same scene by `run` differ by at most their error estimates."""
    scene = FIVE.changed(
        punch__wear_coefficients=[1.0, ratio], punch__rings=rings, load__normal_force=force
    )
    alone = run(scene).dataset.isel(mode=slice(3))
    there = small.sel(wear_ratio=ratio, rings=rings, normal_force=force)
    there = there.isel(mode=slice(3), ring=slice(rings))
    assert there["status"] == 1
    for name in {*quantities_of(small)} - {*ANSWERS}:
        value, other = there[name].values, alone[name].values
        np.testing.assert_array_equal(np.isfinite(value), np.isfinite(other))
        errors = (each[f"{name}_error"].values for each in (there, alone))
        stated = np.maximum(sum(errors), 1e-12)
        assert (np.abs(value - other) <= stated * np.abs(value))[np.isfinite(value)].all(), name
    for name in ANSWERS:
        assert there[name].dims == alone[name].dims
        assert there[name].notnull().any()
        np.testing.assert_allclose(there[name], alone[name], rtol=1e-3, err_msg=name)


def test_loads_share_modes(small):
    assert small["indentation"].dims == ("wear_ratio", "rings", "normal_force", "solver", "time")
    assert (small["status"] == 1).all()
    # the two methods differ by less than their error estimates
    assert small["disagreement"].max() < 1
    light, heavy = small.sel(normal_force=1.0), small.sel(normal_force=3.0)
    np.testing.assert_array_equal(light["relaxation_time"], heavy["relaxation_time"])
    np.testing.assert_allclose(heavy["indentation"], 3 * light["indentation"], rtol=1e-14)


@pytest.mark.parametrize("number", [6, 7])
def test_sweeps_of_the_paper_equal_closed_forms(number):
    """The bundled sweeps are computed for fewer rings and every tenth ratio."""
    file = Path(__file__).parents[2] / "studies" / "sweep" / "files" / f"fig{number}.toml"
    table = tomllib.loads(file.read_text("utf-8"))
    between = np.linspace(-1, 1, 201)
    varied, points = [
        ("punch.wear_ratio", 10.0 ** (4 * between)),
        ("punch.width_ratio", 10.0**between),
    ][number - 6]
    values = np.geomspace(*table["axes"][varied]["geomspace"])
    np.testing.assert_allclose(values, points, rtol=1e-13)
    axes = table["axes"] | {"punch.rings": [2, 8], varied: values[::10]}
    slopes = sweep(table["base"], axes, keep=table["keep"])["steady_rms_slope"].sel(solver="direct")
    for count, place in product((2, 8), range(0, 201, 10)):
        width, ratio = (1.0, points[place]) if number == 6 else (points[place], 0.01)
        rings = Rings.alternating(count, width, ratio)
        pressures = np.pi * direct.steady_pressures(rings.ring_edges, rings.wear_coefficients[0])
        for average in ("line", "area"):
            exact = direct.rms_slope(rings.ring_edges, pressures, average)
            slope = slopes.sel(rings=count, gradient_average=average)[place // 10]
            assert float(slope) == pytest.approx(exact, rel=1e-12)


def test_a_failed_scene_does_not_affect_others():
    """Its reason is stored with it.

    Scenes that would share its discretisation have the results that they have without it.
    """
    # the second step would need so many steps that the march is refused
    marched = FIVE.changed(methods=["mdr"], wear__march="implicit", wear__step=0.01)
    steps = {"wear.step": [0.01, 1e-9, 0.05]}
    dataset = sweep(marched, steps, keep=["indentation"])
    assert dataset["status"].values.tolist() == [1, 2, 1]
    assert "give a larger wear.step" in str(dataset["reason"].values[1])
    assert np.isnan(dataset["indentation"].values[1]).all()
    alone = sweep(marched, {"wear.step": [0.01]}, keep=["indentation"])
    np.testing.assert_allclose(dataset["indentation"][0], alone["indentation"][0], rtol=1e-12)
    zipped = {
        "punch.ring_edges": [[0.5, 1.0], [0.4, 0.7, 1.0]],
        "punch.wear_coefficients": [[1.0, 2.0], [1.0] * 4],
    }
    with pytest.raises(SceneError, match="wear_coefficients has 4 values for 3 rings"):
        sweep(FIVE, zip=zipped)


GOOD = "base = 'five_rings'\nkeep = ['steady_rms_slope']\n[axes]\n'punch.rings' = [2, 3]"


SPHERE, HEAD = GOOD.replace("five_rings", "sphere"), GOOD.partition("[axes]")[0]
TIMES = "'punch.rings' = [2, 3]", "'wear.times' = [[0.1], [0.2]]"
FORCES = "[axes]\n'load.normal_force' = [1.0, 2.0]\n"
DRAWN = "[random]\n'load.normal_force' = [1.0]\n"
BILLIONS = "2000000000"
# the text of a sweep file, and words of the line that states what to write
REFUSED = [
    ("base = ", "TOML"),
    ("", "nothing varies"),
    ("axes = {'punch.rings' = [2]}", "missing key base"),
    (GOOD.replace("five", "six"), "six_rings"),
    (GOOD.replace("keep", "keeps"), "keeps"),
    (GOOD.replace("punch.rings", "punch.ring"), "did you mean rings"),
    (GOOD.replace("3", "2.5"), "punch.rings = 2.5"),
    (GOOD.replace("[2, 3]", "{ logspace = [1, 2, 3] }"), "geomspace"),
    (GOOD.replace("[2, 3]", "{ linspace = [1, 2] }"), "linspace"),
    (GOOD.replace("steady_rms_slope", "slope"), "slope"),
    (GOOD.replace("steady_rms_slope", "worn_volum', 'x"), "keep has 'worn_volum', 'x', no quantit"),
    (GOOD.replace("steady_rms_slope", "worn_volum"), "did you mean 'worn_volume'?"),
    (GOOD.replace("['steady_rms_slope']", "'rms_slope'"), "a list of"),
    (GOOD.replace("steady_rms_slope", "profile"), "output.radii"),
    (SPHERE.replace("steady_rms_slope", "relaxation_time"), "no quantities of these scenes"),
    (SPHERE.replace("'punch.rings' = [2", "'load.indentation' = [-1.0"), "load.indentation = -1"),
    (GOOD.replace("steady_rms_slope", "indentation").replace(*TIMES), "wear.times"),
    (GOOD.replace("axes", "zip") + "\n'punch.width_ratio' = [1.0]", "one length"),
    (GOOD.replace("axes", "random"), "random.count"),
    (GOOD.replace("axes", "random") + "\ncount = 2\nseed = 1\n'title' = []", "title"),
    (GOOD + "\nmethods = [['mdr'], ['direct']]", "same methods"),
    (HEAD + DRAWN + "count = 3\nseed = -1", "random.seed = -1: give"),
    (HEAD + DRAWN + "count = -3\nseed = 1", "random.count = -3 and"),
    (HEAD + DRAWN + "count = 3", "random.seed = None: give"),
    (HEAD + DRAWN + f"seed = 1\ncount = 0x{5000 * '9'}", "a number of thousands of digits values"),
    (HEAD + DRAWN + f"seed = 1\ncount = {BILLIONS}", f"{BILLIONS} values"),
    (GOOD.replace("[2, 3]", f"{5000 * '['}1.0{5000 * ']'}"), "nested too deeply; give those"),
    (GOOD.replace("punch.rings", f"punch{5000 * '.a'}"), "nested too deeply; give those"),
    (GOOD.replace("[2, 3]", f"[{5000 * '9'}]"), "a number has thousands of digits; give numbers"),
    (HEAD + FORCES + DRAWN + "count = 2\nseed = 1", "given twice, in [axes] and in [random]"),
    (HEAD + FORCES + FORCES.replace("axes", "zip"), "is given twice, in [axes] and in [zip]"),
    (GOOD.replace("3", "2"), "punch.rings has 2 twice"),
    (GOOD.replace("[2, 3]", f"{{ linspace = [1, 2, {BILLIONS}] }}"), f"{BILLIONS} values"),
    (
        HEAD
        + "[axes]\n'load.normal_force' = { linspace = [1, 2, 100_000] }\n"
        + "'punch.wear_ratio' = { linspace = [1, 2, 100_000] }",
        "10000000000 scenes",
    ),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_a_bad_sweep_file_is_refused(command, text, message):
    """One line states the reason, and nothing is written."""
    Path("bad.toml").write_text(text)
    for option in ("--dry-run", "--workers=1"):
        (line,) = command(f"sweep bad.toml {option}", 2).err.splitlines()
        assert message in line
        # long values are shortened; names of all quantities are not
        assert len(line) < 900
    assert os.listdir() == ["bad.toml"]


def test_values_that_are_equal_in_the_units_of_the_scene_are_refused():
    with pytest.raises(SceneError, match=r"punch\.radius has 0\.02 twice"):
        sweep(FIVE.changed(units="SI", punch__radius=0.02), {"punch.radius": ["20 mm", 0.02]})


@pytest.mark.parametrize("times", ["running-in", {"tau": [0.1, 1.0]}], ids=str)
def test_times_that_differ_between_scenes_are_refused(times):
    """Multiples of the relaxation time are other times for each punch.

    The times of the first scene must not label the histories of the others.
    """
    scene = FIVE.changed(methods=["mdr"], wear__times=times)
    for keep in (None, ["indentation"], ["steady_rms_slope", "worn_volume"]):
        with pytest.raises(
            SceneError, match=r"punch.wear_ratio = 1.0: .* give the base wear.times as numbers"
        ):
            sweep(scene, RATIOS, keep=keep)
    # quantities that are not over time, and histories of one punch under other loads, are allowed
    assert (sweep(scene, RATIOS, keep=["relaxation_time", "time_to_90"])["status"] == 1).all()
    loads = sweep(scene, {"load.normal_force": [1.0, 2.0]}, keep=["indentation"])
    assert loads["time"].values.tolist() == scene.wear.times


@pytest.mark.slow
def test_axes_crossed_zipped_and_drawn(tmp_path):
    """Every varied key is a coordinate, also in an opened store, and has the unit of its kind."""
    scene = FIVE.changed(units="mm, N, MPa, hours", methods=["direct", "mdr"])
    axes = {"accuracy.rtol": [1e-2, 1e-3], "punch.radius": [1.0]}
    zipped = {
        "punch.rings": {"linspace": [2, 3, 2]},
        "punch.wear_coefficients": [[1.0, 2.0], [1.0, 3.0]],
    }
    draws = {
        "count": 3,
        "seed": 1,
        "load.normal_force": [1.0, 2.0],
        "load.sliding_speed": {"linspace": [1.0, 2.0]},
    }
    keep = ["indentation", "steady_wear_rate", "worn_volume", "steady_rms_slope"]
    sweep(scene, axes, tmp_path, keep=keep, zip=zipped, random=draws)
    dataset = xarray.open_zarr(tmp_path / "sweep.zarr", decode_timedelta=False)
    # `radius` is a dimension of results already
    grid = ("rtol", "punch_radius", "rings", "draw")
    assert dataset["steady_rms_slope"].dims == (*grid, "solver")
    assert dataset["status"].dims == grid
    assert dataset["normal_force"].dims == dataset["sliding_speed"].dims == ("draw",)
    units = {
        "indentation": "mm",
        "indentation_error": "1",
        "steady_wear_rate": "mm/hours",
        "worn_volume": "mm^3",
        "steady_rms_slope": "1",
        "time": "hours",
        "wear_coefficients": "1/MPa",
        "normal_force": "N",
        "sliding_speed": "mm/hours",
    }
    assert {name: dataset[name].attrs["units"] for name in units} == units
    assert set(dataset["normal_force"].values) <= {1.0, 2.0}
    assert (dataset["sliding_speed"] > 1).all()
    assert (dataset["sliding_speed"] < 2).all()
    # the table in the store gives the same scenes
    table = json.loads(dataset.attrs["sweep"])
    again = sweep(table.pop("base"), **table)
    xarray.testing.assert_equal(again, dataset.load())
    # the last scene, as it is run alone
    last = dataset.isel(rtol=1, punch_radius=0, rings=1, draw=2)
    alone = run(
        scene.changed(
            accuracy__rtol=1e-3,
            punch__rings=3,
            punch__wear_coefficients=[1.0, 3.0],
            load__normal_force=last["normal_force"].item(),
            load__sliding_speed=last["sliding_speed"].item(),
        )
    ).dataset
    for name in ("indentation", "steady_wear_rate"):
        np.testing.assert_allclose(last[name], alone[name], rtol=1e-3)


def test_a_dry_run_predicts_scenes_bytes_and_seconds(command):
    """The seconds come from a probe; nothing is written. The file is without the faults above."""
    Path("small.toml").write_text(GOOD)
    text = command("sweep small.toml --dry-run").out
    for part in ("2 scenes", "MiB", "probe", "processes"):
        assert part in text
    assert os.listdir() == ["small.toml"]


def test_a_map_is_drawn_and_its_failure_does_not_affect_other_files(command, tmp_path, monkeypatch):
    Path("map.toml").write_text(
        'base = "five_rings"\nkeep = ["steady_wear_rate"]\n[axes]\n"punch.rings" = [2, 4]'
    )
    out, line = tmp_path / "out", "sweep map.toml --out out --workers 1"
    command(line)
    assert (out / "sweep.png").stat().st_size > 1000

    def fail(*_, **__):
        raise ValueError("no room")

    monkeypatch.setattr(Figure, "savefig", fail)
    assert "sweep.png could not be written: no room" in command(f"{line} --resume", 1).out
    assert not (out / "sweep.png").exists()
    dataset = xarray.open_zarr(out / "sweep.zarr", decode_timedelta=False)
    assert dataset["status"].values.tolist() == [1, 1]


@pytest.mark.parametrize(
    "values", [[1e-2, 1e-3], {"geomspace": [1e-3, 1e-1, 9]}], ids=["few", "many"]
)
def test_random_draws_are_drawn_over_another_axis(values, command, tmp_path):
    table = {
        "base": FIVE.changed(methods=["direct"]).table(),
        "keep": ["steady_wear_rate", "steady_rms_slope"],
        "axes": {"accuracy.rtol": values},
        "random": {"count": 10, "seed": 1, "load.normal_force": [1.0, 2.0]},
    }
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(table), "utf-8")
    command("sweep sweep.toml --out out")
    assert (tmp_path / "out" / "sweep.png").stat().st_size > 1000
