"""Commands refuse a scene that a method cannot compute in the same words, before any work."""

import json

import meshio
import numpy as np
import pytest
import tomli_w
from groups import nightly
from natural import natural

from ringwear import Scene, SceneError, method, run, sweep

SCENE = natural({"rings": 3, "wear_coefficients": [1.0, 5.0]}, [0.0, 0.1, 0.5], methods="mdr")
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


@pytest.mark.parametrize(("name", "feature", "words"), [REFUSED[0], *nightly(*REFUSED[1:])])
def test_all_commands_refuse_a_scene_in_the_same_words(name, feature, words, command, tmp_path):
    table = SCENE.changed(FEATURES[feature]).changed(methods=["mdr", name]).table()
    sweep = {"base": table, "axes": {"accuracy.rtol": [1e-3, 1e-2]}}
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(table), "utf-8")
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    (tmp_path / "theirs.csv").write_text("time,indentation\n0.1,1.0\n", "utf-8")
    # a study has methods of its own; it refuses those that are asked for
    study = f"study tradeoff scene.toml --quick --methods {name}"
    messages = set()
    for line in [*COMMANDS, study]:
        printed = command(line, 2)
        assert printed.out == "" or line == study, line
        messages.add(printed.err.strip().splitlines()[-1])
    (message,) = messages
    assert words in message
    assert "leave " in message
    assert len(list(tmp_path.iterdir())) == 3


