"""The door.

Bad scenes are refused with one line that names the key, and good ones come through unchanged.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ringwear import Scene
from ringwear.meshes.errors import SceneError
from ringwear.studies.cli import BAD_INPUT, main
from ringwear.studies.problem.scene import bundled

GOOD = """\
title = "A scene"
methods = ["direct"]

[punch]
radius = 2.0
rings = 3
wear_coefficients = [1.0, 10.0]

[half_space]
plane_strain_modulus = 1.0
poisson_ratio = 0.3

[load]
normal_force = 2.0
sliding_speed = 1.0

[wear]
times = [0.0, 0.1]

[accuracy]
rtol = 1e-3

[output]
radii = [0.5, 1.5]
"""

# what is replaced, by what, and what the message must contain
BAD: list[tuple[str, str, list[str]]] = [
    # misspelt and unknown keys, with the nearest
    ("radius = 2.0", "raduis = 2.0", ["punch.raduis", "did you mean radius"]),
    ("[half_space]", "[halfspace]", ["halfspace", "did you mean half_space"]),
    ("poisson_ratio", "poissons_ratio", ["poissons_ratio", "did you mean poisson_ratio"]),
    (
        "rtol = 1e-3",
        "rtol = 1e-3\nmdr = { degre = 3 }",
        ["accuracy.mdr.degre", "did you mean degree"],
    ),
    (
        "rtol = 1e-3",
        "rtol = 1e-3\nfem = { elements = 3 }",
        ["accuracy.fem.elements", "did you mean"],
    ),
    # missing keys and tables
    ("radius = 2.0\n", "", ["missing", "punch.radius"]),
    ("wear_coefficients = [1.0, 10.0]\n", "", ["missing", "punch.wear_coefficients"]),
    ("[load]\nnormal_force = 2.0\nsliding_speed = 1.0\n", "", ["missing", "load"]),
    ("rings = 3\n", "", ["punch", "rings", "ring_edges"]),
    ("normal_force = 2.0\n", "", ["load", "normal_force", "mean_pressure"]),
    ("plane_strain_modulus = 1.0\n", "", ["half_space", "plane_strain_modulus", "youngs_modulus"]),
    # two ways to say one thing
    ("rings = 3", "rings = 3\nring_edges = [1.0, 2.0]", ["punch", "rings", "ring_edges"]),
    ("rings = 3", "ring_edges = [1.0, 2.0]\nwidth_ratio = 2.0", ["width_ratio"]),
    (
        "normal_force = 2.0",
        "normal_force = 2.0\nmean_pressure = 1.0",
        ["load", "normal_force", "mean_pressure"],
    ),
    (
        "plane_strain_modulus = 1.0",
        "plane_strain_modulus = 1.0\nyoungs_modulus = 1.0",
        ["youngs_modulus"],
    ),
    # wrong types
    ("radius = 2.0", 'radius = "2.0"', ["punch.radius"]),
    ("radius = 2.0", "radius = true", ["punch.radius"]),
    ("radius = 2.0", "radius = [2.0]", ["punch.radius"]),
    ("rings = 3", "rings = 3.0", ["punch.rings"]),
    ("wear_coefficients = [1.0, 10.0]", "wear_coefficients = 1.0", ["punch.wear_coefficients"]),
    (
        "wear_coefficients = [1.0, 10.0]",
        'wear_coefficients = [1.0, "x"]',
        ["punch.wear_coefficients"],
    ),
    ('methods = ["direct"]', 'methods = "direct"', ["methods"]),
    ("times = [0.0, 0.1]", "times = 0.1", ["wear.times"]),
    ("times = [0.0, 0.1]", 'times = [0.0, 0.1]\nsteady = "no"', ["wear.steady"]),
    # the punch
    *[
        ("radius = 2.0", f"radius = {value}", ["punch.radius", value])
        for value in ("0.0", "-1.0", "inf", "nan")
    ],
    *[
        ("rings = 3", f"rings = {value}", ["punch.rings", value])
        for value in ("0", "-2", "1000000000")
    ],
    *[
        ("rings = 3", f"rings = 3\nwidth_ratio = {value}", ["punch.width_ratio"])
        for value in ("0.0", "-1.0", "inf")
    ],
    ("rings = 3", "ring_edges = [1.5, 1.0, 2.0]", ["ring_edges", "increase"]),
    ("rings = 3", "ring_edges = [1.0, 1.0, 2.0]", ["ring_edges", "repeats"]),
    ("rings = 3", "ring_edges = [0.0, 1.0, 2.0]", ["ring_edges"]),
    ("rings = 3", "ring_edges = [1.0, 1.9]", ["ring_edges", "punch.radius"]),
    ("rings = 3", "ring_edges = [1.0, 2.1]", ["ring_edges", "punch.radius"]),
    ("rings = 3", "ring_edges = []", ["ring_edges"]),
    # wear coefficients
    *[
        ("[1.0, 10.0]", f"[1.0, {value}]", ["punch.wear_coefficients", value])
        for value in ("0.0", "-1.0", "nan", "inf")
    ],
    ("[1.0, 10.0]", "[1.0]", ["wear_coefficients", "1 values", "3 rings"]),
    ("[1.0, 10.0]", "[1.0, 2.0, 3.0, 4.0]", ["wear_coefficients", "4 values"]),
    ("[1.0, 10.0]", "[]", ["wear_coefficients", "0 values"]),
    # the half-space and the load
    *[
        ("poisson_ratio = 0.3", f"poisson_ratio = {v}", ["poisson_ratio", v])
        for v in ("0.51", "1.2", "-1.0", "-3.0", "nan")
    ],
    *[
        ("plane_strain_modulus = 1.0", f"plane_strain_modulus = {v}", ["plane_strain_modulus"])
        for v in ("0.0", "-1.0", "nan")
    ],
    *[
        ("normal_force = 2.0", f"normal_force = {v}", ["load.normal_force", v])
        for v in ("0.0", "-1.0", "inf", "nan")
    ],
    *[
        ("sliding_speed = 1.0", f"sliding_speed = {v}", ["load.sliding_speed"])
        for v in ("0.0", "-1.0", "nan")
    ],
    # times, marches and accuracy
    *[("[0.0, 0.1]", f"[0.0, {value}]", ["wear.times", value]) for value in ("-1.0", "nan", "inf")],
    ("[0.0, 0.1]", "[0.1, 0.05]", ["times", "increase"]),
    ("[0.0, 0.1]", "[0.1, 0.1]", ["times", "repeats"]),
    ("times = [0.0, 0.1]", "steady = false", ["times", "steady"]),
    ("[0.0, 0.1]", '[0.0, 0.1]\nmarch = "leapfrog"', ["wear.march", "leapfrog"]),
    ("[0.0, 0.1]", '[0.0, 0.1]\nmarch = "implicit"', ["march", "step"]),
    ("[0.0, 0.1]", "[0.0, 0.1]\nstep = 0.1", ["step", "march"]),
    ("[0.0, 0.1]", '[0.0, 0.1]\nmarch = "explicit"\nstep = 0.0', ["wear.step"]),
    *[
        ("rtol = 1e-3", f"rtol = {value}", ["accuracy.rtol", value])
        for value in ("0.0", "-1.0", "1e-12", "0.5", "nan")
    ],
    *[
        ("rtol = 1e-3", f"fem = {{ {v} }}", ["accuracy.fem"])
        for v in ("degree = 17", "degree = 1", "truncation = 1.0")
    ],
    ("rtol = 1e-3", 'fem = { mesher = "triangle" }', ["accuracy.fem.mesher", "triangle"]),
    (
        "rtol = 1e-3",
        'fem = { mesher = "bisection", degree = 5 }',
        ["accuracy.fem", "bisection", "give 2 to 4"],
    ),
    (
        "rtol = 1e-3",
        'fem = { mesher = "quads", degree = 3 }',
        ["accuracy.fem", "quads", "give 4 to 16"],
    ),
    ("rtol = 1e-3", 'fem = { mesher = "stars" }', ["accuracy.fem.mesher = 'stars'", "quads"]),
    ('["direct"]', '["direct", "astrology"]', ["methods", "astrology"]),
    ('["direct"]', '["direct", "direct"]', ["methods", "twice"]),
    ('["direct"]', "[]", ["methods"]),
    ("[0.5, 1.5]", "[0.5, 2.5]", ["output.radii", "2.5"]),
    ("[0.5, 1.5]", "[1.5, 0.5]", ["output.radii", "increase"]),
    ("[0.5, 1.5]", "[-0.5, 1.5]", ["output.radii", "-0.5"]),
    # not TOML
    ("radius = 2.0", "radius = ", ["not TOML", "line 5"]),
    ("[punch]", "[punch", ["not TOML", "line 4"]),
    ("[accuracy]", "[punch]", ["not TOML"]),
]


def refused(arguments: list[str], out: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The one line that bad input gets; nothing else may have happened."""
    assert main([*arguments, "--out", str(out)]) == BAD_INPUT == 2
    output, error = capsys.readouterr()
    assert output == ""
    assert error.startswith("ringwear: ")
    assert error.count("\n") == 1
    assert error.endswith("\n")
    assert "Traceback" not in error
    assert "pydantic" not in error
    return error


