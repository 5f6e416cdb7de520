"""Sweeps: the file, the grid, what is shared, and that every scene is what `run` says it is."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, run, sweep
from ringwear.meshes.errors import SceneError
from ringwear.studies.cli import main
from ringwear.studies.methods.base import method
from ringwear.studies.methods.quantities import (
    COMPARED_MODES,
    QUANTITIES,
    differences,
    error_name,
)
from ringwear.studies.paper import gradients
from ringwear.studies.problem.defaults import sharpness
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.shared import Shared, groups
from ringwear.studies.progress import Stages
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.store import Store, template
from ringwear.studies.sweep.summary import draw

FIVE = Scene.load("five_rings").changed(
    methods=["mdr", "direct"], accuracy__rtol=1e-3, wear__times=[0.0, 0.01, 0.3]
)
RATIOS = {"punch.wear_ratio": [0.1, 1.0, 20.0]}


@pytest.fixture(scope="module")
def small() -> xarray.Dataset:
    return sweep(FIVE, RATIOS | {"punch.rings": [2, 5], "load.normal_force": [1.0, 3.0]})


def test_scenes_are_those_of_run(small: xarray.Dataset) -> None:
    """Of each quantity, a scene of a sweep and the same by `run` differ by no more than
    both state.
    """
    for ratio, rings, force in ((0.1, 5, 3.0), (20.0, 2, 1.0), (1.0, 5, 1.0)):
        scene = FIVE.changed(
            punch__wear_coefficients=[1.0, ratio], punch__rings=rings, load__normal_force=force
        )
        alone = run(scene).dataset
        there = small.sel(wear_ratio=ratio, rings=rings, normal_force=force).isel(mode=slice(3))
        assert there["status"] == 1
        for name in (name for name in QUANTITIES if name in small.data_vars):
            value, other = (
                there[name].values,
                alone[name].isel(mode=slice(3), missing_dims="ignore"),
            )
            np.testing.assert_array_equal(np.isfinite(value), np.isfinite(other))
            stated = sum(
                dataset[error_name(name)].isel(mode=slice(3), missing_dims="ignore").values
                for dataset in (there, alone)
            )
            indentation = QUANTITIES[name].norm == "indentation"
            scale = there["indentation"].values if indentation else np.abs(other.values)
            holds = np.abs(value - other.values) <= np.maximum(stated, 1e-12) * scale
            assert holds[np.isfinite(value) & (scale > 0)].all(), name


def test_many_punches_share_their_modes() -> None:
    """Each differs from its own modes by no more than is stated of that, a small part of the
    accuracy.
    """
    scenes = [
        FIVE.changed(punch__wear_coefficients=[1.0, float(ratio)])
        for ratio in np.geomspace(0.1, 8.0, 16)
    ]
    problems, mdr = [scene.problem for scene in scenes], method("mdr")
    together = mdr.solve_all(problems, Stages("mdr"))
    for problem, shared in zip(problems[::4], together[::4], strict=True):
        assert shared.parts["shared modes"] <= 0.25 * problem.rtol
        alone = mdr.solve(Shared.of([problem, *problems]), Stages("mdr"))
        for name, difference in differences(shared.checked, alone.checked, problem.face).items():
            stated, by_itself = (
                np.atleast_1d(solution.checked_error(problem, name))[:COMPARED_MODES]
                if name == "relaxation_time"
                else solution.checked_error(problem, name)
                for solution in (shared, alone)
            )
            missed = difference[:COMPARED_MODES] if name == "relaxation_time" else difference
            assert np.max(missed) <= np.max(stated), name
            assert (stated >= 0.6 * by_itself).all(), name
    # too few to be worth it, and a march in steps
    stepped = [replace(problem, march="implicit", step=0.1) for problem in problems]
    for others in (problems[:5], stepped):
        (first, *_) = mdr.solve_all(others, Stages("mdr"))
        assert "shared modes" not in first.parts


def test_labels_are_those_asked_for(small: xarray.Dataset) -> None:
    assert small["indentation"].dims == ("wear_ratio", "rings", "normal_force", "solver", "time")
    assert small["time"].values.tolist() == FIVE.wear.times
    assert small["wear_ratio"].values.tolist() == RATIOS["punch.wear_ratio"]
    assert small["rings"].values.tolist() == [2, 5]
    assert (small["status"] == 1).all()
    # two methods that state their errors honestly
    assert float(small["disagreement"].max()) < 1
    # three times the force: all of the same modes
    np.testing.assert_array_equal(
        small["relaxation_time"][..., 0, :, :], small["relaxation_time"][..., 1, :, :]
    )
    np.testing.assert_allclose(
        small["indentation"][..., 1, 0, :], 3 * small["indentation"][..., 0, 0, :], rtol=1e-14
    )


def test_one_discretisation_serves_every_wear() -> None:
    """It is as sharp as the sharpest member needs it, and members much less sharp have one of their
    own.
    """
    made = Sweep.of(
        {"base": FIVE.table(), "axes": {"punch.wear_ratio": [1e-6, 0.1, 2.0, 5.0, 1.0]}}
    )
    problems = [made.scene((number,)).problem for number in range(5)]
    found = groups(problems)
    # equal wear leaves no ring edges
    assert sorted(map(sorted, found)) == [[0], [1, 2, 3], [4]]
    shared = Shared.of([problems[number] for number in (1, 2, 3)])
    for number in (1, 2, 3):
        # sharper at every distance from every edge
        halves, edges = shared.merged.widths / 2, np.arange(5)
        for distance in np.geomspace(1e-10, 0.1, 40):
            behind = (
                sharpness(one)(np.full(5, distance), halves, edges)
                for one in (shared, problems[number])
            )
            assert np.greater_equal(*behind).all()
    assert isinstance(shared, Problem)


@pytest.mark.parametrize("number", [6, 7])
def test_the_figures_of_the_paper(number: int) -> None:
    """The bundled sweeps, on fewer rings and every tenth ratio, against the study of the paper."""
    made = Sweep.load(f"fig{number}")
    ratios, widths = gradients.figure_ratios(number)
    varied, points = [("punch.wear_ratio", ratios), ("punch.width_ratio", widths)][number - 6]
    values = made.axes[0].columns[varied]
    np.testing.assert_allclose(values, points, rtol=1e-13)
    axes = made.table["axes"] | {"punch.rings": [2, 8], varied: values[::10]}
    slopes = sweep(made.table["base"], axes, made.keep)["steady_rms_slope"].sel(solver="direct")
    for count, place in product((2, 8), range(0, 201, 10)):
        edges = gradients.alternating_edges(count, widths[place])
        known = gradients.direct_gradients(edges, ratios[place : place + 1])[:, 0]
        slope = slopes.sel(rings=count)[place // 10] / gradients.homogeneous()
        np.testing.assert_allclose(slope, known, rtol=1e-12)


def test_a_failed_scene_fails_alone() -> None:
    """Its reason is kept with it.

    Those that would share its discretisation are what they are without it.
    """
    # so many explicit steps are refused as the march begins
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "base"),
        ("base = 'five_rings'", "nothing varies"),
        ("base = 'six_rings'\naxes = {'punch.rings' = [2]}", "six_rings"),
        ("base = 'five_rings'\nkeeps = []\n[axes]\n'punch.rings' = [2]", "keeps"),
        ("base = 'five_rings'\naxes = 3", "axes"),
        *(
            (f"base = 'five_rings'\n{rest}", message)
            for rest, message in (
                ("[axes]\n'punch.ring' = [2]", "did you mean rings"),
                ("[axes]\n'punch.rings' = [2, 2.5]", "punch.rings = 2.5"),
                ("[axes]\n'punch.rings' = []", "punch.rings"),
                ("[axes]\n'punch.rings' = { logspace = [1, 2, 3] }", "geomspace"),
                ("[axes]\n'punch.rings' = { linspace = [1, 2] }", "linspace"),
                ("keep = ['slope']\n[axes]\n'punch.rings' = [2]", "slope"),
                ("keep = 'rms_slope'\n[axes]\n'punch.rings' = [2]", "a list of"),
                ("keep = ['profile']\n[axes]\n'punch.rings' = [2]", "output.radii"),
                ("keep = ['indentation']\n[axes]\n'wear.times' = [[0.1], [0.2]]", "wear.times"),
                ("[zip]\n'punch.rings' = [2]\n'punch.width_ratio' = [1.0, 2.0]", "one length"),
                ("[random]\n'punch.rings' = [2]", "random.count"),
                ("[random]\ncount = 2\nseed = 1", "random.count"),
                ("[random]\ncount = 2\nseed = 1\n'punch.rings' = []", "punch.rings"),
                ("[axes]\n'punch.rings' = [2, 3, 2]", "punch.rings = 2 is there twice"),
                ("[axes]\n'punch.width_ratio' = [1, 1.0]", "twice"),
                ("[axes]\n'punch.ring_edges' = [[0.5, 1.0], [0.5, 1.0]]", "twice"),
                ("[zip]\n'punch.rings' = [2, 2]\n'punch.width_ratio' = [1.5, 1.5]", "twice"),
            )
        ),
    ],
)
def test_bad_files(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(SceneError, match=message):
        template(Sweep.load(tmp_path / "bad.toml"))


@pytest.mark.parametrize(
    ("text", "out"), [("base = ", "out"), (None, "s3://bucket/map"), (None, "file:///tmp/map")]
)
def test_bad_input_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str | None, out: str
) -> None:
    """Files that are no TOML, and stores that are not on this machine."""
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(
        text or "base = 'five_rings'\nkeep = ['steady_rms_slope']\n[axes]\n'punch.rings' = [2]"
    )
    assert main(["sweep", "small.toml", "--out", out]) == 2
    assert [file.name for file in tmp_path.iterdir()] == ["small.toml"]


@pytest.mark.parametrize("times", ["running-in", {"tau": [0.1, 1.0]}], ids=str)
def test_times_that_scenes_do_not_share(times: Any) -> None:
    """Counts of relaxation times are other times for each punch.

    No history may be labelled by the first's.
    """
    scene = FIVE.changed(methods=["mdr"], wear__times=times)
    for keep in (None, ["indentation"], ["steady_rms_slope", "worn_volume"]):
        with pytest.raises(
            SceneError, match=r"wear.times counts .* punch.wear_ratio .* give wear.times as numbers"
        ):
            sweep(scene, RATIOS, keep)
    # what is not over time, and histories of one punch under other loads
    assert (sweep(scene, RATIOS, ["relaxation_time", "time_to_90"])["status"] == 1).all()
    loads = sweep(scene, {"load.normal_force": [1.0, 2.0]}, ["indentation"])
    assert loads["time"].values.tolist() == scene.wear.times


def test_answers_are_those_of_run() -> None:
    names = ["worn_volume", "force_share", "running_in_time", "time_to_90", "time_to_99"]
    there = sweep(FIVE, {"punch.rings": [3, 5], "load.normal_force": [1.0, 3.0]}, names)
    assert (there["status"] == 1).all()
    assert not [name for name in there.data_vars if str(name).endswith("_error")]
    alone = run(FIVE.changed(punch__rings=3, load__normal_force=3.0)).dataset
    here = there.sel(rings=3, normal_force=3.0)
    assert here["force_share"].dims == ("solver", "state", "ring")
    assert here["state"].values.tolist() == ["start", "steady"]
    for name in names:
        values = here[name].isel(ring=slice(3), missing_dims="ignore").values
        assert np.isfinite(values).any()
        np.testing.assert_allclose(values, alone[name].values, rtol=1e-3, err_msg=name)
    with pytest.raises(
        SceneError, match=r"'worn_volume', which the base does not ask for: give it wear.times"
    ):
        sweep(FIVE.changed(wear__times=[]), {"punch.rings": [2]}, ["worn_volume"])


def test_coordinates_and_units(tmp_path: Path) -> None:
    """Whatever varies is a coordinate, also where a store is opened, and each unit is that of its
    kind.
    """
    scene = FIVE.changed(units="mm, N, MPa, hours", methods=["direct", "mdr"])
    zipped = {"punch.rings": [2, 3], "punch.wear_coefficients": [[1.0, 2.0], [1.0, 3.0]]}
    draws = {
        "count": 3,
        "seed": 1,
        "load.normal_force": [1.0, 2.0],
        "load.sliding_speed": {"linspace": [1.0, 2.0]},
    }
    keep = ["indentation", "steady_wear_rate", "worn_volume", "steady_rms_slope"]
    sweep(scene, {"half_space.poisson_ratio": [0.3]}, keep, zip=zipped, random=draws, out=tmp_path)
    dataset = xarray.open_zarr(tmp_path / "sweep.zarr", decode_timedelta=False)
    units = {
        "indentation": "mm",
        "indentation_error": "1",
        "steady_wear_rate": "mm/hours",
        "worn_volume": "mm^3",
        "steady_rms_slope": "1",
        "disagreement": "1",
        "time": "hours",
        "rings": "1",
        "wear_coefficients": "1/MPa",
        "normal_force": "N",
        "sliding_speed": "mm/hours",
        "poisson_ratio": "1",
    }
    assert {name: dataset[name].attrs["units"] for name in units} == units
    assert {"wear_coefficients", "normal_force", "sliding_speed", "rings", "time"} <= set(
        dataset.coords
    )
    assert dataset["normal_force"].dims == ("draw",)
    assert set(dataset.data_vars) == {
        *keep,
        "indentation_error",
        "steady_wear_rate_error",
        "steady_rms_slope_error",
        "disagreement",
        "effectivity",
        "status",
        "reason",
    }


def test_figures_of_draws_and_of_any_title() -> None:
    """Draws are points in a panel of each place on the other axes; a dollar in a title is a
    dollar.
    """
    dangerous = r"cost $\frac{ and $"
    draws = {"count": 5, "seed": 1, "punch.wear_ratio": {"geomspace": [0.1, 10.0]}}
    zipped = {"punch.rings": [2, 4, 6], "punch.width_ratio": [1.0, 2.0, 3.0]}
    base = FIVE.changed(methods=["direct"], title=dangerous).table()
    titles = {"title": [dangerous, r"$\sqrt{$"]}
    for axes, more in (
        ({}, {"random": draws, "zip": zipped}),
        ({"punch.rings": [2, 3]}, {"random": draws | {"load.normal_force": [1.0, 2.0]}}),
        (titles, {}),
        (titles | {"punch.rings": [2, 3]}, {}),
        (titles | {"punch.rings": [2, 3], "punch.width_ratio": [1.0, 2.0, 3.0]}, {}),
        ({"punch.rings": [2]}, {}),
        (
            {
                "punch.width_ratio": {"geomspace": [0.1, 10.0, 9]},
                "punch.wear_ratio": {"geomspace": [0.1, 10.0, 9]},
            },
            {},
        ),
    ):
        made = Sweep.of({"base": base, "keep": ["steady_rms_slope"], "axes": axes} | more)
        dataset = sweep(base, axes, made.keep, **more)  # type: ignore[arg-type]
        assert draw(dataset, made).startswith(b"\x89PNG")


def test_a_dry_run_says_what_it_takes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Scenes, groups, bytes; seconds and memory by a probe; nothing is written."""
    monkeypatch.chdir(tmp_path)
    text = "base = 'five_rings'\n[axes]\n'punch.rings' = [2, 3]\n'punch.wear_ratio' = [2.0, 3.0]"
    Path("small.toml").write_text(text)
    assert main(["sweep", "small.toml", "--dry-run"]) == 0
    text = capsys.readouterr().out
    for part in ("4 scenes in about 2 groups", "MiB", "probe", "GiB", "processes"):
        assert part in text
    assert [file.name for file in tmp_path.iterdir()] == ["small.toml"]


