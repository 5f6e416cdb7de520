"""What cannot be done is refused in a line that names the key and the remedy, with the right
status; nothing is written.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ringwear import Scene
from ringwear.studies.cli import main

GOOD = """\
title = "a punch"
methods = ["direct"]
[punch]
radius = 1.0
rings = 3
wear_coefficients = [1.0, 10.0]
[half_space]
plane_strain_modulus = 1.0
[load]
normal_force = 2.0
[wear]
times = [0.0, 1.0]
[accuracy]
rtol = 1e-3
"""

# a line of the scene above, what stands in its place, and what is told: the key, and the remedy
SCENES: list[tuple[str, str, tuple[str, ...]]] = [
    ("radius = 1.0", "radius = 0.0", ("punch.radius", "positive length")),
    ("radius = 1.0", "radius = -2", ("punch.radius", "positive length")),
    ("radius = 1.0", "radius = nan", ("punch.radius", "positive length")),
    ("radius = 1.0", "radius = inf", ("punch.radius", "positive length")),
    ("radius = 1.0", "radius = 1e-300", ("punch.radius", "1e-300", "units")),
    ("radius = 1.0", "radius = 1e200", ("punch.radius", "1e+200", "units")),
    ("radius = 1.0", 'radius = "1 m"', ("punch.radius", "positive length")),
    ("radius = 1.0", "radius = true", ("punch.radius", "positive length")),
    (
        "radius = 1.0",
        "",
        ("punch.radius", "missing", "radius", "rings", "wear_coefficients", "for example"),
    ),
    ("radius = 1.0", "raduis = 1.0", ("raduis", "radius")),
    ("rings = 3", "rings = 0", ("punch.rings", "1 or more")),
    ("rings = 3", "rings = -4", ("punch.rings", "1 or more")),
    ("rings = 3", "rings = 2.5", ("punch.rings", "number of rings")),
    ("rings = 3", "rings = 1000000", ("punch.rings", "100000")),
    ("rings = 3", "", ("rings", "ring_edges")),
    ("rings = 3", "rings = 2\nring_edges = [0.5, 1.0]", ("rings", "ring_edges", "not both")),
    ("rings = 3", "ring_edges = [0.7, 0.5, 1.0]", ("ring_edges", "increase")),
    ("rings = 3", "ring_edges = [0.5, 0.9]", ("ring_edges", "punch.radius")),
    ("rings = 3", "ring_edges = [-0.5, 1.0]", ("ring_edges", "greater than 0")),
    ("rings = 3", "rings = 3\nwidth_ratio = 0.0", ("width_ratio", "h2/h1")),
    ("rings = 3", "rings = 3\nwidth_ratio = 1e-300", ("width_ratio", "1e-9")),
    ("[1.0, 10.0]", "[]", ("wear_coefficients", "3")),
    ("[1.0, 10.0]", "[1.0]", ("wear_coefficients", "alternate")),
    ("[1.0, 10.0]", "[1.0, 0.0]", ("wear_coefficients", "positive")),
    ("[1.0, 10.0]", "[1.0, -1.0]", ("wear_coefficients", "positive")),
    ("[1.0, 10.0]", "10.0", ("wear_coefficients", "one for each ring")),
    ("[1.0, 10.0]", "[1e-300, 1e300]", ("wear_coefficients", "units")),
    ("plane_strain_modulus = 1.0", "", ("plane_strain_modulus", "youngs_modulus")),
    (
        "plane_strain_modulus = 1.0",
        "plane_strain_modulus = 1.0\nyoungs_modulus = 1.0",
        ("youngs_modulus", "not both"),
    ),
    (
        "plane_strain_modulus = 1.0",
        "plane_strain_modulus = -1.0",
        ("half_space.plane_strain_modulus", "positive"),
    ),
    (
        "plane_strain_modulus = 1.0",
        "youngs_modulus = 1.0\npoisson_ratio = 0.6",
        ("poisson_ratio", "0.5"),
    ),
    (
        "plane_strain_modulus = 1.0",
        "youngs_modulus = 1.0\npoisson_ratio = -1.0",
        ("poisson_ratio", "above -1"),
    ),
    ("normal_force = 2.0", "", ("normal_force", "mean_pressure")),
    ("normal_force = 2.0", "normal_force = 2.0\nmean_pressure = 1.0", ("mean_pressure", "not two")),
    ("normal_force = 2.0", "normal_force = 0.0", ("load.normal_force", "positive")),
    (
        "normal_force = 2.0",
        "normal_force = 2.0\nsliding_speed = 0.0",
        ("load.sliding_speed", "positive"),
    ),
    ("normal_force = 2.0", "normal_force = 1e-320", ("load.normal_force", "units")),
    ("[load]\nnormal_force = 2.0", "", ("missing key load", "load = {", "for example")),
    ("[punch]", "[pinch]", ("pinch", "punch")),
    ("times = [0.0, 1.0]", "times = [1.0, 0.0]", ("times", "increase")),
    ("times = [0.0, 1.0]", "times = [-1.0, 0.0]", ("times", "0 or later")),
    ("times = [0.0, 1.0]", 'times = "always"', ("times", "running-in")),
    ("times = [0.0, 1.0]", "times = []\nsteady = false", ("nothing to compute", "times")),
    (
        "times = [0.0, 1.0]",
        'times = [0.0, 1.0]\nmarch = "leapfrog"',
        ("march", "modal, implicit or explicit"),
    ),
    ("times = [0.0, 1.0]", 'times = [0.0, 1.0]\nmarch = "implicit"', ("march", "step")),
    ("times = [0.0, 1.0]", "times = [0.0, 1.0]\nstep = 0.1", ("step", "modal")),
    ("rtol = 1e-3", "rtol = 0", ("accuracy.rtol", "1e-9 to 0.1")),
    ("rtol = 1e-3", "rtol = 1.0", ("accuracy.rtol", "1e-9 to 0.1")),
    (
        "rtol = 1e-3",
        "rtol = 1e-3\n[accuracy.fem]\ndegree = 3\nmesher = 'quads'",
        ("degree", "4 to 16"),
    ),
    (
        "rtol = 1e-3",
        "rtol = 1e-3\n[output]\nradii = [0.5, 2.0]",
        ("output.radii", "punch of radius"),
    ),
    ("rtol = 1e-3", "rtol = 1e-3\n[output]\nradii = []", ("output.radii", "leave it out")),
    ('methods = ["direct"]', "methods = []", ("methods", "mdr")),
    ('methods = ["direct"]', 'methods = ["fdm"]', ("fdm", "mdr")),
    ('methods = ["direct"]', 'methods = ["mdr", "mdr"]', ("mdr", "twice")),
    ('methods = ["direct"]', 'methods = ["mdr-grid"]\n[wear]\ntimes = []', ("not TOML",)),
    ('title = "a punch"', "title = 3", ("title", "line of text")),
    ('title = "a punch"', 'title = "a punch', ("not TOML", "line 1")),
    (GOOD, "", ("missing keys punch, half_space, load", "punch = {")),
    (GOOD, "\x00\x01", ("not TOML",)),
]


@pytest.mark.parametrize(
    ("line", "instead", "told"),
    SCENES,
    ids=lambda value: value[:40] if isinstance(value, str) else "",
)
def test_malformed_scenes(
    line: str,
    instead: str,
    told: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert line in GOOD
    scene, out = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text(GOOD.replace(line, instead), "utf-8")
    refused(["run", str(scene), "--out", str(out)], told, capsys)
    assert not out.exists()


def refused(
    arguments: list[str], told: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 2, one line on standard error that tells all of it, and nothing on standard output."""
    try:
        status = main(arguments)
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    # argparse says how the command is used before what is wrong
    (line,) = [line for line in shown.err.splitlines() if line and not re.match(r"usage:| ", line)]
    for part in told:
        assert part in line, line