def test_a_sweep_without_anything_to_compute_is_refused_like_its_scene(command, tmp_path):
    scene = SCENE.changed({"load": {"indentation": 0.5}, "wear": {"times": []}})
    sweep = {"base": scene.table(), "axes": {"accuracy.rtol": [1e-3, 1e-2]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    message = command("sweep sweep.toml --dry-run", 2).err
    assert command("run scene.toml", 2, scene).err == message
    assert "with load.indentation the pressure vanishes in the steady state" in message


@pytest.mark.parametrize(("name", "feature", "words"), REFUSED)
def test_a_method_refuses_a_scene_with_a_reason(name, feature, words):
    assert words in method(name).refusal(SCENE.changed(FEATURES[feature]).problem)


@pytest.mark.parametrize("feature", FEATURES)
def test_other_methods_accept_every_feature(feature):
    problem = SCENE.changed(FEATURES[feature]).problem
    assert not any(method(name).refusal(problem) for name in ("mdr", "bem", "fem"))


def test_a_sweep_computes_the_scenes_that_methods_accept(command, tmp_path):
    """Only a sweep without any such scene is refused; its plan names the reason of a failure."""
    table = SCENE.changed(methods=["mdr-grid"], accuracy__mdr={"grid": 50}).table()
    sweep = {"base": table, "axes": {"punch.inner_radius": [0.3, 0.0]}}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(sweep), "utf-8")
    assert "2 scenes" in command("sweep sweep.toml --dry-run").out
    printed = command("sweep sweep.toml --workers 1", 1).out
    assert "1 scenes finished, 1 failed" in printed
    assert "mdr-grid solves full discs only: with punch.inner_radius leave it out" in printed


# a scene without methods, the default method that cannot solve it, and words of the reason
FORCE_ENDS = {"times": [0.0, 1.0], "values": [1.0, 0.0]}
WITHOUT_METHODS = {
    "fixed indentation": (FEATURES["fixed indentation"], "direct", "nothing presses in the end"),
    "wear along the radius": (
        FEATURES["wear along the radius"],
        "direct",
        "needs pressures that are constant on each ring",
    ),
    "the force ends": ({"load.normal_force": FORCE_ENDS}, "direct", "in the end the force is 0"),
    "no steady state": ({"wear.steady": False}, "direct", "gives the steady state only"),
    "a narrow ring": (
        {"punch": {"radius": 1.0, "ring_edges": [1e-13, 1.0], "wear_coefficients": [1.0, 2.0]}},
        "fem",
        "cannot be meshed",
    ),
}


def without_methods(changes):
    table = SCENE.changed(accuracy__rtol=1e-2).changed(changes).table()
    del table["methods"]
    return Scene.from_table(table)


@pytest.mark.slow
@pytest.mark.parametrize("case", WITHOUT_METHODS)
def test_a_scene_without_methods_is_solved_by_those_that_can(case, command, tmp_path):
    changes, omitted, words = WITHOUT_METHODS[case]
    scene = without_methods(changes)
    printed = command("run scene.toml --no-figures --out out", scene=scene).out
    assert f"without {omitted}" in printed
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert {*summary["methods"]} == {"mdr", "direct", "fem"} - {omitted}
    assert words in summary["left_out"][omitted]
    assert "leave" not in summary["left_out"][omitted]
    printed = command("plan scene.toml").out
    assert f"{omitted}: " in printed.partition("Left out")[2].partition("By method")[0]
    # a method that the scene names is refused, unless it only lacks what is not asked for
    if case != "no steady state":
        with pytest.raises(SceneError, match=r"leave .* out of methods"):
            run(scene, methods=["mdr", omitted])


def test_methods_that_solve_a_scene_are_left_out_of_nothing():
    scene = without_methods({})
    result = run(scene, methods=["mdr"])
    assert "direct" not in result.summary["left_out"]
    assert "fem" not in result.summary["left_out"]


RECESS, STEPS = FEATURES["recess"], {"wear.march": "explicit", "wear.step": 0.1}
SETTINGS = [
    (RECESS | STEPS, "give 'implicit', or 'modal'"),
    (FEATURES["layers"] | {"accuracy.fem.mesher": "gmsh"}, "leave out accuracy.fem.mesher"),
    (RECESS | {"accuracy.mdr.degree": 4}, "accuracy.mdr"),
    (RECESS | {"accuracy.fem.truncation": 4.0}, "accuracy.fem"),
    (FEATURES["varying force"] | STEPS, "wear.march.* 'modal'"),
    (FEATURES["varying force"] | {"wear.times": "running-in"}, "running-in.* times as numbers"),
    (STEPS | {"wear.step": 1.0, "wear.times": [0.0, 1000.0]}, "give a smaller wear.step"),
]


@pytest.mark.parametrize(("changes", "words"), SETTINGS)
def test_a_wrong_setting_is_refused_although_another_method_needs_none(changes, words):
    with pytest.raises(SceneError, match=words):
        run(without_methods(changes))


def test_a_sweep_without_methods_has_those_that_solve_all_of_its_scenes():
    scene = without_methods(FEATURES["fixed indentation"] | {"wear.times": [0.0, 0.1]})
    dataset = sweep(scene, {"load.indentation": [0.25, 0.5]}, keep=["normal_force"])
    assert dataset.solver.values.tolist() == ["mdr", "fem"]
    # F = 2 a E* d of a flat punch
    forces = dataset.normal_force.isel(time=0).transpose("indentation", "solver")
    np.testing.assert_allclose(forces, [[0.5, 0.5], [1.0, 1.0]], rtol=1e-2)


LAYERED = Scene(
    units="SI",
    punch={"radius": 0.005, "wear_coefficient": 1e-15},
    half_space={
        "youngs_modulus": 2e9,
        "layers": [{"thickness": 0.001, "youngs_modulus": 3e8}],
    },
    load={"normal_force": 2.0, "sliding_speed": 1.0},
    wear={"times": [0.0, 100.0]},
)


@pytest.mark.slow
@pytest.mark.gmsh
def test_a_depth_of_the_output_is_refused_with_what_works_on_layers(tmp_path):
    """20 mm are 4 punch radii; the remedy writes all of a mesh of that radius."""
    with pytest.raises(SceneError, match=r"give accuracy\.fem\.truncation = 4 in place of it"):
        run(LAYERED.changed(output__depth="20 mm"))
    shaped = {"output__depth": 0.02, "punch__profile": {"kind": "cone", "slope": 0.1}}
    with pytest.raises(SceneError, match=r"half_space\.layers leave it out: half_space\.vtu has"):
        run(LAYERED.changed(**shaped))
    wide = LAYERED.changed(accuracy={"rtol": 1e-2, "fem": {"truncation": 4.0}}, methods=["fem"])
    run(wide).save(tmp_path / "wide")
    points = meshio.read(tmp_path / "wide" / "half_space.vtu").points
    assert points[:, 0].max() == pytest.approx(0.02, rel=1e-6)