@pytest.mark.parametrize(
    ("old", "new", "named"), BAD, ids=[new.replace("\n", " ") or f"no {old}" for old, new, _ in BAD]
)
def test_bad_scenes(
    old: str, new: str, named: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in GOOD
    file, out = tmp_path / "scene.toml", tmp_path / "out"
    file.write_text(GOOD.replace(old, new, 1), "utf-8")
    message = refused(["run", str(file)], out, capsys)
    assert all(part in message for part in named), message
    assert not out.exists()


def test_bad_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    binary, empty = tmp_path / "binary.toml", tmp_path / "empty.toml"
    binary.write_bytes(bytes(range(256)))
    empty.write_text("", "utf-8")
    for source, named in (
        ("no_such_scene", "no such file"),
        (str(tmp_path), "is a directory"),
        (str(binary), "not a text file"),
        (str(empty), "missing keys punch"),
        (str(empty / "below"), "below"),
    ):
        assert named in refused(["run", source], out, capsys)
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--rtol", "7"], "accuracy.rtol"),
        (["--rtol", "nan"], "accuracy.rtol"),
        (["--methods", "magic"], "magic"),
        (["--methods", ""], "methods"),
        (["--methods", "mdr,mdr"], "twice"),
    ],
)
def test_bad_options(
    arguments: list[str], named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert named in refused(["run", "flat_punch", *arguments], tmp_path / "out", capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("below", ["", "deeper"])
@pytest.mark.parametrize("command", ["run", "mesh"])
def test_out_that_is_a_file(
    command: str, below: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file"
    file.write_text("precious", "utf-8")
    scene = tmp_path / "scene.toml"
    scene.write_text(GOOD, "utf-8")
    assert main([command, str(scene), "--out", str(file / below)]) == BAD_INPUT
    output, error = capsys.readouterr()
    assert output == ""
    # a run may have shown its stages before it came to writing
    assert "--out" in error.splitlines()[-1]
    assert file.read_text("utf-8") == "precious"


def test_an_unstable_march_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(
        GOOD.replace('["direct"]', '["mdr"]').replace(
            "0.1]", '1000.0]\nmarch = "explicit"\nstep = 1.0'
        ),
        "utf-8",
    )
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == BAD_INPUT
    assert "wear.step" in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", bundled())
def test_bundled_scenes_round_trip(name: str) -> None:
    scene = Scene.load(name)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert Scene.from_table(scene.table()) == scene
    assert scene.changed() == scene
    assert scene.title


def test_a_scene_is_a_value() -> None:
    scene = Scene.from_toml(GOOD)
    with pytest.raises(ValueError, match="frozen"):
        scene.punch.radius = 3.0
    changed = scene.changed(
        accuracy__rtol=1e-5, accuracy__fem__degree=3, output__gradient_average="area"
    )
    assert (changed.accuracy.rtol, changed.accuracy.fem.degree) == (1e-5, 3)
    assert changed.output.gradient_average == "area"
    assert scene == Scene.from_toml(GOOD)
    with pytest.raises(SceneError, match=r"accuracy\.rtoll"):
        scene.changed(accuracy__rtoll=1.0)


def test_whole_numbers_will_do() -> None:
    assert Scene.from_toml(
        GOOD.replace("2.0", "2").replace("[1.0, 10.0]", "[1, 10]")
    ) == Scene.from_toml(GOOD)


def test_two_ways_to_say_one_thing() -> None:
    scene = Scene.from_toml(GOOD)
    edges = Scene.from_toml(GOOD.replace("rings = 3", f"ring_edges = {[2 / 3, 4 / 3, 2.0]}"))
    each = Scene.from_toml(GOOD.replace("[1.0, 10.0]", "[1.0, 10.0, 1.0]"))
    for other in (edges, each):
        np.testing.assert_allclose(other.problem.ring_edges, scene.problem.ring_edges, rtol=1e-15)
        np.testing.assert_array_equal(
            other.problem.wear_coefficients, scene.problem.wear_coefficients
        )
    young = Scene.from_toml(
        GOOD.replace("plane_strain_modulus = 1.0", f"youngs_modulus = {1 - 0.3**2}")
    )
    assert young.problem.units.modulus == pytest.approx(1, rel=1e-15)
    mean = Scene.from_toml(GOOD.replace("normal_force = 2.0", f"mean_pressure = {2 / (4 * np.pi)}"))
    assert mean.problem.units.force == pytest.approx(2, rel=1e-15)


@pytest.mark.parametrize(("ratio", "count"), [(1.0, 1), (1.0, 5), (3.0, 4), (0.25, 7)])
def test_ring_widths(ratio: float, count: int) -> None:
    scene = Scene.from_toml(GOOD.replace("rings = 3", f"rings = {count}\nwidth_ratio = {ratio}"))
    widths = np.diff(scene.problem.ring_edges)
    assert scene.problem.ring_edges[[0, -1]].tolist() == [0.0, 1.0]
    np.testing.assert_allclose(widths[2:], widths[:-2], rtol=1e-12)
    if count > 1:
        assert widths[1] / widths[0] == pytest.approx(ratio, rel=1e-12)


def test_output_radii_show_every_ring_and_touch_no_edge() -> None:
    problem = Scene.load("many_rings").problem
    radii, edges = problem.radii, problem.ring_edges
    assert radii[0] == 0
    assert (np.diff(radii) > 0).all()
    assert not np.isin(radii, edges[1:]).any()
    assert np.histogram(radii, edges)[0].min() >= 8