# {tmp} is an empty directory with a file, a dangling link and a full device in it
COMMANDS: list[tuple[list[str], tuple[str, ...]]] = [
    (["run", "no_such_scene"], ("no_such_scene", "five_rings")),
    (["run", "{tmp}"], ("directory", "five_rings")),
    (["run", "{tmp}/bytes"], ("not a text file", "UTF-8")),
    (["run", "five_rings", "--out", ""], ("--out", "give a directory")),
    (["run", "five_rings", "--out", " "], ("--out", "give a directory")),
    (["run", "five_rings", "--out", "{tmp}/file"], ("--out", "a file", "give a directory")),
    (["run", "five_rings", "--out", "{tmp}/file/below"], ("--out", "another directory")),
    (
        ["run", "five_rings", "--out", "{tmp}/dangling"],
        ("--out", "leads nowhere", "give a directory"),
    ),
    (["run", "five_rings", "--out", "/dev/null/nothing"], ("--out", "cannot be written to")),
    (["run", "five_rings", "--rtol", "small"], ("--rtol", "small")),
    (["run", "five_rings", "--rtol", "nan"], ("rtol", "1e-9 to 0.1")),
    (["run", "five_rings", "--rtol", "-1e-4"], ("--rtol",)),
    (["run", "five_rings", "--methods", ""], ("methods", "mdr")),
    (["run", "five_rings", "--methods", "mdr,fdm"], ("fdm", "mdr")),
    (["run", "five_rings", "--fast"], ("--fast",)),
    (["walk"], ("walk", "run")),
    ([], ("COMMAND",)),
    (["plan"], ("scene",)),
    (["plan", "nothing"], ("nothing", "five_rings")),
    (["mesh", "five_rings", "--out", "{tmp}/file"], ("--out", "a file")),
    (["compare", "five_rings"], ("B",)),
    (["compare", "{tmp}", "five_rings", "--out", "{tmp}/new"], ("results.nc", "ringwear run")),
    (["study", "everything"], ("everything", "paper")),
    (["study", "paper", "--fig", "3"], ("--fig", "3")),
    (["study", "march", "--out", ""], ("--out", "give a directory")),
    (
        ["study", "refinement", "--mesh", "{tmp}/none.msh", "--out", "{tmp}/new"],
        ("--mesh", "none.msh"),
    ),
    (
        ["study", "refinement", "--mesh", "{tmp}/file", "--out", "{tmp}/new"],
        ("--mesh", "file", "mesh"),
    ),
    (["study", "refinement", "--mesh", "{tmp}", "--out", "{tmp}/new"], ("--mesh", "directory")),
    (["study", "refinement", "--mesh", "", "--out", "{tmp}/new"], ("--mesh",)),
]


@pytest.mark.parametrize(
    ("arguments", "told"),
    COMMANDS,
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_malformed_commands(
    arguments: list[str],
    told: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    there = tmp_path / "there"
    there.mkdir()
    (there / "file").write_text("mine", "utf-8")
    (there / "bytes").write_bytes(b"\xff\xfe\x80")
    (there / "dangling").symlink_to(there / "nowhere")
    monkeypatch.chdir(tmp_path)
    refused([part.replace("{tmp}", str(there)) for part in arguments], told, capsys)
    assert {entry.name for entry in tmp_path.rglob("*")} == {"there", "file", "bytes", "dangling"}
    assert (there / "file").read_text("utf-8") == "mine"


def test_the_scene_they_are_changed_from_is_good() -> None:
    Scene.from_toml(GOOD)
    assert len(SCENES) + len(COMMANDS) >= 60
