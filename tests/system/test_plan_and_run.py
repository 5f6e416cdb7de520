"""A plan compared with the run that it predicts."""

import re
from pathlib import Path

import pytest

from ringwear import Scene, Stages, main, method, plan

BUNDLED = sorted(file.stem for file in (Path(__file__).parents[2] / "studies/scenes").iterdir())


@pytest.mark.gmsh
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "many_rings")) for name in BUNDLED],
)
def test_unknowns_are_those_of_the_run(name):
    """They are those of the run before a refinement."""
    scene = Scene.load(name)
    # element sizes do not depend on late times; a large rtol takes less time
    scene = scene.changed(wear__times=scene.wear.times[:3], accuracy__rtol=1e-2)
    for of in scene.methods:
        solution = method(of).solve(scene.problem, Stages(of))
        assert method(of).system_size(scene.problem).unknowns == solution.unknowns


@pytest.mark.parametrize("load", [{"normal_force": 1.0}, {"indentation": 0.05}], ids=str)
def test_a_plan_predicts_seconds_and_memory_of_any_punch(load):
    scene = Scene.load("recessed_binder").changed(methods=["mdr"], load=load, accuracy__rtol=1e-2)
    mdr, total, memory = plan(scene)
    assert re.fullmatch(r"mdr: \d+ unknowns, \d+ pressures, about [\d.]+ s", mdr)
    assert re.match(r"in all: about [\d.]+ s", total)
    assert "GiB" in memory


@pytest.mark.parametrize(
    "command", ["plan mine.toml", "run mine.toml --no-figures --verbose --out out"]
)
def test_no_text_calls_an_elastic_punch_rigid(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = Scene.load("pin_on_disc").changed(methods=["direct"])
    (tmp_path / "mine.toml").write_text(scene.to_toml(), "utf-8")
    assert main(command.split()) == 0
    printed = capsys.readouterr().out
    assert "two elastic bodies" in printed
    assert "rigid" not in printed
