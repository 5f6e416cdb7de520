"""Sweeps: the file, the grid, what is shared, and that every scene is what `run` says it is."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, run, sweep
from ringwear.meshes.errors import SceneError
from ringwear.studies.cli import main
from ringwear.studies.methods.estimate import estimated, worn_together
from ringwear.studies.methods.pipeline import compliance_method
from ringwear.studies.methods.quantities import QUANTITIES, differences, error_name
from ringwear.studies.paper import gradients
from ringwear.studies.problem.defaults import sharpness
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.shared import Shared, groups
from ringwear.studies.progress import Stages
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.blocks import block_shape, blocks
from ringwear.studies.sweep.figure import drawn
from ringwear.studies.sweep.layout import layout
from ringwear.studies.sweep.plan import START, planned

FIVE = Scene.load("five_rings").changed(
    methods=["mdr", "direct"], accuracy__rtol=1e-3, wear__times=[0.0, 0.01, 0.3]
)
RATIOS = {"punch.wear_ratio": [0.1, 1.0, 20.0]}


def at(dataset: xarray.Dataset, **labels: Any) -> xarray.Dataset:
    return dataset.sel(labels)


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
        own = run(scene).dataset
        there = at(small, wear_ratio=ratio, rings=rings, normal_force=force)
        assert there["status"] == 1
        for name in (name for name in QUANTITIES if name in small.data_vars):
            value, mine = there[name].values, own[name].values
            if "mode" in own[name].dims:
                value, mine = value[..., :3], mine[..., :3]
            assert (np.isfinite(value) == np.isfinite(mine)).all(), name
            error = error_name(name)
            stated = (
                there[error].values[..., : value.shape[-1]]
                + own[error].values[..., : value.shape[-1]]
            )
            scale = (
                there["indentation"].values
                if QUANTITIES[name].norm == "indentation"
                else np.abs(mine)
            )
            both = np.isfinite(value) & (scale > 0)
            difference = np.divide(
                np.abs(value - mine), scale, out=np.zeros(value.shape), where=both
            )
            assert (difference[both] <= np.maximum(stated, 1e-12)[both]).all(), name


def test_many_punches_share_their_modes() -> None:
    """Each differs from its own modes by no more than is stated of that, a small part of the
    accuracy.
    """
    scenes = [
        FIVE.changed(punch__wear_coefficients=[1.0, float(ratio)])
        for ratio in np.geomspace(0.1, 8.0, 16)
    ]
    problems, mdr = [scene.problem for scene in scenes], compliance_method("mdr")
    one = mdr.discretised(Shared.of(problems), Stages("mdr"))
    together = worn_together(problems, one.compliance, one.coarser)
    assert together is not None
    for problem in problems[::4]:
        found, alone = (
            estimated(problem, one.compliance, one.coarser, shared) for shared in (together, None)
        )
        assert found.result.wear.shared is not None
        lost = together.lost(found.result.wear, problem)
        for name, difference in differences(
            found.result.for_estimate, alone.result.for_estimate, problem.face
        ).items():
            stated, own = (np.atleast_1d(one.errors[name])[:3] for one in (found, alone))
            assert np.max(
                difference.flat[:3] if name == "relaxation_time" else difference
            ) <= np.max(stated), name
            assert np.max(np.atleast_1d(lost[name])[:3]) <= 0.25 * problem.rtol
            assert (stated >= 0.6 * own).all(), name
    # too few to be worth it, and a march in steps
    assert worn_together(problems[:5], one.compliance, one.coarser) is None
    stepped = [replace(problem, march="implicit", step=0.1) for problem in problems]
    assert worn_together(stepped, one.compliance, one.coarser) is None


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
    assert (
        len(
            (Path(__file__).parents[2] / f"studies/sweep/files/fig{number}.toml")
            .read_text("utf-8")
            .splitlines()
        )
        < 20
    )
    table = made.table | {"axes": made.table["axes"] | {"punch.rings": [2, 8]}}
    ratios, widths = gradients.figure_ratios(number)
    varied = {6: "punch.wear_ratio", 7: "punch.width_ratio"}[number]
    asked = np.array(Sweep.of(table).axes[0].columns[varied])
    np.testing.assert_allclose(asked, ratios if number == 6 else widths, rtol=1e-13)
    table["axes"] |= {varied: asked[::10].tolist()}
    slopes = (
        sweep(table["base"], table["axes"], made.keep)["steady_rms_slope"]
        .sel(solver="direct")
        .values
    )
    homogeneous = gradients.homogeneous()
    for place, count in enumerate((2, 8)):
        for here in range(0, 201, 10):
            edges = gradients.alternating_edges(count, widths[here])
            known = gradients.direct_gradients(edges, ratios[here : here + 1])[:, 0]
            np.testing.assert_allclose(slopes[here // 10, place] / homogeneous, known, rtol=1e-12)


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


def test_files(tmp_path: Path) -> None:
    for text, message in (
        ("", "missing key base"),
        ("base = 'five_rings'", "nothing varies"),
        ("base = 'six_rings'\naxes = {'punch.rings' = [2]}", "six_rings: no such file"),
        ("base = 'five_rings'\n[axes]\n'punch.ring' = [2]", "did you mean rings"),
        ("base = 'five_rings'\n[axes]\n'punch.rings' = [2, 2.5]", "punch.rings = 2.5"),
        ("base = 'five_rings'\n[axes]\n'punch.rings' = { logspace = [1, 2, 3] }", "geomspace"),
        (
            "base = 'five_rings'\nkeep = ['slope']\n[axes]\n'punch.rings' = [2]",
            "'slope', which is no quantity",
        ),
        ("base = 'five_rings'\nkeep = ['profile']\n[axes]\n'punch.rings' = [2]", "output.radii"),
        (
            "base = 'five_rings'\nkeep = ['indentation']\n[axes]\n'wear.times' = [[0.1], [0.2]]",
            "wear.times varies",
        ),
        (
            "base = 'five_rings'\n[zip]\n'punch.rings' = [2]\n'punch.width_ratio' = [1.0, 2.0]",
            "of one length",
        ),
        ("base = 'five_rings'\n[random]\n'punch.rings' = [2]", "random.count"),
        (
            "base = 'five_rings'\n[axes]\n'punch.rings' = [2, 3, 2]",
            "punch.rings = 2 is there twice",
        ),
        ("base = 'five_rings'\n[axes]\n'punch.width_ratio' = [1, 1.0]", "twice"),
        ("base = 'five_rings'\n[axes]\n'punch.ring_edges' = [[0.5, 1.0], [0.5, 1.0]]", "twice"),
        (
            "base = 'five_rings'\n[zip]\n'punch.rings' = [2, 2]\n'punch.width_ratio' = [1.5, 1.5]",
            "twice",
        ),
        ("base = 'five_rings'\nkeeps = []\n[axes]\n'punch.rings' = [2]", "unknown key keeps"),
    ):
        with pytest.raises(SceneError, match=message):
            layout(Sweep.of(tomllib.loads(text)))
    (tmp_path / "bad.toml").write_text("base = ")
    assert main(["sweep", str(tmp_path / "bad.toml"), "--out", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
    # pairs that differ in one number are two scenes
    zipped = "base = 'five_rings'\n[zip]\n'punch.rings' = [2, 2]\n'punch.width_ratio' = [1.0, 2.0]"
    assert Sweep.of(tomllib.loads(zipped)).count == 2


@pytest.mark.parametrize("out", ["s3://bucket/map", "file:///tmp/map"])
def test_a_store_is_on_this_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], out: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(
        "base = 'five_rings'\nkeep = ['steady_rms_slope']\n[axes]\n'punch.rings' = [2]"
    )
    assert main(["sweep", "small.toml", "--out", out]) == 2
    assert "no directory of this machine" in capsys.readouterr().err
    with pytest.raises(SceneError, match="no directory of this machine"):
        sweep(FIVE, RATIOS, out=out)
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
    own = run(FIVE.changed(punch__rings=3, load__normal_force=3.0)).dataset
    here = at(there, rings=3, normal_force=3.0)
    assert here["force_share"].dims == ("solver", "state", "ring")
    assert here["state"].values.tolist() == ["start", "steady"]
    for name in names:
        found, known = here[name].values, own[name].values
        found = found[..., :3] if "ring" in here[name].dims else found
        assert np.isfinite(known).any()
        np.testing.assert_allclose(found, known, rtol=1e-3, err_msg=name)
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
        "checksum",
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
        ({"punch.rings": [2, 3]}, {"random": draws}),
        ({"punch.rings": [2, 3]}, {"random": draws, "zip": {"punch.width_ratio": [1.0, 2.0]}}),
        (titles, {}),
        (titles | {"punch.rings": [2, 3]}, {}),
        (titles | {"punch.rings": [2, 3], "punch.width_ratio": [1.0, 2.0, 3.0]}, {}),
    ):
        table = {
            "base": base,
            "keep": ["steady_rms_slope"],
            **({"axes": axes} if axes else {}),
            **more,
        }
        made = Sweep.of(table)
        dataset = sweep(base, axes, made.keep, **more)  # type: ignore[arg-type]
        assert drawn(dataset, made).startswith(b"\x89PNG")


def test_a_plan_is_that_of_the_worst_scene() -> None:
    """The memory of 300 rings, though two come first; and of the most times."""

    def memory(axes: dict[str, Any]) -> float:
        base = FIVE.changed(methods=["mdr"]).table()
        return planned(
            Sweep.of({"base": base, "axes": axes, "keep": ["relaxation_time"]}), 1e9, 1
        ).memory

    alone = memory({"punch.rings": [300]})
    assert alone > 1
    assert memory({"punch.rings": [2, 300]}) == memory({"punch.rings": [300, 2]}) == alone
    many = np.linspace(0.1, 1.0, 30_000).tolist()
    assert (
        memory({"wear.times": [[0.1], many]})
        == memory({"wear.times": [many]})
        > 2 * memory({"wear.times": [[0.1]]})
    )
    with pytest.raises(SceneError, match="are needed"):
        planned(Sweep.of({"base": FIVE.table(), "axes": {"punch.rings": [2, 300]}}), alone / 2, 1)


def test_a_plan_divides_no_block() -> None:
    """Eight processes are no faster with one block than one."""
    made = Sweep.of(
        {"base": FIVE.table(), "axes": {"punch.rings": [2, 3, 4], "punch.wear_ratio": [0.5, 2.0]}}
    )
    one = planned(made, 1e9, 1)
    assert one.blocks == 1
    assert one.elapsed(8) == one.elapsed(1) > one.seconds
    more = replace(one, blocks=9)
    assert more.elapsed(8) == pytest.approx(START + 2 / 9 * one.seconds)


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
    again = Sweep.of(json.loads(made.to_json()))
    assert again.changes((1, 0, 2, 3)) == made.changes((1, 0, 2, 3))
    scene = made.scene((1, 0, 2, 3))
    assert (scene.punch.rings, scene.punch.width_ratio, scene.accuracy.rtol) == (4, 3.0, 1e-3)
    assert 0.1 <= (scene.punch.wear_ratio or 0) <= 10
    names = [name for name, *_ in made.coordinates()]
    assert names == ["rtol", "punch_radius", "rings", "width_ratio", "wear_ratio", "normal_force"]


def test_blocks_cover_the_grid_once() -> None:
    axes = {"punch.wear_ratio": {"geomspace": [0.1, 9.0, 150]}, "punch.rings": [2, 3, 4]}
    made = Sweep.of({"base": "five_rings", "axes": axes})
    seen = np.zeros(made.shape, dtype=int)
    shape = block_shape(made, layout(made))
    for block in blocks(made, shape):
        assert block.shape[1] == 1
        seen[block.region] += 1
    assert (seen == 1).all()
    assert shape == (50, 1)


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
