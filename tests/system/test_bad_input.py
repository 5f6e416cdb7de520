"""Bad input of many kinds is refused with status 2, by a line that states what to write."""

import os
import re

import pytest

from ringwear import Scene, SceneError

SCENE = """[punch]
radius = 1.0
rings = 2
wear_coefficients = [1.0, 10.0]
[half_space]
plane_strain_modulus = 1.0
[load]
normal_force = 2.0
[wear]
times = [0.0, 1.0]
"""
# part of the scene, its replacement, and words of the line that states what to write
SCENES = [
    ("radius = 1.0", "radius = inf", "punch.radius: inf is beyond"),
    ("radius = 1.0", 'radius = "1.0"', "leave out the quotes, or add a unit"),
    ("radius = 1.0", f"radius = 1{400 * '0'}", "give the punch radius, a positive length"),
    ("radius = 1.0", 'radius = "10 mmm"', "did you mean 'mm'?"),
    ("radius = 1.0", 'radius = "10 N"', "is no length"),
    ("radius = 1.0", 'radius = "10 mm 5"', "has two numbers: give one number and its unit"),
    ("[wear]", "[output]\nradii = []\n[wear]", "output.radii = []: should have at least 1 item"),
    ("radius = 1.0", 'radius = "1,5 mm"', "give '1.5 mm'"),
    ("radius = 1.0", "radius = 1,0", "'radius = 1,0'; give lines such as radius = 1.0"),
    ("radius = 1.0", "radius = 1.0\nradius = 2.0", "each key once"),
    ("radius = 1.0", "radius = 1.0\ninner_radius = 2.0", "inner_radius = 2 must be below 1"),
    ("radius = 1.0", 'radius = 1.0\nprofile = { kind = "Cone" }', "did you mean 'cone'?"),
    ("radius = 1.0", "radius = 1.0\nprofile = { slope = 0.1 }", "profile.kind: is missing"),
    (
        "radius = 1.0",
        'radius = 1\nprofile = { kind = "table", file = "no" }',
        "a file of text",
    ),
    ("rings = 2", "ring = 2", "unknown key punch.ring: did you mean rings?"),
    ("rings = 2", "ring_edges = [0.5, 0.2, 1.0]", "must increase"),
    ("[1.0, 10.0]", "[1.0, -1.0]", "wear_coefficients.1: -1.0 must be positive"),
    ("[1.0, 10.0]", "[1.0, 2.0, 3.0]", "give 2, or two, which alternate"),
    ("[1.0, 10.0]", "1.0", "give positive numbers: two"),
    ("normal_force = 2.0", "normal_force = 2.0\nmean_pressure = 1.0", "give one of normal_force"),
    ("normal_force = 2.0", "normal_force = { time = [0], values = [1] }", "did you mean times?"),
    ("[load]\nnormal_force = 2.0", "", "missing key load"),
    ("times = [0.0, 1.0]", "times = [0.0, 1e60]", "1e+60 is beyond 1e-40 to 1e+40"),
    ("times = [0.0, 1.0]", "times = [0.0, nan]", "must be 0 or positive"),
    ("times = [0.0, 1.0]", "times = [1.0, 0.5]", "must increase"),
    ("times = [0.0, 1.0]", 'times = "running_in"', "did you mean 'running-in'?"),
    ("times = [0.0, 1.0]", 'times = [0.0]\nsteady = "yes"', "give true or false"),
    ("[wear]", '[output]\nquantities = ["presure"]\n[wear]', "did you mean 'pressure'?"),
    ("[punch]", 'methods = ["FEM"]\n[punch]', "did you mean 'fem'?"),
    ("[punch]", 'methods = "fem"\n[punch]', "give a list of mdr"),
    ("[punch]", 'units = "mm, N, MPA, s"\n[punch]', "did you mean 'MPa'?"),
    ("[punch]", 'units = "mm, N, GPa, s"\n[punch]', "N/mm^2 is 0.001 GPa"),
    ("[punch]", "title = Five rings\n[punch]", "texts in quotes"),
    ("[punch]", "[[punch]]", "should be a table"),
    ("modulus = 1.0", "modulus = 1.0\npunch_poisson_ratio = 0.3", "give both or neither"),
    ("radius = 1.0", "radius = '1,000 mm'", "leave out separators of thousands: '1000 mm'"),
    ("radius = 1.0", "radius = '10 MM'", "did you mean 'mm'?"),
    ("rings = 2", "profile = 1.0", "should be a table with a kind"),
    ("times = [0.0, 1.0]", "each_cycle = true", "give times = 'each cycle'"),
    (
        "rings = 2",
        'profile = { kind = "table", file = "a.csv", radii = [0.0] }',
        "give either file, or radii and heights, but not both",
    ),
    (
        "rings = 2",
        'profile = { kind = "table", file = "a.csv", level = 1 }',
        "punch.profile.level = 1: give true or false",
    ),
    (SCENE, "", "missing keys punch, half_space, load"),
    ("radius = 1.0", "radius = -1.0\nring = 3", "also wrong: punch.radius"),
    ("times = [0.0, 1.0]", "times = { tau = [] }", "give counts, or times = []"),
    ("times = [0.0, 1.0]", "times = [0.0]\n[wear]", "Cannot declare [wear] twice"),
    (
        "normal_force = 2.0",
        "normal_force = { times = [0.0, 1.0], values = [0.0, 0.0] }",
        "must be positive at some: give a value above 0",
    ),
    (
        "wear_coefficients = [1.0, 10.0]",
        "wear_coefficient = { radius = [0.0], values = [1.0] }",
        "did you mean radii?",
    ),
    ("rings = 2", 'profile = { kind = "ball", radius = 5.0 }', "did you mean ball_radius?"),
    ("rings = 2", 'profile = { kind = "ball" }', "missing key punch.profile.ball_radius; give the"),
    ("[punch]", "methods = []\n[punch]", "should have at least 1 item, not 0; give a list of mdr"),
    (
        "normal_force = 2.0",
        'normal_force = 2.0\nsliding_speed = "60 rpm"',
        "load.sliding_speed = '60 rpm' is a rotation, not a speed: give omega times radius",
    ),
    ("force = 2.0", 'force = 2.0\nsliding_speed = "5 N"', "give a number with a unit of speed"),
    (
        "force = 2.0",
        "force = 2.0\nsliding_speed = -0.1",
        "load.sliding_speed: -0.1 is negative, but wear does not depend on the direction of "
        "sliding: give its absolute value",
    ),
    (
        "force = 2.0",
        "force = 2.0\nsliding_speed = { times = [0.0, 1.0], values = [-1.0, 1.0] }",
        "give its absolute value, and a time of speed 0 where the direction changes",
    ),
    ("times = [0.0, 1.0]", 'times = ["0 m", "2 N"]', "'2 N' is no distance"),
    ("radius = 1.0", f"radius = {5000 * '9'}", "a number has thousands of digits; give numbers"),
    ("radius = 1.0", f"radius = 0x{5000 * '9'}", "give the punch radius, a positive length"),
    ("[punch]", f"title = 0x{5000 * '9'}\n[punch]", "give a text, in quotes"),
    ("[1.0, 10.0]", f"{5000 * '['}1.0{5000 * ']'}", "nested too deeply; give those that"),
    ("radius = 1.0", f"radius{5000 * '.a'} = 1.0", "nested too deeply; give those that"),
]


