"""The READMEs are true: their examples run and give the promised results."""

import re
from pathlib import Path
from textwrap import dedent

import pytest

from ringwear import Scene

ROOT = Path(__file__).parents[2]
FLOORS = ("fem", "mdr", "meshes", "studies")


def test_the_example_of_the_finite_elements(capsys):
    page = (ROOT / "fem" / "README.md").read_text("utf-8")
    exec(dedent(re.search(r"\n(    import numpy.*?)\n\n\[1\]", page, re.DOTALL)[1]), {})
    output = capsys.readouterr().out
    assert float(re.search(r"d0 = (\S+),", output)[1]) == pytest.approx(0.5, rel=1e-5)
    assert "MeshTri" in output
    assert "ElementTriP4" in output


@pytest.mark.parametrize("floor", FLOORS)
def test_names_in_a_readme_exist_in_the_code(floor):
    """Each source in its list is cited."""
    page = (ROOT / floor / "README.md").read_text("utf-8")
    names = re.findall(r"`([A-Za-z_]\w*(?:\.\w+)*)`", page)
    assert len(names) > 10
    files = [file for folder in FLOORS for file in (ROOT / folder).rglob("*.py")]
    code = {word for file in files for word in re.findall(r"\w+", f"{file} {file.read_text()}")}
    # elements of scikit-fem that users may choose
    code |= {"ElementTriP1", "ElementTriP4"}
    assert {word for name in names for word in name.split(".")} <= code
    sources = re.findall(r"(?m)^\[(\d)\]", page)
    assert sources
    assert all(page.count(f"[{number}]") >= 2 for number in sources)


REFERENCE = ROOT / "studies" / "reference.md"


def snippet(start, page=ROOT / "README.md"):
    """Return the indented block of a page that begins with a given text."""
    text = page.read_text("utf-8")
    block = re.search(rf"(?m)^    {re.escape(start)}.*\n(?:    .*\n|\n)*", text)[0]
    return dedent(block)


def test_the_scene_and_the_script_of_the_readme(command):
    """The assertion in the last line of the script holds."""
    Path("punch.toml").write_text(snippet('units = "SI"'), "utf-8")
    command("run punch.toml --no-figures --rtol 1e-3")
    script = snippet("from ringwear import run")
    assert "assert" in script.splitlines()[4]
    exec("\n".join(script.splitlines()[:5]), {})


@pytest.mark.gmsh
def test_the_output_in_the_readme(command):
    output = command("run --no-figures --out out").out
    shown = [line.strip() for line in snippet("Five rings, k2").splitlines() if line.strip()]
    assert len(shown) >= 8
    assert all(line in output for line in shown)


def test_the_keys_in_the_reference():
    """Its scene has only valid keys, and all keys except those that exclude others."""
    text = snippet('title = "Five rings', REFERENCE)
    given = {line.split(" =")[0] for line in text.splitlines() if re.match(r"[a-z_]+ =", line)}
    sections = (Scene, *(field.annotation for field in Scene.model_fields.values()))
    names = {
        field.alias or name
        for section in sections
        if hasattr(section, "model_fields")
        for name, field in section.model_fields.items()
    }
    assert given <= names
    assert given | {"punch", "half_space", "load", "wear", "accuracy", "output"} >= names - {
        *("ring_edges", "wear_coefficient", "wear_ratio", "plane_strain_modulus", "mean_pressure"),
        *(
            "youngs_modulus",
            "indentation",
            "tau",
            "each_cycle",
            "step",
            "fem",
            "mdr",
            "heights",
            "kinks",
        ),
        *("layers", "rigid"),
    }


def test_the_readme_is_short():
    """Tables do not count, because people look up only their own case in them."""
    text = (ROOT / "README.md").read_text("utf-8")
    lines = text.splitlines()
    assert len(lines) <= 120
    assert len(" ".join(line for line in lines if not line.startswith("|")).split()) <= 900


def test_the_reference_names_every_command_and_flag(command):
    text = REFERENCE.read_text("utf-8")
    listed = command("--help").out.partition("COMMAND\n")[2].partition("\n\n")[0]
    commands = re.findall(r"^    ([a-z]+)", listed, re.MULTILINE)
    assert {"run", "check", "challenge"} < set(commands)
    assert "--version" in text
    for name in commands:
        assert f"ringwear {name}" in text
        for flag in set(re.findall(r"--[a-z-]+", command(f"{name} --help").out)) - {"--help"}:
            assert flag in text, (name, flag)