def test_axes_crossed_zipped_and_drawn() -> None:
    table = {
        "base": "five_rings",
        "axes": {"accuracy.rtol": [1e-2, 1e-3], "punch.radius": [1.0]},
        "zip": {"punch.rings": {"linspace": [2, 4, 3]}, "punch.width_ratio": [1.0, 2.0, 3.0]},
        "random": {
            "count": 4,
            "seed": 7,
            "punch.wear_ratio": {"geomspace": [0.1, 9.0]},
            "load.normal_force": [1.0, 2.0],
        },
    }
    made = Sweep.of(table)
    # `radius` is a dimension of results already
    assert made.dims == ("rtol", "punch_radius", "rings", "draw")
    assert made.shape == (2, 1, 3, 4)
    again = Sweep.of(json.loads(json.dumps(made.table)))
    assert again.changes((1, 0, 2, 3)) == made.changes((1, 0, 2, 3))
    scene = made.scene((1, 0, 2, 3))
    assert (scene.punch.rings, scene.punch.width_ratio, scene.accuracy.rtol) == (4, 3.0, 1e-3)
    assert 0.1 <= (scene.punch.wear_ratio or 0) <= 10
    assert list(made.coordinates) == [
        "rtol",
        "punch_radius",
        "rings",
        "width_ratio",
        "wear_ratio",
        "normal_force",
    ]