def refused(shown):
    """Return the line on standard error of a refused command, which prints nothing else."""
    assert shown.out == ""
    (line,) = [line for line in shown.err.splitlines() if line and not re.match(r"usage:| ", line)]
    return line


@pytest.mark.parametrize(("part", "instead", "words"), SCENES)
def test_a_bad_scene_is_refused(part, instead, words, command, tmp_path):
    assert part in SCENE
    (tmp_path / "mine.toml").write_text(SCENE.replace(part, instead), "utf-8")
    line = refused(command("run mine.toml", 2))
    assert line.startswith("ringwear: mine.toml")
    assert words in line
    assert len(line) < 700
    assert [file.name for file in tmp_path.iterdir()] == ["mine.toml"]


COMMANDS = [
    ("runn five_rings", "did you mean run?"),
    ("five_rings", "did you mean ringwear run five_rings?"),
    ("run five_rings --nofigures", "did you mean --no-figures?"),
    ("run five_rings --rtol 1e-3x", "give a number, such as 1e-4"),
    ("run ''", "give a scene file"),
    ("run there", "is a directory; give a scene file"),
    ("run running_in", "running_in: it is a bundled sweep; did you mean"),
    ("run bytes", "a scene is TOML in UTF-8"),
    ("check five_rings none.csv --within -1", "give a positive number"),
    ("sweep nofile", "nofile: no such file or directory; give a sweep file"),
    ("sweep five_rings", "it is a bundled scene; give a sweep file"),
    ("scenes five_rings rubber", "leave it out: --help lists what the command takes"),
    ("study march --steps 0", "--steps 0: give steps above 0, up to 2"),
    ("study refinement --degree 3", "give --mesh FILE"),
    ("compare five_rings there", "it has no summary.json; give a folder"),
    ("challenge 03 04 05", "challenge takes a problem and one file"),
    ("study refinement --mesh bytes --units furlongs:2", "--units"),
    ("study convergence --element mine.py", "--element mine.py"),
    ("check five_rings bytes", "it is not text in UTF-8; give CSV"),
    ("check five_rings a.csv a.csv", "a.csv is given twice: give each file once"),
    ("run /dev/null", "missing keys punch, half_space, load"),
    ("run five_rings --out ''", "give a directory"),
    ("run five_rings --out bytes", "bytes is not a directory"),
    ("run five_rings --out dangling", "directory"),
    ("run five_rings --out /dev/null/nothing", "written"),
    ("run five_rings --methods mdr,fdm", "'fdm'"),
    ("run five_rings --memory 0.1", "punch.rings"),
    ("", "COMMAND"),
    ("study refinement --mesh none.msh --out new", "--mesh none.msh: no such file"),
]


