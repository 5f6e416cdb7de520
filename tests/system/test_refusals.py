"""Commands refuse a scene that a method cannot compute in the same words, before any work."""

import pytest
import tomli_w

from ringwear import Scene
from ringwear.studies.cli import main
from ringwear.studies.outcome.scope import methods_of, refusals

SCENE = Scene(
    methods=["mdr"],
    punch={"radius": 1.0, "rings": 3, "wear_coefficients": [1.0, 5.0]},
    half_space={"plane_strain_modulus": 1.0},
    load={"normal_force": 2.0},
    wear={"times": [0.0, 0.1, 0.5]},
)
OVER_TIME = {"times": [0.0, 1.0], "values": [1.0, 2.0]}
ALONG_RADIUS = {"radii": [0.0, 1.0], "values": [1.0, 3.0]}
FEATURES = {
    "hollow": {"punch.inner_radius": 0.3},
    "layers": {"half_space.layers": [{"thickness": 0.5, "youngs_modulus": 2.0}]},
    "wear along the radius": {"punch": {"radius": 1.0, "wear_coefficient": ALONG_RADIUS}},
    "fixed indentation": {"load": {"indentation": 0.5}},
    "varying force": {"load.normal_force": OVER_TIME},
    "varying speed": {"load.sliding_speed": OVER_TIME},
    "ball": {"punch.profile": {"kind": "ball", "ball_radius": 5.0}},
    "recess": {"punch.recess": [0.0, 0.1, 0.0]},
}
# methods that cannot compute a feature, and words of the reason
REFUSED = [
    ("mdr-grid", "hollow", "mdr-grid solves full discs only"),
    ("mdr-grid", "layers", "mdr-grid does not solve half_space.layers"),
    ("mdr-grid", "wear along the radius", "mdr-grid needs wear that is constant on each ring"),
    ("mdr-grid", "fixed indentation", "mdr-grid solves only flat punches under a given force"),
    ("mdr-grid", "varying force", "mdr-grid needs a constant force and sliding speed"),
    ("mdr-grid", "varying speed", "mdr-grid needs a constant force and sliding speed"),
    ("mdr-grid", "ball", "mdr-grid solves only flat punches under a given force"),
    ("mdr-grid", "recess", "mdr-grid solves only flat punches under a given force"),
    ("direct", "wear along the radius", "direct integration needs pressures that are constant"),
    ("direct", "fixed indentation", "direct gives the steady state only"),
]
COMMANDS = [
    "run scene.toml",
    "plan scene.toml",
    "sweep sweep.toml --dry-run",
    "sweep sweep.toml",
    "compare scene.toml scene.toml",
    "check scene.toml theirs.csv",
]


@pytest.mark.parametrize(("name", "feature", "words"), REFUSED)
def test_all_commands_refuse_a_scene_in_the_same_words(
    name, feature, words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    table = SCENE.changed(FEATURES[feature]).changed(methods=["mdr", name]).table()
    sweep = {"base": table, "axes": {"accuracy.rtol": [1e-3, 1e-2]}}
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(table), "utf-8")
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    (tmp_path / "theirs.csv").write_text("time,indentation\n0.1,1.0\n", "utf-8")
    # a study has methods of its own; it refuses those that are asked for
    study = f"study tradeoff scene.toml --quick --methods {name}"
    messages = set()
    for command in [*COMMANDS, study]:
        assert main(command.split()) == 2, command
        printed = capsys.readouterr()
        assert printed.out == "" or command == study, command
        messages.add(printed.err.strip().splitlines()[-1])
    (message,) = messages
    assert words in message
    assert "leave " in message
    assert len(list(tmp_path.iterdir())) == 3


def test_a_sweep_without_anything_to_compute_is_refused_like_its_scene(tmp_path, capsys):
    scene = SCENE.changed({"load": {"indentation": 0.5}, "wear": {"times": []}})
    sweep = {"base": scene.table(), "axes": {"accuracy.rtol": [1e-3, 1e-2]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    (tmp_path / "scene.toml").write_text(scene.to_toml(), "utf-8")
    messages = set()
    for command in (["sweep", "sweep.toml", "--dry-run"], ["run", "scene.toml"]):
        assert main([command[0], str(tmp_path / command[1]), *command[2:]]) == 2
        messages.add(capsys.readouterr().err)
    (message,) = messages
    assert "with load.indentation the pressure vanishes in the steady state" in message


@pytest.mark.parametrize("feature", FEATURES)
def test_other_methods_accept_every_feature(feature):
    scene = SCENE.changed(FEATURES[feature])
    assert not refusals(scene, methods_of(["mdr", "bem", "fem"]))


def test_a_sweep_computes_the_scenes_that_methods_accept(tmp_path, monkeypatch, capsys):
    """Only a sweep without any such scene is refused; its plan names the reason of a failure."""
    monkeypatch.chdir(tmp_path)
    table = SCENE.changed(methods=["mdr-grid"], accuracy__mdr={"grid": 50}).table()
    sweep = {"base": table, "axes": {"punch.inner_radius": [0.3, 0.0]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    assert main(["sweep", "sweep.toml", "--dry-run"]) == 0
    assert "2 scenes" in capsys.readouterr().out
    assert main(["sweep", "sweep.toml", "--workers", "1"]) == 1
    printed = capsys.readouterr().out
    assert "1 scenes finished, 1 failed" in printed
    assert "mdr-grid solves full discs only: with punch.inner_radius leave it out" in printed