@pytest.mark.parametrize(
    ("axes", "shape"),
    [
        # the scenes of a geometry together
        ({"punch.wear_ratio": {"geomspace": [0.1, 9.0, 150]}, "punch.rings": [2, 3, 4]}, (50, 1)),
        # many scenes to a file where there are many
        (
            {
                "punch.wear_ratio": {"geomspace": [0.1, 9.0, 1000]},
                "punch.width_ratio": {"linspace": [0.5, 2.0, 61]},
            },
            (63, 7),
        ),
    ],
    ids=["few", "many"],
)
def test_blocks_cover_the_grid(
    tmp_path: Path, axes: dict[str, Any], shape: tuple[int, ...]
) -> None:
    """Each scene is in one block."""
    made = Sweep.of({"base": "five_rings", "keep": ["steady_rms_slope"], "axes": axes})
    blocks = Store(made, template(made), tmp_path, False, False).unfinished()
    assert next(iter(blocks.values())).shape == shape
    columns = [
        [
            axis.columns[key]
            for block in blocks.values()
            for axis in block.axes
            if key in axis.columns
        ]
        for key in axes
    ]
    seen = [pair for block in zip(*columns, strict=True) for pair in product(*block)]
    assert len(seen) == len(set(seen)) == made.count


def test_wear_ratio_in_a_scene() -> None:
    """`wear_coefficient` with `wear_ratio` is the list of two."""
    table = Scene.load("five_rings").table()
    del table["punch"]["wear_coefficients"]
    scene = Scene.from_table(
        table | {"punch": table["punch"] | {"wear_coefficient": 2.0, "wear_ratio": 10.0}}
    )
    assert scene.punch.coefficients == [2.0, 20.0]
    for given in (
        {"wear_coefficient": 2.0},
        {"wear_ratio": 2.0},
        {"wear_coefficients": [1.0, 2.0], "wear_ratio": 2.0},
    ):
        with pytest.raises(SceneError, match="wear_"):
            Scene.from_table(table | {"punch": table["punch"] | given})