@pytest.mark.parametrize(("call", "words"), COMMANDS)
def test_a_bad_command_is_refused(call, words, command, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x80\x00")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    line = refused(command(call, 2))
    assert words in line
    # the line has no path of the installation
    assert "studies/" not in line
    assert {file.name for file in tmp_path.rglob("*")} == {"there", "bytes", "dangling"}


FOLDERS = [
    "run flat_punch --out {}",
    "study truncation --quick --out {}",
    "sweep running_in --out {}",
    "run {}.toml",
]


@pytest.mark.parametrize("call", FOLDERS)
def test_a_folder_whose_name_is_not_utf_8_is_refused(call, command, tmp_path):
    """Python has such bytes in texts as halves of surrogate pairs."""
    name = os.fsdecode(b"out\xff")
    (tmp_path / f"{name}.toml").write_text(SCENE, "utf-8")
    before = set(tmp_path.iterdir())
    line = refused(command(call.format(name), 2))
    assert "the name is not UTF-8; give another directory" in line
    assert r"out\udcff" in line
    assert set(tmp_path.iterdir()) == before


def test_values_of_python_that_cannot_be_written_are_refused():
    deep = 1.0
    for _ in range(5000):
        deep = {"a": deep}
    for radius in (10**5000, deep, [10**5000]):
        with pytest.raises(SceneError, match=r"punch.radius = a|nested too deeply"):
            Scene.load("flat_punch").changed({"punch.radius": radius})
    with pytest.raises(SceneError, match="nested too deeply"):
        Scene.load("flat_punch").changed({f"punch{5000 * '.a'}": 1.0})


@pytest.mark.parametrize("width", [60, 80, 100])
def test_no_line_of_the_answer_is_cut(width, command, monkeypatch):
    """A terminal shows every word that is printed without a terminal, in lines that fit."""
    line = "run rubber --methods direct --no-figures --out out"
    whole = command(line).out
    monkeypatch.setenv("COLUMNS", str(width))
    output = command(line).out
    assert output.split() == whole.split()
    assert "..." not in output
    # only a word without blanks, such as a path, may be longer
    assert not [line for line in output.splitlines() if len(line) > width and " " in line.strip()]
    for line in ("--help", "scenes --help"):
        assert max(map(len, command(line).out.splitlines())) <= max(width, 80)
